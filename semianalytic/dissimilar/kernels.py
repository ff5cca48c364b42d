"""Tractions between two different half-planes for their relative slip and opening rates.

With the compliance C of both bodies (`dissimilar.compliance`), rates of slip V and opening U, both
upper minus lower, exert [tau, sigma] = -C^-1 [V, U].  Only relative rates are needed, since both
faces carry the same tractions wherever they touch, part or are loaded.  With k = i b / s,
s = lambda / (q c_t),

    tau = -rho c_t [Z_s V - i sgn(q) H U],   p = rho c_t [Z_n U + i sgn(q) H V],
    Z_s = A / Delta,   Z_n = B / Delta,   H = k D / (i Delta),   Delta = A B + k^2 D^2,

which tend to the impedances of plane waves, 1/B and 1/A, and 0 for fast changes, and are static
stiffnesses over s for slow ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.compliance import Compliance, compliance_of
from semianalytic.dissimilar.thresholds import stoneley_speed
from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.material import Material
from semianalytic.scene.scene import Scene


@dataclass(frozen=True)
class PairImpedance:
    """Z_s, Z_n and H of two half-planes, in units of rho c_t and c_t of the first, on y > 0."""

    first: Material
    second: Material

    @cached_property
    def compliance(self) -> Compliance:
        """Compliance in units of the first solid."""
        return compliance_of(self.first, self.second)

    @property
    def direct(self) -> Array:
        """Limits at s = infinity: impedances of plane waves, and 0, (3,)."""
        # B and A of plane waves, k = 0: the sums of 1 / (rho c) of both bodies.
        slow = sum(body.b / body.modulus * body.b**-2 for body in self.compliance.bodies)
        fast = sum(body.a / body.modulus * body.b**-2 for body in self.compliance.bodies)
        return np.array([1 / slow, 1 / fast, 0.0])

    @property
    def static(self) -> Array:
        """Limits of s times the kernels at s = 0, (3,)."""
        soft, beta = self.compliance.static, self.compliance.dundurs
        # The inverse of the static compliance a_inf [[1, i beta], [-i beta, 1]] / |k|.
        return np.array([1.0, 1.0, beta]) / (soft * (1 - beta**2))

    @cached_property
    def branches(self) -> tuple[float, ...]:
        """Branch points over i: speeds of the body waves, nearly equal ones once."""
        speeds = np.sort(1 / self.compliance.fronts)
        # Next to nearer fronts samples differ by rounding alone.
        apart = np.diff(speeds, prepend=0.0) > 1e-8 * speeds
        return tuple(speeds[apart].tolist())

    def __call__(self, s: Complex) -> Complex:
        """Return Z_s, Z_n and H at s (n,) with Re s > 0, without the Stoneley wave, (3, n)."""
        poles, residues = self.lasting
        waves, mirrored = (1 / (s - pole[:, None]) for pole in (poles, poles.conj()))
        return np.asarray(self.at(s) - (residues @ waves + residues.conj() @ mirrored))

    def at(self, s: NDArray[np.complexfloating]) -> Complex:
        """Return Z_s, Z_n and H at s (n,) with Re s > 0, (3, n)."""
        entries = self.compliance.at(1j / s)
        kernels = np.stack([entries.normal, entries.tangential, entries.coupling / 1j])
        return np.asarray(kernels / entries.determinant)

    @cached_property
    def lasting(self) -> tuple[Complex, Complex]:
        """Poles i v of the Stoneley wave, (0,) or (1,), and the residues of the kernels, (3, .)."""
        speed = stoneley_speed(self.compliance)
        if speed is None:
            return np.zeros(0, dtype=complex), np.zeros((3, 0), dtype=complex)
        # The kernels are analytic near the pole; from the right, where they are defined,
        # e K = r + c e + ..., of which two e leave an error of e^2.
        near = 1e-5 * np.array([1.0, 2.0])  # off by its square, and by rounding over it
        once, twice = (self.at(1j * speed + near) * near).T
        return np.array([1j * speed]), (2 * once - twice)[:, None]


@dataclass(frozen=True, eq=False)
class BodyPair:
    """Two half-planes in the units of one of them.

    The unit is the body with the slower shear wave, whichever is above, so that the two give the
    same answer to rounding when they change places.

    Parameters
    ----------
    upper, lower : Material
        The solids on y > 0 and y < 0.
    """

    upper: Material
    lower: Material

    @cached_property
    def _ordered(self) -> tuple[Material, Material]:
        def key(body: Material) -> tuple[float, ...]:
            return body.shear_speed, body.density, body.poisson_ratio

        first, second = sorted((self.upper, self.lower), key=key)
        return first, second

    @property
    def sense(self) -> int:
        """1 if the unit is the upper body, or -1: the coupling has the other sign then."""
        return 1 if self._ordered[0] == self.upper else -1

    @cached_property
    def kernels(self) -> PairImpedance:
        """Kernels in the units of the first body."""
        return PairImpedance(*self._ordered)

    @property
    def speed(self) -> float:
        """c_t of the unit [length / time]."""
        return self._ordered[0].shear_speed

    @property
    def unit_impedance(self) -> float:
        """rho c_t of the unit [stress time / length]."""
        return self._ordered[0].shear_impedance

    @property
    def impedances(self) -> tuple[float, float]:
        """Z_V and Z_U [stress time / length]."""
        shear, normal, _ = self.unit_impedance * self.kernels.direct
        return float(shear), float(normal)

    @property
    def stiffness(self) -> float:
        """Traction over wavenumber and lasting slip, with the coupling at a friction of 1."""
        own, _, coupled = np.abs(self.kernels.static)
        return float(self._ordered[0].shear_modulus * (own + coupled))

    @property
    def fastest(self) -> float:
        """c_t of both bodies, weighted by how far waves of each move its face [length / time]."""
        # The memory answers fast changes as both faces do: this bounds steps in place of c_t.
        speeds = []
        for name in ("shear_speed", "longitudinal_speed"):
            # Under the same traction the softer face moves more, in proportion to 1 / (rho c).
            ease = [1 / (body.density * getattr(body, name)) for body in self._ordered]
            shear = [body.shear_speed for body in self._ordered]
            speeds.append(float(np.average(shear, weights=ease)))
        return max(speeds)

    def turned(self, amplitudes: Array) -> Array:
        """Return i sgn(q) times amplitudes (2, m), with the sign of the coupling."""
        turned = self.sense * np.stack([-amplitudes[1], amplitudes[0]])
        # The mean and the odd-even wave have no image shifted by a quarter of a wave.
        turned[:, [0, -1]] = 0.0
        return turned


def pair_of(scene: Scene) -> BodyPair | None:
    """Return the two bodies of a scene if they are different ones."""
    lower = scene.lower_material
    return None if lower is None else BodyPair(scene.material, lower)
