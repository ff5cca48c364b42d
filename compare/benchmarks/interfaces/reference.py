"""Answers to the sheets of interfaces: the limit of two grids, and how well it is known.

Slip, slip rate and shear traction at stations and times are extrapolated from two runs.  The stated
error is the difference from the limit of the next coarser two, which is about the error of that
one: more than what is left.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from compare.benchmarks.interfaces.sheets import InterfaceSheet
from compare.records.record import Record
from semianalytic import Run, solve

Array = NDArray[np.float64]

LEAST_ERROR = 1e-6
"""Smallest error that is stated: values are written to seven digits."""
ARRIVALS = "arrivals"


@dataclass(frozen=True, eq=False)
class Reference:
    """What an interface does at the stations of its sheet.

    Attributes
    ----------
    x : (k,) array
        Stations [length].
    t : (m,) array
        Times [time].
    values : mapping of str to (m, k) array
        The quantities that the sheet asks for.
    arrivals : (k,) array
        First times at which the slip rate is above the level of the sheet [time]; inf if never.
    errors : mapping
        Stated relative L1 error of each quantity over times and stations; of "arrivals" the
        largest error [time].
    """

    x: Array
    t: Array
    values: Mapping[str, Array]
    arrivals: Array
    errors: Mapping[str, float]

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the slip at the nearest stations and times [length]."""
        return self._nearest("slip", x, t)

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the slip rate at the nearest stations and times [length / time]."""
        return self._nearest("slip_rate", x, t)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the shear traction at the nearest stations and times [stress]."""
        return self._nearest("shear_traction", x, t)

    def arrivals_at(self, x: ArrayLike) -> Array:
        """Return the arrivals at the nearest stations [time]."""
        return np.asarray(self.arrivals[_nearest(self.x, x)])

    def at_times(self, record: Record, step: float) -> Record:
        """Return a record at the times of the answer that it covers, linear between its samples.

        Fronts are so sharp that only a record, which has the steps of its code, may be
        interpolated.  Slip rates that are means from t to t + step count for the middle.
        """
        t = self.t[(self.t >= record.t[0]) & (self.t <= record.t[-1])]
        moved = {name: step / 2 if name == "slip_rate" else 0.0 for name in record.values}
        values = {
            name: np.interp(t, record.t + moved[name], one) for name, one in record.values.items()
        }
        return Record(record.x, t, values)

    def _nearest(self, name: str, x: ArrayLike, t: ArrayLike) -> Array:
        return np.asarray(self.values[name][_nearest(self.t, t), _nearest(self.x, x)])


def _nearest(known: Array, given: ArrayLike) -> NDArray[np.intp]:
    wanted = np.asarray(given, dtype=float)[..., None]
    return np.asarray(np.abs(known - wanted).argmin(axis=-1))


def sampled(sheet: InterfaceSheet, nodes: int) -> Reference:
    """Return a run on so many nodes at stations and times of a sheet, with no errors."""
    done: Run = solve(
        sheet.interface,
        end_time=sheet.end_time,
        nodes=nodes,
        times=list(sheet.times),
        slipping=sheet.level,
        estimate=False,
        **sheet.options,
    )
    x = np.array(sheet.stations)
    values = {name: done.at(getattr(done, name), x) for name in sheet.report}
    arrivals = done.at(done.onset, x)
    return Reference(x, done.t, values, np.where(np.isnan(arrivals), np.inf, arrivals), {})


def extrapolated(sheet: InterfaceSheet, nodes: int | None = None) -> Reference:
    """Return the limit of runs on so many nodes and on half of them, with its errors.

    Parameters
    ----------
    sheet : InterfaceSheet
    nodes : int, optional
        Those of the sheet by default: a minute, or several on a busy machine.
    """
    nodes = sheet.nodes if nodes is None else nodes
    fine, middle, coarse = (sampled(sheet, nodes // parts) for parts in (1, 2, 4))
    limit, before = _limit(sheet, middle, fine), _limit(sheet, coarse, middle)
    errors = {
        name: max(off(before.values[name], one), LEAST_ERROR) for name, one in limit.values.items()
    }
    apart = np.abs(limit.arrivals - before.arrivals)
    errors[ARRIVALS] = max(float(apart[np.isfinite(apart)].max()), LEAST_ERROR)
    return replace(limit, errors=errors)


def _limit(sheet: InterfaceSheet, coarse: Reference, fine: Reference) -> Reference:
    """Return what two runs tend to; arrivals, read off within a step, do so at first order."""
    weight = 1 / (2**sheet.order - 1)
    values = {name: one + weight * (one - coarse.values[name]) for name, one in fine.values.items()}
    arrivals = fine.arrivals + (fine.arrivals - coarse.arrivals)
    return Reference(fine.x, fine.t, values, arrivals, {})


def off(values: Array, limit: Array) -> float:
    """Return the L1 difference of two fields over that of the second."""
    return float(np.abs(values - limit).sum() / np.abs(limit).sum())


def reference_of(document: Mapping[str, Any]) -> Reference:
    """Return the answer that the document of a sheet holds."""
    answers = {name: np.array(one, dtype=float) for name, one in document["answers"].items()}
    arrivals = answers.pop(ARRIVALS)
    return Reference(
        np.array(document["stations"], dtype=float),
        np.array(document["times"], dtype=float),
        answers,
        np.where(np.isnan(arrivals), np.inf, arrivals),
        document["errors"],
    )


def reference_document(sheet: InterfaceSheet) -> dict[str, Any]:
    """The sheet and its answer, computed now, as plain dictionaries, lists and numbers."""
    answer = extrapolated(sheet)
    numbers = {ARRIVALS: answer.arrivals, **answer.values}
    return {
        "sheet": sheet.name,
        "title": sheet.title,
        "units": sheet.units,
        "scene": sheet.document,
        "si_scene": None,
        "si_scales": {},
        "stations": list(sheet.stations),
        "times": [float(f"{t:.10g}") for t in sheet.times],
        "arrival": f"slip_rate above {sheet.level:g}",
        "sure": "seven digits, of which those within the stated errors are sure",
        "answers": {name: _shortened(values) for name, values in numbers.items()},
        "errors": {name: float(f"{error:.2g}") for name, error in answer.errors.items()},
    }


def _shortened(values: Array) -> Any:
    """Return values to seven digits, as nested lists; None for infinity."""
    flat = [float(f"{one:.7g}") if math.isfinite(one) else None for one in values.ravel().tolist()]
    return np.array(flat, dtype=object).reshape(values.shape).tolist()


def reference_changes(sheet: InterfaceSheet, before: Reference, nodes: int) -> Iterator[str]:
    """Yield quantities whose written values differ from the limit now by more than both errors."""
    now = extrapolated(sheet, min(nodes, sheet.nodes))
    apart = {name: off(before.values[name], values) for name, values in now.values.items()}
    apart[ARRIVALS] = float(np.nanmax(np.abs(before.arrivals - now.arrivals), initial=0.0))
    for name, far in apart.items():
        if not far <= now.errors[name] + before.errors[name]:
            yield f"{name} differs by {far:.2g}"
