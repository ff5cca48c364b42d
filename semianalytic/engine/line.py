"""The line y = 0 with both half-planes: grid, transform along x, and memory of past slip.

The memory lives on the whole periodic line and knows nothing of contacts.  A slip rate V of
wavenumber q exerts -(mu / 2 c_t) [V + int h(q c_t (t - s)) q c_t V ds]; h is a sum of exponentials
(`memory.exponentials`).  V is linear over a step and the integrals over it are exact, so steps
may have any length.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.tuning import TABLES
from semianalytic.memory.cosines import cosines, from_cosines
from semianalytic.memory.exponentials import Memory, SharedMemory

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Grid:
    """Evenly spaced nodes on one period of the line, or on half of it if both halves are alike.

    Parameters
    ----------
    length : float
        Period of the line [length].
    nodes : int
        Nodes of the whole period, an even number.
    between : bool
        Whether x = 0 lies midway between two nodes, as edges of contacts do, or on a node.
    even : bool
        Whether all fields are even in x, so that x >= 0 is enough.
    held : float
        Wavenumber of the stiffness that mean slip meets [1 / length]; 0 for none.
    """

    length: float
    nodes: int
    between: bool = False
    even: bool = False
    held: float = 0.0

    @property
    def spacing(self) -> float:
        """Node distance h [length]."""
        return self.length / self.nodes

    @cached_property
    def x(self) -> Array:
        """Positions of nodes, (n,) [length]."""
        half, shift = self.nodes // 2, 0.5 if self.between else 0.0
        if self.even:
            return np.asarray(self.spacing * (np.arange(half + (not self.between)) + shift))
        return np.asarray(self.spacing * (np.arange(self.nodes) - half + shift))

    @cached_property
    def wavenumbers(self) -> Array:
        """Wavenumbers of the amplitudes, (m,) [1 / length]."""
        count = len(self.x) if self.even else self.nodes // 2 + 1
        q = 2 * np.pi / self.length * np.arange(count)
        q[0] = self.held
        return np.asarray(q)

    def amplitudes(self, values: Array) -> Array:
        """Return the amplitudes of waves along x, real (rows, m)."""
        from scipy.fft import rfft  # imported late, which keeps `import semianalytic` fast

        if self.even:
            even = np.empty((1, len(values)))
            cosines(values, even[0], 2 if self.between else 1)
            return even
        lines = rfft(values)
        return np.stack([lines.real, lines.imag])

    def values(self, amplitudes: Array) -> Array:
        """Return the values at nodes (n,) of amplitudes (rows, m)."""
        from scipy.fft import irfft

        if self.even:
            even = np.empty(amplitudes.shape[1])
            from_cosines(amplitudes[0], even, 2 if self.between else 1)
            return even
        return np.asarray(irfft(amplitudes[0] + 1j * amplitudes[1], n=self.nodes))


@dataclass(frozen=True, eq=False)
class Table:
    """Factors by which a step of one length changes the memory, per pole and wavenumber.

    Attributes
    ----------
    decay, gain, end : (poles, 1, m) complex arrays
        Factor on the memory, on the rate at the beginning and on the rate at the end of the step.
    half : (m,) array
        Factor on the rates at both ends of the step in the static part of the memory.
    feedback : (m,) array
        Contribution of a unit rate at the end of the step to the convolution.
    """

    decay: Complex
    gain: Complex
    end: Complex
    half: Array
    feedback: Array

    @classmethod
    def of(cls, memory: Memory, phase: Array) -> Table:
        """Make the table for steps of q c_t dt = phase, (m,)."""
        z = np.multiply.outer(memory.poles, phase)
        first, second = _phi(z)
        weight = np.multiply.outer(memory.residues, phase)
        decay, end = np.exp(z), weight * second
        # The rate at the beginning ended the step before, which left its share out of the memory.
        gain = weight * (first - second) + decay * end
        half = memory.static * phase / 2
        feedback = end.real.sum(axis=0) + half
        return cls(decay[:, None], gain[:, None], end[:, None], half, feedback)


class LineMemory:
    """The memory of past slip on a grid, carried over steps of any length.

    Attributes
    ----------
    modes : (poles, rows, m) complex array
        Convolutions with the exponentials, without the share of the newest rate.
    lasting : (rows, m) array
        Convolution with the static part of the kernel, without the share of the newest rate.
    last : float
        c_t times the length of the last step [length]; 0 before the first.
    """

    def __init__(self, memory: Memory, grid: Grid) -> None:
        rows, count = 1 if grid.even else 2, len(grid.wavenumbers)
        self.memory, self._q = memory, grid.wavenumbers
        self.modes = np.zeros((len(memory.poles), rows, count), dtype=complex)
        self.lasting = np.zeros((rows, count))
        self.last = 0.0
        self._scratch = np.empty_like(self.modes)
        self._tables: OrderedDict[float, Table] = OrderedDict()

    def table(self, step: float) -> Table:
        """Return the table of steps c_t dt [length]; the latest ones are kept."""
        if step not in self._tables:
            self._tables[step] = Table.of(self.memory, self._q * step)
            if len(self._tables) > TABLES:
                self._tables.popitem(last=False)
        self._tables.move_to_end(step)
        return self._tables[step]

    def advance(self, amplitudes: Array, step: float) -> tuple[Array, Array]:
        """Step on; return the convolution without the end rate (rows, m), and the feedback (m,).

        Parameters
        ----------
        amplitudes : (rows, m) array
            Amplitudes of the rate at the beginning of the step.
        step : float
            c_t dt [length].
        """
        table = self.move(amplitudes, step)
        return self.modes.real.sum(axis=0) + self.lasting, table.feedback

    def move(self, amplitudes: Array, step: float) -> Table:
        """Step on, with the rate at the beginning of the step; return the table of the step."""
        table = self.table(step)
        if self.last != step:
            # The memory lacks the share of the newest rate as the table of the last step had it;
            # the table of this step has another share, which `gain` adds below.
            before = self.table(self.last) if self.last else None
            if before is not None:
                self.modes += before.end * amplitudes
                self.lasting += before.half * amplitudes
            self.modes -= table.end * amplitudes
            self.lasting -= table.half * amplitudes
            self.last = step
        self.modes *= table.decay
        np.multiply(table.gain, amplitudes, out=self._scratch)
        self.modes += self._scratch
        self.lasting += 2 * table.half * amplitudes
        return table

    def kept(self) -> tuple[Complex, Array, float]:
        """Return copies of what a step changes, for `put_back`."""
        return self.modes.copy(), self.lasting.copy(), self.last

    def put_back(self, kept: tuple[Complex, Array, float]) -> None:
        """Undo the steps since `kept` was called."""
        self.modes, self.lasting, self.last = kept

    def convolution(self, amplitudes: Array) -> Array:
        """Return the convolution now (rows, m), with the newest rate's amplitudes (rows, m)."""
        held = self.modes.real.sum(axis=0) + self.lasting
        if self.last:
            held = held + self.table(self.last).feedback * amplitudes
        return np.asarray(held)

    def exchange(self, change: Array) -> None:
        """Change the newest rate by amplitudes (rows, m), with the convolution as it is."""
        # The memory lacks the share of the newest rate, which the next step adds from the rate; a
        # jump changes that rate, so the share that is missing has to change with it.
        if self.last:
            table = self.table(self.last)
            self.modes -= table.end * change
            self.lasting -= table.half * change


