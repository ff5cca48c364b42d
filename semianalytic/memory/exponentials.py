"""The memory of the interface for past slip, as a short sum of exponentials.

The memory kernel h has the Laplace transform G(s) - 1 (`impedance`).  Near s = 0, G tends to
2 (1 - g^2)/s and 1/s, the static stiffness.  The remainder is approximated by poles in the left
half-plane (`rational`), which turns the convolution over all the past into one recursion per pole
(as for non-reflecting boundaries: Alpert, Greengard & Hagstrom 2000).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from semianalytic.memory.impedance import Impedance
from semianalytic.memory.rational import SAMPLES, fitted, samples
from semianalytic.scene.arrays import Array, Complex


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

    poles, residues, error = fitted(remainder, impedance.branches, horizon, tolerance)
    return Memory(poles, residues[0], static, horizon, error)


@lru_cache(maxsize=32)
def fit_shared(kernels: KernelTransforms, horizon: float, tolerance: float) -> SharedMemory:
    """Fit poles that kernels have in common, by set-valued AAA, and their residues; cached."""
    direct, static = kernels.direct[:, None], kernels.static[:, None]

    def remainder(s: Complex) -> Complex:
        return kernels(s) - direct - static / s

    sizes = np.abs(remainder(samples(kernels.branches, horizon, SAMPLES))).max(axis=1)
    # Smaller kernels do not matter, and rounding of 1e-11 of the largest hides them.
    sizes = np.maximum(sizes, 1e-3 * sizes.max())[:, None]

    def relative(s: Complex) -> Complex:
        return remainder(s) / sizes

    poles, residues, error = fitted(relative, kernels.branches, horizon, tolerance)
    waves, parts = kernels.lasting
    poles = np.concatenate([poles, waves])
    residues = np.concatenate([residues * sizes, 2 * parts], axis=1)
    return SharedMemory(poles, residues, kernels.static, horizon, error)
