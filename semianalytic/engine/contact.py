"""The parts of the line on which the bodies touch, and contact that opens and closes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.fields import sampled
from semianalytic.engine.law import not_negative, positive
from semianalytic.engine.line import Grid, LineMemory
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]

FITS = 1e-3
"""Distance of an end from its place, over the node distance, that counts as none: it changes slip
by a thousandth of what one node more or less does.  Half and twice the value choose the same nodes
for ends that are given by three digits."""


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

    def ends(self, length: float) -> Array:
        """Return the ends of contacts within a period -length/2 ... length/2 of the line, (k,)."""
        ends = np.array(self.intervals).ravel()
        return np.asarray(ends[np.abs(ends) < length / 2])

    def misfit(self, length: float, nodes: int) -> float:
        """Return how far the grid of a period has an end of a contact from its place.

        A grid knows ends midway between two of its nodes.  The result is the largest distance over
        the node distance, 0 to 1/2.
        """
        ends = self.ends(length) * nodes / length
        off = np.abs(ends - np.rint(ends))
        return float(np.max(np.where(off > FITS, off, 0.0), initial=0.0))

    def shortened(self, length: float, nodes: int) -> Contact:
        """Return a contact that half the nodes see shorter, where a grid displaces its ends.

        A grid of half the nodes may have an end at the same wrong place as the grid itself; then
        the difference between the two says nothing about it.  Such ends are moved to the next
        place inward that only the coarser grid knows, by at least a node distance of the finer one.
        """
        spacing = length / nodes

        def inward(end: float, sign: int) -> float:
            # for an end at the right sign = 1, at the left -1
            place = sign * end / spacing
            if not abs(end) < length / 2 or abs(place - round(place)) <= FITS:
                return end
            # the last node inside lies before the end: the grid has it half a distance further on
            seen = math.ceil(place - 0.5)
            return sign * 2 * math.floor((seen - 1) / 2) * spacing

        moved = ((inward(begin, -1), inward(end, 1)) for begin, end in self.intervals)
        pairs = zip(self.intervals, moved, strict=True)
        return Contact([new if new[0] < new[1] else old for old, new in pairs])

    def fitting_nodes(self, length: float, least: int, halvings: int) -> int:
        """Return the fewest nodes, up to twice `least`, on which all ends fit; `least` if none do.

        Parameters
        ----------
        length : float
            Period of the line [length].
        least : int
            Fewest nodes of the period.
        halvings : int
            How often the number of nodes should be halved with ends that still fit; if none such
            is found, fewer times.
        """
        for times in range(halvings, -1, -1):
            unit = max(4, 2**times)
            for nodes in range(-(-least // unit) * unit, 2 * least + 1, unit):
                if self.misfit(length, nodes >> times) == 0:
                    return nodes
        return least


@dataclass(frozen=True, eq=False)
class Adhesion:
    """Tension that a contact carries before it opens.

    Faces that touch and have never parted carry tension up to the strength.  Where they part, the
    tension falls linearly to 0 over the length; it takes strength x length / 2 per area to part
    them.  Where they come together before, it falls in proportion to the gap.  What has parted by
    the length touches like any other contact.  Friction acts where the faces touch, with no less
    than no pressure: under tension only cohesion is left of it.

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

    def on(self, x: Array, touching: NDArray[np.bool_]) -> Adhesion:
        """Return strength and length at positions x (n,); slots have no strength."""
        strength = np.zeros(len(x))
        strength[touching] = sampled("adhesion: strength", self.strength, x[touching])
        length = np.ones(len(x))
        length[touching] = sampled("adhesion: length", self.length, x[touching])
        return Adhesion(strength, length)

    def tension(self, gap: Array, opened: Array) -> Array:
        """Return the tension at gaps (n,), the largest gaps so far being (n,) [stress]."""
        left = self.strength * np.maximum(1 - np.maximum(gap, opened) / self.length, 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.where(gap < opened, left * gap / opened, left))


