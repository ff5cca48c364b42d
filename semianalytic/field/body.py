"""Velocity, stress and displacement in the upper body, from the integrals of `cells`, b = mu = 1.

A wave of slowness s is at (x, y) from t > s r on with

    k_s = (-x t + i y (t^2 - s^2 r^2)^1/2) / r^2,

and real before, k_s = (-x t + sgn(x) y (s^2 r^2 - t^2)^1/2) / r^2 + i 0, where for t > s y head
waves and plane waves have come.  Written without cancellation at these it is
-sgn(x) (t^2 - s^2 y^2) / (|x| t + y (s^2 r^2 - t^2)^1/2).  The rows of fields are v_x, v_y,
sigma_xx, sigma_yy, sigma_xy, u_x, u_y; in antiplane shear v_z, sigma_xz, sigma_yz, u_z.
"""

from __future__ import annotations

import numpy as np

from semianalytic.field import tuning
from semianalytic.field.cells import Primitives
from semianalytic.field.waves import P_WAVE, S_WAVE, SHEAR, SUMS, Complex
from semianalytic.halfplane.rayleigh import Array


def slowness(x: Array, y: Array, t: Array, s: float) -> Complex:
    """Return the slowness k_s at points (m,), y >= 0, r > 0, for a wave of slowness s."""
    square = np.square(x) + np.square(y)
    r = np.sqrt(square)
    rest = (t - s * r) * (t + s * r)
    root, inside = np.sqrt(np.abs(rest)), rest >= 0
    across = np.where(inside, 1.0, np.abs(x) * t + y * root)
    before = -np.sign(x) * (t - s * y) * (t + s * y) / across
    real = np.where(inside, -x * t / square, before)
    return real + 1j * np.where(inside, y * root / square, 0.0)


def is_singular(primitives: Primitives, x: Array, y: Array, t: Array) -> np.ndarray:
    """Return (m,) whether points are the contact edge, or lie on a wave that is singular there."""
    edge = (x == 0) & (y == 0)
    away = np.where(edge, t, x)
    at_front = [
        (t >= s * y) & primitives.at_centre(slowness(away, y, t, s)) for s in primitives.slownesses
    ]
    return edge | np.logical_or.reduce(at_front)


def upper(primitives: Primitives, x: Array, y: Array, t: Array, close: float) -> Array:
    """Return the fields (7, m) or (4, m) at points (m,) of the upper body, y >= 0, t > 0.

    Where they are singular, fields at the distance `close` from the singularity are returned, at
    the contact edge ahead of it.
    """
    x = np.where((x == 0) & (y == 0), close * t, x)
    if len(primitives.slownesses) == 1:
        return _antiplane(primitives, x, y, t, close)
    near = t > tuning.NEAR_EDGE * np.hypot(x, y)
    result = np.zeros((7, len(x)))
    a = primitives.slownesses[0]
    for s in primitives.slownesses:
        here = np.flatnonzero((t > s * y) & ~near)
        at = x[here], y[here], t[here]
        values = primitives(slowness(*at, s), close)
        result[:, here] += _of_p(values, *at, a) if s == a else _of_s(values, *at)
    here = np.flatnonzero(near)
    result[:, here] = _beside_edge(primitives, x[here], y[here], t[here], close)
    return result / np.pi


def _antiplane(primitives: Primitives, x: Array, y: Array, t: Array, close: float) -> Array:
    result = np.zeros((4, len(x)))
    here = np.flatnonzero(t > y)
    x, y, t = x[here], y[here], t[here]
    one, k, beta = primitives(slowness(x, y, t, 1.0), close).imag
    result[:, here] = one, k, beta, t * one + x * k + y * beta
    return result / np.pi


def _of_p(parts: Complex, x: Array, y: Array, t: Array, a: float) -> Array:
    """Return pi times the contribution of the P wave."""
    one, k, over_k, alpha, alpha_over_k = parts[P_WAVE].imag
    return np.stack(
        [
            one,
            -alpha_over_k,
            (1 - 2 * a * a) * over_k + 2 * k,
            over_k - 2 * k,
            -2 * alpha,
            t * one + x * k - y * alpha,
            y * (a * a * over_k - k) - t * alpha_over_k - x * alpha,
        ]
    )


def _of_s(parts: Complex, x: Array, y: Array, t: Array) -> Array:
    """Return pi times the contribution of the S wave."""
    one, k, k_over, over, square_over = parts[S_WAVE].imag
    return np.stack(
        [
            one,
            k_over,
            2 * k,
            -2 * k,
            2 * square_over - over,
            t * one + x * k - y * (over - square_over),
            t * k_over + x * square_over - y * k,
        ]
    )


def _beside_edge(primitives: Primitives, x: Array, y: Array, t: Array, close: float) -> Array:
    """Return pi times all fields where both waves nearly cancel, beside the edge.

    The densities of both are added before they are integrated up to k_P; the S wave is then
    integrated on to k_S.
    """
    k_p, a = slowness(x, y, t, primitives.slownesses[0]), primitives.slownesses[0]
    *fields, k_x, k_y, y_x, y_y = primitives(k_p, close)[SUMS].imag
    v_x, v_y, *_ = fields
    moved = [t * v_x + x * k_x - y * y_x, t * v_y + x * k_y - y * y_y]
    result = np.stack([*fields, *moved])
    square = np.square(x) + np.square(y)
    roots = np.sqrt(np.square(t) - square) + np.sqrt(np.square(t) - a * a * square)
    step = 1j * y * (a * a - 1) / roots
    nodes, weights = np.polynomial.legendre.leggauss(tuning.NEAR_EDGE_NODES)
    for share, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
        k = k_p + share * step
        beta = -1j * np.sqrt(k - 1) * np.sqrt(k + 1)
        sent = primitives(k, close)[SHEAR] * weight * step
        lifted, phase = k / beta * sent, t + k * x - beta * y
        parts = (sent, lifted, 2 * k * sent, -2 * k * sent, (2 * k * k - 1) / beta * sent)
        result += np.stack([*parts, phase * sent, phase * lifted]).imag
    return result
