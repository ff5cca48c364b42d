"""Exact fields of given slip zones: the Riemann-Hilbert problem of section 4, solved.

On the cut k = -v + i0 the transform T of the shear traction satisfies Im T = known where the
interface slips and Im (T / M_+) = 0 where it sticks.  With a canonical function X that is real
on slip and has the phase of M_+ on stick,

    T = s f P + X (C + R),   P = P_0 M_+^I / M_+^I(0),

where C is a Cauchy integral over the parts of the cut on which s f P misses its condition and R
is a constant fixed by T(0).  Slip rate and traction follow from

    dV/dv = -Im(T / M_+) / (pi kappa v M_+(v)),    dtau/dv = Im T / (pi v).

X carries the behaviour at each edge (`canonical`).  The parts follow one another here: what
pressure takes, s f P and the sources of C (`PressurePart`); the transform and the slopes of slip
rate and traction (`ZoneFields`); what is left at the edges (`ZoneFields.mismatch`), whose Jacobian
Newton's method forms from neighbouring zones (`edges`).  b = mu = 1; V is one-sided.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.cut.canonical import CanonicalFunction, log_share
from semianalytic.cut.layout import Layout, Zone
from semianalytic.cut.load import Load, per_set
from semianalytic.cut.panels import Panels, lay_panels
from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule
from semianalytic.halfplane.stuck import traction_of


@dataclass(frozen=True)
class PressurePart:
    """The part s f P of the transform of slip zones, and where on the cut it misses its condition.

    Attributes
    ----------
    load : Load
    canonical : CanonicalFunction
    sense : int, s, that of the zone next to the contact edge; 0 without zones
    """

    load: Load
    canonical: CanonicalFunction
    sense: int

    @cached_property
    def amount(self) -> float | Array:
        """s f P_0 / M_+^I(0)."""
        product = self.sense * self.load.friction * self.load.load_pressure
        return product / self.canonical.factors.m_plus_at_zero["I"]

    @cached_property
    def mode_ratio(self) -> Array:
        """|M_+^I / M_+| = sqrt(|b - v| / (v - a)) at the nodes.

        M_+^I / M_+ is -i times that ahead of the shear front, and that behind it.
        """
        at = self.canonical.panels.at
        return np.sqrt(np.abs(at.from_b / at.from_a))

    @cached_property
    def slope(self) -> Array:
        """d(P_0 p*)/dv = Im P(-v + i0) / (pi v) at the nodes, (p, ..., n)."""
        canonical, factors = self.canonical, self.canonical.factors
        (real, imag), ahead = canonical.impedance, canonical.layout.ahead
        slope = imag * self.mode_ratio
        slope[:ahead] = -real * self.mode_ratio[:ahead]
        slope *= self.load.load_pressure / (np.pi * factors.kappa * factors.m_plus_at_zero["I"])
        return slope / (canonical.m_plus * canonical.panels.at.v)

    @cached_property
    def sources(self) -> tuple[np.ndarray, Array]:
        """Panels on which C has an imaginary part, and Im C at all nodes, (p, ..., n).

        Stick ahead of the shear front, and zones of the other sense.
        """
        canonical, panels, layout = self.canonical, self.canonical.panels, self.canonical.layout
        stick, imag = layout.stick_ahead, np.zeros_like(panels.jacobian)
        if self.load.load_pressure == 0 or not self.sense:
            return stick[:0], imag
        imag[stick] = self.amount * self.mode_ratio[stick] / canonical.values[stick]
        other = np.array([i for i in layout.slip if panels.sense[i] != self.sense])
        if len(other):
            factor = -2 * np.pi * self.sense * self.load.friction
            miss = factor * panels.at.v[other] * self.slope[other]
            imag[other] = miss / canonical.values[other]
        return np.append(stick, other.astype(int)), imag


@dataclass(frozen=True)
class ZoneFields:
    """Fields of a load and a set of zones, whether or not the edges satisfy Coulomb's law.

    `zones` run from the longitudinal front inward, in slowness; their edges may hold several
    neighbouring sets at once (see `panels`).  Without `tail` the fields behind the last edge are
    left out.
    """

    factors: RayleighFactors
    load: Load
    zones: tuple[Zone, ...]
    rule: Rule
    tail: bool = True

    @cached_property
    def panels(self) -> Panels:
        """Panels on a rule as fine and as long as these zones need."""
        sets = np.shape(self.load.friction)
        return lay_panels(self.factors, self.zones, self.rule, sets, self.tail)

    @property
    def layout(self) -> Layout:
        """Which panels there are."""
        return self.panels.layout

    @cached_property
    def canonical(self) -> CanonicalFunction:
        """X, real, on panels that slip; X / M_+, real, on panels that stick."""
        return CanonicalFunction(self.factors, self.panels)

    @cached_property
    def _pressure(self) -> PressurePart:
        sense = self.zones[-1].sense if self.zones else 0
        return PressurePart(self.load, self.canonical, sense)

    @cached_property
    def constant(self) -> Array:
        """R, from T(0) = Q_0 - mu b V(inf), (1,) or (k, 1)."""
        load, panels = self.load, self.panels
        at_zero = load.load_shear - load.far_slip_rate
        at_zero -= self._pressure.sense * load.friction * load.load_pressure
        value = at_zero / self.canonical.at_zero
        sources, imag = self._pressure.sources
        if len(sources):
            integrals = panels.integrals(imag / panels.at.v)
            value = value + integrals[sources].sum(axis=0)[..., None] / np.pi
        return value

    @cached_property
    def _cauchy(self) -> Array:
        """(p, ..., n): Re C(-v + i0) at the nodes."""
        panels, (sources, imag) = self.panels, self._pressure.sources
        if not len(sources):
            return imag
        pairs, weights = self.layout.pairs_from(tuple(sources.tolist())), panels.jacobian * imag
        total = pairs.collect(panels.cauchy(pairs, weights[pairs.source]))
        total[sources] += panels.principal_values(sources, weights[sources])
        return total / -np.pi

    @cached_property
    def _reduced(self) -> Array:
        """(p, ..., n): X (Re C + R); over M_+ on panels that stick."""
        return self.canonical.values * (self._cauchy + self.constant)

    @cached_property
    def stick_transform(self) -> Array:
        """(p, ..., n): T / M_+ where the interface sticks (meaningless elsewhere)."""
        result, ahead = self._reduced.copy(), self.layout.ahead
        if self.load.load_pressure:
            result[ahead:] += self._pressure.amount * self._pressure.mode_ratio[ahead:]
        return result

    def stick_transform_off_cut(self, k: Array) -> Array:
        """T / M_+ at k > 0, any shape: what drives the slot faces (one set of zones)."""
        panels, flat = self.panels, np.ravel(k)
        cauchy = np.full_like(flat, self.constant[0])
        sources, imag = self._pressure.sources
        for source in sources:
            kernel = 1 / (panels.at.v[source] + flat[:, None])
            weights = panels.jacobian[source] * imag[source]
            cauchy -= panels.rule.spacing / np.pi * (kernel @ weights)
        ratio = np.sqrt((1 + flat) / (self.factors.a + flat)) * self._pressure.amount
        return (self.canonical.reciprocal_off_cut(flat) * cauchy + ratio).reshape(np.shape(k))

    @cached_property
    def stick_transform_at_edge(self) -> Array:
        """Limit of T / M_+ at the contact edge when it sticks: K_II / (M_+(0) K_II of Q_0 = 1).

        () or (k,).
        """
        return np.asarray((self.constant + self._pressure.amount)[..., 0])

    @cached_property
    def stick_transform_excess(self) -> Array:
        """(..., n): T / M_+ less its limit at a stuck contact edge, last panel, without loss."""
        at, factors = self.panels.at[-1], self.factors
        ratio = np.expm1(0.5 * log_share(at.from_b, at.from_a, np.array(1.0 - factors.a)))
        cauchy, growth = self._cauchy[-1], np.expm1(self.canonical.log_growth)
        return growth * (cauchy + self.constant) + cauchy + self._pressure.amount * ratio

    @cached_property
    def slip_rate_slope(self) -> Array:
        """(p, ..., n): dV/dv on panels that slip, 0 on panels that stick."""
        load, layout, (real, imag) = self.load, self.layout, self.canonical.impedance
        slope = np.zeros_like(imag)
        behind, ahead = layout.slip_behind, layout.slip_ahead
        slope[behind] = self._reduced[behind] / imag[behind]
        if len(ahead):
            product = self._reduced[ahead] * imag[ahead]
            if load.load_pressure:
                _, imag_cauchy = self._pressure.sources
                product -= self.canonical.values[ahead] * imag_cauchy[ahead] * real[ahead]
            slope[ahead] = product / (np.square(real[ahead]) + np.square(imag[ahead]))
            if load.load_pressure:
                by_pressure = self._pressure.amount * self._pressure.mode_ratio[ahead]
                slope[ahead] += by_pressure / (self.factors.kappa * self.canonical.m_plus[ahead])
        return slope / (np.pi * self.panels.at.v)

    @cached_property
    def traction_slope(self) -> Array:
        """(p, ..., n): dtau/dv on panels that stick, 0 on panels that slip."""
        unit = self.canonical.impedance[1] / (self.canonical.m_plus * self.panels.at.v)
        slope = unit * self.stick_transform / (np.pi * self.factors.kappa)
        slope[self.layout.slip] = 0.0
        return slope

    def strength(self, edge: CutPoints) -> Array:
        """Friction bound f p at an edge."""
        load = self.load
        pressure = np.full(edge.v.shape, load.base_pressure)
        if load.load_pressure:
            mode_one = traction_of(self.factors, "I")
            pressure = pressure + load.load_pressure * mode_one(edge.v)
        return load.friction * pressure

    @cached_property
    def _excess_slope(self) -> Array:
        """(p, ..., n): slope of traction less the following zone's sense times strength."""
        load, slope = self.load, self.traction_slope
        if load.load_pressure == 0 or not self.zones:
            return slope
        senses = [zone.sense for zone in self.zones]
        following = np.array([*senses, senses[-1]])[list(self.layout.zone)]
        factor = (following * ~self.layout.slipping).reshape(-1, *[1] * (slope.ndim - 1))
        return slope - factor * load.friction * self._pressure.slope

    def mismatch(self) -> Array:
        """What the edges leave unfulfilled: one row per edge, (e,) or (e, k).

        For each zone: traction less sense times strength where it opens (over the width of the
        stick gap before it when that is narrow), and the slip rate left where it heals.
        """
        load, layout = self.load, self.layout
        integrals = self.panels.integrals(self._excess_slope + self.slip_rate_slope)
        gains = iter(np.add.reduceat(integrals, [part[0] for part in layout.regions], axis=0))
        rows: list[Array] = []
        outward: Zone | None = None
        for zone in self.zones:
            if zone.left is not None:
                rows.append(np.asarray(self._excess_at_opening(zone, outward, next(gains))))
            if zone.right is not None:
                ahead = per_set(load.far_slip_rate) if zone.left is None else 0.0
                rows.append(next(gains) + ahead)
            outward = zone
        return np.stack(rows) if rows else np.zeros(0)

    def _excess_at_opening(self, zone: Zone, outward: Zone | None, gain: Array) -> Array:
        """Traction less sense times strength where a zone opens, () or (k,), from what it gains on
        the stick before it, over the width of a narrow gap to the zone outward of it."""
        load = self.load
        if outward is None:
            strength = per_set(load.friction) * load.base_pressure
            return gain + load.base_shear - per_set(load.far_slip_rate) - zone.sense * strength
        if zone.left is None or outward.right is None:
            return gain
        if outward.sense != zone.sense:
            gain = gain + (outward.sense - zone.sense) * self.strength(outward.right)[..., 0]
        return np.asarray(gain / np.minimum(1.0, zone.left.minus(outward.right)[..., 0]))
