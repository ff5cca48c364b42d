"""Predictions spoilt on purpose, each with one mistake of a known size."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from docs.studies.judge.held_slot import held_slot
from docs.studies.judge.spoilt_answers import Profiled, Retold, profiled, tabulated
from semianalytic import (
    Answer,
    Marched,
    OpenZone,
    Scene,
    SceneError,
    SlipZone,
    Solution,
    Tractions,
    solve,
)
from semianalytic.reference import Reading, published_slip
from semianalytic.reference.known_answers import published_obstacle, published_unit
from semianalytic.results.intervals import slip_intervals
from semianalytic.scene.given.overriding import override_scene
from semianalytic.scene.loading import SLOT

Array = NDArray[np.float64]

_HELD_NODES = 300
_NO_SLIP = 1e-9
"""Slip rates below this part of the largest one count as zero."""


@dataclass(frozen=True)
class Window:
    """Duration, time step and reach of the record of a simulation.

    Attributes
    ----------
    end_time, time_step : [time]
    reach : of the contact [length]
    """

    end_time: float
    time_step: float
    reach: float


Make = Callable[[Answer, Window, float], Answer | None]


@dataclass(frozen=True)
class Spoil:
    """A mistake that a prediction may hold.

    Attributes
    ----------
    name : str
    what : str
        The mistake in a line.
    make : callable
        (right prediction, window of the simulation, size of the mistake) to the wrong prediction;
        None where the mistake is none.
    size : float
        What is usual; 0 where a mistake has no size.
    unit : str
        Of the size; "%" if it is a part.
    """

    name: str
    what: str
    make: Make
    size: float = 0.0
    unit: str = ""


def spoilt(spoil: Spoil, prediction: Answer, window: Window, share: float = 1.0) -> Answer | None:
    """The prediction with a mistake of a share of its usual size; None where it makes no sense."""
    try:
        return spoil.make(prediction, window, share * spoil.size)
    except SceneError:
        return None  # no such material, base or load, or the contact opens


def _with_other(change: Callable[[Scene, float], Scene]) -> Make:
    """The right answer to another scene."""

    def make(prediction: Answer, window: Window, size: float) -> Answer | None:
        scene = prediction.scene
        other = change(scene, size)
        if other == scene:
            return None
        if not isinstance(prediction, Marched):
            return tabulated(solve(other))
        nodes = prediction.grid.observed
        return solve(
            other,
            method="space-time",
            end_time=window.end_time,
            nodes=nodes,
            length=nodes * prediction.grid.spacing,
        )

    return make


def _other_friction(scene: Scene, size: float) -> Scene:
    return replace(scene, friction=(1 + size) * scene.friction)


def _other_ratio(scene: Scene, size: float) -> Scene:
    return override_scene(scene, poisson_ratio=scene.material.poisson_ratio + size)


def _without_base_shear(scene: Scene, size: float) -> Scene:
    held = scene.superposition.in_place
    return replace(scene, base=Tractions(held.pressure, 0.0), load_on=SLOT)


def _late(prediction: Answer, window: Window, size: float) -> Answer | None:
    return Retold(_quick(prediction), lag=size * window.time_step)


def _backward(prediction: Answer, window: Window, size: float) -> Answer | None:
    return Retold(_quick(prediction), sense=-1)


def _quick(prediction: Answer) -> Answer:
    """A solution as a table, and anything else as it is."""
    return profiled(prediction) if isinstance(prediction, Solution) else prediction


def _second_zone_times(factor: float) -> Make:
    """Slip rate in the second zone from the edge times 0 or -1."""

    def make(prediction: Answer, window: Window, size: float) -> Answer | None:
        if not isinstance(prediction, Solution) or len(prediction.zones) < 2:
            return None
        table, zone = profiled(prediction), prediction.zones[1]
        inside = (table.velocity > zone.inner) & (table.velocity < zone.outer)
        changed = SlipZone(zone.inner, zone.outer, -zone.sense)
        kept = tuple(other for other in table.zones if other != zone)
        zones = (*kept, changed) if factor else kept
        rate = np.where(inside, factor * table.rate, table.rate)
        return replace(table, rate=rate, zones=tuple(sorted(zones, key=lambda part: part.inner)))

    return make


def _bent_edge(prediction: Answer, window: Window, size: float) -> Answer | None:
    """The first edge of a zone that has room to move."""
    if not isinstance(prediction, Solution):
        return None
    return _first_bent(prediction, prediction.edge_speeds.ravel().tolist(), size)


def _bent_opening(prediction: Answer, window: Window, size: float) -> Answer | None:
    """The first end of an opening that has room to move."""
    if not isinstance(prediction, Solution):
        return None
    ends = [end for part in prediction.openings_at(1.0) for end in (part.start, part.end)]
    return _first_bent(prediction, ends, size)


def _first_bent(solution: Solution, edges: list[float], size: float) -> Answer | None:
    front = solution.scene.material.longitudinal_speed
    edges = [speed for speed in edges if 0 < speed < math.inf]
    for edge in edges:
        far = [place for place in edges if abs(place - edge) > 2 * abs(size) * edge]
        bent = _bent(solution, edge, (1 + size) * edge, [0.0, front, *far])
        if bent is not None:
            return bent
    return None


def _wider(prediction: Answer, window: Window, size: float) -> Answer | None:
    if not isinstance(prediction, Solution) or not prediction.openings_at(1.0):
        return None
    table = profiled(prediction)
    return replace(table, gap_over_time=(1 + size) * table.gap_over_time)


def _shut(prediction: Answer, window: Window, size: float) -> Answer | None:
    if not isinstance(prediction, Solution) or not prediction.openings_at(1.0):
        return None
    table = profiled(prediction)
    return replace(table, gap_over_time=0 * table.gap_over_time, openings=())


def _bent_rayleigh(prediction: Answer, window: Window, size: float) -> Answer | None:
    if not isinstance(prediction, Solution):
        return None
    material = prediction.scene.material
    speed = material.rayleigh_speed
    fixed = [0.0, material.shear_speed, material.longitudinal_speed]
    return _bent(prediction, speed, (1 + size) * speed, fixed)


def _bent(solution: Solution, place: float, moved: float, fixed: list[float]) -> Answer | None:
    """A solution whose velocities are bent so that one moves and those next to it stay."""
    left = max(other for other in fixed if other < place)
    right = min((other for other in fixed if other > place), default=math.inf)
    if not left < moved < right < math.inf:
        return None

    def bent(velocity: Array) -> Array:
        return np.where(
            (velocity > left) & (velocity < right),
            np.interp(velocity, [left, place, right], [left, moved, right]),
            velocity,
        )

    table = profiled(solution)
    ends = bent(solution.edge_speeds)
    zones = tuple(
        SlipZone(float(inner), float(outer), zone.sense)
        for (inner, outer), zone in zip(ends, solution.zones, strict=True)
    )
    openings = tuple(
        OpenZone(*bent(np.array([part.inner, part.outer])).tolist()) for part in table.openings
    )
    return replace(table, velocity=bent(table.velocity), zones=zones, openings=openings)


def _published(reading: Reading) -> Make:
    """The algorithm of the article, where it applies; what slips is at friction."""

    def make(prediction: Answer, window: Window, size: float) -> Answer | None:
        scene = prediction.scene
        if not isinstance(prediction, Solution) or published_obstacle(scene):
            return None
        table, speed = profiled(prediction), scene.material.shear_speed
        load = scene.superposition.taken_off
        ratio = scene.friction * load.pressure / load.shear
        slip = published_slip(ratio, reading, poisson_ratio=scene.material.poisson_ratio)
        rate = published_unit(scene) * slip.at(speed / table.velocity)
        return _rubbing(table, rate)

    return make


def _held(prediction: Answer, window: Window, size: float) -> Answer | None:
    scene = prediction.scene
    if not isinstance(prediction, Solution) or not prediction.zones:
        return None
    profile, table = held_slot(scene, _HELD_NODES), profiled(prediction)
    at = table.velocity, profile.velocity
    shear = np.interp(*at, profile.shear_traction)
    return replace(_rubbing(table, np.interp(*at, profile.slip_rate)), shear=shear)


def _rubbing(table: Profiled, rate: Array) -> Profiled:
    """A table of another slip rate, at friction where it slips."""
    least = _NO_SLIP * float(np.abs(rate).max())
    parts = slip_intervals(table.velocity, rate, least)
    friction = np.sign(rate) * table.scene.friction * table.normal
    return replace(
        table,
        rate=rate,
        shear=np.where(rate != 0, friction, table.shear),
        zones=tuple(SlipZone(part.start, part.end, part.sense) for part in parts),
    )


def effect(field: str, wrong: Answer, right: Answer, x: Array, t: Array) -> float:
    """Relative L1 difference of a field over positions (n,) and times (m,); inf from nothing."""
    expected, given = (np.asarray(getattr(one, field)(x, t[:, None])) for one in (right, wrong))
    size = float(np.abs(expected).sum())
    change = float(np.abs(given - expected).sum())
    return change / size if size else (math.inf if change else 0.0)


SPOILS = (
    Spoil("friction +3 %", "friction too high", _with_other(_other_friction), 0.03, "%"),
    Spoil("friction -3 %", "friction too low", _with_other(_other_friction), -0.03, "%"),
    Spoil(
        "c_R +0.5 %", "fields bent so that the Rayleigh front is early", _bent_rayleigh, 0.005, "%"
    ),
    Spoil(
        "c_R -0.5 %", "fields bent so that the Rayleigh front is late", _bent_rayleigh, -0.005, "%"
    ),
    Spoil("ν +0.01", "Poisson ratio too high", _with_other(_other_ratio), 0.01),
    Spoil("ν -0.01", "Poisson ratio too low", _with_other(_other_ratio), -0.01),
    Spoil("edge +2 %", "fields bent so that the first zone reaches too far", _bent_edge, 0.02, "%"),
    Spoil("edge -2 %", "fields bent so that the first zone ends too early", _bent_edge, -0.02, "%"),
    Spoil(
        "opening +2 %",
        "fields bent so that the first end of an opening is too far out",
        _bent_opening,
        0.02,
        "%",
    ),
    Spoil(
        "opening -2 %",
        "fields bent so that the first end of an opening is too far in",
        _bent_opening,
        -0.02,
        "%",
    ),
    Spoil("gap +3 %", "contact too far open", _wider, 0.03, "%"),
    Spoil("gap -3 %", "contact not open far enough", _wider, -0.03, "%"),
    Spoil("no opening", "contact taken to stay closed", _shut),
    Spoil("no second zone", "slip of the second zone left out", _second_zone_times(0.0)),
    Spoil(
        "second zone reversed",
        "slip of the second zone with the other sign",
        _second_zone_times(-1.0),
    ),
    Spoil("all slip reversed", "all slip with the other sign", _backward),
    Spoil(
        "signs as printed",
        "the article's algorithm, both terms of the kernel of one sign",
        _published(Reading(signs="equal")),
    ),
    Spoil("slot held", "kernels of an interface that is glued on x < 0, (4.31), (4.37)", _held),
    Spoil(
        "article's algorithm",
        "the algorithm of section 5 as it is best read",
        _published(Reading()),
    ),
    Spoil(
        "a step late", "everything one time step of the simulation too late", _late, 1.0, "steps"
    ),
    Spoil(
        "base shear forgotten",
        "shear of the base taken to be none",
        _with_other(_without_base_shear),
    ),
)
