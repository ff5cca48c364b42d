"""Advance a march and its companion from the state they have reached, from jump to jump."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from semianalytic.spacetime.companion import Follower
from semianalytic.spacetime.exponentials import Opening, fit_memory
from semianalytic.spacetime.grid_loads import (
    FrontLoad,
    FrontPressure,
    GridPressure,
    NodalPressure,
    table_bytes,
)
from semianalytic.spacetime.march_memory import affordable_every, state_bytes
from semianalytic.spacetime.marched import Marched
from semianalytic.spacetime.record import MarchRecord
from semianalytic.spacetime.stepping import Segment, Walk, segments_between
from semianalytic.spacetime.tuning import TOLERANCES


def advance(
    marched: Marched,
    end_time: float,
    memory: float | None,
    setup: float,
    progress: Callable[[int, int], object] | None,
) -> Marched:
    """Continue a march from the state reached to the end time, with its companion if there is one.

    Parameters
    ----------
    marched : Marched
        The march to be continued; it is not changed.
    end_time : float
        Time to march to [time].
    memory : float, optional
        Memory that the march may take [bytes].
    setup : float
        Time it took to make the grid and the memory [s], added to the statistics.
    progress : callable, optional
        Called with (step, steps) after each step, as in `march`.

    Raises
    ------
    SceneError
        If the march does not fit into the memory, or a step is beyond the stable range.
    TensionError
        If the pressure turns tensile at a node.
    ComputationError
        If values are no longer finite.
    """
    began = time.perf_counter()
    segments = segments_between(
        marched.scene, marched.end_time, end_time, marched.step_ratio, marched.grid.spacing
    )
    coarser, companion = [segment.coarser for segment in segments], marched.companion
    # `every` is chosen before the first step, from all memory that the march will hold at once.
    table = _table_bytes(marched, segments)
    table += 0.0 if companion is None else _table_bytes(companion, coarser)
    every = affordable_every(marched, memory, sum(part.steps for part in segments), table)
    walk = _walk(marched, segments, every, progress)
    if companion is None:
        for segment in segments:
            _march_segment(segment, walk, None)
        return _reached(marched, walk, every, setup, time.perf_counter() - began)
    # Half of `every`, rounded up, of half the steps: stored levels lie at about the same times.
    own_every = -(-every // 2)
    # The companion has no progress of its own; it stops where the march was stopped.
    behind = _walk(companion, coarser, own_every, lambda done, steps: follower.stopping)
    follower = Follower(behind, walk, marched.departure)
    for segment in segments:
        _march_segment(segment, walk, follower)
    companion = _reached(companion, behind, own_every, 0.0, follower.seconds)
    marched = replace(marched, companion=companion, departure=follower.departure)
    return _reached(marched, walk, every, setup, time.perf_counter() - began)


def _march_segment(segment: Segment, walk: Walk, follower: Follower | None) -> None:
    """March to the end of a segment, or until stopped; do nothing if already stopped."""
    if walk.record.stopped:
        return
    walk.begin(segment)
    if follower is not None:
        follower.begin(segment)
    while walk.done < segment.steps and not walk.record.stopped:
        walk.advance(segment.steps - walk.done)
        if follower is not None:
            follower.follow()
    walk.end()
    if follower is not None:
        follower.end()


def _walk(
    marched: Marched,
    segments: Sequence[Segment],
    every: int,
    progress: Callable[[int, int], object] | None,
) -> Walk:
    """Prepare a march for its way through segments."""
    pressure, front = loads_on_grid(marched, segments)
    steps = sum(segment.steps for segment in segments)
    return Walk(marched, pressure, front, MarchRecord(marched, steps, every, progress))


def loads_on_grid(
    marched: Marched, segments: Sequence[Segment]
) -> tuple[NodalPressure, FrontLoad | None]:
    """Return the pressure at the nodes of a march, and its load if the front of that moves.

    Parameters
    ----------
    marched : Marched
        The march; its grid, memory and damping are used.
    segments : sequence of Segment
        The time steps to come.
    """
    scene, grid, finest = marched.scene, marched.grid, _finest(segments)
    front = None
    if scene.front_slowness:
        front = FrontLoad(scene, grid.nodes, grid.spacing, grid.slot, marched.entry)
        if scene.superposition.taken_off.pressure:
            material, memory = scene.material, marched.memory
            impedance = Opening(material.shear_speed / material.longitudinal_speed)
            # as accurate as the memory of shear
            tolerance = min(max(memory.error, 2 * TOLERANCES[0]), TOLERANCES[1])
            opening = fit_memory(impedance, memory.horizon, tolerance)
            start = (front, opening, grid.wavenumbers, marched.damping, marched.begins, finest)
            return FrontPressure(*start), front
    contact = grid.size - grid.slot
    return GridPressure(scene, contact, grid.spacing, segments[-1].end, finest), front


def _table_bytes(marched: Marched, segments: Sequence[Segment]) -> float:
    """Return the size of the pressure table of a march, or of its march of pressure [bytes]."""
    if marched.scene.front_slowness and marched.scene.superposition.taken_off.pressure:
        return state_bytes(marched.grid.size, marched.statistics.poles)
    contact = marched.grid.size - marched.grid.slot
    return table_bytes(marched.scene, contact, segments[-1].end / _finest(segments))


def _finest(segments: Sequence[Segment]) -> float:
    """Return the shortest time step of segments [time]."""
    return min(segment.time_step for segment in segments)


def _reached(marched: Marched, walk: Walk, every: int, setup: float, steps: float) -> Marched:
    """Return the march at the state that was reached, with the seconds it took added."""
    before, record = marched.statistics, walk.record
    seconds = {
        "setup": before.seconds["setup"] + setup,
        "steps": before.seconds["steps"] + steps,
    }
    return replace(
        marched,
        interface=record.interface(),
        totals=record.totals(),
        every=every,
        statistics=replace(before, steps=before.steps + record.done, seconds=seconds),
        state=walk.state,
        seen=record.seen,
    )
