"""Tractions that a plane wave exerts on the bonded line between two different half-planes.

The wave is partly reflected as P and S waves and partly transmitted as P and S waves of the other
body, all with its slowness p along the line.  Their four amplitudes make velocity and traction
continuous on y = 0.  A wave whose p exceeds its own 1/c decays away from the line; its slowness
across is i sqrt(p^2 - 1/c^2), for factors exp(i w (p x + s_y |y| - t)) with w > 0, and amplitudes
are complex: a history f(t - p x) arrives as Re(T) f + Im(T) H f, with the Hilbert transform H.
"""

from __future__ import annotations

import cmath
from typing import NamedTuple

import numpy as np

from semianalytic.scene.arrays import Complex
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.material import Material


class BondedWave(NamedTuple):
    """A plane wave beside the line, with the factor exp(i w (slowness . r - t))."""

    is_above: bool  # whether it is in the upper body
    slowness: tuple[complex, complex]  # slowness along x and y [time / length]
    # particle velocity along x and y per unit of the history [length / time]
    motion: tuple[complex, complex]


def bonded_waves(wave: IncidentWave, upper: Material, lower: Material) -> list[BondedWave]:
    """Return a P or SV wave from either body, and the P and SV waves that the bonded line sends.

    The solids are those on y > 0 and y < 0.
    """
    from_above = wave.from_ == "above"
    source = upper if from_above else lower
    (across, along), speed = wave.direction(), wave.speed(source)
    p, moved = across / speed, wave.particle_velocity(source)
    motion = (moved * wave.polarisation()[0], moved * wave.polarisation()[1])
    incoming = BondedWave(from_above, (p, along / speed), motion)
    sent = []
    for body, side in ((upper, 1), (lower, -1)):
        for c in (body.longitudinal_speed, body.shear_speed):
            # Away from the line in either body; beyond 1 / c the root is i times a positive number,
            # which decays.
            q = side * cmath.sqrt(1 / c**2 - p**2)
            # A P wave moves along its slowness vector, an SV wave across it.
            part = (p, q) if c == body.longitudinal_speed else (q, -p)
            sent.append(BondedWave(side > 0, (p, q), (c * part[0], c * part[1])))
    # the upper state less the lower one vanishes, the incident wave being a part of its body
    columns = [_state(upper if wave.is_above else lower, wave) for wave in sent]
    pairs = zip(columns, sent, strict=True)
    matrix = np.stack([c if wave.is_above else -c for c, wave in pairs], 1)
    known = _state(source, incoming) * (1 if from_above else -1)
    amplitudes = np.linalg.solve(matrix, -known).tolist()
    return [incoming] + [
        wave._replace(motion=(size * wave.motion[0], size * wave.motion[1]))
        for size, wave in zip(amplitudes, sent, strict=True)
    ]


def bonded_tractions(
    wave: IncidentWave, upper: Material, lower: Material
) -> tuple[complex, complex]:
    """Return pressure and shear per unit of the history of a P or SV wave [stress].

    They are real unless one of the four waves decays away from the line.

    Examples
    --------
    >>> from semianalytic import IncidentWave, Material
    >>> hard, soft = Material(4.0, 1.0, 0.25), Material(1.0, 1.0, 0.25)
    >>> wave = IncidentWave("SV", angle=0.0, stress=1.0)  # from below: 2 Z / (Z + Z_below)
    >>> pressure, shear = bonded_tractions(wave, hard, soft)
    >>> round(shear.real, 12), shear.imag
    (-1.333333333333, 0.0)
    """
    waves = bonded_waves(wave, upper, lower)
    total = np.sum([_state(upper, wave) for wave in waves if wave.is_above], axis=0)
    return complex(-total[3]), complex(total[2])


def stresses(body: Material, wave: BondedWave) -> Complex:
    """Return stress xx, yy, xy of a wave, -lambda (s.d) - mu (s d + d s), (3,)."""
    (s_x, s_y), (d_x, d_y), mu = wave.slowness, wave.motion, body.shear_modulus
    spread = (body.density * body.longitudinal_speed**2 - 2 * mu) * (s_x * d_x + s_y * d_y)
    shear = -mu * (s_x * d_y + s_y * d_x)
    return np.array([-spread - 2 * mu * s_x * d_x, -spread - 2 * mu * s_y * d_y, shear], complex)


def _state(body: Material, wave: BondedWave) -> Complex:
    """Return velocity x, y and stress xy, yy on y = 0 of a wave, (4,)."""
    _, across, shear = stresses(body, wave)
    return np.array([*wave.motion, shear, across])
