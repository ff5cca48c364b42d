"""The canonical function X of slip zones: real on slip, of the phase of M_+ on stick.

It carries the behaviour at each edge.  The edge that opens ahead of slip has |v - edge|^(-1/2) in
dV/dv when it runs slower than c_R, |v - edge|^(-phi/pi) between c_t and c_l; an edge that heals
has it between c_R and c_t; the others are smoother by one power, for |tau| <= f p would fail.
It knows where the zones are, not how they are loaded.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.polynomial import polyval

from semianalytic.cut.layout import Layout
from semianalytic.cut.panels import Panels
from semianalytic.halfplane.rayleigh import Array, RayleighFactors

_SMALL = 1 / np.arange(2.0, 11.0)  # -(1 + ln(1 - s) / s) / s in powers of s


def log_share(part: Array, whole: Array, rest: Array) -> Array:
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
class CanonicalFunction:
    """X on the panels of slip zones, and the impedance there, b = mu = 1."""

    factors: RayleighFactors
    panels: Panels

    @property
    def layout(self) -> Layout:
        """Which panels there are."""
        return self.panels.layout

    @cached_property
    def impedance(self) -> tuple[Array, Array]:
        """M at the nodes: real part (h, ..., n) ahead of the shear front, imaginary (p, ..., n)."""
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
        """Of all panels ahead of the shear front."""
        panels, ahead, (real, imag) = self.panels, self.layout.ahead, self.impedance
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
    def values(self) -> Array:
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
            modulus = np.abs(self.impedance[1][direct]) / (self.factors.kappa * self.m_plus[direct])
            product[direct] *= modulus * np.sqrt(from_b[direct]) / np.abs(from_c[direct])
        return product * layout.sign.reshape(-1, *[1] * (product.ndim - 1))

    @cached_property
    def at_zero(self) -> Array:
        """X(0), (1,) or (k, 1)."""
        value = np.exp(-self._phase_integral_off_cut(self.layout.stick_ahead, np.zeros(1)))
        if not self.layout.slips_at_c:
            value = value * self.factors.c
        for end, exponent in self.layout.roots:
            value = value * self.panels.ends.v[end] ** exponent
        return value

    def reciprocal_off_cut(self, k: Array) -> Array:
        """X / M_+ at k >= 0, (m,), off the cut (one set of zones)."""
        value = np.exp(self._phase_integral_off_cut(self.layout.slip_ahead, k))
        if self.layout.slips_at_c:
            value /= self.factors.c + k
        if self.layout.slips_at_b:
            value *= np.sqrt(1 + k)
        for end, exponent in self.layout.roots:
            value *= (self.panels.ends.v[end] + k) ** exponent
        return value

    @cached_property
    def log_growth(self) -> Array:
        """(..., n): ln of X / M_+ over its limit at a stuck contact edge, last panel."""
        panels, layout = self.panels, self.layout
        at, log = panels.at[-1], self._log_of_phase[-1]
        if layout.slips_at_c:
            log = log - log_share(at.from_c, at.v, np.array(self.factors.c))
        if layout.slips_at_b:
            log = log + 0.5 * log_share(at.from_b, at.v, np.array(1.0))
        for end, exponent in layout.roots:
            log = log + exponent * log_share(panels.from_ends[end, -1], at.v, panels.ends.v[end])
        return log
