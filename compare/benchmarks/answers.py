"""Answers to the problem sheets: numbers, records at the stations, and files with checksums.

What is self-similar is solved to `RTOL` and written to twelve digits, ten of them sure, or between
different bodies to `PAIR_RTOL`, nine of them sure; what is marched is written to as many decimals
as its error estimates leave, and one more.  Everything is in units mu = rho = c_t = T = 1.
"""

from __future__ import annotations

import csv
import hashlib
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache, partial
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import maximum_filter1d
from scipy.optimize import brentq

from compare.benchmarks.interfaces.reference import (
    Reference,
    reference_changes,
    reference_document,
    reference_of,
)
from compare.benchmarks.interfaces.sheets import InterfaceSheet
from compare.benchmarks.sheet import OPENING, SI_SCALES, SLIP, STATIONS, THRESHOLD, TIMES, Sheet
from compare.benchmarks.sheets import ALL_SHEETS
from compare.comparison.measures import first_above
from compare.comparison.scales import stress_scale
from compare.output.files import write_text
from compare.records.record import QUANTITIES
from semianalytic import (
    LineSolution,
    Marched,
    Pair,
    PairSolution,
    Scene,
    Solution,
    WholeLine,
    solve,
)
from semianalytic.dissimilar.described import pair_document
from semianalytic.results.answer import TOTALS
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.documents import scene_document
from semianalytic.whole_line.named import line_document

Array = NDArray[np.float64]

RTOL, PAIR_RTOL = 1e-12, 1e-10
NODES = 4000
"""Nodes of the march that is written; runs are scored against one on `SCORING_NODES`."""
SCORING_NODES = 1000
DIGITS, DECIMALS = 12, 13
SAME = 1e-10
"""Largest difference from a written number that is ignored, over the largest of its name."""
READING_SAFETY, MARCH_TOLERANCE = 4.0, 2e-6
"""Factor and addend of the error estimates of a march.  Measured: with them marches on 1000 to 8000
nodes agree."""
DATA = Path(str(files("compare.benchmarks").joinpath("data")))
SUMS = "SHA256SUMS"


Answered = Solution | Marched | LineSolution | PairSolution | Reference
"""Answers to sheets: of scenes, solved or marched, of whole lines, of different bodies, and of
interfaces."""


@cache
def answer_to(sheet: Sheet, nodes: int = SCORING_NODES) -> Answered:
    """The answer to a sheet: solved, marched on so many nodes, or of an interface as written."""
    if isinstance(sheet, InterfaceSheet):
        return reference_of(written_document(sheet))
    problem = sheet.problem
    if isinstance(problem, WholeLine):
        answer = solve(problem)
        assert isinstance(answer, LineSolution)  # half-lines are scenes
        return answer
    if isinstance(problem, Pair):
        return solve(problem, rtol=PAIR_RTOL)
    return (
        solve(sheet.scene, method="space-time", end_time=1.0, nodes=nodes)
        if sheet.is_marched
        else solve(sheet.scene, rtol=RTOL)
    )


def arrival_level(sheet: Sheet) -> float:
    """Slip rate above which, or pressure below which, a station counts as reached."""
    if isinstance(sheet, InterfaceSheet):
        return sheet.level
    problem = sheet.problem
    if isinstance(problem, WholeLine):
        return THRESHOLD * problem.excess
    held = sheet.scene.superposition.in_place.pressure
    unit = held if sheet.arrival == OPENING else stress_scale(sheet.scene)
    return THRESHOLD * unit


def first_crossing(sheet: Sheet, t: Array, values: Mapping[str, Array]) -> float:
    """When a record (n,) first passes `arrival_level`, linear between samples; inf if never."""
    excess = _excess(sheet, values)
    known = np.isfinite(excess)
    time = first_above(t[known], excess[known], 0.0)
    return math.inf if time is None else time


def _excess(sheet: Sheet, values: Mapping[str, Array]) -> Array:
    """Return a value that is positive wherever a station counts as reached."""
    level = arrival_level(sheet)
    if sheet.arrival == OPENING:
        return np.asarray(level - values["pressure"])
    return np.asarray(np.abs(values["slip_rate"]) - level)


