"""Slip rate, slip and shear traction of given zones as functions of slowness, b = mu = 1.

They are the integrals of the slopes of `zones` from the longitudinal front inward.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from semianalytic.cut.load import Load, per_set
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.cut.quadrature.running import PanelIntegral
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.halfplane.stuck import StuckTraction, traction_of
from semianalytic.scene.arrays import Array

_LAWFUL = -1.0


@dataclass(frozen=True)
class Profile:
    """Integrated fields of `ZoneFields`; slip rates are one-sided, u = t/x >= 0 has shape (n,).

    For k sets of zones at once there are the fields at the nodes, (k, n), and the values at the
    contact edge, (k,). Fields at any u are for one set.
    """

    fields: ZoneFields

    @property
    def panels(self) -> Panels:
        """Panels of the fields."""
        return self.fields.panels

    @property
    def _load(self) -> Load:
        return self.fields.load

    @property
    def edge_slips(self) -> bool:
        """Whether slip reaches the contact edge."""
        return bool(self.panels.sense[-1])

    @property
    def _m_plus_at_zero(self) -> float:
        return self.fields.factors.m_plus_at_zero[self.fields.factors.mode]

    @cached_property
    def edge_intensity(self) -> Array:
        """K_II (K_III) over that of a unit step on a stuck interface, () or (k,); 0 if the edge
        slips.
        """
        if self.edge_slips:
            return np.zeros(())
        return np.asarray(self.fields.stick_transform_at_edge * per_set(self._m_plus_at_zero))

    @cached_property
    def rate_integral(self) -> PanelIntegral:
        """Running integral of V on panels that slip."""
        return self.fields.rate_integral(None if self._load.resists_rate else self.tail)

    @property
    def tail(self) -> Array:
        """Limit of v^2 dV/dv at the edge, () or (k,); 0 where it sticks, or under a film."""
        if not self.edge_slips or self._load.resists_rate:
            return np.zeros(())
        # T tends to a constant at a slipping edge and M to i kappa v: dV/dv ~ T / (pi kappa v^2).
        kappa = per_set(self.fields.factors.kappa)
        return np.asarray(self.fields.transform_at_edge[..., 0] / (np.pi * kappa))

    @cached_property
    def traction_integral(self) -> PanelIntegral:
        """Running integral of traction on stick, less the part unbounded at a stuck edge."""
        slope = self.fields.traction_slope
        if not self.edge_slips:
            slope = slope.copy()
            unit = self._shear.slope(self.panels.at[-1]) * self._m_plus_at_zero
            # The singular part is a multiple of q*, whose primitive is known: it is added by
            # `_edge_traction`.
            slope[-1] = self.fields.stick_transform_excess * unit
        return PanelIntegral(self.panels, slope, self.fields.factors.c)

    @property
    def _shear(self) -> StuckTraction:
        return traction_of(self.fields.factors, self.fields.factors.mode)

    def _edge_traction(self, panel: int, v: Array) -> Array | float:
        """Return the part of the traction that is unbounded at a stuck edge."""
        if self.panels.right[panel] is not None:
            return 0.0
        # Counted from the left end of the last panel, like the integral that it is added to.
        gained = self._shear(v) - self._shear(self.panels.left[panel].v)
        return self.edge_intensity[..., None] * gained

    @cached_property
    def rate_starts(self) -> Array:
        """Slip rate at the left end of each panel, (p, ...)."""
        panels = self.panels
        rate = np.zeros(panels.jacobian.shape[:-1])
        rate[0] = per_set(self._load.far_slip_rate)
        for i in range(len(panels.left) - 1):
            # Within a zone V goes on from panel to panel; its end is no zero to rounding, and the
            # zone behind does not inherit what is left there.
            if panels.sense[i] and panels.sense[i + 1]:
                rate[i + 1] = rate[i] + self.rate_integral.totals[i]
        return rate

    @cached_property
    def traction_starts(self) -> Array:
        """Traction, where it sticks, at the left end of each panel, (p, ...)."""
        panels, load = self.panels, self._load
        traction = np.zeros(panels.jacobian.shape[:-1])
        traction[0] = self.fields.base_traction
        for i in range(len(panels.left) - 1):
            # Stick hands the traction on to the next panel. V stays 0 there: each zone begins at 0.
            if not panels.sense[i]:
                traction[i + 1] = traction[i] + self.traction_integral.totals[i]
                continue
            if panels.sense[i + 1]:
                continue
            right = panels.right[i]
            assert right is not None
            # At the end of a zone the traction is s f p: it starts from there in the stick behind.
            if self.normal is None:
                strength = self.fields.strength(right)[..., 0]
            else:
                strength = -per_set(load.friction) * self.normal.traction_starts[i + 1]
            traction[i + 1] = panels.sense[i] * strength
        return traction

    @cached_property
    def _slip_starts(self) -> Array:
        """Slip / x at the left end of each panel, (p,)."""
        panels, rate = self.panels, self.rate_starts
        slip = np.zeros(len(panels.left))
        slip[0] = self._load.far_slip_rate * panels.left[0].v[0]
        for i in range(len(slip) - 1):
            slip[i + 1] = slip[i]
            if panels.sense[i]:
                left, right = panels.left[i], panels.right[i]
                assert right is not None
                end = rate[i] + self.rate_integral.totals[i]
                _, mean = self.rate_integral.with_mean(i, right)
                # Slip / x is the integral of V over slowness, here by parts: [v V] - int v dV.
                slip[i + 1] += (end - mean[0]) * right.v[0] - rate[i] * left.v[0]
        return slip

    @cached_property
    def slip_rate_at_nodes(self) -> Array:
        """V at the nodes of all panels, (p, ..., n)."""
        return self.rate_starts[..., None] + self.rate_integral.at_nodes

    @cached_property
    def traction_at_nodes(self) -> Array:
        """tau at the nodes of panels that stick, (p, ..., n); meaningless elsewhere."""
        traction = self.traction_starts[..., None] + self.traction_integral.at_nodes
        if not self.edge_slips:
            traction[-1] += self._edge_traction(len(traction) - 1, self.panels.at.v[-1])
        return traction

    @cached_property
    def normal(self) -> Profile | None:
        """Profile of the normal problem at the same nodes, gap for slip; None if all is closed."""
        return Profile(self.fields.normal) if self.fields.normal is not None else None

    @property
    def strength_at_nodes(self) -> Array:
        """Strength f p at the nodes of all panels, (p, ..., n)."""
        return self._strength_on(0, len(self.panels.sense))

    def _strength_on(self, start: int, stop: int) -> Array:
        """Return the strength f p at the nodes of consecutive panels, (m, ..., n)."""
        if self.normal is None:
            at, ahead = self.panels.at, min(max(start, self.panels.layout.ahead), stop)
            # Tables differ ahead of the shear front and behind it.
            parts = (at[start:ahead], at[ahead:stop])
            return np.concatenate([self._strength_at(part) for part in parts])
        pressure = -self.normal.traction_at_nodes[start:stop]
        pressure[self._open[start:stop]] = 0.0
        return np.asarray(self._load.friction * pressure)

    @cached_property
    def _open(self) -> np.ndarray:
        """Whether the contact is open on each panel, (p,)."""
        return np.array(self.panels.layout.open)

    def _excess(self, region: list[int], strength: Array, traction: Array) -> Array:
        """Return |tau| - f p (p, ..., n) on stick, over strength plus load, or its share in narrow
        gaps.
        """
        panels = self.panels
        right = panels.right[region[-1]]
        if right is None:
            return (np.abs(traction) - strength) / (1 + strength)
        # In a gap between zones the traction starts from strength, and what slip would radiate it
        # falls, like the impedance, with the distance from c.
        left = panels.left[region[0]]
        reach = np.maximum(np.abs(left.from_c), np.abs(right.from_c)) if region[0] else 1.0
        scale = np.minimum(1.0, reach) + strength.max(axis=(0, -1))[..., None]
        return np.asarray((np.abs(traction) - strength) / scale)

    @cached_property
    def largest_rate(self) -> Array:
        """Largest |V| at the nodes, () or (k,), off borders of the opening of infinite rate."""
        size = np.abs(self.slip_rate_at_nodes)
        for power in self.rate_integral.powers:
            # Slip rate is infinite there; half and twice change the largest by up to 16 %, but no
            # edges.
            beside = (power.exponent < 0) & (power.share(self.panels) < 0.1)
            size[power.panel][beside] = 0.0
        return np.asarray(size.max(axis=(0, -1)))

    @cached_property
    def wrong_at_nodes(self) -> Array:
        """Violation of Coulomb's law at the nodes, (p, ..., n), positive where it fails.

        On slip it is the rate against the sense of the zone over the largest rate, on stick as
        `_excess`; where the contact is open the law asks nothing.
        """
        panels, rate = self.panels, self.slip_rate_at_nodes
        sense = np.array(panels.sense).reshape(-1, *[1] * (rate.ndim - 1))
        largest = self.largest_rate[..., None]
        result = np.asarray(-sense * rate / np.where(largest > 0, largest, 1.0))
        for region in (part for part in panels.layout.closed_regions if not panels.sense[part[0]]):
            traction = self.traction_at_nodes[region]
            strength = self._strength_on(region[0], region[-1] + 1)
            result[region] = self._excess(region, strength, traction)
        result[self._open] = _LAWFUL
        return result

    def wrong(self, panel: int, at: CutPoints) -> Array:
        """Return `wrong_at_nodes` at points (m,) inside a panel, for one set of zones."""
        sense = self.panels.sense[panel]
        if self._open[panel]:
            return np.full(at.v.shape, _LAWFUL)
        if sense:
            rate = self.rate_starts[panel] + self.rate_integral(panel, at)
            return np.asarray(-sense * rate / self.largest_rate)
        traction = self.traction_starts[panel] + self.traction_integral(panel, at)
        traction = traction + self._edge_traction(panel, at.v)
        region = next(part for part in self.panels.layout.closed_regions if panel in part)
        return self._excess(region, self._strength_at(at)[None], traction[None])[0]

    def residues(self, panel: int) -> Array:
        """Return the coefficient of ln |v - c| in V where a zone covers c, () or (k,)."""
        return np.asarray(self.rate_integral.residues[panel])

    def residue(self, panel: int) -> float:
        """Return the coefficient of ln |v - c| for one set of zones."""
        return float(self.residues(panel))

    @cached_property
    def edge_slip_rate(self) -> float:
        """V at the contact edge."""
        rate = self.rate_starts[-1] + self.rate_integral.totals[-1]
        return float(rate) if self.edge_slips else 0.0

    def piecewise(
        self, u: Array, ahead: float | Array, inside: Callable[[int, CutPoints], Array]
    ) -> Array:
        """Return a field at slownesses (m,) from its value ahead of all waves and inside panels."""
        return self._piecewise_at(self.fields.factors.cut(u), ahead, inside)

    def _piecewise_at(
        self, at: CutPoints, ahead: float | Array, inside: Callable[[int, CutPoints], Array]
    ) -> Array:
        result = np.full(at.v.shape, ahead)
        panel = self.panels.panel_of(at)
        for i in np.unique(panel[panel >= 0]):
            here = panel == i
            result[here] = inside(int(i), at[here])
        return result

    def slip_rate_inside(self, panel: int, at: CutPoints) -> Array:
        """Return V at points (m,) inside a panel."""
        if not self.panels.sense[panel]:
            return np.zeros(at.v.shape)
        return np.asarray(self.rate_starts[panel] + self.rate_integral(panel, at))

    def slip_rate(self, u: Array) -> Array:
        """Return V at slownesses u."""
        return self.slip_rate_at(self.fields.factors.cut(u))

    def slip_rate_at(self, at: CutPoints) -> Array:
        """Return V at points whose distances from the fronts are exact, however small."""
        return self._piecewise_at(at, self._load.far_slip_rate, self.slip_rate_inside)

    def slip_over_time(self, u: Array) -> Array:
        """Return slip / t at slownesses u: the mean of V over slownesses up to u."""
        rate, slip = self.rate_starts, self._slip_starts

        def inside(i: int, at: CutPoints) -> Array:
            if not self.panels.sense[i]:
                return slip[i] / at.v
            # (s_i + int V dw) / v by parts, as in `_slip_starts`, with V = V_i + gain and v times
            # mean = int w dV from the left end v_i: V_i + gain - mean + (s_i - V_i v_i) / v.
            gain, mean = self.rate_integral.with_mean(i, at)
            start = slip[i] - rate[i] * self.panels.left[i].v
            return rate[i] + (gain - mean) + start / at.v

        return self.piecewise(u, self._load.far_slip_rate, inside)

    def pressure_change(self, u: Array) -> Array:
        """Return p - P_b at slownesses u."""
        return self._pressure_at(self.fields.factors.cut(u)) - self._load.base_pressure

    def strength(self, u: Array) -> Array:
        """Return the strength f p at slownesses u."""
        return self._strength_at(self.fields.factors.cut(u))

    def _strength_at(self, at: CutPoints) -> Array:
        """Return the strength f p at points on the cut, any shape."""
        return np.asarray(self._load.friction * self._pressure_at(at))

    def _pressure_at(self, at: CutPoints) -> Array:
        """Return the contact pressure at points on the cut, any shape; 0 where it is open."""
        if self.normal is None:
            return self._load.pressure(self.fields.factors, at)
        # On the panels of slip the small pressure near an opening is accurate to itself.
        seen = self.fields.factors.seen_in_plane(CutPoints(at.parts.reshape(4, -1)))
        return -self.normal.traction_at(seen).reshape(at.v.shape)

    def carried(self, v: Array, speed: Array, is_open: bool | np.ndarray = False) -> Array:
        """Return the traction f p + eta V under |V| = `speed`; 0 where the contact is open."""
        if self._load.linearised is not None:
            return self._load.linearised.carried(self.strength(v), speed)
        if self._load.resistance is None:
            return self.strength(v)
        return np.where(is_open, 0.0, self.strength(v) + self._load.resistance * speed)

    @cached_property
    def carried_at_nodes(self) -> Array:
        """That traction at the nodes of panels that slip, (p, n); meaningless elsewhere."""
        sense = np.array(self.panels.sense)[:, None]
        return self.carried(self.panels.at.v, sense * self.slip_rate_at_nodes, self._open[:, None])

    def carried_inside(self, panel: int, v: Array, speed: Array) -> Array:
        """Return the traction in the sense of slip at slownesses v inside a panel that slips."""
        return self.carried(v, speed, bool(self._open[panel]))

    def _speed(self, panel: int, at: CutPoints) -> Array:
        """Return V in the sense of a slipping panel where traction depends on it; else 0."""
        if not self._load.resists_rate:
            return np.zeros(at.v.shape)
        return np.asarray(self.panels.sense[panel] * self.slip_rate_inside(panel, at))

    def shear_change(self, u: Array) -> Array:
        """Return tau - Q_b at slownesses u."""
        return self.traction_at(self.fields.factors.cut(u)) - self._load.base_shear

    def traction_at(self, at: CutPoints) -> Array:
        """Return tau at points (m,) whose distances from the fronts are exact."""
        load = self._load

        def inside(i: int, at: CutPoints) -> Array:
            if sense := self.panels.sense[i]:
                return sense * self.carried_inside(i, at.v, self._speed(i, at))
            gained = self.traction_starts[i] + self.traction_integral(i, at)
            return gained + self._edge_traction(i, at.v)

        # Slip ahead of all waves radiates -mu b V(inf).
        return self._piecewise_at(at, load.base_shear - load.far_slip_rate, inside)
