"""How far a run is from the exact answer, in the manner of Barall and Harris (2015).

Arrivals as the root of their mean square error, in units of T and in cells; every quantity as the
L1 and L2 norm of its error over time and all stations, relative to that of the exact answer, or of
V_0 = 2 tau_0 / (rho c_t), V_0 T and tau_0 where that is zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from compare.benchmarks.answers import (
    Answered,
    answer_to,
    arrival_quantity,
    arrival_times,
    first_crossing,
)
from compare.benchmarks.classes import BEYOND, COPIED, tolerance_class
from compare.benchmarks.entries import Run, run_label
from compare.benchmarks.interfaces.reference import Reference
from compare.benchmarks.interfaces.sheets import InterfaceSheet
from compare.benchmarks.sheet import CELLS, Sheet
from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.records.record import QUANTITIES, Record
from semianalytic import WholeLine
from semianalytic.scene.errors import DataFileError

Array = NDArray[np.float64]

ARRIVAL = "arrival"
ENOUGH = 0.9
"""Part of the stations, and of the time at each, that a run has to hold to have a class."""
LONGEST_STEP = 1 / 32
"""Longest step between two samples over T that counts as held: that of the written answers."""
GAP = 3.0
"""A step longer than this many median steps counts as a gap in the record."""
LONGEST_MEAN = 2.0
"""Cells over c_t, the longest step over which slip rates may be means: UGUCA and SEM2DPACK write
means over a quarter and a tenth of one."""
EXACTLY = 1e-6
"""Relative error below which a run is the answer itself: the nearest run of any code on 200 cells,
and of our marcher, is 5e-5 from it."""
GRADED = (ARRIVAL, *QUANTITIES)
"""Errors with tolerance classes: the error of arrivals and the L1 error of each quantity."""
NOTHING = 1e-9
"""An exact norm below this, relative to that of the reference value, is zero."""


@dataclass(frozen=True)
class Score:
    """One number of a run.

    Attributes
    ----------
    sheet, code : str
    cells, seconds : float
        Of the run.
    quantity : str
        Of `GRADED`.
    error : float
        Root of the mean square error of arrivals over T, or relative L1 error; nan if the run does
        not hold the quantity.
    second : float
        The error of arrivals in cells, or the relative L2 error.
    tolerance : str
        As by `tolerance_class`; "" where the run holds too little, `COPIED` where it is the answer.
    note : str
        What the numbers leave out, and why there is no class.
    """

    sheet: str
    code: str
    cells: float
    seconds: float
    quantity: str
    error: float
    second: float
    tolerance: str
    note: str

    @property
    def label(self) -> str:
        """Code and cells, as figures and tables name it."""
        return run_label(self.code, self.cells)


def score(run: Run) -> tuple[Score, ...]:
    """Every number of a run that its sheet asks for.

    Raises
    ------
    DataFileError
        If the run has no station on the contact between 0 and T, or slip rates that are means over
        steps of more than `LONGEST_MEAN` cells.
    """
    _check_step(run)
    sheet, answer = run.sheet, answer_to(run.sheet)
    stations = [
        _until_end(one, sheet.end_time) for one in run.records.stations if _is_on(sheet, one.x)
    ]
    stations = [one for one in stations if len(one.t) > 1]
    if not stations:
        where = "of the sheet" if sheet.is_interface else "with 0 < x <= 2"
        raise DataFileError(
            f"{run.records.source} has no station {where} and 0 < t <= {sheet.end_time:g}."
        )
    note = _missing(sheet, stations)
    found: list[tuple[str, float, float, str, str]] = []
    if sheet.arrival:
        error, missed = _arrival_error(sheet, answer, stations)
        words = f"{missed} station{'s' * (missed > 1)} reached by one only" if missed else ""
        lack = _lacking(sheet, stations, arrival_quantity(sheet))
        graded = BEYOND if missed else tolerance_class(sheet.name, ARRIVAL, error)
        notes = "; ".join(filter(None, (note, words, lack)))
        cells = error * sheet.end_time / sheet.crossing * run.cells
        found.append((ARRIVAL, error, cells, "" if lack else graded, notes))
    for name in sheet.report:
        first, second = _relative_errors(run, answer, stations, name)
        lack = _lacking(sheet, stations, name)
        graded = "" if lack else tolerance_class(sheet.name, name, first)
        found.append((name, first, second, graded, "; ".join(filter(None, (note, lack)))))
    if _is_copied(sheet, answer, found):
        nearer = f"within {EXACTLY:g} of the answer, which no code comes so near to"
        found = [
            (name, first, second, grade and COPIED, "; ".join(filter(None, (words, nearer))))
            for name, first, second, grade, words in found
        ]
    return tuple(Score(sheet.name, run.code, run.cells, run.seconds, *numbers) for numbers in found)


def _is_on(sheet: Sheet, x: float) -> bool:
    """Return whether a sheet has an answer at a position."""
    return bool(_near(sheet, x).any()) if sheet.is_interface else 0 < x <= 2


def _near(sheet: Sheet, x: float) -> NDArray[np.bool_]:
    """Return which stations of a sheet are at a position, (k,)."""
    return np.asarray(np.abs(np.array(sheet.stations) - x) <= 1e-3 * sheet.extent)


def _check_step(run: Run) -> None:
    """Refuse slip rates that are means over so long that they hide what they should show."""
    cells = CELLS[-1] if math.isnan(run.cells) else run.cells
    crossed = run.step / run.sheet.crossing * cells
    if crossed <= LONGEST_MEAN * (1 + NOTHING):
        return
    said = f"{run.step:g} {'' if run.sheet.is_interface else 'T '}is {crossed:.2g} cells"
    if math.isnan(run.cells):
        said = f"{run.step:g} T is long, and it does not say how many cells it has (# cells: 100)"
    raise DataFileError(
        f"{run.records.source}: slip rates are means over steps of at most {LONGEST_MEAN:g} cells, "
        f"and {said}; record them more often."
    )


def _lacking(sheet: Sheet, stations: Iterable[Record], name: str) -> str:
    """Why a quantity has no class: stations or times that are not held; "" if it has enough."""
    shares = dict.fromkeys(sheet.stations, 0.0)
    for one in stations:
        for x, near in zip(sheet.stations, _near(sheet, one.x), strict=True):
            if near:
                shares[x] = max(shares[x], _share(one, name, sheet.end_time))
    poor = [x for x, share in shares.items() if share < ENOUGH]
    if len(shares) - len(poor) >= ENOUGH * len(shares):
        return ""
    most = max(shares[x] for x in poor)
    return (
        f"no class, which takes {100 * ENOUGH:.0f} % of stations and times: at most "
        f"{100 * most:.0f} % of the time at x = {', '.join(f'{x:g}' for x in poor)}"
    )


def _share(record: Record, name: str, end: float) -> float:
    """Part of the time from 0 to T that a record holds; gaps in it and between rows are not."""
    values = record.values.get(name)
    if values is None:
        return 0.0
    steps = np.diff(record.t, prepend=0.0)
    known = np.isfinite(values)
    held = known & np.append(True, known[:-1])
    held &= steps <= min(end * LONGEST_STEP, GAP * float(np.median(steps))) * (1 + NOTHING)
    return float(steps[held].sum()) / end


def _is_copied(
    sheet: Sheet, answer: Answered, found: Sequence[tuple[str, float, float, str, str]]
) -> bool:
    """Whether all that a run holds is the answer itself, and that is not nothing alone."""
    errors = {name: first for name, first, *_ in found if name != ARRIVAL and not math.isnan(first)}
    x, end = sheet.stations, sheet.end_time
    moves = any(np.abs(getattr(answer, name)(x, end)).max() > NOTHING for name in errors)
    return moves and max(errors.values()) < EXACTLY


def _until_end(record: Record, end: float) -> Record:
    """A record over 0 < t <= T."""
    kept = (record.t > 0) & (record.t <= end * (1 + NOTHING))
    t = np.minimum(record.t[kept], end)
    return Record(record.x, t, {name: values[kept] for name, values in record.values.items()})


def _missing(sheet: Sheet, stations: Iterable[Record]) -> str:
    """Which stations of a sheet are not among those of a run."""
    held = np.any([_near(sheet, one.x) for one in stations], axis=0)
    missing = [x for x, known in zip(sheet.stations, held, strict=True) if not known]
    return f"without x = {', '.join(f'{x:g}' for x in missing)}" if missing else ""


def _arrival_error(sheet: Sheet, answer: Answered, stations: Iterable[Record]) -> tuple[float, int]:
    """Root of the mean square error over T, and how many stations one of the two alone reached.

    Where slip begins at once, as in the middle of a patch, nothing is timed.
    """
    errors, missed = [], 0
    for one in stations:
        try:
            at = first_crossing(sheet, one.t, one.values)
        except KeyError:
            return math.nan, 0
        exact = float(arrival_times(sheet, answer, [one.x])[0])
        exact = exact if exact <= one.t[-1] else math.inf
        if math.isfinite(at) and math.isfinite(exact) and exact > 0:
            errors.append((at - exact) / sheet.end_time)
        missed += math.isfinite(at) != math.isfinite(exact)
    return (float(np.sqrt(np.mean(np.square(errors)))) if errors else math.nan), missed


def scale_of(sheet: Sheet, name: str) -> float:
    """Return what an error of a quantity is relative to where the answer is zero."""
    if isinstance(sheet, InterfaceSheet):
        return float(np.abs(getattr(answer_to(sheet), name)(sheet.stations, sheet.end_time)).max())
    problem, rated = sheet.problem, name in ("slip_rate", "slip")
    if isinstance(problem, WholeLine):
        return problem.excess * (2 / problem.material.shear_impedance if rated else 1.0)
    return (slip_rate_scale if rated else stress_scale)(sheet.scene)


def _relative_errors(
    run: Run, answer: Answered, stations: Iterable[Record], name: str
) -> tuple[float, float]:
    """Relative L1 and L2 error of a quantity; nan where no station has it."""
    step = run.step if name == "slip_rate" else 0.0
    parts = [part for one in stations if (part := _parts(answer, one, name, step))]
    if not parts:
        return math.nan, math.nan
    unit = scale_of(run.sheet, name)
    norms = []
    for order in (1, 2):
        wrong, whole, one = (
            sum(np.trapezoid(np.abs(values) ** order, t) for t, values in column) ** (1 / order)
            for column in (
                [(t, off) for t, off, _ in parts],
                [(t, exact) for t, _, exact in parts],
                [(t, np.full(len(t), unit)) for t, _, _ in parts],
            )
        )
        norms.append(float(wrong / (whole if whole > NOTHING * one else one)))
    return norms[0], norms[1]


def _parts(
    answer: Answered, record: Record, name: str, step: float
) -> tuple[Array, Array, Array] | None:
    """Times, errors and exact values of a record, where it holds any."""
    if isinstance(answer, Reference):
        record, step = answer.at_times(record, step), 0.0
    values = record.values.get(name)
    if values is None or np.isfinite(values).sum() < 2:
        return None
    exact = getattr(answer, name)(record.x, record.t)
    known = np.isfinite(values) & np.isfinite(exact)  # slip rate at the end of a patch is infinite
    t, exact = record.t[known], exact[known]
    if step:  # a march ends at T
        ends = np.minimum(t + step, 1.0)
        moved = answer.slip(record.x, ends) - answer.slip(record.x, t)
        exact = np.divide(moved, ends - t, out=exact, where=ends > t)
    return t, values[known] - exact, exact
