"""The memory of the interface for past slip, as a short sum of exponentials.

The memory kernel h has the Laplace transform G(s) - 1 (`impedance`).  Near s = 0, G tends to
2 (1 - g^2)/s and 1/s, the static stiffness.  The remainder is approximated by poles in the left
half-plane, which turns the convolution over all the past into one recursion per pole (as for
non-reflecting boundaries: Alpert, Greengard & Hagstrom 2000).

The poles come from the AAA algorithm (Nakatsukasa, Sete & Trefethen 2018) with support points in
conjugate pairs, their residues from least squares.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from semianalytic.memory.impedance import Impedance
from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.errors import ComputationError

SAMPLES = 60
"""Points of the transform on each of five stretches; the fit is checked on four times as many."""
MOST_PAIRS = 60
"""Largest number of pairs of conjugate poles; the finest tolerance takes 45 poles."""
FAR_SAMPLE = 30.0
"""Largest s of samples, where 1.5/s^2, the tail of G - 1, is right to 0.1 % (nu = 1/3)."""


@dataclass(frozen=True, eq=False)
class Memory:
    """The memory kernel h(x) = static + Re sum residues exp(poles x), for 0 <= x <= horizon."""

    # one pole of each conjugate pair, with twice its residue, (m,) each
    poles: Complex
    residues: Complex
    # 1/(1 - nu) in plane, 1 in antiplane shear: traction of lasting slip over mu q / 2
    static: float
    horizon: float  # largest q c_t t for which the sum is made
    error: float  # largest error of the transform on Re s = 1/horizon over its largest value

    def __call__(self, x: Array) -> Array:
        """Return h at x = q c_t t >= 0, (n,)."""
        return self.static + (np.exp(np.multiply.outer(x, self.poles)) @ self.residues).real


@dataclass(frozen=True, eq=False)
class SharedMemory:
    """Kernels like `Memory` with the same poles: residues are (k, m), and static is (k,)."""

    poles: Complex
    residues: Complex
    static: Array
    horizon: float
    error: float


class KernelTransforms(Protocol):
    """Transforms of several kernels that have their branch points in common."""

    @property
    def branches(self) -> tuple[float, ...]:
        """Branch points and poles divided by i."""

    @property
    def direct(self) -> Array:
        """Limits at s = infinity, (k,)."""

    @property
    def static(self) -> Array:
        """Limits of s times the transforms at s = 0, (k,)."""

    @property
    def lasting(self) -> tuple[Complex, Complex]:
        """Known poles with Re s = 0 < Im s, (p,), and their residues, (k, p)."""

    def __call__(self, s: Complex) -> Complex:
        """Return the transforms without those poles at s (n,) with Re s > 0, (k, n)."""


@lru_cache(maxsize=32)
def fit_memory(impedance: Impedance, horizon: float, tolerance: float) -> Memory:
    """Fit poles and residues to the memory of an impedance up to q c_t t = `horizon`, cached.

    Raises ComputationError if the relative error of the transform stays above the tolerance.
    """
    static = impedance.static

    def remainder(s: Complex) -> Complex:
        # what is left of G - 1 without the static stiffness, bounded at s = 0
        return (impedance(s) - 1 - static / s)[None]

    poles, residues, error = _fitted(remainder, impedance.branches, horizon, tolerance)
    return Memory(poles, residues[0], static, horizon, error)


@lru_cache(maxsize=32)
def fit_shared(kernels: KernelTransforms, horizon: float, tolerance: float) -> SharedMemory:
    """Fit poles that kernels have in common, by set-valued AAA, and their residues; cached."""
    direct, static = kernels.direct[:, None], kernels.static[:, None]

    def remainder(s: Complex) -> Complex:
        return kernels(s) - direct - static / s

    sizes = np.abs(remainder(_samples(kernels.branches, horizon, SAMPLES))).max(axis=1)
    # Smaller kernels do not matter, and rounding of 1e-11 of the largest hides them.
    sizes = np.maximum(sizes, 1e-3 * sizes.max())[:, None]

    def relative(s: Complex) -> Complex:
        return remainder(s) / sizes

    poles, residues, error = _fitted(relative, kernels.branches, horizon, tolerance)
    waves, parts = kernels.lasting
    poles = np.concatenate([poles, waves])
    residues = np.concatenate([residues * sizes, 2 * parts], axis=1)
    return SharedMemory(poles, residues, kernels.static, horizon, error)


def _fitted(
    remainder: Callable[[Complex], Complex],
    branches: tuple[float, ...],
    horizon: float,
    tolerance: float,
) -> tuple[Complex, Complex, float]:
    """Return poles (m,), residues (k, m) and the error of a fit to functions of s, (k, n)."""
    s = _samples(branches, horizon, SAMPLES)
    values = remainder(s)
    poles = _poles(s, values, tolerance)
    residues = _residues(s, values, poles)
    # check at other points than those of the fit, four times as many
    check = _samples(branches, horizon, 4 * SAMPLES + 1)
    exact = remainder(check)
    error = float(np.abs(residues @ _columns(check, poles).T - exact).max() / np.abs(exact).max())
    if not error < 10 * tolerance:
        raise ComputationError(
            f"the memory of the interface could be fitted to {error:.1e} only, not to "
            f"{tolerance:.1e}; use a finer grid or a shorter run."
        )
    pairs, real = _split(poles)
    half = len(pairs)
    # r exp(z x) + conj = Re [2 r exp(z x)]: one of each pair is kept, with twice its residue
    twice = 2 * (residues[:, :half] + 1j * residues[:, half : 2 * half])
    kept = np.concatenate([twice, residues[:, 2 * half :] + 0j], axis=1)
    return np.concatenate([pairs, real + 0j]), kept, error


def _samples(branches: tuple[float, ...], horizon: float, count: int) -> Complex:
    """Return points on Re s = 1/horizon, dense near the branch points, (n,).

    On that line the inverse transform amplifies errors by exp(x/horizon) <= e at most, for all x up
    to the horizon.
    """
    near, last = 0.1 / horizon, max(branches)
    spread = np.geomspace(near, last, count)
    parts = [np.geomspace(near, max(FAR_SAMPLE, 3 * last), count)]
    parts += [branch + sign * spread for branch in branches for sign in (1, -1)]
    # Im s > 0 is enough: h is real, so the transform takes conjugate values at conjugate points
    return 1 / horizon + 1j * np.unique(np.maximum(np.abs(np.concatenate(parts)), near))


def _poles(s: Complex, values: Complex, tolerance: float) -> Complex:
    """Return the stable poles with Im >= 0 of approximations to values (k, n) at s (n,).

    By set-valued AAA: k functions share support points, in conjugate pairs, and weights.
    """
    from scipy.linalg import eigvals  # here, for `import semianalytic` is to be quick

    chosen: list[int] = []
    left = np.ones(len(s), dtype=bool)
    approximation = np.zeros(values.shape, dtype=complex)
    # Columns for each support point, at all points, are formed once.
    direct, mirrored = np.empty((2, len(s), MOST_PAIRS), dtype=complex)
    # Parts of weights (2), support points, parts of equations (2), functions, points.
    loewner = np.empty((2, MOST_PAIRS, 2, *values.shape))
    while True:
        errors = np.abs(values - approximation).max(axis=0)
        chosen.append(int(np.argmax(np.where(left, errors, -1.0))))
        left[chosen[-1]] = False
        support, at_support = s[chosen], values[:, chosen]
        last, count = len(chosen) - 1, len(chosen)
        # The support point itself has no row; 1 stands for its distance of 0.
        direct[:, last] = 1 / np.where(s == support[-1], 1.0, s - support[-1])
        mirrored[:, last] = 1 / (s - support[-1].conj())
        upper = (values - at_support[:, -1:]) * direct[:, last]
        lower = (values - at_support[:, -1:].conj()) * mirrored[:, last]
        # Weights w and conj(w) of a pair as two real unknowns: w U + conj(w) L =
        # Re w (U + L) + i Im w (U - L).
        for part, column in enumerate((upper + lower, 1j * (upper - lower))):
            loewner[part, last] = column.real, column.imag
        matrix = loewner[:, :count].compress(left, axis=-1).reshape(2 * count, -1).T
        # the weights are the last right singular vector; the triangle of a QR has the same one
        triangle = np.linalg.qr(matrix, "r")
        vector = np.linalg.svd(triangle)[2][-1]
        weights = vector[:count] + 1j * vector[count:]
        weighted = (weights * at_support).T
        seen, across = direct[left, :count], mirrored[left, :count]
        numerator = seen @ weighted + across @ weighted.conj()
        denominator = seen @ weights + across @ weights.conj()
        approximation[:, left] = numerator.T / denominator
        approximation[:, chosen] = at_support
        error = np.abs(values - approximation).max() / np.abs(values).max()
        if error < tolerance or count == MOST_PAIRS:
            break
    # The zeros of the denominator are the finite eigenvalues of an arrowhead pencil (Nakatsukasa,
    # Sete & Trefethen 2018, section 3.2); two are infinite.
    both = np.concatenate([support, support.conj()])
    pencil = np.diag(np.concatenate([[0], both]))
    pencil[0, 1:], pencil[1:, 0] = np.concatenate([weights, weights.conj()]), 1
    mass = np.eye(len(pencil))
    mass[0, 0] = 0
    poles: Complex = np.asarray(eigvals(pencil, mass), dtype=complex)
    poles = poles[np.isfinite(poles) & (np.abs(poles) < 100 * FAR_SAMPLE)]
    # poles with Re > 0 come from rounding, near a zero that cancels them: their residues vanish
    return poles[(poles.real < 0) & (poles.imag > -1e-8 * np.abs(poles))]


def _split(poles: Complex) -> tuple[Complex, Array]:
    """Separate the poles of conjugate pairs from the real poles."""
    real = poles.imag <= 1e-8 * np.abs(poles)
    return poles[~real], poles[real].real


def _columns(s: Complex, poles: Complex) -> Complex:
    """Return the matrix (n, unknowns) from residues to values of the transform at s.

    Unknowns are real, then imaginary parts of residues of pairs, then those of real poles.
    """
    pairs, real = _split(poles)
    upper, lower = 1 / (s[:, None] - pairs), 1 / (s[:, None] - pairs.conj())
    return np.hstack([upper + lower, 1j * (upper - lower), 1 / (s[:, None] - real)])


def _residues(s: Complex, values: Complex, poles: Complex) -> Array:
    """Return the residues that fit values (k, n) at s best, (k, unknowns) as in `_columns`."""
    columns = _columns(s, poles)
    matrix = np.vstack([columns.real, columns.imag])
    # columns of equal norm, so that `rcond` judges all poles alike
    scale = np.linalg.norm(matrix, axis=0)
    both = np.concatenate([values.real, values.imag], axis=1)
    return np.asarray(np.linalg.lstsq(matrix / scale, both.T, rcond=1e-13)[0].T / scale)
