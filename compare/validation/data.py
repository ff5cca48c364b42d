"""Whatever holds records, as records: arrays, histories, what readers have read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.records.record import QUANTITIES, Record, Records
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import DataFileError

Array = NDArray[np.float64]

Data = Records | InterfaceHistory | Mapping[str, Any]
"""One run."""
LEAST_TIMES = 2
"""Least number of times that a station needs to be compared."""


def as_runs(data: Data | Sequence[Data]) -> list[Records]:
    """Records of one or several runs, in the order given.

    Parameters
    ----------
    data : Records, InterfaceHistory, mapping, or a sequence of them
        A mapping holds arrays "t", "x" and some of `QUANTITIES`: all of one length, a row for each
        sample, or t (m,), x (n,) or a number, and values (m, n) or (m,).

    Raises
    ------
    DataFileError
        If there are no records, one has fewer than two times, or arrays do not fit each other.
    """
    if isinstance(data, Records | InterfaceHistory | Mapping):
        data = [data]
    runs = [_run(one) for one in data]
    if not runs:
        raise DataFileError("validate: there are no records; give at least one run.")
    for run in runs:
        if run.points and not run.stations:
            raise DataFileError(
                f"{run.source} holds points inside the bodies alone, which slipfront fit takes; "
                "give records of the interface."
            )
    for record in (one for run in runs for one in run.stations if len(one.t) < LEAST_TIMES):
        raise DataFileError(
            f"validate: the record at x = {record.x:g} has {len(record.t)} times; it takes "
            f"{LEAST_TIMES} at least."
        )
    return runs


def _run(data: Data) -> Records:
    if isinstance(data, Records):
        return data
    if isinstance(data, InterfaceHistory):
        values = {name: getattr(data, name) for name in QUANTITIES}
        return Records(_columns(data.t, data.x, values), source="interface history")
    if not isinstance(data, Mapping):
        raise DataFileError(
            "validate: records must be Records, an InterfaceHistory or a mapping of arrays, got "
            f"{type(data).__name__}."
        )
    return _from_arrays(data)


def _from_arrays(data: Mapping[str, Any]) -> Records:
    missing = [name for name in ("t", "x") if name not in data]
    known = [name for name in QUANTITIES if name in data]
    if missing or not known:
        lacking = missing[0] if missing else f"any of {', '.join(QUANTITIES)}"
        raise DataFileError(f"validate: the arrays lack {lacking}; add it.")
    t, x = (np.atleast_1d(np.asarray(data[name], dtype=float)) for name in ("t", "x"))
    values = {name: np.asarray(data[name], dtype=float) for name in known}
    for name, array in values.items():
        if array.shape not in ((len(t), len(x)), (len(t),)):
            raise DataFileError(
                f"validate: {name} has shape {array.shape}, which does not fit t {t.shape} and x "
                f"{x.shape}; give one value for each time, or for each time and position."
            )
    if len(x) == len(t) and all(array.ndim == 1 for array in values.values()):
        return Records(_long_form(t, x, values), source="arrays")
    if len(x) != 1 and any(array.ndim == 1 for array in values.values()):
        raise DataFileError("validate: give one x, or values for each time and position.")
    columns = {name: array.reshape(len(t), len(x)) for name, array in values.items()}
    return Records(_columns(t, x, columns), source="arrays")


def _columns(t: Array, x: Array, values: Mapping[str, Array]) -> tuple[Record, ...]:
    return tuple(
        sorted_record(place, t, {name: array[:, column] for name, array in values.items()})
        for column, place in sorted(enumerate(map(float, x)), key=lambda pair: pair[1])
    )


def _long_form(t: Array, x: Array, values: Mapping[str, Array]) -> tuple[Record, ...]:
    return tuple(
        sorted_record(
            float(place), t[x == place], {name: array[x == place] for name, array in values.items()}
        )
        for place in np.unique(x[np.isfinite(x)])
    )


def sorted_record(x: float, t: Array, values: Mapping[str, Array]) -> Record:
    """A record in the order of its times, each once, those that are no number left out."""
    _, first = np.unique(t, return_index=True)
    order = first[np.isfinite(t[first])]
    return Record(x, t[order], {name: array[order] for name, array in values.items()})
