"""Read the native output of two codes: dumps of UGUCA and fault data of SEM2DPACK."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from compare.records.names import Columns
from compare.records.record import AFTER, ReadingOptions, Records
from compare.records.stations import joined_faces, stations_of_grid
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.bounds import check_file_size
from semianalytic.scene.tables.text import read_table, text_of

UGUCA_FIELDS = {
    "top_velo_0": "velocity_upper",
    "bot_velo_0": "velocity_lower",
    "top_disp_0": "displacement_upper",
    "bot_disp_0": "displacement_lower",
    "cohesion_0": "shear_traction",
    "cohesion_1": "pressure",
}
SEM_FIELDS = {
    "Slip": "slip",
    "Slip_Rate": "slip_rate",
    "Shear_Stress": "shear_traction",
    "Normal_Stress": "pressure",
}
FAULT = "_sem2d.hdr"
"""How the name of a header of SEM2DPACK's fault data ends."""
RECORD_MARK = 4
"""Bytes before and after each record of a sequential file of Fortran."""


def read_uguca(path: Path, options: ReadingOptions) -> Records:
    """Records of the dump that a file NAME.info of UGUCA describes, in text.

    Its slip rate is the mean over the step of the code that follows; the times say how long it is.
    """
    facts = dict(_words(path, 2))
    try:
        coordinates = read_table(path.parent / facts["coord_description"], 1).rows
        times = read_table(path.parent / facts["time_description"], 1).rows
        listed = _words(path.parent / facts["field_description"], 2)
        folder = path.parent / facts["folder_name"]
    except KeyError as error:
        raise DataFileError(
            f"{path} does not say {error.args[0]}; give the file NAME.info."
        ) from None
    columns = {
        UGUCA_FIELDS[name]: read_table(folder / file, 1).rows
        for name, file in listed
        if name in UGUCA_FIELDS
    }
    values, stated, notes = joined_faces(columns, Columns({}))
    x, t = coordinates[:, 0] - options.origin, times[:, -1]
    count = times[-1, 0] if times.shape[1] > 1 else 0.0
    stated = replace(stated, mean=AFTER, step=float(t[-1] / count) if count > 0 else None)
    for name, value in values.items():
        if value.shape != (len(t), len(x)):
            raise DataFileError(
                f"{path}: {name} has shape {value.shape}, where times and coordinates ask for "
                f"{(len(t), len(x))}; write the files again."
            )
    stations, mended = stations_of_grid(path, x, t, values)
    unread = tuple(name for name, _ in listed if name not in UGUCA_FIELDS)
    return Records(stations, None, str(path), (*notes, *mended), stated=stated, unread=unread)


def read_sem2dpack(path: Path, options: ReadingOptions) -> Records:
    """Records of a fault of SEM2DPACK, from its header; the data are in the same folder.

    Tractions in the data are changes, to which the initial ones are added.
    """
    lines = text_of(path).splitlines()
    try:
        points, count, _, step = (float(word) for word in lines[1].split())
        names = lines[2].strip().split(":")
        x = np.array([float(line.split()[0]) for line in lines[4 : 4 + int(points)]])
    except (IndexError, ValueError):
        raise DataFileError(f"{path} is not a header of fault data; give it as written.") from None
    stem = str(path)[: -len(FAULT)]
    data = _fortran_records(Path(stem + "_sem2d.dat"), int(points), int(count))
    initial = read_table(Path(stem + "_init_sem2d.tab"), 1).rows
    if len(names) != count or len(x) != points or len(initial) != points:
        raise DataFileError(f"{path} and its other files are not of one run; write them again.")
    columns = {SEM_FIELDS[name]: data[:, i] for i, name in enumerate(names) if name in SEM_FIELDS}
    for name, place in (("shear_traction", 0), ("pressure", 1)):
        if name in columns:
            columns[name] = columns[name] + initial[:, place]
    t = step * np.arange(float(len(data)))
    stations, notes = stations_of_grid(path, x - options.origin, t, columns)
    notes.append("Normal_Stress is read as pressure")
    unread = tuple(name for name in names if name not in SEM_FIELDS)
    return Records(stations, None, str(path), tuple(notes), unread=unread)


def _words(path: Path, least: int) -> list[list[str]]:
    rows = [line.split() for line in text_of(path).splitlines() if line.strip()]
    for number, row in enumerate(rows, 1):
        if len(row) < least:
            raise DataFileError(f"{path}, line {number}: there should be {least} words.")
    return [row[:least] for row in rows]


def _fortran_records(path: Path, points: int, count: int) -> Array:
    """Data (m, count, points) of records of single precision, each between two marks."""
    check_file_size(path)
    try:
        raw = np.fromfile(path, dtype=np.uint8)
    except OSError as error:
        raise DataFileError(f"{path} cannot be read ({error.strerror}).") from error
    size = 4 * points + 2 * RECORD_MARK
    if not len(raw) or len(raw) % (size * count):
        raise DataFileError(
            f"{path} has {len(raw)} bytes, no multiple of {size * count}, what its header says one "
            "time takes; give both files of one run."
        )
    records = raw.reshape(-1, size)[:, RECORD_MARK:-RECORD_MARK]
    return np.ascontiguousarray(records).view("<f4").astype(float).reshape(-1, count, points)
