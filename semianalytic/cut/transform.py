"""Form the transform of the shear traction of given zones (section 4).

On the cut k = -v + i0 the transform T satisfies Im T = known where the interface slips and
Im (T / M_+) = 0 where it sticks. With a canonical function X that is real on slip and has the phase
of M_+ on stick,

    T = s f P + X (C + R),   P = P_0 M_+^I / M_+^I(0),

where C is a Cauchy integral over the parts of the cut on which s f P does not satisfy its
condition, and R is a constant that follows from T(0).  For a load whose front moves over the slot
with slowness p, the part of R that its amplitude makes, and P, have the factor k / (k + p), and the
residue at k = -p takes the place of T(0).  Where slip
meets the resistance eta V, Im (1 + eta / M) T is known instead, and X has the phase of
M / (M + eta) there.

The normal problem is the same in mode I, with opening for slip, no friction, and minus the pressure
for traction. A gap closes smoothly behind its opening, which requires one more term for each
closing edge e, T = X (C + R + r / (k + e)).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from semianalytic.cut.canonical import CanonicalFunction
from semianalytic.cut.load import Load, normal_load, per_set
from semianalytic.cut.quadrature.laying import lay_panels
from semianalytic.cut.quadrature.layout import Layout, Zone, lies_between, outline
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.cut.strength import PressurePart
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import Rule, finer_rule
from semianalytic.scene.arrays import Array, Complex


@dataclass(frozen=True)
class GivenZones:
    """A load and a set of zones, their panels and their canonical function X."""

    factors: RayleighFactors
    load: Load
    # from the longitudinal front inward, in slowness; their edges may hold several neighbouring
    # sets at once (see `panels`)
    zones: tuple[Zone, ...]
    rule: Rule
    tail: bool = True  # whether the fields behind the last edge are included
    closing: tuple[tuple[CutPoints, float | Array], ...] = ()  # terms of edges that close a gap
    # panels laid for other zones that are to be used, with ends at all edges of these zones
    shared: Panels | None = None

    @cached_property
    def panels(self) -> Panels:
        """Panels on a rule as fine and as long as these zones need."""
        if self.shared is not None:
            ends, count = tuple(self.shared.left[1:]), len(self.shared.left)
            _, layout = outline(self.factors, self.zones, True, ends, laid=True)
            if len(layout.sense) > count:
                _, layout = outline(self.factors, self.zones, False, ends, laid=True)
            return replace(self.shared, layout=layout)
        sets, load = np.shape(self.load.friction), self.load
        by_slip = load.resists_rate or load.given_slope is not None
        # Slip behind the last edge enters ln X through the phase of M / (M + eta), and C through a
        # given slope: it cannot be left out then.
        tail = self.tail or by_slip
        opening = load.opened.zone if load.opened else None
        rule = finer_rule(self.rule, *self._beside_resistance)
        return lay_panels(self.factors, self.zones, rule, sets, tail, self._cuts, opening)

    @property
    def _beside_resistance(self) -> tuple[float, float]:
        """Strip of analyticity over pi, and more length in y, of slip up to an edge under strong
        films.
        """
        edge = self.zones[-1].left if self.zones and self.zones[-1].right is None else None
        if edge is None or self.load.resistance is None:
            return 1.0, 0.0
        # M + eta vanishes at about v = i eta / kappa: its modulus over the slowness of the edge.
        root = float(np.max(np.abs(self.load.resistance))) / self.factors.kappa / edge.first[0]
        return 1 - float(np.arctan(root)) / np.pi, float(np.log1p(root))

    @cached_property
    def _cuts(self) -> tuple[CutPoints, ...]:
        """Points within zones at which fields change their character."""
        factors, cuts, opened = self.factors, [], self.load.opened
        # The normal problem is solved on the same panels, which therefore end at its cuts too.
        if opened is not None:
            cuts += [factors.of_in_plane(cut) for cut in factors.in_plane.cuts[:-1]]
        if self.load.resists_rate and factors.has_rayleigh_wave:
            front = factors.front_c
            # At c_R the phase of M / (M + eta) jumps by pi, so that panels under resistance end
            # there.
            resists = any(lies_between(zone.left, front, zone.right) for zone in self.zones)
            if opened is not None:
                resists &= not lies_between(opened.zone.left, front, opened.zone.right)
            cuts += [front] if resists else []
        return tuple(cuts)

    @property
    def layout(self) -> Layout:
        """Order and kinds of the panels."""
        return self.panels.layout

    @cached_property
    def canonical(self) -> CanonicalFunction:
        """Canonical function: X, real, on panels that slip; X / M_+, real, on panels that stick."""
        resistance = self._resolved.resistance
        given = None if resistance is None else np.asarray(resistance)
        if given is not None and self.load.opened is not None:
            # The film carries no traction where the contact is open.
            closed = ~np.array(self.layout.open).reshape(-1, *[1] * (self.panels.jacobian.ndim - 1))
            given = given * closed
        return CanonicalFunction(self.factors, self.panels, given)

    @cached_property
    def _resolved(self) -> Load:
        """The load, with linearised strength evaluated on the panels."""
        load, panels = self.load, self.panels
        if load.linearised is None:
            return load
        resistance, slope = load.linearised.at(panels.at, panels.layout, panels.jacobian)
        return replace(load, resistance=resistance, given_slope=slope)


class ZoneTransform(GivenZones):
    """The transform T of the shear traction, with the terms in `_terms`."""

    @property
    def _terms(self) -> tuple[tuple[CutPoints, float | Array], ...]:
        """Terms (edge, r) of T in addition to C + R: those given."""
        return self.closing

    @cached_property
    def normal(self) -> Self | None:
        """The normal problem on these panels, minus pressure for traction; None if closed."""
        opened = self.load.opened
        if opened is None:
            return None
        seen, panels = self.factors.seen_in_plane, self.panels
        if not self.factors.has_rayleigh_wave:
            panels = panels.seen_by(seen)
        return replace(
            self,
            factors=rayleigh_factors(self.factors.poisson_ratio, "I"),
            load=normal_load(opened.base, opened.step, opened.slowness),
            zones=(opened.zone.seen_by(seen),),
            closing=tuple((seen(edge), amount) for edge, amount in opened.closing),
            shared=panels,
        )

    @cached_property
    def _pressure(self) -> PressurePart:
        sense = self.zones[-1].last_sense if self.zones else 0
        canonical, count = self.canonical, len(self.panels.sense)
        if self.normal is None:
            return PressurePart(self._resolved, canonical, sense, None, np.zeros(count, dtype=bool))
        # The normal problem has minus the pressure for traction, hence the signs.
        opened, at_edge = -self.normal.stick_transform, -self.normal.constant
        slipping = self.normal.layout.slipping
        return PressurePart(self._resolved, canonical, sense, opened, slipping, at_edge)

    @cached_property
    def _cauchy(self) -> Array:
        """Re C(-v + i0) at the nodes, (p, ..., n)."""
        panels, (sources, imag) = self.panels, self._pressure.sources
        if not len(sources):
            return imag
        pairs, weights = self.layout.pairs_from(sources), panels.jacobian * imag
        total = pairs.collect(panels.cauchy(pairs, weights[pairs.source]))
        # A principal value where source and target are the same panel.
        total[sources] += panels.principal_values(sources, weights[sources])
        return total / -np.pi

    @cached_property
    def amplitude(self) -> Array:
        """Part of R that has the factor k / (k + p), (1,) or (k, 1).

        It follows from the residue of T at k = -p, or from T(0) = Q_0 - mu b V(inf) for p = 0.
        """
        load = self.load
        at_load = load.load_shear - load.far_slip_rate
        # P(0) = P_0: the part s f P of T(0) is subtracted before the division by X(0).
        at_load -= self._pressure.sense * load.friction * load.load_pressure
        return np.asarray(at_load / self.canonical.off_cut(-load.slowness))

    @cached_property
    def _driven(self) -> Array:
        """R without the terms of closing edges, with its factor, at the nodes; (1,) if it is 1."""
        factor = self.load.front_factor(self.panels.at)
        if self.load.slowness:
            return np.asarray(self._first_constant + self.amplitude * (factor - 1.0))
        return self._first_constant

    @cached_property
    def _first_constant(self) -> Array:
        """R without closing edges and far in, where its factor is 1, (1,) or (k, 1)."""
        panels, value = self.panels, self.amplitude
        sources, imag = self._pressure.sources
        if len(sources):
            integrals = panels.integrals(imag / panels.at.v)
            # C(0) = -(1 / pi) int Im C / w dw is subtracted.
            value = value + integrals[sources].sum(axis=0)[..., None] / np.pi
        return value

    @cached_property
    def constant(self) -> Array:
        """R with the terms of closing edges, (1,) or (k, 1)."""
        # Terms are formed as r (1 / (k + e) - 1 / e), which leaves T(0) unchanged.
        return self._first_constant - sum(amount / edge.v for edge, amount in self._terms)

    def _share(self, edge: CutPoints) -> Array:
        """Return 1 / (k + e) - 1 / e at k = -v, (p, ..., n), for a closing edge e."""
        return self.panels.at.v / edge.v * self._pole(edge)

    def _pole(self, edge: CutPoints) -> Array:
        """Return 1 / (k + e) at k = -v, (p, ..., n)."""
        ends = (*self.panels.left, self.panels.right[-1])
        index = next(i for i, end in enumerate(ends) if end and end.first == edge.first)
        # k + e = e - v, whose digits are exact in the panels that end at e.
        return -1 / self.panels.from_ends[index]

    @cached_property
    def _reduced(self) -> Array:
        """X (Re C + R) at the nodes, (p, ..., n); divided by M_+ on panels that stick."""
        driven = self._cauchy + self._driven
        for edge, amount in self._terms:
            driven = driven + amount * self._share(edge)
        return self.canonical.values * driven

    @cached_property
    def stick_transform(self) -> Array:
        """T / M_+ where the interface sticks, T itself where it slips freely, (p, ..., n)."""
        result, pressure = self._reduced.copy(), self._pressure
        if pressure.analytic:
            # In mode II M_+^I / M_+ is imaginary ahead of the shear front, so that s f P has no
            # real part to add there.
            first = self.layout.ahead if self.factors.mode == "II" else 0
            result[first:] += pressure.on_stick(slice(first, None))
        return result

    @cached_property
    def transform(self) -> Complex:
        """T(-v + i0) itself at the nodes of all panels, (p, ..., n)."""
        canonical, panels = self.canonical, self.panels
        own = self.factors.impedance_on_cut(panels.at) / (self.factors.kappa * canonical.m_plus)
        result = own * self.stick_transform
        slip, pressure = self.layout.slip, self._pressure
        if not len(slip):
            return result
        _, missed = pressure.sources
        parts = self._reduced[slip] + 1j * (canonical.values * missed)[slip]
        # `values` leave out the phase of M / (M + eta), which is restored here.
        if canonical.resistance is not None:
            parts = parts * np.exp(-1j * canonical.excess_impedance[1])
        result[slip] = parts + pressure.on_slip
        return result

    @cached_property
    def transform_at_edge(self) -> Array:
        """Limit of T at a contact edge that slips, (1,) or (k, 1)."""
        value = np.sign(self.canonical.values[-1, ..., -1:]) * self.constant
        if self.normal is not None and self.layout.open[-1]:  # elsewhere pressure adds nothing
            weight = self._pressure.sense * self.load.friction
            value = value - weight * self.normal.transform_at_edge
        return np.asarray(value)

    def stick_transform_off_cut(self, k: Array) -> Array:
        """Return T / M_+ at k > 0, any shape, which drives the slot faces (one set of zones).

        It has a pole at k = -p if the front of the load moves away from the edge.
        """
        panels, flat, slowness = self.panels, np.ravel(k), self.load.slowness
        cauchy = np.full_like(flat, self.constant[0])
        factor = flat / (flat + slowness) if slowness else 1.0
        if slowness:
            cauchy += self.amplitude[0] * (factor - 1.0)
        sources, imag = self._pressure.sources
        for source in sources:
            kernel = 1 / (panels.at.v[source] + flat[:, None])
            weights = panels.rule.weights * panels.jacobian[source] * imag[source]
            cauchy -= kernel @ weights / np.pi
        for edge, amount in self._terms:
            cauchy += np.ravel(amount) / (edge.v + flat)
        result = self.canonical.reciprocal_off_cut(flat) * cauchy
        if self._pressure.analytic:
            ratio = self.factors.m_plus(flat, "I") / self.factors.m_plus(flat)
            amount = self._pressure.amount_at_edge * factor
            if self.normal is not None:
                weight = self._pressure.sense * self.load.friction
                amount = -weight * self.normal.stick_transform_off_cut(flat)
            result = result + ratio * amount
        return np.asarray(result).reshape(np.shape(k))

    @cached_property
    def stick_transform_at_edge(self) -> Array:
        """Limit of T / M_+ at a stuck contact edge: K_II / (M_+(0) K_II of Q_0 = 1), () or (k,)."""
        return np.asarray((self.constant + self._pressure.amount_at_edge)[..., 0])

    @property
    def held_at_edge(self) -> float | Array:
        """Part of `stick_transform_at_edge` that friction holds, a number or (k,)."""
        return per_set(self._pressure.amount_at_edge)

    @cached_property
    def stick_transform_excess(self) -> Array:
        """T / M_+ less its limit at a stuck edge on the last panel, (..., n), to all digits."""
        cauchy, growth = self._cauchy[-1], np.expm1(self.canonical.log_growth)
        for edge, amount in self._terms:
            cauchy = cauchy + amount * self._pole(edge)[-1]
        # v / (v - p) - 1, without loss.
        slowness = self.load.slowness
        beyond = slowness / (self.panels.at.v[-1] - slowness) if slowness else 0.0
        if slowness:
            cauchy = cauchy + self.amplitude * beyond
        # (1 + growth)(R + C) - R, rearranged so that no digits cancel.
        excess = growth * (cauchy + self.constant) + cauchy
        pressure = self._pressure
        if not pressure.analytic:
            return excess
        ratio = pressure.ratio_less_edge
        if self.normal is None:
            return excess + pressure.amount_at_edge * (ratio + beyond * (1 + ratio))
        gained = -pressure.sense * self.load.friction * self.normal.stick_transform_excess
        return excess + pressure.amount_on(-1) * ratio + gained
