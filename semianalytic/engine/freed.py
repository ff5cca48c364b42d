"""How the faces of a slot move next to a contact whose motion a march has found.

A march next to a slot is long enough for its contact to see no mirror image.  In the bodies behind
the edge the slot matters on twice that length.  With the slip of the contact given, the faces of a
longer slot are free, and step on their own; so they do under pressure, where a closed contact does
not open.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from semianalytic.engine.bodies.marched_bodies import MarchedBodies, singular_edges
from semianalytic.engine.bodies.motion import Motion, MotionRecord
from semianalytic.engine.loads import FreeFaces, front_of
from semianalytic.engine.nodes import ContactGrid, SlotLayout
from semianalytic.engine.slot import spans_to, spans_until
from semianalytic.engine.stepping.advance import through
from semianalytic.engine.stepping.blocks import EqualSteps, Reached
from semianalytic.scene.arrays import Array

MARGIN = 1.05
"""How far behind the edge fields are known, over the distance that waves travel."""


def bodies_beside_slot(marched: Any) -> MarchedBodies:
    """Return the bodies of a march next to a slot."""
    scene, speed = marched.scene, marched.scene.fastest_speed
    # of a companion too the steps are those that suit its own nodes
    layout = replace(marched.checkpoint.layout, stride=1)
    if layout.entry and not scene.front_too_slow:  # no wave comes from where the load begins
        entry = (1 + MARGIN) * layout.entry
        layout = replace(layout, entry=entry, begins=-scene.front_slowness * entry)
    grid = _longer(marched, layout)
    front = front_of(scene, grid, layout.entry) if scene.front_slowness else None
    known = scene, grid, layout
    slip = _moved(marched, layout, FreeFaces(*known, "shear", front, _slip(marched)))
    opening = np.zeros((len(slip.slip), 0), np.float32)
    if scene.superposition.taken_off.pressure:
        opening = -_moved(marched, layout, FreeFaces(*known, "pressure", front)).slip
    both = (np.concatenate([half[:, ::-1], half], axis=1) for half in (slip.slip, opening))
    motion, spacing = Motion(slip.t, *both), grid.spacing
    first, centre = (0.5 - grid.slot - grid.size) * spacing, -grid.slot * spacing
    edges = tuple(singular_edges(scene, motion, first, spacing))
    far = MARGIN * speed * marched.end_time
    x = marched.interface.x
    ends = (-far, (grid.size - grid.slot) * spacing), spacing, float(x[-1] + x[0])
    return MarchedBodies(scene, motion, first, spacing, edges, centre, *ends)


def _longer(marched: Any, layout: SlotLayout) -> ContactGrid:
    """Return the nodes of a march with a slot so long that no mirror image is seen behind it."""
    from scipy.fft import next_fast_len

    scene, grid, end = marched.scene, marched.checkpoint.grid, marched.end_time
    speed = scene.fastest_speed
    length = (1 + MARGIN) / 2 * speed * end
    if scene.front_slowness < 0:  # a front that outruns the waves meets its mirror image
        length = max(length, (1 + MARGIN) * end / (1 / speed - scene.front_slowness))
    elif layout.entry:
        lasts = scene.front_too_slow * speed * (end - layout.begins)
        length = max(length, layout.entry + lasts)
    contact = grid.size - grid.slot
    slot = max(grid.slot, math.ceil(length / grid.spacing) + 8)
    size = next_fast_len(contact + slot, real=True)
    return ContactGrid(grid.spacing, size - contact, grid.observed, size)


def _slip(marched: Any) -> Callable[[Array, bool], Array]:
    """Return the slip rates of the contact that a march has found, those of its end beyond."""
    known, grid = marched.interface, marched.checkpoint.grid
    beyond = grid.size - grid.slot - grid.observed

    def given(times: Array, after: bool) -> Array:
        rows = np.clip(
            np.searchsorted(known.t, times, side="right" if after else "left"), 1, len(known.t) - 1
        )
        begin, end = known.t[rows - 1], known.t[rows]
        share = np.clip((times - begin) / (end - begin), 0.0, 1.0)[:, None]
        before, last = known.slip_rate[rows - 1], known.slip_rate[rows]
        if after:  # what is stored is the rate before a jump; the slip of the step gives that after
            moved = (known.slip[rows] - known.slip[rows - 1]) / (end - begin)[:, None]
            before = np.where(times[:, None] > known.t[0], 2 * moved - last, before)
        rates = before + share * (last - before)
        rates[times < known.t[0]] = 0.0
        return np.pad(rates, ((0, 0), (0, beyond)), mode="edge")

    return given


def _moved(marched: Any, layout: SlotLayout, line: FreeFaces) -> Motion:
    """Return the motion of a line from the beginning of its load until the end of a march."""
    rest, begins = np.zeros(line.grid.nodes // 2), layout.begins
    none = rest[line.kept]
    line.jumps = marched.scene.jumps
    blocks = EqualSteps(line, Reached(begins, rest, none, none, none, none))
    whole = spans_until(marched.scene, marched.checkpoint.grid, layout)
    spans = spans_to(whole, begins, marched.end_time)
    record = MotionRecord(begins)
    blocks.jump(line.after(begins, spans[0].step))
    for _ in through(line, blocks, spans, lambda _: False):
        if len(blocks.times) > 1:
            record.add(blocks.times, blocks.levels[0])
    return record.motion()
