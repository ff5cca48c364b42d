"""The canonical function X of slip zones, with the phase of M_+ on stick and real on slip.

Where slip of rate V meets the resistance eta V, X has the phase of M / (M + eta) instead.

X carries the behaviour at each edge. An edge at which slip begins has |v - edge|^(-1/2) in dV/dv if
it runs slower than c_R, and |v - edge|^(-phi/pi) between c_t and c_l. An edge that heals has |v -
edge|^(-1/2) between c_R and c_t. The others are smoother by one power, because |tau| <= f p would
fail otherwise. X depends on the zones but not on the load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.cut.quadrature.layout import Layout
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import RayleighFactors
from semianalytic.scene.arrays import Array


def log_share(part: Array, whole: Array, rest: Array) -> Array:
    """Return ln(part / whole), accurate for small part and for small rest = whole - part."""
    share = rest / whole
    near = np.abs(share) > 0.5
    return np.where(near, np.log(part / whole), np.log1p(-np.where(near, 0.0, share)))


@dataclass(frozen=True)
class Phase:
    """Phase phi of panels ahead of the shear front (s, ..., n): a chord plus a rest.

    left, right and width are the slownesses of the ends (s, ..., 1) and their distance, start and
    stop the values of phi there; `rest` is (phi - chord) dv/dy at the nodes.
    """

    left: Array
    right: Array
    width: Array
    start: Array
    stop: Array
    rest: Array

    def __getitem__(self, index: np.ndarray) -> Phase:
        """Return the phase of some of the panels."""
        every = (self.left, self.right, self.width, self.start, self.stop, self.rest)
        return Phase(*(part[index] for part in every))

    def chord_integral(self, to_left: Array, to_right: Array) -> Array:
        """Return the integral of chord(w) / (w - v); to_left = v - left, to_right = v - right."""
        share = self.width / to_left
        log = np.log(np.abs(to_right / to_left))
        linear = log / share + 1
        # Far from a panel, log / share + 1 cancels: a series replaces it.
        small = np.abs(share) < 0.02
        if small.any():
            few = share[small]
            half = few / (2 - few)  # ln(1 - s) = -2 artanh(s / (2 - s))
            square = half * half
            series = square * (1 / 3 + square * (1 / 5 + square * (1 / 7 + square / 9)))
            linear[small] = -half - 2 / (2 - few) * series
            log[small] = -2 * half * (1 + series)
        return self.start * log + (self.stop - self.start) * linear


@dataclass(frozen=True)
class CanonicalFunction:
    """X on the panels of slip zones, and the impedance there, b = mu = 1."""

    factors: RayleighFactors
    panels: Panels
    # eta = dtau/d|V| at the nodes [mu b], of the one-sided slip rate, of a shape that broadcasts to
    # (p, ..., n); None if strength does not depend on slip rate.  Slip that covers c is cut there.
    resistance: Array | None = None

    @property
    def layout(self) -> Layout:
        """Order and kinds of the panels."""
        return self.panels.layout

    @cached_property
    def impedance(self) -> tuple[Array, Array]:
        """Real part of M ahead of b (h, ..., n), and imaginary part, (p, ..., n), at the nodes."""
        at, ahead = self.panels.at, self.layout.ahead
        imag = np.empty_like(at.v)
        real, imag[:ahead] = self.factors.impedance_ahead(at[:ahead])
        imag[ahead:] = self.factors.impedance_behind(at[ahead:])
        return real, imag

    @cached_property
    def m_plus(self) -> Array:
        """M_+ at the nodes, (p, ..., n)."""
        return self.factors.m_plus(self.panels.at.v)

    @cached_property
    def _phase(self) -> Phase:
        """Phase phi on all panels ahead of the shear front, as chord and rest."""
        panels, ahead, (real, imag) = self.panels, self.layout.ahead, self.impedance
        ends = panels.ends[: ahead + 1]
        phi = self.factors.phase(ends)
        start, stop = phi[:-1], phi[1:]
        # The rest vanishes at both ends, so that its Cauchy integrals have no logarithms there.
        chord = start + (stop - start) * panels.rule.share
        whole = np.arctan2(imag[:ahead], real)
        if self.factors.mode == "I":
            # In mode I the factor 1 / alpha of M turns its phase by -pi / 2, which phi lacks.
            whole += np.pi / 2
        rest = (whole - chord) * panels.jacobian[:ahead]
        return Phase(ends.v[:-1], ends.v[1:], panels.widths[:ahead], start, stop, rest)

    @cached_property
    def _log_of_phase(self) -> Array:
        """Contribution of the phase to ln X, (1/pi) int phi(w) / (w - v) dw, (p, ..., n)."""
        panels, pairs = self.panels, self.layout.phase_pairs
        # Antiplane shear has no phase phi.
        if not self.factors.has_rayleigh_wave:
            return np.zeros_like(panels.jacobian)
        phase, distances = self._phase[pairs.source], panels.from_ends
        to_left = distances[pairs.source, pairs.target]
        to_right = distances[pairs.source + 1, pairs.target]
        chord = phase.chord_integral(to_left, to_right)
        return pairs.collect(panels.cauchy(pairs, phase.rest) + chord) / np.pi

    @cached_property
    def excess_impedance(self) -> tuple[Array, Array]:
        """|M + eta| / |M| and the phase of (M + eta) / M at the nodes of panels that slip."""
        slip, ahead, eta = self.layout.slip, len(self.layout.slip_ahead), self.eta
        real = np.zeros(eta.shape)
        real[:ahead] = self.impedance[0][self.layout.slip_ahead]
        imag = self.impedance[1][slip]
        modulus = np.hypot(real + eta, imag) / np.hypot(real, imag)
        phase = np.arctan2(-eta * imag, real * (real + eta) + np.square(imag))
        return modulus, phase

    @cached_property
    def eta(self) -> Array:
        """Resistance at the nodes of panels that slip."""
        shape = self.panels.jacobian.shape
        assert self.resistance is not None
        resistance = np.asarray(self.resistance)
        if resistance.ndim == len(shape):
            # Resistance may be given on the panel behind the last edge too, which is left out here.
            resistance = resistance[: shape[0]]
        return np.broadcast_to(resistance, shape)[self.layout.slip]

    @cached_property
    def _turn(self) -> Phase:
        """Phase of (M + eta) / M on panels that slip; on the unbounded one the chord falls like 1 /
        v.
        """
        panels, slip = self.panels, self.layout.slip
        _, turn = self.excess_impedance
        start, stop = turn[..., :1], turn[..., -1:].copy()
        ends, widths = panels.ends.v, panels.widths
        unbounded = panels.right[slip[-1]] is None if len(slip) else False
        chord = start + (stop - start) * panels.rule.share
        left = ends[slip]
        right, width = np.full_like(left, np.inf), np.full_like(left, np.inf)
        bounded = slip[:-1] if unbounded else slip
        right[: len(bounded)], width[: len(bounded)] = ends[bounded + 1], widths[bounded]
        if unbounded:
            # M ~ i kappa v far in, so that the phase of 1 + eta / M falls like 1 / v.
            stop[-1] = 0.0
            chord[-1] = start[-1] * left[-1] / panels.at.v[slip[-1]]
        return Phase(left, right, width, start, stop, (turn - chord) * panels.jacobian[slip])

    @cached_property
    def _log_of_resistance(self) -> Array:
        """Integral of the phase of (M + eta) / M over w - v, a part of ln X, (p, ..., n)."""
        panels, layout, turn = self.panels, self.layout, self._turn
        if not len(layout.slip):
            return np.zeros_like(panels.jacobian)
        pairs = layout.pairs_from(layout.slip)
        sources = np.searchsorted(layout.slip, pairs.source)
        total = pairs.collect(panels.cauchy(pairs, turn.rest[sources]))
        total[layout.slip] += panels.principal_values(layout.slip, turn.rest)
        distances = panels.from_ends
        for row, panel in enumerate(layout.slip):
            if panels.right[panel] is None:
                to_left, left = distances[panel], turn.left[row]
                total -= turn.start[row] * left / panels.at.v * np.log(np.abs(to_left) / left)
            else:
                total += turn[np.array(row)].chord_integral(distances[panel], distances[panel + 1])
        return total / np.pi

    def _resistance_integral_off_cut(self, k: Array) -> Array:
        """Return (1/pi) times the integral of that phase over w + k, at k > -a (m,); (..., m)."""
        panels, slip, turn = self.panels, self.layout.slip, self._turn
        if not len(slip):
            return np.zeros((*panels.jacobian.shape[1:-1], len(k)))
        w = panels.at.v[slip]
        kernel = 1 / (w[..., None, :] + k[:, None])
        total = panels.rule.spacing * np.sum(turn.rest[..., None, :] * kernel, axis=(0, -1))
        for row, panel in enumerate(slip):
            left = turn.left[row]
            if panels.right[panel] is None:
                share = np.where(k != 0, k / left, 1.0)
                over = np.where(k != 0, np.log1p(share) / share, 1.0)
                total = total + turn.start[row] * over
            else:
                total = total + turn[np.array(row)].chord_integral(-left - k, -turn.right[row] - k)
        return total / np.pi

    @cached_property
    def _resistance_integral_at_c(self) -> Array:
        """That part at c, where an opening covers it and the interface slides freely, (..., 1)."""
        panels, turn = self.panels, self._turn
        from_c, ends = panels.at.from_c, panels.ends.from_c
        rest = turn.rest / from_c[self.layout.slip] @ panels.rule.weights
        total = rest.sum(axis=0)[..., None]
        for row, panel in enumerate(self.layout.slip):
            if panels.right[panel] is None:
                left = turn.left[row]
                share = left / self.factors.c
                total = total - turn.start[row] * share * np.log(np.abs(ends[panel] / left))
            else:
                chord = turn[np.array(row)].chord_integral(-ends[panel], -ends[panel + 1])
                total = total + chord
        return np.asarray(total / np.pi)

    def _phase_integral_off_cut(self, sources: np.ndarray, k: Array) -> Array:
        """Return (1/pi) int phi(w) / (w + k) dw over panels, at k > -a of shape (m,); (..., m)."""
        if not self.factors.has_rayleigh_wave:
            return np.zeros((*self.panels.jacobian.shape[1:-1], len(k)))
        phase, w = self._phase[sources], self.panels.at.v[sources]
        rest = np.sum(phase.rest[..., None, :] / (w[..., None, :] + k[:, None]), axis=-1)
        chord = phase.chord_integral(-phase.left - k, -phase.right - k)
        return np.sum(self.panels.rule.spacing * rest + chord, axis=0) / np.pi

    @cached_property
    def values(self) -> Array:
        """X but for the phase of M / (M + eta) on slip, X / M_+ on stick, real, (p, ..., n)."""
        panels, layout, factors = self.panels, self.layout, self.factors
        from_root, from_c = np.abs(panels.at.parts[factors.root]), panels.at.from_c
        # One square root of the product of all distances is cheaper than one for each.
        square = np.ones_like(from_root)
        for end, exponent in layout.roots:
            distance = np.abs(panels.from_ends[end])
            square = square * distance if exponent > 0 else square / distance
        rooted = layout.stick if layout.slips_at_root else layout.slip
        if layout.slips_at_root == factors.has_rayleigh_wave:
            square[rooted] *= from_root[rooted]
        else:
            square[rooted] /= from_root[rooted]
        product = np.sqrt(square)
        # M_+ has the factor c + k: X has it too, unless slip covers c.
        if layout.slips_at_c:
            product[layout.stick] /= -from_c[layout.stick]
        elif factors.has_rayleigh_wave:
            product[layout.slip] *= -from_c[layout.slip]
        if factors.has_rayleigh_wave:
            product *= np.exp(self._log_of_phase)
            # Slip that is not joined to the shear front is written with |S_+(-v)| on the cut, from
            # |M_+(-v + i0)| = |M| / (kappa M_+(v)).
            direct = layout.slip_behind
            if len(direct) and not layout.slips_at_b:
                modulus = np.abs(self.impedance[1][direct]) / (factors.kappa * self.m_plus[direct])
                product[direct] *= modulus * np.sqrt(from_root[direct]) / np.abs(from_c[direct])
        if self.resistance is not None:
            product *= np.exp(self._log_of_resistance)
        return product * layout.sign.reshape(-1, *[1] * (product.ndim - 1))

    @cached_property
    def at_c(self) -> Array:
        """X at the Rayleigh front where slip covers it, (1,) or (k, 1)."""
        panels, layout, factors = self.panels, self.layout, self.factors
        pairs, (at, from_ends) = layout.phase_pairs, (panels.at, panels.ends.from_c)
        seen = np.flatnonzero(pairs.target == layout.pole)
        log = np.zeros_like(from_ends[0])
        for pair in seen:
            source, weight = pairs.source[pair], pairs.onto[layout.pole, pair]
            phase = self._phase[source]
            rest = phase.rest / at.from_c[source] @ panels.rule.weights
            chord = phase.chord_integral(-from_ends[source], -from_ends[source + 1])
            log += weight * (rest[..., None] + chord) / np.pi
        if self.resistance is not None:
            log = log + self._resistance_integral_at_c
        square, front = np.ones_like(log), factors.front_c.parts[factors.root]
        for end, exponent in layout.roots:
            square = square * np.abs(from_ends[end]) ** (2 * exponent)
        if not layout.slips_at_root:
            square = square / front
        value = layout.sign[layout.pole] * np.sqrt(square) * np.exp(log)
        # As in `values`, with the slope of M at its zero c in place of M.
        if not layout.slips_at_b:
            modulus = factors.impedance_slope_at_c / (factors.kappa * factors.m_plus(factors.c))
            value = value * np.abs(modulus) * np.sqrt(front)
        return np.asarray(value)

    def off_cut(self, k: float) -> Array:
        """Return X at a number k > -a off the cut, (1,) or (k, 1)."""
        at = np.full(1, k)
        value = np.exp(-self._phase_integral_off_cut(self.layout.stick_ahead, at))
        if self.resistance is not None:
            value = value * np.exp(self._resistance_integral_off_cut(at))
        if self.factors.has_rayleigh_wave and not self.layout.slips_at_c:
            value = value * (self.factors.c + k)
        if not self.layout.slips_at_root:
            value = value * (self.factors.root_slowness + k) ** self.factors.root_exponent
        for end, exponent in self.layout.roots:
            value = value * (self.panels.ends.v[end] + k) ** exponent
        return value

    def reciprocal_off_cut(self, k: Array) -> Array:
        """Return X / M_+ at k >= 0, (m,), off the cut (one set of zones)."""
        factors = self.factors
        value = np.exp(self._phase_integral_off_cut(self.layout.slip_ahead, k))
        if self.resistance is not None:
            value *= np.exp(self._resistance_integral_off_cut(k))
        if self.layout.slips_at_c:
            value /= factors.c + k
        if self.layout.slips_at_root:
            value *= (factors.root_slowness + k) ** -factors.root_exponent
        for end, exponent in self.layout.roots:
            value *= (self.panels.ends.v[end] + k) ** exponent
        return value

    @cached_property
    def log_growth(self) -> Array:
        """ln of X / M_+ over its limit at a stuck contact edge on the last panel, (..., n)."""
        panels, layout = self.panels, self.layout
        at, log = panels.at[-1], self._log_of_phase[-1]
        if layout.slips_at_c:
            log = log - log_share(at.from_c, at.v, np.array(self.factors.c))
        if layout.slips_at_root:
            from_root, front = at.parts[self.factors.root], np.array(self.factors.root_slowness)
            share = log_share(from_root, at.v, front)
            log = log - self.factors.root_exponent * share
        if self.resistance is not None:
            log = log + self._log_of_resistance[-1]
        for end, exponent in layout.roots:
            log = log + exponent * log_share(panels.from_ends[end, -1], at.v, panels.ends.v[end])
        return log
