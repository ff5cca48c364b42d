"""The local problem: friction on contacts and loads on slots, met at each node by itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.line import Grid
from semianalytic.engine.stepping.means import area_means
from semianalytic.scene.arrays import Array
from semianalytic.scene.laws.law import Law


class Balance:
    """Slip rate and traction of each node at the end of a step, under the traction that stops it.

    Neither friction, drawn on the nodes of the contact, nor slots know of the memory, which is
    contained in that traction.  The impedance is the traction per relative slip rate of plane waves
    [stress time / length]; `falls` says whether nodes at which the excess of traction over strength
    has fallen since the level before do without the mean over their stretch (`area_means`).  Masks
    `on` and `slots` have the nodes of the contact, and the others.
    """

    def __init__(
        self,
        law: Law,
        impedance: float,
        touching: NDArray[np.bool_],
        grid: Grid,
        falls: bool = False,
    ) -> None:
        self._law, self._impedance, self._touching = law, impedance, touching
        left, right = np.roll(touching, 1), np.roll(touching, -1)
        if grid.even:
            # the neighbours of the first and the last node are mirror images of nodes
            left[0], right[-1] = touching[0], touching[-1]
        self._inner = (touching & left & right)[touching]
        # Beyond the ends of half a line lie mirror images of the nodes inside it.
        self._mirror = (0 if grid.between else 1) if grid.even else None
        self.on, self.slots = _nodes(touching), _nodes(~touching)
        self._steady = law.steady_slope()
        self._is_dry = self._steady is not None and not np.any(self._steady)
        self._resisting = None if self._steady is None else impedance + self._steady
        self._felt = self._rest = np.zeros(0)
        self._follows = law.follows_state
        self._falls = falls
        self._excess: Array | None = None
        self._before: Array | None = None

    def turn(self) -> None:
        """Begin a new level; what was found last belongs to the level before it."""
        self._before = self._excess if self._falls else None

    def forget(self) -> None:
        """Forget the last level, as loads jump: where slip grows or ends is not known then."""
        self._excess = None

    def recall(self, traction: Array, rate: Array, state: Array, felt: Array) -> None:
        """Take up the last level from its traction and slip rate, (contact,) each."""
        if self._falls and self._excess is None:
            size = np.abs(traction + self._impedance * rate)
            self._excess = size - self._strength_at_rest(felt, state)

    def closed(
        self,
        stopping: Array,
        slot: Array | float,
        state: Array,
        felt: Array,
        out: Array,
        means: bool = True,
    ) -> None:
        """Write the slip rate (n,) of a contact that sticks below its strength, and is closed.

        Parameters
        ----------
        stopping : (n,) array
            Traction of a node that does not move [stress].
        slot : (slots,) array or float
            That of slot faces [stress].
        state, felt : (contact,) arrays
            State of friction, and the pressure it follows [stress].
        out : (n,) array
            Where the slip rate is written [length / time].
        means : bool
            Whether nodes slip by the mean over their stretch (`area_means`).
        """
        on = stopping[self.on]
        size = np.abs(on)
        excess = self._excess = size - self._strength_at_rest(felt, state)
        if means:
            mean = area_means(size, excess, self._inner, self._before, self._mirror)
            if mean is not size:
                size, excess = mean, mean - self._rest
        if self._resisting is None:
            speed = self._law.slip_speed(size, felt, self._impedance, state)
        else:
            speed = np.maximum(excess, 0.0)
            speed /= self._resisting
        # Slip has the sense of the traction it relaxes; adding 0.0 keeps +0.0 where it sticks.
        moving = out[self.on]
        np.copysign(speed, on, out=moving)
        moving += 0.0
        if not isinstance(self.on, slice):
            out[self.on] = moving
        if len(on) < len(out):
            out[self.slots] = (stopping[self.slots] - slot) / self._impedance

    def strength(self, speed: Array, state: Array, felt: Array) -> Array:
        """Return the strength at speeds (contact,) under a state and a pressure [stress]."""
        if self._steady is None:
            return self._law.strength(felt, speed, state)
        if self._is_dry:
            return self._strength_at_rest(felt, state)
        return self._strength_at_rest(felt, state) + self._steady * speed

    def _strength_at_rest(self, felt: Array, state: Array) -> Array:
        if felt is not self._felt or self._follows:
            self._felt = felt
            rest = self._law.strength(felt, np.zeros(len(felt)), state)
            self._rest = np.asarray(rest, dtype=float)
        return self._rest

    def __call__(
        self,
        stopping: Array,
        slot: Array,
        state: Array,
        felt: Array,
        is_open: NDArray[np.bool_] | None,
    ) -> tuple[Array, Array]:
        """Return slip rate [length / time] and traction [stress], (n,) each.

        Parameters
        ----------
        stopping, slot : (n,) arrays
            Traction of a node that does not move, and that of slot faces [stress].
        state, felt : (contact,) arrays
            State of friction, and the pressure it follows [stress].
        is_open : (n,) array of bool, optional
            Where the contact is open and carries nothing; None if it never opens.
        """
        touching, law, impedance = self._touching, self._law, self._impedance
        rate = np.empty(len(stopping))
        if is_open is None and law.has_threshold:
            self.closed(stopping, slot[self.slots], state, felt, rate)
            return rate, stopping - impedance * rate
        on = stopping[self.on]
        freed = None if is_open is None else is_open[self.on]
        size = np.abs(on)
        if law.has_threshold and freed is not None:
            rest = np.where(freed, 0.0, law.strength(felt, np.zeros(len(on)), state))
            size = area_means(size, size - rest, self._inner, mirror=self._mirror)
        if freed is not None:
            # Open nodes need some positive pressure here; their slip rate is replaced below.
            felt = np.where(freed, 1.0, felt)
        speed = law.slip_speed(size, felt, impedance, state)
        if not touching.all():
            rate[self.slots] = (stopping - slot)[self.slots] / impedance
        rate[self.on] = np.where(on < 0, 0.0 - speed, speed)
        traction = stopping - impedance * rate
        if freed is not None:
            rate[self.on] = np.where(freed, on / impedance, rate[self.on])
            traction[self.on] = np.where(freed, 0.0, traction[self.on])
        return rate, traction


def _nodes(chosen: NDArray[np.bool_]) -> slice | NDArray[np.bool_]:
    """Return what takes nodes out of arrays: a slice, which copies nothing, where one does."""
    found = np.flatnonzero(chosen)
    if not len(found):
        return slice(0, 0)
    span = slice(int(found[0]), int(found[-1]) + 1)
    return span if chosen[span].all() else chosen


def freed_rate(
    grid: Grid,
    touching: NDArray[np.bool_],
    rate: Array,
    load: Array,
    past: Array,
    feedback: Array,
) -> Array:
    """Return a slip rate (n,) that balances the load of slots, with that of the contact as given.

    Only radiation resists the faces of a slot at once.  An iteration like that of the contact,
    where friction rises with slip rate, therefore diverges over long steps; V + h * V = load is
    solved by conjugate gradients instead, in 2 to 5 iterations.  The rate (n,), less that of the
    plates, is a guess on slots; the load (n,) is the traction of the uncut line less that of slot
    faces, over the impedance [length / time]; past (rows, m) and feedback (m,) are the convolution
    without the rate at the end of the step, and the share of that rate in it; see `LineMemory`.
    """
    from scipy.sparse.linalg import LinearOperator, cg

    free = ~touching
    line = np.where(free, 0.0, rate)
    wanted = (load - grid.values(past + feedback * grid.amplitudes(line)))[free]
    line[:] = 0.0

    def spread(values: Array, factor: Array) -> Array:
        line[free] = values
        return grid.values(factor * grid.amplitudes(line))[free]

    shape = (len(wanted), len(wanted))
    resisted = LinearOperator(shape, lambda v: v + spread(v, feedback), dtype=float)
    # the inverse on a line that is slot everywhere
    near = LinearOperator(shape, lambda v: spread(v, 1 / (1 + feedback)), dtype=float)
    # Slip between two slots changes by 3e-13 with 1e-12, and by 6e-10 with 1e-6, which saves a
    # third of the iterations.
    found, _ = cg(resisted, wanted, rate[free], rtol=1e-9, M=near)
    after = rate.copy()
    after[free] = found
    return after
