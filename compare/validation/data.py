"""Whatever holds records, as records: arrays, histories, what readers have read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from compare.records.arrays import of_history, records_of_arrays
from compare.records.record import ReadingOptions, Records
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import DataFileError

Data = Records | InterfaceHistory | Mapping[str, Any]
"""One run."""
LEAST_TIMES = 2
"""Least number of times that a station needs to be compared."""


def as_runs(data: Data | Sequence[Data]) -> list[Records]:
    """Records of one or several runs, in the order given.

    A mapping holds arrays "t", "x" and some of `QUANTITIES`: all of one length, a row for each
    sample, or t (m,), x (n,) or a number, and values (m, n) or (m,).  A DataFileError
    refuses no records, records of fewer than two times, and arrays that do not fit each other.
    """
    runs = [_run(run) for run in (data if isinstance(data, Sequence) else [data])]
    if not runs:
        raise DataFileError("validate: there are no records; give at least one run.")
    for run in runs:
        if run.points and not run.stations:
            raise DataFileError(
                f"{run.source} holds points inside the bodies alone, which slipfront fit takes; "
                "give records of the interface."
            )
    for record in (place for run in runs for place in run.stations if len(place.t) < LEAST_TIMES):
        raise DataFileError(
            f"validate: the record at x = {record.x:g} has {len(record.t)} times; it takes "
            f"{LEAST_TIMES} at least."
        )
    return runs


def _run(data: object) -> Records:
    if isinstance(data, Records):
        return data
    if isinstance(data, InterfaceHistory):
        return of_history(Path("interface history"), data)
    if not isinstance(data, Mapping):
        raise DataFileError(
            "validate: records must be Records, an InterfaceHistory or a mapping of arrays, got "
            f"{type(data).__name__}."
        )
    arrays = {str(name): np.asarray(values) for name, values in data.items()}
    return records_of_arrays(Path("arrays"), arrays, ReadingOptions())
