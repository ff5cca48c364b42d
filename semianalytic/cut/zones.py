"""Exact fields of given slip zones: the Riemann-Hilbert problem of section 4, solved.

On the cut k = -v + i0 the transform T of the shear traction satisfies Im T = known where the
interface slips and Im (T / M_+) = 0 where it sticks.  With a canonical function X that is real
on slip and has the phase of M_+ on stick,

    T = s f P + X (C + R),   P = P_0 M_+^I / M_+^I(0),

where C is a Cauchy integral over the parts of the cut on which s f P misses its condition and R
is a constant fixed by T(0).  Where slip meets the resistance eta V, Im (1 + eta / M) T is known
instead, and X has the phase of M / (M + eta) there.  Slip rate and traction follow from

    dV/dv = -Im(T / M_+) / (pi kappa v M_+(v)),    dtau/dv = Im T / (pi v).

X carries the behaviour at each edge (`canonical`), strength the sources of C (`strength`).  The
parts follow one another here: the transform and the slopes of slip rate and traction
(`ZoneFields`); what is left at the edges (`ZoneFields.mismatch`), whose Jacobian Newton's method
forms from neighbouring zones (`edges`).  b = mu = 1; V is one-sided.

The normal problem is the same in mode I, with opening for slip, no friction and minus the
pressure for traction.  Where a gap closes behind its opening it does so smoothly, which one term
more allows for each closing edge e, T = X (C + R + r / (k + e)).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from semianalytic.cut.canonical import CanonicalFunction, log_share
from semianalytic.cut.layout import Layout, Zone, lies_between, outline
from semianalytic.cut.load import Load, per_set
from semianalytic.cut.panels import Panels, lay_panels
from semianalytic.cut.strength import PressurePart
from semianalytic.halfplane.rayleigh import (
    Array,
    CutPoints,
    RayleighFactors,
    rayleigh_factors,
)
from semianalytic.halfplane.rules import Rule
from semianalytic.halfplane.stuck import stuck_traction


@dataclass(frozen=True)
class ZoneFields:
    """Fields of a load and a set of zones, whether or not the edges satisfy Coulomb's law.

    `zones` run from the longitudinal front inward, in slowness; their edges may hold several
    neighbouring sets at once (see `panels`).  Without `tail` the fields behind the last edge are
    left out.  `closing` are terms (edge, r) of edges that close a gap.  `shared` are panels to be
    used, with ends at all edges of these zones, laid for others.
    """

    factors: RayleighFactors
    load: Load
    zones: tuple[Zone, ...]
    rule: Rule
    tail: bool = True
    closing: tuple[tuple[CutPoints, float | Array], ...] = ()
    shared: Panels | None = None

    @cached_property
    def panels(self) -> Panels:
        """Panels on a rule as fine and as long as these zones need."""
        if self.shared is not None:
            ends = tuple(self.shared.left[1:])
            _, layout = outline(self.factors, self.zones, self.tail, ends)
            return replace(self.shared, layout=layout)
        sets, load = np.shape(self.load.friction), self.load
        by_slip = load.resistance is not None or load.given_slope is not None
        tail = (
            self.tail or by_slip or self.factors.mode == "III"
        )  # slip behind the last edge counts
        return lay_panels(self.factors, self.zones, self.rule, sets, tail, self._cuts)

    @cached_property
    def _cuts(self) -> tuple[CutPoints, ...]:
        """Where fields change character within zones."""
        factors, cuts = self.factors, []
        if self.load.resistance is not None and factors.has_rayleigh_wave:
            covered = (lies_between(one.left, factors.front_c, one.right) for one in self.zones)
            cuts += [factors.front_c] if any(covered) else []
        if self.load.opened is not None:
            edges = ((one.left, one.right) for one in self.load.opened.zones)
            cuts += [edge for pair in edges for edge in pair if edge is not None]
        return tuple(cuts)

    @property
    def layout(self) -> Layout:
        """Which panels there are."""
        return self.panels.layout

    @cached_property
    def canonical(self) -> CanonicalFunction:
        """X, real, on panels that slip; X / M_+, real, on panels that stick."""
        resistance = self.load.resistance
        given = None if resistance is None else np.asarray(resistance)
        return CanonicalFunction(self.factors, self.panels, given)

    @cached_property
    def _pressure(self) -> PressurePart:
        sense = self.zones[-1].sense if self.zones else 0
        canonical, count = self.canonical, len(self.panels.sense)
        if self.normal is None:
            return PressurePart(self.load, canonical, sense, None, np.zeros(count, dtype=bool))
        normal = self.normal
        opened, at_edge = -normal.stick_transform, -float(normal.stick_transform_at_edge)
        return PressurePart(self.load, canonical, sense, opened, normal.layout.slipping, at_edge)

    @cached_property
    def normal(self) -> ZoneFields | None:
        """The normal problem on these panels, minus pressure for traction; None if the contact
        is closed."""
        opened = self.load.opened
        if opened is None:
            return None
        normal = Load(0.0, 0.0, -opened.base, 0.0, -opened.step, 0.0)
        factors = rayleigh_factors(self.factors.poisson_ratio, "I")
        return ZoneFields(
            factors, normal, opened.zones, self.rule, self.tail, opened.closing, self.panels
        )

    @cached_property
    def constant(self) -> Array:
        """R, from T(0) = Q_0 - mu b V(inf), (1,) or (k, 1)."""
        load, panels = self.load, self.panels
        at_zero = load.load_shear - load.far_slip_rate
        at_zero -= self._pressure.sense * load.friction * load.load_pressure
        value = at_zero / self.canonical.at_zero
        for edge, amount in self.closing:
            value = value - amount / edge.v
        sources, imag = self._pressure.sources
        if len(sources):
            integrals = panels.integrals(imag / panels.at.v)
            value = value + integrals[sources].sum(axis=0)[..., None] / np.pi
        return value

    @cached_property
    def _driven(self) -> Array:
        """(p, ..., n): Re C(-v + i0) at the nodes, with the terms of closing edges."""
        panels, total = self.panels, self._cauchy
        ends = [end.first for end in panels.left]
        for edge, amount in self.closing:
            total = total - amount / panels.from_ends[ends.index(edge.first)]
        return total

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
        return self.canonical.values * (self._driven + self.constant)

    @cached_property
    def stick_transform(self) -> Array:
        """(p, ..., n): T / M_+ where the interface sticks; T itself where it slips freely."""
        result, pressure = self._reduced.copy(), self._pressure
        if pressure.analytic:
            first = self.layout.ahead if self.factors.mode == "II" else 0
            result[first:] += pressure.on_stick(slice(first, None))
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
        for edge, amount in self.closing:
            cauchy += amount / (edge.v + flat)
        result = self.canonical.reciprocal_off_cut(flat) * cauchy
        if self._pressure.analytic:
            ratio = self.factors.m_plus(flat, "I") / self.factors.m_plus(flat)
            amount = self._pressure.amount
            if self.normal is not None:
                weight = self._pressure.sense * self.load.friction
                amount = -weight * self.normal.stick_transform_off_cut(flat)
            result = result + ratio * amount
        return np.asarray(result).reshape(np.shape(k))

    @cached_property
    def stick_transform_at_edge(self) -> Array:
        """Limit of T / M_+ at the contact edge when it sticks: K_II / (M_+(0) K_II of Q_0 = 1).

        () or (k,).
        """
        return np.asarray((self.constant + self._pressure.amount_at_edge)[..., 0])

    @cached_property
    def stick_transform_excess(self) -> Array:
        """(..., n): T / M_+ less its limit at a stuck contact edge, last panel, without loss."""
        at, factors = self.panels.at[-1], self.factors
        cauchy, growth = self._driven[-1], np.expm1(self.canonical.log_growth)
        excess = growth * (cauchy + self.constant) + cauchy
        pressure = self._pressure
        if not pressure.analytic:
            return excess
        if factors.mode == "II":
            ratio = np.expm1(0.5 * log_share(at.from_b, at.from_a, np.array(1.0 - factors.a)))
        else:
            ratio = pressure.mode_ratio[0][-1] - 1
        if self.normal is None:
            return excess + pressure.amount * ratio
        gained = -pressure.sense * self.load.friction * self.normal.stick_transform_excess
        return excess + pressure.amount_on(-1) * ratio + gained

    @cached_property
    def slip_rate_slope(self) -> Array:
        """(p, ..., n): dV/dv on panels that slip, 0 on panels that stick."""
        canonical, layout, pressure = self.canonical, self.layout, self._pressure
        real, imag = canonical.impedance
        slope = np.zeros_like(imag)
        behind, ahead, slip = layout.slip_behind, layout.slip_ahead, layout.slip
        sources, missed = pressure.sources
        slope[behind] = self._reduced[behind] / imag[behind]
        if len(ahead):
            product = self._reduced[ahead] * imag[ahead]
            if len(sources):
                product -= canonical.values[ahead] * missed[ahead] * real[ahead]
            slope[ahead] = product / (np.square(real[ahead]) + np.square(imag[ahead]))
        if canonical.resistance is not None and len(slip):
            modulus, _ = canonical.excess_impedance
            size = np.abs(imag[slip])
            size[: len(ahead)] = np.hypot(real[ahead], imag[ahead])
            slope[slip] -= canonical.values[slip] * missed[slip] * canonical.eta / np.square(size)
            slope[slip] /= modulus
        if pressure.analytic:
            slope[slip] -= pressure.over_impedance[slip]
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
        if load.opened is not None:
            return load.friction * load.opened.pressure(edge)
        pressure = np.full(edge.v.shape, load.base_pressure)
        if load.load_pressure:
            mode_one = stuck_traction(self.factors.poisson_ratio, "I")
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
