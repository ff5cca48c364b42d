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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.field import tuning
from semianalytic.field.cells import Primitives
from semianalytic.field.sources import Source
from semianalytic.field.waves import P_WAVE, S_WAVE, SHEAR, SUMS, Complex
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

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


@dataclass(frozen=True, eq=False)
class Sent:
    """Waves of a source, and the signs (7,), antiplane (4,), of its fields mirrored below."""

    primitives: Primitives
    mirrored: Array

    @property
    def antiplane(self) -> bool:
        """Whether it sends the wave of antiplane shear."""
        return self.primitives.source.antiplane


def fields_of(parts: Sequence[Sent], quantity: Quantity, at: tuple[Array, Array, Array]) -> Array:
    """Return the rows (q, m) of a quantity, those of antiplane shear, if a part sends it, last.

    The points are x, y and t > 0, (m,) each; those whose y has a negative sign, -0.0 included, are
    in the lower body.
    """
    x, y, time = at
    scaled = *_scaled(x, np.abs(y), time), np.signbit(y)
    rows = np.empty((_count(parts, quantity), len(time)))
    # Blocks keep the memory of a picture of any size bounded, and its values in the cache.
    for start in range(0, len(time), tuning.POINTS_AT_ONCE):
        part = slice(start, start + tuning.POINTS_AT_ONCE)
        rows[:, part] = _finite_or_not(parts, quantity, *(row[part] for row in scaled))
    if quantity == "displacement":  # it is of degree 1, the others are of degree 0
        rows *= time
    return rows


def reflected_fields(
    parts: Sequence[Sent], quantity: Quantity, at: tuple[Array, Array, Array]
) -> Array:
    """Return the rows (q, m) of `fields_of` at times t <= 0."""
    x, y, t = at
    place = x, np.abs(y), t
    return _added(parts, quantity, np.signbit(y), lambda part: reflected(part, *place, quantity))


def _count(parts: Sequence[Sent], quantity: Quantity) -> int:
    """Return the number of rows of a quantity."""
    every = [PLANE[quantity], *([ALONG[quantity]] if any(part.antiplane for part in parts) else [])]
    return sum(rows.stop - rows.start for rows in every)


def _added(
    parts: Sequence[Sent],
    quantity: Quantity,
    below: np.ndarray,
    in_upper: Callable[[Primitives], Array],
) -> Array:
    """Return the rows (q, m) in either body from what each part sends into the upper one."""
    in_plane, along = PLANE[quantity], ALONG[quantity]
    rows, count = np.zeros((_count(parts, quantity), len(below))), in_plane.stop - in_plane.start
    for part in parts:
        signs = part.mirrored[along if part.antiplane else in_plane, None]
        own = slice(count, None) if part.antiplane else slice(count)
        # The lower body is the mirror image of the upper one: one evaluation serves both.
        rows[own] += in_upper(part.primitives) * np.where(below, signs, 1)
    return rows


def _near(parts: Sequence[Sent], quantity: Quantity, at: tuple[Array, ...], close: float) -> Array:
    """Return the rows at points (m,), those on a singularity at the distance `close`."""
    x, y, t, below = at
    return _added(parts, quantity, below, lambda part: upper(part, x, y, t, close, quantity))


def _finite_or_not(
    parts: Sequence[Sent], quantity: Quantity, x: Array, y: Array, t: Array, below: np.ndarray
) -> Array:
    """Return the rows at points (m,), infinite with the right sign where they are singular."""
    rows = _near(parts, quantity, (x, y, t, below), tuning.CLOSE[0])
    singular = np.zeros(x.shape, dtype=bool)
    for part in parts:
        singular |= is_singular(part.primitives, x, y, t)
    if singular.any():
        few = rows[:, singular]
        at = x[singular], y[singular], t[singular], below[singular]
        # An infinite value grows as the singularity comes nearer, a steep one does not.
        grown = few - _near(parts, quantity, at, tuning.CLOSE[1])
        # Finite fields change like a square root at least, by 1e-8.
        large = np.abs(grown) > 1e-6 * (1 + np.abs(few))
        rows[:, singular] = np.where(large, np.copysign(np.inf, grown), few)
    return rows


def _scaled(x: Array, y: Array, t: Array) -> tuple[Array, Array, Array]:
    """Return the positions (m,) at t = 1 with the same fields, and times 1."""
    # Fields depend on x / t and y / t alone; displacement is proportional to t besides.
    with np.errstate(over="ignore"):
        # From 1e16 c_t t on fields are those at infinity, to rounding.
        x, y = (np.clip(coordinate / t, -1e16, 1e16) for coordinate in (x, y))
    # Nearer points are the edge: antiplane stresses are off by 1e-8 at 1e-8 and by 6e-7 at 1e-15.
    at_edge = np.square(x) + np.square(y) < 1e-32
    return np.where(at_edge, 0.0, x), np.where(at_edge, 0.0, y), np.ones_like(t)


