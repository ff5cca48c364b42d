"""Tractions that a plane wave exerts on the bonded line between two different half-planes.

The wave is partly reflected as P and S waves and partly transmitted as P and S waves of the other
body, all with its slowness p along the line.  Their four amplitudes make velocity and traction
continuous on y = 0.  A wave whose p exceeds its own 1/c decays away from the line; its slowness
across is i sqrt(p^2 - 1/c^2), for factors exp(i w (p x + s_y |y| - t)) with w > 0, and amplitudes
are complex: a history f(t - p x) arrives as Re(T) f + Im(T) H f, with the Hilbert transform H.
"""

from __future__ import annotations

import cmath

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.material import Material

Complex = NDArray[np.complex128]


def bonded_tractions(
    wave: IncidentWave, upper: Material, lower: Material
) -> tuple[complex, complex]:
    """Return pressure and shear per unit of the history of a P or SV wave [stress].

    They are real unless one of the four waves decays away from the line.

    Parameters
    ----------
    wave : IncidentWave
        A P or an SV wave from either body.
    upper, lower : Material
        The solids on y > 0 and y < 0.

    Examples
    --------
    >>> from semianalytic import IncidentWave, Material
    >>> hard, soft = Material(4.0, 1.0, 0.25), Material(1.0, 1.0, 0.25)
    >>> wave = IncidentWave("SV", angle=0.0, stress=1.0)  # from below: 2 Z / (Z + Z_below)
    >>> pressure, shear = bonded_tractions(wave, hard, soft)
    >>> round(shear.real, 12), shear.imag
    (-1.333333333333, 0.0)
    """
    source = lower if wave.from_ == "below" else upper
    (across, along), motion = wave.direction(), wave.polarisation()
    p = across / wave.speed(source)
    speed = wave.particle_velocity(source)
    incoming = speed * _state(source, (p, along / wave.speed(source)), motion[:2])
    columns = []
    for body, side in ((upper, 1), (lower, -1)):
        for c in (body.longitudinal_speed, body.shear_speed):
            # Away from the line in either body; beyond 1 / c the root is i times a positive number,
            # which decays.
            q = side * cmath.sqrt(1 / c**2 - p**2)
            # A P wave moves along its slowness vector, an SV wave across it.
            moved = (p, q) if c == body.longitudinal_speed else (q, -p)
            columns.append(side * _state(body, (p, q), (c * moved[0], c * moved[1])))
    # the upper state less the lower one vanishes, the incident wave being a part of its body
    known = incoming if wave.from_ == "above" else -incoming
    amplitudes = np.linalg.solve(np.stack(columns, axis=1), -known)
    total = amplitudes[0] * columns[0] + amplitudes[1] * columns[1]
    total = total + (incoming if wave.from_ == "above" else 0.0)
    return complex(-total[3]), complex(total[2])


def _state(
    body: Material, slowness: tuple[complex, complex], motion: tuple[complex, complex]
) -> Complex:
    """Return velocity x, y and stress xy, yy on y = 0 of a wave, (4,).

    The velocity is v d exp(i w (s.r - t)) with unit v, hence stress -lambda (s.d) - mu (s d + d s).
    """
    (s_x, s_y), (d_x, d_y), mu = slowness, motion, body.shear_modulus
    spread = body.density * body.longitudinal_speed**2 - 2 * mu
    shear, along = -mu * (s_x * d_y + s_y * d_x), s_x * d_x + s_y * d_y
    return np.array([d_x, d_y, shear, -spread * along - 2 * mu * s_y * d_y], dtype=complex)
