"""Columns of numbers to records at stations: sorted, each time once, faces joined."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from compare.records.names import FACES
from compare.records.record import QUANTITIES, Array, Record
from semianalytic.scene.errors import DataFileError

LEAST_TIMES = 2
"""At a station, to be a record."""


def joined_faces(columns: Mapping[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """Quantities of the interface from columns of it or of its faces, and what was made of these.

    One face alone stands for the relative quantity, which is for `validate` to double.
    """
    result = {name: columns[name] for name in QUANTITIES if name in columns}
    notes = []
    for name, (upper, lower) in FACES.items():
        if name in result or not (upper in columns or lower in columns):
            continue
        if upper in columns and lower in columns:
            result[name] = columns[upper] - columns[lower]
            notes.append(f"{name} is {upper} less {lower}")
        elif upper in columns:
            result[name] = columns[upper]
            notes.append(f"{name} is that of the upper face alone")
        else:
            result[name] = -columns[lower]
            notes.append(f"{name} is that of the lower face alone, turned")
    return result, notes


def station(
    path: Path, x: float, t: Array, values: Mapping[str, Array]
) -> tuple[Record, list[str]]:
    """A record of times that increase, and what was mended.

    Raises
    ------
    DataFileError
        If there are fewer than two times, or no values.
    """
    notes = []
    timed = np.isfinite(t)
    if not timed.all():
        notes.append(f"{np.sum(~timed)} rows without a time are left out")
    order = np.flatnonzero(timed)
    if np.any(np.diff(t[order]) < 0):
        notes.append("rows are sorted by time")
        order = order[np.argsort(t[order], kind="stable")]
    last = np.append(np.diff(t[order]) > 0, True)[: len(order)]
    if not last.all():
        notes.append("of rows of the same time the last is kept")
    order = order[last]
    if len(order) < LEAST_TIMES:
        raise DataFileError(
            f"{path} has {len(order)} times at x = {x:g}; a record takes {LEAST_TIMES} at least."
        )
    kept = {name: value[order] for name, value in values.items()}
    empty = [name for name, value in kept.items() if not np.isfinite(value).any()]
    kept = {
        name: np.where(np.isfinite(value), value, np.nan)
        for name, value in kept.items()
        if name not in empty
    }
    if not kept:
        raise DataFileError(
            f"{path} has no finite number at x = {x:g}; leave that station out, or write it anew."
        )
    notes += [f"{name} has no number at x = {x:g} and is left out there" for name in empty]
    return Record(float(x), t[order], kept), notes


def stations_of_rows(
    path: Path, x: Array, t: Array, values: Mapping[str, Array]
) -> tuple[tuple[Record, ...], list[str]]:
    """Records of rows (n,), each at a position and a time."""
    result = []
    notes: dict[str, None] = {}
    placed = np.isfinite(x)
    if not placed.all():
        notes[f"{np.sum(~placed)} rows without a position are left out"] = None
    for place in np.unique(x[placed]):
        here = x == place
        one, more = station(path, place, t[here], {k: v[here] for k, v in values.items()})
        result.append(one)
        notes.update(dict.fromkeys(more))
    if not result:
        raise DataFileError(f"{path} has no row with a position; give x in every row.")
    return tuple(result), list(notes)


def stations_of_grid(
    path: Path, x: Array, t: Array, values: Mapping[str, Array]
) -> tuple[tuple[Record, ...], list[str]]:
    """Records of arrays (m, n) at times (m,) and positions (n,)."""
    result = []
    notes: dict[str, None] = {}
    for place in np.argsort(x):
        columns = {name: value[:, place] for name, value in values.items()}
        one, more = station(path, x[place], t, columns)
        result.append(one)
        notes.update(dict.fromkeys(more))
    return tuple(result), list(notes)


def contact_stations(
    path: Path, x: Array, t: Array, values: Mapping[str, Array]
) -> tuple[tuple[Record, ...], list[str]]:
    """Records of arrays (m, n) at times (m,) and those of positions (n,) that are ahead of the
    contact edge, x > 0."""
    inside = x > 0
    kept = {name: value[:, inside] for name, value in values.items()}
    return stations_of_grid(path, x[inside], t, kept)