_READ = {SLIP: "slip_rate", OPENING: "pressure"}


def arrival_quantity(sheet: Sheet) -> str:
    """Return the quantity whose threshold defines arrivals; "" if nothing is timed."""
    return _READ.get(sheet.arrival, "")


def arrival_times(sheet: Sheet, answer: Answered, x: ArrayLike) -> Array:
    """When slip or opening arrives at positions x (n,) [length]; inf if not until T."""
    x = np.asarray(x, dtype=float)
    name = arrival_quantity(sheet)
    if not name:
        return np.full(x.shape, math.inf)
    if isinstance(answer, Reference):
        return answer.arrivals_at(x)
    if isinstance(answer, Marched):
        t = answer.interface.t
        records = getattr(answer, name)(x, t[:, None]).T
        return np.array([first_crossing(sheet, t, {name: one}) for one in records])
    times = x / _arrival_speed(sheet, answer)
    return np.where(times <= 1, times, math.inf)


def _arrival_speed(sheet: Sheet, solution: Solution | LineSolution | PairSolution) -> float:
    """Return the speed of the farthest point that counts as reached [length / time]."""
    name = arrival_quantity(sheet)

    def excess(velocity: float) -> float:
        return float(_excess(sheet, {name: getattr(solution, name)(velocity, 1.0)}))

    front = (solution.openings if sheet.arrival == OPENING else solution.zones)[-1]
    # linear in the root of the distance from a front, where slip rate is a power of it
    steps = (front.outer - front.inner) * np.linspace(0, 1, 400)[1:] ** 2
    behind = next(front.outer - step for step in steps if excess(front.outer - step) > 0)
    ahead = 1.01 * front.outer
    return float(brentq(excess, behind, ahead, xtol=1e-15, rtol=1e-14))


def content_of(sheet: Sheet, answer: Answered) -> dict[str, Array]:
    """All numbers of an answer by name.

    Returns
    -------
    dict
        Where the sheet is solved: "zones", rows of inner and outer edge over c_t and sense;
        "openings", rows of inner and outer edge; "edge_slip_rate"; for identical bodies "K_I" and
        "K_II" or "K_III" at T.  "arrivals" at the stations, inf where there is none; totals at T;
        and each quantity at `TIMES` and `STATIONS`, (33, 5).
    """
    content: dict[str, Any] = {}
    if isinstance(answer, Solution | PairSolution):
        content["zones"] = [(zone.inner, zone.outer, zone.sense) for zone in answer.zones]
        content["openings"] = [(part.inner, part.outer) for part in answer.openings]
        content["edge_slip_rate"] = answer.edge_slip_rate
    if isinstance(answer, Solution):
        modes = (f"K_{mode}" for mode in ("I", answer.scene.shear_mode))
        content.update(zip(modes, answer.stress_intensity(1.0), strict=True))
    if isinstance(answer, LineSolution):
        content["zones"] = [(zone.inner, zone.outer, zone.sense) for zone in answer.zones]
        content["edge_amplitude"] = answer.edge_amplitude
    if sheet.arrival:
        content["arrivals"] = arrival_times(sheet, answer, STATIONS)
    for name in TOTALS:
        content[name] = getattr(answer, name)(1.0)
    for name in QUANTITIES:
        content[name] = getattr(answer, name)(STATIONS, np.array(TIMES)[:, None])
    return {name: np.asarray(values, dtype=float) for name, values in content.items()}


def errors_of(sheet: Sheet, answer: Answered) -> dict[str, Array]:
    """Estimated errors of the numbers of a march, of shapes as `content_of`; none if solved.

    `READING_SAFETY` times the largest of five times in a row, for the estimate of a number alone is
    too small where two curves cross; and what the march takes for granted.
    """
    if not isinstance(answer, Marched) or answer.companion is None:
        return {}
    ours = content_of(sheet, answer)
    errors = {}
    for name, values in ours.items():
        error = answer.error_of(partial(_number_of, sheet, name))
        error = np.where(np.isfinite(values), error, 0.0)
        error = maximum_filter1d(error, 5, axis=0) if values.ndim == 2 else error
        errors[name] = READING_SAFETY * error + MARCH_TOLERANCE
    return errors


