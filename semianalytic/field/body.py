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

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.field import tuning
from semianalytic.field.cells import Primitives
from semianalytic.field.waves import P_WAVE, S_WAVE, SHEAR, SUMS, Complex
from semianalytic.halfplane.rayleigh import Array
from semianalytic.scene.errors import SceneError


@dataclass(frozen=True, eq=False)
class Sent:
    """What one source sends into a body, as a part of all its fields.

    Attributes
    ----------
    primitives : Primitives
    rows : slice
        The rows of all fields to which it adds.
    signs : (7,) or (4,) array
        Signs that turn its fields in the upper half-plane into those of the body, which may be a
        mirror image.
    """

    primitives: Primitives
    rows: slice
    signs: Array


def fields_of(
    parts: Sequence[Sent], count: int, moved: Sequence[int], at: tuple[Array, Array, Array]
) -> Array:
    """Return all fields (count, m) at points of the upper half-plane, t > 0.

    Parameters
    ----------
    parts : sequence of Sent
    count : int
        Number of rows.
    moved : sequence of int
        Rows of displacements, which are of degree 1.
    at : three (m,) arrays
        x, y >= 0 and t > 0.
    """
    time = at[2]
    scaled = _scaled(*at)
    rows = np.empty((count, len(time)))
    for start in range(0, len(time), tuning.POINTS_AT_ONCE):
        part = slice(start, start + tuning.POINTS_AT_ONCE)
        x, y, t = (one[part] for one in scaled)
        rows[:, part] = _finite_or_not(parts, count, x, y, t)
    rows[list(moved)] *= time
    return rows


def reflected_fields(parts: Sequence[Sent], count: int, at: tuple[Array, Array, Array]) -> Array:
    """Return all fields (count, m) at points (m,) of the upper half-plane at times t <= 0."""
    rows = np.zeros((count, len(at[0])))
    for part in parts:
        rows[part.rows] += reflected(part.primitives, *at) * part.signs[:, None]
    return rows


def _near(parts: Sequence[Sent], count: int, x: Array, y: Array, t: Array, close: float) -> Array:
    """Return all fields at points (m,), those on a singularity at the distance `close`."""
    rows = np.zeros((count, len(x)))
    for part in parts:
        rows[part.rows] += upper(part.primitives, x, y, t, close) * part.signs[:, None]
    return rows


def _finite_or_not(parts: Sequence[Sent], count: int, x: Array, y: Array, t: Array) -> Array:
    """Return all fields at points (m,), infinite with the right sign where they are singular."""
    rows = _near(parts, count, x, y, t, tuning.CLOSE[0])
    singular = np.zeros(x.shape, dtype=bool)
    for part in parts:
        singular |= is_singular(part.primitives, x, y, t)
    if singular.any():
        few = rows[:, singular]
        at = x[singular], y[singular], t[singular]
        grown = few - _near(parts, count, *at, tuning.CLOSE[1])
        large = np.abs(grown) > tuning.GROWN * (1 + np.abs(few))
        rows[:, singular] = np.where(large, np.copysign(np.inf, grown), few)
    return rows


def _scaled(x: Array, y: Array, t: Array) -> tuple[Array, Array, Array]:
    """Return the positions (m,) at t = 1 with the same fields, and times 1.

    Fields depend on x / t and y / t alone; displacement is proportional to t besides.  Positions
    are limited to `FARTHEST`, and are put at the edge within `NEAREST` of it.
    """
    with np.errstate(over="ignore"):
        x, y = (np.clip(one / t, -tuning.FARTHEST, tuning.FARTHEST) for one in (x, y))
    at_edge = np.hypot(x, y) < tuning.NEAREST
    return np.where(at_edge, 0.0, x), np.where(at_edge, 0.0, y), np.ones_like(t)


def checked_points(x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Array, Array, Array]:
    """Return positions and times as arrays of one shape; raise SceneError if one is not finite."""
    points = [np.asarray(one, dtype=float) for one in (x, y, t)]
    if not all(np.all(np.isfinite(one)) for one in points):
        raise SceneError("positions and times must be finite numbers.")
    x, y, t = np.broadcast_arrays(*points)
    return x, y, t


