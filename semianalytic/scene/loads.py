"""Load histories: the dimensionless functions f(t) that multiply a scene's loads.

A history is 0 up to t = 0.  It is kept as a sum of jumps, kinks and waves, which solvers treat
exactly where they can.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import (
    check_fields,
    checked_number,
    checked_size,
    checked_word,
    shown,
)
from semianalytic.scene.errors import SceneError
from semianalytic.scene.quantities import with_quantities

PULSE_SHAPES = ("rectangle", "triangle", "half-sine", "haversine")


class Wave(NamedTuple):
    """A wave amplitude * sin(2 pi frequency lag) from lag = t - start = 0 on.

    With `cosine` it is amplitude * (1 - cos(2 pi frequency lag)).
    """

    start: float
    amplitude: float
    frequency: float
    cosine: bool

    def value(self, t: ArrayLike) -> Array:
        """Return the wave at times t [time], any shape."""
        angle = 2 * np.pi * self.frequency * np.maximum(np.asarray(t, dtype=float) - self.start, 0)
        return self.amplitude * (1 - np.cos(angle) if self.cosine else np.sin(angle))

    def integral(self, t: ArrayLike) -> Array:
        """Return the integral from 0 to t [time], any shape."""
        lag = np.maximum(np.asarray(t, dtype=float) - self.start, 0)
        angular = 2 * np.pi * self.frequency
        angle = angular * lag
        if self.cosine:
            return self.amplitude * (lag - np.sin(angle) / angular)
        # 1 - cos(angle) without cancellation
        return self.amplitude * 2 * np.sin(angle / 2) ** 2 / angular


class Pieces(NamedTuple):
    """A history as a sum: jumps (time, height), kinks (time, change of slope), and waves."""

    jumps: tuple[tuple[float, float], ...] = ()
    kinks: tuple[tuple[float, float], ...] = ()
    waves: tuple[Wave, ...] = ()

    def value(self, t: ArrayLike) -> Array:
        """Return f(t), any shape; at a jump the value before it."""
        t = np.asarray(t, dtype=float)
        total = np.zeros(t.shape)
        for start, height in self.jumps:
            total += height * (t > start)
        for start, slope in self.kinks:
            total += slope * np.maximum(t - start, 0.0)
        for wave in self.waves:
            total += wave.value(t)
        return total

    def integral(self, t: ArrayLike) -> Array:
        """Return the integral of f from 0 to t [time], any shape."""
        t = np.asarray(t, dtype=float)
        total = np.zeros(t.shape)
        for start, height in self.jumps:
            total += height * np.maximum(t - start, 0.0)
        for start, slope in self.kinks:
            total += slope / 2 * np.maximum(t - start, 0.0) ** 2
        for wave in self.waves:
            total += wave.integral(t)
        return total

    @property
    def breaks(self) -> tuple[float, ...]:
        """Times at which f or one of its derivatives jumps, in order [time]."""
        starts = [piece[0] for piece in (*self.jumps, *self.kinks, *self.waves)]
        return tuple(sorted(set(starts)))


def check_pieces(name: str, history: LoadHistory) -> None:
    """Raise SceneError unless a history is a sum of finite pieces from t = 0 on.

    The histories of this package check their parameters; this one is for those of other packages.
    """
    pieces = history.pieces
    if not isinstance(pieces, Pieces):
        raise SceneError(f"scene: the pieces of the {name} must be a Pieces, got {shown(pieces)}.")
    for piece in (*pieces.jumps, *pieces.kinks, *pieces.waves):
        if not (np.all(np.isfinite(piece)) and piece[0] >= 0):
            raise SceneError(
                f"scene: the pieces of the {name} must be finite numbers that begin at t = 0 or "
                f"later, got {shown(tuple(piece))}."
            )


@checking_methods
class LoadHistory(ABC):
    """A load history f(t), the sum of its pieces.

    All that solvers need of a history follows from `pieces` and `turn`; a history of your own
    is a frozen dataclass that defines both.

    Examples
    --------
    >>> from semianalytic import LoadHistory, Ramp
    >>> history = Ramp(rise_time=2.0)
    >>> isinstance(history, LoadHistory)
    True
    >>> history.value([0.0, 1.0, 5.0]).tolist()
    [0.0, 0.5, 1.0]
    >>> float(history.mean(0.0, 2.0))
    0.5
    """

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        checking_methods(cls)

    @abstractmethod
    def turn(self, width: float, until: float) -> float:
        """Return how far f goes up and down again, or down and up, within a time `width`.

        The turn is relative to the largest value of f.  It is 0 where f only rises or only falls; a
        jump is no turn.  A march has to resolve turns.

        Parameters
        ----------
        width : float
            Length of the time interval [time].
        until : float
            Time up to which f matters [time].
        """

    @property
    @abstractmethod
    def pieces(self) -> Pieces:
        """The jumps, kinks and waves whose sum is f."""

    def value(self, t: ArrayLike) -> Array:
        """Return f(t) at times t [time], any shape; at a jump the value before it."""
        return self.pieces.value(t)

    def integral(self, t: ArrayLike) -> Array:
        """Return the integral of f from 0 to t [time], any shape."""
        return self.pieces.integral(t)

    def mean(self, start: ArrayLike, end: ArrayLike) -> Array:
        """Return the mean of f over intervals start < t < end [time], any shape."""
        start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        return (self.integral(end) - self.integral(start)) / (end - start)


@dataclass(frozen=True)
class Step(LoadHistory):
    """A sudden load that stays: f = H(t).

    Examples
    --------
    >>> from semianalytic import Step
    >>> Step().value([-1.0, 0.0, 1.0]).tolist()
    [0.0, 0.0, 1.0]
    """

    @cached_property
    def pieces(self) -> Pieces:
        """The jump at t = 0."""
        return Pieces(jumps=((0.0, 1.0),))

    def turn(self, width: float, until: float) -> float:
        """Return 0: a step never turns."""
        return 0.0


@with_quantities
@dataclass(frozen=True)
class Ramp(LoadHistory):
    """A load that rises linearly from 0 to 1 and then stays constant.

    Parameters
    ----------
    rise_time : float
        Time over which it rises [time]; a step if it is 0.

    Raises
    ------
    SceneError
        If the rise time is negative or not a finite number.

    Examples
    --------
    >>> from semianalytic import Ramp
    >>> Ramp(rise_time=2.0).value([0.0, 0.5, 3.0]).tolist()
    [0.0, 0.25, 1.0]
    """

    rise_time: float

    def __post_init__(self) -> None:
        least = (checked_number, "be a number, 0 or more", lambda given: given >= 0)
        check_fields(self, "ramp", ("rise_time",), *least)

    @property
    def _sudden(self) -> bool:
        """Whether the slope would overflow, so that the ramp is a step."""
        return self.rise_time == 0 or math.isinf(1 / self.rise_time)

    @cached_property
    def pieces(self) -> Pieces:
        """The kinks at both ends of the rise, or one jump where the slope would overflow."""
        if self._sudden:
            return Pieces(jumps=((0.0, 1.0),))
        slope = 1 / self.rise_time
        return Pieces(kinks=((0.0, slope), (self.rise_time, -slope)))

    def value(self, t: ArrayLike) -> Array:
        """Return f(t), any shape."""
        t = np.asarray(t, dtype=float)
        # not as a sum of pieces, which loses digits for very short ramps
        return super().value(t) if self._sudden else np.clip(t / self.rise_time, 0.0, 1.0)

    def integral(self, t: ArrayLike) -> Array:
        """Return the integral of f from 0 to t [time], any shape."""
        if self._sudden:
            return super().integral(t)
        t = np.maximum(np.asarray(t, dtype=float), 0.0)
        rising = np.minimum(t, self.rise_time)
        return rising * (rising / self.rise_time) / 2 + (t - rising)

    def turn(self, width: float, until: float) -> float:
        """Return 0: a ramp only rises."""
        return 0.0


@with_quantities
@dataclass(frozen=True)
class Pulse(LoadHistory):
    """A load that rises and falls back to 0 within a time, with largest value 1.

    Parameters
    ----------
    duration : float
        Time from its beginning to its end [time], positive.
    shape : str
        "rectangle", "triangle" (up and down evenly), "half-sine", or "haversine", (1 - cos)/2,
        which starts and ends without a kink.

    Raises
    ------
    SceneError
        If the duration is not positive or the shape is unknown.

    Examples
    --------
    >>> from semianalytic import Pulse
    >>> Pulse(duration=2.0, shape="triangle").value([0.5, 1.0, 1.5, 2.5]).tolist()
    [0.5, 1.0, 0.5, 0.0]
    """

    duration: float
    shape: str = "rectangle"

    def __post_init__(self) -> None:
        check_fields(self, "pulse", ("duration",), checked_size, "be a positive number")
        checked_word("pulse: shape", self.shape, PULSE_SHAPES)

    @cached_property
    def pieces(self) -> Pieces:
        """The jumps, kinks or waves that make up the shape."""
        end = float(self.duration)
        if self.shape == "rectangle":
            return Pieces(jumps=((0.0, 1.0), (end, -1.0)))
        if self.shape == "triangle":
            slope = 2 / end
            return Pieces(kinks=((0.0, slope), (end / 2, -2 * slope), (end, slope)))
        if self.shape == "half-sine":
            per = 0.5 / end
            # a sine that begins at the end, half a period later, cancels the first one
            return Pieces(waves=(Wave(0.0, 1.0, per, False), Wave(end, 1.0, per, False)))
        return Pieces(waves=(Wave(0.0, 0.5, 1 / end, True), Wave(end, -0.5, 1 / end, True)))

    def turn(self, width: float, until: float) -> float:
        """Return the turn around the middle; see `LoadHistory.turn`.

        A rectangle turns if it is no longer than `width`.
        """
        share = min(width / self.duration, 1.0)
        if self.shape == "rectangle":
            return float(share == 1 and self.duration < until)
        if until <= self.duration / 2:
            return 0.0
        if self.shape == "triangle":
            return share
        angle = np.pi * share
        return float(
            (1 - np.cos(angle)) / 2 if self.shape == "haversine" else 1 - np.cos(angle / 2)
        )


@with_quantities
@dataclass(frozen=True)
class Harmonic(LoadHistory):
    """A load that oscillates from t = 0 on: f = sin(2 pi frequency t).

    Parameters
    ----------
    frequency : float
        Cycles per time [1 / time], positive.

    Raises
    ------
    SceneError
        If the frequency is not positive.

    Examples
    --------
    >>> from semianalytic import Harmonic
    >>> Harmonic(frequency=0.5).value([0.0, 0.5, 1.5]).round(12).tolist()
    [0.0, 1.0, -1.0]
    """

    frequency: float

    def __post_init__(self) -> None:
        check_fields(self, "harmonic", ("frequency",), checked_size, "be a positive number")

    @cached_property
    def pieces(self) -> Pieces:
        """The sine wave from t = 0 on."""
        return Pieces(waves=(Wave(0.0, 1.0, float(self.frequency), False),))

    def turn(self, width: float, until: float) -> float:
        """Return the turn around a crest; see `LoadHistory.turn`."""
        if until * self.frequency <= 0.25:
            return 0.0
        return float(1 - np.cos(np.pi * min(width * self.frequency, 1.0)))
