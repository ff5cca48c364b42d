"""P wave and S wave that surface tractions of one slowness send into the upper body.

A shear traction of transform T = M S, or a change of sigma_yy of transform N = M^I U, gives
velocities and stresses (1/pi) Im [F_P(k_P) + F_S(k_S)], F = int (density) dk, from two densities
alone, those of v_x in either wave:

    P_v = -2 k S  or  (q / alpha) U,        S_v = -(q / k) S  or  -2 beta U,

            v_y                sigma_xx                        sigma_yy        sigma_xy
    P   -(alpha / k) P_v   (1 - 2 a^2 + 2 k^2) / k P_v    (q / k) P_v    -2 alpha P_v
    S   (k / beta) S_v     2 k S_v                        -2 k S_v       -(q / beta) S_v

(b = mu = 1, alpha = (a^2 - k^2)^1/2, beta = (1 - k^2)^1/2, q = 1 - 2 k^2).  Both together move the
surface at the rates V_x = k (P_v + S_v) and V_y = k^2 S_v / beta - alpha P_v, so that

    P_v = (k V_x - beta V_y) / (alpha beta + k^2),
    S_v = beta (V_y + alpha V_x / k) / (alpha beta + k^2)

whatever the tractions are that move it.  Displacement takes the
same densities with the phase t + k x - alpha y, t + k x - beta y as a factor.  Next to the edge,
where k is large, the two waves nearly cancel; their sums are formed without that cancellation.  In
antiplane shear there is one wave, of v_z = -S / k, sigma_xz = -S and sigma_yz = T / k.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.halfplane.rayleigh import Mode, RayleighFactors
from semianalytic.scene.arrays import Complex

SHEAR = 0
"""Row of `densities` that holds S_v."""
P_WAVE = slice(1, 6)
"""Rows that hold P_v times 1, k, 1 / k, alpha and alpha / k, the densities of a P wave."""
S_WAVE = slice(6, 11)
"""Rows that hold S_v times 1, k, k / beta, 1 / beta and k^2 / beta."""
SUMS = slice(11, 20)
"""Rows that hold sums of both waves: v_x, v_y, sigma_xx, sigma_yy, sigma_xy; k v_x, k v_y; and v_x,
v_y with the factors alpha and beta."""


@dataclass(frozen=True)
class Slowness:
    """Points k of the upper half-plane, with k + a, k + b, k + c, and k - a, k - b, k - c."""

    factors: RayleighFactors
    k: Complex
    from_left: Complex
    from_right: Complex

    @cached_property
    def alpha(self) -> Complex:
        """The root (a^2 - k^2)^1/2, with its sign in the upper half-plane."""
        return -1j * np.sqrt(self.from_left[0]) * np.sqrt(self.from_right[0])

    @cached_property
    def beta(self) -> Complex:
        """The root (1 - k^2)^1/2, with its sign in the upper half-plane."""
        return -1j * np.sqrt(self.from_left[1]) * np.sqrt(self.from_right[1])

    @cached_property
    def bulk(self) -> Complex:
        """The function alpha beta + k^2, without cancellation; it has no zero."""
        z, product, a = np.square(self.k), self.alpha * self.beta, self.factors.a
        direct, difference = product + z, product - z
        cancels = np.abs(direct) < np.abs(difference)
        rest = a * a - z * (1 + a * a)
        return np.where(cancels, rest / np.where(cancels, difference, 1.0), direct)

    @cached_property
    def coupling(self) -> Complex:
        """The function 2 alpha beta - q, without cancellation for large k."""
        z, square = np.square(self.k), self.factors.a**2
        # (2 alpha beta)^2 - q^2 = 4 a^2 - 1 - 4 a^2 k^2, over the sum, in which nothing cancels.
        return (4 * square - 1 - 4 * square * z) / (2 * self.alpha * self.beta + self.q)

    @cached_property
    def q(self) -> Complex:
        """The polynomial 1 - 2 k^2."""
        return 1 - 2 * np.square(self.k)

    @cached_property
    def rayleigh(self) -> Complex:
        """The Rayleigh function R(k), without cancellation near c and for large k."""
        z, product = np.square(self.k), 4 * np.square(self.k) * self.alpha * self.beta
        square = np.square(self.q)
        direct, conjugate = square + product, square - product
        e1, e0 = self.factors.in_plane._spurious_roots
        over = -self.from_left[2] * self.from_right[2] * (z * (z + e1) + e0)
        lead = 16 * (1 - self.factors.a**2)
        # R R* is a cubic in k^2 with the root c^2: where R cancels, it is that cubic over R*.
        rational = np.abs(conjugate) > np.abs(direct)
        return np.where(rational, lead * over / np.where(rational, conjugate, 1.0), direct)

    def impedance(self, mode: Mode) -> Complex:
        """Return the impedance M(k)."""
        if mode == "III":
            return self.beta
        return self.rayleigh / (self.beta if mode == "II" else self.alpha)


def densities(at: Slowness, transform: Complex, mode: Mode) -> Complex:
    """Return all densities, (20, ...) or in antiplane shear (3, ...), from the transform T or N.

    The table in the module's docstring gives them.
    """
    k, rate, none = at.k, transform / at.impedance(mode), np.zeros_like(transform)
    if mode == "III":
        return np.stack([-rate / k, -rate, transform / k])
    coupling = at.coupling
    if mode == "II":
        return radiated(at, (-rate, k * coupling / at.beta * rate), (transform, none))
    return radiated(at, (-k * coupling / at.alpha * rate, -rate), (none, transform))


def radiated(
    at: Slowness, motion: tuple[Complex, Complex], tractions: tuple[Complex, Complex]
) -> Complex:
    """Return densities (20, ...) from transforms of rates and traction changes of the surface."""
    k, alpha, beta, bulk, a = at.k, at.alpha, at.beta, at.bulk, at.factors.a
    (v_x, v_y), z = motion, np.square(k)
    # Two equations, V_x and V_y of the surface, solved for the amplitudes of the two waves.
    compression = (k * v_x - beta * v_y) / bulk
    shear = beta * (v_y + alpha * v_x / k) / bulk
    along, across, shearing, press = (part / k for part in (*motion, *tractions))
    difference = (a * a - 1) / (alpha + beta)  # alpha - beta
    sums = [along, across, 4 * (1 - a * a) * v_x + (1 - 2 * a * a) * press, press, shearing]
    sums += [v_x, v_y, (alpha * along - beta * difference * v_y) / bulk]
    sums.append((a * a * beta * across - alpha * difference * v_x) / bulk)
    of_p = [compression * factor for factor in (1, k, 1 / k, alpha, alpha / k)]
    of_s = [shear * factor for factor in (1, k, k / beta, 1 / beta, z / beta)]
    return np.stack([shear, *of_p, *of_s, *sums])


def reflected_wave(factors: RayleighFactors, mode: Mode, load: float, slowness: float) -> Complex:
    """Return i pi times the plane wave of a load of slowness p, |p| < a, from the pole at -p."""
    k = np.array([-slowness + 0j])
    fronts = np.array([[factors.a], [1.0], [factors.in_plane.c]])
    at = Slowness(factors, k, k + fronts, k - fronts)
    result = 1j * np.pi * densities(at, np.array([-slowness * load + 0j]), mode)[:, 0]
    if mode != "III":
        # This row is kept as a density, so that it has no integral to change.
        result[SHEAR] = 0.0
    return result


def plane_wave(transform: float, mode: Mode, a: float) -> Complex:
    """Return the change of all integrals past the pole at 0, from k > 0 to k < 0.

    It is i pi times the plane wave of a traction that changes everywhere by `transform` = T(0).
    """
    if mode == "III":
        return 1j * np.pi * transform * np.array([-1, 0, 1])
    result = np.zeros(20, dtype=complex)
    if mode == "II":
        result[S_WAVE] = -1, 0, 0, -1, 0
        result[SUMS] = -1, 0, 0, 0, 1, 0, 0, -1, 0
    else:
        result[P_WAVE] = 0, 0, 1, 0, a
        result[SUMS] = 0, -a, 1 - 2 * a * a, 1, 0, 0, 0, 0, -a * a
    return 1j * np.pi * transform * result
