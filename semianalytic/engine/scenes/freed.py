"""How the faces of a slot move beside a contact whose motion a march has found.

A march beside a slot is long enough for its contact to see no mirror image.  In the bodies behind
the edge the slot matters on twice that length.  With the slip of the contact given, the faces of a
longer slot are free, and step on their own; so they do under pressure, where a closed contact does
not open.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.bodies.marched_bodies import MarchedBodies, singular_edges
from semianalytic.engine.bodies.motion import Motion, MotionRecord
from semianalytic.engine.scenes.loads import SWEEPS, TOLERANCES, front_of
from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.nodes import ContactGrid
from semianalytic.engine.scenes.slot import load_jumps, spans_to, spans_until
from semianalytic.engine.stepping.advance import through
from semianalytic.engine.stepping.blocks import ClosedLine, EqualSteps, Level, Reached
from semianalytic.memory.exponentials import Memory, fit_memory
from semianalytic.memory.impedance import Opening
from semianalytic.memory.line_memory import LineMemory

Array = NDArray[np.float64]
Given = Callable[[Array, bool], Array]
"""Rates of the contact nodes, or of all alike, at times (k,), just after jumps or not, (k, n)."""

MARGIN = 1.05
"""How far behind the edge fields are known, over the distance that waves travel."""


class _Known:
    """Law and local problem of `EqualSteps` where the contact moves as it is known to."""

    follows_state = False

    def __init__(self, slot: int, impedance: float) -> None:
        self._slot, self._impedance = slot, impedance
        self.on = slice(slot, None)

    def closed(
        self,
        stopping: Array,
        on_slot: Array | float,
        state: Array,
        given: Array,
        out: Array,
        means: bool = True,
    ) -> None:
        """Write the rate (n,) of all nodes."""
        out[self.on] = given
        out[: self._slot] = (stopping[: self._slot] - on_slot) / self._impedance

    def strength(self, speed: Array, state: Array, given: Array) -> float:
        """Return that the given motion does no work."""
        return 0.0

    def turn(self, *_: object) -> None:
        """Do nothing at a new level."""

    forget = recall = turn


class FreeSlot(ClosedLine):
    """The line beside a slot with given rates of its contact: of slip, or of an opening of none."""

    sweeps = SWEEPS

    def __init__(
        self,
        marched: Marched,
        grid: ContactGrid,
        name: Literal["pressure", "shear"],
        kernel: Memory,
        impedance: float,
        given: Given,
    ) -> None:
        self._scene, self._slot, self._name, self._given = marched.scene, grid.slot, name, given
        self.grid, self.kept, self.damping = grid.line, grid.contact, marched.damping
        self.speed, self.impedance = marched.scene.material.shear_speed, impedance
        self.law: Any = _Known(grid.slot, impedance)
        self.balance: Any = self.law
        self.memory, self.jumps = LineMemory(kernel, self.grid.wavenumbers), load_jumps(self._scene)
        moves = self._scene.front_slowness
        self._front = front_of(self._scene, grid, marched.entry) if moves else None

    def levels(self, ends: list[float], steps: list[float]) -> Iterator[Level]:
        """Yield the ends of steps (`ClosedLine.levels`), with given rates as pressures."""
        for end, step, rates in zip(ends, steps, self._given(np.array(ends), False), strict=True):
            yield self._level(end, step, end, rates)

    def after(self, time: float, step: float) -> Level:
        """Return a level just after loads have jumped (`ClosedLine.after`)."""
        rates = self._given(np.array([time]), True)[0]
        return self._level(time, step, math.nextafter(time, math.inf), rates)

    def _level(self, time: float, step: float, since: float, rates: Array) -> Level:
        """Return a level under the loads of a time."""
        if self._front is not None:
            return Level(time, step, *self._front(self._name, time, step), rates)
        scene, name = self._scene, self._name
        history = getattr(scene, f"{name}_history")
        load = getattr(scene.superposition.taken_off, name) * float(history.value(since))
        return Level(time, step, load, 0.0, rates)


def bodies_beside_slot(marched: Marched) -> MarchedBodies:
    """Return the bodies of a march beside a slot."""
    scene, solid, speed = marched.scene, marched.scene.material, marched.scene.fastest_speed
    if marched.entry and not scene.front_too_slow:  # no wave may tell where the load begins
        marched = replace(marched, entry=(1 + MARGIN) * marched.entry)
    grid, own = _longer(marched), _slip(marched)
    parts = [FreeSlot(marched, grid, "shear", marched.memory, solid.shear_impedance / 2, own)]
    if scene.superposition.taken_off.pressure:
        kernel = Opening(solid.shear_speed / solid.longitudinal_speed)
        tolerance = min(max(marched.memory.error, 2 * TOLERANCES[0]), TOLERANCES[1])
        memory = fit_memory(kernel, marched.memory.horizon, tolerance)
        stiff = solid.density * solid.longitudinal_speed / 2
        parts.append(FreeSlot(marched, grid, "pressure", memory, stiff, _none))
    slip, *closing = (_moved(marched, part) for part in parts)
    opening = -closing[0].slip if closing else np.zeros((len(slip.slip), 0), np.float32)
    both = (np.concatenate([one[:, ::-1], one], axis=1) for one in (slip.slip, opening))
    motion, spacing = Motion(slip.t, *both), grid.spacing
    first, centre = (0.5 - grid.slot - grid.size) * spacing, -grid.slot * spacing
    edges = tuple(singular_edges(scene, motion, first, spacing))
    far = MARGIN * speed * marched.end_time
    known = marched.interface.x
    ends = (-far, (grid.size - grid.slot) * spacing), spacing, float(known[-1] + known[0])
    return MarchedBodies(scene, motion, first, spacing, edges, centre, *ends)


def _longer(marched: Marched) -> ContactGrid:
    """Return the nodes of a march with a slot so long that no mirror image is seen behind it."""
    from scipy.fft import next_fast_len

    scene, grid, speed, end = (
        marched.scene,
        marched.grid,
        marched.scene.fastest_speed,
        marched.end_time,
    )
    length = (1 + MARGIN) / 2 * speed * end
    if scene.front_slowness < 0:  # a front that outruns the waves meets its mirror image
        length = max(length, (1 + MARGIN) * end / (1 / speed - scene.front_slowness))
    elif marched.entry:
        lasts = scene.front_too_slow * speed * (end - marched.begins)
        length = max(length, marched.entry + lasts)
    contact = grid.size - grid.slot
    slot = max(grid.slot, math.ceil(length / grid.spacing) + 8)
    size = next_fast_len(contact + slot, real=True)
    return ContactGrid(grid.spacing, size - contact, grid.observed, size)


def _none(times: Array, after: bool) -> Array:
    """Return that nothing opens on the contact."""
    return np.zeros((len(times), 1))


def _slip(marched: Marched) -> Given:
    """Return the slip rates of the contact that a march has found, those of its end beyond."""
    known = marched.interface
    beyond = marched.grid.size - marched.grid.slot - marched.grid.observed

    def given(times: Array, after: bool) -> Array:
        rows = np.clip(
            np.searchsorted(known.t, times, side="right" if after else "left"), 1, len(known.t) - 1
        )
        begin, end = known.t[rows - 1], known.t[rows]
        share = np.clip((times - begin) / (end - begin), 0.0, 1.0)[:, None]
        before, last = known.slip_rate[rows - 1], known.slip_rate[rows]
        if after:  # what is stored is the rate before a jump; the slip of the step tells that after
            moved = (known.slip[rows] - known.slip[rows - 1]) / (end - begin)[:, None]
            before = np.where(times[:, None] > known.t[0], 2 * moved - last, before)
        rates = before + share * (last - before)
        rates[times < known.t[0]] = 0.0
        return np.pad(rates, ((0, 0), (0, beyond)), mode="edge")

    return given


def _moved(marched: Marched, line: FreeSlot) -> Motion:
    """Return the motion of a line from the beginning of its load until the end of a march."""
    rest, begins = np.zeros(line.grid.nodes // 2), marched.begins
    none = rest[line.kept]
    blocks = EqualSteps(line, Reached(begins, rest, none, none, none, none))
    spans = spans_to(spans_until(marched), begins, marched.end_time)
    record = MotionRecord(begins)
    blocks.jump(line.after(begins, spans[0].step))
    for _ in through(line, blocks, spans, lambda _: False):
        if len(blocks.times) > 1:
            record.add(blocks.times, blocks.levels[0])
    return record.motion()
