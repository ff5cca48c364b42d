"""Arrays that the pictures of the page show, in the units of their axes, and answers in words.

Positions are relative to c_t T, times to T, tractions to τ₀, slip rates to V₀, slip and
displacement to V₀ T; T is the end time.  Pictures of one moment show the time `share` T.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from compare.comparison.scales import (
    contact_fronts,
    reference_values,
    slip_rate_scale,
    stress_scale,
)
from compare.figures.fronts import fronts, moving_parts, reach
from semianalytic import Marched, Scene
from semianalytic.results.in_words import digits_apart, kind_of_slip, number_or_infinity
from semianalytic.scene.arrays import Array
from semianalytic.scene.units import unit
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone

KINDS = ("stick", "slip", "reverse slip", "open")
"""States of the contact; arrays store the index of a state."""
NODES = 300
"""Number of evenly spread nodes of curves over x; more are added near edges and fronts."""
BESIDE = np.outer([-1, 1], np.geomspace(1e-6, 3e-2, 9)).ravel()
"""Relative distances of the added nodes from their edge or front."""
NAMED = 0.9
"""Part of the picture of both bodies in which names of waves are not cut by its rim."""
SPEED, DISPLACEMENT = "particle speed", "displacement"
"""Quantities that the picture of both bodies can show."""
MOST = 240
"""Largest number of rows and columns of a space-time image of a march."""


def end_time(scene: Scene) -> float:
    """Return T, the time a shear wave takes over a length of 1 [time]."""
    return 1.0 / scene.material.shear_speed


@dataclass(frozen=True, eq=False)
class InterfaceView:
    """State of the contact at one time."""

    x: Array  # (n,) array: positions over c_t T
    slip_rate: Array  # (n,) array: slip rate over V₀
    slip: Array  # (n,) array: slip over V₀ T
    # (n,) arrays: shear traction, friction bound f p and contact pressure over τ₀
    shear: Array
    bound: Array
    pressure: Array

    @property
    def rate_limits(self) -> tuple[float, float]:
        """Return limits of an axis for the slip rate, without its few largest values."""
        return _limits(self.slip_rate, 0.05)

    @property
    def slip_limits(self) -> tuple[float, float]:
        """Return limits of an axis for the slip."""
        return _limits(self.slip, 0.05)

    @property
    def traction_limits(self) -> tuple[float, float]:
        """Return limits of an axis for tractions, without the singular values near the edge."""
        inner = self.x > 0.05 * np.max(self.x)
        parts = (self.shear, self.bound, -self.bound, self.pressure)
        return _limits(np.concatenate([part[inner] for part in parts]), 0.1)


def interface_view(answer: Any, nodes: int = NODES, share: float = 1.0) -> InterfaceView:
    """Return slip rate, slip and tractions along the contact, at `nodes` places and at edges."""
    scene = answer.scene
    end, stress = end_time(scene), stress_scale(scene)
    time, rate = share * end, slip_rate_scale(scene)
    x = _places(answer, nodes, share)
    pressure = answer.pressure(x, time)
    return InterfaceView(
        x=x / (scene.material.shear_speed * end),
        slip_rate=answer.slip_rate(x, time) / rate,
        slip=answer.slip(x, time) / (rate * end),
        shear=answer.shear_traction(x, time) / stress,
        bound=scene.strength(pressure) / stress,
        pressure=pressure / stress,
    )


def _places(solution: Any, nodes: int, share: float) -> Array:
    """Return positions [length] that make curves smooth, denser near edges and fronts."""
    if solution.method == "space-time":
        x = solution.interface.x
        return np.asarray(x[:: max(1, len(x) // (2 * NODES))])
    scene, fronts = solution.scene, contact_fronts(solution.scene)
    far = reach(solution, end_time(scene))[1] / end_time(scene)
    parts: list[SlipZone | OpenZone] = [*solution.zones, *solution.openings]
    edges = [edge for part in parts for edge in (part.inner, part.outer) if 0 < edge < np.inf]
    near = np.array([*fronts.values(), *edges])
    even = np.linspace(far / nodes, far, nodes)
    speeds = np.concatenate([even / share, even, (near[:, None] * (1 + BESIDE)).ravel()])
    inside = (speeds > 0) & (speeds <= far / share)
    return np.unique(speeds[inside]) * share * end_time(scene)


def _limits(values: Array, margin: float) -> tuple[float, float]:
    low, high = (float(limit) for limit in np.nanquantile(values, [0.005, 0.995]))
    room = margin * max(high - low, 1e-3)
    return low - room, high + room


@dataclass(frozen=True, eq=False)
class SpaceTimeView:
    """State of the contact over space and time."""

    # tuple of (kind, inner, outer): edges of zones at T over c_t T, infinite for slip that a remote
    # load starts everywhere; empty for a march
    wedges: tuple[tuple[str, float, float], ...]
    # (m, n) array or None: indices of `KINDS` over 0 < x < reach, 0 < t < T; None for a solution
    image: Array | None
    reach: float  # largest position over c_t T
    waves: Mapping[str, float]  # positions of the wave fronts at T over c_t T, by name


def space_time_view(answer: Any) -> SpaceTimeView:
    """Return zones as wedges if they are self-similar, otherwise as an image of slip senses."""
    scene = answer.scene
    speed = scene.material.shear_speed
    fronts = contact_fronts(scene)
    waves = {name: front / speed for name, front in fronts.items()}
    if answer.method == "space-time":
        last = float(answer.interface.x[-1]) / (speed * end_time(scene))
        return SpaceTimeView((), _senses(answer), last, waves)
    length = speed * end_time(scene)
    far = reach(answer, end_time(scene))[1] / length
    wedges = tuple(
        (part.kind, part.start / length, part.end / length)
        for part in moving_parts(answer, end_time(scene))
    )
    return SpaceTimeView(wedges, None, far, waves)


def _senses(marched: Marched) -> Array:
    """Return indices of `KINDS` at levels and nodes of a march; slip below a thousandth sticks."""
    history = marched.interface
    rows = slice(None, None, max(1, len(history.t) // MOST))
    columns = slice(None, None, max(1, len(history.x) // MOST))
    rate = history.slip_rate[rows, columns]
    least = 1e-3 * slip_rate_scale(marched.scene)
    return np.select([rate > least, rate < -least], [1.0, 2.0], 0.0)


@dataclass(frozen=True, eq=False)
class FieldView:
    """Particle speed or displacement in both bodies at one time."""

    # (m, n) array: particle speed over V₀, or displacement over V₀ T, clipped at `largest`
    size: Array
    reach: float  # half the side of the picture over c_t T
    largest: float  # value at the end of the colour scale
    lines: list[tuple[Array, Array]]  # list of (x, y): wave fronts in both bodies
    # list of (name, x, y): names of waves, each next to its front
    names: list[tuple[str, float, float]]
    # list of (kind, start, end): slipping and open parts of the interface
    parts: list[tuple[str, float, float]]


def field_view(fields: Any, points: int, share: float = 1.0, of: str = SPEED) -> FieldView:
    """Return speed or displacement on points x points square cells around the contact edge."""
    scene, end = fields.scene, end_time(fields.scene)
    time, length = share * end, scene.material.shear_speed * end
    far = reach(fields, end)[1]
    middles = far * (2 * (np.arange(points) + 0.5) / points - 1)
    x, y = (part.ravel() for part in np.meshgrid(middles, middles))
    rows = (fields.velocity if of == SPEED else fields.displacement)(x, y, time)
    scale = slip_rate_scale(scene) * (1.0 if of == SPEED else end)
    size = np.sqrt(np.sum(np.square(rows), axis=0)).reshape(points, points) / scale
    largest = float(np.quantile(size[np.isfinite(size)], 0.995)) or 1.0
    lines, names = [], []
    for front in fronts(fields, time):
        inside = (np.abs(front.x) <= 2 * far) & (np.abs(front.y) <= 2 * far)
        along, across = front.x[inside] / length, front.y[inside] / length
        lines += [(along, side * across) for side in front.sides]
        if len(along) and not front.name.startswith("plane"):
            at = min(round(front.share * (len(along) - 1)), len(along) - 1)
            place = float(along[at]), front.sides[0] * float(across[at])
            if max(map(abs, place)) < NAMED * far / length:
                names.append((front.name, *place))
    parts = [
        (part.kind, part.start / length, min(part.end, far) / length)
        for part in moving_parts(fields, time)
    ]
    return FieldView(np.minimum(size, largest), far / length, largest, lines, names, parts)


def readings(answer: Any) -> list[list[str]]:
    """Return further results of an answer, each with name and value."""
    scene = answer.scene
    if answer.method == "space-time":
        slip = float(answer.max_slip(answer.end_time))
        return [["largest slip", f"{slip:.4g} {unit('length', scene.units)}"]]
    speed = scene.material.shear_speed
    parts = [
        (kind_of_slip(zone.sense), zone.inner / speed, zone.outer / speed) for zone in answer.zones
    ]
    parts += [("open", opening.inner / speed, opening.outer / speed) for opening in answer.openings]
    digits = digits_apart((end for _, *ends in parts for end in ends), 5)
    rows = [
        [kind, f"{inner:.{digits}g} … {number_or_infinity(outer, digits)} c_t"]
        for kind, inner, outer in sorted(parts, key=lambda part: part[1])
    ]
    return rows or [["interface", "sticks everywhere"]]


def scales(scene: Scene) -> list[list[str]]:
    """Return the scales of the axes: symbol, value with its unit."""
    time = end_time(scene)
    named = reference_values(scene, time)
    named["c_t T"] = (scene.material.shear_speed * time, unit("length", scene.units))
    shown = {symbol: named[symbol] for symbol in ("c_t T", "T", "τ₀", "V₀")}
    return [[symbol, f"{value:.4g} {name}"] for symbol, (value, name) in shown.items()]
