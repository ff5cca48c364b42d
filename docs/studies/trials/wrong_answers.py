"""Answers and simulations that are wrong on purpose, each with one mistake of a known size."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

import semianalytic as sf
from fem import Simulation
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.answer import Answer, OpenInterval, SlipInterval
from semianalytic.scene.loading import SLOT
from semianalytic.selfsimilar.answer import SelfSimilarAnswer
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone

Array = NDArray[np.float64]

_EVEN, _GRADED, _CLUSTERED = 4000, 300, 200
_REACH = 1.1
"""End of the table of a profile, over c_l; fields farther ahead keep the values at the end."""
_FIRST, _NEAREST, _BESIDE = 1e-6, 1e-7, 0.05
"""First velocity, and least and largest distance of points from an edge or a front, over c_t."""


@dataclass(frozen=True, eq=False)
class Profiled(SelfSimilarAnswer):
    """A self-similar answer of given fields at velocities x/t, linear between them.

    Slip and totals follow from them.  Nearer to the edge than the first velocity, and further than
    the last, fields are those there.  Tractions include the base, `gap_over_time` is how far the
    contact is open over the time, and `lag` is the time by which all of it is late.
    """

    scene: sf.Scene
    velocities: Array
    rate: Array
    shear: Array
    normal: Array
    zones: tuple[SlipZone, ...]
    gap_over_time: Array
    openings: tuple[OpenZone, ...]
    lag: float = 0.0

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self._at(self.rate, 0.0, x, t)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self._since(t) * self._at(self._slip_over_time, 0.0, x, t)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self._at(self.shear, self.scene.superposition.in_place.shear, x, t)

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self._at(self.normal, self.scene.superposition.in_place.pressure, x, t)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self._since(t) * self._at(self.gap_over_time, 0.0, x, t)

    def max_slip(self, t: ArrayLike) -> Array:
        return self._since(t) * float(np.abs(self._slip_over_time).max())

    def accumulated_slip(self, t: ArrayLike) -> Array:
        return self._growing(np.abs(self.rate), t)

    def frictional_work(self, t: ArrayLike) -> Array:
        return self._growing(np.abs(self.shear * self.rate), t)

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        return super().zones_at(t - self.lag)

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        return super().openings_at(t - self.lag)

    def _since(self, t: ArrayLike) -> Array:
        return np.maximum(np.asarray(t, dtype=float) - self.lag, 0.0)

    def _at(self, values: Array, at_rest: float, x: ArrayLike, t: ArrayLike) -> Array:
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t) - self.lag)
        velocity = np.divide(x, t, out=np.full(x.shape, np.inf), where=t > 0)
        return np.where(t < 0, at_rest, np.interp(velocity, self.velocities, values))

    @cached_property
    def _slip_over_time(self) -> Array:
        """Slip / t, (n,): the mean of the slip rate over slownesses up to t/x."""
        slowness = 1 / self.velocities
        steps = -np.diff(slowness) * (self.rate[:-1] + self.rate[1:]) / 2
        past = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
        return self.velocities * (past + self.rate[-1] * slowness[-1])

    def _growing(self, values: Array, t: ArrayLike) -> Array:
        """Integral over all positions and times up to t; inf where it slips ahead of all waves."""
        over_time = math.inf
        if not values[-1]:
            over_time = np.trapezoid(values, self.velocities) + values[0] * self.velocities[0]
        time = self._since(t)
        return np.multiply(over_time / 2, time**2, out=np.zeros(time.shape), where=time > 0)


@lru_cache(maxsize=2)
def profiled(solution: sf.Solution) -> Profiled:
    """Tabulate the fields of a solution on the contact so that they can be distorted."""
    material = solution.scene.material
    speed, reach = material.shear_speed, _REACH * material.longitudinal_speed
    openings = solution.openings
    opened = [end for part in openings for end in (part.inner, part.outer)]
    edges = np.array([*solution.edge_speeds.ravel(), *opened])
    fronts = (material.rayleigh_speed, speed, material.longitudinal_speed)
    ends = np.array([*edges[(edges > 0) & np.isfinite(edges)], *fronts])
    near = speed * np.geomspace(_NEAREST, _BESIDE, _CLUSTERED)
    velocity = np.concatenate(
        [
            np.geomspace(_FIRST * speed, reach, _GRADED),
            np.linspace(_FIRST * speed, reach, _EVEN),
            ends,
            np.add.outer(ends, [*near, *-near]).ravel(),
        ]
    )
    velocity = np.unique(velocity[(velocity > 0) & (velocity <= reach)])
    velocity = velocity[velocity != material.rayleigh_speed]  # slip there has a logarithm
    named = (solution.slip_rate, solution.shear_traction, solution.pressure, solution.gap)
    rate, shear, normal, gap = (field(velocity, 1.0) for field in named)
    return Profiled(solution.scene, velocity, rate, shear, normal, solution.zones, gap, openings)


# --- answers --------------------------------------------------------------------------------------


def _of_another_scene(other: sf.Scene, right: Answer) -> Answer | None:
    """Return the right answer to another scene."""
    if other == right.scene:
        return None
    if not isinstance(right, sf.Marched):
        return sf.solve(other)
    nodes = right.grid.observed
    return sf.solve(
        other,
        method="space-time",
        end_time=right.end_time,
        nodes=nodes,
        length=nodes * right.grid.spacing,
    )


def _friction(size: float, share: float, scene: sf.Scene) -> sf.Scene:
    return replace(
        scene, friction=scene.law.with_coefficient((1 + size * share) * scene.coefficient)
    )


def _ratio(size: float, share: float, scene: sf.Scene) -> sf.Scene:
    return override_scene(scene, poisson_ratio=scene.material.poisson_ratio + size * share)


def _second_zone_times(factor: float, right: sf.Solution) -> Profiled | None:
    """Multiply the slip rate in the second zone from the edge by 0 or -1."""
    if len(right.zones) < 2:
        return None
    table, zone = profiled(right), right.zones[1]
    inside = (table.velocities > zone.inner) & (table.velocities < zone.outer)
    changed = (SlipZone(zone.inner, zone.outer, -zone.sense),) if factor else ()
    zones = [*(other for other in table.zones if other != zone), *changed]
    rate = np.where(inside, factor * table.rate, table.rate)
    return replace(table, rate=rate, zones=tuple(sorted(zones, key=lambda part: part.inner)))


def _backward(right: sf.Solution) -> Profiled:
    table = profiled(right)
    zones = tuple(SlipZone(zone.inner, zone.outer, -zone.sense) for zone in table.zones)
    return replace(table, rate=-table.rate, zones=zones)


def _with_gap_times(factor: float, right: sf.Solution) -> Profiled | None:
    if not right.openings:
        return None
    table = profiled(right)
    openings = table.openings if factor else ()
    return replace(table, gap_over_time=factor * table.gap_over_time, openings=openings)


def _first_bent(of: str, size: float, right: sf.Solution) -> Profiled | None:
    """Move the first edge of a slip zone or an opening that has room to move."""
    edges = [end for part in getattr(right, of) for end in (part.inner, part.outer)]
    front = right.scene.material.longitudinal_speed
    edges = [speed for speed in edges if 0 < speed < math.inf]
    for edge in edges:
        far = [place for place in edges if abs(place - edge) > 2 * abs(size) * edge]
        least = max(other for other in [0.0, front, *far] if other < edge)
        most = min((other for other in [front, *far] if other > edge), default=math.inf)
        if least < (1 + size) * edge < most < math.inf:
            return _bent(right, [least, edge, most], [least, (1 + size) * edge, most])
    return None


def _bent(right: sf.Solution, old: list[float], new: list[float]) -> Profiled:
    """Bend the velocities of a solution between the first and the last of the old ones."""

    def bent(velocity: Array) -> Array:
        inside = (velocity > old[0]) & (velocity < old[-1])
        return np.where(inside, np.interp(velocity, old, new), velocity)

    table, ends = profiled(right), bent(right.edge_speeds)
    zones = tuple(
        SlipZone(float(inner), float(outer), zone.sense)
        for (inner, outer), zone in zip(ends, right.zones, strict=True)
    )
    openings = tuple(
        OpenZone(*bent(np.array([part.inner, part.outer])).tolist()) for part in table.openings
    )
    return replace(table, velocities=bent(table.velocities), zones=zones, openings=openings)


Make = Callable[[float, float], Callable[[sf.Solution], Answer | None]]
MISTAKEN_SCENES: Mapping[str, Callable[[float, sf.Scene], sf.Scene]] = {
    "friction +3 %": partial(_friction, 0.03),
    "friction -3 %": partial(_friction, -0.03),
    "ν +0.01": partial(_ratio, 0.01),
    "ν -0.01": partial(_ratio, -0.01),
    "base shear forgotten": lambda _, scene: replace(
        scene, base=sf.Tractions(scene.superposition.in_place.pressure, 0.0), load_on=SLOT
    ),
}
"""Mistakes about the scene, by a share of the usual size."""
_SELF_SIMILAR: Mapping[str, Make] = {
    "edge +2 %": lambda share, step: partial(_first_bent, "zones", 0.02 * share),
    "edge -2 %": lambda share, step: partial(_first_bent, "zones", -0.02 * share),
    "opening +2 %": lambda share, step: partial(_first_bent, "openings", 0.02 * share),
    "opening -2 %": lambda share, step: partial(_first_bent, "openings", -0.02 * share),
    "gap +3 %": lambda share, step: partial(_with_gap_times, 1 + 0.03 * share),
    "gap -3 %": lambda share, step: partial(_with_gap_times, 1 - 0.03 * share),
    "no opening": lambda share, step: partial(_with_gap_times, 0.0),
    "no second zone": lambda share, step: partial(_second_zone_times, 0.0),
    "second zone reversed": lambda share, step: partial(_second_zone_times, -1.0),
    "all slip reversed": lambda share, step: _backward,
    "a step late": lambda share, step: lambda right: replace(profiled(right), lag=share * step),
}
"""Mistakes of a self-similar answer, by a share of the usual size and a time step."""
MISTAKES = (*MISTAKEN_SCENES, *_SELF_SIMILAR)


def spoilt(mistake: str, right: Answer, step: float, share: float = 1.0) -> Answer | None:
    """Return an answer with a mistake of a share of its usual size; None where it makes no sense.

    `step` is the time step of the simulation [time].
    """
    try:
        if mistake in MISTAKEN_SCENES:
            return _of_another_scene(MISTAKEN_SCENES[mistake](share, right.scene), right)
        if isinstance(right, sf.Solution):
            return _SELF_SIMILAR[mistake](share, step)(right)
        return None
    except sf.SceneError:  # no such material, base or load, or the contact opens
        return None


# --- simulations ----------------------------------------------------------------------------------

PLACE = 0.3
"""Position on the contact, over c_t T, of a single node that is at fault."""


def _field(name: str, factor: float, node: bool, run: Simulation) -> Simulation | None:
    """Multiply a field, or its values at one node, and leave the companions as they are."""
    seen = run.interface
    values = getattr(seen, name).copy()
    place = PLACE * run.scene.material.shear_speed * run.end_time
    values[:, np.argmin(np.abs(seen.x - place)) if node else slice(None)] *= factor
    if np.array_equal(values, getattr(seen, name)):
        return None
    return replace(run, interface=replace(seen, **{name: values}))


def _moves_more(factor: float, run: Simulation) -> Simulation | None:
    """Multiply all slip on all meshes by a factor, as a wrong modulus would."""
    seen = run.interface
    if not seen.slip.any():
        return None
    return replace(
        run,
        interface=replace(seen, slip=factor * seen.slip, slip_rate=factor * seen.slip_rate),
        slip_after=factor * run.slip_after,
        final_path=factor * run.final_path,
        final_work_density=factor * run.final_work_density,
        companion=run.companion and _moves_more(factor, run.companion),
    )


def _not_a_number(run: Simulation) -> Simulation:
    values = run.interface.pressure.copy()
    values[-1, len(values[-1]) // 3] = np.nan
    return replace(run, interface=replace(run.interface, pressure=values))


FAULTS: Mapping[str, Callable[[Simulation], Simulation | None]] = {
    "shear reversed": partial(_field, "shear_traction", -1.0, False),
    "slip × 1.05": partial(_field, "slip", 1.05, False),
    "slip rate × 1.02": partial(_field, "slip_rate", 1.02, False),
    "pressure × 1.02": partial(_field, "pressure", 1.02, False),
    "motion × 1.03": partial(_moves_more, 1.03),
    "node × 10, slip rate": partial(_field, "slip_rate", 10.0, True),
    "node × 10, slip": partial(_field, "slip", 10.0, True),
    "node × 10, shear": partial(_field, "shear_traction", 10.0, True),
    "node × 10, pressure": partial(_field, "pressure", 10.0, True),
    "not a number": _not_a_number,
}
"""Faults of the finest mesh alone, but for the motion, which is too large on all meshes; a fault
that changes nothing gives None."""
