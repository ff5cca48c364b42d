"""The memory of the interface, carried from one time step to the next on all cosines of a grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import SceneError
from semianalytic.spacetime.exponentials import GridMemory
from semianalytic.spacetime.tuning import (
    LARGEST_FEEDBACK,
)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Modes = NDArray[np.complex64] | NDArray[np.complex128]


class Recursion:
    """The memory of past slip over steps of equal length, one number per pole and cosine.

    A pole z with residue r carries m(t) = r int exp(z q c_t (t - s)) q c_t V(s) ds, whose part
    before a step is multiplied by exp(z q c_t dt).  V is linear over the step, so its integral
    there is exact.  Between `enter` and `leave` the contribution of the end value of V is left out
    of m, because that value is still to be found; a step then costs one multiplication and one
    addition per number.

    Parameters
    ----------
    memory : GridMemory
        Poles, residues and the static part of h.
    phase : (size,) array
        q c_t dt of all cosines.
    damping : float
        Least feedback of the shortest wave.
    modes : (n,) complex array
        The numbers m, band by band, in each pole by pole; steps change them in place.  The
        coefficients have the same precision, rates and sums are double.
    lasting : (size,) array
        The static part of the memory, changed in place.

    Attributes
    ----------
    feedback : (size,) array
        What the end value of V contributes to the convolution, per cosine and unit of V.

    Raises
    ------
    SceneError
        If the feedback of the shortest wave is too close to 1 for the iteration of a step.
    """

    def __init__(
        self, memory: GridMemory, phase: Array, damping: float, modes: Modes, lasting: Array
    ) -> None:
        self._modes, self._lasting, kind = modes, lasting, modes.dtype
        self._decay, self._end, gains = (np.empty(len(modes), dtype=kind) for _ in range(3))
        feedback, first = np.zeros(len(phase)), 0
        real = modes.real.dtype
        self._twice = np.empty(2 * len(phase), dtype=real)
        self._sums, self._scratch = np.empty_like(self._twice), np.empty(2 * len(modes), dtype=real)
        parts, gain, self._bands = modes.view(real), gains.view(real), []
        for cosines, poles in memory.bands(len(phase)):
            here, begin = phase[cosines], first
            for pole, residue in zip(memory.poles[poles], memory.residues[poles], strict=True):
                z = pole * here
                one, two = _phi(z)
                weight, decay = residue * here, np.exp(z)
                # int_0^1 exp(z (1 - s)) V(s) ds for V from V0 to V1: (one - two) V0 + two V1
                end, row = weight * two, slice(first, first + len(here))
                # V0 was the end value of the step before, left out there and added here, decayed
                gains[row] = weight * (one - two) + decay * end
                self._decay[row], self._end[row] = decay, end
                feedback[cosines] += end.real
                first = row.stop
            # Real and imaginary parts lie side by side.  With each rate written twice, the product
            # of complex gains and real rates is one of real numbers, in half the time.
            both = slice(2 * cosines.start, 2 * cosines.stop)
            views = (
                values[2 * begin : 2 * first].reshape(-1, 2 * len(here))
                for values in (parts, gain, self._scratch)
            )
            self._bands.append((*views, self._twice[both], self._sums[both]))
        self._parts = parts
        # the static part of h remembers slip itself: the trapezoidal rule, exact for linear V
        self._half = memory.static * phase / 2
        self._whole = 2 * self._half
        feedback += self._half
        # The iteration of a step contracts by the feedback, which must be below 1; the shortest
        # wave has the largest.  h(0) = 0, so the feedback grows like the square of the step.
        shortest = float(feedback[-1])
        if shortest >= LARGEST_FEEDBACK:
            raise SceneError(
                "march: `step_ratio` is beyond the stable range for this Poisson ratio; lower it "
                f"by {math.ceil(100 * (1 - math.sqrt(LARGEST_FEEDBACK / shortest)))} %."
            )
        # damping: the shortest wave gets the feedback `damping`, longer ones much less more
        self.feedback = feedback + max(damping - shortest, 0.0) * (phase / phase[-1]) ** 4

    def exerted(self) -> Array:
        """Return the convolution over past slip in (4.40), per cosine (size,) [length / time]."""
        for modes, _, _, _, sums in self._bands:
            np.add.reduce(modes, axis=0, out=sums)
        return np.asarray(self._sums[::2] + self._lasting)

    def enter(self, rate: Array) -> None:
        """Begin steps of this length at a rate (size,): take its end value out."""
        self._add_end(-rate)

    def step(self, rate: Array) -> Array:
        """Step on, leaving out the end value; `rate` is that at the start, (size,).

        Returns what is exerted at the end of the step but for its end value, as `exerted` does.
        """
        self._twice.reshape(-1, 2)[:] = rate[:, None]
        np.multiply(self._modes, self._decay, out=self._modes)
        for _, gain, scratch, twice, _ in self._bands:
            np.multiply(gain, twice, out=scratch)
        np.add(self._parts, self._scratch, out=self._parts)
        # half as the start of this step, half as the end value left out of the one before
        self._lasting += self._whole * rate
        return self.exerted()

    def leave(self, rate: Array) -> None:
        """End the steps of this length: add the end value."""
        self._add_end(rate)

    def _add_end(self, rate: Array) -> None:
        """Add what an end value of V contributes."""
        self._twice.reshape(-1, 2)[:] = rate[:, None]
        for _, _, scratch, twice, _ in self._bands:
            scratch[:] = twice
        self._parts += self._end.view(self._parts.dtype) * self._scratch
        self._lasting += self._half * rate


def _phi(z: Complex) -> tuple[Complex, Complex]:
    """Return (e^z - 1)/z and (e^z - 1 - z)/z^2."""
    # both cancel at small z; the series, to z^3, is right to 1e-10 below 0.01
    small = np.abs(z) < 1e-2
    large = np.where(small, 1.0, z)
    first = (np.exp(large) - 1) / large
    second = (first - 1) / large
    series = 0.5 + z / 6 * (1 + z / 4 * (1 + z / 5))
    return np.where(small, 1 + z * series, first), np.where(small, series, second)
