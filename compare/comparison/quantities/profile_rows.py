"""Rows of fields along the interface at the end of a run, predicted and simulated."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compare.comparison.case import EDGE_CELLS, UNSEEN, Case, own_wear, too_narrow, worn_of
from compare.comparison.judging import profile_row
from compare.comparison.measures import NOTHING, ROUNDING, norm, within, worn
from compare.comparison.rows import Row
from semianalytic.results.answer import OpenInterval, SlipInterval
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.arrays import Array

Answers = Callable[[ArrayLike, ArrayLike], Array]

NEAREST, FARTHEST = 0.02, 1.9
"""Positions over c_t T between which slip is compared: not at the edge, nor at the P front."""
LAST = slice(-1, None)
POINTS = 2000
"""Number of points at which a prediction is integrated apart from the nodes."""


def slip_rate_rows(case: Case) -> Iterator[Row]:
    """Rows of the relative errors of slip rate and slip at the end; their bars include zones too
    narrow for the mesh.

    Slip rates of all meshes and of the prediction are means over the last window of the coarsest
    mesh.
    """
    reach, end = (NEAREST * case.length, _farthest(case)), np.array([case.end_time])

    def mean_rate(history: InterfaceHistory) -> Array:
        return case.mean_rate(history, end)[0]

    yield profile_row(
        case,
        "slip rate",
        "slip rate",
        lambda answer, history: mean_rate(history),
        lambda number: mean_rate(case.runs[number].interface),
        reach,
        exact=_norm(case, partial(_exact_rate, case), reach, case.rate),
        unseen=case.norm_of(_unseen_rate(case) / case.rate, reach),
        scale=(case.rate, "V₀"),
        driven=lambda number: case.strength_changes[number][-1],
        showing=case.showing("slip_rate", LAST),
        jumps=True,
    )
    yield _end_row(
        case,
        "slip",
        reach,
        unseen=case.norm_of(_unseen_wear(case)[0] / case.unit("slip")[0], reach),
        driven=partial(_driven_by, case, 0),
    )


def _end_row(case: Case, name: str, reach: tuple[float, float], **how: Any) -> Row:
    """Row of a field at the end between two positions [length]; `how` as for `profile_row`."""
    words, (value, unit, _) = name.replace("_", " "), case.unit(name)
    return profile_row(
        case,
        words,
        words,
        lambda answer, history: np.asarray(getattr(history, name)[-1]),
        lambda number: np.asarray(getattr(case.runs[number].interface, name)[-1]),
        reach,
        exact=_norm(case, getattr(case.prediction, name), reach, value),
        scale=(value, unit),
        **how,
    )


def _exact_rate(case: Case, x: ArrayLike, t: ArrayLike) -> Array:
    """Return the mean slip rate of the prediction over the window before a time."""
    if not case.window:
        return case.prediction.slip_rate(x, t)
    late, early = (case.prediction.slip(x, at) for at in (t, np.asarray(t) - case.window))
    return (late - early) / case.window


def _unseen_rate(case: Case) -> Array:
    """Mean |slip rate| of the prediction over the last window, counting only slip in zones too
    narrow for the mesh, (n,)."""
    times = case.seen.t
    start = case.end_time - max(case.window, float(times[-1] - times[-2]))
    inside = within(times, start, case.end_time)
    rate = np.where(case.narrow, np.abs(case.at_nodes.slip_rate), 0.0)[inside]
    return np.asarray(np.trapezoid(rate, times[inside], axis=0) / np.ptp(times[inside]))


def gap_rows(case: Case) -> Iterator[Row]:
    """Row of the relative error of the gap at the end, if any opens."""
    if not case.opens:
        return
    scale, reach = case.unit("gap")[0], _disturbed(case)
    gap = case.at_nodes.gap[-1:]
    unseen = case.norm_of(np.where(too_narrow(gap > 0), gap, 0.0)[0] / scale, reach)
    yield _end_row(case, "gap", reach, unseen=unseen, meshes=case.showing("gap", LAST))


def wear_rows(case: Case) -> Iterator[Row]:
    """Rows of accumulated |slip| and frictional work per area at the end."""
    slip = case.rate * case.end_time
    unseen, back, summed = _unseen_wear(case), _unseen_return(case), _unseen_between(case)
    for part, (name, kind, field, scale, symbol) in enumerate(
        (
            ("accumulated |slip|", "slip", "final_path", slip, "V₀ T"),
            ("frictional work", "work", "final_work_density", slip * case.stress, "τ₀ V₀ T"),
        )
    ):
        if kind == "work" and case.scene.coefficient == 0 == case.prediction.scene.coefficient:
            continue
        start = NEAREST * case.length
        if kind == "work" and case.scene.superposition.taken_off.pressure:
            start = max(start, _beside_edge(case))  # the pressure can be singular there
        reach = start, _farthest(case)
        yield profile_row(
            case,
            name,
            kind,
            partial(worn_of, part),
            [np.asarray(getattr(run, field)) for run in case.runs].__getitem__,
            reach,
            exact=_worn_norm(case, part, reach, scale),
            unseen=case.norm_of((unseen[part] + back[part] + summed[part]) / scale, reach),
            scale=(scale, symbol),
            driven=partial(_driven_by, case, part),
        )


def traction_rows(case: Case) -> Iterator[Row]:
    """Rows of the relative L1 errors of shear traction and pressure at the end.

    They cover the disturbed interface without the four elements next to the edge, where tractions
    can be singular.
    """
    reach = _beside_edge(case), _disturbed(case)[1]
    yield _end_row(case, "shear_traction", reach, unseen=_unseen_shear(case, reach))
    yield _end_row(case, "pressure", reach)


def _driven_by(case: Case, part: int, number: int) -> Array:
    """Change of slip over V₀ T (part 0) or of work per area over τ₀ V₀ T (1) due to the change of
    strength from one mesh to the next, (n,) at the nodes of the coarser run."""
    run, rate = case.runs[number + 1].interface, case.strength_changes[number]
    if part:
        rate = rate * np.abs(run.shear_traction) / case.stress
    return np.asarray(np.trapezoid(rate, run.t, axis=0)) / case.end_time


def _unseen_wear(case: Case) -> tuple[Array, Array]:
    """Predicted accumulated |slip| and frictional work per area at nodes that slip only in zones
    too narrow for the mesh, (n,) each; 0 at other nodes."""
    ever = np.abs(case.at_nodes.slip_rate) > NOTHING * case.rate
    unseen = (case.narrow == ever).all(axis=0)
    path, work = case.worn_at_nodes
    return np.where(unseen, path, 0.0), np.where(unseen, work, 0.0)


def _unseen_return(case: Case) -> tuple[Array, Array]:
    """Predicted accumulated |slip| and work per area of slip back and forth that the mesh misses,
    (n,) each: twice the slip against the final slip of a node in zones too narrow for the mesh."""
    seen = case.at_nodes
    back = case.narrow & (np.sign(seen.slip_rate) == -np.sign(seen.slip[-1]))
    rate = np.where(back, np.abs(seen.slip_rate), 0.0)
    path = np.trapezoid(rate, seen.t, axis=0)
    work = np.trapezoid(rate * np.abs(seen.shear_traction), seen.t, axis=0)
    return np.asarray(2 * path), np.asarray(2 * work)


def _unseen_between(case: Case) -> tuple[Array, Array]:
    """Change of predicted accumulated |slip| and work per area if every second time is left out of
    their sums, (n,) each; 0 where the prediction has summed them itself."""
    history = case.at_nodes
    x, end, last = history.x, case.end_time, len(history.t) - 1
    if own_wear(case.prediction, x, end, 0) is not None:
        return np.zeros(len(x)), np.zeros(len(x))
    kept = np.union1d(np.arange(0, last, 2), last)
    fields = ("t", "slip", "slip_rate", "shear_traction", "pressure", "gap")
    fewer = replace(history, **{name: getattr(history, name)[kept] for name in fields})
    path, work = (
        np.abs(fine - other) for fine, other in zip(worn(history), worn(fewer), strict=True)
    )
    return path, work


def _unseen_shear(case: Case, reach: tuple[float, float]) -> float:
    """Norm over τ₀ c_t T of the effect of stick and slip of too few nodes on the shear traction
    between two positions at the end.

    A zone at the edge that the mesh does not show keeps the traction there at f p, which moves the
    singular field beyond it by up to its width.  Two different bodies that pressed each other
    with slip until 0.0016 c_t, the traction was 1.5 bars off without this part, and 0.4 with it.
    """
    width, end = 0.0, case.end_time
    parts: list[SlipInterval | OpenInterval] = [
        *case.prediction.zones_at(end),
        *case.prediction.openings_at(end),
    ]
    for part in sorted(parts, key=lambda part: part.start):
        if part.start <= (1 + ROUNDING) * width < UNSEEN * case.simulation.element_size:
            width = part.end
    moved = 0.0
    if width < UNSEEN * case.simulation.element_size:
        shown = within(case.seen.x, *reach)
        shear, pressure = case.at_nodes.shear_traction[-1], case.at_nodes.pressure[-1]
        vary = (np.abs(np.diff(field[shown])).sum() for field in (shear, pressure))
        moved = width * float(next(vary) + case.scene.coefficient * next(vary))
    return moved / (case.stress * case.length) + case.norm_of(
        _unseen_stick(case) / case.stress, reach
    )


def _unseen_stick(case: Case) -> Array:
    """Deviation of the predicted shear traction at the end from interpolation between the nodes on
    either side, in gaps between zones with too few nodes, (n,); 0 elsewhere."""
    gaps, x = case.narrow_gaps[-1], case.seen.x
    traction = case.at_nodes.shear_traction[-1]
    if not gaps.any():
        return np.zeros(len(x))
    return np.asarray(np.interp(x, x[~gaps], traction[~gaps]) - traction)


def _beside_edge(case: Case) -> float:
    """Position at which profiles begin beyond the elements left out next to the edge [length]."""
    return (EDGE_CELLS + 0.5) * case.simulation.element_size


def _farthest(case: Case) -> float:
    """Position up to which slip is compared [length], counted by the faster shear wave."""
    return FARTHEST * max(body.shear_speed for body in case.scene.bodies) * case.end_time


def _disturbed(case: Case) -> tuple[float, float]:
    return NEAREST * case.length, case.fastest_speed * case.end_time


def _norm(case: Case, answer: Answers, reach: tuple[float, float], scale: float) -> float:
    """L1 norm of a prediction between two positions at the end, over its scale and c_t T."""
    x = _between(case, reach)
    return norm(answer(x, case.end_time) / scale, x / case.length, 1)


def _worn_norm(case: Case, part: int, reach: tuple[float, float], scale: float) -> float | None:
    """L1 norm of predicted accumulated |slip| (part 0) or work per area (1) between two positions
    at the end, over its scale and c_t T; None if the prediction has not summed them itself."""
    x = _between(case, reach)
    own = own_wear(case.prediction, x, case.end_time, part)
    return None if own is None else norm(own / scale, x / case.length, 1)


def _between(case: Case, reach: tuple[float, float]) -> Array:
    """Evenly spaced positions between two, as far as the contact was simulated."""
    end = min(reach[1], float(case.seen.x[-1]))
    return np.linspace(max(reach[0], end / POINTS), end, POINTS)
