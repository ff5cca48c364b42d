"""Compliance of two half-planes joined at y = 0, as a function of slowness.

Tractions of slowness k on the line y = 0, exp(s (t + k x)), move the faces of the bodies by

    V = -B tau - k D sigma,    U = k D tau - A sigma,

with V, U the relative rates of slip and opening (upper minus lower), tau the shear traction and
sigma the normal traction, positive in tension.  Each body adds to A and B its own

    A_j = alpha b^2 / (mu R),   B_j = beta b^2 / (mu R),   D_j = (2 alpha beta - q) / (mu R),
    alpha = sqrt(a^2 - k^2),  beta = sqrt(b^2 - k^2),  q = b^2 - 2 k^2,  R = q^2 + 4 k^2 alpha beta,

and D = D_1 - D_2 changes its sign where the bodies change places.  All quantities are formed times
R_1 R_2, not divided by R, so that none has a pole at the Rayleigh waves of the bodies.  Slowness is
in units of that of shear waves in the upper body, and stress in units of its shear modulus.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.scene import Material

LEAST_CONTRAST = 1e-6
"""Contrast below which no wave grows: it would by 1.1 times it at most; rounding hides 1e-7."""


@dataclass(frozen=True)
class Body:
    """One half-plane: shear modulus and slownesses of its longitudinal and shear waves."""

    modulus: float
    a: float
    b: float


@dataclass(frozen=True)
class Roots:
    """Roots alpha, beta and k^2 of one body at slownesses k, and functions formed from them."""

    body: Body
    alpha: Complex
    beta: Complex
    square: Complex

    @cached_property
    def bulk(self) -> Complex:
        """alpha beta + k^2, from (alpha beta)^2 - k^4 where the two cancel."""
        a, b = self.body.a, self.body.b
        product = self.alpha * self.beta
        direct, difference = product + self.square, product - self.square
        cancels = np.abs(direct) < np.abs(difference)
        rest = (a * b) ** 2 - self.square * (a * a + b * b)
        return np.asarray(np.where(cancels, rest / np.where(cancels, difference, 1.0), direct))

    @cached_property
    def rayleigh(self) -> Complex:
        """The Rayleigh function R = (b^2 - 2 k^2)^2 + 4 k^2 alpha beta."""
        b2 = self.body.b**2
        # q^2 + 4 k^2 alpha beta, with the cancelling sum alpha beta + k^2 as one number.
        return np.asarray(b2 * b2 - 4 * self.square * (b2 - self.bulk))

    @cached_property
    def normal(self) -> Complex:
        """A_j R."""
        return np.asarray(self.alpha * (self.body.b**2 / self.body.modulus))

    @cached_property
    def tangential(self) -> Complex:
        """B_j R."""
        return np.asarray(self.beta * (self.body.b**2 / self.body.modulus))

    @cached_property
    def coupling(self) -> Complex:
        """D_j R = (2 alpha beta - b^2 + 2 k^2) / mu."""
        return np.asarray((2 * self.bulk - self.body.b**2) / self.body.modulus)

    @cached_property
    def determinant(self) -> Complex:
        """(A_j B_j + k^2 D_j^2) R = (alpha beta + k^2) / mu^2: it has no Rayleigh pole."""
        return np.asarray(self.bulk / self.body.modulus**2)


@dataclass(frozen=True)
class Entries:
    """The compliance matrix [[B, k D], [-k D, A]] times R_1 R_2 at slownesses k.

    Each entry is formed when it is first asked for: growing waves need two of them only.
    """

    slowness: Complex
    bodies: tuple[Roots, Roots]

    @cached_property
    def normal(self) -> Complex:
        """A R_1 R_2."""
        upper, lower = self.bodies
        return np.asarray(upper.normal * lower.rayleigh + lower.normal * upper.rayleigh)

    @cached_property
    def tangential(self) -> Complex:
        """B R_1 R_2."""
        upper, lower = self.bodies
        return np.asarray(upper.tangential * lower.rayleigh + lower.tangential * upper.rayleigh)

    @cached_property
    def coupling(self) -> Complex:
        """k D R_1 R_2."""
        upper, lower = self.bodies
        difference = upper.coupling * lower.rayleigh - lower.coupling * upper.rayleigh
        return np.asarray(self.slowness * difference)

    @cached_property
    def determinant(self) -> Complex:
        """(A B + k^2 D^2) R_1 R_2, which has no Rayleigh pole either."""
        upper, lower = self.bodies
        # Products of one body's own entries are its determinant, in which its Rayleigh pole
        # cancels; D = D_1 - D_2 leaves -2 k^2 D_1 D_2 of the others.
        mixed = upper.normal * lower.tangential + lower.normal * upper.tangential
        own = upper.determinant * lower.rayleigh + lower.determinant * upper.rayleigh
        return np.asarray(own + mixed - 2 * upper.square * upper.coupling * lower.coupling)

    @property
    def rayleigh(self) -> Complex:
        """R_1 R_2."""
        upper, lower = self.bodies
        return np.asarray(upper.rayleigh * lower.rayleigh)

    def frictional(self, friction: float | Complex) -> Complex:
        """Phi R_1 R_2 = (A + s f k D) R_1 R_2 of `friction` s f, s being the sense of slip."""
        return np.asarray(self.normal + friction * self.coupling)

    @property
    def matrix(self) -> Complex:
        """C R_1 R_2, (..., 2, 2)."""
        rows = [[self.tangential, self.coupling], [-self.coupling, self.normal]]
        return np.moveaxis(np.array(rows), (0, 1), (-2, -1))

    @property
    def inverse(self) -> Complex:
        """C^{-1}, (..., 2, 2): finite at the Rayleigh waves of the bodies."""
        rows = [[self.normal, -self.coupling], [self.coupling, self.tangential]]
        return np.moveaxis(np.array(rows) / self.determinant, (0, 1), (-2, -1))


@dataclass(frozen=True)
class Compliance:
    """Two half-planes on one another."""

    upper: Body
    lower: Body

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Upper and lower body."""
        return self.upper, self.lower

    @property
    def contrast(self) -> float:
        """Largest relative difference of moduli and wave slownesses; 0 for identical bodies."""
        pairs = zip(vars(self.upper).values(), vars(self.lower).values(), strict=True)
        return max(abs(value / other - 1) for value, other in pairs)

    @property
    def is_alike(self) -> bool:
        """Whether the bodies differ so little that waves between them neither grow nor decay."""
        return self.contrast < LEAST_CONTRAST

    @cached_property
    def fronts(self) -> Array:
        """Slownesses a, b of the upper body and a, b of the lower one, (4,)."""
        return np.array([self.upper.a, self.upper.b, self.lower.a, self.lower.b])

    @cached_property
    def distinct_fronts(self) -> list[float]:
        """The fronts from the fastest to the slowest, each once."""
        return sorted(set(self.fronts.tolist()))

    @property
    def first(self) -> float:
        """Slowness m of the fastest wave."""
        return float(self.fronts.min())

    @property
    def last(self) -> float:
        """Slowness of the slowest body wave, the shear wave of the slower body."""
        return float(self.fronts.max())

    @cached_property
    def static(self) -> float:
        """Limit a_inf of |k| times the compliance, the sum of b^2 / (2 mu (b^2 - a^2))."""
        return sum(body.b**2 * _softness(body) for body in self.bodies)

    @cached_property
    def dundurs(self) -> float:
        """Dundurs' second parameter beta, upper minus lower body: k D / A tends to i beta."""
        upper, lower = (body.a**2 * _softness(body) for body in self.bodies)
        return (upper - lower) / self.static

    @property
    def mirrored(self) -> Compliance:
        """Compliance with the bodies exchanged, for waves that run the other way: k becomes -k."""
        return Compliance(self.lower, self.upper)

    def at(self, k: ArrayLike) -> Entries:
        """Return the matrix at complex slownesses k off the cuts |Re k| > `first`."""
        k = np.asarray(k, dtype=complex)
        return Entries(k, self._roots(k, [s + k for s in self.fronts.tolist()]))

    def on_cut(self, v: ArrayLike, from_fronts: Array | Complex | None = None) -> Entries:
        """Return the matrix at k = -v + i0, v > 0, or at k = -v with Im v < 0.

        `from_fronts` (4, ...) are v less each front where differences of v would lose digits.
        """
        v = np.asarray(v)
        if from_fronts is None:
            from_fronts = v - self.fronts.reshape(4, *[1] * v.ndim)
        # A real -(v - s) becomes complex with imaginary part +0: the upper side of the cut.
        k = -v.astype(complex)
        return Entries(k, self._roots(k, list((-from_fronts).astype(complex))))

    def beside(self, place: Array, offset: Complex) -> Entries:
        """Return the matrix at k = place + offset, Re k < 0 <= Im k, exact near -`place`."""
        k = place + offset
        # s + place is exactly 0 for the front itself, and the offset keeps all its digits.
        plus = [(s + place) + offset for s in self.fronts.tolist()]
        return Entries(k, self._roots(k, plus))

    def _roots(self, k: Complex, plus: list[Complex]) -> tuple[Roots, Roots]:
        """Return the roots of both bodies, given the four sums of front and k."""
        square, fronts = k * k, self.fronts.tolist()
        alpha, beta, alpha_two, beta_two = (
            # The product of two roots is analytic off both cuts; the root of s^2 - k^2 is not.
            np.sqrt(s - k) * np.sqrt(near)
            for s, near in zip(fronts, plus, strict=True)
        )
        lower = Roots(self.lower, alpha_two, beta_two, square)
        return Roots(self.upper, alpha, beta, square), lower


def _softness(body: Body) -> float:
    """Return 1 / (2 mu (b^2 - a^2))."""
    return 1 / (2 * body.modulus * (body.b**2 - body.a**2))


def compliance_of(upper: Material, lower: Material) -> Compliance:
    """Return the compliance of two materials, over shear slowness and modulus of the upper."""
    unit = upper.shear_speed
    speeds = ((body.longitudinal_speed, body.shear_speed) for body in (upper, lower))
    slownesses = [(unit / fast, unit / slow) for fast, slow in speeds]
    moduli = 1.0, lower.shear_modulus / upper.shear_modulus
    return Compliance(*(Body(mu, *ab) for mu, ab in zip(moduli, slownesses, strict=True)))