@dataclass(frozen=True, eq=False)
class Faces:
    """Pressure and gap of the interface at one time; arrays are (n,).

    Attributes
    ----------
    pressure : array
        Contact pressure [stress], 0 where the contact is open and on slots; tension of adhesion is
        negative.
    gap, gap_rate : array
        Gap [length] and its rate [length / time].  The gap is 0 or more on the contact; on slots it
        is the change of their width.
    closing : array
        Work per area that the contact has taken from the bodies in closing, and that adhesion has
        taken [stress length].
    opened : array
        Largest gap so far where the bodies touch, 0 on slots [length].
    """

    pressure: Array
    gap: Array
    gap_rate: Array
    closing: Array
    opened: Array

    @property
    def is_open(self) -> NDArray[np.bool_]:
        """Whether a node is open or begins to open, (n,)."""
        return (self.gap > 0) | (self.gap_rate > 0)


class Unilateral:
    """Contact that opens where the pressure would be negative, and closes where the gap ends.

    An opening rate U exerts the pressure Z [U + int h(q c_t (t - s)) q c_t U ds] with Z = rho c_l/2
    (`memory.impedance.Opening`).  Slip does not change the pressure between identical bodies,
    so each step computes the pressure before friction.  The gap follows the backward Euler rule, by
    which p U <= 0 at every node and step: the contact never gives energy to the bodies, which it
    does with the trapezoidal rule.  Adhesion takes at the end of the step the tension that its gap
    has then, by which it gives back no more than it took.

    Parameters
    ----------
    impedance : float
        Z [stress time / length].
    memory : LineMemory
        Memory of past opening.
    grid : Grid
        Nodes.
    loads : function of time and whether it is after a jump
        Pressure that an uncut line carries, and that of slot faces, (n,) each [stress].
    touching : (n,) array of bool
        Whether the bodies touch.
    adhesion : Adhesion, optional
        Tension that the contact carries, at the nodes.
    """

    def __init__(
        self,
        impedance: float,
        memory: LineMemory,
        grid: Grid,
        loads: Callable[..., tuple[Array, Array]],
        touching: NDArray[np.bool_],
        adhesion: Adhesion | None = None,
    ) -> None:
        self.impedance, self.memory, self.loads = impedance, memory, loads
        self.grid, self.touching, self.adhesion = grid, touching, adhesion

    def jump(self, now: Faces, time: float, push: Array | float = 0.0) -> Faces:
        """Return pressure and opening rate after loads have jumped, with the gap as it is.

        The pressure that slip exerts is `push`, (n,).
        """
        held = self.held(now)[0]
        line, slot = self.loads(time, after=True)
        least = np.where(now.gap > 0, -math.inf, 0.0)
        pressure, rate = self.balance(line + push, slot, held, least, now, 0.0)
        self.memory.exchange(self.grid.amplitudes(rate - now.gap_rate))
        return Faces(pressure, now.gap, rate, now.closing, now.opened)

    def step(self, now: Faces, time: float, length: float, path: float, sweeps: int) -> Faces:
        """Return pressure and gap one step later, and advance the memory to the same time.

        Parameters
        ----------
        now : Faces
            Pressure and gap at the beginning of the step.
        time : float
            End of the step [time].
        length, path : float
            Its length [time], and c_t times it [length].
        sweeps : int
            Iterations.
        """
        parting = Parting(self, now, time, length, path)
        for _ in range(sweeps):
            parting.sweep()
        return parting.faces

    def held(self, now: Faces) -> Array:
        """Return the convolutions now, one per kernel, (1 or 2, rows, m)."""
        held = self.memory.convolution(self.grid.amplitudes(now.gap_rate))
        return held if held.ndim == 3 else held[None]

    def frees(self, now: Faces, time: float, push: Array | float = 0.0) -> bool:
        """Return whether a node is open, or would open under the loads of a later time.

        The pressure that slip exerts is `push`, (n,).
        """
        if now.is_open[self.touching].any():
            return True
        left = self.loads(time)[0] + push + self.impedance * self.grid.values(self.held(now)[0])
        if self.adhesion is not None:
            left = left + self.adhesion.tension(now.gap, now.opened)
        return bool((left[self.touching] < 0).any())

    def balance(
        self,
        line: Array,
        slot: Array,
        convolution: Array,
        least: Array,
        now: Faces,
        length: float,
    ) -> tuple[Array, Array]:
        """Return pressure and opening rate at the end of a step.

        Parameters
        ----------
        line, slot : (n,) arrays
            Pressure that an uncut line carries, and that of slot faces [stress].
        convolution : (rows, m) array
        least : (n,) array
            Opening rate at which the gap closes within the step [length / time].
        now : Faces
            Pressure and gap at the beginning of the step.
        length : float
            Its length [time].
        """
        stopping = line + self.impedance * self.grid.values(convolution)
        freed = -stopping / self.impedance
        tension = 0.0 * stopping
        if self.adhesion is not None:
            freed = np.where(self.touching, self._parted(stopping, now, length), freed)
            gap = now.gap + length * np.maximum(freed, least)
            tension = self.adhesion.tension(gap, now.opened) * self.touching
        rate = np.where(self.touching, np.maximum(freed, least), freed + slot / self.impedance)
        # An open node has a pressure of exactly 0, since rounding could make p U positive.
        held = self.touching & (least >= freed)
        floor = np.where((now.opened > 0) | (now.gap > 0), 0.0, -tension)
        closed = np.maximum(stopping + self.impedance * rate, floor)
        return np.where(held, closed, 0.0 - tension), rate

    def _parted(self, stopping: Array, now: Faces, length: float) -> Array:
        """Return the opening rate (n,) of nodes that adhesion holds, if the gap does not close.

        The pressure stopping + Z U is then that of the tension at the gap g + length U.  On the way
        back the tension is in proportion to the gap; beyond the largest gap so far it falls.
        """
        assert self.adhesion is not None
        strength, reach, z = self.adhesion.strength, self.adhesion.length, self.impedance
        gap, opened, soft = now.gap, now.opened, strength / reach
        with np.errstate(invalid="ignore", divide="ignore"):
            left = strength * np.maximum(1 - opened / reach, 0.0)
            stiff = np.where(opened > 0, left / opened, 0.0)
        back = -(stopping + stiff * gap) / (z + stiff * length)
        ahead = -(stopping + strength - soft * gap) / (z - soft * length)
        free = -stopping / z
        intact = opened == 0
        grows = np.where(intact, stopping < -strength, gap + length * back > opened)
        ahead = np.where((gap + length * ahead > reach) | (opened >= reach), free, ahead)
        return np.where(grows, ahead, np.where(intact, 0.0, back))


