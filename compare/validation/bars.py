"""A judged row, and what its error bar is made of: the data, their grid, and the answer."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

from compare.comparison.rows import Row
from compare.records.record import Record
from compare.validation.exact import Exact
from compare.validation.grids import Grids, changes, grid_bar, spacing_bar, unseen_part
from compare.validation.norms import station_size, weights

ALARM = 1.5
"""Number of bars beyond which a difference counts."""
MEAN_NOISE = math.sqrt(2 / math.pi)
"""Mean absolute value of normally distributed noise over its standard deviation."""
SCATTER = 3.0
"""Standard deviations by which a mean of noise may be larger: of 750 means one is."""


@dataclass(frozen=True)
class Bar:
    """How far a record may be off, in the unit of a difference.

    The parts are bounds and not standard deviations, so that they are added up.
    """

    grid: float | None  # by the grid of the code; None where nothing is said of it
    data: float = 0.0  # by the noise of the data
    answer: float = 0.0  # by the error of the answer
    order: float | None = None  # that several grids show

    @property
    def whole(self) -> float | None:
        """All parts together; None where one is not known."""
        return None if self.grid is None else self.grid + self.data + self.answer

    def row(
        self,
        name: str,
        kind: str,
        exact: float,
        simulated: float | None,
        difference: float | None,
        **given: Any,
    ) -> JudgedRow:
        """A row with this bar and its parts."""
        given |= {"grid_bar": self.grid, "data_bar": self.data, "answer_bar": self.answer}
        numbers = (exact, exact, simulated, difference, self.whole)
        return JudgedRow(name, kind, *numbers, order=self.order, **given)


@dataclass(frozen=True)
class JudgedRow(Row):
    """A row of a validation, with the parts of its bar as in `Bar`."""

    grid_bar: float | None = None
    data_bar: float = 0.0
    answer_bar: float = 0.0
    alarm: ClassVar[float] = ALARM


def station_bar(grids: Grids, record: Record, name: str, exact: Exact, everywhere: float) -> Bar:
    """Error bar of one quantity at one station, relative as its L1 error.

    `everywhere` is the mean |quantity| of the exact answer at all stations over that at this one.
    """
    expected = exact.record(name, record.x, record.t, grids.sampling)
    weight = weights(record.t, record.values[name])
    size = station_size(expected, weight, exact.unit(name))
    total = float(weight.sum())
    answer = exact.doubt(name, record.x, record.t) * total / size
    data = grids.noise.get(name, 0.0) * noise_mean(float(weight @ weight) / total**2) * total / size
    differences = changes(grids, record, name, exact) if len(grids.runs) > 1 else []
    if differences:
        bar, order = grid_bar(grids, differences)
        return Bar(max(bar, unseen_part(grids, record, name, exact)), data, answer, order)
    return Bar(spacing_bar(grids, record, name, exact, everywhere), data, answer)


def noise_mean(share: float) -> float:
    """Largest mean of the absolute value of noise, over its standard deviation.

    The share is the sum of the squares of the weights of samples, over that of the weights squared:
    one over the number of samples that are alike.
    """
    return MEAN_NOISE + SCATTER * math.sqrt((1 - MEAN_NOISE**2) * share)


def pooled_bar(bars: Iterable[Bar], sizes: Iterable[float], whole: float) -> Bar:
    """Bar of all stations together, over the mean size of a quantity there."""
    pairs = list(zip(bars, sizes, strict=True))
    total = whole * len(pairs)

    def part(values: Iterable[float]) -> float:
        sized = zip(values, pairs, strict=True)
        return sum(value * size for value, (_, size) in sized) / total

    known = [bar.grid for bar, _ in pairs if bar.grid is not None]
    grid = part(known) if len(known) == len(pairs) else None
    orders = sorted(bar.order for bar, _ in pairs if bar.order is not None)
    order = orders[len(orders) // 2] if orders else None
    data, answer = (part(getattr(bar, name) for bar, _ in pairs) for name in ("data", "answer"))
    return Bar(grid, data, answer, order)
