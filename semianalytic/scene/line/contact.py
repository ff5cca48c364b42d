"""The parts of the line on which the bodies touch, and what holds them together there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import checking_methods, floats_of
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.checks import checked_count, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.alike import Alike
from semianalytic.scene.laws.law import not_negative, positive
from semianalytic.scene.laws.sampling import sampled

FITS = 1e-3
"""Distance of an end over the node distance that changes slip by a thousandth of one node."""


@checking_methods
@dataclass(frozen=True)
class Contact:
    """The parts of the line y = 0 on which the bodies touch; the rest is open slot.

    Parameters
    ----------
    intervals : sequence of (float, float), optional
        Beginning and end of each part [length]; the whole line by default.  An end may be infinite.

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
        ends = floats_of(self.intervals)
        if ends is None or ends.shape[1:] != (2,) or not len(ends):
            raise SceneError(
                "contact: intervals must be pairs of begin and end, such as [[-1, 1]], got "
                f"{shown(self.intervals)}."
            )
        parts = sorted(map(tuple, ends.tolist()))
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
        """Return the contact x > 0, next to a slot x < 0."""
        return cls(((0.0, math.inf),))

    @property
    def is_whole(self) -> bool:
        """Whether the bodies touch everywhere."""
        return self.intervals == ((-math.inf, math.inf),)

    def touches(self, x: ArrayLike) -> Mask:
        """Return whether the bodies touch at positions x, (n,)."""
        x = np.asarray(x, dtype=float)
        return np.any([(begin < x) & (x < end) for begin, end in self.intervals], axis=0)

    def ends(self, length: float) -> Array:
        """Return the ends of contacts within a period -length/2 ... length/2 of the line, (k,)."""
        ends = np.array(self.intervals).ravel()
        return np.asarray(ends[np.abs(ends) < length / 2])

    @property
    def ends_with_period(self) -> bool:
        """Whether the contact extends to infinity on one side only.

        The contact of a periodic line then ends where the period does.
        """
        ends = self.intervals[0][0], self.intervals[-1][1]
        return math.isinf(ends[0]) != math.isinf(ends[1])

    def narrowest(self, length: float) -> float:
        """Return the width of the narrowest contact, or slot between two, in a period [length]."""
        ends = self.ends(length)
        if not len(ends):
            return length
        # the period begins again with its first end
        return float(np.diff([*ends, ends[0] + length]).min())

    def misfit(self, length: float, nodes: int, shift: float = 0.0) -> float:
        """Return how far the grid of a period displaces the ends of contacts.

        A grid has ends midway between two of its nodes.  The result is the largest distance over
        the node distance, 0 to 1/2, on a grid that is moved by `shift` [length].
        """
        ends = (self.ends(length) - shift) / _cell(length, nodes)
        off = np.abs(ends - np.rint(ends))
        return float(np.max(np.where(off > FITS, off, 0.0), initial=0.0))

    def shift(self, length: float, nodes: int) -> float:
        """Return by how much to move a grid so that the ends are in their places [length].

        It is 0 if they fit without it, and otherwise displaces the ends least: two distances, a
        cell apart, do so, and the one returned is better on half the nodes.
        """
        if self.misfit(length, nodes) == 0:
            return 0.0
        cell = _cell(length, nodes)
        parts = np.sort(self.ends(length) / cell % 1.0)
        # On the circle of a cell, the places of ends lie best about the middle of their arc, which
        # begins behind the widest gap between them.
        gaps = np.diff([*parts, parts[0] + 1])
        widest = int(np.argmax(gaps))
        middle = float(parts[(widest + 1) % len(parts)] + (1 - gaps[widest]) / 2)
        nearest = (middle - round(middle)) * cell
        other = nearest - math.copysign(cell, nearest)
        return min(nearest, other, key=lambda shift: self.misfit(length, max(nodes // 2, 1), shift))

    def shortened(self, length: float, nodes: int, shift: float = 0.0) -> Contact:
        """Return a contact shorter by one node of a grid of half the nodes at each displaced end.

        The change of the answer measures the error due to the displaced ends, which are `misfit`
        node distances off: half that share of a node of the coarser grid.
        """
        cell = 2 * _cell(length, nodes)

        def inward(end: float, sign: int) -> float:
            # for an end at the right sign = 1, at the left -1
            place = sign * (end - shift) / cell
            if not abs(end) < length / 2 or abs(2 * place - round(2 * place)) <= FITS:
                return end
            # the last node inside lies before the end: the grid has it half a distance further on
            return sign * (math.ceil(place - 0.5) - 1) * cell + shift

        moved = ((inward(begin, -1), inward(end, 1)) for begin, end in self.intervals)
        pairs = zip(self.intervals, moved, strict=True)
        return Contact([new if new[0] < new[1] else old for old, new in pairs])

    def fitting_nodes(self, length: float, least: int, halvings: int, movable: bool = False) -> int:
        """Return the fewest nodes, up to twice `least`, on which all ends fit.

        Parameters
        ----------
        length : float
            Period of the line [length].
        least : int
            Fewest nodes of the period.
        halvings : int
            How often the number of nodes can be halved so that the ends still fit; fewer times if
            no such number is found.
        movable : bool
            Whether the grid may be moved (`shift`).  If the ends fit on no grid, a movable one has
            the number of nodes, up to one and a half times `least`, on half of which they are least
            misplaced, and any other one has `least`.
        """
        least = checked_count("contact: least", least, 1, "a whole number from")
        for times in range(min(halvings, least.bit_length()), -1, -1):
            unit = max(4, 2**times)
            for nodes in range(-(-least // unit) * unit, 2 * least + 1, unit):
                if self.misfit(length, nodes >> times) == 0:
                    return nodes
        if not movable:
            return least
        near = range(-(-least // 4) * 4, 3 * least // 2 + 1, 4)

        def misplaced(nodes: int) -> float:
            # 3 % of 400 random contacts exceed it, on 540 nodes in the median; slip of 36 runs is
            # off by 0.2 %, ends are a small part.
            return max(self.misfit(length, nodes // 2, self.shift(length, nodes)), 0.02)

        return min(near, key=misplaced)


def _cell(length: float, nodes: int) -> float:
    """Return the node distance of a grid [length]."""
    count = checked_count("contact: nodes", nodes, 1, "a whole number from")
    return (length if length == math.inf else checked_size("contact: length", length)) / count


@checking_methods
@dataclass(frozen=True, eq=False)
class Adhesion(Alike):
    """Tension that a contact carries before it opens.

    Faces that have never separated carry tension up to the strength.  Where they separate, the
    tension falls linearly with the gap and vanishes at the length; this takes strength x length / 2
    per area.  Where they approach again before, it falls in proportion to the gap.  Faces that have
    separated by the length touch without adhesion afterwards.  Under tension only cohesion resists
    slip.

    Parameters
    ----------
    strength : field
        Largest tension [stress]; a number, a function of x or a `Table`.
    length : field
        Gap at which no tension is left [length].

    Raises
    ------
    SceneError
        If the strength is negative, or the length is not positive.

    Examples
    --------
    >>> from semianalytic import Adhesion
    >>> Adhesion(strength=2.0, length=1e-3)
    Adhesion(strength=2.0, length=0.001)
    """

    strength: Any
    length: Any

    def __post_init__(self) -> None:
        not_negative("adhesion", strength=self.strength)
        positive("adhesion", length=self.length)

    def on(self, x: Array, touching: Mask) -> Adhesion:
        """Return strength and length at positions x (n,); slots have no strength."""
        strength = np.zeros(len(x))
        strength[touching] = sampled("adhesion: strength", self.strength, x[touching])
        length = np.ones(len(x))
        length[touching] = sampled("adhesion: length", self.length, x[touching])
        return Adhesion(strength, length)

    def tension(self, gap: Array, opened: Array) -> Array:
        """Return the tension at gaps (n,), the largest gaps so far being (n,) [stress]."""
        left = self.strength * np.maximum(1 - np.maximum(gap, opened) / self.length, 0.0)
        # the faces of slots, which have never parted here, may come nearer
        back = (gap < opened) & (opened > 0)
        return np.asarray(np.where(back, left * gap / opened, left))
