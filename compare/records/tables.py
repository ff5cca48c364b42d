"""Tables of text as records: rows of all stations, one station a file, times of rupture."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from compare.records.names import known_columns, no_columns
from compare.records.options import ReadingOptions
from compare.records.record import Record, Records
from compare.records.stations import joined_faces, station, stations_of_rows
from compare.records.text import Table, read_table
from semianalytic.scene.errors import DataFileError

SCEC_UNIT = 100.0
"""Metres to which the numbers of a SCEC station's name count."""
NEVER = 1e8
"""Time of rupture from which on there is none: SCEC writes 1e9."""

_SCEC = re.compile(r"faultst(-?\d+)dp(-?\d+)", re.IGNORECASE)
_NAMED = re.compile(r"(?:^|[_\-\s])x[_=]?(-?\d+(?:\.\d+)?(?:e-?\d+)?)", re.IGNORECASE)
_COMMENTED = re.compile(r"^(?:x|position|station)\s*[:=]\s*([-+\d.eE]+)", re.IGNORECASE)
_SPACING = re.compile(r"^(?:spacing|dx|element_size|grid spacing)\s*[:=]\s*([-+\d.eE]+)", re.I)
_CELLS = re.compile(r"^cells\s*[:=]\s*(\d+)", re.IGNORECASE)


def read_text(path: Path, options: ReadingOptions, at: float | None) -> tuple[Records, bool]:
    """Records of one text file, and whether it is one station of a run.

    Parameters
    ----------
    path : Path
    options : ReadingOptions
    at : float or None
        Position of its station, if that is told.

    Raises
    ------
    DataFileError
        If it cannot be read; the message says where.
    """
    table = read_table(path)
    if tuple(name.lower() for name in table.names) == ("j", "k", "t"):
        return _rupture_times(table, options), False
    names = table.names or _bare_names(table, alone=at is not None or bool(_SCEC.search(path.name)))
    places, scales, notes = known_columns(path, names, options.columns, table.line)
    if "t" not in places:
        raise DataFileError(
            f"{path} has no column of times among {', '.join(names)}; call it t, or say t=NAME."
        )
    columns = {name: table.rows[:, i] * scales.get(name, 1.0) for name, i in places.items()}
    values, more = joined_faces(columns)
    if not values:
        raise no_columns(path, names, table.line)
    spacing = _spacing(table)
    if "x" in columns and at is None:
        along = columns["x"] - options.origin
        stations, mended = stations_of_rows(path, along, columns["t"], values)
        return Records(stations, None, str(path), (*notes, *more, *mended), spacing), False
    x, how = _position(table, at)
    one, mended = station(path, x - options.origin, columns["t"], values)
    return Records((one,), None, str(path), (*notes, *more, *how, *mended), spacing), True


def joined(parts: list[Records]) -> Records:
    """Stations of one run, a file each, as one.

    Raises
    ------
    DataFileError
        If two are at the same position.
    """
    stations: dict[float, tuple[Record, str]] = {}
    for part in parts:
        for one in part.stations:
            if one.x in stations:
                raise DataFileError(
                    f"{stations[one.x][1]} and {part.source} are both of the station x = {one.x:g};"
                    " say where each is, or put every run into a folder of its own."
                )
            stations[one.x] = one, part.source
    notes = tuple(dict.fromkeys(note for part in parts for note in part.notes))
    sources = ", ".join(part.source for part in parts)
    spacings = {part.spacing for part in parts}
    spacing = spacings.pop() if len(spacings) == 1 else None
    return Records(tuple(stations[x][0] for x in sorted(stations)), None, sources, notes, spacing)


def _bare_names(table: Table, alone: bool) -> tuple[str, ...]:
    """What columns without names are, if there are as many as there have to be."""
    wanted = ("t", "slip_rate") if alone else ("t", "x", "slip_rate")
    if table.rows.shape[1] == len(wanted):
        return wanted
    raise DataFileError(
        f"{table.path} has {table.rows.shape[1]} columns and no line that names them; write one, "
        "as t,x,slip_rate."
    )


def _position(table: Table, at: float | None) -> tuple[float, list[str]]:
    """Where a station is, and how that is known."""
    if at is not None:
        return at, []
    scec = _SCEC.search(table.path.name)
    if scec:
        x = SCEC_UNIT * int(scec[1])
        return x, [f"{table.path.name} is at x = {x:g} m, by its name"]
    for comment in table.comments:
        match = _COMMENTED.match(comment)
        if match:
            return _number(table.path, match[1]), []
    named = _NAMED.search(table.path.stem.removesuffix(".csv"))
    if named:
        return float(named[1]), [f"{table.path.name} is at x = {float(named[1]):g}, by its name"]
    raise DataFileError(
        f"{table.path} does not say where its station is; add a column x, or give its position "
        "with --at."
    )


def _number(path: Path, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise DataFileError(f"{path}: {text!r} in a comment is not a number; mend it.") from None


def _spacing(table: Table) -> float | None:
    """Between grid points, where a comment says so: itself, or cells over c_t T = 1."""
    for comment in table.comments:
        match = _SPACING.match(comment)
        if match:
            return _number(table.path, match[1])
    if any(comment.startswith("benchmark:") for comment in table.comments):
        for comment in table.comments:
            cells = _CELLS.match(comment)
            if cells and int(cells[1]):
                return 1 / int(cells[1])
    return None


def _rupture_times(table: Table, options: ReadingOptions) -> Records:
    """Times of rupture by position, of the row nearest to k = 0."""
    j, k, t = table.rows.T
    depth = np.unique(k[np.abs(k) == np.nanmin(np.abs(k))])[0]
    here = (k == depth) & np.isfinite(j) & np.isfinite(t)
    order = np.argsort(j[here], kind="stable")
    x, times = j[here][order] - options.origin, t[here][order]
    if len(x) < 2:
        raise DataFileError(f"{table.path} has fewer than two times of rupture; give all of them.")
    notes = (f"times of rupture at k = {depth:g}",) if len(np.unique(k)) > 1 else ()
    times = np.where(times > NEVER, np.inf, times)
    return Records((), (x, times), str(table.path), notes)
