"""The memory of a line for past slip, or opening, carried from one time step to the next.

A slip rate V of wavenumber q exerts -(mu / 2 c_t) [V + int h(q c_t (t - s)) q c_t V ds], and h is a
sum of exponentials (`exponentials`).  A pole z with residue r therefore carries one number,
m(t) = r int exp(z q c_t (t - s)) q c_t V(s) ds, per wavenumber, whose part before a step is
multiplied by exp(z q c_t dt).  V is linear over a step, so that its integral there is exact and
steps may have any length.  The memory knows nothing of contacts, slots or friction.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from semianalytic.memory.exponentials import Memory, SharedMemory
from semianalytic.scene.arrays import Array, Complex


@dataclass(frozen=True, eq=False)
class Past:
    """Memory of a line at one time."""

    # convolutions with the exponentials, at the time up to which they are known, (rows, p, size)
    modes: Complex
    lasting: Array  # convolution with the static part of the kernel, (rows, size)
    # c_t times the length of the last step [length], whose end value is left out of all of these; 0
    # where nothing is left out
    last: float = 0.0


@dataclass(frozen=True, eq=False)
class Kernels:
    """How the numbers of the memory exert one or more tractions."""

    # poles z, and factors with which a rate enters the numbers m, (p,) each
    poles: Complex
    weights: Complex
    # factors of the numbers m in each of k kernels; None for one kernel that adds them up, (k, p)
    reads: Complex | None
    static: float  # factor with which a rate enters the lasting slip
    lasting: Array  # factors of that in each kernel; one kernel has it as it is, (k,)
    horizon: float  # largest q c_t t for which the kernels are made

    @classmethod
    def of(cls, memory: Memory) -> Kernels:
        """Return the one kernel h of a memory."""
        parts = memory.poles, memory.residues, None, memory.static, np.ones(1)
        return cls(*parts, memory.horizon)

    @classmethod
    def coupled(cls, fit: SharedMemory, own: int, direct: float) -> Kernels:
        """Return the two kernels of slip, or opening, of different bodies.

        Slip changes the pressure between bodies that differ, and opening the shear traction,

            tau = tau_0 - Z_V [V + h_s * V] + i sgn(q) Z_U h_p * U,
            p   = p_0   + Z_U [U + h_n * U] + i sgn(q) Z_V h_q * V,

        with Z_V, Z_U the impedances of plane waves; nothing of the coupling is at once
        (`dissimilar.kernels`).

        The fit is of Z_s, Z_n and H; `own` is 0 for slip, whose own kernel is Z_s, 1 for opening,
        whose own is Z_n; `direct` is Z_V or Z_U over the unit of the kernels.
        """
        reads, lasting = fit.residues[[own, 2]] / direct, fit.static[[own, 2]] / direct
        return cls(fit.poles, np.ones_like(fit.poles), reads, 1.0, lasting, fit.horizon)

    def exerted(self, modes: Complex, lasting: Array, out: Array) -> None:
        """Write what numbers m (p, size) and lasting slip (size,) exert, (k, size)."""
        if self.reads is None:
            # Real and imaginary parts lie side by side: their sums over poles are one product of
            # a vector with a matrix, in half the time of a sum over the real parts.
            parts = modes.view(modes.real.dtype)
            np.add((_ones(len(modes), parts.dtype) @ parts)[::2], lasting, out=out[0])
        else:
            np.multiply.outer(self.lasting, lasting, out=out)
            out += (self.reads @ modes).real


@lru_cache
def _ones(count: int, kind: np.dtype[Any]) -> Array:
    return np.ones(count, kind)


class Factors(NamedTuple):
    """Factor of a step on the numbers m, and what the rate at its end and begin adds to them."""

    decay: Complex
    end: Complex
    gain: Complex


class Part(NamedTuple):
    """Wavenumbers whose numbers m have one precision: which, and their complex and real types."""

    place: slice
    kind: type
    real: type


class StepTable:
    """Factors by which steps of one length change the memory, per pole and wavenumber.

    Parameters
    ----------
    kernels : Kernels
        The sum of exponentials.
    phase : (size,) array
        q c_t dt.
    parts : sequence of Part
        Wavenumbers that have one precision, and which.

    Attributes
    ----------
    factors : list of Factors
        Factors of the numbers m of each part.
    half, whole : (size,) arrays
        Factor on the rate at an end of a step in the lasting slip, and twice that.
    feedback : (k, size) array
        Share of a unit rate at the end of a step in each convolution.
    """

    def __init__(self, kernels: Kernels, phase: Array, parts: Sequence[Part]) -> None:
        whole = Factors(*np.empty((3, len(kernels.poles), len(phase)), dtype=complex))
        for row, (pole, weight) in enumerate(zip(kernels.poles, kernels.weights, strict=True)):
            z = pole * phase
            whole.decay[row], first, second = phi(z)
            share = weight * phase
            # int_0^1 exp(z (1 - s)) V(s) ds for V from V0 to V1: (first - second) V0 + second V1
            whole.end[row] = share * second
            # V0 was the end value of the step before, left out there and so added here, decayed
            whole.gain[row] = share * (first - second) + whole.decay[row] * whole.end[row]
        # the lasting slip by the trapezoidal rule, exact for linear V
        self.half = kernels.static * phase / 2
        self.whole = 2 * self.half
        self.feedback = np.empty((len(kernels.lasting), len(phase)))
        kernels.exerted(whole.end, self.half, self.feedback)
        self.factors = [
            Factors(*(table[:, part.place].astype(part.kind, order="C") for table in whole))
            for part in parts
        ]


class LineMemory:
    """The memory of past slip on a line, carried over steps of any length.

    The end value of a step is still to be found when its memory is needed: `advance` returns the
    convolution without it, and `feedback` is its share per unit.

    Parameters
    ----------
    memory : Memory or Kernels
        Poles, residues and the static part of h, or of several kernels.
    wavenumbers : (size,) array
        q [1 / length].
    rows : int
        Amplitudes per wavenumber: 1 of cosines, 2 of a periodic line (real and imaginary parts).
    tables : int
        Step lengths whose tables are kept.
    double : int, optional
        Wavenumbers whose numbers m and factors have double precision, of which the lowest are
        taken; all by default.  Those of single precision take half the time.  Lasting slip and
        feedback are double in any case.
    """

    def __init__(
        self,
        memory: Memory | Kernels,
        wavenumbers: Array,
        rows: int = 1,
        tables: int = 1,
        double: int | None = None,
    ) -> None:
        kernels = memory if isinstance(memory, Kernels) else Kernels.of(memory)
        self.horizon, self.size = kernels.horizon, len(wavenumbers)
        self._kernels, self._q, self._most = kernels, wavenumbers, tables
        double = self.size if double is None else double
        parts = (
            Part(slice(0, double), complex, float),
            Part(slice(double, self.size), np.complex64, np.float32),
        )
        self._parts = [part for part in parts if part.place.start < part.place.stop]
        poles = len(kernels.poles)
        sizes = [part.place.stop - part.place.start for part in self._parts]
        # convolutions, without the share of the newest rate where a last step is noted
        self._modes = [
            np.zeros((rows, poles, size), dtype=part.kind)
            for part, size in zip(self._parts, sizes, strict=True)
        ]
        self._scratch = [np.empty_like(modes[0]) for modes in self._modes]
        self._lasting, self._last = np.zeros((rows, self.size)), 0.0
        self._tables: OrderedDict[float, StepTable] = OrderedDict()

    @property
    def feedback(self) -> Array:
        """Share of a unit rate at the end of the last step in each convolution, (k, size)."""
        return self.table(self._last).feedback

    def table(self, step: float) -> StepTable:
        """Return the table of steps c_t dt [length]; the latest ones are kept."""
        if step not in self._tables:
            if len(self._tables) >= self._most:
                self._tables.popitem(last=False)
            self._tables[step] = StepTable(self._kernels, self._q * step, self._parts)
        self._tables.move_to_end(step)
        return self._tables[step]

    def advance(self, amplitudes: Array, step: float) -> Array:
        """Step on by c_t dt [length] from rates (rows, size); return convolutions but their end."""
        if self._last != step:
            # The memory lacks the share of the newest rate as the table of the last step has it;
            # the table of this step has another share, which its `gain` adds.
            self.settle(amplitudes)
            self._add(self.table(step), -amplitudes)
            self._last = step
        table = self.table(step)
        # half as the start of this step, half as the end value left out of the one before
        self._lasting += table.whole * amplitudes
        for part, every, factors, scratch in self._with(table):
            for modes, row in zip(every, amplitudes[:, part.place], strict=True):
                modes *= factors.decay
                modes += np.multiply(factors.gain, row.astype(part.real, copy=False), out=scratch)
        return self._exerted()

    def settle(self, amplitudes: Array) -> None:
        """Complete the memory with the newest rate (rows, size), so that nothing is left out."""
        if self._last:
            self._add(self.table(self._last), amplitudes)
            self._last = 0.0

    def convolution(self, amplitudes: Array) -> Array:
        """Return the convolutions now, (k, rows, size), with the newest rate (rows, size)."""
        held = self._exerted()
        if self._last:
            held += self.table(self._last).feedback[:, None] * amplitudes
        return held

    def exchange(self, change: Array) -> None:
        """Change the newest rate by amplitudes (rows, size), with the convolution as it is."""
        # The memory lacks the share of the newest rate, which the next step adds from the rate; a
        # jump changes that rate, so the share that is missing has to change with it.
        if self._last:
            self._add(self.table(self._last), -change)

    def past(self) -> Past:
        """Return copies of everything that steps change, for `put_back`."""
        return Past(np.concatenate(self._modes, axis=2), self._lasting.copy(), self._last)

    def put_back(self, past: Past) -> None:
        """Take up a memory that `past` returned, to the last bit."""
        for part, modes in zip(self._parts, self._modes, strict=True):
            modes[:] = past.modes[..., part.place]
        self._lasting[:], self._last = past.lasting, past.last

    def _exerted(self) -> Array:
        """Return the convolutions now but for a share that is left out, (k, rows, size)."""
        exerted = np.empty((len(self._kernels.lasting), *self._lasting.shape))
        for part, every in zip(self._parts, self._modes, strict=True):
            for row, modes in enumerate(every):
                lasting = self._lasting[row, part.place]
                self._kernels.exerted(modes, lasting, exerted[:, row, part.place])
        return exerted

    def _add(self, table: StepTable, amplitudes: Array) -> None:
        """Add the share of a rate at the end of a step to the memory."""
        for part, every, factors, scratch in self._with(table):
            for modes, row in zip(every, amplitudes[:, part.place], strict=True):
                modes += np.multiply(factors.end, row.astype(part.real, copy=False), out=scratch)
        self._lasting += table.half * amplitudes

    def _with(self, table: StepTable) -> Iterator[tuple[Part, Complex, Factors, Complex]]:
        """Return parts of the wavenumbers, with their numbers m, factors and room for products."""
        return zip(self._parts, self._modes, table.factors, self._scratch, strict=True)


def phi(z: Complex) -> tuple[Complex, Complex, Complex]:
    """Return e^z, (e^z - 1)/z and (e^z - 1 - z)/z^2, to rounding for all Re z <= 0."""
    grown, small = np.exp(z), np.abs(z) < 0.1
    large: Complex = np.where(small, 1.0, z)
    first = (grown - 1) / large
    second = (first - 1) / large
    # For |z| < 0.1 the quotients above cancel digits; this series is exact to rounding.
    least = z[small]
    series = np.zeros_like(least)
    for power in range(11, 1, -1):
        series = (1 + least * series) / power
    first[small], second[small] = 1 + least * series, series
    return grown, first, second
