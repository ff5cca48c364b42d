"""Comparison over space and time: sense of slip, reversals, wear; for any load history."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from compare.comparison.measures import is_nothing, norm, onset_time, relative_error
from compare.comparison.predictions import Prediction
from compare.comparison.rows import (
    EDGE_CELLS,
    NO_SLIP,
    ZONE_CELLS,
    Row,
    comparison_row,
    element_over_length,
    nothing_row,
)
from compare.comparison.scales import load_time, slip_rate_scale, stress_scale
from semianalytic import Harmonic, InterfaceHistory
from semianalytic.scene.scene import Scene

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

SENSE_THRESHOLD = 0.01
REVERSAL_THRESHOLD = 0.05
PROBES = (0.04, 0.25, 0.5, 0.75)
NEAR = 1
EARLY = 0.2
REACH = 1.9


def slip_sense(slip_rate: Array, largest: float) -> NDArray[np.int8]:
    """+1, 0 or -1 where slip is faster than 1 % of the largest slip rate, any shape."""
    fast = np.abs(slip_rate) > SENSE_THRESHOLD * largest
    return np.where(fast, np.sign(slip_rate), 0).astype(np.int8)


def slips(prediction: Prediction, simulation: Simulation) -> bool:
    """Whether any slip is predicted at the nodes of a simulation."""
    scale = slip_rate_scale(simulation.scene)
    return not is_nothing(prediction.interface.slip_rate, scale)


def sense_maps(
    prediction: Prediction, simulation: Simulation
) -> tuple[NDArray[np.int8], NDArray[np.int8], NDArray[np.bool_]]:
    """Predicted and simulated sense of slip, and what the waves have reached, (m, n) each."""
    seen = simulation.contact
    largest = float(np.abs(prediction.interface.slip_rate).max())
    speed = simulation.scene.material.longitudinal_speed
    reached = seen.x <= speed * seen.t[:, None]
    predicted = slip_sense(prediction.interface.slip_rate, largest)
    return predicted, slip_sense(seen.slip_rate, largest), reached


def beside_edges(sense: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Nodes and times within one of a change of sense, (m, n)."""
    changes = np.zeros(sense.shape, dtype=bool)
    changes[:-1] |= np.diff(sense, axis=0) != 0
    changes[:, :-1] |= np.diff(sense, axis=1) != 0
    return np.asarray(binary_dilation(changes, iterations=NEAR), dtype=bool)


def rate_rows(prediction: Prediction, simulation: Simulation) -> Iterator[Row]:
    """Relative L1 error of the slip rate over space and time, the four elements at the edge left
    out; the two values are means over V₀.  The largest value where none is predicted."""
    predicted, seen = prediction.interface, simulation.contact
    shown = seen.x > EDGE_CELLS * simulation.element_size
    later = seen.t > EARLY * seen.t[-1]
    wanted, found = (field.slip_rate[np.ix_(later, shown)] for field in (predicted, seen))
    scale, quantity = slip_rate_scale(simulation.scene), "slip rate over space and time"
    if is_nothing(wanted, scale):
        # what slips next to the edge, or before, may be seen wider by what edges may be off
        slipping = ~np.array([is_nothing(record, scale) for record in predicted.slip_rate.T])
        still = ~binary_dilation(slipping, iterations=ZONE_CELLS) & shown
        wanted, found = (field.slip_rate[np.ix_(later, still)] for field in (predicted, seen))
        yield nothing_row(quantity, wanted, found, scale, NO_SLIP)
        return
    yield Row(
        f"{quantity} in L1",
        float(np.abs(wanted).mean()) / scale,
        float(np.abs(found).mean()) / scale,
        float(np.abs(found - wanted).sum() / np.abs(wanted).sum()),
        *_tolerance("slip rate over space and time", 4, simulation),
    )


def sense_rows(prediction: Prediction, simulation: Simulation) -> Iterator[Row]:
    """Parts of the space-time area behind the first wave that slip, each way, and that differ."""
    predicted, seen, reached = sense_maps(prediction, simulation)
    area = float(reached.sum())
    edges = float((beside_edges(predicted) & reached).sum()) / area
    for name, sense in (("forward", 1), ("reverse", -1)):
        parts = [float((found == sense)[reached].sum()) / area for found in (predicted, seen)]
        yield comparison_row(
            f"{name} slip, part of the map",
            parts[0],
            parts[1],
            max(edges / 2, 1 / area),
            "sense of slip: half of what lies within one node of an edge of the predicted map",
        )
    differing = float((predicted != seen)[reached].sum()) / area
    yield Row(
        "sense of slip, part of the map that differs",
        0.0,
        differing,
        differing,
        max(edges, 1 / area),
        "sense of slip: what lies within one node of an edge of the predicted map",
    )


