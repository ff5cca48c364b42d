"""Solution of one chunk of a survey; its scenes are swept together, solved alone, or marched."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.engine.marched import Marched
from semianalytic.methods import chosen, solve
from semianalytic.parameters.numbers import with_numbers
from semianalytic.results.answer import Answer
from semianalytic.results.intervals import front_speeds
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError, SlipfrontError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.sweeps.contact_edge import at_contact_edge
from semianalytic.sweeps.sweep import sweep
from slipfront.surveys.plan import Question
from slipfront.surveys.quantities import QUANTITIES, TEXT

Values = dict[str, Any]
Columns = dict[str, NDArray[Any]]

SWEPT = ("friction", "poisson_ratio")
"""Parameters along which scenes are solved together in one sweep."""
DEFAULT_RTOL = 1e-6
"""Accuracy of solved scenes unless one is given; marches have no default."""
SOLVED, MARCHED = "self-similar", "space-time"
_REFUSED = {"method": "none", "origin": "refused"}


def solved_chunk(
    scene: Scene, values: Mapping[str, Array], fixed: Mapping[str, float], question: Question
) -> bytes:
    """Compute all quantities at the points of a chunk and pack them into bytes.

    Values (m,) are those of the parameters at each point, fixed ones the same at all.
    """
    count = len(next(iter(values.values())))
    rows: list[Values] = [{} for _ in range(count)]
    scenes: dict[int, Scene] = {}
    others: dict[int, Scene] = {}
    for i, numbers in enumerate(zip(*(row.tolist() for row in values.values()), strict=True)):
        given = {**fixed, **dict(zip(values, numbers, strict=True))}
        try:
            problem = with_numbers(scene, given)
            swept = problem.lower_material is None and not problem.on_line
            (scenes if swept else others)[i] = problem
        except SlipfrontError as error:
            rows[i] = _refused(error)
    for i, other in others.items():
        rows[i] = _alone(other, question)
    for group in _groups(scenes, values):
        for places, found in _answered([(i, scenes[i]) for i in group], question):
            for i, row in zip(places, found, strict=True):
                rows[i] = row
    return packed(_columns(rows, question))


def _groups(scenes: Mapping[int, Scene], values: Mapping[str, Array]) -> list[list[int]]:
    """Group points whose scenes differ only in parameters that can be swept."""
    others = [values[name] for name in values if name not in SWEPT]
    groups: dict[tuple[float, ...], list[int]] = {}
    for i in scenes:
        groups.setdefault(tuple(float(row[i]) for row in others), []).append(i)
    return list(groups.values())


Found = Iterator[tuple[list[int], list[Values]]]


def _answered(points: Sequence[tuple[int, Scene]], question: Question) -> Found:
    """Yield rows for points whose scenes differ only in parameters that can be swept.

    They are swept together; where a sweep is impossible or refused, each is solved alone.
    """
    places, scenes = [i for i, _ in points], [scene for _, scene in points]
    if len(scenes) > 1 and chosen(scenes[0]).name == SOLVED:
        start = process_time()
        try:
            yield places, _swept(scenes, question, start)
            return
        except SlipfrontError:
            ratios = sorted({scene.material.poisson_ratio for scene in scenes})
        if len(ratios) > 1:  # refusals come from the pressure, which has no friction in it
            for ratio in ratios:
                some = [point for point in points if point[1].material.poisson_ratio == ratio]
                yield from _answered(some, question)
            return
    for i, scene in points:
        yield [i], [_alone(scene, question)]


def _swept(scenes: Sequence[Scene], question: Question, start: float) -> list[Values]:
    """Return the rows of scenes that differ in friction and Poisson ratio, by one sweep."""
    found = sweep(
        scenes[0],
        np.array([scene.coefficient for scene in scenes]),
        question.rtol or DEFAULT_RTOL,
        poisson_ratio=np.array([scene.material.poisson_ratio for scene in scenes]),
    )
    rates, intensities = at_contact_edge(found.solutions)
    rows = [
        _of_solution(solution, origin, float(rate), intensity, question)
        for solution, origin, rate, intensity in zip(
            found.solutions, found.origin, rates, intensities, strict=True
        )
    ]
    seconds = (process_time() - start) / len(rows)
    return [{**row, "seconds": seconds} for row in rows]


def _alone(scene: Scene, question: Question) -> Values:
    """Return the row of one scene."""
    start = process_time()
    try:
        options: dict[str, Any] = {"rtol": question.rtol or DEFAULT_RTOL}
        if chosen(scene).name == MARCHED:
            options = _march_options(scene, question)
        answer: Any = solve(scene, **options)
        if answer.method == MARCHED:
            row = _of_march(answer, question)
        else:
            alike = scene.lower_material is None
            intensity = np.stack(answer.stress_intensity(1.0)) if alike else None
            rate = answer.edge_slip_rate
            row = _of_solution(answer, "from scratch", rate, intensity, question)
    except SlipfrontError as error:
        row = _refused(error)
    return {**row, "seconds": process_time() - start}


def _refused(error: SlipfrontError) -> Values:
    """Return the row of a scene that does not exist or has no answer."""
    return {**_REFUSED, "status": str(error), "seconds": 0.0}


def _of_solution(
    solution: Solution | PairSolution,
    origin: str,
    rate: float,
    intensity: Array | None,
    question: Question,
) -> Values:
    """Return the row of a solution; between different bodies intensity has no two modes."""
    end = question.end_time
    row: Values = {
        "edges": solution.edge_speeds,
        "sense": [zone.sense for zone in solution.zones],
        "edge_slip_rate": rate,
        "error_estimate": solution.error_estimate,
        "status": solution.status,
        "origin": origin,
        "method": SOLVED,
    }
    if intensity is not None:
        row["stress_intensity"] = intensity
    for part in solution.openings:
        row["opening"] = part.inner, part.outer
    if end is not None:
        row |= {"end_time": end, **_totals(solution, end)}
        row["largest_slip"] = float(solution.max_slip(end))
    return row | _fields(solution, question)


def _march_options(scene: Scene, question: Question) -> dict[str, Any]:
    """Return the settings with which a scene is marched."""
    names = ("end_time", "nodes", "rtol", "length")
    options: dict[str, Any] = {**scene.run}
    options |= {name: known for name in names if (known := getattr(question, name)) is not None}
    if scene.on_line and question.t:
        options = {"end_time": max(question.t), **options, "times": question.t}
    if scene.on_line and "end_time" not in options:
        raise SceneError("survey: end_time is missing; give the end of the march.")
    return options


def _of_march(marched: Marched, question: Question) -> Values:
    seen, end, scene = marched.seen, marched.end_time, marched.scene
    slipped, known = np.isfinite(seen.onset), marched.interface
    row: Values = {
        "end_time": end,
        "largest_slip_rate": float(seen.slip_rate.max()),
        "largest_slip": float(marched.totals.max_slip.max()),
        "onset": float(seen.onset.min()) if slipped.any() else np.nan,
        "reach_of_slip": float(np.abs(known.x[slipped]).max(initial=0.0)),
        **_totals(marched, end),
        "error_estimate": marched.error_estimate,
        "status": marched.caution or marched.status,
        "origin": "marched",
        "method": MARCHED,
    }
    if not scene.on_line:
        return row | _fields(marched, question)
    row |= {
        "time_of_largest_slip_rate": float(marched.totals.t[marched.totals.peak_rate.argmax()]),
        "rupture_speed": marched.rupture_speed,
        "slipped_length": marched.slipped_length,
        "frictional_work": marched.work["friction"],
        "error_estimate": marched.error_estimates["slip"],
        "slip_rate_error": marched.error_estimates["slip_rate"],
        "status": marched.status,
    }
    if scene.may_open:
        row["largest_gap"] = float(known.gap[:, known.touching].max(initial=0.0))
    if question.x:
        x, onset = np.array(question.x), np.where(slipped, seen.onset, np.nan)
        row["arrival"] = marched.at(onset, x)
        row["front_speed"] = marched.at(front_speeds(onset, marched.spacing), x)
        names = question.fields if question.t else ()
        row |= {name: marched.at(getattr(known, name), x) for name in names}
    return row


def _totals(answer: Answer | PairSolution, end: float) -> Values:
    return {
        name: float(getattr(answer, name)(end)) for name in ("accumulated_slip", "frictional_work")
    }


def _fields(answer: Answer | PairSolution, question: Question) -> Values:
    """Return the requested fields at all positions and times, each (t, x)."""
    x, t = np.array(question.x), np.array(question.t)
    return {name: getattr(answer, name)(x, t[:, None]) for name in question.fields if len(x)}


def _columns(rows: Sequence[Values], question: Question) -> Columns:
    """Return rows as arrays (m, ...), for those quantities that any point has."""
    lengths = {
        "edge": 2,
        "mode": 2,
        "zone": max((len(row["sense"]) for row in rows if "sense" in row), default=0),
        "t": len(question.t),
        "x": len(question.x),
    }
    columns: Columns = {}
    for name, quantity in QUANTITIES.items():
        known = [(i, row[name]) for i, row in enumerate(rows) if name in row]
        if not known:
            continue
        if quantity.kind == TEXT:
            columns[name] = np.array([row.get(name, "") for row in rows], dtype=object)
            continue
        shape = (len(rows), *(lengths[along] for along in quantity.along))
        columns[name] = column = np.full(shape, quantity.absent, dtype=quantity.kind)
        for i, value in known:
            if quantity.along[:1] == ("zone",):
                column[i, : len(value)] = value
            else:
                column[i] = value
    return columns


def packed(columns: Columns) -> bytes:
    """Pack arrays into the bytes of a compressed .npz file, text as codes and their table."""
    arrays: dict[str, Any] = {}
    for name, column in columns.items():
        if QUANTITIES[name].kind == TEXT:
            words, codes = np.unique(column.astype(str), return_inverse=True)
            arrays[f"{name}.words"], arrays[name] = words, codes.astype(np.uint32)
        else:
            arrays[name] = column
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def unpacked(data: bytes) -> Columns:
    """Return the arrays that `packed` has packed."""
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        columns: Columns = {}
        for name in QUANTITIES:
            if name not in arrays:
                continue
            column = arrays[name]
            if QUANTITIES[name].kind == TEXT:
                column = arrays[f"{name}.words"].astype(object)[column]
            columns[name] = column
    return columns
