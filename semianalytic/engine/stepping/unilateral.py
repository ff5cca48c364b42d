"""Contact that opens where the pressure would be negative, and closes where the gap ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.line import Grid
from semianalytic.memory.line_memory import LineMemory
from semianalytic.scene.arrays import Array
from semianalytic.scene.line.contact import Adhesion


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

    def held(self, now: Faces) -> Array:
        """Return the convolutions now, one per kernel, (1 or 2, rows, m)."""
        return self.memory.convolution(self.grid.amplitudes(now.gap_rate))

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
        """Return the opening rate (n,) of nodes that adhere, if the gap does not close.

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
    unilateral : Unilateral
        Contact and memory.
    now : Faces
        Pressure and gap at the beginning of the step.
    time : float
        End of the step [time].
    length, path : float
        Its length [time], and c_t times it [length].
    """

    def __init__(
        self, unilateral: Unilateral, now: Faces, time: float, length: float, path: float
    ) -> None:
        self._unilateral, self._now, self._length = unilateral, now, length
        self._line, self._slot = unilateral.loads(time)
        self._amplitudes = unilateral.grid.amplitudes(now.gap_rate)
        self._past = unilateral.memory.advance(self._amplitudes, path)
        self._feedback = unilateral.memory.feedback
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
