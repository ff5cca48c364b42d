"""Tables of text as records: rows of all stations, one station a file, times of rupture."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from compare.records.names import NOISE, Columns, dimensions_of, known_columns, no_columns, unit_of
from compare.records.record import AFTER, ReadingOptions, Record, Records, Stated, Unit
from compare.records.stations import joined_faces, station, stations_of_rows
from semianalytic.inversion.gauges import FIELDS
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.columns import split_heading
from semianalytic.scene.tables.text import NamedColumns, read_table
from semianalytic.scene.tables.units import EXAMPLES, common_size

SCEC_UNIT = 100.0
"""Metres that one unit of the number in the name of a SCEC station stands for."""
NEVER = 1e8
"""Rupture times from this value on mean that no rupture occurred; SCEC writes 1e9."""
_FAR = 10.0
"""Factor above all other times from which 1000, 99999 and their like mean the same."""
_SCEC = re.compile(r"faultst(-?\d+)dp(-?\d+)", re.IGNORECASE)
_NAMED = re.compile(r"(?:^|[_\-\s])x[_=]?(-?\d+(?:\.\d+)?(?:e-?\d+)?)", re.IGNORECASE)
_LENGTH = r"\s*([-+]?[\d.][-+\d.eE]*)\s*(\S*)"
_COMMENTED = re.compile(rf"^(?:(?:x|position|station)\s*[:=]|x1\s){_LENGTH}", re.IGNORECASE)
_SPACING = re.compile(rf"^(?:spacing|dx|element_size|grid spacing)\s*[:=]{_LENGTH}", re.IGNORECASE)
_MEAN = re.compile(r"from t to t \+ ([\d.eE+-]*\d)")
"""Words by which a comment says that slip rates are means over a step, as in benchmarks."""
_HEADED = re.compile(r"column\s*#?\s*(\d+)\s*[:=].*[(\[]([^()\[\]]+)[)\]]\s*\Z", re.IGNORECASE)
"""Comments of SCEC that name the unit of a column, as Column #8 = normal stress (MPa)."""
_CELLS = re.compile(r"^cells\s*[:=]\s*(\d+)", re.IGNORECASE)


def read_text(path: Path, options: ReadingOptions, at: float | None) -> tuple[Records, bool]:
    """Records of a text file, and whether it is a station of a run, which may be given its x.

    A DataFileError says where it cannot be read.
    """
    table = read_table(path)
    if tuple(name.lower() for name in table.names) == ("j", "k", "t"):
        return _rupture_times(table, options), False
    names = table.names or _bare_names(table, alone=at is not None or bool(_SCEC.search(path.name)))
    units = _units_of_comments(table, names)
    gauges = _gauges(table, names, options)
    taken = [place for place, _ in gauges.values()]
    others = ["" if place in taken else name for place, name in enumerate(names)]
    known = known_columns(path, others, options.columns, table.line, units, bodies=True)
    if "t" not in known.places:
        raise DataFileError(
            f"{path} has no column of times among {', '.join(names)}; call it t, or say t=NAME."
        )
    if gauges:
        return _records_of_gauges(table, names, options, gauges, known), False
    columns = {name: table.rows[:, i] * known.scale(name) for name, i in known.places.items()}
    values, stated, more = joined_faces(columns, known)
    fields = {name: columns[name] for name in FIELDS if name in columns}
    if not values and not fields:
        raise no_columns(path, names, table.line)
    for noisy in (values, fields):
        noisy |= _noise(columns, known, tuple(noisy))
    stated = replace(stated, **_mean(table))
    source, unread = str(path), known.unread
    notes = [*known.notes, *more]
    if "x" in columns and at is None:
        along, t = columns["x"] - options.origin * known.scale("x"), columns["t"]
        y = columns.get("y", np.full(len(t), np.nan))
        stations: tuple[Record, ...] = ()
        points: list[Record] = []
        here = np.isnan(y) | (y == 0)
        if "y" in columns:  # rows of other places have gaps where a quantity is not theirs
            here &= _any_finite(values, len(t))
        if values and (here.any() or "y" not in columns):
            stations, mended = stations_of_rows(path, along[here], t[here], _rows_of(values, here))
            notes += mended
        for height in np.unique(y[np.isfinite(y) & _any_finite(fields, len(t))]):
            here = (y == height) & _any_finite(fields, len(t))
            some, mended = stations_of_rows(path, along[here], t[here], _rows_of(fields, here))
            points += [replace(point, y=float(height)) for point in some]
            notes += mended
        notes += _misplaced(y, values, fields)
        if not stations and not points:
            raise DataFileError(f"{path}: {'; '.join(_misplaced(y, values, fields))}.")
        spacing = _spacing(table, stated.units.get("x"))
        points.sort(key=lambda point: (point.x, point.y))
        notes = list(dict.fromkeys(notes))
        parts = tuple(notes), spacing, stated, tuple(points), unread
        return Records(stations, None, source, *parts), False
    if not values:
        raise DataFileError(
            f"{path} holds {', '.join(fields)} of points inside the bodies; give columns x and y."
        )
    x, unit, how = _position(table, at, options.origin)
    if unit is not None:
        stated = replace(stated, units={**stated.units, "x": unit})
    record, mended = station(path, x, columns["t"], values)
    spacing = _spacing(table, unit)
    notes += [*how, *mended]
    return Records((record,), None, source, tuple(notes), spacing, stated, unread=unread), True


