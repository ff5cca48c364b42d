"""The parts of the line on which the bodies touch, and the mean of a traction near their ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.tuning import AREA
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Contact:
    """The parts of the line y = 0 on which the bodies touch; the rest is open slot.

    Parameters
    ----------
    intervals : sequence of (float, float), optional
        Begin and end of each part [length]; the whole line by default.  An end may be infinite.

    Raises
    ------
    SceneError
        If an interval is empty, or two overlap.

    Examples
    --------
    >>> from semianalytic import Contact
    >>> Contact([(-1.0, 1.0)]).touches([-2.0, 0.5]).tolist()
    [False, True]
    >>> Contact.half_line().touches([-0.5, 0.5]).tolist()
    [False, True]
    """

    intervals: Sequence[tuple[float, float]] = ((-math.inf, math.inf),)

    def __post_init__(self) -> None:
        try:
            parts = sorted((float(begin), float(end)) for begin, end in self.intervals)
        except (TypeError, ValueError):
            parts = []
        if not parts:
            raise SceneError(
                "contact: intervals must be pairs of begin and end, such as [[-1, 1]], got "
                f"{shown(self.intervals)}."
            )
        for begin, end in parts:
            if not begin < end:
                raise SceneError(
                    f"contact: {begin:g} to {end:g} is empty; begin must be below end."
                )
        for (_, end), (begin, _) in pairwise(parts):
            if begin <= end:
                raise SceneError(
                    f"contact: two intervals overlap or meet at x = {begin:g}; join them."
                )
        object.__setattr__(self, "intervals", tuple(parts))

    @classmethod
    def half_line(cls) -> Contact:
        """Return the contact x > 0, beside a slot x < 0."""
        return cls(((0.0, math.inf),))

    @property
    def is_whole(self) -> bool:
        """Whether the bodies touch everywhere."""
        return self.intervals == ((-math.inf, math.inf),)

    def touches(self, x: Sequence[float] | Array) -> NDArray[np.bool_]:
        """Return whether the bodies touch at positions x, (n,)."""
        x = np.asarray(x, dtype=float)
        return np.any([(begin < x) & (x < end) for begin, end in self.intervals], axis=0)


def area_mean(excess: Array, inner: NDArray[np.bool_]) -> Array:
    """Return the mean of the positive part of the excess of traction over strength around nodes.

    A node stands for a stretch of the line on which the excess is linear.  Without the mean, the
    end of a slip zone crosses nodes one by one and radiates waves three nodes long.

    Parameters
    ----------
    excess : (n,) array
        Traction of nodes at rest, less their strength [stress].
    inner : (n,) array of bool
        Whether a node has neighbours of the same contact on both sides.
    """
    left, right = np.roll(excess, 1), np.roll(excess, -1)
    # Where strength or load jumps, the two one-sided slopes differ: the smaller one counts.
    even = np.minimum(np.abs(right - excess), np.abs(excess - left))
    reach = AREA * np.minimum(np.abs(right - left) / 4, even)
    # Beside a stuck edge the excess is singular but of one sign: there the mean must not slip.
    ends = np.minimum(np.minimum(left, right), excess) < 0
    ends &= np.maximum(np.maximum(left, right), excess) > 0
    mixed = inner & ends & (np.abs(excess) < reach)
    safe = np.where(mixed, reach, 1.0)
    return np.where(mixed, (excess + reach) ** 2 / (4 * safe), excess)