class Parting:
    """One step of the contact's pressure and gap, in sweeps; the memory is advanced at once.

    Parameters
    ----------
    unilateral, now, time, length, path
        As in `Unilateral.step`.
    """

    def __init__(
        self, unilateral: Unilateral, now: Faces, time: float, length: float, path: float
    ) -> None:
        self._unilateral, self._now, self._length = unilateral, now, length
        self._line, self._slot = unilateral.loads(time)
        self._amplitudes = unilateral.grid.amplitudes(now.gap_rate)
        past, feedback = unilateral.memory.advance(self._amplitudes, path)
        several = past.ndim == 3
        self._past, self._feedback = (past, feedback) if several else (past[None], feedback[None])
        self._least = 0.0 - now.gap / length
        self._pressure, self._rate = now.pressure, now.gap_rate

    @property
    def convolutions(self) -> Array:
        """Convolutions with the latest opening rate, one per kernel, (1 or 2, rows, m)."""
        return self._past + self._feedback[:, None] * self._amplitudes

    def sweep(self, push: Array | float = 0.0) -> Array:
        """Find the opening rate anew under a pressure that slip exerts; return the pressure."""
        self._pressure, self._rate = self._unilateral.balance(
            self._line + push,
            self._slot,
            self.convolutions[0],
            self._least,
            self._now,
            self._length,
        )
        self._amplitudes = self._unilateral.grid.amplitudes(self._rate)
        return self._pressure

    @property
    def faces(self) -> Faces:
        """Pressure and gap at the end of the step."""
        now, rate, on = self._now, self._rate, self._unilateral.touching
        gap = now.gap + self._length * rate
        gap[on] = np.where(rate > self._least, np.maximum(gap, 0.0), 0.0)[on]
        closing = now.closing - self._length * self._pressure * rate
        opened = np.where(on, np.maximum(now.opened, gap), 0.0)
        return Faces(self._pressure, gap, rate, closing, opened)
