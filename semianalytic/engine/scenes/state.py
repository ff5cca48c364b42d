"""What a march remembers of all steps until a time, and its cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.state import onsets_until
from semianalytic.results.questions import ONSET_SHARE

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Extremes:
    """Extremes over every step of a march, stored or not, at the observed nodes.

    Attributes
    ----------
    forward, reverse : (n,) arrays
        Largest slip rate so far, at least 0, and least one, at most 0 [length / time].
    onset : (n,) array
        Time at which slip began [time], inf where it did not: |V| passed 1 % of the largest |V|
        anywhere until then, interpolated linearly between the two levels around that time.
    """

    forward: Array
    reverse: Array
    onset: Array

    @classmethod
    def at_rest(cls, nodes: int) -> Extremes:
        """Return the extremes at so many nodes before anything happens."""
        rest = np.zeros(nodes)
        return cls(rest, rest, np.full(nodes, np.inf))

    @property
    def slip_rate(self) -> Array:
        """Largest |slip rate| (n,) [length / time]."""
        return np.maximum(self.forward, np.abs(self.reverse))

    def with_levels(self, times: Sequence[float], rates: Array) -> Extremes:
        """Return the extremes with k more levels included.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        rates : (k + 1, n) array
            Slip rates at these [length / time].
        """
        forward = np.maximum(self.forward, rates[1:].max(axis=0))
        reverse = np.minimum(self.reverse, rates[1:].min(axis=0))
        # The threshold of a level uses only what was until then, so that a march that is continued
        # finds the same onsets.
        speeds = np.abs(rates)
        until = np.maximum.accumulate(speeds[1:].max(axis=1))
        threshold = ONSET_SHARE * np.maximum(until, float(self.slip_rate.max()))
        return Extremes(forward, reverse, onsets_until(self.onset, times, speeds, threshold))


@dataclass(frozen=True)
class MarchStatistics:
    """The cost of a march.

    Attributes
    ----------
    steps : int
        Number of time steps.
    nodes : int
        Number of nodes of the whole grid.
    poles : int
        Number of exponentials that carry the memory.
    memory_error : float
        Relative error of their transform.
    seconds : dict
        Seconds by stage: "setup" and "steps".
    """

    steps: int
    nodes: int
    poles: int
    memory_error: float
    seconds: dict[str, float]
