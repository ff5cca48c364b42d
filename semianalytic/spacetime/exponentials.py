"""The memory of the interface for past slip, as a short sum of exponentials.

A slip rate of wavenumber q exerts the traction -(rho c_t / 2) [V + int h(q c_t (t - s)) q c_t V ds]
(Geubelle & Rice 1995).  h has the Laplace transform G(s) - 1, where G is the impedance of a
half-plane (docs/theory.md, "Any load history") at slowness i/s.  With A = sqrt(g^2 s^2 + 1),
B = sqrt(s^2 + 1), g = c_t/c_l, it is

    G = [(s^2 + 2)^2 - 4 A B] / (s^3 B)   in plane (`InPlane`),
    G = B / s                             in antiplane shear (`Antiplane`), h = int J_1(x) / x dx.

An opening rate meets g G_in-plane B / A of the impedance rho c_l / 2 (`Opening`).

Near s = 0, G tends to 2 (1 - g^2)/s and 1/s, the static stiffness.  The remainder is approximated
by poles in the left half-plane, which turns the convolution over all the past into one recursion
per pole (as for non-reflecting boundaries: Alpert, Greengard & Hagstrom 2000).  The poles come from
the AAA algorithm (Nakatsukasa, Sete & Trefethen 2018) with support points in conjugate pairs, their
residues from least squares.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import ComputationError
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.tuning import (
    FAR_SAMPLE,
    LEAST_KERNEL,
    MOST_PAIRS,
    SAMPLES,
    SHORTEST_SAMPLE,
)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Memory:
    """The memory kernel h(x) = static + Re sum residues exp(poles x), for 0 <= x <= horizon.

    Attributes
    ----------
    poles, residues : (m,) complex arrays
        One pole of each conjugate pair, with twice its residue.
    static : float
        1/(1 - nu) in plane, 1 in antiplane shear: traction of lasting slip over mu q / 2.
    horizon : float
        Largest q c_t t for which the sum is made.
    error : float
        Largest error of the transform on Re s = 1/horizon over its largest value.
    """

    poles: Complex
    residues: Complex
    static: float
    horizon: float
    error: float

    def __call__(self, x: Array) -> Array:
        """Return h at x = q c_t t >= 0, (n,)."""
        return self.static + (np.exp(np.multiply.outer(x, self.poles)) @ self.residues).real


@dataclass(frozen=True, eq=False)
class SharedMemory:
    """Several memory kernels with the same poles, static + Re sum residues exp(poles x) each.

    Attributes
    ----------
    poles : (m,) complex array
        One pole of each conjugate pair.
    residues : (k, m) complex array
        Twice the residue of a pair, for every kernel.
    static : (k,) array
        Limits of the kernels for long times.
    horizon : float
        Largest q c_t t for which the sums are made.
    error : float
        Largest error of a transform on Re s = 1/horizon over its largest value.
    """

    poles: Complex
    residues: Complex
    static: Array
    horizon: float
    error: float


class Kernels(Protocol):
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


@dataclass(frozen=True)
class InPlane:
    """The impedance G of shear along x; speed_ratio = c_t/c_l, between 0 and sqrt(3)/2."""

    speed_ratio: float

    @property
    def static(self) -> float:
        """Limit of s G at s = 0, 2 (1 - c_t^2/c_l^2) = 1/(1 - nu)."""
        return 2 * (1 - self.speed_ratio**2)

    @property
    def branches(self) -> tuple[float, ...]:
        """Branch points of G divided by i: those of the shear wave and the pressure wave."""
        return 1.0, 1 / self.speed_ratio

    def __call__(self, s: Complex) -> Complex:
        """Return G(s) for Re s > 0, any shape; the numerator keeps all its digits."""
        g2, s2 = self.speed_ratio**2, s * s
        a, b = self.speed_ratio * _root(s, 1 / self.speed_ratio), _root(s, 1.0)
        # (s^2 + 2)^2 - 4 A B cancels as s -> 0.  Times (s^2 + 2)^2 + 4 A B it is s^2 times this
        # polynomial in s^2, in which nothing cancels.
        numerator = ((s2 + 8) * s2 + 24 - 16 * g2) * s2 + 16 * (1 - g2)
        return numerator / (s * b * ((s2 + 2) ** 2 + 4 * a * b))


@dataclass(frozen=True)
class Antiplane:
    """The impedance G of shear along z, the same for every solid."""

    static = 1.0
    branches = (1.0,)

    def __call__(self, s: Complex) -> Complex:
        """Return G(s) for Re s > 0, any shape."""
        return _root(s, 1.0) / s


@dataclass(frozen=True)
class Opening(InPlane):
    """The impedance of an opening rate, over rho c_l / 2: g [(s^2 + 2)^2 - 4 A B] / (s^3 A).

    It tends to 1 for fast changes, like that of shear over rho c_t / 2.
    """

    @property
    def static(self) -> float:
        """Limit of s G at s = 0, 2 g (1 - g^2)."""
        return self.speed_ratio * super().static

    def __call__(self, s: Complex) -> Complex:
        """Return G(s) for Re s > 0, any shape."""
        # A of the equation is g times the root here, which cancels the g before it
        return super().__call__(s) * _root(s, 1.0) / _root(s, 1 / self.speed_ratio)


Impedance = InPlane | Antiplane


def impedance_of(scene: Scene) -> Impedance:
    """Return the impedance that the shear of a scene meets, in plane or antiplane."""
    material = scene.material
    if scene.antiplane:
        return Antiplane()
    return InPlane(material.shear_speed / material.longitudinal_speed)


def _root(s: Complex, branch: float) -> Complex:
    """Return sqrt(s^2 + branch^2) with a positive real part, for Re s > 0."""
    # Each factor lies within 45 degrees of the real axis, so the product crosses no branch cut;
    # the principal root of the sum would.
    return np.asarray(np.sqrt(s - 1j * branch) * np.sqrt(s + 1j * branch))


@lru_cache(maxsize=32)
def fit_memory(impedance: Impedance, horizon: float, tolerance: float) -> Memory:
    """Fit poles and residues to the memory of an impedance; results are cached.

    Parameters
    ----------
    impedance : Impedance
        G of in-plane or antiplane shear.
    horizon : float
        Largest q c_t t that will be asked for.
    tolerance : float
        Relative error of the transform at which to stop.

    Raises
    ------
    ComputationError
        If the tolerance is not met.
    """
    static = impedance.static

    def remainder(s: Complex) -> Complex:
        # what is left of G - 1 without the static stiffness, bounded at s = 0
        return impedance(s) - 1 - static / s

    poles, residues, error = _fitted(
        lambda s: remainder(s)[None], impedance.branches, horizon, tolerance
    )
    return Memory(poles, residues[0], static, horizon, error)


@lru_cache(maxsize=32)
def fit_shared(kernels: Kernels, horizon: float, tolerance: float) -> SharedMemory:
    """Fit poles that several kernels have in common, and their residues; results are cached.

    Kernels are fitted relative to their own sizes, by set-valued AAA (one set of support points).

    Parameters
    ----------
    kernels : Kernels
        Transforms of the kernels.
    horizon : float
        Largest q c_t t that will be asked for.
    tolerance : float
        Relative error of the transforms at which to stop.

    Raises
    ------
    ComputationError
        If the tolerance is not met.
    """
    direct, static = kernels.direct[:, None], kernels.static[:, None]

    def remainder(s: Complex) -> Complex:
        return kernels(s) - direct - static / s

    sizes = np.abs(remainder(_samples(kernels.branches, horizon, SAMPLES))).max(axis=1)
    sizes = np.maximum(sizes, LEAST_KERNEL * sizes.max())[:, None]
    poles, residues, error = _fitted(
        lambda s: remainder(s) / sizes, kernels.branches, horizon, tolerance
    )
    waves, parts = kernels.lasting
    return SharedMemory(
        np.concatenate([poles, waves]),
        np.concatenate([residues * sizes, 2 * parts], axis=1),
        kernels.static,
        horizon,
        error,
    )


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
            f"{tolerance:.1e}; raise the tolerance or shorten the run."
        )
    pairs, real = _split(poles)
    half = len(pairs)
    # r exp(z x) + conj = Re [2 r exp(z x)]: one of each pair is kept, with twice its residue
    twice = 2 * (residues[:, :half] + 1j * residues[:, half : 2 * half])
    kept = np.concatenate([twice, residues[:, 2 * half :] + 0j], axis=1)
    return np.concatenate([pairs, real + 0j]), kept, error


def _samples(branches: tuple[float, ...], horizon: float, count: int) -> Complex:
    """Return points on Re s = 1/horizon, dense beside the branch points, (n,).

    On that line the inverse transform amplifies errors by exp(x/horizon) <= e at most, for all x up
    to the horizon.
    """
    near, last = SHORTEST_SAMPLE / horizon, max(branches)
    spread = np.geomspace(near, last, count)
    parts = [np.geomspace(near, max(FAR_SAMPLE, 3 * last), count)]
    parts += [branch + sign * spread for branch in branches for sign in (1, -1)]
    # Im s > 0 is enough: h is real, so the transform takes conjugate values at conjugate points
    return 1 / horizon + 1j * np.unique(np.maximum(np.abs(np.concatenate(parts)), near))


def _poles(s: Complex, values: Complex, tolerance: float) -> Complex:
    """Return the stable poles with Im >= 0 of rational approximations to values (k, n) at s (n,).

    By set-valued AAA: all k functions have the same support points and weights.  Support points
    come in conjugate pairs, which makes the approximation real on the real axis.
    """
    from scipy.linalg import eigvals  # here, for `import semianalytic` is to be quick

    chosen: list[int] = []
    left = np.ones(len(s), dtype=bool)
    approximation = np.zeros(values.shape, dtype=complex)
    while True:
        errors = np.abs(values - approximation).max(axis=0)
        chosen.append(int(np.argmax(np.where(left, errors, -1.0))))
        left[chosen[-1]] = False
        support, at_support = s[chosen], values[:, chosen]
        direct = 1 / (s[left, None] - support)
        mirrored = 1 / (s[left, None] - support.conj())
        differences = values[:, left, None] - at_support[:, None]
        upper = np.concatenate(list(differences * direct))
        differences = values[:, left, None] - at_support[:, None].conj()
        lower = np.concatenate(list(differences * mirrored))
        # Weights w and conj(w) of a pair as two real unknowns: w U + conj(w) L =
        # Re w (U + L) + i Im w (U - L).
        loewner = np.hstack([upper + lower, 1j * (upper - lower)])
        # the weights are the last right singular vector; the triangle of a QR has the same one
        triangle = np.linalg.qr(np.vstack([loewner.real, loewner.imag]), "r")
        last = np.linalg.svd(triangle)[2][-1]
        weights = last[: len(chosen)] + 1j * last[len(chosen) :]
        weighted = (weights * at_support).T
        numerator = direct @ weighted + mirrored @ weighted.conj()
        denominator = direct @ weights + mirrored @ weights.conj()
        approximation[:, left] = numerator.T / denominator
        approximation[:, chosen] = at_support
        error = np.abs(values - approximation).max() / np.abs(values).max()
        if error < tolerance or len(chosen) == MOST_PAIRS:
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
    # poles with Re > 0 come from rounding, beside a zero that cancels them: their residues vanish
    return poles[(poles.real < 0) & (poles.imag > -1e-8 * np.abs(poles))]


def _split(poles: Complex) -> tuple[Complex, Array]:
    """Separate the poles of conjugate pairs from the real poles."""
    real = poles.imag <= 1e-8 * np.abs(poles)
    return poles[~real], poles[real].real


def _columns(s: Complex, poles: Complex) -> Complex:
    """Return the matrix (n, unknowns) from residues to values of the transform at s.

    The unknowns are the real parts, then the imaginary parts of the residues of pairs, then the
    residues of real poles.
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
