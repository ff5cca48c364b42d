"""The memory of the interface, carried from one time step to the next on all cosines of a grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import SceneError
from semianalytic.spacetime.exponentials import Memory
from semianalytic.spacetime.tuning import (
    LARGEST_FEEDBACK,
)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Recursion:
    """The memory of past slip over steps of equal length, one number per pole and cosine.

    A pole z with residue r carries m(t) = r int exp(z q c_t (t - s)) q c_t V(s) ds, whose part
    before a step is multiplied by exp(z q c_t dt).  V is linear over the step, so its integral
    there is exact.  Between `enter` and `leave` the contribution of the end value of V is left out
    of m, because that value is still to be found; a step then costs one multiplication and one
    addition per number.

    Parameters
    ----------
    memory : Memory
        Poles, residues and the static part of h.
    phase : (size,) array
        q c_t dt of all cosines.
    damping : float
        Least feedback of the shortest wave.

    Attributes
    ----------
    feedback : (size,) array
        What the end value of V contributes to the convolution, per cosine and unit of V.

    Raises
    ------
    SceneError
        If the feedback of the shortest wave is too close to 1 for the iteration of a step.
    """

    def __init__(self, memory: Memory, phase: Array, damping: float) -> None:
        shape = (len(memory.poles), len(phase))
        self._decay, self._end, self._gain = (np.empty(shape, dtype=complex) for _ in range(3))
        for row, (pole, residue) in enumerate(zip(memory.poles, memory.residues, strict=True)):
            z = pole * phase
            first, second = _phi(z)
            weight = residue * phase
            # int_0^1 exp(z (1 - s)) V(s) ds for V from V0 to V1: (first - second) V0 + second V1
            self._decay[row], self._end[row] = np.exp(z), weight * second
            # V0 was the end value of the step before, left out there and so added here, decayed
            self._gain[row] = weight * (first - second) + self._decay[row] * self._end[row]
        # the static part of h remembers slip itself: the trapezoidal rule, exact for linear V
        self._half = memory.static * phase / 2
        self._scratch = np.empty(shape, dtype=complex)
        feedback = self._end.real.sum(axis=0) + self._half
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

    def enter(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Begin steps of this length at a rate (size,): take its end value out, in place."""
        modes -= self._end * rate
        lasting -= self._half * rate

    def step(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Step on in place, leaving out the end value; `rate` is that at the start, (size,)."""
        modes *= self._decay
        np.multiply(self._gain, rate, out=self._scratch)
        modes += self._scratch
        # half as the start of this step, half as the end value left out of the one before
        lasting += 2 * self._half * rate

    def leave(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """End the steps of this length: add the end value, in place."""
        modes += self._end * rate
        lasting += self._half * rate


def exerted(modes: Complex, lasting: Array) -> Array:
    """Return the convolution over past slip in (4.40), per cosine (size,) [length / time]."""
    return np.asarray(modes.real.sum(axis=0) + lasting)


def _phi(z: Complex) -> tuple[Complex, Complex]:
    """Return (e^z - 1)/z and (e^z - 1 - z)/z^2."""
    # both cancel at small z; the series, to z^3, is right to 1e-10 below 0.01
    small = np.abs(z) < 1e-2
    large = np.where(small, 1.0, z)
    first = (np.exp(large) - 1) / large
    second = (first - 1) / large
    series = 0.5 + z / 6 * (1 + z / 4 * (1 + z / 5))
    return np.where(small, 1 + z * series, first), np.where(small, series, second)
