"""The slip rate of slots at the end of a long step, which no friction keeps from diverging."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.line import Grid
from semianalytic.engine.tuning import SLOT_TOLERANCE

Array = NDArray[np.float64]


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
        Convolution without the rate at the end of the step, and the share of that rate in it, as
        `LineMemory.advance` returns them.
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
    found, _ = cg(resisted, wanted, rate[free], rtol=SLOT_TOLERANCE, M=near)
    after = rate.copy()
    after[free] = found
    return after
