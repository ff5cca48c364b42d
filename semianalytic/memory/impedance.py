"""The impedance that motion of an interface between two equal half-planes meets.

A slip rate of wavenumber q exerts the traction -(rho c_t / 2) [V + int h(q c_t (t - s)) q c_t V ds]
(Geubelle & Rice 1995).  h has the Laplace transform G(s) - 1, where G is the impedance of a
half-plane at slowness i/s.  With A = sqrt(g^2 s^2 + 1),
B = sqrt(s^2 + 1), g = c_t/c_l, it is

    G = [(s^2 + 2)^2 - 4 A B] / (s^3 B)   in plane (`InPlane`),
    G = B / s                             in antiplane shear (`Antiplane`), h = int J_1(x) / x dx.

An opening rate meets g G_in-plane B / A of the impedance rho c_l / 2 (`Opening`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.scene.arrays import Complex
from semianalytic.scene.scene import Scene


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
