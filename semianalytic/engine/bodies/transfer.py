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

from typing import Any

import numpy as np

from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.scene import Material

Drive = tuple[Any, Any]
"""Phi and Psi that a unit rate makes, complex arrays."""


def decays(body: Material, q: Array, s: Complex) -> tuple[Complex, Complex]:
    """Return A and B at wavenumbers and frequencies that broadcast [1 / length]."""
    square = np.square(s)
    return decay(body.longitudinal_speed, q, square), decay(body.shear_speed, q, square)


def decay(speed: float, q: Array, square: Complex) -> Complex:
    """Return A or B, that of the speed, from the square of the frequencies."""
    # Re s > 0 keeps the radicands off the branch cut of the principal root.
    return np.asarray(np.sqrt(q * q + square / speed**2))


def potentials(
    bodies: tuple[Material, ...], lower: bool, q: Array, s: Complex, opening: bool
) -> Drive:
    """Return Phi and Psi in a body for a unit rate, that of slip or that of opening.

    Parameters
    ----------
    bodies : one or two Material
        The upper body, and the lower one if it is another.
    lower : bool
        Whether potentials are those of the lower body.
    q : array
        Wavenumbers [1 / length].
    s : complex array
        Frequencies, Re s > 0 [1 / time].
    opening : bool
        Whether the faces open.
    """
    if len(bodies) == 2:
        return _of_two(bodies, lower, q, s, opening)
    speed = bodies[0].longitudinal_speed if opening else bodies[0].shear_speed
    squared, sign = np.square(bodies[0].shear_speed / s), -1.0 if lower else 1.0
    once = 1j * q * squared
    twice = (0.5 + q * q * squared) / decay(speed, q, np.square(s))
    return (-twice, once) if opening else (sign * once, sign * twice)


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
    bodies: tuple[Material, ...], lower: bool, q: Array, s: Complex, opening: bool
) -> Drive:
    """Return the potentials between different bodies, of which both carry one traction."""
    roots = [decays(body, q, s) for body in bodies]
    (d_up, up11, up12, up22), (d_low, low11, low12, low22) = (
        _impedance(body, *root, q, s) for body, root in zip(bodies, roots, strict=True)
    )
    # Z w = Y (w - r) with the rates r: w = -(Z - Y)^-1 Y r; Y = [[-Z11, Z12], [-Z12, -Z22]] below
    m11, m12, m22 = up11 + low11, up12 - low12, up22 + low22
    det = m11 * m22 + m12 * m12
    first, second = (low12, -low22) if opening else (-low11, -low12)  # column of Y
    a, b = roots[lower]
    along = -(m22 * first - m12 * second) / det
    across = -(m12 * first + m11 * second) / det
    if lower:
        along, across = along - (not opening), opening - across
    d = d_low if lower else d_up
    return (1j * q * along - b * across) / d, (a * along + 1j * q * across) / d
