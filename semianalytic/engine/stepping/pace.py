"""How the histories of loads pace a run: how long steps may be, and how many nodes follow them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np

from semianalytic.dissimilar.kernels import pair_of
from semianalytic.engine.stepping.fronts import ActingFront, acting_loads
from semianalytic.scene.arrays import Array
from semianalytic.scene.line.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.loads import LoadHistory
from semianalytic.scene.scene import Scene
from semianalytic.scene.tabulated import Tabulated

TURN_RATIO = 0.5
"""Steps c_t dt / h by which turns of loads are measured, whatever the steps of a march."""


class LoadWindow(NamedTuple):
    """A time in which a load changes all along, and the longest step that follows it [time]."""

    begin: float
    end: float
    longest: float


class LoadPace:
    """The longest steps that do not pass over what loads do.

    Steps end at jumps of loads in any case.  A kink of a history should lie in a step of the
    shortest length, because the load may come and go between it and the next one.  A load that is a
    function of time, or of x and t, is looked at 1001 times; a step passes over a
    tenth of its range at most, up and down counted.

    Parameters
    ----------
    scene : Scene
        The loads are its own.
    x : (n,) array
        Nodes, which lie at equal distances [length].
    end_time : float
        Time until which functions are looked at [time].
    """

    def __init__(self, scene: Scene, x: Array, end_time: float) -> None:
        self._loads, self._x = acting_loads(scene), x
        self._times = _sample_times(end_time)
        spacing = float(x[1] - x[0])
        self._breaks: list[float] = []
        self._windows: list[LoadWindow] = []
        for load, history in _histories(self._loads):
            breaks = history.pieces.breaks
            first, last = breaks[0], breaks[-1]
            waves = [1 / wave.frequency for wave in history.pieces.waves]
            if waves and not _rests(history, last, min(waves)):
                last = math.inf
            slowness = load.slowness if isinstance(load, ActingFront) else 0.0
            if slowness:
                # the front passes all nodes of a period one after the other
                assert isinstance(load, ActingFront)
                ends = slowness * (np.array([-0.5, 0.5]) * scene.period - load.at)
                first, last = first + float(ends.min()), last + float(ends.max())
                self._windows.append(LoadWindow(first, last, abs(slowness) * spacing))
            else:
                self._breaks += breaks
            if waves:
                # Slip rate of a slow interface under a harmonic is off by 3e-4, with 32 steps a
                # period by 2e-4; with 8 steps are repeated.
                self._windows.append(LoadWindow(first, last, min(waves) / 16))
        self._breaks.sort()

    def longest(self, time: float) -> float:
        """Return the longest step that may begin at a time [time]; inf if loads set no bound."""
        following = bisect_right(self._breaks, time)
        longest = math.inf
        if following < len(self._breaks):
            longest = self._breaks[following] - time
        for begin, end, step in self._windows:
            if begin <= time < end:
                longest = min(longest, step)
            elif time < begin:
                longest = min(longest, begin - time)
        for passed in self._passed:
            # Three loads on a quiet fault leave slip off by 99, 9 and 8 % without this bound, by
            # 0.02, 0.04 and 0.7 % with 0.1; 0.05 gains nothing.
            enough = float(np.interp(time, self._times, passed)) + 0.1
            if enough < passed[-1]:
                # the variation rises from sample to sample, so that the first one beyond decides
                after = int(np.searchsorted(passed, enough))
                sides = slice(after - 1, after + 1)
                longest = min(
                    longest, float(np.interp(enough, passed[sides], self._times[sides])) - time
                )
        return longest

    @cached_property
    def _passed(self) -> list[Array]:
        """Variation of each function until each sample, over its range, (1001,).

        It is found when it is first asked for: steps that are as short as they can be do not.
        """
        found = []
        for load in self._loads:
            if not isinstance(load, InterfaceLoad):
                continue
            if load.is_timed:
                found.append(_variation(map(np.asarray, map(load.factor, self._times.tolist()))))
            elif load.history is None:
                found += [
                    _variation(load.traction(self._x, t, of=of) for t in self._times.tolist())
                    for of in ("shear", "pressure")
                    if load.acts(of)
                ]
        return [passed for passed in found if passed[-1] > 0]


def _variation(samples: Iterable[Array]) -> Array:
    """Return the largest variation at a node up to each sample (n,), over the largest range."""
    rows = iter(samples)
    before = low = high = next(rows)
    steps = [0.0]
    for row in rows:
        steps.append(float(np.abs(row - before).max()))
        before, low, high = row, np.minimum(low, row), np.maximum(high, row)
    size = float((high - low).max())
    return np.cumsum(steps) / size if 0 < size < math.inf else np.zeros(len(steps))


def in_fours(nodes: float) -> int:
    """Return the least multiple of 4, as grids have them, that is no less than a number."""
    return 4 * math.ceil(nodes / 4)


def nodes_for_contact(scene: Scene) -> float:
    """Return how many nodes of a period resolve the narrowest contact or slot."""
    # Mean slip of a contact pushed from both sides is 9, 6, 0.3 and 0.1 % off with 2, 4, 8 and 16
    # nodes.
    return 8 * scene.period / scene.contact.narrowest(scene.period)


def _follows(history: LoadHistory, step: float, latest: float) -> bool:
    """Return whether a history turns slowly enough for steps h / (2 c_t) of this length [time]."""
    # Largest turn of a load within 1 and 4 such steps: frictional work is then off by 1 to 3 %.
    return all(
        history.turn(steps * step, latest) <= allowed for steps, allowed in ((1, 0.08), (4, 0.32))
    )


def longest_following(history: LoadHistory, step: float, latest: float) -> float:
    """Return the longest step h / (2 c_t), up to `step`, that follows a history until `latest`.

    It is found to 0.1 %, and 0 if the history reverses instantaneously.
    """
    if _follows(history, step, latest):
        return step
    # Bisect: sixteenths until one is short enough, then halves of the interval.
    enough, lacking = 0.0, step
    for _ in range(50):  # they end at 0.1 %
        middle = lacking / 16 if enough == 0 else (enough + lacking) / 2
        enough, lacking = (
            (middle, lacking) if _follows(history, middle, latest) else (enough, middle)
        )
        if enough > 0.999 * lacking:
            break
    return enough


def nodes_for_histories(scene: Scene, end_time: float) -> float:
    """Return how many nodes of a period follow the histories of all loads; inf if none do.

    A grid of node distance h follows a history that turns no more than `march` allows within steps
    h / (2 c_t) of the slower body.  A function of time is sampled 1001 times.
    """
    pair = pair_of(scene)
    speed = scene.material.shear_speed if pair is None else pair.speed
    most = TURN_RATIO * scene.period / speed  # step times nodes
    given = [history for _, history in _histories(scene.loads)]
    for load in scene.loads:
        if isinstance(load, InterfaceLoad) and load.is_timed:
            given.append(_sampled(load, end_time))
    needed = 1.0
    for history in given:
        needed = nodes_following(history, most, end_time, needed)
    return needed


def nodes_following(history: LoadHistory, most: float, latest: float, least: float) -> float:
    """Return how many nodes, `least` or more, follow a history until a time; inf if none do.

    `most` is the longest step h / (2 c_t) times the number of nodes [time].
    """
    step = longest_following(history, most / least, latest)
    return max(least, most / step) if step else math.inf


def _sampled(load: InterfaceLoad, end_time: float) -> LoadHistory:
    """Return samples of a history that is a function of time, as a table."""
    times = _sample_times(end_time).tolist()
    return Tabulated(tuple(times), tuple(map(load.factor, times)))


def _sample_times(end_time: float) -> Array:
    """Return the times at which functions are looked at, (1001,) [time]."""
    return np.linspace(0.0, end_time, 1001)  # a wave of 60 periods has 16 of them in each


def _histories(
    loads: Iterable[InterfaceLoad | FrontLoad],
) -> Iterator[tuple[InterfaceLoad | FrontLoad, LoadHistory]]:
    """Yield the loads that have a `LoadHistory`, and these; one without pieces is always 0."""
    for load in loads:
        if isinstance(load.history, LoadHistory) and load.history.pieces.breaks:
            yield load, load.history


def _rests(history: LoadHistory, time: float, period: float) -> bool:
    """Return whether a history keeps its value after its last break, its waves having ended."""
    # samples at such parts of a period that no wave has the same value at all of them
    values = history.value(time + period * np.array([0.0, 0.13, 0.29, 0.41]))
    return bool(np.ptp(values) <= 1e-9 * max(float(np.abs(values).max()), 1.0))
