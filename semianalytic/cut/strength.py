"""Compute the strength on the panels of the cut, and where it does not satisfy its condition.

On slip of sense s the shear traction follows the strength,

    dtau/dv = s f dp/dv + eta d|V|/dv + dg/dv.

The pressure comes from the normal problem; eta and dg/dv are given on the panels. The part A = s f
P of the transform T, with P the transform of pressure and s the sense next to the contact edge,
already has the right imaginary part where the interface slips in that sense, closed or open, and
the right phase where it sticks behind the shear front. The Cauchy integral C of `zones` supplies
the remainder; its sources are computed here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.cut.canonical import CanonicalFunction, log_share
from semianalytic.cut.load import Load
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.stuck import traction_of
from semianalytic.scene.arrays import Array, Complex


@dataclass(frozen=True)
class PressurePart:
    """The part s f P of the transform of slip zones, and where its condition is not satisfied."""

    load: Load
    canonical: CanonicalFunction
    sense: int  # s, the sense of the zone next to the contact edge; 0 without zones
    # P / M_+^I where the contact is closed, P where it is open (panels of the mask `open`), both
    # real, (p, ..., n); None if it is closed everywhere, where P / M_+^I is P_0 / M_+^I(0)
    opened: Array | None
    open: np.ndarray  # whether the contact is open, per panel, (p,)
    opened_at_edge: float | Array = 0.0  # limit of P / M_+^I at the contact edge, with `opened`

    @property
    def _weight(self) -> float | Array:
        """The factor s f."""
        return self.sense * self.load.friction

    @cached_property
    def analytic(self) -> bool:
        """Whether s f P is part of T, which requires slip and a change of pressure."""
        return bool(self.sense and self.load.load_pressure != 0)

    @cached_property
    def amount(self) -> float | Array:
        """s f P / M_+^I on closed panels; a number (or (k, 1)) if all of the contact is closed and
        the load comes at once."""
        if not self.analytic:
            return 0.0
        if self.opened is not None:
            return self._weight * self.opened
        return self._weight * self._unit * self.load.front_factor(self.canonical.panels.at)

    @cached_property
    def _unit(self) -> float | Array:
        """P_0 / M_+^I(-p), the limit of P / M_+^I at the contact edge if it is closed."""
        factors, load = self.canonical.factors, self.load
        return load.load_pressure / factors.m_plus_at_load(load.slowness, "I")

    @property
    def amount_at_edge(self) -> float | Array:
        """Limit of `amount` at a stuck contact edge."""
        if not self.analytic:
            return 0.0
        if self.opened is None:
            return self._weight * self._unit
        return self._weight * self.opened_at_edge

    def amount_on(self, panels: np.ndarray | slice | int) -> float | Array:
        """Return `amount` on some panels."""
        if not self.analytic or (self.opened is None and not self.load.slowness):
            return self.amount
        return np.asarray(self.amount)[panels]

    @cached_property
    def mode_ratio(self) -> tuple[Array, Array]:
        """M_+^I / M_+ at the nodes: real part, and imaginary part ahead of the shear front.

        In mode II it is -i sqrt((b - v) / (v - a)) there, and the real part holds its modulus.
        """
        canonical, ahead = self.canonical, self.canonical.layout.ahead
        at, factors = canonical.panels.at, canonical.factors
        if factors.mode == "II":
            # M_+^I / M_+^II = sqrt((b + k) / (a + k)): all other factors are common to both modes.
            ratio = np.sqrt(np.abs(at.from_b / at.from_a))
            return ratio, -ratio[:ahead]
        normal = factors.in_plane
        unit = normal.kappa * factors.m_plus(at.v, "I")
        ratio = np.empty_like(at.v)
        ratio[ahead:] = normal.impedance_behind(factors.seen_in_plane(at[ahead:]), "I")
        ratio[ahead:] /= unit[ahead:] * np.sqrt(at.from_b[ahead:])
        # In mode III M_+ = sqrt(b + k), which is imaginary behind the shear front b only: the ratio
        # keeps both parts of the mode I impedance ahead of it.
        both = np.stack(normal.impedance_ahead(at[:ahead], "I")) / unit[:ahead]
        ratio[:ahead], imag = both / np.sqrt(-at.from_b[:ahead])
        return ratio, imag

    @cached_property
    def ratio_less_edge(self) -> Array:
        """M_+^I / M_+ over its limit at the edge, less 1, on the last panel, (..., n), to all
        digits.
        """
        at, factors = self.canonical.panels.at[-1], self.canonical.factors
        if factors.mode == "II":
            return np.expm1(0.5 * log_share(at.from_b, at.from_a, np.array(1.0 - factors.a)))
        from_c = factors.seen_in_plane(at).from_c
        log = log_share(np.abs(from_c), at.v, np.array(factors.in_plane.c))
        log = log - 0.5 * log_share(at.from_a, at.v, np.array(factors.a))
        log = log - 0.5 * log_share(at.from_b, at.v, np.array(1.0))
        log = log + factors.log_s_plus_behind(at)
        # In antiplane shear a stuck edge may reach ahead of c, where M_+^I changes sign.
        return np.where(from_c < 0, -np.exp(log) - 1, np.expm1(log))

    @cached_property
    def slope(self) -> Array:
        """dp/dv = Im P(-v + i0) / (pi v) at the nodes, (p, ..., n); 0 where open."""
        canonical, factors, load = self.canonical, self.canonical.factors, self.load
        at = canonical.panels.at
        if factors.mode == "III":
            unit = traction_of(factors, "I").slope(factors.seen_in_plane(at))
            slope = unit * factors.m_plus_at_zero["I"]  # that of a load which comes at once
        else:
            (real, imag), ahead = canonical.impedance, canonical.layout.ahead
            ratio, _ = self.mode_ratio
            # Im P with P = (P / M_+^I) (M_+^I / M_+) M_+: the ratio is real behind the shear front,
            # and -i |ratio| ahead of it, where Im (-i M) = -Re M.
            slope = imag * ratio
            slope[:ahead] = -real * ratio[:ahead]
            slope /= np.pi * factors.kappa * canonical.m_plus * at.v
        if self.opened is None:
            return np.asarray(slope * (self._unit * load.front_factor(at)))
        return np.asarray(slope * np.where(self._per_panel(self.open), 0.0, self.opened))

    def on_stick(self, panels: slice | int) -> Array:
        """Return A / M_+ at the nodes of panels that stick: the real part ahead of the shear front.

        Behind the shear front it is real.
        """
        return np.asarray(self.amount_on(panels) * self.mode_ratio[0][panels])

    @property
    def on_slip(self) -> Complex:
        """A(-v + i0) at the nodes of panels that slip, (s, ..., n)."""
        canonical, slip = self.canonical, self.canonical.layout.slip
        factors, at = canonical.factors, canonical.panels.at[slip]
        if not self.analytic:
            return np.zeros(at.v.shape, dtype=complex)
        normal = factors.in_plane
        plane = factors.seen_in_plane(at)
        unit = normal.impedance_on_cut(plane, "I") / (normal.kappa * factors.m_plus(at.v, "I"))
        unit = np.where(self._per_panel(self.open[slip]), 1.0, unit)
        return np.asarray(self.amount_on(slip) * unit)

    def _per_panel(self, values: np.ndarray) -> np.ndarray:
        """Return (p,) values with the axes of nodes."""
        return values.reshape(-1, *[1] * (self.canonical.panels.jacobian.ndim - 1))

    @cached_property
    def over_impedance(self) -> Array:
        """Im (A / M) at the nodes of panels that slip, (p, ..., n), 0 elsewhere."""
        canonical, layout = self.canonical, self.canonical.layout
        result = np.zeros_like(canonical.panels.jacobian)
        if not self.analytic:
            return result
        real, imag = canonical.impedance
        ahead = layout.slip_ahead
        by_ratio = self.amount_on(ahead) * self.mode_ratio[1][ahead]
        result[ahead] = by_ratio / (canonical.factors.kappa * canonical.m_plus[ahead])
        # P is real where the contact is open: Im (A / M) = -A Im M / |M|^2.
        for panel in np.flatnonzero(self.open & layout.slipping):
            square = np.square(imag[panel])
            if panel < layout.ahead:
                square = square + np.square(real[panel])
            result[panel] = -self.amount_on(int(panel)) * imag[panel] / square
        return result

    @cached_property
    def sources(self) -> tuple[np.ndarray, Array]:
        """Panels on which C has an imaginary part, and Im C at all nodes, (p, ..., n).

        These are stick ahead of the shear front, zones of the other sense, and slip whose strength
        has parts that A does not contain.
        """
        canonical, layout = self.canonical, self.canonical.layout
        imag = np.zeros_like(canonical.panels.jacobian)
        stick = layout.stick_ahead[:0]
        if self.analytic:
            stick = layout.stick_ahead
            by_ratio = self.amount_on(stick) * self.mode_ratio[1][stick]
            # On stick Im (T / M_+) = 0: X C / M_+ cancels the imaginary part of A / M_+.
            imag[stick] = -by_ratio / canonical.values[stick]
        slip = self._missing_on
        if len(slip):
            imag[slip] = self._missing[slip] / canonical.values[slip]
            if canonical.resistance is not None:
                modulus, _ = canonical.excess_impedance
                # (1 + eta / M) X is real there; `values` hold |X| with its sign.
                imag[slip] /= modulus[np.searchsorted(layout.slip, slip)]
        return np.append(stick, slip), imag

    @cached_property
    def _missing_on(self) -> np.ndarray:
        """Panels that slip and on which A does not have the slope of the strength."""
        layout, senses = self.canonical.layout, np.array(self.canonical.panels.sense)
        if self.load.given_slope is not None:
            return layout.slip
        wrong = np.zeros(len(senses), dtype=bool)
        if self.load.load_pressure != 0 and self.sense:
            wrong = senses != self.sense
        if self.analytic and self.canonical.resistance is not None:
            wrong[: layout.ahead] = True
        return np.flatnonzero(wrong & layout.slipping)

    @cached_property
    def _missing(self) -> Array:
        """Im [(1 + eta / M)(T - A)] at the nodes of panels that slip, (p, ..., n)."""
        canonical = self.canonical
        at, senses = canonical.panels.at, np.array(canonical.panels.sense)
        # The strength of a zone of the other sense differs by twice f P, since A has the wrong
        # sign.
        rest = senses - (self.sense if self.analytic else 0)
        missing = np.zeros_like(at.v)
        if self.load.load_pressure != 0:
            missing = self._per_panel(rest) * (np.pi * self.load.friction * at.v * self.slope)
        if self.load.given_slope is not None:
            missing = missing + np.pi * at.v * self.load.given_slope[: len(at.v)]
        if canonical.resistance is not None and self.analytic:
            slip = canonical.layout.slip
            missing[slip] -= canonical.eta * self.over_impedance[slip]
        return missing
