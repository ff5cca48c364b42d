"""What the interface remembers of past slip, as a short sum of exponentials.

A slip rate of wavenumber q leaves the traction -(rho c_t / 2) [V + int h(q c_t (t - s)) q c_t V ds]
behind (Geubelle & Rice 1995); h has the Laplace transform G(s) - 1, and G is the impedance of a
half-plane (theory (4.40) in mode II) at slowness i/s.  With A = sqrt(g^2 s^2 + 1),
B = sqrt(s^2 + 1), g = c_t/c_l, it is

    G = [(s^2 + 2)^2 - 4 A B] / (s^3 B)   in plane (`InPlane`),
    G = B / s                             in antiplane shear (`Antiplane`), h = int J_1(x) / x dx.

Near s = 0 that is 2 (1 - g^2)/s and 1/s, the static stiffness; the rest is approximated by poles
in the left half-plane, which turns the convolution over all the past into one recursion per pole
(as for non-reflecting boundaries: Alpert, Greengard & Hagstrom 2000).  The poles come from the AAA
algorithm (Nakatsukasa, Sete & Trefethen 2018) with support points in conjugate pairs, their
residues from least squares.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import ComputationError
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.tuning import (
    FAR_SAMPLE,
    MOST_PAIRS,
    SAMPLES,
    SHORTEST_SAMPLE,
)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Memory:
    """h(x) = static + Re sum residues exp(poles x), for 0 <= x <= horizon.

    Attributes
    ----------
    poles, residues : (m,) complex arrays
        One of each conjugate pair, with twice its residue.
    static : float
        1/(1 - nu) in plane, 1 in antiplane shear: traction of lasting slip over mu q / 2.
    horizon : float
        Largest q c_t t the sum is made for.
    error : float
        Largest error of the transform on Re s = 1/horizon over its largest value.
    """

    poles: Complex
    residues: Complex
    static: float
    horizon: float
    error: float

    def __call__(self, x: Array) -> Array:
        """h at x = q c_t t >= 0, (n,)."""
        return self.static + (np.exp(np.multiply.outer(x, self.poles)) @ self.residues).real


@dataclass(frozen=True)
class InPlane:
    """G of shear along x; speed_ratio = c_t/c_l, between 0 and sqrt(3)/2."""

    speed_ratio: float

    @property
    def static(self) -> float:
        """s G at s = 0, 2 (1 - c_t^2/c_l^2) = 1/(1 - nu)."""
        return 2 * (1 - self.speed_ratio**2)

    @property
    def branches(self) -> tuple[float, ...]:
        """Branch points of G over i, the shear wave and the pressure wave."""
        return 1.0, 1 / self.speed_ratio

    def __call__(self, s: Complex) -> Complex:
        """G(s) for Re s > 0, any shape; the numerator keeps all its digits."""
        g2, s2 = self.speed_ratio**2, s * s
        a, b = self.speed_ratio * _root(s, 1 / self.speed_ratio), _root(s, 1.0)
        numerator = ((s2 + 8) * s2 + 24 - 16 * g2) * s2 + 16 * (1 - g2)
        return numerator / (s * b * ((s2 + 2) ** 2 + 4 * a * b))


@dataclass(frozen=True)
class Antiplane:
    """G of shear along z, the same for every solid."""

    static = 1.0
    branches = (1.0,)

    def __call__(self, s: Complex) -> Complex:
        """G(s) for Re s > 0, any shape."""
        return _root(s, 1.0) / s


Impedance = InPlane | Antiplane


def impedance_of(scene: Scene) -> Impedance:
    """What the shear of a scene meets."""
    material = scene.material
    if scene.antiplane:
        return Antiplane()
    return InPlane(material.shear_speed / material.longitudinal_speed)


def _root(s: Complex, branch: float) -> Complex:
    """sqrt(s^2 + branch^2), Re > 0."""
    return np.asarray(np.sqrt(s - 1j * branch) * np.sqrt(s + 1j * branch))


@lru_cache(maxsize=32)
def fit_memory(impedance: Impedance, horizon: float, tolerance: float) -> Memory:
    """Poles and residues for an impedance, kept.

    Parameters
    ----------
    impedance : Impedance
    horizon : float
        Largest q c_t t that will be asked for.
    tolerance : float
        Relative error of the transform to stop at.

    Raises
    ------
    ComputationError
        If the tolerance is not met.
    """
    static = impedance.static

    def remainder(s: Complex) -> Complex:
        return impedance(s) - 1 - static / s

    s = _samples(impedance.branches, horizon, SAMPLES)
    poles = _poles(s, remainder(s), tolerance)
    residues = _residues(s, remainder(s), poles)
    check = _samples(impedance.branches, horizon, 4 * SAMPLES + 1)
    exact = remainder(check)
    error = float(np.abs(_columns(check, poles) @ residues - exact).max() / np.abs(exact).max())
    if not error < 10 * tolerance:
        raise ComputationError(
            f"the memory of the interface could be fitted to {error:.1e} only, not to "
            f"{tolerance:.1e}; raise the tolerance or shorten the run."
        )
    pairs, real = _split(poles)
    half = len(pairs)
    twice = 2 * (residues[:half] + 1j * residues[half : 2 * half])
    return Memory(
        np.concatenate([pairs, real + 0j]),
        np.concatenate([twice, residues[2 * half :] + 0j]),
        static,
        horizon,
        error,
    )


def _samples(branches: tuple[float, ...], horizon: float, count: int) -> Complex:
    """Points on Re s = 1/horizon, dense beside the branch points over i, (n,)."""
    near, last = SHORTEST_SAMPLE / horizon, max(branches)
    spread = np.geomspace(near, last, count)
    parts = [np.geomspace(near, max(FAR_SAMPLE, 3 * last), count)]
    parts += [branch + sign * spread for branch in branches for sign in (1, -1)]
    return 1 / horizon + 1j * np.unique(np.maximum(np.abs(np.concatenate(parts)), near))


def _poles(s: Complex, values: Complex, tolerance: float) -> Complex:
    """Stable poles with Im >= 0 of a rational function through values at s and conjugates."""
    from scipy.linalg import eigvals  # here, for `import semianalytic` is to be quick

    chosen: list[int] = []
    left = np.ones(len(s), dtype=bool)
    approximation = np.zeros(len(s), dtype=complex)
    while True:
        chosen.append(int(np.argmax(np.where(left, np.abs(values - approximation), -1.0))))
        left[chosen[-1]] = False
        support, at_support = s[chosen], values[chosen]
        direct = 1 / (s[left, None] - support)
        mirrored = 1 / (s[left, None] - support.conj())
        upper = (values[left, None] - at_support) * direct
        lower = (values[left, None] - at_support.conj()) * mirrored
        loewner = np.hstack([upper + lower, 1j * (upper - lower)])
        triangle = np.linalg.qr(np.vstack([loewner.real, loewner.imag]), "r")
        last = np.linalg.svd(triangle)[2][-1]
        weights = last[: len(chosen)] + 1j * last[len(chosen) :]
        numerator = direct @ (weights * at_support) + mirrored @ (weights * at_support).conj()
        approximation[left] = numerator / (direct @ weights + mirrored @ weights.conj())
        approximation[chosen] = at_support
        error = np.abs(values - approximation).max() / np.abs(values).max()
        if error < tolerance or len(chosen) == MOST_PAIRS:
            break
    # the denominator's zeros are the eigenvalues of an arrowhead pencil
    both = np.concatenate([support, support.conj()])
    pencil = np.diag(np.concatenate([[0], both]))
    pencil[0, 1:], pencil[1:, 0] = np.concatenate([weights, weights.conj()]), 1
    mass = np.eye(len(pencil))
    mass[0, 0] = 0
    poles: Complex = np.asarray(eigvals(pencil, mass), dtype=complex)
    poles = poles[np.isfinite(poles) & (np.abs(poles) < 100 * FAR_SAMPLE)]
    # poles to the right are doublets of rounding: their residues are nothing
    return poles[(poles.real < 0) & (poles.imag > -1e-8 * np.abs(poles))]


def _split(poles: Complex) -> tuple[Complex, Array]:
    """Poles of conjugate pairs, and real poles."""
    real = poles.imag <= 1e-8 * np.abs(poles)
    return poles[~real], poles[real].real


def _columns(s: Complex, poles: Complex) -> Complex:
    """What residues (real parts, imaginary parts, real poles) multiply at s, (n, unknowns)."""
    pairs, real = _split(poles)
    upper, lower = 1 / (s[:, None] - pairs), 1 / (s[:, None] - pairs.conj())
    return np.hstack([upper + lower, 1j * (upper - lower), 1 / (s[:, None] - real)])


def _residues(s: Complex, values: Complex, poles: Complex) -> Array:
    columns = _columns(s, poles)
    matrix = np.vstack([columns.real, columns.imag])
    scale = np.linalg.norm(matrix, axis=0)
    both = np.concatenate([values.real, values.imag])
    return np.asarray(np.linalg.lstsq(matrix / scale, both, rcond=1e-13)[0] / scale)
