"""Waves in two half-planes whose faces part at given rates, at wavenumbers q and frequencies s.

Waves go like exp(s t + i q x), and fall off in the upper body like exp(-A y) and exp(-B y),

    A^2 = q^2 + s^2 / c_l^2,  B^2 = q^2 + s^2 / c_t^2,  Re A, Re B > 0.

With the potentials Phi of the P wave and Psi of the S wave, P = Phi exp(-A y), S = Psi exp(-B y):

    v_x = i q P + B S,  v_y = -A P + i q S,  s e_xx = i q v_x,
    s (e_xx + e_yy) = (s / c_l)^2 P,  s gamma_xy = 2 i q v_y - (s / c_t)^2 S.

The lower body is computed as if it lay above, from face velocities (w_x, -w_y); there v_y and
gamma_xy change sign.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.scene import Material

Pair = tuple[Complex, Complex]

FALLEN = 35.0
"""Waves that have fallen by more than exp of this do not count."""


def decays(body: Material, q: Array, s: Complex) -> Pair:
    """Return A and B at wavenumbers and frequencies that broadcast [1 / length]."""
    square = np.square(s)
    return decay(body.longitudinal_speed, q, square), decay(body.shear_speed, q, square)


def decay(speed: float, q: Array, square: Complex) -> Complex:
    """Return A or B, that of the speed, from the square of the frequencies."""
    # Re s > 0 keeps the radicands off the branch cut of the principal root.
    return np.asarray(np.sqrt(q * q + square / speed**2))


def driven(
    bodies: tuple[Material, ...],
    lower: bool,
    q: Array,
    s: Complex,
    names: Iterable[str],
    roots: Pair,
) -> dict[tuple[str, str], Any]:
    """Return the waves Phi as "P" and Psi as "S", v_z as "Z", of unit rates at the face of a body.

    Parameters
    ----------
    bodies : one or two Material
        The upper body, and the lower one if it is another.
    lower : bool
        Whether waves are those of the lower body.
    q : array
        Wavenumbers [1 / length].
    s : complex array
        Frequencies, Re s > 0 [1 / time].
    names : iterable of {"x", "y", "z"}
        Rates of slip, "x" or "z", and of opening, "y".
    roots : (A, B) of the body

    Returns
    -------
    dict
        Complex arrays by rate and wave.
    """
    found: dict[tuple[str, str], Any] = {}
    if "z" in names:
        found["z", "Z"] = -0.5 if lower else 0.5
    # antiplane slip comes with waves in the plane where a load of pressure opens the slot
    plane = [name for name in names if name != "z"]
    if len(bodies) == 2:
        pairs: Mapping[str, Any] = _of_two(bodies, lower, q, s, plane, roots)
    else:
        squared, sign = np.square(bodies[0].shear_speed / s), -1.0 if lower else 1.0
        once, twice = 1j * q * squared, 0.5 + q * q * squared
        alike = {"x": (sign * once, sign * twice / roots[1]), "y": (-twice / roots[0], once)}
        pairs = {name: alike[name] for name in plane}
    for name, pair in pairs.items():
        found |= {(name, wave): drive for wave, drive in zip("PS", pair, strict=True)}
    return found


def _impedance(body: Material, a: Complex, b: Complex, q: Array, s: Complex) -> list[Complex]:
    """Return D = A B - q^2 and Z11, Z12, Z22 of sigma_xy = Z11 w_x + Z12 w_y on the upper body.

    sigma_yy = -Z12 w_x + Z22 w_y.
    """
    c_l, c_t, mu = body.longitudinal_speed, body.shear_speed, body.shear_modulus
    # D without the cancellation of A B and q^2
    square = q * q * (1 / c_l**2 + 1 / c_t**2) + np.square(s / (c_l * c_t))
    d = s * s * square / (a * b + q * q)
    across = -1j * mu * q * (b * b + q * q - 2 * a * b) / (s * d)
    own = -mu * s / c_t**2 / d
    return [d, own * a, across, own * b]


def _of_two(
    bodies: tuple[Material, ...],
    lower: bool,
    q: Array,
    s: Complex,
    names: Iterable[str],
    roots: Pair,
) -> dict[str, Pair]:
    """Return Phi and Psi between different bodies, of which both carry one traction."""
    other = decays(bodies[not lower], q, s)
    pairs = (other, roots) if lower else (roots, other)
    (d_up, up11, up12, up22), (d_low, low11, low12, low22) = (
        _impedance(body, *pair, q, s) for body, pair in zip(bodies, pairs, strict=True)
    )
    # Z w = Y (w - r) with the rates r: w = -(Z - Y)^-1 Y r; Y = [[-Z11, Z12], [-Z12, -Z22]] below
    m11, m12, m22 = up11 + low11, up12 - low12, up22 + low22
    (a, b), d = roots, d_low if lower else d_up
    scale, found = -1 / (m11 * m22 + m12 * m12), dict[str, Pair]()
    for name in names:
        opening = name == "y"
        first, second = (low12, -low22) if opening else (-low11, -low12)  # column of Y
        along = scale * (m22 * first - m12 * second)
        across = scale * (m12 * first + m11 * second)
        if lower:
            along, across = along - (not opening), opening - across
        phi, psi = 1j * q * along - b * across, a * along + 1j * q * across
        found[name] = np.asarray(phi / d), np.asarray(psi / d)
    return found


def laid_down(depths: Array, decay: Complex, sent: Complex) -> Array:
    """Return real parts of sums over frequencies, at depths (d,), of waves (k, m) that fall off.

    They are (d, k).  For many evenly spaced depths some exponentials are powers of one, and waves
    fall from one group of depths to the next.
    """
    sent = sent.conj()  # of which products of real numbers take the real part of complex ones
    count, step = math.isqrt(len(depths) * len(sent)), depths[-1] - depths[0]
    even = depths[0] + step * np.linspace(0.0, 1.0, len(depths))
    if len(depths) < 16 or np.abs(depths - even).max() > 1e-8 * step:
        falling = np.exp(-np.multiply.outer(depths, decay))
        return np.asarray(falling.view(float) @ sent.view(float).T)
    count = min(count, len(depths))
    powers, once = np.empty((count, len(decay)), complex), np.exp(-step / (len(depths) - 1) * decay)
    powers[0] = 1.0
    for before, after in pairwise(powers):
        np.multiply(before, once, out=after)
    found = np.empty((len(depths), len(sent)))
    sent, leap = sent * np.exp(-depths[0] * decay.conj()), (once * powers[-1]).conj()
    for start in range(0, len(depths), count):
        # evanescent waves, of low frequencies, do not reach the deeper groups
        here = slice(int(np.searchsorted(-depths[start] * decay.real, -FALLEN)), None)
        part = found[start : start + count]
        part[:] = powers[: len(part), here].view(float) @ sent[:, here].view(float).T
        sent[:, here] *= leap[here]
    return found
