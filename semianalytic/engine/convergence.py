"""The error of a march, estimated from its difference from one on half the nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

ERROR_SAFETY = 1.25
"""Estimate over the difference from half the nodes: errors are 0.35 to 1.05 of it in 100 scenes."""
NARROW_SAFETY, WIDE_SAFETY = 1.5, 0.9
"""The same of slip along a line: errors are up to 1.1 and 0.75 of it in 103 random scenes."""
NARROW = 5
"""Nodes of the coarser grid below which a slip zone is narrow."""
MEMORY_SAFETY = 4.0
"""Factor on the error of the memory's transform: at 1e-4 the slip rate is off by 3.5 times that."""


@dataclass(frozen=True)
class Departure:
    """The difference between a march and its companion, over the observed contact and time.

    Attributes
    ----------
    difference, slip_rate : float
        Integrals of |V - V of the companion| and of |V| [length^2].
    """

    difference: float = 0.0
    slip_rate: float = 0.0

    @property
    def share(self) -> float:
        """Difference relative to the slip rate, nan where nothing slips."""
        return self.difference / self.slip_rate if self.slip_rate else math.nan


@dataclass(frozen=True)
class Tried:
    """A march of some nodes, by how far half as many are from it.

    Attributes
    ----------
    nodes : int
        Its number of nodes.
    share : float
        Difference from half the nodes, relative to the quantity itself; nan where that is 0.
    """

    nodes: int
    share: float


def safety(order: float | None, narrow: bool | None = None) -> float:
    """Return the estimate over the difference from half the nodes, for an order if one was seen.

    Slip and slip rate along a line have factors of their own, of zones that are `narrow` or not.
    """
    most = {None: ERROR_SAFETY, True: NARROW_SAFETY, False: WIDE_SAFETY}[narrow]
    if order is None:
        return most
    # difference = (2^order - 1) error, if errors fall as nodes^-order
    # With 1.3 estimates are 1.25 to 4.2 times the errors of 50 scenes, with 1.0 at least 0.97
    # times.  Higher orders are not believed: at 1.3 to 1.6 errors are half the difference.
    return min(most, 1.3 / (2 ** min(order, 1.6) - 1))


def order_seen(coarse: Tried, fine: Tried) -> float | None:
    """Return the order at which two marches approach those of half their nodes, or None.

    It is None where one of them saw nothing.
    """
    if not (coarse.share > 0 and fine.share > 0):
        return None
    growth = math.log(fine.nodes / coarse.nodes)
    # Orders of 0.7 to 1.4 are measured.
    return float(np.clip(math.log(coarse.share / fine.share) / growth, 0.5, 2.0))


def more_nodes(nodes: int, estimate: float, rtol: float, order: float | None, most: int) -> int:
    """Return how many nodes to try next, up to `most`, where an estimate is above `rtol`.

    Until two marches are known, first order is assumed, that of slip rate at edges.
    """
    # Error ~ nodes^-order: the nodes that bring the estimate to rtol / 1.3.  With 1.15 a march that
    # lacks a tenth is repeated: six scenes to 3e-3 and 1e-3 take 20 s in all, with 1.3 14 s.
    growth = (1.3 * estimate / rtol) ** (1 / (order or 1.0))
    # The order is not known before the second march; one at a quarter of the nodes costs a
    # sixteenth.
    growth = float(np.clip(growth, 1.3, 4.0))
    return min(most, math.ceil(growth * nodes))
