"""The companion of a march: the same march on half the nodes in half the steps.

The difference between the two gives the error estimate (docs/spacetime.md, "Error of a march").
The companion follows a block of steps behind: little has to be stored for the comparison, and
either grid stays in the processor cache for a while.  Each of its nodes lies half-way between two
nodes of the march.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from semianalytic.spacetime.marched import Departure
from semianalytic.spacetime.stepping import Segment, Walk

Array = NDArray[np.float64]


class Follower:
    """A companion under way, behind the march it follows.

    Parameters
    ----------
    walk : Walk
        The steps of the companion.
    leader : Walk
        The steps of the march.
    departure : Departure
        Difference between the two until now.

    Attributes
    ----------
    departure : Departure
        Difference between the two, updated with each step of the companion.
    stopping : bool
        Whether the step under way is the last, because the march was stopped.
    seconds : float
        Time that the companion has taken [s].
    """

    def __init__(self, walk: Walk, leader: Walk, departure: Departure) -> None:
        self.departure, self.stopping, self.seconds = departure, False, 0.0
        self._walk, self._leader = walk, leader

    def begin(self, segment: Segment) -> None:
        """Enter a segment of the march, after the march has entered it."""
        self._steps, self._segment = segment.steps, segment.coarser
        self._walk.begin(self._segment)
        self._rates = self._paired(self._leader.rates)
        self._difference, self._slip_rate = self._look(self._rates, self._walk.rates)

    def follow(self) -> None:
        """Catch up with a block of steps of the march; if it was stopped, to a level before."""
        began = time.perf_counter()
        done, whole = self._leader.done, self._segment.steps
        self._rates = np.concatenate([self._rates[-1:], self._paired(self._leader.rates[1:])])
        # Times are compared as whole numbers: level i of n steps of the march and level j of m
        # steps of the companion are at i m and j n.
        reached = (done * whole - self._leader.record.stopped) // self._steps
        first = done - len(self._rates) + 1
        while self._walk.done < reached:
            before = self._walk.done
            self._walk.advance(reached - before)
            levels = self._steps * np.arange(before + 1, self._walk.done + 1)
            # the level of the march at or after each, and the share of the level before it
            after, share = -(-levels // whole) - first, (-levels % whole)[:, None] / whole
            rates = self._rates[after]
            if share.any():
                rates = (1 - share) * rates + share * self._rates[np.maximum(after - 1, 0)]
            self._add(rates)
        self.seconds += time.perf_counter() - began

    def end(self) -> None:
        """Leave the segment where the march leaves it."""
        self._walk.end()
        if self._leader.record.stopped:
            # the march may have stopped between two levels of the companion: one step of its own
            # length brings the companion to the same time
            self.stopping = True
            self._walk.begin(Segment(self._walk.time, self._leader.time, 1))
            self._walk.advance(1)
            self._add(self._paired(self._leader.rates[-1:]))
            self._walk.end()

    def _add(self, rates: Array) -> None:
        """Add the last steps of the companion, by the trapezoidal rule.

        `rates` (k, n) are the slip rates of the march at their ends, at the companion's nodes.
        """
        differences, slip_rates = self._look(rates, self._walk.rates[1:])
        half = self._walk.grid.spacing * self._walk.time_step / 2
        self.departure = Departure(
            self.departure.difference + half * _ends(self._difference, differences),
            self.departure.slip_rate + half * _ends(self._slip_rate, slip_rates),
        )
        self._difference, self._slip_rate = differences, slip_rates

    def _look(self, rates: Array, own: Array) -> tuple[Array, Array]:
        """Sum |V - V of the companion| and |V| over the nodes, given V of the march, (k, n)."""
        own = self._walk.grid.observe(own)
        return np.abs(rates - own).sum(axis=1), np.abs(rates).sum(axis=1)

    def _paired(self, rates: Array) -> Array:
        """Return slip rates of the march (k, size) at the nodes of the companion, (k, n)."""
        # companion node i at (i + 1/2) 2h lies half-way between nodes 2i and 2i + 1 of the march
        slot = self._leader.grid.slot
        contact = rates[:, slot : slot + 2 * self._walk.grid.observed]
        return np.asarray((contact[:, ::2] + contact[:, 1::2]) / 2)


def _ends(before: Array, now: Array) -> float:
    """Return the sum over steps of the values at both their ends.

    `now` holds the values at the ends of the steps, `before` ends with that at the start of the
    first one.
    """
    return float(before[-1] + 2 * now[:-1].sum() + now[-1])
