"""The error of a march, estimated from its difference from one on half the nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

SAFETY = {"slot": (1.25, 1.05), "line": (1.25, 1.3), "narrow": (1.5, 1.3), "wide": (0.9, 1.3)}
"""Largest estimate over the difference from half the nodes, and estimate over the error that an
observed order shows: of slip rate beside a slot, along a line, and of slip and its rate there where
zones have few nodes or ends of contacts are displaced, and elsewhere.  Errors are 0.35 to 1.05 of
the former beside 100 slots, up to 1.1 and 0.75 in 103 narrow and wide scenes; with 1.05 estimates
are 1.06 to 4 times the errors beside 64 slots."""
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


def safety(order: float | None, of: str) -> float:
    """Return the estimate over the difference from half the nodes, for an order if one was seen."""
    most, share = SAFETY[of]
    # difference = (2^order - 1) error, if errors fall as nodes^-order
    # Higher orders are not believed: at 1.3 to 1.6 errors are half the difference.
    return most if order is None else min(most, share / (2 ** min(order, 1.6) - 1))


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

    Until two marches are known, a usual order is assumed: with 1.0 a tenth of 64 scenes ends at an
    estimate of less than a third of `rtol`, with 1.3 half as many, in the same time.
    """
    # Orders of 1.0 to 1.2 fall to 0.8 to 0.95 between 1,000 and 2,800 nodes, where fronts remain of
    # the error, and the share of the error in a difference with them (`safety`).
    order = order or 1.3
    slope = min(order, max(0.95, order - 0.4 * (1.35 - order)))
    # Error ~ nodes^-slope: the nodes that bring the estimate to rtol / 1.15.  With 1.3, and 1.3 as
    # the least growth, 64 scenes take 1.1 times as long.
    wanted = 1.15 * estimate / rtol * (2**order - 1) / (2**slope - 1)
    # The order is not known before the second march; one at a quarter of the nodes costs a
    # sixteenth.
    return min(most, math.ceil(nodes * float(np.clip(wanted ** (1 / slope), 1.15, 4.0))))