def points_around(reach: float) -> tuple[Array, Array]:
    """Return x and y (m,) of random points within twice the reach of waves, at which rules are
    compared; half of them are near the edge.

    Parameters
    ----------
    reach : float
        Slowness of the slowest front or zone edge, over that of the unit of speed.
    """
    rng = np.random.default_rng(0)
    angle, share = rng.uniform(size=(2, tuning.ESTIMATED_POINTS))
    radius, angle = 2 * (2 * reach) ** -share, 2 * np.pi * angle
    return radius * np.cos(angle), radius * np.sin(angle)


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
        (t >= primitives.source.front * away + np.sqrt(s**2 - primitives.source.front**2) * y)
        & primitives.at_centre(slowness(away, y, t, s, primitives.source.front))
        for s in primitives.source.slownesses
    ]
    return edge | np.logical_or.reduce(at_front)


def upper(primitives: Primitives, x: Array, y: Array, t: Array, close: float) -> Array:
    """Return the fields (7, m) or (4, m) at points (m,) of the upper body, y >= 0, t > 0.

    Where they are singular, fields at the distance `close` from the singularity are returned, at
    the contact edge ahead of it.
    """
    x = np.where((x == 0) & (y == 0), close * t, x)
    if len(primitives.source.slownesses) == 1:
        return _antiplane(primitives, x, y, t, close)
    near = t > tuning.NEAR_EDGE * np.hypot(x, y)
    result = np.zeros((7, len(x)))
    a = primitives.source.slownesses[0]
    for s in primitives.source.slownesses:
        here = np.flatnonzero(arrives(x, y, t, s, primitives.source.front) & ~near)
        at = x[here], y[here], t[here]
        k = slowness(*at, s, primitives.source.front)
        if s == a:
            result[:, here] += _of_p(primitives(k, close, P_WAVE), *at, a)
        else:
            result[:, here] += _of_s(primitives(k, close, S_WAVE), *at)
    here = np.flatnonzero(near)
    result[:, here] = _beside_edge(primitives, x[here], y[here], t[here], close)
    return result / np.pi


def reflected(primitives: Primitives, x: Array, y: Array, t: Array) -> Array:
    """Return the fields (7, m) or (4, m) at points (m,) at times t <= 0, y >= 0.

    They are the plane waves of a load that comes along the slot, and 0 without one.
    """
    alone = len(primitives.source.slownesses) == 1
    result = np.zeros((4 if alone else 7, len(x)))
    if not primitives.source.front:
        return result
    for s in primitives.source.slownesses:
        here = np.flatnonzero(arrives(x, y, t, s, primitives.source.front))
        at = x[here], y[here], t[here]
        values = np.repeat(primitives.source.behind[:, None], len(here), axis=1)
        if alone:
            one, k, beta = values.imag
            result[:, here] = one, k, beta, at[2] * one + at[0] * k + at[1] * beta
        elif s == primitives.source.slownesses[0]:
            result[:, here] += _of_p(values[P_WAVE], *at, s)
        else:
            result[:, here] += _of_s(values[S_WAVE], *at)
    return result / np.pi


def _antiplane(primitives: Primitives, x: Array, y: Array, t: Array, close: float) -> Array:
    result = np.zeros((4, len(x)))
    here = np.flatnonzero(arrives(x, y, t, 1.0, primitives.source.front))
    x, y, t = x[here], y[here], t[here]
    one, k, beta = primitives(slowness(x, y, t, 1.0, primitives.source.front), close).imag
    result[:, here] = one, k, beta, t * one + x * k + y * beta
    return result / np.pi


def _of_p(parts: Complex, x: Array, y: Array, t: Array, a: float) -> Array:
    """Return pi times the contribution of the P wave."""
    one, k, over_k, alpha, alpha_over_k = parts.imag
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
    one, k, k_over, over, square_over = parts.imag
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
    k_p, a = slowness(x, y, t, primitives.source.slownesses[0]), primitives.source.slownesses[0]
    *fields, k_x, k_y, y_x, y_y = primitives(k_p, close, SUMS).imag
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
        (sent,) = primitives(k, close, slice(SHEAR, SHEAR + 1)) * weight * step
        lifted, phase = k / beta * sent, t + k * x - beta * y
        parts = (sent, lifted, 2 * k * sent, -2 * k * sent, (2 * k * k - 1) / beta * sent)
        result += np.stack([*parts, phase * sent, phase * lifted]).imag
    return result
