"""Edges of slip zones and openings in a self-similar scene: predicted, as the nodes show the
prediction, and simulated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from compare.comparison.bars import ErrorBar, error_bar
from compare.comparison.case import Case
from compare.comparison.judging import judged, rate_bar, value_row
from compare.comparison.measures import NARROW, NOTHING, ROUNDING
from compare.comparison.rows import BEYOND, Row
from semianalytic.results.answer import OpenInterval, SlipInterval
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.intervals import open_intervals, slip_intervals
from semianalytic.results.sampled import interpolated

Part = SlipInterval | OpenInterval
"""A slip zone or an opening."""
Seen = Callable[[InterfaceHistory, int], tuple[Part, ...]]
"""Function that returns the parts that a history shows at a level, in velocities x/t."""

READ_FROM = 0.01
"""Part of the largest slip rate above which slip counts; slower slip runs ahead of the fronts."""
OPEN_FROM = 1e-4
"""Part of the largest gap above which an opening counts."""
SHARED = 1e-6
"""Relative difference below which two edges are the same."""
LEVELS = 24
"""Number of times in the last third of the run at which edges are read; their median is used."""
EDGE_FLOOR = 0.25
"""Uncertainty of an edge due to nodes alone, in elements, whatever the mesh differences.  Among 220
edges measured one was farther beyond its bar than that, by 0.6 in an opening of 19 elements; with
half this value there would have been four more."""
SHALLOW = "the gap at its end changes from mesh to mesh by more than its largest value"
"""Obstacle of an end of an opening that cannot be read off."""
NEARBY = 0.5
"""Part of a zone, or of the gap next to it, up to which edges of two meshes count as the same."""
LEAST_SEEN = 4
"""Least width, in elements, of slip or an opening that counts although it is not predicted."""


@dataclass(frozen=True)
class Obstacle:
    """Reason why an edge cannot be seen, and the width that would have to be `NARROW` elements."""

    reason: str
    width: float


def zone_rows(case: Case) -> Iterator[Row]:
    """Rows of the velocities in c_t of zone edges, and of simulated zones that are not predicted.

    There are none for edges at 0, at infinity, at the P front, which is an arrival, and at either
    end of an opening.
    """
    zones = case.prediction.zones_at(case.end_time)
    openings = case.prediction.openings_at(case.end_time)
    seen = partial(_zones, case)
    yield from _edge_rows(case, zones, seen, {end for part in openings for end in _ends(part)})
    yield from _unpredicted_rows(case, zones, seen)


def opening_rows(case: Case) -> Iterator[Row]:
    """Rows of the edges of openings and of openings that are not predicted, if any."""
    if not case.opens:
        return
    openings, seen = case.prediction.openings_at(case.end_time), partial(_openings, case)
    yield from _edge_rows(case, openings, seen, set())
    yield from _unpredicted_rows(case, openings, seen)


def _edge_rows(
    case: Case, parts: tuple[Part, ...], seen: Seen, elsewhere: set[float]
) -> Iterator[Row]:
    """Rows of the ends of parts of one kind, except those listed in `elsewhere`."""
    rows = {}
    for number, part in enumerate(parts):
        for end, edge in zip(("start", "end"), _ends(part), strict=True):
            if not 0 < edge < math.inf or _is_arrival(case, edge):
                continue
            if any(math.isclose(edge, other, rel_tol=SHARED) for other in elsewhere):
                continue
            rows[number, end] = _edge_row(case, parts, number, end, seen)
    for number, (part, after) in enumerate(pairwise(parts)):
        sides = (number, "end"), (number + 1, "start")
        if math.isclose(part.end, after.start, rel_tol=SHARED) and rows.keys() >= set(sides):
            # the zones on either side read one edge, at which slip changes its sense
            bars = [bar for side in sides if (bar := rows[side].bar) is not None]
            for side in sides:
                row = replace(rows[side], bar=max(bars, default=None))
                within = row.bar is not None and row.over_bar <= 1
                if rows[side].bar is not None:
                    past = within and row.obstacle.startswith(BEYOND)
                    rows[side] = replace(row, obstacle="" if past else row.obstacle)
    yield from rows.values()


def _is_arrival(case: Case, edge: float) -> bool:
    """Whether an edge [length] runs with the P wave of either body."""
    speed, bodies = edge / case.end_time, case.prediction.scene.bodies
    return any(math.isclose(speed, body.longitudinal_speed, rel_tol=SHARED) for body in bodies)


def narrow_obstacle(
    parts: tuple[Part, ...], number: int, end: str, least: float
) -> Obstacle | None:
    """Return why nodes cannot show an edge: its zone or what lies beyond is narrower than `least`.

    The edge is the start or the end of a part by its number, from the edge of the contact outward.
    """
    part = parts[number]
    name = _name(part)
    if part.end - part.start < least:
        return Obstacle(f"the {name} is {{width}} c_t T wide", part.end - part.start)
    beyond = number + (1 if end == "end" else -1)
    if not 0 <= beyond < len(parts):
        return None
    other = parts[beyond]
    gap = other.start - part.end if end == "end" else part.start - other.end
    if gap >= least:
        return None
    if _sense(other) != _sense(part) and other.end - other.start >= least:
        return None
    if _sense(other) != _sense(part):
        return Obstacle("the zone next to it is {width} c_t T wide", other.end - other.start)
    return Obstacle(f"the gap to the next {name} is {{width}} c_t T wide", gap)


def room(parts: tuple[Part, ...], number: int, end: str) -> float:
    """Width of a part, or of the gap to the next part of its sense at an end if that is less."""
    part, beyond = parts[number], number + (1 if end == "end" else -1)
    room = part.end - part.start
    if not 0 <= beyond < len(parts):
        return room
    other = parts[beyond]
    gap = other.start - part.end if end == "end" else part.start - other.end
    return min(room, gap) if _sense(other) == _sense(part) else room


def _sense(part: Part) -> int:
    """Sense of a slip zone; 0 for an opening."""
    return part.sense if isinstance(part, SlipInterval) else 0


def _name(part: Part) -> str:
    return "zone" if isinstance(part, SlipInterval) else "opening"


def _ends(part: Part) -> tuple[float, float]:
    return part.start, part.end


def _edge_row(case: Case, parts: tuple[Part, ...], number: int, end: str, seen: Seen) -> Row:
    part = parts[number]
    name = f"{_name(part)} {number + 1}, {'inner' if end == 'start' else 'outer'} edge"
    kind = f"{_name(part)} edge"
    read = partial(_edge_velocity, case, part, end, seen)
    cell = case.simulation.element_size / case.length
    exact = getattr(part, end) / case.length
    read_off = read_off_bar(case, part, end)
    if math.isinf(read_off) and isinstance(part, SlipInterval):
        read_off = 0.0  # a sharp edge, whose own changes from mesh to mesh say how far it moves
    row = value_row(
        case,
        name,
        kind,
        read,
        exact=exact,
        floor=EDGE_FLOOR * cell,
        unit="c_t",
        reach=NEARBY * room(parts, number, end) / case.length,
        unseen=read_off,
    ) or Row(name, kind, exact, None, None, None, None, "c_t")
    obstacle = narrow_obstacle(parts, number, end, NARROW * case.simulation.element_size)
    if obstacle is not None:
        width = obstacle.width / case.length
        reason = f"{obstacle.reason.format(width=f'{width:.2g}')}, {width / cell:.2g} elements"
        enough = math.ceil(NARROW * case.length / obstacle.width) if obstacle.width > 0 else None
        return replace(row, obstacle=reason, resolution=enough)
    if math.isinf(read_off):
        return replace(row, obstacle=SHALLOW, resolution=2 * case.simulation.resolution)
    if row.verdict == "differs" and isinstance(part, SlipInterval):
        return replace(row, obstacle=_weakness(case, part))
    return row


def read_off_bar(case: Case, part: Part, end: str) -> float:
    """Return how far in c_t an end ("start" or "end") of a zone or an opening moves if only slip
    rates, or gaps, above their own error bar are trusted.

    An end is read where they pass a level (`READ_FROM`, `OPEN_FROM`).  Their error bar is taken
    where prediction and simulation have the end, and the larger one of the moves counts.  It is
    infinite where no more than that bar is seen, 0 where there is no coarser mesh or neither answer
    shows the part.
    """
    name, seen = ("gap", _openings) if isinstance(part, OpenInterval) else ("slip_rate", _zones)
    shown = [
        (history, edge)
        for history in (case.at_nodes, case.seen)
        if (edge := _edge_velocity(case, part, end, partial(seen, case), history)) is not None
    ]
    runs = [run.interface for run in case.runs]
    if not shown or len(runs) < 2:
        return 0.0
    t = case.seen.t[_late_levels(case, case.seen)]
    # gaps of a self-similar scene grow with time, slip rates along x = v t are constant
    grown = t / case.end_time if name == "gap" else np.ones(len(t))
    errors = []
    for _, edge in shown:
        x = edge * case.scene.material.shear_speed * t
        values = [interpolated(run, name, x, t) / grown for run in runs]
        changes = [float(np.median(np.abs(fine - coarse))) for fine, coarse in pairwise(values)]
        error = error_bar(changes)
        errors.append(min(error.size, error.limit))
    above = partial(seen, case, more=max(errors))
    moved = []
    for history, edge in shown:
        inner = _edge_velocity(case, part, end, above, history)
        moved.append(math.inf if inner is None else abs(inner - edge))
    return max(moved)


def _weakness(case: Case, zone: SlipInterval) -> str:
    """Obstacle that slip in a zone is slower than the error bar of slip rate there, or that the
    simulation has the zone, but with slip too slow to be read; "" if neither is so."""
    inside = (case.seen.x > zone.start) & (case.seen.x < zone.end)
    rate = case.at_nodes.slip_rate[-1, inside]
    if not len(rate) or not case.coarser:
        return ""
    bar = rate_bar(case, zone.start, zone.end)
    peak = float(np.abs(rate).max())
    read_from, nothing = _read_from(case), NOTHING * case.rate
    found = float((zone.sense * case.seen.slip_rate[-1, inside]).max())
    if peak < bar:
        return (
            f"slip in the zone, {peak / case.rate:.2g} V₀ at most, is slower than the error bar "
            f"there, {bar / case.rate:.2g} V₀"
        )
    if nothing < found < read_from:
        return (
            f"the simulation slips there at {found / case.rate:.2g} V₀ at most, and edges are read "
            f"from {read_from / case.rate:.2g} V₀ on"
        )
    return ""


def _unpredicted_rows(case: Case, parts: tuple[Part, ...], seen: Seen) -> Iterator[Row]:
    """Rows of simulated zones or openings that overlap no predicted one of their sense."""
    least = LEAST_SEEN * case.simulation.element_size
    for part in seen(case.seen, -1):
        start, end = part.start * case.end_time, part.end * case.end_time
        end = min(end, float(case.seen.x[-1]))
        margin = EDGE_FLOOR * case.simulation.element_size
        if any(
            _sense(other) == _sense(part)
            and other.start < end + margin
            and start < other.end + margin
            for other in parts
        ):
            continue
        what = "slip" if isinstance(part, SlipInterval) else "opening"
        row = Row(
            f"unpredicted {what} at {start / case.length:.3f} c_t",
            f"{_name(part)} edge",
            None,
            None,
            (end - start) / case.length,
            None,
            least / case.length,
            "c_t T",
        )
        if end - start < least:
            row = replace(row, obstacle=f"it is narrower than {LEAST_SEEN} elements")
        elif not any(_shows(seen(run.interface, -1), part) for run in case.coarser[:1]):
            row = replace(row, obstacle="the coarser mesh does not show it")
        width = ErrorBar(least / case.length, None, math.inf, converges=True)
        yield row if row.obstacle else judged(case, row, width)


def _shows(seen: tuple[Part, ...], part: Part) -> bool:
    """Whether slip of the same sense, or an opening, overlaps a part."""
    return any(
        _sense(other) == _sense(part) and other.start < part.end and part.start < other.end
        for other in seen
    )


def _late_levels(case: Case, history: InterfaceHistory) -> NDArray[np.intp]:
    late = np.flatnonzero(history.t > (1 + ROUNDING) * 2 / 3 * case.end_time)
    return late[np.unique(np.linspace(0, len(late) - 1, LEVELS).round().astype(int))]


def _edge_velocity(
    case: Case, part: Part, end: str, seen: Seen, history: InterfaceHistory
) -> float | None:
    """Velocity in c_t of an edge in a history; None unless half of the times show its part."""
    at = getattr(part, end) / case.end_time
    levels = _late_levels(case, history)
    edges = []
    for level in levels:
        rivals = [
            getattr(other, end)
            for other in seen(history, int(level))
            if _sense(other) == _sense(part)
            and other.start * case.end_time < part.end
            and part.start < other.end * case.end_time
        ]
        if rivals:
            edges.append(min(rivals, key=lambda edge: abs(edge - at)))
    if len(edges) < len(levels) / 2:
        return None
    middle = float(np.median(edges))
    return middle / case.scene.material.shear_speed if math.isfinite(middle) else None


def _zones(
    case: Case, history: InterfaceHistory, level: int, more: float = 0.0
) -> tuple[SlipInterval, ...]:
    """Slip zones that a history shows at a level, in velocities x/t; those that slip by so much
    faster than what counts [length / time], if given."""
    velocity = history.x / history.t[level]
    return slip_intervals(velocity, history.rubbing_rate[level], _read_from(case) + more)


def _read_from(case: Case) -> float:
    """Return the slip rate above which slip counts as a zone [length / time]."""
    return max(READ_FROM * case.largest_rate, NOTHING * case.rate)


def _openings(
    case: Case, history: InterfaceHistory, level: int, more: float = 0.0
) -> tuple[OpenInterval, ...]:
    """Openings that a history shows at a level, in velocities x/t; those that gape by so much more
    than what counts [length at the end], if given."""
    time = float(history.t[level])
    least = (OPEN_FROM * case.largest_gap + more) * time / case.end_time
    return open_intervals(history.x / time, history.gap[level], least)
