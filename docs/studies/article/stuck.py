"""The stuck interface under any load history, (3.20).

A remote load P_0 f(t) makes the stuck pressure P_0 int f'(s) p*((t - s)/x) ds, with p*(u) of
(3.10); likewise shear with q*.  Jumps and straight pieces of f are exact, from p* and its
primitive; waves take f(0) p*(t/x) + int_a^{t/x} [f(t - v x) - f(0)] dp*/dv dv, without the roots at
fronts.  Tractions are what the load adds to the base; with base = P_0 f remote, add P_0 f(t)
(3.10).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from docs.studies.article.kernels import square_root_panels
from semianalytic.halfplane.primitives import stuck_primitive
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.halfplane.stuck import (
    ARCTAN_SERIES,
    NEAR_FRONT,
    StuckTraction,
    stuck_traction,
)
from semianalytic.halfplane.stuck_histories import superposed
from semianalytic.results.intervals import contact_points
from semianalytic.scene.arrays import Array
from semianalytic.scene.loads import LoadHistory, Wave
from semianalytic.scene.scene import Material


@dataclass(frozen=True, eq=False)
class StuckHistory:
    """Stuck traction at positions and times [stress], and the largest error of its waves."""

    value: Array
    error: float


def antiplane_primitive(u: ArrayLike) -> Array:
    """Return the primitive of q* in mode III at slowness u [1/b], 0 ahead of the shear front.

    It is (2/pi) (2 r^3/3 + r - (r^2 + 1) arctan r), r^2 = u/b - 1.
    """
    z = np.maximum(np.asarray(u, dtype=float) - 1, 0.0)
    root, terms = np.sqrt(z), 2 * ARCTAN_SERIES / (5 + 2 * np.arange(len(ARCTAN_SERIES)))
    # The primitive of the series of r - arctan r, term by term, where the closed form cancels.
    series = z * z * root * polynomial.polyval(np.minimum(z, NEAR_FRONT), terms)
    direct = (2 * z / 3 + 1) * root - (z + 1) * np.arctan(root)
    return np.asarray(2 / np.pi * np.where(z < NEAR_FRONT, series, direct))


def primitive_of(poisson_ratio: float, mode: Mode) -> Callable[[ArrayLike], Array]:
    """Return the primitive of p* (mode I) or q* (modes II and III) over slowness, b = 1."""
    return antiplane_primitive if mode == "III" else stuck_primitive(poisson_ratio, mode)


def _wave(wave: Wave, stuck: StuckTraction, t: float, per: float, order: int) -> float:
    """Return int_a^u wave(t - v per) dp*/dv dv, u = (t - start)/per; `per` = x b."""
    a, u = stuck.factors.a, (t - wave.start) / per
    if u <= a:
        return 0.0
    if abs(u - 1) < 1e-12:
        u = 1.0  # no panel of rounding next to the root of dq*/dv
    # Gauss points follow half a period of the wave, however many of them lie between the fronts.
    longest = 1 / (2 * wave.frequency * per)
    ends = [a, min(u, 1.0)]
    if u > 1:
        ends += [min(u, 2.0)]
    if u > 2:
        count = int(np.ceil(np.log2(u / 2))) + 1
        ends += list(2 * (u / 2) ** (np.arange(1, count + 1) / count))
    split = [
        np.linspace(left, right, int(np.ceil((right - left) / longest)) + 1)[:-1]
        for left, right in pairwise(ends)
    ]
    v, weight = square_root_panels([*np.concatenate(split).tolist(), u], order)
    # weights vanish at the fronts like the square roots that slope has there
    return float((weight * stuck.derivative(v)) @ wave.value(t - v * per))


def _stuck(
    history: LoadHistory,
    amplitude: float,
    material: Material,
    x: ArrayLike,
    t: ArrayLike,
    mode: Mode,
) -> StuckHistory:
    x, t = contact_points(x, t)
    stuck = stuck_traction(material.poisson_ratio, mode)
    per = x / material.shear_speed
    pieces = history.pieces
    primitive = primitive_of(material.poisson_ratio, mode)
    total = superposed(pieces.jumps, lambda lag: stuck(lag / per), t)
    total += superposed(pieces.kinks, lambda lag: per * primitive(lag / per), t)
    error = 0.0
    if pieces.waves:
        points = list(zip(t.ravel(), per.ravel(), strict=True))
        rough, fine = (
            np.array(
                [sum(_wave(w, stuck, *point, order) for w in pieces.waves) for point in points]
            )
            for order in (24, 36)
        )
        error = abs(amplitude) * float(np.abs(fine - rough).max(initial=0.0))
        total += fine.reshape(x.shape)
    return StuckHistory(amplitude * total, error)


def stuck_pressure(
    history: LoadHistory, amplitude: float, material: Material, x: ArrayLike, t: ArrayLike
) -> StuckHistory:
    """Return the pressure that a slot load P_0 f(t) adds at x > 0 and t, (3.10), (3.20)."""
    return _stuck(history, amplitude, material, x, t, "I")


def stuck_shear(
    history: LoadHistory,
    amplitude: float,
    material: Material,
    x: ArrayLike,
    t: ArrayLike,
    shear_mode: Literal["II", "III"] = "II",
) -> StuckHistory:
    """Return the shear traction that a slot load Q_0 f(t) adds at x > 0 and t, (3.14), (3.20)."""
    return _stuck(history, amplitude, material, x, t, shear_mode)


def near_field(intensity: ArrayLike, x: ArrayLike) -> Array:
    """Return K / sqrt(2 pi x) near the edge, (3.13): what the load adds, and the load [stress]."""
    return np.asarray(intensity, dtype=float) / np.sqrt(2 * np.pi * np.asarray(x, dtype=float))
