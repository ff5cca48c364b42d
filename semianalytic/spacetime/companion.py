"""The companion of a march: the same on half the nodes in half the steps, for an error estimate.

It goes along some steps behind, so that little has to be stored for the comparison, and either grid
stays in the cache for a while.  Its nodes lie half-way between two of the march.
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
    """A companion on its way behind the march it follows.

    Parameters
    ----------
    walk : Walk
        Of the companion.
    leader : Walk
        Of the march.
    departure : Departure
        Until now.

    Attributes
    ----------
    departure : Departure
    stopping : bool
        Whether the step under way is the last, since the march was stopped.
    seconds : float
        That the companion has taken [s].
    """

    def __init__(self, walk: Walk, leader: Walk, departure: Departure) -> None:
        self.departure, self.stopping, self.seconds = departure, False, 0.0
        self._walk, self._leader = walk, leader
        self._rates: list[Array] = []

    def begin(self, segment: Segment) -> None:
        """Enter a segment, given as the march steps through it, which has entered it."""
        self._steps, self._segment = segment.steps, segment.coarser
        self._walk.begin(self._segment)
        self._rates = [self._paired()]
        self._look(self._rates[0])

    def follow(self) -> None:
        """Note a step of the march, and catch up now and then."""
        self._rates.append(self._paired())
        if len(self._rates) > COMPANION_LAG:
            self._catch_up()

    def end(self) -> None:
        """Leave the segment where the march leaves it."""
        self._catch_up()
        self._walk.end()
        if self._leader.record.stopped:
            self.stopping = True
            self._walk.begin(Segment(self._walk.state.time, self._leader.state.time, 1))
            self._walk.step()
            self._add(self._rates[-1])
            self._walk.end()

    def _catch_up(self) -> None:
        """Step on as far as the march is; if it was stopped, not quite."""
        began = time.perf_counter()
        done, whole = self._leader.done, self._segment.steps
        reached = done * whole - self._leader.record.stopped
        first = done - len(self._rates) + 1
        while (level := (self._walk.done + 1) * self._steps) <= reached:
            self._walk.step()
            after, share = -(-level // whole), (-level % whole) / whole
            rate = self._rates[after - first]
            if share:
                rate = (1 - share) * rate + share * self._rates[after - first - 1]
            self._add(rate)
        self._rates = self._rates[-1:]
        self.seconds += time.perf_counter() - began

    def _add(self, rate: Array) -> None:
        """Add a step of the companion, given the slip rate of the march where it ends."""
        difference, slip_rate = self._difference, self._slip_rate
        self._look(rate)
        half = self._walk.grid.spacing * (self._walk.state.time - self._walk.before.time) / 2
        self.departure = Departure(
            self.departure.difference + half * (difference + self._difference),
            self.departure.slip_rate + half * (slip_rate + self._slip_rate),
        )

    def _look(self, rate: Array) -> None:
        """Sums over nodes of |V - V of the companion| and |V|, given the slip rate of the march."""
        own = self._walk.grid.observe(self._walk.state.rate)
        self._difference = float(np.abs(rate - own).sum())
        self._slip_rate = float(np.abs(rate).sum())

    def _paired(self) -> Array:
        """Slip rate of the march at the nodes of the companion, half-way between two of its own."""
        leader = self._leader
        contact = leader.state.rate[leader.grid.contact][: 2 * self._walk.grid.observed]
        return np.asarray((contact[::2] + contact[1::2]) / 2)
