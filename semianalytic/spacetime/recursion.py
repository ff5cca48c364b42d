"""The memory of the interface carried from one time step to the next, on all cosines of a grid."""

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
    """What the past exerts, carried over steps of one length by one number per pole and cosine.

    Between `enter` and `leave` the end value of the last step is left out of the numbers, so that
    a step costs one multiplication and one addition each.
    """

    def __init__(self, memory: Memory, phase: Array, damping: float) -> None:
        shape = (len(memory.poles), len(phase))
        self._decay, self._end, self._gain = (np.empty(shape, dtype=complex) for _ in range(3))
        for row, (pole, residue) in enumerate(zip(memory.poles, memory.residues, strict=True)):
            z = pole * phase
            first, second = _phi(z)
            weight = residue * phase
            self._decay[row], self._end[row] = np.exp(z), weight * second
            self._gain[row] = weight * (first - second) + self._decay[row] * self._end[row]
        self._half = memory.static * phase / 2
        self._scratch = np.empty(shape, dtype=complex)
        feedback = self._end.real.sum(axis=0) + self._half
        shortest = float(feedback[-1])
        if shortest >= LARGEST_FEEDBACK:
            raise SceneError(
                "march: step_ratio is beyond the stable range for this Poisson ratio; lower it by "
                f"{math.ceil(100 * (1 - math.sqrt(LARGEST_FEEDBACK / shortest)))} %."
            )
        self.feedback = feedback + max(damping - shortest, 0.0) * (phase / phase[-1]) ** 4

    def enter(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Begin steps of this length at a rate (size,), in place."""
        modes -= self._end * rate
        lasting -= self._half * rate

    def step(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Step on in place, all but the end value; rate is that of the start, (size,)."""
        modes *= self._decay
        np.multiply(self._gain, rate, out=self._scratch)
        modes += self._scratch
        lasting += 2 * self._half * rate

    def leave(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Add the end value in place."""
        modes += self._end * rate
        lasting += self._half * rate


def exerted(modes: Complex, lasting: Array) -> Array:
    """What the past exerts, per cosine (size,), over rho c_t / 2."""
    return np.asarray(modes.real.sum(axis=0) + lasting)


def _phi(z: Complex) -> tuple[Complex, Complex]:
    """(e^z - 1)/z and (e^z - 1 - z)/z^2."""
    small = np.abs(z) < 1e-2
    large = np.where(small, 1.0, z)
    first = (np.exp(large) - 1) / large
    second = (first - 1) / large
    series = 0.5 + z / 6 * (1 + z / 4 * (1 + z / 5))
    return np.where(small, 1 + z * series, first), np.where(small, series, second)
