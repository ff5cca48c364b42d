"""The time levels of a march, in segments between jumps of the loads."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.scenes.loads import FrontPressure, GridFront, GridPressure
from semianalytic.engine.stepping.blocks import Level
from semianalytic.scene.errors import TensionError
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Segment:
    """A span of time from `begin` to `end` [time] without load jumps, in an even number of steps.

    Every second level is then one of the companion as well.  A march may take those from the level
    `first` to the level `last` alone.
    """

    begin: float
    end: float
    whole: int
    first: int
    last: int

    @property
    def steps(self) -> int:
        """Number of steps that are taken."""
        return self.last - self.first

    @property
    def time_step(self) -> float:
        """Length of one step [time]."""
        return (self.end - self.begin) / self.whole

    @property
    def levels(self) -> Array:
        """Begin and end of all steps of the span, (whole + 1,) [time]."""
        # the end is taken as it is: a jump there has to fall on the level to the last digit
        return np.append(self.begin + self.time_step * np.arange(self.whole), self.end)

    @property
    def start(self) -> float:
        """Time of the level `first` [time]."""
        return float(self.levels[self.first])

    @property
    def halved(self) -> Segment:
        """The same steps for a companion, whose levels are every second one."""
        return replace(self, whole=self.whole // 2, first=self.first // 2, last=self.last // 2)

    def between(self, start: float, end: float) -> Segment:
        """Return the steps from a level on until an even level reaches the end [time]."""
        # times that are rounded count as their level
        pairs = (math.ceil((at - self.begin) / (2 * self.time_step) - 1e-9) for at in (start, end))
        first, last = (min(max(2 * pair, 0), self.whole) for pair in pairs)
        return replace(self, first=first, last=last)


def segments_between(
    scene: Scene, start: float, end: float, step_ratio: float, spacing: float
) -> list[Segment]:
    """Divide the time from `start` to `end` at the load jumps, in steps c_t dt <= step_ratio h.

    Parameters
    ----------
    scene : Scene
        Its load histories determine the jumps, its material the shear wave speed.
    start, end : float
        First and last time [time].
    step_ratio : float
        Largest c_t dt / h.
    spacing : float
        Node distance h [length].
    """
    # a march that begins with a load far along the slot is recorded from t = 0 on at the latest
    ends = [start, *(at for at in {0.0, *load_jumps(scene)} if start < at < end), end]
    ends.sort()
    speed, largest = scene.material.shear_speed, step_ratio * spacing
    found = []
    for begin, until in pairwise(ends):
        count = 2 * max(1, math.ceil(speed * (until - begin) / largest / 2))
        found.append(Segment(begin, until, count, 0, count))
    return found


def load_jumps(scene: Scene) -> list[float]:
    """Return the times at which a load jumps, in increasing order [time].

    Jumps of a load whose front moves come to each node in turn.
    """
    if scene.front_slowness:
        return []
    histories = scene.acting_histories.values()
    return sorted({at for history in histories for at, _ in history.pieces.jumps})


def levels_of(
    scene: Scene,
    segment: Segment,
    pressure: GridPressure | FrontPressure,
    front: GridFront | None,
) -> Iterator[Level]:
    """Yield the levels of a segment; raise as `_check` does where loads change the pressure.

    At a jump, the first level takes the shear load just after it and the last one that before it.
    """
    taken, step = slice(segment.first, segment.last + 1), segment.time_step
    times = segment.levels[taken]
    # the slot carries Q_b - Q_0 f
    loads, uncut = _shear_loads(scene, segment.levels)[taken], scene.superposition.in_place.shear
    arrives, kept = scene.arrives, scene.before_load.shear
    changes = scene.superposition.taken_off.pressure != 0
    for now, load, on_contact in zip(times.tolist(), loads, pressure.over(times), strict=True):
        if changes and now > times[0]:
            _check(scene, now, on_contact, pressure.spacing)
        if front is not None:
            yield Level(now, step, *front.tractions("shear", now, step), on_contact)
        elif arrives:
            yield Level(now, step, kept + load, kept, on_contact)
        else:
            yield Level(now, step, uncut, uncut - load, on_contact)


def _shear_loads(scene: Scene, levels: Array) -> Array:
    """Return Q_0 f at evenly spaced levels (n,) [stress].

    At a jump the value is that before it, but at the first level that after it.  Where several
    breaks of the history lie within the step around a level, the exact mean over that step is
    taken (docs/spacetime.md, "Resolution of the grid").
    """
    history = scene.shear_history
    loads, breaks = history.value(levels), np.array(history.pieces.breaks)
    loads[0] = history.value(math.nextafter(levels[0], math.inf))
    half = (levels[-1] - levels[0]) / (2 * (len(levels) - 1))
    inner = levels[1:-1]
    held = np.searchsorted(breaks, inner + half) - np.searchsorted(breaks, inner - half)
    means = history.mean(inner - half, inner + half)
    # Values at the levels represent one kink, but not several.
    loads[1:-1] = np.where(held >= 2, means, loads[1:-1])
    return np.asarray(scene.superposition.taken_off.shear * loads)


def _check(scene: Scene, time: float, pressure: Array, spacing: float) -> None:
    """Raise an error if the contact would open or friction weakens too fast under a pressure."""
    node = int(np.argmin(pressure))
    if pressure[node] < 0:
        solved = scene.is_self_similar and isinstance(scene.friction, float)
        raise TensionError(
            f"the pressure would turn tensile at x = {(node + 0.5) * spacing:.4g}, "
            f"t = {time:.4g}; raise the base pressure, {'use `solve`, ' if solved else ''}"
            "or simulate the scene with finite elements (docs/limits.md)."
        )
    scene.check_weakening(float(pressure.max()))
