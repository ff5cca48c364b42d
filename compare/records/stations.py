"""Columns of numbers to records at stations: sorted, each time once, faces joined."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from compare.records.names import FACES, NOISE, Columns
from compare.records.record import QUANTITIES, Record, Stated
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.bounds import LARGEST_STATIONS


def joined_faces(
    columns: Mapping[str, Array], known: Columns
) -> tuple[dict[str, Array], Stated, list[str]]:
    """Quantities of the interface from columns of it or of its faces.

    One face alone stands for the relative quantity, which is for `validate` and `fit` to double.
    With them come what the columns say of them, and what was made of columns of faces.
    """
    result = {name: columns[name] for name in QUANTITIES if name in columns}
    units = {name: unit for name, unit in known.units.items() if name in (*result, "t", "x")}
    notes, alone = [], set()
    for name, faces in FACES.items():
        there = [face for face in faces if face in columns]
        if name in result or not there:
            continue
        upper, lower = faces
        if len(there) == 2:
            result[name] = columns[upper] - columns[lower]
            notes.append(f"{name} is {upper} less {lower}")
        else:
            alone.add(name)
            result[name] = columns[upper] if upper in columns else -columns[lower]
            side = "upper face alone" if upper in columns else "lower face alone, turned"
            notes.append(f"{name} is that of the {side}")
        if all(face in known.units for face in there):
            units[name] = known.units[there[0]]
    return result, Stated(units, frozenset(alone), known.changes), notes


def station(
    path: Path, x: float, t: Array, values: Mapping[str, Array]
) -> tuple[Record, list[str]]:
    """A record of increasing times, and the corrections; DataFileError if it is empty."""
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
    if not len(order):
        raise DataFileError(f"{path} has no time at x = {x:g}; give one in every row.")
    kept = {name: value[order] for name, value in values.items()}
    for name, value in kept.items():
        if np.isinf(value).any():
            raise DataFileError(
                f"{path}: {name} is infinite at x = {x:g}, t = {t[order][np.isinf(value)][0]:g}; "
                "leave out values written by a run that failed."
            )
    empty = [name for name, value in kept.items() if not np.isfinite(value).any()]
    kept = {name: value for name, value in kept.items() if name not in empty}
    noise = {name: kept.pop(f"{NOISE} {name}", None) for name in list(kept)}
    if not kept:
        raise DataFileError(
            f"{path} has no finite number at x = {x:g}; leave that station out, or write it again."
        )
    notes += [f"{name} has no number at x = {x:g} and is left out there" for name in empty]
    known = {name: value for name, value in noise.items() if value is not None}
    return Record(float(x), t[order], kept, noise=known), notes


Stations = tuple[tuple[Record, ...], list[str]]
"""Records by position, and the corrections made in them."""


def _stations(
    path: Path, count: int, parts: Iterable[tuple[float, Array, Mapping[str, Array]]]
) -> Stations:
    """Records of positions, times and values."""
    if count > LARGEST_STATIONS:
        raise DataFileError(
            f"{path} has {count} stations, and at most {LARGEST_STATIONS} are read; leave some out."
        )
    found = [station(path, *part) for part in parts]
    notes = dict.fromkeys(note for _, mended in found for note in mended)
    return tuple(record for record, _ in found), list(notes)


def stations_of_rows(path: Path, x: Array, t: Array, values: Mapping[str, Array]) -> Stations:
    """Records of rows (n,), each at a position and a time."""
    placed = np.isfinite(x)
    order = np.flatnonzero(placed)[np.argsort(x[placed], kind="stable")]
    if not len(order):
        raise DataFileError(f"{path} has no row with a position; give x in every row.")
    rows = np.split(order, np.flatnonzero(np.diff(x[order])) + 1)
    parts = (
        (float(x[here[0]]), t[here], {name: value[here] for name, value in values.items()})
        for here in rows
    )
    stations, notes = _stations(path, len(rows), parts)
    lost = int(np.sum(~placed))
    return stations, [f"{lost} rows without a position are left out"] * (lost > 0) + notes


def stations_of_grid(path: Path, x: Array, t: Array, values: Mapping[str, Array]) -> Stations:
    """Records of arrays (m, n) at times (m,) and positions (n,)."""
    parts = (
        (x[place], t, {name: value[:, place] for name, value in values.items()})
        for place in np.argsort(x)
    )
    return _stations(path, len(x), parts)