def _gauges(
    table: NamedColumns, names: Sequence[str], options: ReadingOptions
) -> dict[str, tuple[int, float]]:
    """Column of each gauge, whose heading is its name, maybe with a unit, and the factor to SI."""
    places = {}
    for gauge, (quantity, *_) in options.gauges.items():

        def dimensions(stem: str, gauge: str = gauge, quantity: str = quantity) -> tuple[str, ...]:
            return dimensions_of(quantity) if stem == gauge else ()

        split = [split_heading(name, dimensions) for name in names]
        there = [n for n, (bare, _) in enumerate(split) if gauge in (bare, names[n])]
        if len(there) != 1:
            has, change = f"{len(there)} columns", "rename them"
            if not there:
                has, change = "no column", f"choose among {', '.join(names)}"
            raise DataFileError(f"{table.path} has {has} {gauge!r} of a gauge; {change}.")
        where = f"the name of {names[there[0]]!r}"
        unit = unit_of(table.path, table.line, where, split[there[0]][1], quantity)
        places[gauge] = there[0], unit.size if unit else 1.0
    return places


def _records_of_gauges(
    table: NamedColumns,
    names: Sequence[str],
    options: ReadingOptions,
    gauges: Mapping[str, tuple[int, float]],
    known: Columns,
) -> Records:
    """Records of a table with a column for each gauge."""
    t = table.rows[:, known.places["t"]] * known.scale("t")
    stations: list[Record] = []
    points: list[Record] = []
    notes: list[str] = []
    for gauge, (place, size) in gauges.items():
        quantity, x, y = options.gauges[gauge]
        record, mended = station(table.path, x, t, {quantity: size * table.rows[:, place]})
        (points if quantity in FIELDS else stations).append(replace(record, y=y, name=gauge))
        notes += mended
    taken = (known.places["t"], *(place for place, _ in gauges.values()))
    unread = tuple(name for place, name in enumerate(names) if place not in taken)
    parts = tuple(dict.fromkeys(notes)), None, Stated(), tuple(points), unread
    return Records(tuple(stations), None, str(table.path), *parts)


def _units_of_comments(table: NamedColumns, names: Sequence[str]) -> dict[str, str]:
    """Units by name of column, where comments say them by its number."""
    found = (match for comment in table.comments if (match := _HEADED.search(comment)))
    return {
        names[int(match[1]) - 1]: match[2]
        for match in found
        if 0 < int(match[1]) <= len(names)
        and any(common_size(match[2].strip(), unit) is not None for unit in EXAMPLES)
    }


def _noise(columns: Mapping[str, Array], known: Columns, names: Iterable[str]) -> dict[str, Array]:
    """Standard deviations of quantities, under the names of their columns."""
    of_all = columns.get(NOISE)
    result = {}
    for name in names:
        own = columns.get(f"{NOISE} {name}")
        if own is None and of_all is not None:
            own = of_all if NOISE in known.units else of_all * known.scale(name)
        if own is not None:
            result[f"{NOISE} {name}"] = own
    return result


def _any_finite(values: Mapping[str, Array], count: int) -> Mask:
    """Rows in which one quantity at least has a number."""
    known = [np.isfinite(value) for name, value in values.items() if not name.startswith(NOISE)]
    return np.any([np.zeros(count, dtype=bool), *known], axis=0)


def _rows_of(values: Mapping[str, Array], here: Mask) -> dict[str, Array]:
    return {name: value[here] for name, value in values.items()}


def _misplaced(y: Array, values: Mapping[str, Array], fields: Mapping[str, Array]) -> list[str]:
    """Parts that are omitted because they are misplaced, a sentence each."""
    notes = []
    for named, there, where in (
        (values, np.isfinite(y) & (y != 0), "is of the interface, where y is 0 or missing"),
        (fields, np.isnan(y), "is of points inside the bodies and needs its y"),
    ):
        for name, column in named.items():
            count = int(np.sum(there & np.isfinite(column)))
            if count and not name.startswith(NOISE):
                notes.append(f"{name} {where}: {count} rows are left out")
    return notes


