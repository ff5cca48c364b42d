"""Poles of the rates in an opening at the Rayleigh waves of its free faces.

At the slowness c of a Rayleigh wave of body j the inverse compliance takes n = (s_j k D_j, A_j) R_j
to 0, s = +1 for the upper and -1 for the lower body: rates of slip and opening may have a pole
rho n / (k + c) there under finite tractions.  Its first entry is real and its second imaginary, so
that rho = 1 is a jump of V and a logarithm in U at x/t = 1/c, rho = i a logarithm in V and a jump
of U (Lamb).  On the cut both are

    q = d delta(v - c) + p G(v) / (v - c),    G(c) = 1,

with G a parabola that vanishes at the ends of the panel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.dissimilar.canonical import Glued
from semianalytic.dissimilar.compliance import Compliance
from semianalytic.dissimilar.stretch import Values
from semianalytic.halfplane.polynomials import gauss
from semianalytic.scene.arrays import Array


@dataclass(frozen=True, eq=False)
class Pole:
    """Both kinds of pole at one Rayleigh wave c in an opening, on a panel left < v < right.

    `direction` is n, the imaginary part of its second entry.
    """

    glued: Glued
    slowness: float
    left: float
    right: float
    direction: tuple[float, float]

    @property
    def jumps(self) -> Array:
        """Coefficients d of the delta functions of both kinds, in columns, (2, 2)."""
        x, y = self.direction
        return np.array([[-np.pi * x, 0.0], [0.0, np.pi * y]])

    @property
    def residues(self) -> Array:
        """Coefficients p of the simple poles of both kinds, in columns, (2, 2)."""
        x, y = self.direction
        return np.array([[0.0, -x], [-y, 0.0]])

    def parabola(self, v: Values) -> Values:
        """Return G(v), the parabola with G(c) = 1 that vanishes at both ends of the panel."""
        scale = (self.slowness - self.left) * (self.right - self.slowness)
        return np.asarray((v - self.left) * (self.right - v) / scale)

    def _carried(self, v: Values) -> Values:
        """Return Psi^T p G / n_inf at slownesses v, (m, 2, 2)."""
        psi = np.swapaxes(self.glued.psi(v), -1, -2) / self.glued.limit
        return np.asarray(psi @ self.residues * self.parabola(v)[:, None, None])

    @cached_property
    def _nodes(self) -> tuple[Array, Array, Values]:
        """Gauss points on the panel, their weights, and `_carried` there."""
        t, weight = gauss(48)
        w = self.left + (self.right - self.left) * t
        return w, (self.right - self.left) * weight, self._carried(w)

    def _over(self, v: Values) -> Values:
        """Return int Psi^T p G / n_inf dw / (w - v), (m, 2, 2), a principal value on the panel."""
        w, weight, carried = self._nodes
        width = self.right - self.left
        # Far from the panel the integrand is smooth, and the subtraction below would only cancel.
        far = np.abs(v - (self.left + self.right) / 2) > width
        result = np.empty((len(v), 2, 2), dtype=v.dtype)
        result[far] = np.einsum("w,wab,mw->mab", weight, carried, 1 / (w - v[far, None]))
        near = v[~far]
        here = self._carried(near)
        # Near the panel the value at v is subtracted, whose integral is a logarithm.
        share = (carried - here[:, None]) / (w - near[:, None])[..., None, None]
        if np.isrealobj(v):
            inside = (near != self.left) & (near != self.right)  # G vanishes at the ends
            ends = np.where(inside, (self.right - near) / (self.left - near + ~inside), 1.0)
            log = np.log(np.abs(ends))
        else:
            log = np.log(self.right - near) - np.log(self.left - near)
        near_by = np.einsum("w,mwab->mab", weight, share) + here * log[:, None, None]
        result[~far] = near_by
        return result

    @cached_property
    def _at_pole(self) -> tuple[Values, Values]:
        """The integral `_over` at v = c, and Psi^T(c) d / n_inf."""
        c = np.array([self.slowness])
        psi = np.swapaxes(self.glued.psi(c), -1, -2)[0] / self.glued.limit
        return self._over(c)[0], psi @ self.jumps

    def transform(self, v: Values) -> Values:
        """Return int Psi^T q / n_inf dw / (w - v), (m, 2, 2), of both kinds in columns."""
        # 1 / ((w - c) (w - v)) = (1 / (w - c) - 1 / (w - v)) / (c - v) in partial fractions.
        over, jump = self._at_pole
        distance = (self.slowness - v)[:, None, None]
        return np.asarray((over + jump - self._over(v)) / distance)

    def values(self, v: Array) -> Array:
        """Return q off the pole at slownesses on the panel, (m, 2, 2)."""
        return np.asarray(self.residues * (self.parabola(v) / (v - self.slowness))[:, None, None])

    def change(self, v: Array) -> Array:
        """Return the integrals of q from the left end to slownesses v on the panel, (m, 2, 2)."""
        # The delta function at c is a jump of what is integrated across it.
        passed = (v > self.slowness)[:, None, None] * self.jumps
        return np.asarray(passed + self._first(v)[:, None, None] * self.residues)

    def area(self, v: Array) -> Array:
        """Return the integrals of `change` from the left end to slownesses v, (m, 2, 2)."""
        passed = np.maximum(v - self.slowness, 0.0)[:, None, None] * self.jumps
        return np.asarray(passed + self._second(v)[:, None, None] * self.residues)

    @property
    def _bends(self) -> tuple[float, float]:
        """Coefficients s and q of G = 1 + s (v - c) - q (v - c)^2."""
        before, after = self.slowness - self.left, self.right - self.slowness
        return 1 / before - 1 / after, 1 / (before * after)

    def _first(self, v: Array) -> Array:
        """Return the integral of G / (w - c) from the left end."""
        (s, q), (y, start) = self._bends, (v - self.slowness, self.left - self.slowness)
        log = np.log(np.abs(y / start))
        return np.asarray(log + s * (y - start) - q * (y * y - start * start) / 2)

    def _second(self, v: Array) -> Array:
        """Return the integral of `_first` from the left end."""
        (s, q), (y, start) = self._bends, (v - self.slowness, self.left - self.slowness)
        width = y - start
        cubic = (y**3 - start**3) / 3 - start * start * width
        # y ln |y| is 0 at the pole itself.
        log = np.where(y == 0, 0.0, y * np.log(np.abs(np.where(y, y, 1.0) / start)))
        return np.asarray(log - width + s * width * width / 2 - q * cubic / 2)


def free_direction(compliance: Compliance, body: int, slowness: float) -> tuple[float, float]:
    """Return n over b^2 / mu at the Rayleigh wave of the upper body, 0, or the lower one, 1."""
    moduli = compliance.bodies[body]
    root = np.sqrt((slowness - moduli.a) * (slowness + moduli.a))
    other = np.sqrt((slowness - moduli.b) * (slowness + moduli.b))
    coupling = -2 * root * other - moduli.b**2 + 2 * slowness**2  # 2 alpha beta - q, alpha beta < 0
    sign = 1 if body == 0 else -1
    return -sign * slowness * float(coupling) / moduli.b**2, float(root)


def poles_on(glued: Glued, slownesses: Sequence[float], left: float, right: float) -> list[Pole]:
    """Return the poles on a panel of an opening, from the Rayleigh slownesses of both bodies."""
    return [
        Pole(glued, c, left, right, free_direction(glued.compliance, body, c))
        for body, c in enumerate(slownesses)
        if left < c < right
    ]
