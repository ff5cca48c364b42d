"""Compute the exact fields of given slip zones by solving a Riemann-Hilbert problem (section 4).

On the cut k = -v + i0 the transform T of the shear traction satisfies Im T = known where the
interface slips and Im (T / M_+) = 0 where it sticks. With a canonical function X that is real on
slip and has the phase of M_+ on stick,

    T = s f P + X (C + R),   P = P_0 M_+^I / M_+^I(0),

where C is a Cauchy integral over the parts of the cut on which s f P does not satisfy its
condition, and R is a constant that follows from T(0).  Of a load whose front moves over the slot
with slowness p, the part of R that its amplitude makes, and P, have the factor k / (k + p), and the
residue at k = -p takes the place of T(0) (docs/theory.md, "Loads whose front moves").  Where slip
meets the resistance eta V, Im (1 + eta / M) T is known instead, and X has the phase of
M / (M + eta) there.  Slip rate and traction follow from

    dV/dv = -Im(T / M_+) / (pi kappa v M_+(v)),    dtau/dv = Im T / (pi v).

`canonical` supplies X, which determines the behaviour at each edge, and `strength` the sources of
C. `ZoneFields` computes the transform and the slopes of slip rate and traction;
`ZoneFields.mismatch` computes the mismatch at the edges, whose Jacobian Newton's method forms from
neighbouring zones (`selfsimilar.edges`). Units are b = mu = 1; V is one-sided. See docs/theory.md,
"Slip under a step, for given zones".

The normal problem is the same in mode I, with opening for slip, no friction, and minus the pressure
for traction. A gap closes smoothly behind its opening, which requires one more term for each
closing edge e, T = X (C + R + r / (k + e)) (docs/separation.md, "The normal problem"). Slip that
meets resistance has the same term where it borders on an opening: V, or its finite part, is 0 there
(docs/rate.md, "A film that opens").
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from semianalytic.cut.canonical import CanonicalFunction
from semianalytic.cut.layout import Layout, Zone, lies_between, outline
from semianalytic.cut.load import Load, normal_load, per_set
from semianalytic.cut.panels import Panels, lay_panels
from semianalytic.cut.running import Power, RunningIntegral, split_power
from semianalytic.cut.strength import PressurePart
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import (
    Array,
    CutPoints,
    RayleighFactors,
    rayleigh_factors,
)
from semianalytic.halfplane.rules import Rule, finer_rule


@dataclass(frozen=True)
class ZoneFields:
    """Fields of a load and a set of zones, whether or not the edges satisfy Coulomb's law.

    Attributes
    ----------
    factors : RayleighFactors
    load : Load
    zones : tuple of Zone
        From the longitudinal front inward, in slowness; their edges may hold several
        neighbouring sets at once (see `panels`).
    rule : Rule
    tail : bool
        Whether the fields behind the last edge are included.
    closing : tuple of (edge, r)
        Terms of edges that close a gap.
    shared : Panels or None
        Panels laid for other zones that are to be used, with ends at all edges of these zones.
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
        """Strip of analyticity, over pi, and additional length in y, of slip under strong
        resistance.

        They apply to slip up to the contact edge: M + eta vanishes at about v = i eta / kappa.
        """
        edge = self.zones[-1].left if self.zones and self.zones[-1].right is None else None
        if edge is None or self.load.resistance is None:
            return 1.0, 0.0
        # Modulus of that zero over the slowness of the edge.
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
            # there (docs/theory.md, "Other conditions on the same cut").
            resists = any(lies_between(one.left, front, one.right) for one in self.zones)
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

    @cached_property
    def _pressure(self) -> PressurePart:
        sense = self.zones[-1].last_sense if self.zones else 0
        canonical, count = self.canonical, len(self.panels.sense)
        if self.normal is None:
            return PressurePart(self._resolved, canonical, sense, None, np.zeros(count, dtype=bool))
        normal = self.normal
        # The normal problem has minus the pressure for traction, hence the signs.
        opened, at_edge = -normal.stick_transform, -normal.constant
        return PressurePart(
            self._resolved, canonical, sense, opened, normal.layout.slipping, at_edge
        )

    @cached_property
    def normal(self) -> ZoneFields | None:
        """The normal problem on these panels, minus pressure for traction; None if all is
        closed."""
        opened = self.load.opened
        if opened is None:
            return None
        factors, seen = (
            rayleigh_factors(self.factors.poisson_ratio, "I"),
            self.factors.seen_in_plane,
        )
        panels = self.panels
        if not self.factors.has_rayleigh_wave:
            panels = panels.seen_by(seen)
        return ZoneFields(
            factors,
            normal_load(opened.base, opened.step, opened.slowness),
            (opened.zone.seen_by(seen),),
            self.rule,
            self.tail,
            tuple((seen(edge), amount) for edge, amount in opened.closing),
            panels,
        )

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
        """R without the terms of closing edges and far in, where its factor is 1, (1,) or (k,
        1)."""
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

    @cached_property
    def transform_at_edge(self) -> Array:
        """Limit of T at a contact edge that slips, (1,) or (k, 1).

        The pressure contributes only where the contact is open there.
        """
        value = np.sign(self.canonical.values[-1, ..., -1:]) * self.constant
        if self.normal is not None and self.layout.open[-1]:
            weight = self._pressure.sense * self.load.friction
            value = value - weight * self.normal.transform_at_edge
        return np.asarray(value)

    @cached_property
    def borders(self) -> tuple[tuple[int, Array], ...]:
        """Pairs (panel, exponent of X, (..., 1)) for each border of the opening under resistance.

        The border is the right end of the panel.
        """
        canonical, layout = self.canonical, self.layout
        if canonical.resistance is None or self.load.opened is None:
            return ()
        _, turn = canonical.excess_impedance
        borders, row = [], {panel: i for i, panel in enumerate(layout.slip)}
        for panel in range(len(layout.sense) - 1):
            if panel in row and panel + 1 in row and layout.open[panel] != layout.open[panel + 1]:
                # theta is the phase of (M + eta) / M on the closed side; X ~ d^(+-theta / pi), with
                # the sign of the side (docs/rate.md, "A film that opens").
                if layout.open[panel]:
                    borders.append((panel, -turn[row[panel + 1], ..., :1] / np.pi))
                else:
                    borders.append((panel, turn[row[panel], ..., -1:] / np.pi))
        return tuple(borders)

    @cached_property
    def _vanishing(self) -> tuple[tuple[int, CutPoints], ...]:
        """Pairs (panel, its right end) at which an additional term makes the slip rate vanish.

        These are the borders of the opening, and ends of zones where the opening closes.
        """
        panels, zone = self.panels, np.array(self.layout.zone)
        held = [
            int(np.flatnonzero(self.layout.slipping & (zone == index))[-1])
            for index, one in enumerate(self.zones)
            if one.held
        ]
        every = sorted([*(panel for panel, _ in self.borders), *held])
        return tuple((panel, end) for panel in every if (end := panels.right[panel]) is not None)

    @cached_property
    def _sharp(self) -> tuple[RunningIntegral, ...]:
        """Slip rates of unit terms r / (k + e), one for each edge at which the slip rate
        vanishes."""
        panels, exponents = self.panels, dict(self.borders)
        result = []
        for panel, edge in self._vanishing:
            slope = self._by_impedance(self.canonical.values * self._share(edge))
            slope /= np.pi * panels.at.v
            powers: list[Power] = []
            if self._jumps_at(panel):
                _, jump = self._jump(panel, edge)
                powers.append(Power(panel + 1, True, exponents[panel], jump))
            # Beside the border the slope is d^(eps - 1) on both sides, which no rule resolves for
            # small eps: its integral is taken in closed form.
            elif panel in exponents:
                for one, at_left in ((panel, False), (panel + 1, True)):
                    powers.append(split_power(panels, slope, one, at_left, exponents[panel]))
            result.append(RunningIntegral(panels, slope, self.factors.c, powers=tuple(powers)))
        return tuple(result)

    def _jumps_at(self, panel: int) -> bool:
        """Return whether slip rate and traction jump at a border, which requires a real impedance.

        M is real ahead of the shear front in antiplane shear.
        """
        ahead = panel + 1 < self.layout.ahead and not self.factors.has_rayleigh_wave
        return ahead and panel in dict(self.borders)

    def _jump(self, panel: int, edge: CutPoints) -> tuple[Array, Array]:
        """Return the slip rate ahead of a border and its jump, per term r, (..., 1).

        The traction falls from eta V to 0 there.
        """
        canonical, row = self.canonical, int(np.searchsorted(self.layout.slip, panel))
        fall = canonical.values[panel, ..., -1:] / edge.v
        return fall / canonical.eta[row, ..., -1:], fall / canonical.impedance[0][panel, ..., -1:]

    @cached_property
    def _terms(self) -> tuple[tuple[CutPoints, float | Array], ...]:
        """All terms (edge, r): those given, and those that make the slip rate vanish."""
        amounts = self._amounts
        edges = [edge for _, edge in self._vanishing]
        return (*self.closing, *zip(edges, amounts, strict=True))

    @cached_property
    def _amounts(self) -> tuple[Array, ...]:
        """Amounts r that make the slip rate vanish where it must, (1,) or (k, 1) each."""
        if not self._vanishing:
            return ()
        zone, plain = np.array(self.layout.zone), self._given_slope
        totals = np.stack(
            [self.panels.integrals(plain), *(sharp.totals for sharp in self._sharp)], axis=-1
        )
        # One equation per such edge: V gained from the beginning of its zone is zero there; V is
        # linear in the amounts.
        rows = []
        for index, (panel, edge) in enumerate(self._vanishing):
            here = np.flatnonzero(self.layout.slipping & (zone == zone[panel]))
            row = totals[here[here <= panel]].sum(axis=0)
            if self.zones[zone[panel]].left is None:
                row[..., 0] += per_set(self.load.far_slip_rate)
            if self._jumps_at(panel):
                row[..., index + 1] -= self._jump(panel, edge)[0][..., 0]
            rows.append(row)
        both = np.stack(rows, axis=-2)
        return tuple(np.moveaxis(_solved(both[..., 1:], -both[..., 0])[..., None], -2, 0))

    def _share(self, edge: CutPoints) -> Array:
        """Return 1 / (k + e) - 1 / e at k = -v, (p, ..., n), for a closing edge e that ends a
        panel."""
        return self.panels.at.v / edge.v * self._pole(edge)

    def _pole(self, edge: CutPoints) -> Array:
        """Return 1 / (k + e) at k = -v, (p, ..., n)."""
        ends = (*self.panels.left, self.panels.right[-1])
        index = next(i for i, end in enumerate(ends) if end and end.first == edge.first)
        # k + e = e - v, whose digits are exact in the panels that end at e.
        return -1 / self.panels.from_ends[index]

    @cached_property
    def _cauchy(self) -> Array:
        """Re C(-v + i0) at the nodes, (p, ..., n)."""
        panels, (sources, imag) = self.panels, self._pressure.sources
        if not len(sources):
            return imag
        pairs, weights = self.layout.pairs_from(tuple(sources.tolist())), panels.jacobian * imag
        total = pairs.collect(panels.cauchy(pairs, weights[pairs.source]))
        # A principal value where source and target are the same panel.
        total[sources] += panels.principal_values(sources, weights[sources])
        return total / -np.pi

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
    def transform(self) -> NDArray[np.complex128]:
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
        """T / M_+ less its limit at a stuck contact edge on the last panel, (..., n), without
        loss."""
        cauchy, growth = self._cauchy[-1], np.expm1(self.canonical.log_growth)
        for edge, amount in self._terms:
            cauchy = cauchy + amount * self._pole(edge)[-1]
        beyond = self._beyond_factor
        if self.load.slowness:
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

    @property
    def _beyond_factor(self) -> float | Array:
        """v / (v - p) - 1 on the last panel, (..., n), without loss; 0 for p = 0."""
        slowness = self.load.slowness
        return slowness / (self.panels.at.v[-1] - slowness) if slowness else 0.0

    @cached_property
    def slip_rate_slope(self) -> Array:
        """dV/dv on panels that slip, (p, ..., n), 0 on panels that stick.

        The powers of `rate_integral` are not included.
        """
        if not self.borders:
            return self._slope_of(self._reduced)
        slope = self._given_slope
        for amount, sharp in zip(self._amounts, self._sharp, strict=True):
            slope = slope + amount * sharp.density
        return slope

    @cached_property
    def _given_slope(self) -> Array:
        """dV/dv without the terms that make the slip rate vanish, (p, ..., n)."""
        driven = self._cauchy + self._driven
        for edge, amount in self.closing:
            driven = driven + amount * self._share(edge)
        return self._slope_of(self.canonical.values * driven)

    def rate_integral(self, tail: float | Array | None = None) -> RunningIntegral:
        """Return V on panels that slip as a running integral; `tail` as of `RunningIntegral`."""
        residue = self.residue if self.layout.pole >= 0 else None
        return RunningIntegral(
            self.panels, self.slip_rate_slope, self.factors.c, self._powers, residue, tail
        )

    @property
    def _powers(self) -> tuple[Power, ...]:
        """Parts of dV/dv that are large beside borders of the opening."""
        return tuple(
            replace(power, amount=amount * power.amount)
            for amount, sharp in zip(self._amounts, self._sharp, strict=True)
            for power in sharp.powers
        )

    @cached_property
    def _reduced_at_c(self) -> Array:
        """X (Re C + R) at the Rayleigh front where slip covers it, (1,) or (k, 1).

        The nodes straddle c evenly, so that a sum over them is a principal value (docs/solver.md,
        "Quadrature").
        """
        panels, (sources, imag) = self.panels, self._pressure.sources
        driven, slowness = self._first_constant, self.load.slowness
        if slowness:
            driven = driven + self.amplitude * slowness / (self.factors.c - slowness)
        if len(sources):
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

    @property
    def _modulus(self) -> Array:
        """|M + eta| / |M| at the nodes of panels that slip; 1 without resistance."""
        if self.canonical.resistance is None:
            return np.ones((len(self.layout.slip), *[1] * (self.panels.jacobian.ndim - 1)))
        return self.canonical.excess_impedance[0]

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

    @cached_property
    def traction_slope(self) -> Array:
        """dtau/dv on panels that stick, (p, ..., n), 0 on panels that slip."""
        # Im T / (pi v), with T / M_+ real and M_+(-v + i0) = M / (kappa M_+(v)).
        unit = self.canonical.impedance[1] / (self.canonical.m_plus * self.panels.at.v)
        slope = unit * self.stick_transform / (np.pi * self.factors.kappa)
        slope[self.layout.slip] = 0.0
        return slope

    @cached_property
    def base_traction(self) -> float | Array:
        """Traction ahead of all waves, a number or (k,).

        In the normal problem it is chosen such that, on these panels, the pressure falls to zero
        exactly where the contact opens. Beside that edge the pressure is small compared with the
        base, and so is the strength of slip that ends there.
        """
        if self.factors.mode != "I":
            return self.load.base_shear - per_set(self.load.far_slip_rate)
        ahead = self.panels.integrals(self.traction_slope)[self.layout.regions[0]]
        return np.asarray(-ahead.sum(axis=0))

    def strength(self, edge: CutPoints) -> Array:
        """Return the strength f p at an edge."""
        return self.load.friction * self.load.pressure(self.factors, edge)

    @cached_property
    def _excess_slope(self) -> Array:
        """Slope of traction less that of strength in the sense of the following zone, (p, ...,
        n)."""
        load, slope = self.load, self.traction_slope
        if load.load_pressure == 0 or not self.zones:
            return slope
        senses = [zone.sense for zone in self.zones]
        following = np.array([*senses, senses[-1]])[list(self.layout.zone)]
        factor = (following * ~self.layout.slipping).reshape(-1, *[1] * (slope.ndim - 1))
        return slope - factor * load.friction * self._pressure.slope

    def mismatch(self) -> Array:
        """Return the mismatch of the conditions at the edges, one row per edge, (e,) or (e, k).

        For each zone it is the traction less sense times strength where the zone opens (divided by
        the width of the stick gap ahead of it if that is narrow), and the slip rate that is left
        where it heals. See docs/theory.md, "Where the edges are".
        """
        load, layout = self.load, self.layout
        integrals = self.panels.integrals(self._excess_slope + self.slip_rate_slope)
        for power in self._powers:
            integrals[power.panel] += power.total
        # Stretches of stick and slip alternate: a stretch of stick gains traction, a zone slip
        # rate.
        gains = iter(np.add.reduceat(integrals, [part[0] for part in layout.regions], axis=0))
        rows: list[Array] = []
        outward: Zone | None = None
        for zone in self.zones:
            if zone.left is not None:
                excess = np.asarray(self._excess_at_opening(zone, outward, next(gains)))
                with_opening = (
                    self.load.opened is not None and zone.left is self.load.opened.zone.left
                )
                rows.append(np.zeros_like(excess) if with_opening else excess)
            if zone.right is not None:
                ahead = per_set(load.far_slip_rate) if zone.left is None else 0.0
                rate = next(gains) + ahead
                # A zone that ends with the opening has slip rate 0 there by its additional term.
                rows.append(np.zeros_like(rate) if zone.held else rate)
            outward = zone
        return np.stack(rows) if rows else np.zeros(0)

    def _excess_at_opening(self, zone: Zone, outward: Zone | None, gain: Array) -> Array:
        """Return traction less sense times strength where a zone opens, () or (k,).

        It follows from the traction gained on the stick before the zone, and is divided by the
        width of a narrow gap to the zone outward of it.
        """
        load = self.load
        if outward is None:
            strength = per_set(load.friction) * load.base_pressure
            excess = gain + load.base_shear - per_set(load.far_slip_rate) - zone.sense * strength
            if self.normal is None:
                return np.asarray(excess)
            # as if pressure fell from its base to 0 exactly: beside the opening it is known
            # relative to itself, beside the longitudinal front what the base lacks of friction is
            fall = self.panels.integrals(self.normal.traction_slope)[self.layout.regions[0]]
            share = fall.sum(axis=0) / -self.normal.base_traction
            rest = share * (load.base_pressure + self.normal.base_traction)
            return np.asarray(excess + zone.sense * per_set(load.friction) * rest)
        if zone.left is None or outward.right is None:
            return gain
        # Between zones of opposite sense the traction must go from one bound of friction to the
        # other.
        if outward.last_sense != zone.sense:
            gain = gain + (outward.last_sense - zone.sense) * self.strength(outward.right)[..., 0]
        return np.asarray(gain / np.minimum(1.0, zone.left.minus(outward.right)[..., 0]))


def _solved(matrix: Array, right: Array) -> Array:
    """Return x of matrix (..., m, m) x = right (..., m)."""
    if matrix.shape[-1] == 1:
        return np.asarray(right / matrix[..., 0])
    return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
