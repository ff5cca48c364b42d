"""Exact fields of given slip zones: the Riemann-Hilbert problem of section 4, solved.

On the cut k = -v + i0 the transform T of the shear traction satisfies Im T = known where the
interface slips and Im (T / M_+) = 0 where it sticks.  With a canonical function X that is real
on slip and has the phase of M_+ on stick,

    T = s f P + X (C + R),   P = P_0 M_+^I / M_+^I(0),

where C is a Cauchy integral over the parts of the cut on which s f P misses its condition and R
is a constant fixed by T(0).  Slip rate and traction follow from

    dV/dv = -Im(T / M_+) / (pi kappa v M_+(v)),    dtau/dv = Im T / (pi v).

X carries the behaviour at each edge.  The edge that opens ahead of slip has |v - edge|^(-1/2) in
dV/dv when it runs slower than c_R, |v - edge|^(-phi/pi) between c_t and c_l; an edge that heals
has it between c_R and c_t; the others are smoother by one power, for |tau| <= f p would fail.
b = mu = 1; V is one-sided.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.polynomial import polyval

from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.selfsimilar.layout import Layout, Zone
from semianalytic.selfsimilar.load import Load, per_set
from semianalytic.selfsimilar.panels import Panels, lay_panels

_SMALL = 1 / np.arange(2.0, 11.0)  # -(1 + ln(1 - s) / s) / s in powers of s


def _log_share(part: Array, whole: Array, rest: Array) -> Array:
    """ln(part / whole) with part + rest = whole, accurate for part << whole and rest << whole."""
    share = rest / whole
    near = np.abs(share) > 0.5
    return np.where(near, np.log(part / whole), np.log1p(-np.where(near, 0.0, share)))


@dataclass(frozen=True)
class Phase:
    """The phase phi of panels ahead of the shear front (s, ..., n): a chord plus a rest.

    left, right, width are slownesses of their ends (s, ..., 1) and their distance, start and stop
    phi there; `rest` is (phi - chord) dv/dy at the nodes.
    """

    left: Array
    right: Array
    width: Array
    start: Array
    stop: Array
    rest: Array

    def __getitem__(self, index: np.ndarray) -> Phase:
        """Some of the panels."""
        every = (self.left, self.right, self.width, self.start, self.stop, self.rest)
        return Phase(*(part[index] for part in every))

    def chord_integral(self, to_left: Array, to_right: Array) -> Array:
        """Integral of chord(w) / (w - v); to_left = v - left, to_right = v - right.

        Accurate near the panels and far from them.
        """
        share = self.width / to_left
        log = np.log(np.abs(to_right / to_left))
        linear = log / share + 1
        small = np.abs(share) < 0.02
        if small.any():
            few = share[small]
            linear[small] = -few * polyval(few, _SMALL)
            log[small] = few * (linear[small] - 1)
        return self.start * log + (self.stop - self.start) * linear


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

    @property
    def _reference_sense(self) -> int:
        return self.zones[-1].sense if self.zones else 0

    @cached_property
    def _reference_pressure(self) -> float | Array:
        """s f P_0 / M_+^I(0) of the reference sense s."""
        load = self.load
        amount = self._reference_sense * load.friction * load.load_pressure
        return amount / self.factors.m_plus_at_zero["I"]

    @cached_property
    def _impedance(self) -> tuple[Array, Array]:
        """M at the nodes: real part (h, ..., n) ahead of the shear front, imaginary (p, ..., n)."""
        at, ahead = self.panels.at, self.layout.ahead
        imag = np.empty_like(at.v)
        real, imag[:ahead] = self.factors.impedance_ahead(at[:ahead])
        imag[ahead:] = self.factors.impedance_behind(at[ahead:])
        return real, imag

    @cached_property
    def _m_plus(self) -> Array:
        return self.factors.m_plus(self.panels.at.v)

    @cached_property
    def _phase(self) -> Phase:
        """Of all panels ahead of the shear front."""
        panels, ahead, (real, imag) = self.panels, self.layout.ahead, self._impedance
        ends = panels.ends[: ahead + 1]
        phi = self.factors.phase(ends)
        start, stop = phi[:-1], phi[1:]
        chord = start + (stop - start) * panels.rule.share
        rest = (np.arctan2(imag[:ahead], real) - chord) * panels.jacobian[:ahead]
        return Phase(ends.v[:-1], ends.v[1:], panels.widths[:ahead], start, stop, rest)

    @cached_property
    def _log_of_phase(self) -> Array:
        """(p, ..., n): what the phase adds to ln X, (1/pi) int phi(w) / (w - v) dw."""
        panels, pairs = self.panels, self.layout.phase_pairs
        phase, distances = self._phase[pairs.source], panels.from_ends
        to_left = distances[pairs.source, pairs.target]
        to_right = distances[pairs.source + 1, pairs.target]
        chord = phase.chord_integral(to_left, to_right)
        return pairs.collect(panels.cauchy(pairs, phase.rest) + chord) / np.pi

    def _phase_integral_off_cut(self, sources: np.ndarray, k: Array) -> Array:
        """(1/pi) int phi(w) / (w + k) dw over panels, at k >= 0 of shape (m,); (..., m)."""
        phase, w = self._phase[sources], self.panels.at.v[sources]
        rest = np.sum(phase.rest[..., None, :] / (w[..., None, :] + k[:, None]), axis=-1)
        chord = phase.chord_integral(-phase.left - k, -phase.right - k)
        return np.sum(self.panels.rule.spacing * rest + chord, axis=0) / np.pi

    @cached_property
    def canonical(self) -> Array:
        """(p, ..., n): X, real, on panels that slip; X / M_+, real, on panels that stick."""
        panels, layout = self.panels, self.layout
        from_b, from_c = np.abs(panels.at.from_b), panels.at.from_c
        square = np.ones_like(from_b)  # of what has the exponent 1/2
        for end, exponent in layout.roots:
            distance = np.abs(panels.from_ends[end])
            square = square * distance if exponent > 0 else square / distance
        if layout.slips_at_b:
            square[layout.stick] *= from_b[layout.stick]
        else:
            square[layout.slip] /= from_b[layout.slip]
        product = np.sqrt(square)
        if layout.slips_at_c:
            product[layout.stick] /= -from_c[layout.stick]
        else:
            product[layout.slip] *= -from_c[layout.slip]
        product *= np.exp(self._log_of_phase)
        direct = layout.slip_behind  # with |S_+(-v)| on the cut
        if len(direct) and not layout.slips_at_b:
            modulus = np.abs(self._impedance[1][direct]) / (
                self.factors.kappa * self._m_plus[direct]
            )
            product[direct] *= modulus * np.sqrt(from_b[direct]) / np.abs(from_c[direct])
        return product * layout.sign.reshape(-1, *[1] * (product.ndim - 1))

    @cached_property
    def _canonical_at_zero(self) -> Array:
        """X(0), (1,) or (k, 1)."""
        value = np.exp(-self._phase_integral_off_cut(self.layout.stick_ahead, np.zeros(1)))
        if not self.layout.slips_at_c:
            value = value * self.factors.c
        for end, exponent in self.layout.roots:
            value = value * self.panels.ends.v[end] ** exponent
        return value

    @cached_property
    def _mode_ratio(self) -> Array:
        """|M_+^I / M_+| = sqrt(|b - v| / (v - a)) at the nodes.

        M_+^I / M_+ is -i times that ahead of the shear front, and that behind it.
        """
        at = self.panels.at
        return np.sqrt(np.abs(at.from_b / at.from_a))

    @cached_property
    def _pressure_slope(self) -> Array:
        """d(P_0 p*)/dv = Im P(-v + i0) / (pi v) at the nodes."""
        zero = self.factors.m_plus_at_zero["I"]
        (real, imag), ahead = self._impedance, self.layout.ahead
        slope = imag * self._mode_ratio
        slope[:ahead] = -real * self._mode_ratio[:ahead]
        slope *= self.load.load_pressure / (np.pi * self.factors.kappa * zero)
        return slope / (self._m_plus * self.panels.at.v)

    @cached_property
    def _sources(self) -> tuple[np.ndarray, Array]:
        """Panels on which C has an imaginary part, and Im C at all nodes, (p, ..., n)."""
        load, panels, stick = self.load, self.panels, self.layout.stick_ahead
        imag = np.zeros_like(panels.jacobian)
        if load.load_pressure == 0 or not self.zones:
            return stick[:0], imag
        imag[stick] = self._reference_pressure * self._mode_ratio[stick] / self.canonical[stick]
        other = np.array([i for i in self.layout.slip if panels.sense[i] != self._reference_sense])
        if len(other):
            factor = -2 * np.pi * self._reference_sense * load.friction
            miss = factor * panels.at.v[other] * self._pressure_slope[other]
            imag[other] = miss / self.canonical[other]
        return np.append(stick, other.astype(int)), imag

    @cached_property
    def constant(self) -> Array:
        """R, from T(0) = Q_0 - mu b V(inf), (1,) or (k, 1)."""
        load, panels = self.load, self.panels
        at_zero = load.load_shear - load.far_slip_rate
        at_zero -= self._reference_sense * load.friction * load.load_pressure
        value = at_zero / self._canonical_at_zero
        sources, imag = self._sources
        if len(sources):
            integrals = panels.integrals(imag / panels.at.v)
            value = value + integrals[sources].sum(axis=0)[..., None] / np.pi
        return value

    @cached_property
    def _cauchy(self) -> Array:
        """(p, ..., n): Re C(-v + i0) at the nodes."""
        panels, (sources, imag) = self.panels, self._sources
        if not len(sources):
            return imag
        pairs, weights = self.layout.pairs_from(tuple(sources.tolist())), panels.jacobian * imag
        total = pairs.collect(panels.cauchy(pairs, weights[pairs.source]))
        total[sources] += panels.principal_values(sources, weights[sources])
        return total / -np.pi

    @cached_property
    def _reduced(self) -> Array:
        """(p, ..., n): X (Re C + R); over M_+ on panels that stick."""
        return self.canonical * (self._cauchy + self.constant)

    @cached_property
    def stick_transform(self) -> Array:
        """(p, ..., n): T / M_+ where the interface sticks (meaningless elsewhere)."""
        result, ahead = self._reduced.copy(), self.layout.ahead
        if self.load.load_pressure:
            result[ahead:] += self._reference_pressure * self._mode_ratio[ahead:]
        return result

    def stick_transform_off_cut(self, k: Array) -> Array:
        """T / M_+ at k > 0, any shape: what drives the slot faces (one set of zones)."""
        panels, layout, flat = self.panels, self.layout, np.ravel(k)
        value = np.exp(self._phase_integral_off_cut(layout.slip_ahead, flat))
        if layout.slips_at_c:
            value /= self.factors.c + flat
        if layout.slips_at_b:
            value *= np.sqrt(1 + flat)
        for end, exponent in layout.roots:
            value *= (panels.ends.v[end] + flat) ** exponent
        cauchy = np.full_like(flat, self.constant[0])
        sources, imag = self._sources
        for source in sources:
            kernel = 1 / (panels.at.v[source] + flat[:, None])
            weights = panels.jacobian[source] * imag[source]
            cauchy -= panels.rule.spacing / np.pi * (kernel @ weights)
        ratio = np.sqrt((1 + flat) / (self.factors.a + flat)) * self._reference_pressure
        return (value * cauchy + ratio).reshape(np.shape(k))

    @cached_property
    def stick_transform_at_edge(self) -> Array:
        """Limit of T / M_+ at the contact edge when it sticks: K_II / (M_+(0) K_II of Q_0 = 1).

        () or (k,).
        """
        return np.asarray((self.constant + self._reference_pressure)[..., 0])

    @cached_property
    def stick_transform_excess(self) -> Array:
        """(..., n): T / M_+ less its limit at a stuck contact edge, last panel, without loss."""
        panels, layout, factors = self.panels, self.layout, self.factors
        at, log = panels.at[-1], self._log_of_phase[-1]
        if layout.slips_at_c:
            log = log - _log_share(at.from_c, at.v, np.array(factors.c))
        if layout.slips_at_b:
            log = log + 0.5 * _log_share(at.from_b, at.v, np.array(1.0))
        for end, exponent in layout.roots:
            share = _log_share(panels.from_ends[end, -1], at.v, panels.ends.v[end])
            log = log + exponent * share
        ratio = np.expm1(0.5 * _log_share(at.from_b, at.from_a, np.array(1.0 - factors.a)))
        cauchy, growth = self._cauchy[-1], np.expm1(log)
        return growth * (cauchy + self.constant) + cauchy + self._reference_pressure * ratio

    @cached_property
    def slip_rate_slope(self) -> Array:
        """(p, ..., n): dV/dv on panels that slip, 0 on panels that stick."""
        load, layout, (real, imag) = self.load, self.layout, self._impedance
        slope = np.zeros_like(imag)
        behind, ahead = layout.slip_behind, layout.slip_ahead
        slope[behind] = self._reduced[behind] / imag[behind]
        if len(ahead):
            product = self._reduced[ahead] * imag[ahead]
            if load.load_pressure:
                product -= self.canonical[ahead] * self._sources[1][ahead] * real[ahead]
            slope[ahead] = product / (np.square(real[ahead]) + np.square(imag[ahead]))
            if load.load_pressure:
                by_pressure = self._reference_pressure * self._mode_ratio[ahead]
                slope[ahead] += by_pressure / (self.factors.kappa * self._m_plus[ahead])
        return slope / (np.pi * self.panels.at.v)

    @cached_property
    def traction_slope(self) -> Array:
        """(p, ..., n): dtau/dv on panels that stick, 0 on panels that slip."""
        unit = self._impedance[1] / (self._m_plus * self.panels.at.v)
        slope = unit * self.stick_transform / (np.pi * self.factors.kappa)
        slope[self.layout.slip] = 0.0
        return slope

    def strength(self, edge: CutPoints) -> Array:
        """Friction bound f p at an edge."""
        load = self.load
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
        return slope - factor * load.friction * self._pressure_slope

    def mismatch(self) -> Array:
        """What the edges leave unfulfilled: one row per edge, (e,) or (e, k).

        For each zone: traction less sense times strength where it opens (over the width of the
        stick gap before it when that is narrow), and the slip rate left where it heals.
        """
        load, layout = self.load, self.layout
        integrals = self.panels.integrals(self._excess_slope + self.slip_rate_slope)
        gains = iter(np.add.reduceat(integrals, [part[0] for part in layout.regions], axis=0))
        far_slip_rate = per_set(load.far_slip_rate)
        rows: list[Array] = []
        outward: Zone | None = None
        for zone in self.zones:
            if zone.left is not None:
                opening = next(gains)
                if outward is None:
                    strength = per_set(load.friction) * load.base_pressure
                    opening = opening + load.base_shear - far_slip_rate - zone.sense * strength
                elif outward.right is not None:
                    if outward.sense != zone.sense:
                        strength = self.strength(outward.right)[..., 0]
                        opening = opening + (outward.sense - zone.sense) * strength
                    opening = opening / np.minimum(1.0, zone.left.minus(outward.right)[..., 0])
                rows.append(np.asarray(opening))
            if zone.right is not None:
                rows.append(next(gains) + (far_slip_rate if zone.left is None else 0.0))
            outward = zone
        return np.stack(rows) if rows else np.zeros(0)
