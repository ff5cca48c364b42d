"""One zone of motion that spreads evenly to both sides of a patch or of a point force.

Units: slowness b, impedance mu b; stress over the excess S of the patch, or over F_0 / c_t for a
force F_0 t, whose patch has vanished (w = 0).  Rates are those of one side.  With e_s the slowness
of the edge of motion, e_p = 1/w that of the patch and m(v) = Im M(-v + i0), transforms over x/t are

    W = C k / ((e_p^2 - k^2) sqrt(e_s^2 - k^2)),  T = -M W,

with C = 2 S e_p sqrt(e_p^2 - e_s^2) / m(e_p), and the edge is where the traction ahead of it meets
strength.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property, partial
from typing import Any

import numpy as np

from semianalytic.halfplane.imaginary_axis import (
    impedance_on_axis,
    over_axis,
    static_remainder,
)
from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.halfplane.running import RunningIntegral, panels_to
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

_NEAREST = -36.0
"""ln((e_s - c) / (e_p - e_s)) from which an edge is looked for: e^-36 is below rounding."""


@dataclass(frozen=True, eq=False)
class Spreading:
    """Motion at |x| < xi_s t around a patch |x| < w t of excess 1, or around a unit point force."""

    factors: RayleighFactors  # impedance in the mode of motion
    patch: float  # speed w of the patch over c_t; 0 for a point force
    edge: float  # slowness e_s of the edge of motion
    # slowness e_p - e_s by which the patch is behind the edge, with all digits; inf for a point
    lead: float = np.inf

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}  # no closures

    @cached_property
    def beyond(self) -> float:
        """Share y_p = sqrt(1 - (w / xi_s)^2) of the edge at which the patch ends; 1 for a point."""
        if not self.patch:
            return 1.0
        # 1 - w e_s = w (e_p - e_s): the lead is known to all its digits, the difference from 1 is
        # not.
        return float(np.sqrt(self.lead * self.patch * (1 + self.patch * self.edge)))

    @cached_property
    def scale(self) -> float:
        """Slip rate over the logarithm of `slip_rate`: S / (pi m(e_p)), or F_0 / (2 pi m_static).

        The limit for a slow patch, m(e_p) -> m_static e_p, joins them.
        """
        if not self.patch:
            return 1 / (2 * np.pi * self.factors.kappa)
        return 1 / (np.pi * impedance_behind(self.factors, 1 / self.patch))

    def missing(self, spacing: float | None = None) -> float:
        """Return the rise of traction from the base to the edge: d over the excess, or over F_0.

        It is S - (C / pi) int M(i eta) / ((e_p^2 + eta^2) sqrt(e_s^2 + eta^2)) d eta.
        """
        rule = {} if spacing is None else {"spacing": spacing}
        if not self.patch:

            def rest(eta: Array) -> Array:
                return static_remainder(self.factors, eta, self.edge)

            return 2 * self.scale * over_axis(rest, **rule)
        end = 1 / self.patch

        def density(eta: Array) -> Array:
            axis = np.sqrt(self.edge**2 + eta**2) * (end**2 + eta**2)
            return np.asarray(impedance_on_axis(self.factors, eta) / axis)

        # C / pi for S = 1, since sqrt(e_p^2 - e_s^2) = e_p y_p.
        return 1 - 2 * self.scale * end**2 * self.beyond * over_axis(density, **rule)

    def slip_rate(self, xi: Array) -> Array:
        """Return the slip rate at velocities xi >= 0; 0 ahead of the edge.

        It is scale ln |(y_p + y) / (y_p - y)| with y = sqrt(1 - (xi / xi_s)^2): infinite at the end
        of a patch, and at a point force.
        """
        return self.scale * np.where(self._moves(xi), self._logarithm(xi), 0.0)

    def slip(self, xi: Array) -> Array:
        """Return the slip over the time, at velocities xi >= 0."""
        y = self._share(xi)
        if not self.patch:
            # The limit of the formula below for w -> 0, where the moment becomes elementary.
            return np.where(self._moves(xi), self.scale * (self._logarithm(xi) - 2 * y), 0.0)
        from scipy.special import xlogy  # imported late, which keeps commands fast to start

        w, y_p = self.patch, self.beyond
        # The logarithms of the slip rate and of its moment are both infinite at the end of the
        # patch; their difference, formed here by xlogy, is finite.
        near = 2 * np.log((y_p + y) / self.edge)
        moment = 2 * np.log(y_p * xi + y * w)
        difference = xlogy(xi / w - 1, np.abs((xi - w) * (xi + w)))
        slip = near - xi / w * moment + difference
        return np.where(self._moves(xi), self.scale * slip, 0.0)

    def _moves(self, xi: Array) -> np.ndarray:
        return np.asarray(xi * self.edge < 1)

    def _share(self, xi: Array) -> Array:
        """Return y = sqrt(1 - (xi / xi_s)^2), 0 ahead of the edge."""
        velocity = np.minimum(xi * self.edge, 1.0)
        return np.sqrt((1 - velocity) * (1 + velocity))

    def _logarithm(self, xi: Array) -> Array:
        with np.errstate(divide="ignore"):
            # y_p^2 - y^2 = (xi^2 - w^2) e_s^2, in factors: y_p - y itself would lose its digits
            # near the end of the patch.
            lag = np.abs((xi - self.patch) * (xi + self.patch)) * self.edge**2
            return np.asarray(2 * np.log(self.beyond + self._share(xi)) - np.log(lag))

    def traction(self, xi: Array) -> Array:
        """Return the traction above the base at velocities xi >= 1 / e_s, ahead of the edge."""
        with np.errstate(divide="ignore"):
            return self._running.at(1 / np.asarray(xi, dtype=float).ravel()).reshape(np.shape(xi))

    @cached_property
    def _running(self) -> RunningIntegral:
        """The traction ahead of the edge over slowness: C Im M / (pi (e_p^2 - v^2) sqrt(...))."""
        w, lead = self.patch, self.lead

        def slope(at: CutPoints, to_edge: Array) -> Array:
            imaginary = self.factors.impedance_on_cut(at).imag
            root = np.sqrt(to_edge * (self.edge + at.v))
            if not w:
                return np.asarray(2 * self.scale * imaginary / root)
            end = 1 / w
            from_end = (lead + to_edge) * (end + at.v)
            return np.asarray(2 * self.scale * end**2 * self.beyond * imaginary / (from_end * root))

        # The pole at e_p lies `lead` beyond the edge: panels near the edge must be shorter than
        # that.
        least = min(lead / 2, self.edge)
        return RunningIntegral(self.factors, slope, panels_to(self.factors, self.edge, least))

    @cached_property
    def missing_again(self) -> float:
        """A second evaluation of `missing`, from the traction ahead of the edge."""
        return float(self._running.total)

    @cached_property
    def turning(self) -> tuple[float, float]:
        """Traction at the shear wave and at the Rayleigh wave, between which alone it falls.

        Ahead of the shear wave it rises in mode II and falls in mode I; in mode III it rises all
        the way to the edge.
        """
        at_shear, at_rayleigh = self._running.at(np.array([1.0, self.factors.c]))
        return float(at_shear), float(at_rayleigh)

    @cached_property
    def area(self) -> float:
        """Integral of the slip rate over velocity: twice the integral over xi > 0."""
        if not self.patch:
            return 4 * np.pi * self.scale / (2 * self.edge)
        return 2 * np.pi * self.scale * self.beyond / self.edge

    @cached_property
    def area_on_patch(self) -> float:
        """Integral of the slip rate over the patch, |xi| < w."""
        # The slip rate has a logarithm at |xi| = w, towards which the pieces become shorter.
        t, weight = gauss(20)
        # With 30 the logarithm at the end of the patch costs 1e-9.
        ends = 1 - 0.5 ** np.arange(41)
        xi = self.patch * (ends[:-1, None] + np.diff(ends)[:, None] * t)
        rule = self.patch * np.diff(ends)[:, None] * weight
        return float(2 * np.sum(rule * self.slip_rate(xi)))


def impedance_behind(factors: RayleighFactors, slowness: float) -> float:
    """Return m(v) = Im M(-v + i0) at a slowness behind the shear wave."""
    return float(factors.impedance_behind(factors.cut(np.array([slowness])))[0])


def spread(factors: RayleighFactors, patch: float, missing: float) -> Spreading:
    """Find the edge of motion around a patch, or a point force.

    `patch` is its speed over c_t, slower than the Rayleigh wave (the shear wave in mode III), 0 for
    a point; `missing` is d over the excess, or over F_0 / c_t.  Raises SceneError if no edge is
    slower than these waves.
    """
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    at = partial(_at, factors, patch)
    farthest = float(np.log(1e12)) if not patch else 36.0

    def excess(x: float) -> float:
        return at(x).missing() - missing

    # `missing` grows with x: it is least for an edge at the wave and S for one at the patch.
    if excess(_NEAREST) > 0:
        wave = "Rayleigh" if factors.has_rayleigh_wave else "shear"
        raise SceneError(
            f"whole line: no edge slower than the {wave} wave carries this load, whose excess is "
            "too large; what the base lacks to overcome friction must be more than "
            f"{least_missing(factors, patch):.4g} of it, got {missing:.4g}: raise friction or "
            "pressure, or lower the load."
        )
    if excess(farthest) < 0:
        raise SceneError(
            "whole line: the edge is at the end of the patch within rounding; nothing moves "
            "outside, and what the base lacks to overcome friction must be less of the excess, got "
            f"{missing:.17g}."
        )
    # The unknown is a logarithm, so that an edge near the wave, or near the patch, keeps all
    # digits of that distance.
    return at(brentq(excess, _NEAREST, farthest, xtol=1e-15, rtol=1e-15))


def least_missing(factors: RayleighFactors, patch: float) -> float:
    """Return d over the excess below which there is no single zone slower than all its waves.

    In mode II a second zone of slip starts at the shear wave, where traction meets strength; in the
    others, and around fast patches, the edge comes to the Rayleigh wave, or the shear wave.
    """
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    def margin(x: float) -> float:
        spreading = _at(factors, patch, x)
        return spreading.missing() - spreading.turning[0]

    x = _NEAREST
    if factors.mode == "II" and margin(x) < 0:
        # Traction ahead of the zone peaks at the shear wave in mode II: there it would meet
        # strength first.
        x = brentq(margin, x, 12.0, xtol=1e-10)  # a second zone never starts close to the patch
    return _at(factors, patch, x).missing()


def _at(factors: RayleighFactors, patch: float, x: float) -> Spreading:
    """Return motion with an edge at x = ln((e_s - c) / (e_p - e_s)), or ln(e_s / c - 1)."""
    c = factors.c
    if not patch:
        return Spreading(factors, 0.0, c * (1 + float(np.exp(x))))
    # The shorter of the two distances is formed by itself: the logistic map never subtracts.
    width, small = 1 / patch - c, float(np.exp(-abs(x)))
    near, far = width * small / (1 + small), width / (1 + small)
    return Spreading(factors, patch, *((c + near, far) if x < 0 else (1 / patch - near, near)))
