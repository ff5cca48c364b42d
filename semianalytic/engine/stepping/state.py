"""The state of an interface at one time, and extremes until then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from semianalytic.engine.stepping.unilateral import Faces
from semianalytic.results.questions import ONSET_SHARE, onsets_until
from semianalytic.scene.arrays import Array


@dataclass(frozen=True, eq=False)
class State(Faces):
    """The state of an interface at one time, from which the next step starts; arrays are (n,).

    Beside a slot all but the slip rate are those of its contact.

    Attributes
    ----------
    time : float
        Time [time].
    rate, slip, traction : array
        Slip rate [length / time], slip [length] and shear traction [stress].
    state : array
        State of friction at nodes of the contact, (contact,).
    felt : array
        Pressure that friction follows there, (contact,) [stress].
    work : array
        Work of friction there so far, (contact,) [stress length].
    rung : int
        Rung of the ladder of the last step.
    pace : float
        Change of slip rate in the last step, over the largest rate and the step [1 / time].
    """

    time: float
    rate: Array
    slip: Array
    traction: Array
    state: Array
    felt: Array
    work: Array
    rung: int = 0
    pace: float = 0.0


@dataclass(frozen=True, eq=False)
class Extremes:
    """Extremes over every step of a march, stored or not, at the observed nodes.

    Attributes
    ----------
    forward, reverse : (n,) arrays
        Largest slip rate so far, at least 0, and least one, at most 0 [length / time].
    path : (n,) array
        Accumulated |slip| [length].
    onset : (n,) array
        Time at which slip began [time], inf where it did not: |V| passed the threshold,
        interpolated linearly between the two levels around that time.
    slipping : float, optional
        The threshold [length / time]; by default it is 1 % of the largest |V| until then.
    """

    forward: Array
    reverse: Array
    path: Array
    onset: Array
    slipping: float | None = None

    @classmethod
    def none(cls, nodes: int, slipping: float | None = None) -> Extremes:
        """Return those of so many nodes at rest."""
        forward, reverse, path = np.zeros((3, nodes))
        return cls(forward, reverse, path, np.full(nodes, np.inf), slipping)

    @property
    def slip_rate(self) -> Array:
        """Largest |slip rate| (n,) [length / time]."""
        return np.maximum(self.forward, np.abs(self.reverse))

    def with_levels(
        self, times: Sequence[float], rates: Array, speeds: Array, path: Array
    ) -> Extremes:
        """Return the extremes with k more levels included.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        rates, speeds : (k + 1, n) arrays
            Slip rates at these, and their sizes [length / time].
        path : (n,) array
            Accumulated |slip| with these levels [length].
        """
        forward = np.maximum(self.forward, rates[1:].max(axis=0))
        reverse = np.minimum(self.reverse, rates[1:].min(axis=0))
        threshold = np.full(len(rates) - 1, self.slipping)
        if self.slipping is None:
            # The threshold of a level uses only what was until then, so that a march that is
            # continued finds the same onsets.
            until = np.maximum.accumulate(speeds[1:].max(axis=1))
            threshold = ONSET_SHARE * np.maximum(until, float(self.slip_rate.max()))
        onset = onsets_until(self.onset, times, speeds, threshold)
        return Extremes(forward, reverse, path, onset, self.slipping)
