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

from semianalytic.panels import (
    Panels,
    Rule,
    Zone,
    fitted_rule,
    lay_panels,
    lies_between,
    spans_of,
)
from semianalytic.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.stuck import stuck_traction

_SMALL = 1 / np.arange(2.0, 11.0)  # -(1 + ln(1 - s) / s) / s in powers of s


@dataclass(frozen=True)
class Load:
    """Friction and tractions in one unit of stress, slip rate far ahead in that unit / (mu b).

    For k sets of zones that differ in friction, friction and far_slip_rate are (k, 1) arrays.
    """

    friction: float | Array
    base_pressure: float
    base_shear: float
    step_pressure: float
    step_shear: float
    far_slip_rate: float | Array

    @property
    def critical(self) -> bool:
        """Whether the base shear traction reaches friction ahead of all waves (one set)."""
        return bool(abs(self.base_shear) >= self.friction * self.base_pressure * (1 - 1e-12))


def per_set(value: float | Array) -> float | Array:
    """A number, or a (k, 1) array as (k,)."""
    return np.asarray(value)[..., 0] if np.ndim(value) else value


@dataclass(frozen=True)
class Piece:
    """One panel ahead of the shear front as a source of phase: phi is a chord plus a rest.

    start and stop are phi at its ends; `rest` is (phi - chord) dv/dy at its nodes.
    """

    panel: int
    left: CutPoints
    right: CutPoints
    start: Array
    stop: Array
    rest: Array

    def chord_integral(self, to_left: Array, to_right: Array) -> Array:
        """Integral of chord(w) / (w - v); to_left = v - left, to_right = v - right.

        Accurate near the panel and far from it.
        """
        share = self.right.minus(self.left) / to_left
        size = np.abs(share)
        near = np.log(np.abs(to_right / to_left))
        log = np.where(size < 0.5, np.log1p(-np.minimum(share, 0.5)), near)
        linear = log / share + 1
        small = size < 0.02
        if small.any():
            linear[small] = -share[small] * polyval(share[small], _SMALL)
        return self.start * log + (self.stop - self.start) * linear


def _log_share(part: Array, whole: Array, rest: Array) -> Array:
    """ln(part / whole) with part + rest = whole, accurate for part << whole and rest << whole."""
    share = rest / whole
    near = np.abs(share) > 0.5
    return np.where(near, np.log(part / whole), np.log1p(-np.where(near, 0.0, share)))


