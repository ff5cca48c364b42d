"""Arrays over times and positions as records: NPZ, HDF5 and NetCDF, those of this package included.

NetCDF, as xarray writes it by way of h5netcdf, is HDF5 with units and scales of dimensions.
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from compare.records.names import known_columns, no_columns
from compare.records.record import QUANTITIES, ReadingOptions, Records
from compare.records.stations import joined_faces, stations_of_grid, stations_of_rows
from semianalytic.results.interface_history import FORMAT as HISTORY
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.bounds import MOST_FILES, check_file_size, check_numbers

ANEW = "write it again"


def read_npz(path: Path, options: ReadingOptions) -> Records:
    """Records of an NPZ file of arrays t (m,), x (n,) and quantities (m, n), or all of rows (n,).

    An NPY file of rows with named fields is taken as well; a DataFileError refuses what does not
    fit.
    """
    check_file_size(path)
    if not zipfile.is_zipfile(path):
        return records_of_arrays(path, _fields(path), options)
    with zipfile.ZipFile(path) as file:
        infos = file.infolist()[:MOST_FILES]
        members = {info.filename.removesuffix(".npy"): info for info in infos}
        heads = {name: _head(file, member) for name, member in members.items()}
        wanted = _wanted(path, list(members), options)
        for name in wanted:
            _check_head(path, name, heads[name], members[name].file_size)
        check_numbers(path, sum(math.prod(heads[name][0]) for name in wanted))
        arrays: dict[str, np.ndarray] = {}
        for name, (shape, _) in heads.items():
            if name in wanted:
                with file.open(members[name]) as stream:
                    arrays[name] = np.lib.format.read_array(stream, allow_pickle=False)
            else:
                arrays[name] = _not_read(shape)
    return records_of_arrays(path, arrays, options)


def _not_read(shape: tuple[int, ...]) -> np.ndarray:
    """Stands for an array that holds nothing of the interface, and takes no memory."""
    return np.broadcast_to(np.nan, shape)


Head = tuple[tuple[int, ...], np.dtype[Any]]
"""Shape and type of an array, as a file says them."""


def _head(file: zipfile.ZipFile, member: zipfile.ZipInfo) -> Head:
    """Shape and type that the header of an array names; no bytes of the array are read."""
    with file.open(member) as stream:
        try:
            version = np.lib.format.read_magic(stream)
            read = np.lib.format.read_array_header_1_0
            if version != (1, 0):
                read = np.lib.format.read_array_header_2_0
            shape, _, dtype = read(stream)
        except ValueError:
            return (), np.dtype(object)
    return tuple(shape), dtype


def _check_head(path: Path, name: str, head: Head, size: int) -> None:
    """Refuse an array whose header asks for more than there is, and one of objects."""
    shape, dtype = head
    if dtype.hasobject:
        raise DataFileError(f"{path}: array {name!r} does not hold real numbers; {ANEW}.")
    if math.prod(shape) * dtype.itemsize > size:
        raise DataFileError(f"{path}: array {name!r} is shorter than its header says; {ANEW}.")


def _wanted(path: Path, names: list[str], options: ReadingOptions) -> set[str]:
    """Names of the arrays that hold something of the interface."""
    places = known_columns(path, names, options.columns).places
    return {names[place] for place in places.values()}


def _fields(path: Path) -> dict[str, np.ndarray]:
    """Fields of the rows of an NPY file."""
    array = np.load(path, mmap_mode="r", allow_pickle=False)
    if not isinstance(array, np.ndarray) or array.dtype.names is None:
        raise DataFileError(
            f"{path} holds one array without names; save its columns with numpy.savez(t=..., "
            "x=..., slip_rate=...)."
        )
    check_numbers(path, array.size * len(array.dtype.names))
    return {name: np.array(array[name]).ravel() for name in array.dtype.names}


def read_hdf5(path: Path, options: ReadingOptions) -> Records:
    """Records of an HDF5 file: a history, a march or a simulation of this package, or datasets t, x
    and quantities as in an NPZ file.
    """
    import h5py

    check_file_size(path)
    with h5py.File(path) as file:
        kind = str(file.attrs.get("format", ""))
        own, fields = kind.startswith("slipfront"), file
        if kind.startswith("slipfront march") and "motion" in file:  # one along a line
            own, fields = False, file["interface"]
        sets = {name: field for name, field in fields.items() if isinstance(field, h5py.Dataset)}
        wanted = set() if own else _wanted(path, list(sets), options)
        shapes = [sets[name].shape for name in wanted]
        if not wanted:  # then of all datasets, in groups as well
            file.visititems(lambda _, item: shapes.append(getattr(item, "shape", None)))
        check_numbers(path, sum(math.prod(shape or (0,)) for shape in shapes))
        arrays = {
            name: np.asarray(data) if name in wanted else _not_read(data.shape or ())
            for name, data in sets.items()
        }
        named = {name: data.attrs["units"] for name, data in sets.items() if "units" in data.attrs}
        units = {
            name: text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
            for name, text in named.items()
        }
    if kind == HISTORY:
        return of_history(path, InterfaceHistory.load(path))
    if own and kind.startswith("slipfront march"):
        from semianalytic import Marched

        return of_history(path, Marched.load(path).interface)
    if kind.startswith("slipfront simulation"):
        return read_simulation(path.parent)
    return records_of_arrays(path, arrays, options, units)


def read_simulation(folder: Path) -> Records:
    """Records of a simulation of this package, with the size of its elements."""
    from fem.results import load_simulation

    simulation = load_simulation(folder)
    return of_history(folder, simulation.interface, simulation.element_size)


def of_history(path: Path, history: InterfaceHistory, spacing: float | None = None) -> Records:
    """Records at all positions of a history but that of the contact edge."""
    ahead = history.x > 0
    values = {name: getattr(history, name)[:, ahead] for name in QUANTITIES}
    stations, notes = stations_of_grid(path, history.x[ahead], history.t, values)
    return Records(stations, None, str(path), tuple(notes), spacing)


def records_of_arrays(
    path: Path,
    arrays: Mapping[str, np.ndarray],
    options: ReadingOptions,
    units: Mapping[str, str] | None = None,
) -> Records:
    """Records of arrays by name, some of which may have units; DataFileError if they do not fit."""
    known = known_columns(path, list(arrays), options.columns, units=units)
    named = list(arrays.items())
    columns: dict[str, Array] = {}
    for name, place in known.places.items():
        key, array = named[place]
        if array.dtype.kind not in "fiu":
            raise DataFileError(f"{path}: array {key!r} does not hold real numbers; {ANEW}.")
        columns[name] = np.asarray(array, dtype=float) * known.scale(name)
    for name, what in (("t", "times"), ("x", "positions")):
        if name not in columns:
            raise DataFileError(
                f"{path} has no array of {what} among {', '.join(arrays) or 'none'}; call it "
                f"{name}, or say {name}=NAME."
            )
    t, x = np.atleast_1d(columns.pop("t")), np.atleast_1d(columns.pop("x"))
    x = x - options.origin * known.scale("x")
    values, stated, more = joined_faces(columns, known)
    if not values:
        raise no_columns(path, list(arrays))
    fitted = {name: _fitted(path, name, value, t, x) for name, value in values.items()}
    turned = [name for name in fitted if fitted[name].shape != values[name].shape]
    if turned:
        more.append(f"{', '.join(turned)} had positions first and is turned")
    in_rows = t.shape == x.shape and all(value.ndim == 1 for value in fitted.values())
    stations_of = stations_of_rows if in_rows else stations_of_grid
    stations, mended = stations_of(path, x, t, fitted)
    notes = (*known.notes, *more, *mended)
    # arrays of other shapes hold no quantity of these times and positions
    shapes = {shape for column in columns.values() for shape in (column.shape, column.shape[::-1])}
    unread = tuple(name for name in known.unread if np.shape(arrays[name]) in shapes)
    return Records(stations, None, str(path), notes, stated=stated, unread=unread)


def _fitted(path: Path, name: str, value: Array, t: Array, x: Array) -> Array:
    """A quantity as an array (m, n) over times and positions, or of rows."""
    if t.ndim != 1 or x.ndim != 1 or not len(t) or not len(x):
        raise DataFileError(f"{path}: t and x must be arrays of one dimension; {ANEW}.")
    if value.shape == (len(t), len(x)) or value.shape == t.shape == x.shape:
        return value
    if value.shape == (len(x), len(t)):
        return value.T
    if len(x) == 1 and value.shape == t.shape:
        return value[:, None]
    raise DataFileError(
        f"{path}: {name} has shape {value.shape}, where t and x ask for ({len(t)}, {len(x)}); "
        f"{ANEW}."
    )