def _number_of(sheet: Sheet, name: str, answer: Marched) -> Array:
    return content_of(sheet, answer)[name]


def document_of(sheet: Sheet, nodes: int = NODES) -> dict[str, Any]:
    """The sheet and its answer as plain dictionaries, lists and numbers; None for infinity.

    The answer to a sheet of an interface is that of the nodes which the sheet names.
    """
    if isinstance(sheet, InterfaceSheet):
        return reference_document(sheet)
    answer = answer_to(sheet, nodes)
    content, errors = content_of(sheet, answer), errors_of(sheet, answer)
    written = {
        name: _written(values, errors.get(name, np.zeros(values.shape)))
        for name, values in content.items()
    }
    sure = (
        "the last digit or two in doubt, see errors in the JSON file"
        if errors
        else f"{'nine' if sheet.is_pair else 'ten'} digits of twelve"
    )
    return {
        "sheet": sheet.name,
        "title": sheet.title,
        "units": "mu = rho = c_t = T = 1",
        "scene": described_problem(sheet),
        "si_scene": problem_document(sheet.si_problem),
        "si_scales": dict(SI_SCALES),
        "stations": list(STATIONS),
        "times": list(TIMES),
        "arrival": _arrival_words(sheet),
        "sure": sure,
        "answers": written,
        "errors": {name: _bounds(values) for name, values in errors.items()},
    }


def described_problem(sheet: Sheet) -> dict[str, Any]:
    """The problem of a sheet as plain dictionaries, strings and numbers."""
    if isinstance(sheet, InterfaceSheet):
        return sheet.document
    return problem_document(sheet.problem)


def problem_document(problem: Scene | Pair | WholeLine) -> dict[str, Any]:
    """A scene, two bodies or a whole line as plain dictionaries, strings and numbers."""
    if isinstance(problem, Pair):
        return pair_document(problem)
    return line_document(problem) if isinstance(problem, WholeLine) else scene_document(problem)


def _arrival_words(sheet: Sheet) -> str:
    """Return the condition that defines an arrival, in words; empty if nothing is timed."""
    name = arrival_quantity(sheet)
    side = "below" if sheet.arrival == OPENING else "above"
    return name and f"{name} {side} {arrival_level(sheet):g}"


def _written(values: Array, errors: Array) -> Any:
    """Values as they are written: by their digits, or by what errors leave and one decimal more."""
    flat: list[float | None] = []
    for value, error in zip(values.ravel().tolist(), errors.ravel().tolist(), strict=True):
        if not math.isfinite(value):
            flat.append(None)
        elif error > 0:
            flat.append(round(value, 1 - math.ceil(math.log10(error))) + 0.0)
        else:
            flat.append(float(f"{round(value, DECIMALS):.{DIGITS}g}") + 0.0)
    return np.array(flat, dtype=object).reshape(values.shape).tolist()


def _bounds(errors: Array) -> Any:
    """Errors as they are written: rounded up to one digit."""
    digit = 10.0 ** np.floor(np.log10(errors))
    bounds = [float(f"{bound:.1g}") for bound in (np.ceil(errors / digit) * digit).ravel()]
    return np.array(bounds).reshape(errors.shape).tolist()


def csv_of(document: Mapping[str, Any]) -> str:
    """The records of a document in the form that codes hand in."""
    answers = document["answers"]
    stream = StringIO(newline="")
    stream.write(f"# slipfront benchmark {document['sheet']}: {document['title']}\n")
    stream.write(f"# units {document['units']}; {document['sure']}\n")
    table = csv.writer(stream, lineterminator="\n")
    names = [name for name in QUANTITIES if name in answers]
    table.writerow(["t", "x", *names])
    for place, x in enumerate(document["stations"]):
        for level, t in enumerate(document["times"]):
            table.writerow([t, x, *(answers[name][level][place] for name in names)])
    return stream.getvalue()


