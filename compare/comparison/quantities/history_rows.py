"""Comparison over space and time: slip rate, gap, sense of slip, onset, reversal."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.bars import error_bar
from compare.comparison.case import Case, beyond_edge, too_narrow
from compare.comparison.judging import Compared, field_row, judged, rate_bar, value_row
from compare.comparison.measures import (
    EARLY,
    NARROW,
    NOTHING,
    PROBES,
    ROUNDING,
    SENSE_THRESHOLD,
    first_above,
    nearest,
)
from compare.comparison.rows import Row
from semianalytic import Harmonic
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated
from semianalytic.scene.arrays import Array, Mask

Senses = NDArray[np.int8]

APART = 2
"""Value in a map of senses where the contact is open."""
REVERSAL_THRESHOLD = 0.05
"""Part of the largest slip rate above which slip of the other sense counts as a reversal."""
FRONT = 1
"""Number of elements of the coarsest mesh behind the first wave that maps of senses leave out.
With none, a frictionless scene whose slip grows from zero behind the P wave was 2 bars off."""
NEIGHBOURS = 2
"""Number of elements on either side of a probe that give the error bar of the slip rate there."""
SENSE_FLOOR = 0.12
"""Uncertainty of parts of maps, over the part of nodes and times that lie next to edges of slip."""
ONSET_FLOOR = 0.35
"""Uncertainty of a time due to nodes and steps, in elements over c_t.  Among 180 times measured one
was farther beyond its bar than that, by a fifth of it; without it there would have been three."""


def slip_sense(slip_rate: Array, largest: float) -> Senses:
    """Sense of slip, +1 or -1 where it is faster than 1 % of the largest slip rate, else 0."""
    fast = np.abs(slip_rate) > SENSE_THRESHOLD * largest
    return np.where(fast, np.sign(slip_rate), 0).astype(np.int8)


def sense_maps(case: Case) -> tuple[Senses, Senses, Mask]:
    """Return predicted and simulated maps of the sense of slip, `APART` where the contact is open,
    and the mask of the nodes and times that the waves have reached, (m, n) each."""
    seen = case.seen
    reached = _behind_front(case, seen.x, seen.t[:, None])
    return _senses(case, case.at_nodes), _senses(case, seen), reached


def _senses(case: Case, history: InterfaceHistory) -> Senses:
    """Map of senses of a history at its nodes and times."""
    return _sense_or_apart(case, history.slip_rate, history.gap)


def _sense_or_apart(case: Case, slip_rate: Array, gap: Array) -> Senses:
    senses = slip_sense(slip_rate, case.largest_rate)
    senses[gap > SENSE_THRESHOLD * case.largest_gap] = APART
    return senses


def beside_edges(sense: Senses) -> Mask:
    """Nodes and times within one of a change of sense, (m, n)."""
    changes = np.zeros(sense.shape, dtype=bool)
    changes[:-1] |= np.diff(sense, axis=0) != 0
    changes[:, :-1] |= np.diff(sense, axis=1) != 0
    return np.asarray(scipy.ndimage.binary_dilation(changes), dtype=bool)


def map_rows(case: Case) -> Iterator[Row]:
    """Rows of the relative L1 errors over space and time of the slip rate, without the four
    elements at the edge, and of the gap if the contact opens; of the largest values where none is
    predicted.

    Slip rates of all meshes and of the prediction are means over the window of the coarsest mesh.
    """
    beyond, rate = beyond_edge(case.seen.x, case.simulation), case.at_nodes.slip_rate
    yield map_row(case, "slip_rate", np.where(case.narrow & beyond, rate, 0.0))
    if case.opens:
        gap = case.at_nodes.gap
        yield map_row(case, "gap", np.where(too_narrow(gap > 0), gap, 0.0))


def map_row(case: Case, name: str, unseen: Array) -> Row:
    """Row of a field over space and time: relative L1 error, or largest value if none is predicted.

    `unseen`, (m, n), is how far the prediction at the nodes is uncertain, or too narrow for them.
    """
    runs = [run.interface for run in case.runs]
    late = [run.t > (1 + ROUNDING) * EARLY * case.end_time for run in runs]
    times = [run.t[kept] for run, kept in zip(runs, late, strict=True)]

    def field(history: InterfaceHistory, of: int) -> Array:
        """Return the field of a history at its own positions and the times of a run."""
        if name == "slip_rate":
            return case.mean_rate(history, times[of])
        places = np.broadcast_arrays(history.x, times[of][:, None])
        return interpolated(history, name, *places)

    both = Compared(
        [run.x for run in runs],
        [case.compared(name, number) for number in range(len(runs))],
        lambda number, of: field(runs[number], of),
        lambda of: field(case.expected[of], of),
        None if case.doubted is None else field(case.doubted, 0),
        times,
    )
    words, scale = name.replace("_", " "), case.unit(name)
    driven = name == "slip_rate" and bool(case.strength_changes)
    shown = both.shown[0]
    return field_row(
        case,
        f"{words} over (x, t)",
        words,
        both,
        scale,
        unseen=case.size(unseen[np.ix_(late[0], shown)], both.x[0][shown], times[0]) / scale[0],
        driven=(lambda of: case.strength_changes[of][late[of + 1]]) if driven else None,
        showing=case.showing(name, slice(None)) if name == "slip_rate" else 2,
        jumps=driven,
    )


def _behind_front(case: Case, x: Array, t: Array) -> Mask:
    """Mask of where the first wave has passed, except for `FRONT` elements of the coarsest mesh
    behind it, by which slip may begin too early on all meshes."""
    width = FRONT * case.runs[-1].element_size
    return np.asarray(x <= (1 + ROUNDING) * case.fastest_speed * t - width)


def sense_rows(case: Case) -> Iterator[Row]:
    """Rows of the parts of the (x, t) area behind the first wave that slip each way or are open,
    and of the part where the sense differs."""
    predicted, simulated, reached = sense_maps(case)
    area = float(reached.sum())
    edges = max(float((beside_edges(sense) & reached).sum()) for sense in (predicted, simulated))
    floor = SENSE_FLOOR * edges / area + 1 / area
    narrow = case.narrow | case.narrow_gaps | too_narrow(case.at_nodes.gap > 0)
    for sense in (1, -1):  # the mesh shows such a zone with any width of so few nodes
        narrow |= too_narrow(simulated == sense)
    unseen = float((narrow & reached).sum()) / area
    for name, sense in (("forward slip", 1), ("reverse slip", -1), ("open", APART)):
        row = value_row(
            case,
            f"{name}, share of nodes and times",
            "sense",
            partial(_part, case, sense),
            floor=floor,
            unseen=unseen,
        )
        if row is not None:
            yield row
    changes = []
    for fine, coarse in case.pairs:
        x, t = np.broadcast_arrays(coarse.x, coarse.t[:, None])
        behind = _behind_front(case, x, t)
        between = (interpolated(fine, field, x, t) for field in ("slip_rate", "gap"))
        senses = [_sense_or_apart(case, *between), _senses(case, coarse)]
        changes.append(float((senses[0] != senses[1])[behind].sum() / behind.sum()))
    differing = float((predicted != simulated)[reached].sum()) / area
    if case.doubted is not None:
        doubted = _senses(case, case.doubted)
        unseen += float((doubted != predicted)[reached].sum()) / area

    def before() -> float:
        there, run = case.expected[1], case.runs[1].interface
        behind = _behind_front(case, there.x, there.t[:, None])
        differs = _senses(case, run)[:, : len(there.x)] != _senses(case, there)
        return float(differs[behind].sum() / behind.sum())

    name = "other sense, share of nodes and times"
    row = Row(name, "sense", None, 0.0, differing, differing, None)
    error = error_bar(changes, floor) if changes else None
    yield judged(case, row, error, before, unseen)


def _part(case: Case, sense: int, history: InterfaceHistory) -> float:
    """Part of the area behind the first wave that has one sense of slip, or is open."""
    reached = _behind_front(case, history.x, history.t[:, None])
    slips = _senses(case, history) == sense
    return float(slips[reached].sum() / reached.sum())


def event_rows(case: Case) -> Iterator[Row]:
    """Rows of the times in T at which slip starts and first reverses at probe points.

    A reversal is slip against the sense in which the simulation starts to slip there.
    """
    cell = case.simulation.element_size / case.length
    # a self-similar solution is the same at all probes, only coarser near the edge
    for probe in PROBES[-1:] if case.scene.is_self_similar else PROBES:
        place = float(case.seen.x[nearest(case.seen.x, probe * case.length)])
        fast = REVERSAL_THRESHOLD * case.largest_rate
        against = -_first_sense(case, place, fast)
        for name, sense, least in (
            ("onset", None, SENSE_THRESHOLD * case.largest_rate),
            ("reversal", against, fast),
        ):
            row = value_row(
                case,
                f"{name} at {place / case.length:.2f} c_t T",
                "onset",
                partial(_event, sense, place, least, case.end_time),
                floor=ONSET_FLOOR * cell,
                unit="T",
            )
            if row is None:
                continue
            if row.verdict == "differs":
                row = replace(row, obstacle=_weakness(case, row, place, least))
            yield row


def _event(
    sense: int | None, place: float, least: float, end_time: float, history: InterfaceHistory
) -> float | None:
    """First time in T of slip at a place, of one sense if given; None if it does not happen."""
    record = _record(history, place)
    rate = np.abs(record) if sense is None else sense * record
    when = first_above(history.t, rate, least)
    return None if when is None else when / end_time


def _weakness(case: Case, row: Row, place: float, least: float) -> str:
    """Reason why the mesh may miss an event that differs: too short, or too slow; or ""."""
    if not case.coarser:
        return ""
    near = NEIGHBOURS * case.simulation.element_size
    bar = rate_bar(case, place - near, place + near)
    events = [
        case.end_time if at is None else at * case.end_time for at in (row.at_nodes, row.simulated)
    ]
    early = case.at_nodes if events[0] < events[1] else case.seen
    between = (early.t >= (1 - ROUNDING) * min(events)) & (early.t < (1 - ROUNDING) * max(events))
    elements = _lasts(early, place, min(events), least) / case.simulation.element_size
    elements *= case.scene.material.shear_speed
    if elements < NARROW:
        return f"it is over while a shear wave crosses {elements:.2g} elements"
    passed = float(np.abs(_record(early, place)[between]).max(initial=0.0)) - least
    if passed > bar:
        return ""
    return f"slip there is within its error bar, {bar / case.rate:.2g} V₀, of the threshold"


def _lasts(history: InterfaceHistory, place: float, start: float, least: float) -> float:
    """Duration of slip of one sense above a threshold at a place, from a time on [time]."""
    later = history.t >= (1 - ROUNDING) * start
    record, time = _record(history, place)[later], history.t[later]
    if not len(record):
        return 0.0
    over = np.flatnonzero(record * np.sign(record[0]) <= least)
    end = time[over[0]] if len(over) else time[-1]
    return float(end - start)


def _record(history: InterfaceHistory, place: float) -> Array:
    """Slip rate over time at a place."""
    return interpolated(history, "slip_rate", np.full(history.t.shape, place), history.t)


def _first_sense(case: Case, place: float, threshold: float) -> int:
    """Sense in which the simulation, or else the prediction, first slips at a place; 0 for none."""
    for history in (case.seen, case.at_nodes):
        record = _record(history, place)
        fast = record[np.abs(record) > threshold]
        if len(fast):
            return int(np.sign(fast[0]))
    return 0


def cycle_rows(case: Case) -> Iterator[Row]:
    """Rows of the frictional work per unit thickness in each whole cycle of a harmonic load."""
    if not isinstance(case.scene.shear_history, Harmonic):
        return
    period = 1 / case.scene.shear_history.frequency
    unit = case.stress * case.rate * case.length * case.end_time
    for cycle in range(int(case.end_time / period * (1 + 1e-9))):
        row = value_row(
            case,
            f"work in cycle {cycle + 1}",
            "work",
            partial(_work_between, unit, cycle * period, (cycle + 1) * period),
            floor=NOTHING,
            unit="τ₀ V₀ c_t T²",
        )
        if row is not None:
            yield row


def _work_between(unit: float, start: float, end: float, history: InterfaceHistory) -> float:
    """Frictional work per unit thickness between two times, over a unit."""
    power = np.asarray(np.trapezoid(history.slip_rate * history.shear_traction, history.x, axis=1))
    steps = np.diff(history.t) * (power[1:] + power[:-1]) / 2
    work = np.concatenate([np.zeros(1), np.cumsum(steps)])
    first, last = np.interp([start, end], history.t, work).tolist()
    return float(last - first) / unit
