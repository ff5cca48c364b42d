"""Comparison over space and time: sense of slip, reversals, wear; for any load history."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from compare.comparison.measures import is_nothing, onset_time
from compare.comparison.prediction import Prediction
from compare.comparison.rows import (
    EDGE_CELLS,
    NO_SLIP,
    ZONE_CELLS,
    Row,
    comparison_row,
    element_over_length,
    error_row,
    nothing_row,
)
from compare.comparison.scales import load_time, slip_rate_scale, stress_scale
from semianalytic import Harmonic, InterfaceHistory
from semianalytic.scene.scene import Scene
from semianalytic.scene.units import unit

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
    seen = simulation.interface
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
    out; the two values are means.  The largest value where none is predicted."""
    predicted, simulated = prediction.interface, simulation.interface
    x, t = simulated.x, simulated.t
    shown, later = x > EDGE_CELLS * simulation.element_size, t > EARLY * t[-1]
    scale, quantity = slip_rate_scale(simulation.scene), "slip rate over space and time"
    part = np.ix_(later, shown)
    if not is_nothing(predicted.slip_rate[part], scale):
        yield error_row(
            quantity,
            predicted.slip_rate[part],
            simulated.slip_rate[part],
            x[shown],
            time=t[later],
            tolerance=_tolerance(quantity, 4, simulation),
            unit="V₀",
            scale=scale * float(np.ptp(x[shown]) * np.ptp(t[later])),
        )
        return
    # what slips next to the edge, or before, may be seen wider by what edges may be off
    slipping = ~np.array([is_nothing(record, scale) for record in predicted.slip_rate.T])
    part = np.ix_(later, ~binary_dilation(slipping, iterations=ZONE_CELLS) & shown)
    rates = predicted.slip_rate[part], simulated.slip_rate[part]
    yield nothing_row(quantity, *rates, scale, NO_SLIP, "V₀")


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
    """Times in T at which slip starts and first reverses at probe points."""
    predicted, simulated = prediction.interface, simulation.interface
    end = simulated.t[-1]
    length = simulation.scene.material.shear_speed * end
    largest = float(np.abs(predicted.slip_rate).max())
    tolerance = 2 * element_over_length(simulation) + 2 * (simulated.t[1] - simulated.t[0]) / end
    reason = (
        "onset and reversal: two elements at c_t and two steps, at 1 and 5 % of the largest rate"
    )
    # what is self-similar looks the same everywhere, only coarser near the edge
    for probe in PROBES[-1:] if simulation.scene.is_self_similar else PROBES:
        node = int(np.argmin(np.abs(simulated.x - probe * length)))
        place = f"at x = {simulated.x[node] / length:.2f} c_t T"
        records = [field.slip_rate[:, node] for field in (predicted, simulated)]
        for name, first_time, share in (
            ("slip onset (1 % of peak)", onset_time, SENSE_THRESHOLD),
            ("slip reversal", _reversal, REVERSAL_THRESHOLD),
        ):
            onsets = [first_time(simulated.t, record, share * largest) for record in records]
            expected, seen = (None if time is None else time / end for time in onsets)
            yield comparison_row(f"{name} {place}", expected, seen, tolerance, reason, "T")


def _reversal(time: Array, slip_rate: Array, threshold: float) -> float | None:
    """First time at which slip is faster than the threshold against its first direction."""
    fast = np.flatnonzero(np.abs(slip_rate) > threshold)
    if not len(fast):
        return None
    return onset_time(time, np.maximum(-np.sign(slip_rate[fast[0]]) * slip_rate, 0.0), threshold)


def slip_and_work_rows(prediction: Prediction, simulation: Simulation) -> Iterator[Row]:
    """Slip and accumulated |slip| at the end, frictional work, and its part in each cycle.

    The two values are integrals over the contact.
    """
    predicted, simulated = prediction.interface, simulation.interface
    scene, tolerance = simulation.scene, _tolerance("wear", 1, simulation)
    x, end = simulated.x, simulated.t[-1]
    shown = x < REACH * scene.material.shear_speed * end
    slip = slip_rate_scale(scene) * end, "V₀ T", unit("length^2", scene.units)
    work = slip[0] * stress_scale(scene), "τ₀ V₀ T", unit("stress length^2", scene.units)
    for name, expected, seen, (scale, symbol, summed) in (
        ("slip at the end", predicted.slip[-1], simulated.slip[-1], slip),
        ("accumulated |slip|", prediction.final_path, simulation.final_path, slip),
        ("frictional work", prediction.final_work_density, simulation.final_work_density, work),
    ):
        pair = expected[shown], seen[shown]
        if is_nothing(pair[0], scale):
            yield nothing_row(name, *pair, scale, _no(name), symbol)
        else:
            yield error_row(name, *pair, x[shown], tolerance=tolerance, unit=summed)
    scale = work[0] * scene.material.shear_speed * end
    for cycle, (expected, seen) in enumerate(_cycles(scene, predicted, simulated), start=1):
        name = f"frictional work in cycle {cycle}"
        if is_nothing(np.array(expected), scale):
            pair = np.array(expected), np.array(seen)
            yield nothing_row(name, *pair, scale, _no("frictional work"), "τ₀ V₀ c_t T²")
        else:
            error = abs(seen - expected) / expected
            yield Row(name, expected, seen, error, *tolerance, work[2], relative=True)


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
    scene: Scene, predicted: InterfaceHistory, simulated: InterfaceHistory
) -> Iterator[tuple[float, float]]:
    """Frictional work per unit thickness in each whole cycle of a harmonic load, by both."""
    if not isinstance(scene.shear_history, Harmonic):
        return
    period = 1 / scene.shear_history.frequency
    whole = int(simulated.t[-1] / period * (1 + 1e-9))
    ends = period * np.arange(whole + 1)
    done = []
    for history in (predicted, simulated):
        power: Array = np.asarray(
            np.trapezoid(history.slip_rate * history.shear_traction, history.x, axis=1)
        )
        steps = np.diff(history.t) * (power[1:] + power[:-1]) / 2
        done.append(np.interp(ends, history.t, np.concatenate([[0.0], np.cumsum(steps)])))
    yield from zip(*(np.diff(work).tolist() for work in done), strict=True)
