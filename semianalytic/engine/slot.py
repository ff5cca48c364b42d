"""The contact next to a slot on the mirrored line that suits it: its loads, friction and memory."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from semianalytic.engine.loads import FrontPressure, GridPressure, front_of
from semianalytic.engine.nodes import ContactGrid, SlotLayout
from semianalytic.engine.stepping.advance import CUT, Span, reached_at
from semianalytic.engine.stepping.balance import Balance
from semianalytic.engine.stepping.blocks import ClosedLine, EqualSteps, Level
from semianalytic.engine.stepping.state import State
from semianalytic.memory.line_memory import LineMemory
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import TensionError
from semianalytic.scene.scene import Scene

SINGLE_SIZE = 4096
"""Nodes up to which all of the memory has single precision: slip rates change by 5e-6 of
themselves.  Beyond, the lowest eighth of wavenumbers has double precision: they change by 3e-8."""
SINGLE_RATES = 1e-20, 1e20
"""Slip rates [length / time] within single precision, 1e-38 to 3e38, with all their sums."""


class SlotLine(ClosedLine):
    """The contact next to a slot, on half of a line that is even about both of its ends.

    Parameters
    ----------
    scene : Scene
        What is marched.
    nodes : ContactGrid
        Nodes of slot and contact.
    layout : SlotLayout
        Memory and steps.
    since : float
        Time from which the march goes on [time].
    """

    means_last, climbs, is_cut = True, False, False
    unilateral, settings = None, dict[str, float]()
    fields = "slip", "slip_rate", "shear_traction", "pressure", "gap"

    def __init__(self, scene: Scene, nodes: ContactGrid, layout: SlotLayout, since: float) -> None:
        self.scene, self.nodes, self.layout = scene, nodes, layout
        self.damping, self.kept = layout.damping, nodes.contact
        self.grid, self.law, self.jumps = nodes.line, scene.law, scene.jumps
        self.impedance = scene.material.shear_impedance / 2
        self.speed = scene.material.shear_speed
        self.touching = np.ones(nodes.observed, dtype=bool)
        on = np.arange(nodes.size) >= nodes.slot
        self.balance = Balance(self.law, self.impedance, on, self.grid, falls=True)
        # rates of units that are far from 1 would leave the range of single precision
        sizes = [max(abs(load.pressure), abs(load.shear)) for load in scene.superposition]
        usual = SINGLE_RATES[0] < max(sizes) / self.impedance < SINGLE_RATES[1]
        double = 0 if nodes.size <= SINGLE_SIZE else nodes.size // 8
        double = double if usual else nodes.size
        self.memory = LineMemory(layout.kernel, self.grid.wavenumbers, double=double)
        # what the history adds to the shear of the uncut line, and of slot faces: Q_b - Q_0 f
        load, self._base = scene.superposition.taken_off.shear, scene.before_load.shear
        self._shares = (load, 0.0) if scene.arrives else (0.0, -load)
        self._front = front_of(scene, nodes, layout.entry) if scene.front_slowness else None
        # the steps are those of a march until `latest`, wherever it stops and goes on
        self._spans = spans_until(scene, nodes, layout)
        finest = layout.stride * min(span.step for span in self._spans)
        self._pressure: GridPressure | FrontPressure
        if self._front is not None and scene.superposition.taken_off.pressure:
            self._pressure = FrontPressure(scene, nodes, layout, self._front, finest, since)
        else:
            count = nodes.size - nodes.slot
            self._pressure = GridPressure(scene, count, nodes.spacing, layout.latest, finest)
        self.steady = {"gap": np.zeros(nodes.observed)}  # a march ends where the contact would open
        if not scene.superposition.taken_off.pressure:
            self.steady["pressure"] = self.after(since, finest).pressure[: nodes.observed]

    def begin(self) -> State:
        """Return the state at rest, before the load comes."""
        none, rest = np.zeros(self.nodes.observed), np.zeros(self.nodes.size - self.nodes.slot)
        rate = np.zeros(self.nodes.size)
        now = self.layout.begins, rate, rest, rest, rest, rest, rest
        return State(none, none, none, none, none, *now)

    def jump(self, now: State) -> State:
        """Return the state after loads have jumped, with the memory as it is."""
        step = next(span.step for span in self._spans if span.stop > now.time)
        level = self.after(now.time, self.layout.stride * step)
        blocks = EqualSteps(self, reached_at(now), 2)
        blocks.jump(level)
        return replace(now, **vars(blocks.reached) | {"pressure": level.pressure})

    def every_memory(self) -> list[LineMemory]:
        """Return the memory of slip."""
        return [self.memory]

    def spans(self, time: float, end_time: float) -> list[Span]:
        """Return the spans from a level on until a pair of steps reaches the end [time]."""
        stride, spans = self.layout.stride, spans_to(self._spans, time, end_time)
        return [span._replace(step=stride * span.step) for span in spans]

    def levels(self, ends: list[float], steps: list[float]) -> Iterator[Level]:
        """Yield the ends of steps, with the pressure checked where loads change it."""
        changes = self.scene.superposition.taken_off.pressure != 0
        loads = self._means(np.array(ends), np.array(steps))
        pressures = self._pressure.over(np.array(ends), steps)
        for end, step, load, pressure in zip(ends, steps, loads, pressures, strict=True):
            if changes:
                self._check(end, pressure)
            yield self._level(end, step, load, pressure)

    def after(self, time: float, step: float) -> Level:
        """Return a level just after loads have jumped, or at which the march goes on."""
        load = self.scene.shear_history.value(math.nextafter(time, math.inf))
        pressed = self._pressure
        now = pressed.now() if isinstance(pressed, FrontPressure) else pressed.after(time)
        return self._level(time, step, float(load), now)

    def _level(self, time: float, step: float, load: float, pressure: Array) -> Level:
        """Return a level under the history of the shear load, and a contact pressure."""
        if self._front is not None:
            return Level(time, step, *self._front("shear", time, step), pressure)
        line, faces = self._shares
        return Level(time, step, self._base + line * load, self._base + faces * load, pressure)

    def _means(self, ends: Array, steps: Array) -> list[float]:
        """Return the history of the shear load at the ends of steps, (k,); before it at a jump.

        Where several breaks of the history lie within the step around an end, it is the exact mean
        over that step.
        """
        history = self.scene.shear_history
        values, breaks, half = history.value(ends), np.array(history.pieces.breaks), steps / 2
        for stop in (*self.jumps, self.layout.latest):  # beyond which no mean is taken
            half = np.minimum(half, np.abs(ends - stop))
        within = np.searchsorted(breaks, ends + half) - np.searchsorted(breaks, ends - half)
        # Values at the levels represent one kink, but not several.
        if (several := within >= 2).any():
            means = history.mean((ends - half)[several], (ends + half)[several])
            values = np.array(values)
            values[several] = means
        return np.asarray(values).tolist()

    def _check(self, time: float, pressure: Array) -> None:
        """Raise an error if the contact would open or friction weakens too fast."""
        node = int(np.argmin(pressure))
        if pressure[node] < 0:
            solved = self.scene.is_self_similar and isinstance(self.scene.friction, float)
            raise TensionError(
                f"the pressure would turn tensile at x = {(node + 0.5) * self.grid.spacing:.4g}, "
                f"t = {time:.4g}; raise the base pressure, {'use `solve`, ' if solved else ''}"
                "or simulate the scene with finite elements (docs/limits.md)."
            )
        self.scene.check_weakening(float(pressure.max()))


def spans_until(scene: Scene, nodes: ContactGrid, layout: SlotLayout) -> list[Span]:
    """Return the spans between jumps of the loads until the latest time, in pairs of equal steps.

    The end of each pair is a level of the companion as well, whose steps are twice as long.
    """
    # a march that begins with a load far along the slot is recorded from t = 0 on at the latest
    at = {0.0, *scene.jumps, layout.latest}
    stops = sorted(time for time in at if layout.begins < time <= layout.latest)
    longest = layout.step_ratio * (nodes.spacing / layout.stride) / scene.material.shear_speed
    return [
        Span(begin, stop, (stop - begin) / (2 * max(1, math.ceil((stop - begin) / longest / 2))))
        for begin, stop in pairwise([layout.begins, *stops])
    ]


def spans_to(spans: list[Span], reached: float, end: float) -> list[Span]:
    """Return the spans from a level on until a pair of steps reaches the end [time]."""
    found = list[Span]()
    for begin, stop, step in spans:
        pairs = math.ceil((end - begin) / (2 * step) - CUT)
        if stop > reached and pairs > 0:
            last = begin + 2 * step * pairs < stop - step
            found.append(Span(begin, begin + 2 * step * pairs if last else stop, step))
    return found
