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

from semianalytic.panels import Panels, Rule, Zone, analytic_strip, lay_panels, spans_of
from semianalytic.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.stuck import stuck_traction


@dataclass(frozen=True)
class Load:
    """Friction and tractions in one unit of stress, slip rate far ahead in that unit / (mu b)."""

    friction: float
    base_pressure: float
    base_shear: float
    step_pressure: float
    step_shear: float
    far_slip_rate: float


def _chord_integral(
    start: float, stop: float, to_left: Array, to_right: Array, width: Array
) -> Array:
    """Integral of chord(w) / (w - v) over a panel, the chord running from start to stop.

    to_left and to_right are v - left and v - right; accurate near the panel and far from it.
    """
    share = np.asarray(width / to_left)
    far = np.abs(share) < 0.5
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.where(far, np.log1p(-np.where(far, share, 0)), np.log(np.abs(to_right / to_left)))
    small = np.abs(share) < 0.02
    linear = np.divide(log + share, share, where=~small, out=np.zeros_like(share))
    if np.any(small):
        within = share[small]
        series = np.polynomial.polynomial.polyval(within, 1 / np.arange(2.0, 11.0))
        linear[small] = -within * series
    return start * log + (stop - start) * linear


def _log_share(part: Array, whole: Array, rest: float) -> Array:
    """ln(part / whole) with part + rest = whole, accurate for part << whole and rest << whole."""
    share = rest / whole
    near = np.abs(share) > 0.5
    return np.where(near, np.log(part / whole), np.log1p(-np.where(near, 0.0, share)))


