"""Choice of the mesh of a comparison, from what the scene needs and the budget allows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

from compare.comparison.measures import NARROW
from semianalytic import Scene, Tractions
from semianalytic.results.answer import Answer
from semianalytic.results.memory import GIGABYTE, memory_limit
from semianalytic.scene.checks import checked_size
from semianalytic.scene.contact import process_zone
from semianalytic.scene.errors import SceneError

DEFAULT_BUDGET = 20.0
"""Default budget [s], as `fem.Cost` counts time, so that every machine gets the same mesh."""
USUAL = 100
"""Resolution of a scene that does not need a finer one."""
COARSER = (2, 4)
"""Element sizes of the companions over that of the simulation."""
LEAST = 32
"""Lowest resolution that is chosen; its coarsest companion is the coarsest possible mesh."""
STRIDE, ROUND_STRIDE = 4, 20
"""Steps between resolutions.  Multiples of `STRIDE` give companions whole resolutions.  Where only
the budget sets a resolution beyond the usual one, it is found in steps of `ROUND_STRIDE`, so that
small differences in cost do not change it."""
SPARE = 0.9
"""Part of the available memory that a choice may count on, because later there may be less."""

DRAWN = 4.5
"""Time to start, to compare and to draw on any mesh [s], as `fem.Cost` counts it: between 3.9 s
(`antiplane`) and 5.1 s (`preloaded`) of processor time for `slipfront compare --no-snapshots`."""
JUDGED, JUDGED_MARCH = 1.4, 10.0
"""Time to compare and to draw field snapshots, over the time to write them, for exact predictions,
and for marches at the usual resolution: their fields in the bodies are sums over nodes and levels.
With a resolution of 60 it is 15."""
MARCHED, MARCH_POWER = 0.5, 1.43
"""Time of a march, with the coarse one that checks it before [s], at a resolution of 100 and a wave
twice as fast as that of shear, and its power of the number of nodes: 0.48, 0.84 and 1.35 s with
resolutions of 100, 144 and 200."""

QUIETING = 0.1
"""Damping of scenes along whose interface waves of a few elements may grow.  With the usual 0.02
they did in 7 of 13 drawn pairs and scenes whose friction falls with slip rate, with 0.1 in none but
one that 0.2 does not mend either; bars were no wider."""
ROUGH, CALMING = 1.25, 0.2
"""Friction between different bodies from which on damping is larger, and that damping.  With 0.1
waves grew in 5 of 6 drawn pairs beyond it and in one of 24 others, with 0.2 in none of these 5."""

BARS = "error bars under the {} history"
"""Feature of error bars, which are narrower if coarser meshes follow a load too."""
WITHIN = "the finest within budget and memory"
RESOLVED_WITH = "may be resolved with {}"
"""Advice on what is unresolved, with a setting by its name."""

YEAR = 365.25 * 86400
LONGEST = 1000 * YEAR
"""Time [s] beyond which durations are not distinguished."""


class Feature(NamedTuple):
    """Feature that a mesh can be too coarse for: its name and the resolution that it needs."""

    name: str
    resolution: int


@dataclass(frozen=True)
class Unseen:
    """Feature that a mesh is too coarse for, and the mesh that would show it.

    The resolution is in node distances per c_t T; time [s] and memory [bytes] are those of a
    comparison without snapshots on this machine at that resolution, or at the usual one if that is
    finer, even if no mesh may be so large, which `meshable` says.
    """

    name: str
    resolution: int
    seconds: float
    memory: float
    meshable: bool

    @property
    def advice(self) -> str:
        """Resolution that may resolve the feature, and its time, in words."""
        if not self.meshable:
            return f"it would take `resolution` {self.resolution}, more than a mesh may have"
        default = ", the default" if self.resolution <= USUAL else ""
        size = f"`resolution` {_at_least_usual(self.resolution)}{default}"
        return f"{RESOLVED_WITH.format(size)}, in about {duration(self.seconds)} without snapshots"


@dataclass(frozen=True)
class MeshChoice:
    """A mesh for the comparison of a scene.

    Attributes
    ----------
    resolution : int
        Node distances per c_t T.
    reason : str
        Reason for the choice: the feature that it is just fine enough for, or another limit.
    needed : int
        Resolution at which no feature that is known beforehand stays unresolved.
    seconds : float
        Time of the simulation, its companions and the comparison on this machine [s].
    memory : float
        Memory of the simulation [bytes].
    unresolved : tuple of Unseen
        Features that this mesh is too coarse for, the widest first.
    damping : float
        As for `fem.simulate`: the given one, or more than usual where short waves may grow.
    """

    resolution: int
    reason: str
    needed: int
    seconds: float
    memory: float
    unresolved: tuple[Unseen, ...]
    damping: float


@dataclass(frozen=True)
class Prices:
    """Time and memory of simulations of a scene at any resolution, companions included.

    Scene and end time are those of `fem.simulate`, options other fields of `fem.Settings` than the
    resolution; with snapshots, the time to write them counts.
    """

    scene: Scene
    end_time: float | None
    snapshots: bool = False
    options: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def pace(self) -> float:
        """Time that this machine takes over the time that `fem.Cost` gives."""
        from fem.budget import machine_pace

        return machine_pace()

    def at(self, resolution: int) -> tuple[float, float]:
        """Time as `fem.Cost` counts it [s] and memory [bytes]; inf if no mesh may be so large."""
        try:
            return self.checked(resolution)
        except SceneError:
            return math.inf, math.inf

    def checked(self, resolution: int, memory: float | None = math.inf) -> tuple[float, float]:
        """Time and memory as from `at`; SceneError is raised if `fem.simulate` would do so."""
        from fem import cost

        options = {**self.options, "resolution": resolution}
        run = cost(self.scene, self.end_time, snapshots=self.snapshots, memory=memory, **options)
        bare = cost(self.scene, self.end_time, **options) if self.snapshots else run
        return run.seconds + sum(size**-3 for size in COARSER) * bare.seconds, run.memory

    def comparing(self, resolution: int) -> float:
        """Additional time to march, to compare and to draw, as `fem.Cost` counts it [s]."""
        scene, taken = self.scene, DRAWN
        if marched := not scene.is_self_similar:
            faster = scene.fastest_speed / scene.material.shear_speed / 2
            taken += MARCHED * (resolution / 100 * faster) ** MARCH_POWER
        seconds, _ = self.at(resolution)
        without = marched and not isinstance(scene.load, Tractions)  # such marches have no fields
        if not self.snapshots or math.isinf(seconds) or without:
            return taken
        bare, _ = replace(self, snapshots=False).at(resolution)
        times = JUDGED_MARCH * (USUAL / resolution) ** 0.8 if marched else JUDGED
        return taken + times * (seconds - bare)

    def here(self, resolution: int) -> tuple[float, float]:
        """Time of a comparison on this machine [s] and memory [bytes], extrapolated from a mesh
        that is allowed where one of this resolution is too large."""
        seconds, memory = self.at(resolution)
        if math.isfinite(seconds) or resolution <= LEAST:
            return self.pace * (seconds + self.comparing(resolution)), memory
        seconds, memory = self.here(resolution // 2)
        return 2**3 * seconds, 2**2 * memory

    def unseen(self, feature: Feature) -> Unseen:
        """Return the resolution, time and memory that it would take to see a feature."""
        size = _at_least_usual(feature.resolution)
        return Unseen(*feature, *self.here(size), math.isfinite(self.at(size)[0]))


def choose_mesh(
    prediction: Answer | None,
    scene: Scene,
    end_time: float | None = None,
    budget: float | None = None,
    *,
    resolution: int | None = None,
    snapshots: bool = False,
    memory: float | None = None,
    **options: Any,
) -> MeshChoice:
    """Choose the mesh to compare a prediction on, before anything is simulated.

    It is just fine enough for the narrowest slip zone, opening, gap or weakening front that the
    budget reaches.  If the budget reaches none of them, the mesh is as fine as a budget that was
    given allows.  It is not coarser than a resolution of 100 unless budget or memory force that.

    Parameters
    ----------
    prediction : Answer or None
        Prediction of a self-similar scene, which gives its zones and gaps; None if there is none
        yet.
    scene, end_time
        As in `fem.simulate`.
    budget : float, optional
        Time that the simulation, its companions and the comparison may take on this machine [s].
        The default is 20 s of simulations as `fem.Cost` counts them, or the time that a resolution
        of 100 takes if that is longer.
    resolution : int, optional
        Resolution to take, whatever the budget.
    snapshots : bool
        Whether field snapshots are written.
    memory : float, optional
        Largest memory of the simulation [bytes]; the default is 70 % of what is available.
    **options
        Other fields of `fem.Settings`.

    Returns
    -------
    MeshChoice

    Raises
    ------
    SceneError
        If an option is out of range, or budget or memory do not reach the coarsest mesh that
        follows the loads.
    """
    from fem.settings import Settings

    if options.get("damping") is None:
        upper, lower = scene.bodies
        usual = CALMING if upper != lower and scene.coefficient > ROUGH else QUIETING
        options["damping"] = usual if short_waves_grow(scene) else Settings.damping
    prices = Prices(scene, end_time, snapshots, options)
    end_time = 1 / scene.material.shear_speed if end_time is None else end_time
    end_time = checked_size("simulate: end_time", end_time)
    loads = _loads(scene, end_time)
    features = [*_narrow(prediction, end_time), *_of_scene(scene, end_time)]
    features.sort(key=lambda feature: feature.resolution)
    reason = "as given"
    if resolution is None:
        affordable = _limits(prices, budget, memory)
        least = _whole(max([LEAST, *loads.values()]))
        if not affordable(least):
            size = min(least, USUAL)
            seconds = prices.checked(size, memory)[0] + prices.comparing(size)  # or `fem` raises
            raise SceneError(
                f"compare: the coarsest mesh there is to choose, resolution {least}, takes "
                f"{duration(prices.pace * seconds)}; raise `budget`, or give a `resolution`."
            )
        bars = [
            Feature(BARS.format(name), size * needed)
            for name, needed in loads.items()
            for size in COARSER
        ]
        resolution, reason = _chosen(features + bars, least, affordable, spend=budget is not None)
    prices.checked(resolution)  # raises if a given one cannot be simulated
    bare = replace(prices, snapshots=False)
    unresolved = tuple(bare.unseen(part) for part in features if part.resolution > resolution)
    needed = unresolved[-1].resolution if unresolved else resolution
    damping = options["damping"]
    return MeshChoice(resolution, reason, needed, *prices.here(resolution), unresolved, damping)


def short_waves_grow(scene: Scene) -> bool:
    """Return whether waves along a sliding interface may grow in proportion to their wave number:
    between different bodies, and under friction that falls with slip rate."""
    upper, lower = scene.bodies
    return scene.coefficient > 0 and (upper != lower or scene.law.fall_with_rate > 0)


def toll(seconds: float, memory: float) -> str:
    """Time and memory in words."""
    return f"{duration(seconds)}, {two_digits(memory / GIGABYTE)} GB"


def duration(seconds: float) -> str:
    """Time in words, in a unit that suits its length."""
    if seconds > LONGEST:
        return f"more than {two_digits(LONGEST / YEAR)} years"
    for unit, length, least in (("years", YEAR, 2), ("days", 86400.0, 4), ("hours", 3600.0, 1.5)):
        if seconds >= least * length:
            return f"{two_digits(seconds / length)} {unit}"
    return f"{two_digits(seconds / 60)} minutes" if seconds >= 90 else f"{two_digits(seconds)} s"


def _narrow(prediction: Answer | None, end_time: float) -> Iterator[Feature]:
    """Slip zones, openings and gaps between two zones of one sense of a self-similar prediction.

    Two zones of opposite sense, or with an opening in between, are distinct without a gap.
    """
    if prediction is None or not prediction.scene.is_self_similar:
        return
    length = prediction.scene.material.shear_speed * end_time
    zones, openings = prediction.zones_at(end_time), prediction.openings_at(end_time)
    parts = [("zone", zone.start, zone.end) for zone in zones]
    parts += [("opening", part.start, part.end) for part in openings]
    parts += [
        ("gap", zone.end, other.start)
        for zone, other in pairwise(zones)
        if zone.sense == other.sense
        and not any(zone.start < part.start < other.start for part in openings)
    ]
    for kind, start, end in parts:
        width = (end - start) / length
        if 0 < width < math.inf:
            digits = max(4, math.ceil(-math.log10(width)))
            name = f"{start / length:.{digits}f} and {end / length:.{digits}f} c_t"
            yield Feature(f"the {kind} between {name}", math.ceil(NARROW / width))


def _of_scene(scene: Scene, end_time: float) -> Iterator[Feature]:
    """Front of slip weakening, and shear waves of a slower lower body, if the scene has them."""
    from fem.resolution import LEAST_CROSSED, WEAKENING_ELEMENTS

    width = process_zone(scene) / (scene.material.shear_speed * end_time)
    if width < math.inf:
        name = f"the weakening front, {width:.2g} c_t T long"
        yield Feature(name, math.ceil(WEAKENING_ELEMENTS / width))
    upper, lower = scene.bodies
    if lower.shear_speed < upper.shear_speed:
        ratio = lower.shear_speed / upper.shear_speed
        yield Feature("shear waves of the slower body", math.ceil(LEAST_CROSSED / ratio))


def _loads(scene: Scene, end_time: float) -> dict[str, int]:
    """Least resolution that follows each load; `fem` refuses loads that no mesh follows."""
    from fem.resolution import needed_resolution

    return {
        name: needed_resolution(history, end_time, end_time) or 1
        for name, history in scene.acting_histories.items()
    }


def _limits(prices: Prices, budget: float | None, memory: float | None) -> Callable[[int], bool]:
    """Return a function that says whether a resolution is within budget and memory."""
    room = memory_limit(memory) * (SPARE if memory is None else 1)
    if budget is None:
        known = (DEFAULT_BUDGET, prices.at(USUAL)[0], prices.at(LEAST)[0])
        time = max(seconds for seconds in known if math.isfinite(seconds))
    else:
        time = checked_size("compare: budget", budget) / prices.pace

    def affordable(resolution: int) -> bool:
        seconds, taken = prices.at(resolution)
        if budget is not None:
            seconds += prices.comparing(resolution)
        return seconds <= time and taken <= room

    return affordable


def _chosen(
    wishes: list[Feature], least: int, affordable: Callable[[int], bool], *, spend: bool
) -> tuple[int, str]:
    """Finest resolution that is needed and affordable, and the reason; see `choose_mesh`."""
    base = max(USUAL, least)
    if not affordable(base):
        return _finest(affordable, least, base, STRIDE), WITHIN
    beyond = sorted((_whole(size), name) for name, size in wishes if size > base)
    reached = [(size, f"for {name}") for size, name in beyond if affordable(size)]
    if reached:
        return reached[-1]
    if beyond and spend:
        return _finest(affordable, base, beyond[0][0], ROUND_STRIDE), WITHIN
    return base, "the usual one" if beyond else "nothing asks for a finer one"


def _finest(affordable: Callable[[int], bool], low: int, high: int, stride: int) -> int:
    """Largest affordable of low, low + stride, ... below high; low if none is affordable."""
    steps, beyond = 0, math.ceil((high - low) / stride)
    while beyond - steps > 1:
        middle = (steps + beyond) // 2
        steps, beyond = (middle, beyond) if affordable(low + middle * stride) else (steps, middle)
    return low + steps * stride


def _at_least_usual(resolution: int) -> int:
    """A whole resolution from this one and the usual one on."""
    return _whole(max(resolution, USUAL))


def _whole(resolution: int) -> int:
    """Next resolution from this one on that gives each companion a whole resolution."""
    return STRIDE * math.ceil(resolution / STRIDE)


def two_digits(value: float) -> str:
    """Positive number to two significant digits, written in full."""
    return f"{float(f'{value:.2g}'):,g}"
