"""What a reading leaves of each quantity of a file, relative to the exact answer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from compare.records.record import QUANTITIES, Array, Records
from compare.validation.exact import Exact
from compare.validation.norms import weights
from compare.validation.readings import Conversion

LITTLE = 0.25
"""Relative error of a quantity above which a reading does not explain it.

Right runs of UGUCA and SEM2DPACK on 40 to 200 cells leave up to 0.16, and readings differ by a
sense or a factor of two, so that a wrong one leaves 0.47 at least.  With half of it coarse runs are
not read; with twice of it a factor of two passes."""
TELLING = 1e-5
"""Mean of a quantity over its unit below which the answer says nothing of its sense or size."""


@dataclass(frozen=True, eq=False)
class WeighedColumn:
    """One quantity at all stations that waves reach, in order.

    Attributes
    ----------
    values, weight, expected : ndarray, shape (n,)
        Numbers of the file, zero in gaps; weights of samples, zero in gaps; exact values.
    unit : float
        That of the quantity, as in `Exact.unit`.
    """

    values: Array
    weight: Array
    expected: Array
    unit: float

    def tells(self, base: float = 0.0) -> bool:
        """Whether the answer has something to say of the quantity, besides its base."""
        return self._size(base) > TELLING * self.unit * float(self.weight.sum())

    def left(self, factor: float, base: float = 0.0) -> float:
        """Relative error of numbers times a factor plus a base, of what changes from the base.

        Where nothing does, over the quantity with its base, or over its unit.
        """
        size = self._size(base)
        if not self.tells(base):
            size = max(self._size(0.0), self.unit * float(self.weight.sum()))
        return float(self.weight @ np.abs(factor * self.values + base - self.expected)) / size

    def ratio(self, factor: float, base: float) -> float:
        """Size of the numbers as they are read over that of the exact ones, which is not zero."""
        return float(self.weight @ np.abs(factor * self.values + base)) / self._size(0.0)

    def _size(self, base: float) -> float:
        return float(self.weight @ np.abs(self.expected - base))


Columns = Mapping[str, WeighedColumn]


def columns_of(sample: Records, exact: Exact, reading: Conversion) -> dict[str, WeighedColumn]:
    """The quantities of a file, whose positions and times are read by a reading."""
    columns = {}
    for name in QUANTITIES:
        parts = list(_parts(sample, name, exact, reading))
        if parts:
            values, weight, expected = map(np.concatenate, zip(*parts, strict=True))
            columns[name] = WeighedColumn(values, weight, expected, exact.unit(name))
    return columns


def _parts(
    sample: Records, name: str, exact: Exact, reading: Conversion
) -> Iterator[tuple[Array, Array, Array]]:
    for record in sample.stations:
        values = record.values.get(name)
        x, t = reading.place(record), reading.times(record)
        if values is None or x > exact.scene.material.longitudinal_speed * t[-1]:
            continue
        weight = weights(t, values)
        if weight.any():
            yield np.where(weight > 0, values, 0.0), weight, exact.record(name, x, t)


def left_by(reading: Conversion, columns: Columns) -> dict[str, float]:
    """Relative error of each quantity by a reading."""
    return {
        name: column.left(reading.factor(name), reading.offset(name))
        for name, column in columns.items()
    }
