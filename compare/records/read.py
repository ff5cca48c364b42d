"""Files of other codes as records, by what they are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path

from compare.records.arrays import read_hdf5, read_npz, read_simulation
from compare.records.bodies import read_bodies
from compare.records.codes import FAULT, read_sem2dpack, read_uguca
from compare.records.record import ReadingOptions, Records
from compare.records.tables import joined, read_text
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.bounds import MOST_FILES, beginning_of, parsing

MESHES = (".vtu", ".vtk", ".pvd", ".xdmf", ".xmf")
ARRAYS = (".npz", ".npy", ".h5", ".hdf5", ".hdf", ".nc")
BINARY = {b"PK\3\4": read_npz, b"\x93NUM": read_npz, b"\x89HDF": read_hdf5}
"""Readers of arrays by the first bytes of their files, whatever these are called."""
SIMULATION = "simulation.h5"


def read_records(
    paths: Sequence[str | Path], options: ReadingOptions | None = None
) -> list[Records]:
    """Read the records in files of other codes, one `Records` for each run.

    Files that hold one station each, and those of a folder, are one run; any other is a run of its
    own.  Runs are in the order of the paths, values in units of the files.  If one cannot be read,
    a DataFileError names the file, and the line where it has any.
    """
    options = options or ReadingOptions()
    files = [Path(path) for path in paths]
    if not files:
        raise DataFileError("There is no file to read; name at least one.")
    if options.at and len(options.at) != len(files):
        raise DataFileError(
            f"There are {len(options.at)} positions for {len(files)} files; give one for each."
        )
    runs: list[Records] = []
    alone: dict[Path, list[Records]] = {}
    for number, path in enumerate(files):
        if path.is_dir():
            runs.append(_read_folder(path, options))
            continue
        records, is_station = _read_file(path, options, options.at[number] if options.at else None)
        if is_station:
            alone.setdefault(path.parent, []).append(records)
        else:
            runs.append(records)
    return runs + [joined(parts) for parts in alone.values()]


def _read_file(path: Path, options: ReadingOptions, at: float | None) -> tuple[Records, bool]:
    """Records of a file, and whether it is one station of a run."""
    suffix = path.suffix.lower()
    if not path.exists():
        raise DataFileError(f"{path} does not exist; give a file that does.")
    binary = binary_reader(path)
    if options.gauges and (binary or suffix in MESHES):
        raise DataFileError(f"{path}: gauges are columns of a table of text; leave them out.")
    if reader := read_bodies if suffix in MESHES else binary:
        with parsing(path):
            return reader(path, options), False
    if suffix in ARRAYS:
        raise DataFileError(
            f"{path} cannot be read: it is no NPZ, NPY, HDF5 or NetCDF-4 file; write it again."
        )
    if suffix == ".info":
        return read_uguca(path, options), False
    if path.name.endswith(FAULT):
        return read_sem2dpack(path, options), False
    return read_text(path, options, at)


def binary_reader(path: Path) -> Callable[[Path, ReadingOptions], Records] | None:
    """The reader of an ordinary file of arrays; None for any other file."""
    return BINARY.get(beginning_of(path, 4))


def _read_folder(folder: Path, options: ReadingOptions) -> Records:
    """A run in a folder: a simulation of ours, a fault of SEM2DPACK, or a file for each station."""
    if (folder / SIMULATION).is_file():
        return read_simulation(folder)
    for header in sorted(folder.glob("*" + FAULT)):
        return read_sem2dpack(header, options)
    files = sorted(islice((path for path in folder.iterdir() if path.is_file()), MOST_FILES + 1))
    if len(files) > MOST_FILES:
        raise DataFileError(f"{folder} holds more than {MOST_FILES} files; leave some out.")
    if not files:
        raise DataFileError(f"{folder} is an empty folder; give one with files of stations.")
    parts = []
    for path in files:
        records, is_station = _read_file(path, options, None)
        if not is_station:
            raise DataFileError(
                f"{path} is a run of its own; give it alone, not the folder it lies in."
            )
        parts.append(records)
    return joined(parts)
