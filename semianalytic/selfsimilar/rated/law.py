"""Strength that depends on slip rate, in units of a profile, and linear about a slip rate.

The equations are those of `newton`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Layout
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.cut.quadrature.running import PanelIntegral
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.halfplane.stuck import traction_of
from semianalytic.scene.arrays import Array
from semianalytic.scene.laws.law import Law
from semianalytic.scene.scene import Scene


@dataclass(frozen=True)
class UnitLaw:
    """Friction law in units of stress and of the one-sided slip rate, b = mu = 1.

    It takes f p, of which `pressure` is the unit of the law over f.  `share` is the part of the
    change of constant friction that is applied, for steps towards the law.
    """

    law: Law
    stress: float
    pressure: float
    rate: float
    share: float = 1.0

    def strength(self, frictional: Array, speed: Array) -> Array:
        """Return the strength S(f p, |V|)."""
        none = np.zeros(np.shape(frictional))
        whole = self.law.strength(self.pressure * frictional, self.rate * speed, none)
        return np.asarray((1 - self.share) * frictional + self.share / self.stress * whole)

    def slopes(self, frictional: Array, speed: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives with respect to f p, to |V|, to both, and to |V| twice."""
        given = self.law.rate_slopes(self.pressure * frictional, self.rate * speed)
        by_pressure, by_rate, mixed, twice = (self.share * slope for slope in given)
        # Chain rule for the units of slip rate, of pressure and of stress.
        unit, pressed = self.rate / self.stress, self.pressure / self.stress
        by_friction = pressed * by_pressure + (1 - self.share)
        return by_friction, unit * by_rate, self.rate * pressed * mixed, unit * self.rate * twice


def unit_law(scene: Scene, stress: float) -> UnitLaw:
    """Return the law of a scene in the units of its load."""
    pressure = stress / scene.coefficient if scene.coefficient else 0.0
    # The law takes the relative slip rate, twice the one-sided one.
    return UnitLaw(scene.law, stress, pressure, 2 * stress / scene.material.shear_impedance)


@dataclass(frozen=True)
class SlipRate:
    """V as a function of slowness: at left ends of panels, from there on, and V(inf) ahead."""

    panels: Panels
    integral: PanelIntegral
    starts: Array
    ahead: float

    @classmethod
    def of(cls, profile: Profile) -> SlipRate:
        """Return the slip rate of a profile of one set of zones."""
        ahead = float(profile.fields.load.far_slip_rate)
        return cls(profile.panels, profile.rate_integral, profile.rate_starts, ahead)

    def __call__(self, at: CutPoints) -> Array:
        """Return V at points of any shape."""
        flat, senses = CutPoints(at.parts.reshape(4, -1)), self.panels.sense
        rate = np.full(flat.v.shape, self.ahead)
        panel = self.panels.panel_of(flat)
        for i in np.unique(panel[panel >= 0]):
            here = panel == i
            rate[here] = self.starts[i] + self.integral(int(i), flat[here]) if senses[i] else 0.0
        return rate.reshape(at.v.shape)


@dataclass(frozen=True)
class RateStep:
    """Strength linearised about V_k, with its term in the new V from the last iterate.

    `before`, `density`, `last` (p, n) are V_k, dV_k/dy and that iterate at the nodes of a layout.
    """

    law: UnitLaw
    load: Load
    factors: RayleighFactors
    rate: SlipRate
    layout: Layout
    before: Array
    density: Array
    last: Array

    @classmethod
    def about(cls, law: UnitLaw, fields: ZoneFields, rate: SlipRate) -> RateStep:
        """Return a step about a slip rate on the panels of some fields, without its slope."""
        panels, load = fields.panels, replace(fields.load, linearised=None)
        none = np.zeros_like(panels.jacobian)
        step = cls(law, load, fields.factors, rate, panels.layout, none, none, none)
        known = step._known(panels.at, panels.layout)
        return replace(step, before=known, last=known)

    def follows(self, fields: ZoneFields) -> bool:
        """Return whether V_k is known at the nodes of fields."""
        return fields.layout == self.layout and fields.panels.jacobian.shape == self.before.shape

    def carried(self, frictional: Array, speed: Array) -> Array:
        """Return the strength; see `LinearisedStrength`."""
        return self.law.strength(frictional, speed)

    def at(self, points: CutPoints, layout: Layout, jacobian: Array) -> tuple[Array, Array]:
        """Return eta and dg/dv; see `LinearisedStrength`.

        If the panels are other than those with which V_k moves, V_k is taken at fixed slowness.
        """
        count, (*sets, size) = len(layout.sense), points.v.shape[1:]
        shape = (count, *[1] * len(sets), size)
        if size == self.before.shape[1] and layout.begins(self.layout):
            before, density, last = (
                part[:count].reshape(shape) for part in (self.before, self.density, self.last)
            )
        else:
            before = last = self._known(points, layout)
            density = np.zeros_like(before)
        senses = np.array(layout.sense).reshape(-1, *[1] * (points.v.ndim - 1))
        frictional, gained = self._frictional(points)
        by_friction, eta, mixed, twice = self.law.slopes(frictional, np.abs(before))
        # d eta/dv along V_k: the derivatives of S' with respect to f p and to |V|.
        bent = mixed * gained + twice * senses * density / jacobian
        # Both terms of dg/dv in the description of this module.
        slope = senses * (by_friction - 1) * gained + bent * (last - before)
        return np.broadcast_to(eta, jacobian.shape), np.where(senses != 0, slope, 0.0)

    def _known(self, points: CutPoints, layout: Layout) -> Array:
        """Return V_k at points (p, ..., n) of panels, 0 where these stick."""
        slipping = layout.slipping.reshape(-1, *[1] * (points.v.ndim - 1))
        return np.where(slipping, self.rate(points), 0.0)

    def _frictional(self, points: CutPoints) -> tuple[Array, Array]:
        """Return f p and its slope."""
        load, factors = self.load, self.factors
        pressure, slope = load.pressure(factors, points), np.zeros(points.v.shape)
        if load.load_pressure:
            unit = traction_of(factors, "I")
            slope = load.load_pressure * unit.slope(factors.seen_in_plane(points))
        return load.friction * pressure, load.friction * slope


def on_any_panels(profile: Profile) -> ZoneFields:
    """Return the fields of a profile in a form that other panels of the same zones can use.

    The strength is linearised about the slip rate itself, which Newton's method leaves unchanged.
    """
    fields = profile.fields
    step = fields.load.linearised
    if not isinstance(step, RateStep):
        return fields
    nowhere = np.zeros((0, 0))
    step = replace(step, rate=SlipRate.of(profile), before=nowhere, density=nowhere, last=nowhere)
    return replace(fields, load=replace(fields.load, linearised=step))
