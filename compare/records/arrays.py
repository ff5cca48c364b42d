"""Arrays over times and positions as records: NPZ and HDF5, those of this package included."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from compare.records.names import known_columns, no_columns
from compare.records.options import ReadingOptions
from compare.records.record import QUANTITIES, Array, Records
from compare.records.stations import (
    contact_stations,
    joined_faces,
    stations_of_grid,
    stations_of_rows,
)
from semianalytic.results.interface_history import FORMAT as HISTORY
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import DataFileError

ANEW = "write it anew"


def read_npz(path: Path, options: ReadingOptions) -> Records:
    """Records of an NPZ file of arrays t (m,), x (n,) and quantities (m, n), or all of rows (n,).

    Raises
    ------
    DataFileError
        If it is damaged, or the arrays do not fit.
    """
    with _damage(path), np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    return records_of_arrays(path, arrays, options)


def read_hdf5(path: Path, options: ReadingOptions) -> Records:
    """Records of an HDF5 file: a history, a march or a simulation of this package, or datasets t, x
    and quantities as in an NPZ file.

    Raises
    ------
    DataFileError
        If it is damaged, or holds nothing of that kind.
    """
    import h5py

    with _damage(path), h5py.File(path) as file:
        kind = str(file.attrs.get("format", ""))
        arrays = {
            name: np.asarray(item) for name, item in file.items() if isinstance(item, h5py.Dataset)
        }
    if kind == HISTORY:
        return of_history(path, InterfaceHistory.load(path))
    if kind.startswith("slipfront march"):
        from semianalytic import Marched

        return of_history(path, Marched.load(path).interface)
    if kind.startswith("slipfront simulation"):
        return read_simulation(path.parent)
    return records_of_arrays(path, arrays, options)


def read_simulation(folder: Path) -> Records:
    """Records of a simulation of this package, with the size of its elements."""
    from fem import load_simulation

    simulation = load_simulation(folder)
    return of_history(folder, simulation.interface, simulation.element_size)


def of_history(path: Path, history: InterfaceHistory, spacing: float | None = None) -> Records:
    """Records at all positions of a history but that of the contact edge."""
    values = {name: getattr(history, name) for name in QUANTITIES}
    stations, notes = contact_stations(path, history.x, history.t, values)
    return Records(stations, None, str(path), tuple(notes), spacing)


def records_of_arrays(
    path: Path, arrays: Mapping[str, np.ndarray], options: ReadingOptions
) -> Records:
    """Records of arrays by name.

    Raises
    ------
    DataFileError
        If there are no times, positions or quantities, or they do not fit each other.
    """
    places, scales, notes = known_columns(path, list(arrays), options.columns)
    named = list(arrays.items())
    columns: dict[str, Array] = {}
    for name, place in places.items():
        key, array = named[place]
        if array.dtype.kind not in "fiu":
            raise DataFileError(f"{path}: array {key!r} does not hold real numbers; {ANEW}.")
        columns[name] = np.asarray(array, dtype=float) * scales.get(name, 1.0)
    for name, what in (("t", "times"), ("x", "positions")):
        if name not in columns:
            raise DataFileError(
                f"{path} has no array of {what} among {', '.join(arrays) or 'none'}; call it "
                f"{name}, or say {name}=NAME."
            )
    t, x = np.atleast_1d(columns.pop("t")), np.atleast_1d(columns.pop("x")) - options.origin
    values, more = joined_faces(columns)
    if not values:
        raise no_columns(path, list(arrays))
    fitted = {name: _fitted(path, name, value, t, x) for name, value in values.items()}
    turned = [name for name in fitted if fitted[name].shape != values[name].shape]
    if turned:
        more.append(f"{', '.join(turned)} had positions first and is turned")
    in_rows = t.shape == x.shape and all(value.ndim == 1 for value in fitted.values())
    stations_of = stations_of_rows if in_rows else stations_of_grid
    stations, mended = stations_of(path, x, t, fitted)
    return Records(stations, None, str(path), (*notes, *more, *mended))


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


@contextmanager
def _damage(path: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, RuntimeError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise DataFileError(f"{path} cannot be read ({reason}); {ANEW}.") from error
