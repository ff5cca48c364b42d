"""The local problem: friction on contacts and loads on slots, met at each node by itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.line import Grid
from semianalytic.interface.law import InterfaceLaw
from semianalytic.spacetime.grid.line import area_means

Array = NDArray[np.float64]


class Balance:
    """Slip rate and traction of each node at the end of a step, under the traction that stops it.

    Neither friction nor slots know of the memory, which is contained in that traction.

    Parameters
    ----------
    law : InterfaceLaw
        Friction, drawn on the nodes of the contact.
    impedance : float
        Traction per relative slip rate of plane waves [stress time / length].
    touching : (n,) array of bool
        Whether the bodies touch; the rest is slot.
    grid : Grid
        Nodes.
    """

    def __init__(
        self, law: InterfaceLaw, impedance: float, touching: NDArray[np.bool_], grid: Grid
    ) -> None:
        self._law, self._impedance, self._touching = law, impedance, touching
        left, right = np.roll(touching, 1), np.roll(touching, -1)
        if grid.even:
            # the neighbours of the first and the last node are mirror images of nodes
            left[0], right[-1] = touching[0], touching[-1]
        self._inner = (touching & left & right)[touching]
        # Beyond the ends of half a line lie mirror images of the nodes inside it.
        self._mirror = (0 if grid.between else 1) if grid.even else None

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
        on = stopping[touching]
        freed = None if is_open is None else is_open[touching]
        size = np.abs(on)
        if law.has_threshold:
            rest = law.strength(felt, np.zeros(len(on)), state)
            if freed is not None:
                rest = np.where(freed, 0.0, rest)
            # The mean acts where slip ends as well.  Without it there (`before`) five of nine
            # interfaces have the same errors, slip of pulses beside slots is up to 27 % better and
            # that of a pulse at an angle up to 15 % worse (docs/engine.md, "Method").
            size = area_means(size, size - rest, self._inner, mirror=self._mirror)
        if freed is not None:
            # Open nodes need some positive pressure here; their slip rate is replaced below.
            felt = np.where(freed, 1.0, felt)
        speed = law.slip_speed(size, felt, impedance, state)
        rate = (stopping - slot) / impedance
        # Slip has the sense of the traction it relaxes; 0.0 - speed keeps +0.0 where it sticks.
        rate[touching] = np.where(on < 0, 0.0 - speed, speed)
        traction = stopping - impedance * rate
        if freed is not None:
            rate[touching] = np.where(freed, on / impedance, rate[touching])
            traction[touching] = np.where(freed, 0.0, traction[touching])
        return rate, traction


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
    solved by conjugate gradients instead, in 2 to 5 iterations.

    Parameters
    ----------
    grid : Grid
        Nodes.
    touching : (n,) array of bool
        Whether the bodies touch; the rest is slot.
    rate : (n,) array
        Slip rate less that of the plates: wanted on the contact, a guess on slots [length / time].
    load : (n,) array
        Traction of the uncut line less that of slot faces, over the impedance [length / time].
    past, feedback : (rows, m) and (m,) arrays
        Convolution without the rate at the end of the step, and the share of that rate in it; see
        `LineMemory`.
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
