"""The memory of the interface, carried from one time step to the next on all cosines of a grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semianalytic.memory.exponentials import Memory
from semianalytic.memory.tuning import LARGEST_FEEDBACK, MEMORY_STEPS
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Recursion:
    """The memory of past slip over steps of equal length, one number per pole and cosine.

    A pole z with residue r carries m(t) = r int exp(z q c_t (t - s)) q c_t V(s) ds, whose part
    before a step is multiplied by exp(z q c_t dt).  V is linear over the step, so its integral
    there is exact.  Between `enter` and `leave` the contribution of the end value of V is left out
    of m, because that value is still to be found.

    The numbers m are brought up to date every `MEMORY_STEPS` steps.  In between, what they exert is
    known ahead but for the rates of those few steps, for which the sum over poles is made once: a
    step then reads half of the numbers that it would have to read otherwise.

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
        poles, size = len(memory.poles), len(phase)
        # exp(z q c_t k dt) for k = 1, 2, ...
        self._decays = np.empty((MEMORY_STEPS, poles, size), dtype=complex)
        self._end, self._gain, self._scratch = np.empty((3, poles, size), dtype=complex)
        decay = self._decays[0]
        for row, (pole, residue) in enumerate(zip(memory.poles, memory.residues, strict=True)):
            z = pole * phase
            first, second = _phi(z)
            weight = residue * phase
            # int_0^1 exp(z (1 - s)) V(s) ds for V from V0 to V1: (first - second) V0 + second V1
            decay[row], self._end[row] = np.exp(z), weight * second
            # V0 was the end value of the step before, left out there and so added here, decayed
            self._gain[row] = weight * (first - second) + decay[row] * self._end[row]
        # What the start value of a step exerts at its end, and that many steps later; the last row
        # is the first of these, so that rates of increasing time meet rows in order.
        self._kernel = np.empty((MEMORY_STEPS, size))
        self._kernel[-1] = self._gain.real.sum(axis=0)
        for after in range(1, MEMORY_STEPS):
            earlier, later = self._decays[after - 1 : after + 1]
            np.multiply(self._gain, earlier, out=self._scratch)
            self._kernel[-1 - after] = self._scratch.real.sum(axis=0)
            np.multiply(earlier, decay, out=later)
        # the static part of h remembers slip itself: the trapezoidal rule, exact for linear V
        self._half = memory.static * phase / 2
        self._whole = 2 * self._half
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
        # Real and imaginary parts lie side by side: with each rate written twice, sums of products
        # of complex numbers with real ones are sums of products of real numbers.
        self._rates, self._free = np.empty((2, MEMORY_STEPS, size))
        self._twice, self._both = np.empty((2, MEMORY_STEPS, 2 * size))
        self._taken = 0

    def enter(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Begin steps of this length at a rate (size,): take its end value out.

        Parameters
        ----------
        modes : (poles, size) complex array
            The numbers m, which are changed in place until `leave`.
        lasting : (size,) array
            The static part of the memory, changed in place as well.
        rate : (size,) array
            Cosines of the slip rate.
        """
        self._modes, self._lasting, self._taken = modes, lasting, 0
        self._modes -= np.multiply(self._end, rate, out=self._scratch)
        self._lasting -= self._half * rate

    def step(self, rate: Array) -> Array:
        """Step on, leaving out the end value; `rate` is that at the start, (size,).

        Returns what is exerted at the end of the step but for its end value, as `exerted` does.
        """
        if self._taken == 0:
            self._look_ahead()
        taken = self._taken
        self._rates[taken] = rate
        # half as the start of this step, half as the end value left out of the one before
        self._lasting += self._whole * rate
        past = np.einsum("ks,ks->s", self._kernel[-1 - taken :], self._rates[: taken + 1])
        past += self._free[taken]
        past += self._lasting
        self._taken += 1
        if self._taken == MEMORY_STEPS:
            self._catch_up()
        return past

    def leave(self, rate: Array) -> None:
        """End the steps of this length: bring the memory up to date and add the end value."""
        if self._taken:
            self._catch_up()
        self._modes += np.multiply(self._end, rate, out=self._scratch)
        self._lasting += self._half * rate

    def _look_ahead(self) -> None:
        """Sum up what the numbers m exert after each of the steps to come."""
        np.einsum("kps,ps->ks", self._decays.view(float), self._modes.view(float), out=self._both)
        # the real part of a product is that of the real parts less that of the imaginary parts
        np.subtract(self._both[:, ::2], self._both[:, 1::2], out=self._free)

    def _catch_up(self) -> None:
        """Bring the numbers m to the end of the steps that were taken."""
        taken, scratch = self._taken, self._scratch
        self._twice.reshape(MEMORY_STEPS, -1, 2)[:taken] = self._rates[:taken, :, None]
        # the rate at the start of step j has decayed over taken - 1 - j steps since its end
        if taken > 1:
            decays = self._decays[taken - 2 :: -1].view(float)
            np.einsum("kps,ks->ps", decays, self._twice[: taken - 1], out=scratch.view(float))
        else:
            scratch[:] = 0
        scratch.real += self._rates[taken - 1]
        scratch *= self._gain
        self._modes *= self._decays[taken - 1]
        self._modes += scratch
        self._taken = 0


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