def checked_points(x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Array, Array, Array]:
    """Return positions and times as arrays of one shape; raise SceneError if one is not finite."""
    points = [np.asarray(values, dtype=float) for values in (x, y, t)]
    if not all(np.all(np.isfinite(point)) for point in points):
        raise SceneError("positions and times must be finite numbers.")
    x, y, t = np.broadcast_arrays(*points)
    return x, y, t


def points_around(reach: float) -> tuple[Array, Array]:
    """Return random points (m,) within twice the slowest `reach`, half of them near the edge."""
    rng = np.random.default_rng(0)
    # With 30 and 120 estimates of four scenes differ by 5 % at most.
    angle, share = rng.uniform(size=(2, 60))
    # Evenly in the logarithm of the radius, so that the neighbourhood of the edge counts as much.
    radius, angle = 2 * (2 * reach) ** -share, 2 * np.pi * angle
    return radius * np.cos(angle), radius * np.sin(angle)


class WaveSource(NamedTuple):
    """A wave of a slowness, and which densities are its own, (p, f).

    `fields` (q, p) and `moved` take their integrals to pi times velocities and stresses, and
    motion.
    """

    slowness: float
    parts: Array
    fields: Array
    moved: Callable[[Array, Array, Array, Array], Array]

    def rows(self, parts: Array, x: Array, y: Array, t: Array) -> Array:
        """Return pi times all fields (..., m) from the integrals of its densities (p, m)."""
        return np.concatenate([self.fields @ parts, self.moved(parts, x, y, t)])


def waves(source: Source) -> tuple[WaveSource, ...]:
    """Return the waves: P and S, or that of antiplane shear."""
    if source.antiplane:

        def by_s_along(parts: Array, x: Array, y: Array, t: Array) -> Array:
            ones, k, beta = parts
            return (t * ones + x * k + y * beta)[None]

        # The densities are those of v_z, sigma_xz and sigma_yz themselves.
        return (WaveSource(1.0, np.eye(3), np.eye(3), by_s_along),)
    a = source.slownesses[0]
    # Columns: P_v times 1, k, 1 / k, alpha, alpha / k.
    of_p = np.zeros((5, 5))
    of_p[0, 0], of_p[1, 4] = 1, -1
    of_p[2, 1:3], of_p[3, 1:3], of_p[4, 3] = (2, 1 - 2 * a * a), (-2, 1), -2
    # Columns: S_v times 1, k, k / beta, 1 / beta, k^2 / beta.
    of_s = np.zeros((5, 5))
    of_s[0, 0], of_s[1, 2], of_s[2, 1], of_s[3, 1], of_s[4, 3:] = 1, 1, 2, -2, (-1, 2)

    def by_p(parts: Array, x: Array, y: Array, t: Array) -> Array:
        ones, k, over_k, alpha, alpha_over_k = parts
        along = t * ones + x * k - y * alpha
        return np.stack([along, y * (a * a * over_k - k) - t * alpha_over_k - x * alpha])

    def by_s(parts: Array, x: Array, y: Array, t: Array) -> Array:
        ones, k, k_over, over, square_over = parts
        along = t * ones + x * k - y * (over - square_over)
        return np.stack([along, t * k_over + x * square_over - y * k])

    every = np.eye(len(source.behind))
    return WaveSource(a, every[P_WAVE], of_p, by_p), WaveSource(1.0, every[S_WAVE], of_s, by_s)


def arrives(x: Array, y: Array, t: Array, s: float, front: float) -> np.ndarray:
    """Return (m,) whether a wave may have come, of a load whose front has slowness `front` or 0."""
    return t > front * x + np.sqrt((s - front) * (s + front)) * y


def slowness(x: Array, y: Array, t: Array, s: float, front: float = 0.0) -> Complex:
    """Return the slowness k_s at points (m,), y >= 0, r > 0, for a wave of slowness s."""
    square = np.square(x) + np.square(y)
    r = np.sqrt(square)
    rest = (t - s * r) * (t + s * r)
    # r^2 k^2 + 2 x t k + t^2 - s^2 y^2 = 0; ahead of the wave both roots are real, and the one that
    # cancels follows from their product.
    real, before = -x * t / square, rest < 0
    if before.any():
        x_b, y_b, t_b, root = x[before], y[before], t[before], np.sqrt(-rest[before])
        across = np.abs(x_b) * t_b + y_b * root
        ahead = -np.sign(x_b) * (t_b - s * y_b) * (t_b + s * y_b) / across
        if front:  # where the sign at the root is that of -x, nothing cancels
            turned = (x_b > 0) & (s * x_b < front * r[before])
            ahead = np.where(turned, -(x_b * t_b + y_b * root) / square[before], ahead)
        real[before] = ahead
    return real + 1j * (y * np.sqrt(np.maximum(rest, 0.0)) / square)