@dataclass(frozen=True)
class ZoneFields:
    """Fields of a load and a set of zones, whether or not the edges satisfy Coulomb's law.

    `zones` run from the longitudinal front inward, in slowness; their edges may hold several
    neighbouring sets at once (see `panels`).
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
        Without `tail` the unbounded panel is left out.
        """
        further = 0.0
        for inward, outward in zip(self.zones[1:], self.zones[:-1], strict=True):
            left, right = outward.right, inward.left
            if (
                left is not None
                and right is not None
                and lies_between(left, self.factors.front_c, right)
            ):
                further += max(0.0, -float(np.log(right.minus(left).min())))
        spans = spans_of(self.factors, self.zones)
        if not self.tail and len(spans) > 1:
            spans.pop()
        rule = fitted_rule(self.factors, spans, self.rule, further)
        return lay_panels(self.factors, spans, rule, np.shape(self.load.friction))

    def _slips_at(self, front: CutPoints) -> bool:
        return any(lies_between(zone.left, front, zone.right) for zone in self.zones)

    @cached_property
    def _slips_at_b(self) -> bool:
        return self._slips_at(self.factors.front_b)

    @cached_property
    def _slips_at_c(self) -> bool:
        return self._slips_at(self.factors.front_c)

    @property
    def _reference_sense(self) -> int:
        return self.zones[-1].sense if self.zones else 0

    @cached_property
    def _square_roots(self) -> list[tuple[CutPoints, float]]:
        """Edges slower than c_t with the exponent X has there."""
        edges = []
        for zone in self.zones:
            for edge, opening in ((zone.left, True), (zone.right, False)):
                if edge is not None and edge.from_b.flat[0] > 0:
                    smooth = opening == bool(edge.from_c.flat[0] < 0)
                    edges.append((edge, 0.5 if smooth else -0.5))
        return edges

    @cached_property
    def _impedance(self) -> np.ndarray:
        return self.factors.impedance_on_cut(self.panels.at)

    @cached_property
    def _m_plus(self) -> Array:
        return self.factors.m_plus(self.panels.at.v)

    def _pieces(self, slipping: bool) -> list[Piece]:
        """Panels ahead of the shear front that slip, or stick."""
        panels, factors, pieces = self.panels, self.factors, []
        for i in np.flatnonzero(panels.ahead & ((panels.sense != 0) == slipping)):
            left, right = panels.left[i], panels.right[i]
            assert right is not None
            start, stop = factors.phase(left), factors.phase(right)
            share = panels.from_left[i] / right.minus(left)
            rest = factors.phase(panels.at[i]) - start - (stop - start) * share
            pieces.append(Piece(int(i), left, right, start, stop, rest * panels.jacobian[i]))
        return pieces

    @cached_property
    def _stick_pieces(self) -> list[Piece]:
        return self._pieces(False)

    @cached_property
    def _slip_pieces(self) -> list[Piece]:
        return self._pieces(True)

    def _phase_integral(self, pieces: list[Piece], targets: np.ndarray) -> Array:
        """(1/pi) int phi(w) / (w - v) dw over pieces, at the nodes of other panels."""
        panels = self.panels
        total = np.zeros((len(targets), *panels.jacobian.shape[1:]))
        for piece in pieces:
            to_left, to_right = (panels.minus(p)[targets] for p in (piece.left, piece.right))
            chord = piece.chord_integral(to_left, to_right)
            total += panels.cauchy(piece.panel, piece.rest, targets) + chord
        return total / np.pi

    def _phase_integral_off_cut(self, pieces: list[Piece], k: Array) -> Array:
        """(1/pi) int phi(w) / (w + k) dw over pieces, at k >= 0 of shape (m,)."""
        total = np.zeros_like(k)
        for piece in pieces:
            w = self.panels.at.v[piece.panel]
            rest = np.sum(piece.rest[..., None, :] / (w[..., None, :] + k[:, None]), axis=-1)
            chord = piece.chord_integral(-piece.left.v - k, -piece.right.v - k)
            total = total + self.panels.rule.spacing * rest + chord
        return total / np.pi

    @cached_property
    def canonical(self) -> Array:
        """(p, ..., n): X, real, on panels that slip; X / M_+, real, on panels that stick."""
        panels = self.panels
        from_b, from_c = panels.at.from_b, panels.at.from_c
        slipping = panels.sense != 0
        phase = np.zeros(len(slipping))  # of the square roots, over pi
        product = np.ones_like(panels.jacobian)
        for edge, exponent in self._square_roots:
            difference = panels.minus(edge)
            root = np.sqrt(np.abs(difference))
            product = product * root if exponent > 0 else product / root
            phase += exponent * (difference.reshape(len(phase), -1)[:, 0] > 0)
        root_b = np.sqrt(np.abs(from_b))
        if self._slips_at_b:
            product[~slipping] *= root_b[~slipping]
            phase[~slipping] += 0.5 * ~panels.ahead[~slipping]
        else:
            product[slipping] /= root_b[slipping]
            phase[slipping] -= 0.5 * ~panels.ahead[slipping]
        if self._slips_at_c:
            product[~slipping] /= -from_c[~slipping]
        else:
            product[slipping] *= -from_c[slipping]
        by_stick = slipping & (panels.ahead | self._slips_at_b)
        if by_stick.any():
            integral = self._phase_integral(self._stick_pieces, np.flatnonzero(by_stick))
            product[by_stick] *= np.exp(-integral)
        by_slip = ~by_stick
        if self._slip_pieces and by_slip.any():
            integral = self._phase_integral(self._slip_pieces, np.flatnonzero(by_slip))
            product[by_slip] *= np.exp(integral)
        direct = by_slip & slipping  # with |S_+(-v)| on the cut
        if direct.any():
            modulus = np.abs(self._impedance[direct]) / (self.factors.kappa * self._m_plus[direct])
            product[direct] *= modulus * root_b[direct] / np.abs(from_c[direct])
        sign = np.cos(np.pi * phase).round()
        return product * sign.reshape(-1, *[1] * (product.ndim - 1))

    @cached_property
    def _canonical_at_zero(self) -> Array:
        """X(0), (1,) or (k, 1)."""
        value = np.exp(-self._phase_integral_off_cut(self._stick_pieces, np.zeros(1)))
        if not self._slips_at_c:
            value = value * self.factors.c
        for edge, exponent in self._square_roots:
            value = value * edge.v**exponent
        return value

    @cached_property
    def _mode_one_at_zero(self) -> float:
        return float(self.factors.m_plus(0.0, "I"))

    @cached_property
    def _mode_ratio(self) -> np.ndarray:
        """M_+^I / M_+ = sqrt((b + k) / (a + k)) at the nodes: -i |.| ahead of the shear front."""
        at = self.panels.at
        ratio = np.sqrt(np.abs(at.from_b / at.from_a))
        return np.where(at.from_b < 0, -1j, 1.0) * ratio

    @cached_property
    def _pressure_slope(self) -> Array:
        """d(P_0 p*)/dv = Im P(-v + i0) / (pi v) at the nodes."""
        scale = self.load.step_pressure / (np.pi * self.factors.kappa * self._mode_one_at_zero)
        impedance = (self._impedance * self._mode_ratio).imag
        return scale * impedance / (self._m_plus * self.panels.at.v)

    @cached_property
    def _sources(self) -> list[tuple[int, Array]]:
        """Panels on which C has an imaginary part, and that part at their nodes."""
        load, panels = self.load, self.panels
        if load.step_pressure == 0 or not self.zones:
            return []
        sources, s0 = [], self._reference_sense
        for i, sense in enumerate(panels.sense):
            if sense == 0 and panels.ahead[i]:
                root = np.sqrt(-panels.at.from_b[i] / panels.at.from_a[i])
                amount = s0 * load.friction * load.step_pressure / self._mode_one_at_zero
                sources.append((i, amount * root / self.canonical[i]))
            elif sense not in (0, s0):
                pressure = np.pi * panels.at.v[i] * self._pressure_slope[i]
                miss = (sense - s0) * load.friction * pressure
                sources.append((i, miss / self.canonical[i]))
        return sources

    @cached_property
    def constant(self) -> Array:
        """R, from T(0) = Q_0 - mu b V(inf), (1,) or (k, 1)."""
        load, panels = self.load, self.panels
        at_zero = load.step_shear - load.far_slip_rate
        at_zero -= self._reference_sense * load.friction * load.step_pressure
        value = at_zero / self._canonical_at_zero
        for i, imag in self._sources:
            density = panels.jacobian[i] * imag / panels.at.v[i]
            value = value + panels.rule.spacing / np.pi * density.sum(axis=-1, keepdims=True)
        return value

    @cached_property
    def _cauchy(self) -> np.ndarray | None:
        """C(-v + i0) at the nodes, complex; None without sources."""
        if not self._sources:
            return None
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
    def stick_transform(self) -> Array:
        """(p, ..., n): T / M_+ where the interface sticks (meaningless elsewhere)."""
        load = self.load
        cauchy = 0.0 if self._cauchy is None else self._cauchy.real
        reduced = self.canonical * (cauchy + self.constant)
        if not load.step_pressure:
            return reduced
        amount = self._reference_sense * load.friction * load.step_pressure
        return reduced + amount / self._mode_one_at_zero * self._mode_ratio.real

    def stick_transform_off_cut(self, k: Array) -> Array:
        """T / M_+ at k > 0, any shape: what drives the slot faces (one set of zones)."""
        load, panels = self.load, self.panels
        flat = np.ravel(k)
        value = np.exp(self._phase_integral_off_cut(self._slip_pieces, flat))
        if self._slips_at_c:
            value /= self.factors.c + flat
        if self._slips_at_b:
            value *= np.sqrt(1 + flat)
        for edge, exponent in self._square_roots:
            value *= (edge.v + flat) ** exponent
        cauchy = np.full_like(flat, self.constant[0])
        for source, imag in self._sources:
            kernel = 1 / (panels.at.v[source] + flat[:, None])
            cauchy -= panels.rule.spacing / np.pi * kernel @ (panels.jacobian[source] * imag)
        amount = self._reference_sense * load.friction * load.step_pressure
        ratio = np.sqrt((1 + flat) / (self.factors.a + flat)) * amount / self._mode_one_at_zero
        return (value * cauchy + ratio).reshape(np.shape(k))

    @cached_property
    def stick_transform_at_edge(self) -> Array:
        """Limit of T / M_+ at the contact edge when it sticks: K_II / (M_+(0) K_II of Q_0 = 1).

        () or (k,).
        """
        load = self.load
        amount = self._reference_sense * load.friction * load.step_pressure
        return np.asarray((self.constant + amount / self._mode_one_at_zero)[..., 0])

    @cached_property
    def stick_transform_excess(self) -> Array:
        """(..., n): T / M_+ less its limit at a stuck contact edge, last panel, without loss."""
        panels, load, factors = self.panels, self.load, self.factors
        last = len(panels.sense) - 1
        at = panels.at[last]
        log = np.zeros_like(at.v)
        log += self._phase_integral(self._slip_pieces, np.array([last]))[0]
        if self._slips_at_c:
            log -= _log_share(at.from_c, at.v, np.array(factors.c))
        if self._slips_at_b:
            log += 0.5 * _log_share(at.from_b, at.v, np.array(1.0))
        for edge, exponent in self._square_roots:
            log += exponent * _log_share(panels.minus(edge)[last], at.v, edge.v)
        cauchy = np.zeros_like(log) if self._cauchy is None else self._cauchy[last].real
        ratio = np.expm1(0.5 * _log_share(at.from_b, at.from_a, np.array(1.0 - factors.a)))
        amount = self._reference_sense * load.friction * load.step_pressure
        growth = np.expm1(log)
        return growth * (cauchy + self.constant) + cauchy + amount / self._mode_one_at_zero * ratio

    @cached_property
    def slip_rate_slope(self) -> Array:
        """(p, ..., n): dV/dv on panels that slip, 0 on panels that stick."""
        panels, load = self.panels, self.load
        slip = panels.sense != 0
        cauchy = 0.0 if self._cauchy is None else self._cauchy[slip]
        transform = self.canonical[slip] * (cauchy + self.constant)
        ratio = (transform / self._impedance[slip]).imag
        if load.step_pressure:
            amount = self._reference_sense * load.friction * load.step_pressure
            scale = amount / (self.factors.kappa * self._mode_one_at_zero)
            ratio = ratio + scale * self._mode_ratio[slip].imag / self._m_plus[slip]
        result = np.zeros_like(panels.jacobian)
        result[slip] = -ratio / (np.pi * panels.at.v[slip])
        return result

    @cached_property
    def traction_slope(self) -> Array:
        """(p, ..., n): dtau/dv on panels that stick, 0 on panels that slip."""
        panels = self.panels
        stick = panels.sense == 0
        unit = self._impedance[stick].imag / (self._m_plus[stick] * panels.at.v[stick])
        result = np.zeros_like(panels.jacobian)
        result[stick] = unit * self.stick_transform[stick] / (np.pi * self.factors.kappa)
        return result

    def strength(self, edge: CutPoints) -> Array:
        """Friction bound f p at an edge."""
        load = self.load
        pressure = np.full(edge.v.shape, load.base_pressure)
        if load.step_pressure:
            mode_one = stuck_traction(self.factors.poisson_ratio, "I")
            pressure = pressure + load.step_pressure * mode_one(edge.v)
        return load.friction * pressure

    @cached_property
    def _excess_slope(self) -> Array:
        """(p, ..., n): slope of traction less the following zone's sense times strength."""
        panels, load = self.panels, self.load
        slope = self.traction_slope
        if load.step_pressure == 0:
            return slope
        following = [self.zones[min(k, len(self.zones) - 1)].sense for k in panels.zone]
        sense = np.where(panels.sense == 0, following, 0)
        factor = sense.reshape(-1, *[1] * (slope.ndim - 1)) * load.friction
        return slope - factor * self._pressure_slope

    def mismatch(self) -> Array:
        """What the edges leave unfulfilled: one row per edge, (e,) or (e, k).

        For each zone: traction less sense times strength where it opens (over the width of the
        stick gap before it when that is narrow), and the slip rate left where it heals.
        """
        panels, load = self.panels, self.load
        excess = panels.integrals(self._excess_slope)
        slip_rate = panels.integrals(self.slip_rate_slope)
        rows: list[Array] = []
        far_slip_rate = per_set(load.far_slip_rate)
        traction: Array | float = load.base_shear - far_slip_rate
        strength: Array | float = per_set(load.friction) * load.base_pressure
        healed: CutPoints | None = None
        for index, zone in enumerate(self.zones):
            if zone.left is not None:
                before = (panels.sense == 0) & (panels.zone == index)
                opening = traction - zone.sense * strength + excess[before].sum(axis=0)
                if healed is not None:
                    opening = opening / np.minimum(1.0, zone.left.minus(healed)[..., 0])
                rows.append(np.asarray(opening))
            if zone.right is not None:
                start = far_slip_rate if zone.left is None else 0.0
                inside = (panels.sense != 0) & (panels.zone == index)
                rows.append(start + slip_rate[inside].sum(axis=0))
                healed, strength = zone.right, self.strength(zone.right)[..., 0]
                traction = zone.sense * strength
        return np.stack(rows)
