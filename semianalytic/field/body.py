"""Velocity, stress and displacement in the upper body, from the integrals of `cells`, b = mu = 1.

A wave of slowness s is at (x, y) from t > s r on with

    k_s = (-x t + i y (t^2 - s^2 r^2)^1/2) / r^2,

and real before, k_s = (-x t + sgn(x) y (s^2 r^2 - t^2)^1/2) / r^2 + i 0, where for t > s y head
waves and plane waves have come.  Written without cancellation at these it is
-sgn(x) (t^2 - s^2 y^2) / (|x| t + y (s^2 r^2 - t^2)^1/2).  The rows of fields are v_x, v_y,
sigma_xx, sigma_yy, sigma_xy, u_x, u_y; in antiplane shear v_z, sigma_xz, sigma_yz, u_z.

If the front of the load comes along the slot with slowness p > 0, plane waves come from
t > p x + y (s^2 - p^2)^1/2 on, and the real k_s is the one on the side of k = -p.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, NamedTuple

import numpy as np

from semianalytic.field import tuning
from semianalytic.field.cells import Primitives
from semianalytic.field.waves import P_WAVE, S_WAVE, SHEAR, SUMS, Complex
from semianalytic.halfplane.rayleigh import Array

Quantity = Literal["velocity", "stress", "displacement"]
PLANE: Mapping[Quantity, slice] = {
    "velocity": slice(0, 2),
    "stress": slice(2, 5),
    "displacement": slice(5, 7),
}
"""Rows of each quantity in the plane."""
ALONG: Mapping[Quantity, slice] = {
    "velocity": slice(0, 1),
    "stress": slice(1, 3),
    "displacement": slice(3, 4),
}
"""Its rows in antiplane shear."""


class Wave(NamedTuple):
    """A wave, and how its fields follow from the integrals of its densities.

    Attributes
    ----------
    slowness : float
    parts : (p, f) array
        Which densities are its own.
    fields : (q, p) array
        Takes their integrals to pi times velocities and stresses.
    moved : function
        Takes their integrals (p, m) and x, y, t (m,) to pi times displacements.
    """

    slowness: float
    parts: Array
    fields: Array
    moved: Callable[[Array, Array, Array, Array], Array]

    def rows(self, parts: Array, x: Array, y: Array, t: Array) -> Array:
        """Return pi times all fields (..., m) from the integrals of its densities (p, m)."""
        return np.concatenate([self.fields @ parts, self.moved(parts, x, y, t)])


def waves(primitives: Primitives) -> tuple[Wave, ...]:
    """Return the waves: P and S, or that of antiplane shear."""
    if len(primitives.slownesses) == 1:

        def by_s_along(parts: Array, x: Array, y: Array, t: Array) -> Array:
            one, k, beta = parts
            return (t * one + x * k + y * beta)[None]

        # The densities are those of v_z, sigma_xz and sigma_yz themselves.
        return (Wave(1.0, np.eye(3), np.eye(3), by_s_along),)
    a = primitives.slownesses[0]
    # Columns: P_v times 1, k, 1 / k, alpha, alpha / k.
    of_p = np.zeros((5, 5))
    of_p[0, 0], of_p[1, 4] = 1, -1
    of_p[2, 1:3], of_p[3, 1:3], of_p[4, 3] = (2, 1 - 2 * a * a), (-2, 1), -2
    # Columns: S_v times 1, k, k / beta, 1 / beta, k^2 / beta.
    of_s = np.zeros((5, 5))
    of_s[0, 0], of_s[1, 2], of_s[2, 1], of_s[3, 1], of_s[4, 3:] = 1, 1, 2, -2, (-1, 2)

    def by_p(parts: Array, x: Array, y: Array, t: Array) -> Array:
        one, k, over_k, alpha, alpha_over_k = parts
        along = t * one + x * k - y * alpha
        return np.stack([along, y * (a * a * over_k - k) - t * alpha_over_k - x * alpha])

    def by_s(parts: Array, x: Array, y: Array, t: Array) -> Array:
        one, k, k_over, over, square_over = parts
        along = t * one + x * k - y * (over - square_over)
        return np.stack([along, t * k_over + x * square_over - y * k])

    every = np.eye(len(primitives.behind_front))
    return Wave(a, every[P_WAVE], of_p, by_p), Wave(1.0, every[S_WAVE], of_s, by_s)


def arrives(x: Array, y: Array, t: Array, s: float, front: float) -> np.ndarray:
    """Return (m,) whether a wave of slowness s may have come to points.

    `front` is the slowness p > 0 of a load that comes along the slot, else 0.
    """
    return t > front * x + np.sqrt((s - front) * (s + front)) * y


def slowness(x: Array, y: Array, t: Array, s: float, front: float = 0.0) -> Complex:
    """Return the slowness k_s at points (m,), y >= 0, r > 0, for a wave of slowness s."""
    square = np.square(x) + np.square(y)
    r = np.sqrt(square)
    rest = (t - s * r) * (t + s * r)
    root, inside = np.sqrt(np.abs(rest)), rest >= 0
    across = np.where(inside, 1.0, np.abs(x) * t + y * root)
    before = -np.sign(x) * (t - s * y) * (t + s * y) / across
    if front:  # where the sign at the root is that of -x, nothing cancels
        turned = (x > 0) & (s * x < front * r)
        before = np.where(turned, -(x * t + y * root) / square, before)
    real = np.where(inside, -x * t / square, before)
    return real + 1j * np.where(inside, y * root / square, 0.0)


def is_singular(primitives: Primitives, x: Array, y: Array, t: Array) -> np.ndarray:
    """Return (m,) whether points are the contact edge, or lie on a wave that is singular there."""
    edge = (x == 0) & (y == 0)
    away = np.where(edge, t, x)
    at_front = [
        (t >= primitives.front * away + np.sqrt(s**2 - primitives.front**2) * y)
        & primitives.at_centre(slowness(away, y, t, s, primitives.front))
        for s in primitives.slownesses
    ]
    return edge | np.logical_or.reduce(at_front)


def upper(
    primitives: Primitives, x: Array, y: Array, t: Array, close: float, quantity: Quantity
) -> Array:
    """Return the rows of a quantity at points (m,) of the upper body, y >= 0, t > 0.

    They are those of `PLANE` or of `ALONG`.  Where they are singular, fields at the distance
    `close` from the singularity are returned, at the contact edge ahead of it.
    """
    x = np.where((x == 0) & (y == 0), close * t, x)
    along = len(primitives.slownesses) == 1
    chosen = (ALONG if along else PLANE)[quantity]
    near = np.zeros(len(x), dtype=bool) if along else t > tuning.NEAR_EDGE * np.hypot(x, y)
    result = np.zeros((chosen.stop - chosen.start, len(x)))
    for wave in waves(primitives):
        here = np.flatnonzero(arrives(x, y, t, wave.slowness, primitives.front) & ~near)
        at = x[here], y[here], t[here]
        k = slowness(*at, wave.slowness, primitives.front)
        if chosen.stop <= len(wave.fields):
            # What is asked for is added up per cell, not per point.
            result[:, here] += primitives(k, close, wave.fields[chosen] @ wave.parts)
        else:
            result[:, here] += wave.rows(primitives(k, close, wave.parts), *at)[chosen]
    here = np.flatnonzero(near)
    if len(here):
        result[:, here] = _beside_edge(primitives, x[here], y[here], t[here], close)[chosen]
    return result / np.pi


def reflected(primitives: Primitives, x: Array, y: Array, t: Array, quantity: Quantity) -> Array:
    """Return the rows of a quantity at points (m,) at times t <= 0, y >= 0.

    They are the plane waves of a load that comes along the slot, and 0 without one.
    """
    along = len(primitives.slownesses) == 1
    result = np.zeros((4 if along else 7, len(x)))
    if primitives.front:
        for wave in waves(primitives):
            here = np.flatnonzero(arrives(x, y, t, wave.slowness, primitives.front))
            parts = wave.parts @ np.repeat(primitives.behind_front.imag[:, None], len(here), axis=1)
            result[:, here] += wave.rows(parts, x[here], y[here], t[here])
    return result[(ALONG if along else PLANE)[quantity]] / np.pi


def _beside_edge(primitives: Primitives, x: Array, y: Array, t: Array, close: float) -> Array:
    """Return pi times all fields (7, m) where both waves nearly cancel, beside the edge.

    The densities of both are added before they are integrated up to k_P; the S wave is then
    integrated on to k_S.
    """
    k_p, a = slowness(x, y, t, primitives.slownesses[0]), primitives.slownesses[0]
    every = np.eye(len(primitives.behind_front))
    *fields, k_x, k_y, y_x, y_y = primitives(k_p, close, every[SUMS])
    v_x, v_y, *_ = fields
    moved = [t * v_x + x * k_x - y * y_x, t * v_y + x * k_y - y * y_y]
    result = np.stack([*fields, *moved])
    square = np.square(x) + np.square(y)
    roots = np.sqrt(np.square(t) - square) + np.sqrt(np.square(t) - a * a * square)
    step = 1j * y * (a * a - 1) / roots
    nodes, weights = np.polynomial.legendre.leggauss(tuning.NEAR_EDGE_NODES)
    k = k_p + (nodes[:, None] + 1) / 2 * step
    beta = -1j * np.sqrt(k - 1) * np.sqrt(k + 1)
    # Its real part is the imaginary part of i times it.
    real, imag = primitives(k.ravel(), close, np.array([[1j], [1]]) * every[SHEAR])
    sent = (real + 1j * imag).reshape(k.shape) * (weights[:, None] / 2 * step)
    lifted, phase = k / beta * sent, t + k * x - beta * y
    parts = (sent, lifted, 2 * k * sent, -2 * k * sent, (2 * k * k - 1) / beta * sent)
    return result + np.stack([*parts, phase * sent, phase * lifted]).sum(axis=1).imag
