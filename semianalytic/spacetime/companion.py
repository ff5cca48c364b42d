"""The companion of a march: the same march on half the nodes in half the steps.

The difference between the two gives the error estimate (docs/spacetime.md, "Error of a march").
The companion follows some steps behind: little has to be stored for the comparison, and either grid
stays in the processor cache for a while.  Each of its nodes lies half-way between two nodes of the
march.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from semianalytic.spacetime.marched import Departure
from semianalytic.spacetime.stepping import Segment, Walk
from semianalytic.spacetime.tuning import COMPANION_LAG

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
        self._rates: list[Array] = []

    def begin(self, segment: Segment) -> None:
        """Enter a segment of the march, after the march has entered it."""
        self._steps, self._segment = segment.steps, segment.coarser
        self._walk.begin(self._segment)
        self._rates = [self._paired()]
        self._look(self._rates[0])

    def follow(self) -> None:
        """Note a step of the march, and catch up with it every `COMPANION_LAG` steps."""
        self._rates.append(self._paired())
        if len(self._rates) > COMPANION_LAG:
            self._catch_up()

    def end(self) -> None:
        """Leave the segment where the march leaves it."""
        self._catch_up()
        self._walk.end()
        if self._leader.record.stopped:
            # the march may have stopped between two levels of the companion: one step of its own
            # length brings the companion to the same time
            self.stopping = True
            self._walk.begin(Segment(self._walk.state.time, self._leader.state.time, 1))
            self._walk.step()
            self._add(self._rates[-1])
            self._walk.end()

    def _catch_up(self) -> None:
        """Step on to the time of the march; if the march was stopped, to a level before it."""
        began = time.perf_counter()
        done, whole = self._leader.done, self._segment.steps
        # Times are compared as whole numbers: level i of n steps of the march and level j of m
        # steps of the companion are at i m and j n.
        reached = done * whole - self._leader.record.stopped
        first = done - len(self._rates) + 1
        while (level := (self._walk.done + 1) * self._steps) <= reached:
            self._walk.step()
            # the level of the march at or after this one, and the share of the level before it
            after, share = -(-level // whole), (-level % whole) / whole
            rate = self._rates[after - first]
            if share:
                rate = (1 - share) * rate + share * self._rates[after - first - 1]
            self._add(rate)
        self._rates = self._rates[-1:]
        self.seconds += time.perf_counter() - began

    def _add(self, rate: Array) -> None:
        """Add a step of the companion, by the trapezoidal rule.

        `rate` is the slip rate of the march at the end of the step, at the companion's nodes.
        """
        difference, slip_rate = self._difference, self._slip_rate
        self._look(rate)
        half = self._walk.grid.spacing * (self._walk.state.time - self._walk.before.time) / 2
        self.departure = Departure(
            self.departure.difference + half * (difference + self._difference),
            self.departure.slip_rate + half * (slip_rate + self._slip_rate),
        )

    def _look(self, rate: Array) -> None:
        """Sum |V - V of the companion| and |V| over the nodes, given V, that of the march."""
        own = self._walk.grid.observe(self._walk.state.rate)
        self._difference = float(np.abs(rate - own).sum())
        self._slip_rate = float(np.abs(rate).sum())

    def _paired(self) -> Array:
        """Return the slip rate of the march at the nodes of the companion."""
        leader = self._leader
        # companion node i at (i + 1/2) 2h lies half-way between nodes 2i and 2i + 1 of the march
        contact = leader.state.rate[leader.grid.contact][: 2 * self._walk.grid.observed]
        return np.asarray((contact[::2] + contact[1::2]) / 2)
