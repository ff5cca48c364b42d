"""Central differences for one elastic body, in mass-normalised unknowns.

With s = sqrt(m) for the lumped masses, the unknowns are U = s u and the matrix is
A = dt^2 K / (s s^T), so that one step from t_n to t_{n+1} reads

    D <- D - A (U + (eta/dt) D) + forces,      U <- U + D,

D being the increment of U over a step, and every energy is a plain scalar product.  The
damping C = eta K acts on the velocity of the past half-step and costs no product of its own.

Energy.  Multiplying the first line by the mean of the increments before and after it shows
that the scheme conserves, without damping and between steps n and n+1,

    E = [ |D|^2 + U_n . A U_{n+1} ] / (2 dt^2),

and that every other force F_n at t_n does the work F_n . (d_{n-1/2} + d_{n+1/2})/2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import eigsh

from semianalytic.scene.arrays import Array


def normalised(stiffness: sparse.csr_array, mass: Array) -> tuple[sparse.csr_array, Array]:
    """Return the stiffness in mass-normalised unknowns, and the roots of their masses.

    The stiffness (m n, m n) has m components per node, the lumped masses are (n,).  The first
    result is K_ij / sqrt(m_i m_j) [1 / time^2], the second the root of the mass of every unknown (m
    n,).
    """
    components = stiffness.shape[0] // len(mass)
    root = np.sqrt(np.repeat(mass, components))
    indices, indptr = stiffness.indices, stiffness.indptr
    data = stiffness.data / root[indices]
    data /= np.repeat(root, np.diff(indptr))
    return sparse.csr_array((data, indices, indptr), shape=stiffness.shape), root


def highest_frequency(matrix: sparse.csr_array, tol: float = 1e-4) -> float:
    """Return the largest eigenfrequency omega [1 / time] of the mass-normalised stiffness.

    The Lanczos method approaches it from below; the relative tolerance is added, so that omega is
    not underestimated.  Clusters of high frequencies need a small one.
    """
    start = np.random.default_rng(0).standard_normal(matrix.shape[0])
    largest = eigsh(matrix, k=1, which="LA", v0=start, ncv=20, tol=tol, return_eigenvectors=False)
    return float(np.sqrt(largest[0] * (1 + tol)))


def critical_step(frequency: float, damping_time: float) -> float:
    """Return the largest stable time step, (2/omega) / (sqrt(1 + z^2) + z), z = eta omega / 2.

    omega is the largest eigenfrequency [1 / time], and eta that of the damping C = eta K, taken at
    the past half-step [time].
    """
    z = damping_time * frequency / 2
    return 2 / frequency / (float(np.hypot(1.0, z)) + z)


STRIP = 65536
"""Unknowns per pass: their values stay in the cache until all sums over them are taken."""


class BodyEnergy(NamedTuple):
    """Energies of a body, each times dt^2, in the middle of a step; the last is work."""

    kinetic: float
    strain: float
    damping: float


@dataclass
class MarchedBody:
    """An elastic body that marches in time.

    The nodes are in order of arrival: only the first `active` unknowns move, all others are
    still at rest, and the product takes only the leading rows of the matrix.  A lower body is
    described by its mirror image on y > 0.
    """

    # displacement components of a node, one unknown after the other: (0, 1) for x and y, (2,) for z
    components: tuple[int, ...]
    matrix: sparse.csr_array  # (n, n), A = dt^2 K / (s s^T); may be shared between bodies
    root: Array  # (n,) array: s, square roots of the masses of the unknowns
    damping: float  # eta / dt
    arrival: Array  # (nodes,) array: times from which the nodes may move, increasing [time]
    # (k,) arrays: unknowns of sides that are held, or absorb plane waves by dashpots; and their
    # z = c dt / (2 m), c being the dashpot of each [mass / time], inf if held
    sides: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    absorption: Array = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        unknowns = self.matrix.shape[0]
        self.displacement = np.zeros(unknowns)  # U at the time level reached
        # D over the step before this level and, once kicked, over the step after it
        self.before = np.zeros(unknowns)
        self.increment = np.zeros(unknowns)
        self.energy = BodyEnergy(0.0, 0.0, 0.0)  # in the middle of the step before, once kicked
        self.active = 0  # number of leading unknowns that move
        # what dashpots let pass of an impulse
        self.ease = np.ones(unknowns)
        self.ease[self.sides] = 1 / (1 + self.absorption)
        self._z = np.where(self.absorption < np.inf, self.absorption, 0.0)
        self._damped = np.zeros(unknowns)  # U + (eta/dt) D
        self._force: dict[int, Array] = {}  # of each strip, by its first unknown
        self._strips: list[tuple[slice, sparse.csr_array]] = []
        self._taken = 0.0  # (D of the past step) . force
        self._square = 0.0  # U . A U
        self._inside = 0.0  # work done against internal forces and dashpots

    def activate(self, time: float) -> None:
        """Let the unknowns move that do so by a time; strips of matrix rows are views."""
        nodes = int(np.searchsorted(self.arrival, time, side="right"))
        unknowns = len(self.components) * nodes
        if unknowns == self.active:
            return
        if self._strips and self._strips[-1][0].stop % STRIP:
            self._strips.pop()
        for start in range(STRIP * len(self._strips), unknowns, STRIP):
            rows = slice(start, min(start + STRIP, unknowns))
            self._strips.append((rows, _row_view(self.matrix, rows)))
        self.active = unknowns

    def kick(self) -> None:
        """Change the increment by internal forces and dashpots."""
        kinetic, now, taken = self._sum(self._kick_strip)
        # the strips wrote D - A (U + theta D) over the older increment; the two change their roles
        self.before, self.increment = self.increment, self.before
        self._taken = taken
        self._settle(kinetic, now, taken)
        if len(self.sides):
            resisted = self._z * self.before[self.sides]
            slowed = (self.increment[self.sides] - resisted) * self.ease[self.sides]
            self.increment[self.sides] = slowed

    def drift(self) -> None:
        """Move on to the next level, after the kick and all tractions."""
        if len(self.sides):
            twice = self.before[self.sides] + self.increment[self.sides]
            self._inside += float(self._z @ twice**2) / 2
        # a force at t_n does work on the mean of the increments before and after it
        self._inside += (self._taken + self._sum(self._drift_strip)[0]) / 2

    def _kick_strip(self, rows: slice, matrix: sparse.csr_array) -> tuple[float, ...]:
        """Kick some unknowns; return D . D, U . force and D . force over them."""
        increment = self.increment[rows]
        force = self._force[rows.start] = matrix @ self._damped
        np.subtract(increment, force, out=self.before[rows])
        displacement = self.displacement[rows]
        return _dot(increment, increment), _dot(displacement, force), _dot(increment, force)

    def _drift_strip(self, rows: slice, _: sparse.csr_array) -> tuple[float, ...]:
        """Drift some unknowns; return D . force over them."""
        increment, displacement = self.increment[rows], self.displacement[rows]
        damped = self._damped[rows]
        displacement += increment
        np.multiply(increment, self.damping, out=damped)
        # U + theta D for the next kick, formed while both are in the cache
        damped += displacement
        return (_dot(increment, self._force[rows.start]),)

    def _sum(self, work: Callable[[slice, sparse.csr_array], tuple[float, ...]]) -> list[float]:
        """Run a function on every strip and add up its results, always in the same order."""
        results = [work(rows, matrix) for rows, matrix in self._strips]
        return [sum(values) for values in zip(*results, strict=True)]

    def state(self) -> dict[str, Array]:
        """The state from which the march continues, after a drift; the arrays are not copies."""
        sums = np.array([self._square, self._inside])
        return {"displacement": self.displacement, "increment": self.increment, "sums": sums}

    def restore(self, state: Mapping[str, Array]) -> None:
        """Continue from the state of another body of the same model, to the last bit."""
        self.displacement[:], self.increment[:] = state["displacement"], state["increment"]
        self._square, self._inside = state["sums"].tolist()
        np.multiply(self.increment, self.damping, out=self._damped)
        self._damped += self.displacement

    def _settle(self, kinetic: float, now: float, taken: float) -> None:
        """Set the energy in the middle of the past step, from D . D, U_n . force and D . force.

        The strain energy U_n . A U_{n-1} comes from the damped product alone: with
        A (U_n + theta D) = (1 + theta) A U_n - theta A U_{n-1}, its products with U_n and
        U_{n-1} = U_n - D give U_n . A U_{n-1} and U_n . A U_n in turn.
        """
        # `_square` is U_{n-1} . A U_{n-1} before the assignment, U_n . A U_n after it
        theta = self.damping
        cross = (now - taken + theta * self._square) / (1 + theta)
        self._square = (now + theta * cross) / (1 + theta)
        self.energy = BodyEnergy(
            kinetic=kinetic / 2,
            strain=cross / 2,
            damping=self._inside - cross / 2,
        )


def _dot(vector: Array, other: Array) -> float:
    """Return a scalar product without BLAS, whose threads wait for one another when busy."""
    return float(np.einsum("i,i", vector, other))


def _row_view(matrix: sparse.csr_array, rows: slice) -> sparse.csr_array:
    """Return some rows of a CSR matrix that share its memory, except for their row pointers."""
    start, end = matrix.indptr[rows.start], matrix.indptr[rows.stop]
    return sparse.csr_array(
        (
            matrix.data[start:end],
            matrix.indices[start:end],
            matrix.indptr[rows.start : rows.stop + 1] - start,
        ),
        shape=(rows.stop - rows.start, matrix.shape[1]),
    )