def json_of(document: Mapping[str, Any]) -> str:
    """A document as JSON, a row of numbers a line."""
    rows = re.compile(r"\[\s+([^\[\]{}]*?)\s+\]")
    text = json.dumps(document, indent=1, allow_nan=False)
    return rows.sub(lambda row: f"[{' '.join(row[1].split())}]", text) + "\n"


def write_answers(folder: Path = DATA, names: Iterable[str] = ()) -> None:
    """Compute answers and write them, and `SUMS` of all, which `sha256sum --check` reads.

    Parameters
    ----------
    folder : Path
    names : iterable of str
        Sheets whose answers are computed; all of them by default.

    Raises
    ------
    DataFileError
        If a file cannot be written, or one of another sheet cannot be read.
    """
    for name in list(names) or ALL_SHEETS:
        sheet = ALL_SHEETS[name]
        document = document_of(sheet)
        write_text(folder / _csv(sheet), csv_of(document))
        write_text(folder / _json(sheet), json_of(document))
    lines = []
    for file in sorted(file for sheet in ALL_SHEETS.values() for file in answer_files(sheet)):
        try:
            lines.append(f"{hashlib.sha256((folder / file).read_bytes()).hexdigest()}  {file}\n")
        except OSError as error:
            raise DataFileError(f"{folder / file} cannot be read ({error}).") from error
    write_text(folder / SUMS, "".join(lines))


def _csv(sheet: Sheet) -> str:
    return f"records/{sheet.name}.csv"


def _json(sheet: Sheet) -> str:
    return f"answers/{sheet.name}.json"


def answer_files(sheet: Sheet) -> tuple[str, str]:
    """Names of the files of an answer below `DATA`: records and all numbers."""
    return _csv(sheet), _json(sheet)


def written_bytes(name: str, folder: Path = DATA) -> bytes:
    """Return the bytes of a written answer file.

    Raises
    ------
    DataFileError
        If it cannot be read, or is not what its checksum says.
    """
    path = folder / name
    try:
        data = path.read_bytes()
        sums = dict(line.split()[::-1] for line in (folder / SUMS).read_text().splitlines())
    except (OSError, ValueError) as error:
        raise DataFileError(f"{path} cannot be read ({error}).") from error
    if sums.get(name) != hashlib.sha256(data).hexdigest():
        raise DataFileError(f"{path} does not fit its checksum in {SUMS}; take a new copy.")
    return data


def written_document(sheet: Sheet, folder: Path = DATA) -> dict[str, Any]:
    """The answer to a sheet as it was written; raises as `written_bytes`."""
    document: dict[str, Any] = json.loads(written_bytes(_json(sheet), folder))
    return document


def changes(sheet: Sheet, nodes: int = NODES, folder: Path = DATA) -> Iterator[str]:
    """Yield a sentence for each difference between a written answer and the one computed now.

    Numbers may differ by `SAME` relative to the largest number of their name.  Marched numbers may
    also differ by the error estimates of both answers.

    Raises
    ------
    DataFileError
        As `written_bytes`.
    """
    document = written_document(sheet, folder)
    if written_bytes(_csv(sheet), folder).decode() != csv_of(document):
        yield f"{_csv(sheet)} does not hold the records of {_json(sheet)}"
    if isinstance(sheet, InterfaceSheet):
        for change in reference_changes(sheet, reference_of(document), nodes):
            yield f"{_json(sheet)}: {change}"
        return
    answer = answer_to(sheet, nodes)
    content, errors = content_of(sheet, answer), errors_of(sheet, answer)
    if set(content) != set(document["answers"]):
        yield f"{_json(sheet)} holds other quantities"
        return
    for name, values in content.items():
        before = np.array(document["answers"][name], dtype=float).reshape(values.shape)
        off = np.where(np.isinf(values) & np.isnan(before), 0.0, np.abs(values - before))
        allowed = SAME * np.max(np.abs(before), initial=SAME, where=np.isfinite(before))
        if errors:
            was = np.array(document["errors"][name], dtype=float).reshape(values.shape)
            allowed = allowed + errors[name] + was
        if not np.all(off <= allowed):
            yield f"{_json(sheet)}: {name} differs by {np.nanmax(off):.2g}"
