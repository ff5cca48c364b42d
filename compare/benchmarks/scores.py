"""Scores of records on a sheet: what `validate` says of them, and an accuracy class.

The errors follow Barall and Harris (2015): of arrivals the root of their mean square error over T;
of every quantity the L1 norm of its error over time and all stations, relative to that of the
answer, or where that is zero to that of V_0 = 2 tau_0 / (rho c_t), V_0 T or tau_0.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from compare.benchmarks import answers
from compare.benchmarks.sheets import SI, Sheet, find_sheet
from compare.records.names import not_read
from compare.records.read import MESHES, binary_reader, read_records
from compare.records.record import AFTER, QUANTITIES, Record, Records
from compare.validation import Conventions, validate
from compare.validation.exact import AT_TIME, Exact, Sampling
from compare.validation.norms import pooled, station_norm
from semianalytic.scene.arrays import Mask
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.tables.text import lines_of

ARRIVAL = "arrival"
GRADED = (ARRIVAL, *QUANTITIES)
ENOUGH = 0.9
"""Part of the time, at all stations together, that a run has to cover to have a class."""
LONGEST_STEP = 1 / 32
"""Longest step between two samples over T that counts as held: that of the answers' tables."""
NOTHING = 1e-9
"""Rounding of times."""
_STATED = Conventions(sign="as-given", slip="relative", pressure="compression", tractions="total")
"""Conventions that a sheet asks for, so that nothing is inferred."""


@dataclass(frozen=True)
class Score:
    """One number of a run."""

    file: str
    sheet: str
    verdict: str  # verdict of `validate` on the whole run
    quantity: str  # one of `QUANTITIES`, or "arrival"
    # root of the mean square error of arrivals over T, or relative L1 error; nan if the run does
    # not hold the quantity
    error: float
    grade: str  # as by `class_of`; "" where the run holds less than `ENOUGH`
    held: float  # part of the time, at all stations together, that the run holds without gaps
    # corrections made in reading the run, and parts that were not read, a sentence each
    notes: tuple[str, ...]


def score_files(paths: Iterable[Path], sheet: Sheet | None = None) -> tuple[Score, ...]:
    """Score the runs of files; files that hold one station each are one run, as for `validate`.

    They are of a sheet that is given, or that they name (``# benchmark: NAME``); SceneError if
    neither.  A file that cannot be read, is of another sheet, or in other units, raises
    DataFileError, and `score` may.
    """
    runs: dict[str, list[Path]] = {}
    for path in paths:
        named = _named(path)
        if sheet is None and named is None:
            raise SceneError(f"{path} does not say of which benchmark it is; give `sheet`.")
        if sheet is not None and named not in (None, sheet.name):
            raise DataFileError(f"{path} is of {named}, not of {sheet.name}; leave `sheet` out.")
        runs.setdefault(sheet.name if sheet else str(named), []).append(path)
    scores: list[Score] = []
    for name, files in runs.items():
        of = sheet or find_sheet(name)
        for records in read_records(files):
            for column, unit in records.stated.units.items():
                if of.units != SI:  # numbers with units were converted to the SI
                    raise DataFileError(
                        f"{records.source}: {column} is in {unit.name}; hand it in where "
                        f"{of.units}, without a unit."
                    )
            if records.stated.faces or records.stated.changes:
                raise DataFileError(
                    f"{records.source} holds motion of one face, or changes of tractions; hand in "
                    "slip of one face relative to the other, and tractions."
                )
            scores += score(of, records)
    return tuple(scores)


def _named(path: Path) -> str | None:
    """Name of the sheet that a file, or the first one of a folder that does, says it is of."""
    for file in sorted(path.iterdir()) if path.is_dir() else [path]:
        if file.is_dir() or file.suffix.lower() in MESHES or binary_reader(file):
            continue
        said = (line.removeprefix("#").partition(":") for line in lines_of(file) if line[:1] == "#")
        for label, _, name in said:
            if label.strip() == "benchmark":
                return name.strip()
    return None


