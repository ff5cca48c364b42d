"""Answers to the problem sheets: stored, or solved or marched when they are asked for.

Exact answers are sure to ten digits, between different bodies to nine, and written so; what comes
of grids is written to seven digits at most, with a stated error.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from compare.benchmarks.sheets import OPENING, Sheet, stored_text
from compare.comparison.measures import first_above
from compare.comparison.scales import stress_scale
from compare.output.tables import csv_text
from compare.records.record import QUANTITIES
from semianalytic import solve
from semianalytic.results.answer import TOTALS, method_of
from semianalytic.scene.arrays import Array
from semianalytic.whole_line.drive import Drive

RTOL, PAIR_RTOL = 1e-12, 1e-10
NODES = 2000
"""Nodes of a march: some seconds, and errors a tenth of those of class A."""
THRESHOLD = 0.002
"""Slip rate over the largest load over rho c_t, or pressure over that of the base, at which slip or
opening counts as begun."""
FINE = 1000
"""Parts into which an interval of time is divided, twice, to find an arrival: to 1e-6 T."""


@dataclass(frozen=True, eq=False)
class Stored:
    """Records of an interface at the stations of its sheet: the limit of two grids."""

    x: Array  # (k,) array: stations [length]
    t: Array  # (m,) array: times [time]
    # mapping of str to (m, k) array: the quantities that the sheet asks for, which are functions of
    # x and t as of any answer: at the nearest stations and times
    values: Mapping[str, Array]
    # (k,) array: first times at which the slip rate is above the level of the sheet [time]; inf if
    # never
    arrivals: Array
    # Stated relative L1 error of each quantity over times and stations; of "arrivals" the largest
    # error [time]. It is the difference from the limit of the next coarser two grids.
    errors: Mapping[str, float]

    def __getattr__(self, name: str) -> Callable[[ArrayLike, ArrayLike], Array]:
        if name not in QUANTITIES:
            raise AttributeError(name)
        return lambda x, t: self.values[name][_nearest(self.t, t), _nearest(self.x, x)]


def _nearest(known: Array, given: ArrayLike) -> NDArray[np.intp]:
    wanted = np.asarray(given, dtype=float)[..., None]
    return np.asarray(np.abs(known - wanted).argmin(axis=-1))


Answered = Any


@cache
def answer_to(sheet: Sheet) -> Answered:
    """The answer to a sheet, solved, marched or read; raises as `stored_text` and the solvers."""
    if not sheet.nodes:
        return solve(sheet.problem, **_settings(sheet))
    document = json.loads(stored_text(f"{sheet.name}.json"))
    values = {name: np.array(rows, dtype=float) for name, rows in document["answers"].items()}
    arrivals = np.nan_to_num(values.pop("arrivals"), nan=math.inf)  # null: never
    x, t = np.array(sheet.stations), np.array(sheet.times)
    return Stored(x, t, values, arrivals, document["errors"])


def _settings(sheet: Sheet) -> dict[str, Any]:
    if sheet.is_interface:
        return {"times": list(sheet.times)}
    if sheet.is_marched:
        return {"method": "space-time", "end_time": 1.0, "nodes": NODES}
    if not sheet.problem.has_slot or sheet.problem.grows:
        return {}  # exact to rounding
    return {"rtol": RTOL if sheet.problem.lower_material is None else PAIR_RTOL}


def checksums(contents: Mapping[str, bytes]) -> str:
    """Return the lines that ``sha256sum --check`` reads, of the contents of files by name."""
    return "".join(f"{hashlib.sha256(contents[name]).hexdigest()}  {name}\n" for name in contents)


def values_of(answer: Answered, name: str, x: ArrayLike, t: ArrayLike) -> Array:
    """Return one of `QUANTITIES` of an answer at positions and times, of broadcast shape."""
    return np.asarray(getattr(answer, name)(x, t))


def arrival_quantity(sheet: Sheet) -> str:
    """Return the quantity whose level defines arrivals; "" if nothing is timed."""
    return sheet.arrival and ("pressure" if sheet.arrival == OPENING else "slip_rate")


def arrival_level(sheet: Sheet) -> float:
    """Slip rate above which, or pressure below which, a station counts as reached."""
    problem = sheet.problem
    if problem.on_line:
        return sheet.level
    if not problem.has_slot:
        return THRESHOLD * Drive(problem).excess
    held = problem.superposition.in_place.pressure
    return THRESHOLD * (held if sheet.arrival == OPENING else stress_scale(problem))


def first_crossing(sheet: Sheet, t: Array, values: Array) -> float:
    """When a record (n,) of the timed quantity first passes its level [time]; inf if never."""
    known, level = np.isfinite(values), arrival_level(sheet)
    excess = level - values if sheet.arrival == OPENING else np.abs(values) - level
    time = first_above(t[known], excess[known], 0.0)
    return math.inf if time is None else time


def arrival_time(sheet: Sheet, answer: Answered, x: float) -> float:
    """When slip or opening arrives at a position [time]; inf if not until T."""
    if isinstance(answer, Stored):
        return float(answer.arrivals[_nearest(answer.x, x)])
    name, start, end = arrival_quantity(sheet), 0.0, sheet.end_time
    for _ in range(2):
        t = np.linspace(start, end, FINE + 1)[1:]
        time = first_crossing(sheet, t, values_of(answer, name, x, t))
        if math.isinf(time):
            return time
        end = float(t[np.searchsorted(t, time)])
        start = end - (t[1] - t[0])
    return time


def numbers_of(sheet: Sheet) -> dict[str, Any]:
    """Numbers of an answer at t = T by name.

    "zones", rows of inner and outer edge [length / time] and sense; "openings", rows of two edges;
    "arrivals" at the stations [time], None where there is none; totals.  Interfaces have arrivals
    and "slip" at the stations alone.
    """
    answer = answer_to(sheet)
    numbers: dict[str, Any] = {}
    if method_of(answer) == "self-similar":
        numbers["zones"] = [[zone.inner, zone.outer, zone.sense] for zone in answer.zones]
        if sheet.problem.has_slot:
            numbers["openings"] = [[part.inner, part.outer] for part in answer.openings]
    if sheet.arrival:
        times = [arrival_time(sheet, answer, x) for x in sheet.stations]
        numbers["arrivals"] = [None if math.isinf(time) else time for time in times]
    if isinstance(answer, Stored):
        return {**numbers, "slip": answer.values["slip"][-1].tolist()}
    return {**numbers, **{name: float(getattr(answer, name)(sheet.end_time)) for name in TOTALS}}


def field_of(sheet: Sheet, name: str, answer: Answered) -> Array:
    """A quantity of an answer at the times and stations of its sheet, (m, k)."""
    return values_of(answer, name, sheet.stations, np.array(sheet.times)[:, None])


def fields_of(sheet: Sheet, answer: Answered) -> dict[str, Array]:
    """Every quantity of an answer at the times and stations of its sheet, (m, k)."""
    names = sheet.report if sheet.is_interface else QUANTITIES
    return {name: field_of(sheet, name, answer) for name in names}


def stated_errors(sheet: Sheet) -> dict[str, float]:
    """Relative L1 errors of an answer by quantity, and of "arrivals" in time; none if solved.

    Those of a march are by its estimate; an error of a code below them says nothing about the code.
    """
    answer = answer_to(sheet)
    if isinstance(answer, Stored):
        return dict(answer.errors)
    if method_of(answer) != "space-time":
        return {}
    if sheet.is_interface:
        return {name: answer.error_estimates[name] for name in sheet.report}
    return {
        name: float(answer.error_of(partial(field_of, sheet, name)).sum() / np.abs(values).sum())
        for name, values in fields_of(sheet, answer).items()
    }


def digits_of(sheet: Sheet) -> int:
    """Return the significant digits to which an answer is written."""
    different = getattr(sheet.problem, "lower_material", None) is not None
    return 7 if sheet.is_marched else 9 if different else 10


def table_of(sheet: Sheet) -> str:
    """The records of an answer as CSV, in the form in which codes are scored."""
    answer, digits = answer_to(sheet), digits_of(sheet)
    fields = fields_of(sheet, answer)
    rows = []
    for place, x in enumerate(sheet.stations):
        for level, t in enumerate(sheet.times):
            values = [float(field[level, place]) for field in fields.values()]
            if not sheet.is_marched:  # what is nothing but rounding is written as 0
                values = [round(value, digits + 2) + 0.0 for value in values]
            rows.append([f"{t:.10g}", f"{x:g}", *(f"{value:.{digits}g}" for value in values)])
    comments = f"benchmark: {sheet.name}", f"answer of slipfront, units {sheet.units}"
    return csv_text(["t", "x", *fields], rows, *comments)