@dataclass(frozen=True)
class ZoneFields:
    """Fields of a load and a set of zones, whether or not the edges satisfy Coulomb's law.

    `zones` run from the longitudinal front inward, in slowness.
    """

    factors: RayleighFactors
    load: Load
    zones: tuple[Zone, ...]
    rule: Rule
    tail: bool = True

    @cached_property
    def panels(self) -> Panels:
        """Panels on a rule as fine and as long as these zones need.

        Beside a narrow stick gap around c, dV/dv ~ 1/(v - c) over all scales down to the gap.
        """
        reach = self.rule.reach
        for inward, outward in zip(self.zones[1:], self.zones[:-1], strict=True):
            left, right = outward.right, inward.left
            if left is not None and right is not None and left.from_c < 0 < right.from_c:
                reach += max(0.0, -float(np.log(right.minus(left))))
        spans = spans_of(self.factors, self.zones)
        if not self.tail and len(spans) > 1:
            spans.pop()
        spacing = self.rule.spacing * analytic_strip(self.factors, spans)
        return lay_panels(self.factors, spans, Rule(spacing, reach))

    def slips_at(self, front: CutPoints) -> bool:
        """Whether a zone covers a wave front."""
        return any(
            (zone.left is None or front.minus(zone.left) > 0)
            and (zone.right is None or front.minus(zone.right) < 0)
            for zone in self.zones
        )

    @cached_property
    def _slips_at_b(self) -> bool:
        return self.slips_at(self.factors.cut(1.0))

    @cached_property
    def _slips_at_c(self) -> bool:
        return self.slips_at(self.factors.cut(self.factors.c))

    @cached_property
    def _reference_sense(self) -> int:
        return self.zones[-1].sense if self.zones else 0

    @cached_property
    def _square_roots(self) -> list[tuple[CutPoints, float]]:
        """Edges slower than c_t with the exponent X has there."""
        edges = []
        for zone in self.zones:
            for edge, opening in ((zone.left, True), (zone.right, False)):
                if edge is not None and edge.from_b > 0:
                    smooth = opening == (edge.from_c < 0)
                    edges.append((edge, 0.5 if smooth else -0.5))
        return edges

    def _phase_panels(self, slipping: bool) -> list[int]:
        """Panels ahead of the shear front that slip, or stick."""
        panels = self.panels
        ahead = panels.at.from_b[:, 0] < 0
        return list(np.flatnonzero(ahead & ((panels.sense != 0) == slipping)))

    def _phase_integral(self, sources: list[int], targets: Array) -> Array:
        """(1/pi) int phi(w) / (w - v) dw over some panels, at the nodes of others."""
        panels = self.panels
        total = np.zeros((len(targets), len(panels.rule.y)))
        for source in sources:
            left, right, start, stop, excess = self._phase_on(source)
            total += panels.cauchy(source, excess, targets)
            to_left, to_right = panels.minus(left)[targets], panels.minus(right)[targets]
            total += _chord_integral(start, stop, to_left, to_right, right.minus(left))
        return total / np.pi

    def _phase_on(self, source: int) -> tuple[CutPoints, CutPoints, float, float, Array]:
        """Ends of a panel, phi there, and (phi - its chord) dv/dy at the nodes."""
        panels, factors = self.panels, self.factors
        left, right = panels.left[source], panels.right[source]
        assert right is not None
        start = float(factors.phase(left))
        stop = float(factors.phase(right))
        share = panels.from_left[source] / right.minus(left)
        excess = self._phase[source] - start - (stop - start) * share
        return left, right, start, stop, excess * panels.jacobian[source]

    @cached_property
    def _phase(self) -> Array:
        return self.factors.phase(self.panels.at)

    @cached_property
    def _impedance(self) -> np.ndarray:
        return self.factors.impedance_on_cut(self.panels.at)

    @cached_property
    def _m_plus(self) -> Array:
        return self.factors.m_plus(self.panels.at.v)

    @cached_property
    def _roots(self) -> tuple[Array, Array]:
        """Logarithm of the modulus, and the phase / pi, of the product of the square roots."""
        log = np.zeros_like(self.panels.jacobian)
        phase = np.zeros_like(log)
        for edge, exponent in self._square_roots:
            difference = self.panels.minus(edge)
            log += exponent * np.log(np.abs(difference))
            phase += exponent * (difference > 0)
        return log, phase

    @cached_property
    def canonical(self) -> Array:
        """(p, n): X, real, on panels that slip; X / M_+, real, on panels that stick."""
        panels, factors = self.panels, self.factors
        slipping = panels.sense != 0
        ahead = panels.at.from_b[:, 0] < 0
        log, phase = (x.copy() for x in self._roots)
        behind_b, behind_c = panels.at.from_b > 0, panels.at.from_c > 0
        log_b = 0.5 * np.log(np.abs(panels.at.from_b))
        log_c = np.log(np.abs(panels.at.from_c))
        integral = np.zeros_like(log)
        stick_pieces, slip_pieces = self._phase_panels(False), self._phase_panels(True)
        by_stick = slipping & (ahead | self._slips_at_b)
        if stick_pieces and by_stick.any():
            integral[by_stick] = -self._phase_integral(stick_pieces, np.flatnonzero(by_stick))
        by_slip = ~by_stick
        if slip_pieces and by_slip.any():
            integral[by_slip] = self._phase_integral(slip_pieces, np.flatnonzero(by_slip))
        log += integral
        # Stick: X / M_+ = exp(J_slip) (b + k)^(1/2 if slip at b) / (c + k if slip at c) ...
        stick = ~slipping
        if self._slips_at_b:
            log[stick] += log_b[stick]
            phase[stick] += 0.5 * behind_b[stick]
        if self._slips_at_c:
            log[stick] -= log_c[stick]
            phase[stick] -= behind_c[stick]
        # Slip: X = E(k) (c + k if stick at c) / (b + k)^(1/2 if stick at b) ...
        if not self._slips_at_c:
            log[slipping] += log_c[slipping]
            phase[slipping] += behind_c[slipping]
        if not self._slips_at_b:
            log[slipping] -= log_b[slipping]
            phase[slipping] -= 0.5 * behind_b[slipping]
        direct = by_slip & slipping  # E = |S_+(-v)| exp(J_slip)
        if direct.any():
            modulus = np.abs(self._impedance[direct]) / (factors.kappa * self._m_plus[direct])
            log[direct] += np.log(modulus) + log_b[direct] - log_c[direct]
        return np.exp(log) * np.cos(np.pi * phase).round()

    @cached_property
    def _canonical_at_zero(self) -> float:
        log = 0.0 if self._slips_at_c else np.log(self.factors.c)
        for edge, exponent in self._square_roots:
            log += exponent * np.log(edge.v)
        for source in self._phase_panels(False):
            left, right, start, stop, excess = self._phase_on(source)
            log -= self.panels.rule.spacing * np.sum(excess / self.panels.at.v[source]) / np.pi
            chord = _chord_integral(start, stop, -left.v, -right.v, right.minus(left))
            log -= float(chord) / np.pi
        return float(np.exp(log))

    @cached_property
    def _mode_one_at_zero(self) -> float:
        return float(self.factors.m_plus(0.0, "I"))

    @cached_property
    def _pressure_transform(self) -> np.ndarray:
        """P(-v + i0) at the nodes."""
        factors, at = self.factors, self.panels.at
        m = factors.m_plus(at.v, "I")
        scale = self.load.step_pressure / (self._mode_one_at_zero * factors.kappa)
        return scale * factors.impedance_on_cut(at, "I") / m

    @cached_property
    def _sources(self) -> list[tuple[int, Array]]:
        """Panels on which C has an imaginary part, and that part at their nodes."""
        load, panels = self.load, self.panels
        if load.step_pressure == 0 or not self.zones:
            return []
        sources = []
        s0 = self._reference_sense
        for i, sense in enumerate(panels.sense):
            if sense == 0 and panels.at.from_b[i, 0] < 0:
                root = np.sqrt(-panels.at.from_b[i] / panels.at.from_a[i])
                amount = s0 * load.friction * load.step_pressure / self._mode_one_at_zero
                sources.append((i, amount * root / self.canonical[i]))
            elif sense not in (0, s0):
                miss = (sense - s0) * load.friction * self._pressure_transform[i].imag
                sources.append((i, miss / self.canonical[i]))
        return sources

    @cached_property
    def constant(self) -> float:
        """R, from T(0) = Q_0 - mu b V(inf)."""
        load = self.load
        at_zero = load.step_shear - load.far_slip_rate
        at_zero -= self._reference_sense * load.friction * load.step_pressure
        panels = self.panels
        cauchy = sum(
            -panels.rule.spacing / np.pi * float(np.sum(panels.jacobian[i] * imag / panels.at.v[i]))
            for i, imag in self._sources
        )
        return at_zero / self._canonical_at_zero - cauchy

    @cached_property
    def _cauchy(self) -> np.ndarray:
        """C(-v + i0) at the nodes, complex."""
        panels = self.panels
        total = np.zeros(panels.jacobian.shape, dtype=complex)
        every = np.arange(len(panels.sense))
        for source, imag in self._sources:
            weights = panels.jacobian[source] * imag
            others = every[every != source]
            total[others] -= panels.cauchy(source, weights, others) / np.pi
            total[source] += 1j * imag - panels.principal_value(source, weights) / np.pi
        return total

    @cached_property
    def reduced_transform(self) -> Array:
        """(p, n): T / M_+, real, on panels that stick; T - s f P, real part, on those that slip."""
        return self.canonical * (self._cauchy.real + self.constant)

    @cached_property
    def stick_transform(self) -> Array:
        """(p, n): T / M_+ where the interface sticks (meaningless elsewhere)."""
        load, at = self.load, self.panels.at
        ratio = np.where(at.from_b > 0, np.sqrt(np.abs(at.from_b / at.from_a)), 0.0)
        amount = self._reference_sense * load.friction * load.step_pressure
        return self.reduced_transform + amount / self._mode_one_at_zero * ratio

    def stick_transform_off_cut(self, k: Array) -> Array:
        """T / M_+ at k > 0, any shape: what drives the slot faces."""
        load, panels = self.load, self.panels
        flat = np.ravel(k)
        log = np.zeros_like(flat)
        if self._slips_at_c:
            log -= np.log(self.factors.c + flat)
        if self._slips_at_b:
            log += 0.5 * np.log(1 + flat)
        for edge, exponent in self._square_roots:
            log += exponent * np.log(edge.v + flat)
        for source in self._phase_panels(True):
            left, right, start, stop, excess = self._phase_on(source)
            width = right.minus(left)
            chord = _chord_integral(start, stop, -left.v - flat, -right.v - flat, width)
            kernel = 1 / (panels.at.v[source] + flat[:, None])
            log += (self.panels.rule.spacing * kernel @ excess + chord) / np.pi
        cauchy = np.full_like(flat, self.constant)
        for source, imag in self._sources:
            kernel = 1 / (panels.at.v[source] + flat[:, None])
            cauchy -= self.panels.rule.spacing / np.pi * kernel @ (panels.jacobian[source] * imag)
        amount = self._reference_sense * load.friction * load.step_pressure
        ratio = np.sqrt((1 + flat) / (self.factors.a + flat)) * amount / self._mode_one_at_zero
        return (np.exp(log) * cauchy + ratio).reshape(np.shape(k))

    @cached_property
    def stick_transform_at_edge(self) -> float:
        """Limit of T / M_+ at the contact edge when it sticks: K_II / (M_+(0) K_II of Q_0 = 1)."""
        load = self.load
        amount = self._reference_sense * load.friction * load.step_pressure
        return self.constant + amount / self._mode_one_at_zero

    @cached_property
    def stick_transform_excess(self) -> Array:
        """(n,): T / M_+ less its limit at a stuck contact edge, on the last panel, without loss."""
        panels, load = self.panels, self.load
        last = len(panels.sense) - 1
        v = panels.at.v[last]
        log = self._phase_integral(self._phase_panels(True), np.array([last]))[0]
        if self._slips_at_c:
            log -= _log_share(panels.at.from_c[last], v, self.factors.c)
        if self._slips_at_b:
            log += 0.5 * _log_share(panels.at.from_b[last], v, 1.0)
        for edge, exponent in self._square_roots:
            log += exponent * _log_share(panels.minus(edge)[last], v, float(edge.v))
        cauchy = self._cauchy[last].real
        from_a, from_b = panels.at.from_a[last], panels.at.from_b[last]
        ratio = np.expm1(0.5 * _log_share(from_b, from_a, 1.0 - self.factors.a))
        amount = self._reference_sense * load.friction * load.step_pressure
        growth = np.expm1(log)
        return growth * (cauchy + self.constant) + cauchy + amount / self._mode_one_at_zero * ratio

    @cached_property
    def slip_rate_slope(self) -> Array:
        """(p, n): dV/dv on panels that slip, 0 on panels that stick."""
        panels, factors = self.panels, self.factors
        slip = panels.sense != 0
        transform = self.canonical[slip] * (self._cauchy[slip] + self.constant)
        if self.load.step_pressure:
            strength = self._reference_sense * self.load.friction
            transform = transform + strength * self._pressure_transform[slip]
        m = self._m_plus[slip]
        ratio = transform / self._impedance[slip] * (factors.kappa * m)
        result = np.zeros_like(panels.jacobian)
        result[slip] = -ratio.imag / (np.pi * factors.kappa * panels.at.v[slip] * m)
        return result

    @cached_property
    def traction_slope(self) -> Array:
        """(p, n): dtau/dv on panels that stick, 0 on panels that slip."""
        factors, stick = self.factors, (self.panels.sense == 0)[:, None]
        shear = stuck_traction(factors.poisson_ratio, "II")
        unit = shear.slope(self.panels.at) * float(factors.m_plus(0.0))
        return np.where(stick, unit * self.stick_transform, 0.0)

    def strength(self, edge: CutPoints) -> float:
        """Friction bound f p at an edge."""
        load = self.load
        pressure = stuck_traction(self.factors.poisson_ratio, "I")(edge.v)
        return load.friction * (load.base_pressure + load.step_pressure * float(pressure))

    @cached_property
    def excess_slope(self) -> Array:
        """(p, n): slope of traction less the following zone's sense times strength, on stick."""
        panels, load = self.panels, self.load
        slope = self.traction_slope
        if load.step_pressure == 0 or not self.zones:
            return slope
        following = np.array([self.zones[min(k, len(self.zones) - 1)].sense for k in panels.zone])
        mode_one = stuck_traction(self.factors.poisson_ratio, "I").slope(panels.at)
        strength = load.friction * load.step_pressure * mode_one
        return slope - np.where(panels.sense == 0, following, 0)[:, None] * strength

    def mismatch(self) -> Array:
        """What the edges leave unfulfilled: one number per edge.

        For each zone: traction less sense times strength where it opens (over the width of the
        stick gap before it when that is narrow), and the slip rate left where it heals.
        """
        panels, load = self.panels, self.load
        weight = self.panels.rule.spacing * panels.jacobian
        excess = np.sum(weight * self.excess_slope, axis=1)
        slip_rate = np.sum(weight * self.slip_rate_slope, axis=1)
        result = []
        traction = load.base_shear - load.far_slip_rate
        strength, healed = load.friction * load.base_pressure, None
        for index, zone in enumerate(self.zones):
            if zone.left is not None:
                before = (panels.sense == 0) & (panels.zone == index)
                opening = traction - zone.sense * strength + excess[before].sum()
                narrow = 1.0 if healed is None else min(1.0, float(zone.left.minus(healed)))
                result.append(opening / narrow)
            if zone.right is not None:
                start = load.far_slip_rate if zone.left is None else 0.0
                inside = (panels.sense != 0) & (panels.zone == index)
                result.append(start + slip_rate[inside].sum())
                healed, strength = zone.right, self.strength(zone.right)
                traction = zone.sense * strength
        return np.array(result)
