"""Speeds of the Rayleigh, S and P signals along both faces, predicted and simulated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from compare.comparison.bars import error_bar
from compare.comparison.case import Case
from compare.comparison.judging import judged, mesh_changes
from compare.comparison.measures import ROUNDING
from compare.comparison.quantities.arrivals import (
    LARGEST_MISFIT,
    FrontWindow,
    Table,
    Waveform,
    aligned_speed,
    alignment_bar,
    front_window,
    left_over,
    roughness,
    smeared,
    tabulated,
)
from compare.comparison.rows import Row
from compare.comparison.scales import contact_fronts, scene_fronts
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

if TYPE_CHECKING:
    from fem import Simulation


LEAST_ROUGHNESS = 1e-3
"""Least root mean square of a signal, over τ₀ or V₀, that is read.  Among 288 fronts of 119 drawn
scenes and 20 named ones, the 25 weakest, of 0.0010 to 0.0012, were within their bar.  Twice this
value would leave them all out; half of it reads signals that are as weak as the error of the field
around them."""
FARTHEST = 1.5
"""Position over c_l T up to which the waveform around the P front is compared."""
COARSE_MISFIT = 0.9
"""Largest misfit on a coarser mesh, which only has to show how much larger its error is."""
ARRIVAL_FLOOR = 0.2
"""Uncertainty of the position of a front due to nodes alone, in elements.  Among 460 fronts
measured two were beyond their bar with this value, by less than a third; without it, P fronts on
the slot face would have been beyond by 0.8."""


@dataclass(frozen=True)
class Face:
    """One field on one face: its predicted values and those recorded by a run.

    `predict` returns predicted values over the reference value at velocities [length / time], and
    `record`, for a simulation, increasing distances from the edge (n,) [length], times (m,) [time]
    and values over the reference value (m, n).
    """

    name: str
    predict: Waveform
    record: Callable[[Simulation], tuple[Array, Array, Array]]


def arrival_rows(case: Case) -> Iterator[Row]:
    """Speeds in c_t of the first signal on the interface and on the slot face, and of the Rayleigh
    signal on the slot face.

    A signal is read off the field whose predicted waveform is roughest there, relative to the
    reference stress or slip rate and smeared as by damping.  It is read at the last time at which
    the window around the front is still on the recorded part of the face.  There are no rows for
    predictions that do not reach beyond all fronts, such as marches, and none for the slot face
    where the prediction does not know it or the load moves over it.  An S front behind a P front,
    or a Rayleigh front on the interface, is too close to others for the mesh at 2h in half of the
    scenes; on the slot, `slot_rows` cover them.
    """
    if not _reaches(case):
        return
    scene = case.prediction.scene
    own, fronts = scene_fronts(scene), contact_fronts(scene)
    end, prediction = case.end_time, case.prediction
    ends = [(zone.start, zone.end) for zone in prediction.zones_at(end)]
    ends += [(opening.start, opening.end) for opening in prediction.openings_at(end)]
    edges = [edge / end for both in ends for edge in both if 0 < edge < math.inf]
    signals: tuple[str, ...] = (max(fronts, key=fronts.__getitem__),)
    faces = [("interface", fronts, signals, edges, _interface_fields(case))]
    slot_velocity = getattr(case.prediction, "slot_velocity", None)
    # a front of the load runs over the slot among the waves, and covers the first of them
    if slot_velocity is not None and not case.scene.front_slowness:
        first = list(own)[-1]
        signals = ("Rayleigh", first) if "Rayleigh" in own else (first,)
        faces.append(("slot face", own, signals, [], _slot_fields(case, slot_velocity)))
    for face, waves, signals, others, fields in faces:
        for signal in signals:
            front = waves[signal]
            window = front_window(front, {*waves.values(), *others} - {front})
            row = _arrival_row(case, f"{signal} front, {face}", window, fields)
            if row is not None:
                yield row


def _reaches(case: Case) -> bool:
    """Whether a prediction has values beyond all fronts at the end."""
    speed = case.fastest_speed
    try:
        case.prediction.slip_rate(np.array([FARTHEST * speed * case.end_time]), case.end_time)
    except SceneError:
        return False
    return True


def _arrival_row(case: Case, name: str, window: FrontWindow, fields: list[Face]) -> Row | None:
    """Row of one front; None where no field has a signal there."""
    shear_speed = case.scene.material.shear_speed
    if not all(_late(case.simulation, field, window) for field in fields):
        reason = "no step is stored while the front is on the recorded part; store all of them"
        row = Row(name, "arrival", window.front / shear_speed, None, None, None, None, "c_t")
        return replace(row, obstacle=reason)
    samples = window.samples()
    sharp = [tabulated(field.predict, window) for field in fields]
    templates = [
        _template(case.simulation, field, waveform, window)
        for field, waveform in zip(fields, sharp, strict=True)
    ]
    strength = [roughness(template(samples), samples) for template in templates]
    strongest = int(np.argmax(strength))
    if strength[strongest] < LEAST_ROUGHNESS:
        return None
    field = fields[strongest]
    velocity, _ = _recorded(case.simulation, field, window)
    template = templates[strongest]
    exact = aligned_speed(velocity, template(velocity), template, window)
    speeds: list[float | None] = []
    left: list[tuple[Array, Array]] = []
    for run in (case.simulation, *case.coarser):
        if not _late(run, field, window):
            speeds.append(None)
            continue
        smooth, misfit = template, LARGEST_MISFIT
        if run is not case.simulation:
            smooth, misfit = _template(run, field, sharp[strongest], window), COARSE_MISFIT
        recorded = _recorded(run, field, window)
        speeds.append(aligned_speed(*recorded, smooth, window, misfit))
        if speeds[-1] is not None:
            left.append(left_over(*recorded, smooth, window, speeds[-1]))
    values = [None if speed is None else speed / shear_speed for speed in (exact, *speeds)]
    at_nodes, simulated, changes = values[0], values[1], mesh_changes(values[1:])
    row = Row(
        f"{name} ({field.name})",
        "arrival",
        window.front / shear_speed,
        at_nodes,
        simulated,
        None if at_nodes is None or simulated is None else simulated - at_nodes,
        None,
        "c_t",
    )
    finer = 2 * case.simulation.resolution
    if at_nodes is None:
        return replace(row, obstacle="too few nodes lie about the front", resolution=finer)
    if simulated is None:
        reason = "the front is not sharp enough to be read"
        return replace(row, obstacle=reason, resolution=finer)
    floor = ARRIVAL_FLOOR * _cell(case.simulation, field, window)
    error = error_bar(changes, floor) if changes else None
    at, unexplained = left[0]
    if len(left) > 1:
        # An error that two meshes share is that of the prediction, not theirs.
        unexplained = unexplained - np.interp(at, *left[1])
    added = alignment_bar(at, unexplained, template, window, simulated * shear_speed) / shear_speed
    return judged(case, row, error, added=added)


def _template(run: Simulation, field: Face, sharp: Table, window: FrontWindow) -> Waveform:
    """Predicted waveform as smeared by the damping of a run.

    Damping C = eta K spreads a front over sqrt(eta t) in time, eta = damping h / c_t.
    """
    width = window.front * math.sqrt(run.damping * _cell(run, field, window))
    return smeared(sharp, width)


def _cell(run: Simulation, field: Face, window: FrontWindow) -> float:
    """Element size over c_t t at the time at which a front is read."""
    late = _late(run, field, window)
    return run.element_size / (run.scene.material.shear_speed * late)


def _late(run: Simulation, field: Face, window: FrontWindow) -> float:
    """Time at which a front is read; 0 where no stored step shows it."""
    distance, time, _ = field.record(run)
    return _last_time(distance, time, window.upper)


def _recorded(run: Simulation, field: Face, window: FrontWindow) -> tuple[Array, Array]:
    """Similarity velocities and values of a field at the time at which a front is read."""
    distance, time, values = field.record(run)
    late = _last_time(distance, time, window.upper)
    return distance / late, values[np.searchsorted(time, late)]


def _last_time(distance: Array, time: Array, velocity: float) -> float:
    """Last recorded time at which a signal of a given velocity is still on the record."""
    return float(time[velocity * time <= distance[-1] * (1 + ROUNDING)][-1])


def _interface_fields(case: Case) -> list[Face]:
    scales = {"shear_traction": case.stress, "pressure": case.stress, "slip_rate": case.rate}
    return [
        Face(
            name.replace("_", " "),
            _over(getattr(case.prediction, name), scale, case.end_time),
            _recording("interface", name, scale),
        )
        for name, scale in scales.items()
    ]


def _slot_fields(
    case: Case, slot_velocity: Callable[[Array, float], tuple[Array, Array]]
) -> list[Face]:
    def component(index: int) -> Waveform:
        return lambda v: slot_velocity(-v * case.end_time, case.end_time)[index] / case.rate

    names = (("v_z" if case.scene.antiplane else "v_x", "velocity_x"), ("v_y", "velocity_y"))
    return [
        Face(name, component(index), _recording("slot", field, case.rate))
        for index, (name, field) in enumerate(names)
    ]


def _recording(
    face: str, name: str, scale: float
) -> Callable[[Simulation], tuple[Array, Array, Array]]:
    """Return the function that reads a field of the interface or of the slot off a run, over its
    scale and from the edge outward."""

    def of(run: Simulation) -> tuple[Array, Array, Array]:
        history = getattr(run, face)
        outward = np.argsort(np.abs(history.x))
        return np.abs(history.x)[outward], history.t, getattr(history, name)[:, outward] / scale

    return of


def _over(predict: Callable[[Array, float], Array], scale: float, time: float) -> Waveform:
    """Waveform over similarity velocity, in units of a reference value."""
    return lambda velocity: predict(velocity * time, time) / scale