def event_rows(prediction: Prediction, simulation: Simulation) -> Iterator[Row]:
    """Times over T at which slip starts and first reverses at probe points."""
    predicted, seen = prediction.interface, simulation.contact
    end = seen.t[-1]
    length = simulation.scene.material.shear_speed * end
    largest = float(np.abs(predicted.slip_rate).max())
    tolerance = 2 * element_over_length(simulation) + 2 * (seen.t[1] - seen.t[0]) / end
    reason = (
        "onset and reversal: two elements at c_t and two steps, at 1 and 5 % of the largest rate"
    )
    # what is self-similar looks the same everywhere, only coarser near the edge
    for probe in PROBES[-1:] if simulation.scene.is_self_similar else PROBES:
        node = int(np.argmin(np.abs(seen.x - probe * length)))
        place = f"at x = {seen.x[node] / length:.2f} c_t T"
        records = [field.slip_rate[:, node] for field in (predicted, seen)]
        onsets = [onset_time(seen.t, record, SENSE_THRESHOLD * largest) for record in records]
        reversals = [_reversal(seen.t, record, REVERSAL_THRESHOLD * largest) for record in records]
        for name, times in (("slip onset", onsets), ("slip reversal", reversals)):
            yield comparison_row(
                f"{name} {place}",
                None if times[0] is None else times[0] / end,
                None if times[1] is None else times[1] / end,
                tolerance,
                reason,
            )


def _reversal(time: Array, slip_rate: Array, threshold: float) -> float | None:
    """First time at which slip is faster than the threshold against its first direction."""
    fast = np.flatnonzero(np.abs(slip_rate) > threshold)
    if not len(fast):
        return None
    return onset_time(time, np.maximum(-np.sign(slip_rate[fast[0]]) * slip_rate, 0.0), threshold)


def wear_rows(prediction: Prediction, simulation: Simulation) -> Iterator[Row]:
    """Slip and accumulated |slip| at the end, frictional work, and its part in each cycle."""
    predicted, seen = prediction.interface, simulation.contact
    inside = simulation.on_contact
    scene, tolerance = simulation.scene, _tolerance("wear", 1, simulation)
    shown = seen.x < REACH * scene.material.shear_speed * seen.t[-1]
    slip, end = slip_rate_scale(scene) * seen.t[-1], seen.t[-1]
    work = slip * stress_scale(scene)
    for name, wanted, found, unit in (
        ("slip at the end", predicted.slip[-1], seen.slip[-1], slip),
        ("accumulated |slip|", prediction.path, simulation.final_path[inside], slip),
        (
            "frictional work",
            prediction.friction_work,
            simulation.final_work_density[inside],
            work,
        ),
    ):
        if is_nothing(wanted[shown], unit):
            yield nothing_row(name, wanted[shown], found[shown], unit, _no(name))
            continue
        yield Row(
            f"{name} in L1",
            norm(wanted[shown], seen.x[shown], 1),
            norm(found[shown], seen.x[shown], 1),
            relative_error(found[shown], wanted[shown], seen.x[shown], 1),
            *tolerance,
        )
    unit = work * scene.material.shear_speed * end
    for cycle, (wanted_work, found_work) in enumerate(_cycles(scene, predicted, seen), start=1):
        name = f"frictional work in cycle {cycle}"
        if is_nothing(np.array(wanted_work), unit):
            pair = np.array(wanted_work), np.array(found_work)
            yield nothing_row(name, *pair, unit, _no("frictional work"))
            continue
        difference = abs(found_work - wanted_work) / wanted_work
        yield Row(name, wanted_work, found_work, difference, *tolerance)


def _no(name: str) -> str:
    """Why next to nothing of a quantity passes where none is predicted."""
    return f"no {name}: what the simulation has of it is rounding, below 1e-6 of its unit"


def _tolerance(what: str, elements: int, simulation: Simulation) -> tuple[float, str]:
    """Elements over c_t times the time of the load, half an order less under a pressure shock."""
    scene, end = simulation.scene, simulation.end_time
    cell = element_over_length(simulation) * end / load_time(scene, end)
    if scene.load.pressure == 0 or scene.pressure_history.pieces.jumps == ():
        count = "one element" if elements == 1 else f"{elements} elements"
        return elements * cell, f"{what}: {count} over c_t times the time of the load"
    return (
        elements * 0.03 * math.sqrt(100 * cell),
        f"{what} under a pressure shock: damping smears the friction bound over √h at the fronts, "
        f"{3 * elements} % at h = 0.01 c_t T",
    )


def _cycles(
    scene: Scene, predicted: InterfaceHistory, seen: InterfaceHistory
) -> Iterator[tuple[float, float]]:
    """Frictional work per unit thickness in each whole cycle of a harmonic load, by both."""
    if not isinstance(scene.shear_history, Harmonic):
        return
    period = 1 / scene.shear_history.frequency
    whole = int(seen.t[-1] / period * (1 + 1e-9))
    ends = period * np.arange(whole + 1)
    done = []
    for history in (predicted, seen):
        power: Array = np.asarray(
            np.trapezoid(history.slip_rate * history.shear_traction, history.x, axis=1)
        )
        steps = np.diff(history.t) * (power[1:] + power[:-1]) / 2
        done.append(np.interp(ends, history.t, np.concatenate([[0.0], np.cumsum(steps)])))
    yield from zip(*(np.diff(work).tolist() for work in done), strict=True)