def is_singular(primitives: Primitives, x: Array, y: Array, t: Array) -> np.ndarray:
    """Return (m,) whether points are the contact edge, or lie on a wave that is singular there."""
    edge, r = (x == 0) & (y == 0), np.sqrt(np.square(x) + np.square(y))
    away, front, result = np.where(edge, t, x), primitives.source.front, edge.copy()
    for s in primitives.source.slownesses:
        # anywhere else slowness is not real
        few = np.flatnonzero((y <= 1e-8 * r) | (s * r >= (1 - 1e-8) * t))
        at = away[few], y[few], t[few]
        behind = at[2] >= front * at[0] + np.sqrt(s**2 - front**2) * at[1]
        result[few] |= behind & primitives.at_centre(slowness(*at, s, front))
    return result


def upper(
    primitives: Primitives, x: Array, y: Array, t: Array, close: float, quantity: Quantity
) -> Array:
    """Return the rows (`PLANE` or `ALONG`) of a quantity at points (m,), y >= 0, t > 0.

    Singular ones are at the distance `close` from there, at the contact edge ahead of it.
    """
    # At the contact edge itself fields depend on the direction: those just ahead of it are meant.
    x = np.where((x == 0) & (y == 0), close * t, x)
    along = primitives.source.antiplane
    chosen = (ALONG if along else PLANE)[quantity]
    # There is one wave in antiplane shear, and nothing to cancel with it.
    near = (t > tuning.NEAR_EDGE * np.sqrt(np.square(x) + np.square(y))) & (not along)
    result = np.zeros((chosen.stop - chosen.start, len(x)))
    for wave in waves(primitives.source):
        here = np.flatnonzero(arrives(x, y, t, wave.slowness, primitives.source.front) & ~near)
        at = x[here], y[here], t[here]
        k = slowness(*at, wave.slowness, primitives.source.front)
        if chosen.stop <= len(wave.fields):
            # Requested values are added up per cell, not per point.
            result[:, here] += primitives(k, close, wave.fields[chosen] @ wave.parts)
        else:
            result[:, here] += wave.rows(primitives(k, close, wave.parts), *at)[chosen]
    here = np.flatnonzero(near)
    if len(here):
        result[:, here] = _beside_edge(primitives, x[here], y[here], t[here], close)[chosen]
    return result / np.pi


def reflected(primitives: Primitives, x: Array, y: Array, t: Array, quantity: Quantity) -> Array:
    """Return a quantity at points (m,) at t <= 0, y >= 0: plane waves of a load along the slot."""
    along = primitives.source.antiplane
    result = np.zeros((4 if along else 7, len(x)))
    if primitives.source.front:
        for wave in waves(primitives.source):
            here = np.flatnonzero(arrives(x, y, t, wave.slowness, primitives.source.front))
            # Before anything comes from the edge integrals are those right of the parting point.
            behind = np.repeat(primitives.source.behind.imag[:, None], len(here), axis=1)
            result[:, here] += wave.rows(wave.parts @ behind, x[here], y[here], t[here])
    return result[(ALONG if along else PLANE)[quantity]] / np.pi


def _beside_edge(primitives: Primitives, x: Array, y: Array, t: Array, close: float) -> Array:
    """Return pi times all fields (7, m) where both waves nearly cancel, near the edge.

    Densities of both are added before integration to k_P; the S wave goes on alone to k_S.
    """
    k_p, a = slowness(x, y, t, primitives.source.slownesses[0]), primitives.source.slownesses[0]
    every = np.eye(len(primitives.source.behind))
    *fields, k_x, k_y, y_x, y_y = primitives(k_p, close, every[SUMS])
    v_x, v_y, *_ = fields
    moved = [t * v_x + x * k_x - y * y_x, t * v_y + x * k_y - y * y_y]
    result = np.stack([*fields, *moved])
    square = np.square(x) + np.square(y)
    roots = np.sqrt(np.square(t) - square) + np.sqrt(np.square(t) - a * a * square)
    # k_S - k_P = i y (sqrt(t^2 - r^2) - sqrt(t^2 - a^2 r^2)) / r^2, with the difference
    # rationalised.
    step = 1j * y * (a * a - 1) / roots
    # k_P and k_S lie within 1 % of k of one another.
    nodes, weights = np.polynomial.legendre.leggauss(10)
    k = k_p + (nodes[:, None] + 1) / 2 * step
    beta = -1j * np.sqrt(k - 1) * np.sqrt(k + 1)
    # Its real part is the imaginary part of i times it.
    real, imag = primitives(k.ravel(), close, np.array([[1j], [1]]) * every[SHEAR])
    sent = (real + 1j * imag).reshape(k.shape) * (weights[:, None] / 2 * step)
    lifted, phase = k / beta * sent, t + k * x - beta * y
    parts = (sent, lifted, 2 * k * sent, -2 * k * sent, (2 * k * k - 1) / beta * sent)
    return result + np.stack([*parts, phase * sent, phase * lifted]).sum(axis=1).imag
