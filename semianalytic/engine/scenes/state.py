"""The state of a march at one time, and what it remembers of all steps until then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.scenes.nodes import Grid
from semianalytic.results.sampled import ONSET_SHARE

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MarchState:
    """The state of a march at one time, from which it can be continued.

    Attributes
    ----------
    time : float
        Time reached [time].
    modes : (poles, size) complex array
        Memory of past slip, per pole and cosine [length / time].
    lasting : (size,) array
        Static part of the memory, per cosine [length / time].
    rate : (size,) array
        Relative slip rate, slot included [length / time].
    traction : (size - slot,) array
        Shear traction of the contact [stress].
    slip, path : (size - slot,) arrays
        Slip and accumulated |slip| on the contact [length].
    work : (size - slot,) array
        Frictional work per area of the contact [stress length].
    """

    time: float
    modes: NDArray[np.complex128]
    lasting: Array
    rate: Array
    traction: Array
    slip: Array
    path: Array
    work: Array

    @classmethod
    def at_rest(cls, poles: int, grid: Grid, time: float = 0.0) -> MarchState:
        """Return the state before anything happens, at a time, for so many poles."""
        lasting, contact = np.zeros(grid.size), np.zeros(grid.size - grid.slot)
        modes = np.zeros((poles, grid.size), dtype=complex)
        return cls(time, modes, lasting, lasting, contact, contact, contact, contact)


@dataclass(frozen=True, eq=False)
class Extremes:
    """Extremes over every step of a march, stored or not, at the observed nodes.

    Attributes
    ----------
    forward, reverse : (n,) arrays
        Largest slip rate so far, at least 0, and least one, at most 0 [length / time].
    slip : (n,) array
        Largest |slip| so far [length].
    onset : (n,) array
        Time at which slip began [time], inf where it did not: |V| passed 1 % of the largest |V|
        anywhere until then, interpolated linearly between the two levels around that time.
    """

    forward: Array
    reverse: Array
    slip: Array
    onset: Array

    @classmethod
    def at_rest(cls, nodes: int) -> Extremes:
        """Return the extremes at so many nodes before anything happens."""
        rest = np.zeros(nodes)
        return cls(rest, rest, rest, np.full(nodes, np.inf))

    @property
    def slip_rate(self) -> Array:
        """Largest |slip rate| (n,) [length / time]."""
        return np.maximum(self.forward, np.abs(self.reverse))

    def with_levels(self, times: Sequence[float], rates: Array, slips: Array) -> Extremes:
        """Return the extremes with k more levels included.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        rates : (k + 1, n) array
            Slip rates at these [length / time].
        slips : (k, n) array
            Slip at the levels [length].
        """
        forward = np.maximum(self.forward, rates[1:].max(axis=0))
        reverse = np.minimum(self.reverse, rates[1:].min(axis=0))
        slip = np.maximum(self.slip, np.maximum(slips.max(axis=0), -slips.min(axis=0)))
        waiting = np.flatnonzero(np.isinf(self.onset))
        if not len(waiting):
            return Extremes(forward, reverse, slip, self.onset)
        # The threshold of a level uses only what was until then, so that a march that is continued
        # finds the same onsets.
        speeds = np.abs(rates)
        until = np.maximum.accumulate(speeds[1:].max(axis=1))
        threshold = ONSET_SHARE * np.maximum(until, float(self.slip_rate.max()))
        begins = speeds[1:, waiting] > threshold[:, None]
        first = np.argmax(begins, axis=0)
        began = np.flatnonzero(begins[first, np.arange(len(waiting))])
        if not len(began):
            return Extremes(forward, reverse, slip, self.onset)
        level, node, t = first[began], waiting[began], np.asarray(times)
        late, speed = speeds[level, node], speeds[level + 1, node]
        # |V| is linear between the two levels; after a jump, where they are one, onset is now
        rise = np.where(speed > late, speed - late, 1.0)
        share = np.where(speed > late, (threshold[level] - late) / rise, 0.0)
        onset = self.onset.copy()
        onset[node] = t[level] + (t[level + 1] - t[level]) * np.clip(share, 0.0, 1.0)
        return Extremes(forward, reverse, slip, onset)


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
