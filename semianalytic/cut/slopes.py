"""Slopes of slip rate and traction of given zones: they follow from their transform (section 4).

    dV/dv = -Im(T / M_+) / (pi kappa v M_+(v)),    dtau/dv = Im T / (pi v).

Units are b = mu = 1; V is one-sided.
"""

from __future__ import annotations

import numpy as np

from semianalytic.cut.transform import ZoneTransform
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import Array


class ZoneSlopes(ZoneTransform):
    """Slopes along the cut, and the pole of the slip rate at c_R where slip covers it."""

    def _slope_of(self, reduced: Array) -> Array:
        """Return dV/dv on panels that slip from X (Re C + R), (p, ..., n)."""
        canonical, layout, pressure = self.canonical, self.layout, self._pressure
        real, imag = canonical.impedance
        ahead, slip = layout.slip_ahead, layout.slip
        sources, missed = pressure.sources
        slope = self._by_impedance(reduced)
        # Ahead of the shear front M has a real part, which multiplies Im C.
        if len(ahead) and len(sources):
            product = canonical.values[ahead] * missed[ahead] * real[ahead]
            size = np.square(real[ahead]) + np.square(imag[ahead])
            slope[ahead] -= product / (size * self._modulus[: len(ahead)])
        if canonical.resistance is not None and len(slip):
            size = np.abs(imag[slip])
            size[: len(ahead)] = np.hypot(real[ahead], imag[ahead])
            product = canonical.values[slip] * missed[slip] * canonical.eta
            slope[slip] -= product / (np.square(size) * self._modulus)
        # The part A = s f P of T contributes -Im (A / M).
        if pressure.analytic:
            slope[slip] -= pressure.over_impedance[slip]
        return slope / (np.pi * self.panels.at.v)

    def _by_impedance(self, reduced: Array) -> Array:
        """Return -Im (reduced / M) on panels that slip, (p, ..., n), 0 on panels that stick."""
        layout, (real, imag) = self.layout, self.canonical.impedance
        slope = np.zeros_like(imag)
        behind, ahead = layout.slip_behind, layout.slip_ahead
        # M = i m behind the shear front, so that -Im (1 / M) = 1 / m.
        slope[behind] = reduced[behind] / imag[behind]
        if len(ahead):
            size = np.square(real[ahead]) + np.square(imag[ahead])
            slope[ahead] = reduced[ahead] * imag[ahead] / size
        if self.canonical.resistance is not None and len(layout.slip):
            slope[layout.slip] /= self._modulus
        return slope

    @property
    def _modulus(self) -> Array:
        """|M + eta| / |M| at the nodes of panels that slip; 1 without resistance."""
        if self.canonical.resistance is None:
            return np.ones((len(self.layout.slip), *[1] * (self.panels.jacobian.ndim - 1)))
        return self.canonical.excess_impedance[0]

    @cached_property
    def _reduced_at_c(self) -> Array:
        """X (Re C + R) at c where slip covers it, (1,) or (k, 1)."""
        panels, (sources, imag) = self.panels, self._pressure.sources
        driven, slowness = self._first_constant, self.load.slowness
        if slowness:
            driven = driven + self.amplitude * slowness / (self.factors.c - slowness)
        if len(sources):
            # Nodes straddle c evenly: the sum over them is a principal value.
            sums = panels.integrals(imag / panels.at.from_c)[sources].sum(axis=0)
            driven = driven - sums[..., None] / np.pi
        for edge, amount in self._terms:
            driven = driven + amount * self.factors.c / (edge.v * edge.from_c)
        return np.asarray(self.canonical.at_c * driven)

    @cached_property
    def residue(self) -> Array:
        """Coefficient of 1 / (v - c) in dV/dv where slip covers c, () or (k,)."""
        driven, pressure = self._reduced_at_c, self._pressure
        if self.normal is not None and pressure.analytic and self.layout.open[self.layout.pole]:
            driven = driven - pressure.sense * self.load.friction * self.normal._reduced_at_c
        # dV/dv = X (C + R) / (pi v m) beside c, with m = m'(c) (v - c).
        slope = np.pi * self.factors.c * self.factors.impedance_slope_at_c
        return np.asarray((driven / slope)[..., 0])

    @cached_property
    def traction_slope(self) -> Array:
        """dtau/dv on panels that stick, (p, ..., n), 0 on panels that slip."""
        # Im T / (pi v), with T / M_+ real and M_+(-v + i0) = M / (kappa M_+(v)).
        unit = self.canonical.impedance[1] / (self.canonical.m_plus * self.panels.at.v)
        slope = unit * self.stick_transform / (np.pi * self.factors.kappa)
        slope[self.layout.slip] = 0.0
        return slope
