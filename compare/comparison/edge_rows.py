"""Where slip zones end in a self-similar scene: predicted, as the mesh would see it, simulated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from compare.comparison.case import NARROW, Case
from compare.comparison.measures import NOTHING
from compare.comparison.rows import Row
from compare.comparison.scales import speed_regime
from semianalytic import InterfaceHistory
from semianalytic.results.answer import SlipInterval
from semianalytic.results.sampled import slip_intervals

Array = NDArray[np.float64]

READ_FROM = 0.01
"""Part of the largest slip rate from which on slip counts: less runs ahead of the fronts."""
LEVELS = 24
"""Times in the last third of the run at which edges are read; of self-similar zones the median."""
EDGE_FLOOR = 0.6
"""Elements by which nodes alone leave an edge open, whatever the mesh differences."""


@dataclass(frozen=True)
class Obstacle:
    """Why an edge cannot be seen, and the width that would have to be (`NARROW`) elements wide."""

    reason: str
    width: float


def zone_rows(case: Case) -> Iterator[Row]:
    """Velocities in c_t of all zone edges, except 0, infinity and the P front, an arrival.

    Then the zones of the simulation that are not predicted.
    """
    zones = case.prediction.zones_at(case.end_time)
    material = case.prediction.scene.material
    for number, zone in enumerate(zones):
        for end in ("start", "end"):
            edge = getattr(zone, end)
            if not 0 < edge < math.inf or (
                speed_regime(edge / case.end_time, material) == "at c_l"
            ):
                continue
            name = f"zone {number + 1}, {'inner' if end == 'start' else 'outer'} edge"
            yield _edge_row(case, name, zones, number, end)
    yield from _unpredicted_rows(case, zones)


def narrow_obstacle(
    zones: tuple[SlipInterval, ...], number: int, end: str, least: float
) -> Obstacle | None:
    """Why nodes cannot show an edge: its zone, or what lies beyond it, is narrower than `least`.

    Parameters
    ----------
    zones : tuple of SlipInterval
        From the edge outward, at one time.
    number : int
        Of the zone.
    end : str
        "start" or "end".
    least : float
        [length].
    """
    zone = zones[number]
    if zone.end - zone.start < least:
        return Obstacle("the zone is {width} c_t T wide", zone.end - zone.start)
    beyond = number + (1 if end == "end" else -1)
    if not 0 <= beyond < len(zones):
        return None
    other = zones[beyond]
    gap = other.start - zone.end if end == "end" else zone.start - other.end
    if gap >= least:
        return None
    if other.sense != zone.sense and other.end - other.start >= least:
        return None
    if other.sense != zone.sense:
        return Obstacle("the zone next to it is {width} c_t T wide", other.end - other.start)
    return Obstacle("the gap to the next zone is {width} c_t T wide", gap)


def _edge_row(case: Case, name: str, zones: tuple[SlipInterval, ...], number: int, end: str) -> Row:
    zone = zones[number]
    read = partial(_edge_velocity, case, zone, end)
    cell = case.simulation.element_size / case.length
    exact = getattr(zone, end) / case.length
    row = case.value_row(
        name, "zone edge", read, exact=exact, floor=EDGE_FLOOR * cell, unit="c_t"
    ) or Row(name, "zone edge", exact, None, None, None, None, "c_t")
    obstacle = narrow_obstacle(zones, number, end, NARROW * case.simulation.element_size)
    if obstacle is not None:
        width = obstacle.width / case.length
        reason = f"{obstacle.reason.format(width=f'{width:.2g}')}, {width / cell:.2g} elements"
        enough = case.resolution_for(obstacle.width) if obstacle.width > 0 else None
        return replace(row, obstacle=reason, resolution=enough)
    if row.verdict == "differs":
        return replace(row, obstacle=_weakness(case, zone))
    return row


def _weakness(case: Case, zone: SlipInterval) -> str:
    """That slip in a zone is slower than the error bar of slip rate there; "" if it is not."""
    inside = (case.seen.x > zone.start) & (case.seen.x < zone.end)
    rate = case.at_nodes.slip_rate[-1, inside]
    if not len(rate) or not case.coarser:
        return ""
    bar = case.rate_bar(zone.start, zone.end)
    peak = float(np.abs(rate).max())
    if peak >= bar:
        return ""
    return (
        f"slip in the zone, {peak / case.rate:.2g} V₀ at most, is slower than the error bar there, "
        f"{bar / case.rate:.2g} V₀"
    )


def _unpredicted_rows(case: Case, zones: tuple[SlipInterval, ...]) -> Iterator[Row]:
    """Zones of the simulation that overlap none of the prediction of their sense."""
    least = NARROW * case.simulation.element_size
    for zone in _intervals(case, case.seen, -1):
        start, end = zone.start * case.end_time, zone.end * case.end_time
        end = min(end, float(case.seen.x[-1]))
        margin = EDGE_FLOOR * case.simulation.element_size
        if any(
            other.sense == zone.sense and other.start < end + margin and start < other.end + margin
            for other in zones
        ):
            continue
        row = Row(
            f"unpredicted slip at {start / case.length:.3f} c_t",
            "zone edge",
            None,
            None,
            (end - start) / case.length,
            None,
            least / case.length,
            "c_t T",
        )
        if end - start < least:
            row = replace(row, obstacle=f"it is narrower than {NARROW} elements")
        elif not any(_shows(case, run.interface, zone) for run in case.coarser[:1]):
            row = replace(row, obstacle="the coarser mesh does not show it")
        yield case.judged(row, None)


def _shows(case: Case, history: InterfaceHistory, zone: SlipInterval) -> bool:
    """Whether a history has slip of the same sense where a zone is."""
    return any(
        other.sense == zone.sense and other.start < zone.end and zone.start < other.end
        for other in _intervals(case, history, -1)
    )


def _edge_velocity(
    case: Case, zone: SlipInterval, end: str, history: InterfaceHistory
) -> float | None:
    """Velocity in c_t of an edge in a history; None unless most of the times show the zone."""
    at = getattr(zone, end) / case.end_time
    late = np.flatnonzero(history.t > 2 / 3 * case.end_time)
    levels = late[np.unique(np.linspace(0, len(late) - 1, LEVELS).round().astype(int))]
    edges = []
    for level in levels:
        rivals = [
            getattr(other, end)
            for other in _intervals(case, history, level)
            if other.sense == zone.sense
            and other.start * case.end_time < zone.end
            and zone.start < other.end * case.end_time
        ]
        if rivals:
            edges.append(min(rivals, key=lambda edge: abs(edge - at)))
    if len(edges) < len(levels) / 2:
        return None
    middle = float(np.median(edges))
    return middle / case.scene.material.shear_speed if math.isfinite(middle) else None


def _intervals(case: Case, history: InterfaceHistory, level: int) -> tuple[SlipInterval, ...]:
    """Slip zones that a history shows at a level, in velocities x/t."""
    velocity = history.x / history.t[level]
    least = max(READ_FROM * case.largest_rate, NOTHING * case.rate)
    return slip_intervals(velocity, history.slip_rate[level], least)