def joined(parts: list[Records]) -> Records:
    """Stations of one run, a file each, as one; DataFileError if two are at the same position."""
    stations: dict[float, tuple[Record, str]] = {}
    for part in parts:
        for row in part.stations:
            if row.x in stations:
                raise DataFileError(
                    f"{stations[row.x][1]} and {part.source} are both of the station x = {row.x:g};"
                    " state the position of each, or put every run into a folder of its own."
                )
            stations[row.x] = row, part.source
    notes = tuple(dict.fromkeys(note for part in parts for note in part.notes))
    sources = ", ".join(part.source for part in parts)
    spacings = {part.spacing for part in parts}
    spacing = spacings.pop() if len(spacings) == 1 else None
    stated = parts[0].stated
    for part in parts:
        if part.stated != stated:
            raise DataFileError(
                f"{parts[0].source} and {part.source} name different units or conventions; write "
                "the stations of a run alike."
            )
    one_run = tuple(stations[x][0] for x in sorted(stations))
    unread = tuple(dict.fromkeys(name for part in parts for name in part.unread))
    return Records(one_run, None, sources, notes, spacing, stated, unread=unread)


def _bare_names(table: NamedColumns, alone: bool) -> tuple[str, ...]:
    """Return the names of unnamed columns; raise a DataFileError if their number does not fit."""
    wanted = ("t", "slip_rate") if alone else ("t", "x", "slip_rate")
    if table.rows.shape[1] == len(wanted):
        return wanted
    raise DataFileError(
        f"{table.path} has {table.rows.shape[1]} columns and no line that names them; write one, "
        "as t,x,slip_rate."
    )


def _position(
    table: NamedColumns, at: float | None, origin: float
) -> tuple[float, Unit | None, list[str]]:
    """Return the position of a station relative to the origin, its unit and notes on its source."""
    path = table.path
    if at is not None:
        return at - origin, None, []
    scec = _SCEC.search(path.name)
    if scec:
        x = SCEC_UNIT * int(scec[1]) - origin
        return x, Unit("m", 1.0), [f"{path.name} is at x = {x + origin:g} m, by its name"]
    for comment in table.comments:
        if match := _COMMENTED.match(comment):
            unit = _unit(path, match[2])
            size = unit.size if unit else 1.0
            return size * (_number(path, match[1]) - origin), unit, []
    named = _NAMED.search(path.stem.removesuffix(".csv"))
    if named:
        x = float(named[1])
        return x - origin, None, [f"{path.name} is at x = {x:g}, by its name"]
    raise DataFileError(
        f"{path} does not say where its station is; add a column x (for slipfront "
        "validate, its position with --at will do)."
    )


def _number(path: Path, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise DataFileError(f"{path}: {text!r} in a comment is not a number; correct it.") from None


def _unit(path: Path, text: str) -> Unit | None:
    """The unit behind a length in a comment; None where there is none."""
    return unit_of(path, 0, "a comment", text.strip("[](),;."), "x")


def _mean(table: NamedColumns) -> dict[str, Any]:
    """Fields of `Stated` for slip rates that comments call means over a step."""
    for comment in table.comments:
        if match := _MEAN.search(comment):
            return {"mean": AFTER, "step": _number(table.path, match[1])}
    return {}


def _spacing(table: NamedColumns, unit: Unit | None) -> float | None:
    """Distance of grid points, in the unit of x unless a comment names one, or 1 over the cells."""
    for comment in table.comments:
        if match := _SPACING.match(comment):
            own = _unit(table.path, match[2])
            if own is not None and unit is None:
                raise DataFileError(
                    f"{table.path} names a unit of its spacing and none of x; name both or none."
                )
            size = own or unit
            return _number(table.path, match[1]) * (size.size if size else 1.0)
    if unit is None and any(comment.startswith("benchmark:") for comment in table.comments):
        for comment in table.comments:
            cells = _CELLS.match(comment)
            if cells and int(cells[1]):
                return 1 / int(cells[1])
    return None


def _rupture_times(table: NamedColumns, options: ReadingOptions) -> Records:
    """Times of rupture by position, of the row nearest to k = 0."""
    j, k, t = table.rows.T
    depth = np.unique(k[np.abs(k) == np.nanmin(np.abs(k))])[0]
    here = (k == depth) & np.isfinite(j)
    order = np.argsort(j[here], kind="stable")
    x, times = j[here][order] - options.origin, t[here][order]
    if len(x) < 2:
        raise DataFileError(f"{table.path} has fewer than two times of rupture; give all of them.")
    notes = [f"times of rupture at k = {depth:g}"] if len(np.unique(k)) > 1 else []
    never = _never(x, times)
    for word in dict.fromkeys(f"{time:g}" for time in times[never]):
        notes.append(f"times of rupture {word} are read as never")
    return Records((), (x, np.where(never, np.inf, times)), str(table.path), tuple(notes))


def _never(x: Array, times: Array) -> Mask:
    """Which times of rupture say that there was none, whatever the code writes for that."""
    never = ~(times >= 0) | (times > NEVER)
    last = np.max(times[~never], initial=0.0)
    known = last >= 1e3 and any(math.log10(last + step) % 1 == 0 for step in (0, 1))
    if known and last >= _FAR * np.max(times[~never & (times < last)], initial=0.0):
        never |= times == last
    # a rupture that begins at the edge does not reach a point before those nearer to it
    begun = np.min(x[~never & (times > 0) & (x > 0)], initial=np.inf)
    return np.asarray(never | ((times == 0) & (x > begun)))
