"""Rows of the two tables of the trials: judgements of right answers, and of spoilt ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

from compare.comparison.rows import ALARM, UNRESOLVED


@dataclass(frozen=True)
class JudgedRow:
    """A row of a judgement of the right answer, of a random scene.

    Attributes
    ----------
    group : str, kind of the draw, or the named scene that a map is around
    index : int, which seeds the draw, or is the place on the map
    of : int, rows of the scene, all of which have to be there
    refusals : int, draws before it that had no answer
    resolution : int, of the mesh that was chosen
    whole : bool, whether field snapshots were judged too
    seconds : what the scene took [s]
    judgement : verdict on the scene
    name, kind, unit : as in the judgement
    exact, difference, bar : nan where there is none
    relative : bool, whether the last two are over the norm of the prediction
    verdict : "agrees", "differs" or "unresolved"
    """

    group: str
    index: int
    of: int
    refusals: int
    resolution: int
    whole: bool
    seconds: float
    judgement: str
    name: str
    kind: str
    unit: str
    exact: float
    difference: float
    bar: float
    relative: bool
    verdict: str

    @property
    def share(self) -> float:
        """The bar over what is compared; nan where that is nothing or has no value of its own."""
        if self.relative:
            return self.bar
        return self.bar / abs(self.exact) if self.exact else math.nan

    @property
    def tells(self) -> bool:
        """Whether the row is held against its bar: it has one, and no obstacle."""
        barred = math.isfinite(self.difference) and math.isfinite(self.bar)
        return barred and (self.verdict != UNRESOLVED or 1 < self.over_bar <= ALARM)

    @property
    def over_bar(self) -> float:
        """|difference| over the bar; 0 of nothing."""
        if not self.difference:
            return 0.0
        return abs(self.difference) / self.bar if self.bar else math.inf


@dataclass(frozen=True)
class SpoiltRow:
    """A judgement of a spoilt answer.

    Attributes
    ----------
    scene : str
    index : int
    of : int, rows of the scene
    spoil : str, or "none" for the right answer
    share : float, of the usual size of the mistake
    slip_rate, shear_traction : relative L1 effect on either, over x and t
    over_bar : float, effect read at the nodes over the bar of the row, where that is most
    verdict : str
    by : str, kinds of the rows that differ
    """

    scene: str
    index: int
    of: int
    spoil: str
    share: float
    slip_rate: float
    shear_traction: float
    over_bar: float
    verdict: str
    by: str
