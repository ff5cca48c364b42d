"""Compute the exact fields of given slip zones by solving a Riemann-Hilbert problem (section 4).

The classes follow docs/theory.md in its order: `GivenZones` and `ZoneTransform` (`transform`, with
`strength`), `ZoneSlopes`, and `ZoneFields`, where the slip rate is made to vanish where it must and
the conditions at the edges are formed.  `ZoneFields.mismatch` is what is left of these
(`selfsimilar.zones.edges`).

Slip that meets resistance has a further term r / (k + e) of T where it borders on an opening: V, or
its finite part, is 0 there.  So has a zone that ends with its
opening.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semianalytic.cut.load import per_set
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.quadrature.running import PanelIntegral, Power, split_power
from semianalytic.cut.transform import ZoneTransform
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.scene.arrays import Array


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
        # dV/dv = X (C + R) / (pi v m) near c, with m = m'(c) (v - c).
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


class ZoneFields(ZoneSlopes):
    """Fields of a load and a set of zones, whether or not the edges satisfy Coulomb's law.

    Its attributes are those of `transform.GivenZones`.
    """

    @cached_property
    def borders(self) -> tuple[tuple[int, Array], ...]:
        """Pairs (panel that ends there, exponent of X (..., 1)) of borders under resistance."""
        canonical, layout = self.canonical, self.layout
        if canonical.resistance is None or self.load.opened is None:
            return ()
        _, turn = canonical.excess_impedance
        borders, row = [], {panel: i for i, panel in enumerate(layout.slip)}
        for panel in range(len(layout.sense) - 1):
            if panel in row and panel + 1 in row and layout.open[panel] != layout.open[panel + 1]:
                # theta is the phase of (M + eta) / M on the closed side; X ~ d^(+-theta / pi), with
                # the sign of the side.
                if layout.open[panel]:
                    borders.append((panel, -turn[row[panel + 1], ..., :1] / np.pi))
                else:
                    borders.append((panel, turn[row[panel], ..., -1:] / np.pi))
        return tuple(borders)

    @cached_property
    def _vanishing(self) -> tuple[tuple[int, CutPoints], ...]:
        """Pairs (panel, right end) where a term makes V vanish: borders and closing ends."""
        panels, zone = self.panels, np.array(self.layout.zone)
        held = [
            int(np.flatnonzero(self.layout.slipping & (zone == index))[-1])
            for index, part in enumerate(self.zones)
            if part.held
        ]
        every = sorted([*(panel for panel, _ in self.borders), *held])
        return tuple((panel, end) for panel in every if (end := panels.right[panel]) is not None)

    @cached_property
    def _sharp(self) -> tuple[PanelIntegral, ...]:
        """Slip rates of unit terms r / (k + e), one for each edge where V vanishes."""
        panels, exponents = self.panels, dict(self.borders)
        result = []
        for panel, edge in self._vanishing:
            slope = self._by_impedance(self.canonical.values * self._share(edge))
            slope /= np.pi * panels.at.v
            powers: list[Power] = []
            if self._jumps_at(panel):
                _, jump = self._jump(panel, edge)
                powers.append(Power(panel + 1, True, exponents[panel], jump))
            # Next to the border the slope is d^(eps - 1) on both sides, which no rule resolves for
            # small eps: its integral is taken in closed form.
            elif panel in exponents:
                for end, at_left in ((panel, False), (panel + 1, True)):
                    powers.append(split_power(panels, slope, end, at_left, exponents[panel]))
            result.append(PanelIntegral(panels, slope, self.factors.c, powers=tuple(powers)))
        return tuple(result)

    def _jumps_at(self, panel: int) -> bool:
        """Return whether V and traction jump at a border: M is real, ahead of b in mode III."""
        ahead = panel + 1 < self.layout.ahead and not self.factors.has_rayleigh_wave
        return ahead and panel in dict(self.borders)

    def _jump(self, panel: int, edge: CutPoints) -> tuple[Array, Array]:
        """Return V ahead of a border, where traction falls from eta V, and its jump per r, (...,
        1).
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

    @cached_property
    def _given_slope(self) -> Array:
        """dV/dv without the terms that make the slip rate vanish, (p, ..., n)."""
        driven = self._cauchy + self._driven
        for edge, amount in self.closing:
            driven = driven + amount * self._share(edge)
        return self._slope_of(self.canonical.values * driven)

    @cached_property
    def slip_rate_slope(self) -> Array:
        """dV/dv on slip, (p, ..., n), 0 on stick, without the powers of `rate_integral`."""
        if not self.borders:
            return self._slope_of(self._reduced)
        slope = self._given_slope
        for amount, sharp in zip(self._amounts, self._sharp, strict=True):
            slope = slope + amount * sharp.density
        return slope

    def rate_integral(self, tail: float | Array | None = None) -> PanelIntegral:
        """Return V on panels that slip as a running integral; `tail` as of `PanelIntegral`."""
        residue = self.residue if self.layout.pole >= 0 else None
        return PanelIntegral(
            self.panels, self.slip_rate_slope, self.factors.c, self._powers, residue, tail
        )

    @property
    def _powers(self) -> tuple[Power, ...]:
        """Parts of dV/dv that are large near borders of the opening."""
        return tuple(
            replace(power, amount=amount * power.amount)
            for amount, sharp in zip(self._amounts, self._sharp, strict=True)
            for power in sharp.powers
        )

    @cached_property
    def base_traction(self) -> float | Array:
        """Traction ahead of all waves, a number or (k,).

        In the normal problem it is chosen such that, on these panels, the pressure falls to zero
        exactly where the contact opens. Next to that edge the pressure is small compared with the
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
        """Slope of traction less strength in the sense of the next zone, (p, ..., n)."""
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
        where it heals.
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
                opened = load.opened
                with_opening = opened is not None and zone.left is opened.zone.left
                rows.append(np.zeros_like(excess) if with_opening else excess)
            if zone.right is not None:
                ahead = per_set(load.far_slip_rate) if zone.left is None else 0.0
                rate = next(gains) + ahead
                # A zone that ends with the opening has slip rate 0 there by its additional term.
                rows.append(np.zeros_like(rate) if zone.held else rate)
            outward = zone
        return np.stack(rows) if rows else np.zeros(0)

    def _excess_at_opening(self, zone: Zone, outward: Zone | None, gain: Array) -> Array:
        """Return traction less sense times strength where a zone opens, () or (k,)."""
        load = self.load
        if outward is None:
            strength = per_set(load.friction) * load.base_pressure
            excess = gain + load.base_shear - per_set(load.far_slip_rate) - zone.sense * strength
            if self.normal is None:
                return np.asarray(excess)
            # as if pressure fell from its base to 0 exactly: near the opening it is known
            # relative to itself, near the longitudinal front what the base lacks of friction is
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
        # over the width of the gap, where that is narrow
        return np.asarray(gain / np.minimum(1.0, zone.left.minus(outward.right)[..., 0]))


def _solved(matrix: Array, right: Array) -> Array:
    """Return x of matrix (..., m, m) x = right (..., m)."""
    if matrix.shape[-1] == 1:
        return np.asarray(right / matrix[..., 0])
    return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