def score(sheet: Sheet, records: Records) -> tuple[Score, ...]:
    """Every number of a run that its sheet asks for.

    A run without a station of the sheet between 0 and T is refused by a DataFileError.
    """
    answer, end = answers.answer_to(sheet), sheet.end_time
    near = [station for station in records.stations if _near(sheet, station.x).any()]
    kept = [record.taken((record.t > 0) & (record.t <= end * (1 + NOTHING))) for record in near]
    known = [replace(record, t=np.minimum(record.t, end)) for record in kept if len(record.t) > 1]
    if not known:
        places = ", ".join(f"{x:g}" for x in sheet.stations)
        raise DataFileError(
            f"{records.source} has no station at x = {places} and 0 < t <= {end:g}; record there."
        )
    verdict = validate(records, sheet.problem, conventions=_STATED).verdict
    notes = (*records.notes, *not_read(records.unread))
    left = {
        "stations that the sheet does not have": len(records.stations) - len(near),
        "times beyond T": sum(int(np.sum(record.t > end * (1 + NOTHING))) for record in near),
    }
    notes += tuple(f"{count} {what} are left out" for what, count in left.items() if count)
    step = records.stated.step or 0.0
    errors = {ARRIVAL: _arrival_error(sheet, answer, known)} if sheet.arrival else {}
    errors |= {name: _relative_error(sheet, answer, known, name, step) for name in sheet.report}
    scores = []
    for name, error in errors.items():
        held = _held(sheet, known, answers.arrival_quantity(sheet) if name == ARRIVAL else name)
        grade = class_of(sheet, name, error) if held >= ENOUGH else ""
        scores.append(Score(records.source, sheet.name, verdict, name, error, grade, held, notes))
    return tuple(scores)


def class_of(sheet: Sheet, quantity: str, error: float) -> str:
    """The class of an error: A, B, C, D beyond all of them; "" where there is none."""
    bounds = sheet.classes.get(quantity)
    return (
        "ABCD"[sum(error > bound for bound in bounds)] if bounds and not math.isnan(error) else ""
    )


def _near(sheet: Sheet, x: float) -> Mask:
    """Return which stations of a sheet are at a position, (k,)."""
    return np.asarray(np.abs(np.array(sheet.stations) - x) <= 1e-3 * sheet.extent)


def _held(sheet: Sheet, stations: Iterable[Record], name: str) -> float:
    """Part of the stations and times of a sheet that a run holds; gaps are not."""
    shares = np.zeros(len(sheet.stations))
    for station in stations:
        if name in station.values:
            steps, known = np.diff(station.t, prepend=0.0), np.isfinite(station.values[name])
            held = known & np.append(True, known[:-1])
            held &= steps <= sheet.end_time * LONGEST_STEP * (1 + NOTHING)
            shares[_near(sheet, station.x)] = steps[held].sum() / sheet.end_time
    return float(shares.mean())


def _arrival_error(sheet: Sheet, answer: answers.Answered, stations: Iterable[Record]) -> float:
    """Root of the mean square error over T; what is not reached counts as reached at the end.

    Where slip begins at once, as in the middle of a patch, nothing is timed.
    """
    errors, name = [], answers.arrival_quantity(sheet)
    for station in stations:
        if name not in station.values:
            return math.nan
        end = float(station.t[-1])
        at = min(answers.first_crossing(sheet, station.t, station.values[name]), end)
        exact = min(answers.arrival_time(sheet, answer, station.x), end)
        if exact > 0 and min(at, exact) < end:
            errors.append((at - exact) / sheet.end_time)
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else math.nan


def _relative_error(
    sheet: Sheet, answer: answers.Answered, stations: Sequence[Record], name: str, step: float
) -> float:
    """Relative L1 error of a quantity, means of slip rate over a step; nan where none has it."""
    exact = Exact(sheet.problem, answer, sheet.end_time)
    sampling = Sampling(AFTER, step) if step else AT_TIME
    if sheet.is_interface:
        stations = [
            _at_times_of(sheet, record, step if name == "slip_rate" else 0.0) for record in stations
        ]
        sampling = AT_TIME
    norms = [station_norm(record, name, exact, sampling) for record in stations]
    known = [norm for norm in norms if norm is not None]
    return pooled(known).L1 if known else math.nan


def _at_times_of(sheet: Sheet, record: Record, step: float) -> Record:
    """A record at times of the answer: fronts are so sharp that only a record, which has the steps
    of its code, may be interpolated.  A mean from t to t + step counts for the middle."""
    t = np.array([time for time in sheet.times if record.t[0] <= time <= record.t[-1]])
    values = {
        name: np.interp(t, record.t + step / 2, values) for name, values in record.values.items()
    }
    return Record(record.x, t, values)