class CoupledMemory(LineMemory):
    """The memory of slip, or opening, of different bodies, which exert two tractions each.

    Slip changes the pressure between bodies that differ, and opening the shear traction,

        tau = tau_0 - Z_V [V + h_s * V] + i sgn(q) Z_U h_p * U,
        p   = p_0   + Z_U [U + h_n * U] + i sgn(q) Z_V h_q * V,

    with Z_V, Z_U the impedances of plane waves; nothing of the coupling is at once
    (`dissimilar.kernels`).
    `advance` and `convolution` return both kernels, (2, rows, m), and feedback is (2, m).

    Parameters
    ----------
    fit : SharedMemory
        Sums of exponentials of Z_s, Z_n and H.
    own : int
        0 for slip, whose own kernel is Z_s; 1 for opening, whose own is Z_n.
    direct : float
        Z_V or Z_U over the unit of the kernels.
    grid : Grid
        Nodes.
    """

    def __init__(self, fit: SharedMemory, own: int, direct: float, grid: Grid) -> None:
        super().__init__(
            Memory(fit.poles, np.ones_like(fit.poles), 1.0, fit.horizon, fit.error), grid
        )
        self._residues = fit.residues[[own, 2]] / direct
        self._static = fit.static[[own, 2]] / direct
        self._shares: tuple[float, Array] = (0.0, np.zeros((2, 1)))

    def advance(self, amplitudes: Array, step: float) -> tuple[Array, Array]:
        """Step on; see `LineMemory.advance`."""
        self.move(amplitudes, step)
        return self._held(), self._feedback()

    def convolution(self, amplitudes: Array) -> Array:
        """Return both convolutions now, with the newest rate's amplitudes (rows, m)."""
        held = self._held()
        return held + self._feedback()[:, None] * amplitudes if self.last else held

    def _held(self) -> Array:
        modes = np.tensordot(self._residues, self.modes, 1).real
        return np.asarray(modes + np.multiply.outer(self._static, self.lasting))

    def _feedback(self) -> Array:
        if self._shares[0] != self.last:
            table = self.table(self.last)
            ends = (self._residues @ table.end[:, 0]).real
            self._shares = self.last, ends + np.multiply.outer(self._static, table.half)
        return self._shares[1]


def _phi(z: Complex) -> tuple[Complex, Complex]:
    """Return (e^z - 1)/z and (e^z - 1 - z)/z^2, to rounding for all Re z <= 0."""
    small = np.abs(z) < 0.1
    large = np.where(small, 1.0, z)
    first = (np.exp(large) - 1) / large
    second = (first - 1) / large
    # For |z| < 0.1 the quotients above cancel digits; this series is exact to rounding.
    series = np.zeros_like(z)
    for power in range(11, 1, -1):
        series = (1 + z * series) / power
    return np.where(small, 1 + z * series, first), np.where(small, series, second)
