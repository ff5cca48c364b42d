"""Derivatives of slip rate, slip and traction as functions of slowness, b = mu = 1, one-sided.

Changes at fixed nodes of the panels are integrated like the fields themselves; the contribution of
the motion of the nodes is subtracted. With F' at a fixed node and w the velocity of the node, the
derivative at fixed slowness is

    dF/dp = F' - w dF/dv.

It is infinite at the edges where F has a power less than one. Powers of the slip rate near the
borders of an opening are differentiated in closed form, at a fixed share of the panel. See
docs/derivatives.md, "Fields".
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from semianalytic.cut.node_fields import NodeFields
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.cut.quadrature.running import PanelIntegral, Power
from semianalytic.halfplane.rayleigh import CutPoints, Mode
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.derivatives.variation import Variation


def edges_of_zones(profile: Profile) -> list[CutPoints]:
    """Return the edges of slip zones, from the longitudinal front inward, and of the opening."""
    zones, opened = profile.fields.zones, profile.fields.load.opened
    if opened is not None:
        zones = (*zones, opened.zone)
    return [edge for zone in zones for edge in (zone.left, zone.right) if edge is not None]


@dataclass(frozen=True)
class VariedProfile:
    """Derivatives of a profile with respect to a parameter, at fixed u = t/x >= 0 of shape (m,)."""

    profile: Profile
    variation: Variation

    @property
    def _panels(self) -> Panels:
        return self.profile.panels

    @property
    def _nodes(self) -> NodeFields:
        return self.variation.nodes

    def _velocity(self, panel: int, at: CutPoints) -> Array:
        """Return the velocity of points (m,) of a panel that moves with its ends, at a fixed y."""
        panels, rate = self._panels, self._nodes.skew / self._panels.skew
        moved, right = self._velocity_of_share(panel, at), panels.right[panel]
        if right is None:
            return moved
        # The skew rho changes too: ds/drho = -s (1 - s) / rho at fixed y.
        share = at.minus(panels.left[panel]) / panels.widths[panel]
        return np.asarray(moved + share * at.minus(right) * rate[panel])

    def _velocity_of_share(self, panel: int, at: CutPoints) -> Array:
        """Return the velocity of points (m,) of a panel at a fixed share of it."""
        # v = left + s width, hence dv = d left + (v - left) d ln width at a fixed share s.
        from_left = at.minus(self._panels.left[panel])
        return np.asarray(self._nodes.ends[0, panel] + from_left * self._growth[panel])

    @cached_property
    def _growth(self) -> Array:
        """Derivative of the logarithm of the width of each panel, (p, 1)."""
        panels, ends = self._panels, self._nodes.ends[0]
        growth = self._nodes.skew / panels.skew
        bounded = len(panels.widths)
        growth[:bounded] = np.diff(ends, axis=0) / panels.widths
        return np.asarray(growth)

    def moved(self, point: CutPoints) -> Array:
        """Return the derivative of the slowness of an edge or front where a panel begins, (1,)."""
        starts = [left.first for left in self._panels.left]
        return np.asarray(self._nodes.ends[0, starts.index(point.first)])

    def edge_moved(self, edge: CutPoints) -> float:
        """Return the derivative of the velocity [c_t] of an edge or front where a panel begins."""
        # The velocity is 1 / v, so that d(1/v) = -dv / v^2.
        return float(-self.moved(edge)[0] / edge.v[0] ** 2)

    def edges_moved(self) -> Array:
        """Return the derivatives (e,) of the velocities of `edges_of_zones` [c_t]."""
        return np.array([self.edge_moved(edge) for edge in edges_of_zones(self.profile)])

    @cached_property
    def _rate(self) -> PanelIntegral:
        """Running integral of the derivative of dV/dv at fixed nodes, powers at fixed shares."""
        return self._integral(self._nodes.rate / self._panels.jacobian, self._powers)

    @cached_property
    def _powers(self) -> tuple[Power, ...]:
        """Derivatives of the powers of dV/dv."""
        nodes = self._nodes
        # d(A s^n) = (dA + A dn ln s) s^n.
        return tuple(
            replace(power, amount=amount, of_log=power.amount * exponent)
            for power, amount, exponent in zip(
                self.profile.rate_integral.powers, nodes.amounts, nodes.exponents, strict=True
            )
        )

    @cached_property
    def _moment(self) -> PanelIntegral:
        """Integral whose moment is the derivative of that of dV/dv, but for ends of powers."""
        panels, rate = self._panels, self.profile.rate_integral
        velocity = np.stack([self._velocity(i, panels.at[i]) for i in range(len(panels.left))])
        carried = rate.density * velocity
        for power in rate.powers:
            i = power.panel
            carried[i] += self._growth[i] * power.moment_by_y(panels) / panels.jacobian[i]
        return self._integral(
            self._nodes.rate / panels.jacobian + carried / panels.at.v, self._powers
        )

    @cached_property
    def _traction(self) -> PanelIntegral:
        return self._integral(self._nodes.traction / self._panels.jacobian)

    def _integral(self, density: Array, powers: tuple[Power, ...] = ()) -> PanelIntegral:
        tail = None if self.profile.rate_integral.tail is None else self._nodes.tail
        front = self.profile.fields.factors.c
        return PanelIntegral(self._panels, density, front, powers, tail=tail)

    def _slope(self, integral: PanelIntegral, panel: int, at: CutPoints) -> Array:
        """Return the slope of an integral at points (m,) inside a panel, infinite at ends."""
        panels, v = self._panels, at.v
        right, rounding, wide = panels.right[panel], 4 * np.finfo(float).eps * v, 0.0
        y = np.where(at.minus(panels.left[panel]) < rounding, -np.inf, panels.coordinate(panel, at))
        if right is not None:
            y = np.where(-at.minus(right) < rounding, np.inf, y)
            wide = max(0.0, float(np.log(panels.widths[panel, 0])))
        skew = 0.0 if right is None else float(np.log(panels.skew[panel, 0]))
        first, last = min(skew, 0.0) - 12.0 - wide, max(skew, 0.0) + 12.0
        within = panels.inside(panel, np.clip(y, first, last))
        value = integral.slope(panel, within)
        # Beyond the innermost part the slope continues as a power of the distance from the end.
        for end, outward in ((first, -1.0), (last, 1.0)):
            beyond = outward * (y - end) > 0
            if beyond.any():
                pair = panels.inside(panel, end - outward * np.array([0.0, 1.0]))
                growth = _growth(integral.slope(panel, pair))
                value[beyond] *= np.exp(growth * (outward * (y[beyond] - end)))
        return value

    @property
    def _far_slip_rate(self) -> float:
        return self.variation.rates.far_slip_rate

    def slip_rate(self, u: Array) -> Array:
        """Return the derivative of V; plus or minus infinity at edges where V has a square root."""
        return self.profile.piecewise(u, self._far_slip_rate, self._slip_rate_inside)

    def _slip_rate_inside(self, i: int, at: CutPoints) -> Array:
        """Return the derivative of V at points (m,) inside a panel."""
        if not self._panels.sense[i]:
            return np.zeros(at.v.shape)
        rate = self.profile.rate_integral
        # The derivative at a fixed point is that at the moving node, less dV/dv times its velocity.
        value = self._nodes.rate_starts[i] + self._rate(i, at)
        value = value - _carried(self._slope(rate, i, at), self._velocity(i, at))
        of_powers = rate.slope_of_powers(i, at)
        return np.asarray(value - _carried(of_powers, self._velocity_of_share(i, at)))

    def moved_root(self, u: Array) -> Array:
        """Return the derivatives of slownesses (m,) at which V is zero within a zone."""
        rate = self.profile.rate_integral
        with np.errstate(invalid="ignore"):
            moved = self.slip_rate(u) / self.profile.piecewise(
                u, 0.0, lambda i, at: self._slope(rate, i, at) + rate.slope_of_powers(i, at)
            )
        # V(u(p), p) = 0 gives du/dp = -(dV/dp) / (dV/du).
        return np.where(np.isnan(moved), 0.0, -moved)

    @cached_property
    def edge_slip_rate(self) -> float:
        """Derivative of V at the contact edge."""
        if not self.profile.edge_slips:
            return 0.0
        return float(self._nodes.rate_starts[-1] + self._rate.totals[-1])

    def _slip(self, i: int, at: CutPoints, start: float | Array) -> Array:
        """Return the derivative of slip / x inside a slipping panel from that at its left."""
        gain, mean = self._rate(i, at), self._moment.with_mean(i, at)[1]
        for power in self.profile.rate_integral.powers_on(i):
            moved = self._nodes.ends[0, power.end_index]
            mean = mean + moved * power.inside(self._panels, at) / at.v
        before = self._nodes.rate_starts[i]
        # Slip / x is [v V] - int v dV over slowness; both parts are counted from the left end.
        left = self._panels.left[i].v
        return np.asarray(start + at.v * (gain - mean) + (at.v - left) * before)

    @cached_property
    def _slip_starts(self) -> Array:
        """Derivative of slip / x at the left end of each panel, (p,)."""
        panels = self._panels
        slip = np.zeros(len(panels.left))
        slip[0] = self._far_slip_rate * panels.left[0].v[0]
        for i in range(len(slip) - 1):
            right = panels.right[i]
            assert right is not None
            slip[i + 1] = self._slip(i, right, slip[i])[0] if panels.sense[i] else slip[i]
        return slip

    def slip_over_time(self, u: Array) -> Array:
        """Return the derivative of slip / t."""
        start = self._slip_starts

        def inside(i: int, at: CutPoints) -> Array:
            slip = self._slip(i, at, start[i]) if self._panels.sense[i] else start[i]
            return np.asarray(slip / at.v)

        return self.profile.piecewise(u, self._far_slip_rate, inside)

    def _stuck(self, u: Array, mode: Mode, of_load: bool = True) -> Array:
        """Return the change of p* or q* with the half-plane and, `of_load`, the load's front."""
        stencil, own = self.variation.stencil, self.profile.fields.factors
        rates = self.variation.rates
        slowness, by_slowness = self.profile.fields.load.slowness, rates.slowness
        if not of_load:
            slowness = by_slowness = 0.0
        if not (rates.poisson_ratio or by_slowness) or stencil is None:
            return np.zeros(u.shape)
        # Between the fronts, a moves with the ratio while b = 1 stays: points at a fixed share of
        # (a, b) are differenced there.
        between = (u > own.a) & (u < 1)  # of the fronts, that move: at a fixed share
        share = np.where(between, (u - own.a) / (1 - own.a), 0.0)
        values, places = [], []
        for point in stencil.points:
            ratio = float(own.poisson_ratio + rates.poisson_ratio * point)
            traction = stuck_traction(ratio, mode, float(slowness + by_slowness * point))
            a = traction.factors.a
            places.append(np.where(between, a + share * (1 - a), u))
            values.append(traction(places[-1]))
        value, moved = (stencil.difference(np.stack(every), 0) for every in (values, places))
        inside = np.where(between, u, (1 + own.a) / 2)
        slope = stuck_traction(own.poisson_ratio, mode, slowness).derivative(inside)
        return np.where(u <= own.a, 0.0, value - np.where(between, slope * moved, 0.0))

    @cached_property
    def normal(self) -> VariedProfile | None:
        """Derivatives of the normal problem, or None if it stays or the contact is closed.

        Minus the pressure stands for the traction, and the opening of one side for slip.
        """
        profile, variation = self.profile.normal, self.variation.of_normal
        return VariedProfile(profile, variation) if profile and variation else None

    def pressure(self, u: Array) -> Array:
        """Return the derivative of contact pressure."""
        load, rates = self.profile.fields.load, self.variation.rates
        if load.opened is not None:
            return np.zeros(u.shape) if self.normal is None else -self.normal.traction(u)
        result = np.full(u.shape, rates.base_pressure)
        if rates.load_pressure:
            mode_one = load.stuck(self.profile.fields.factors, "I")
            result += rates.load_pressure * mode_one(u)
        if load.load_pressure:
            result += load.load_pressure * self._stuck(u, "I")
        return result

    def strength(self, u: Array) -> Array:
        """Return the derivative of the strength f p."""
        load, rates = self.profile.fields.load, self.variation.rates
        # d(f p) = f dp + p df.
        change = load.friction * self.pressure(u)
        if rates.friction:
            pressure = load.base_pressure + self.profile.pressure_change(u)
            change = change + rates.friction * pressure
        return np.asarray(change)

    def traction(self, u: Array) -> Array:
        """Return the derivative of the shear traction, infinite at edges that open below c_R."""
        rates, profile, nodes = self.variation.rates, self.profile, self._nodes
        integral = profile.traction_integral

        def inside(i: int, at: CutPoints) -> Array:
            sense = self._panels.sense[i]
            if sense:
                return np.asarray(sense * self.strength(at.v) + self._resisted(i, at))
            value = nodes.traction_starts[i] + self._traction(i, at)
            value = value - _carried(self._slope(integral, i, at), self._velocity(i, at))
            return np.asarray(value + self._edge_traction(i, at.v))

        return self.profile.piecewise(u, rates.base_shear - rates.far_slip_rate, inside)

    def _resisted(self, i: int, at: CutPoints) -> Array | float:
        """Return the derivative of eta V inside a panel that slips."""
        resistance = self.profile.fields.load.resistance
        by_resistance = self.variation.rates.resistance
        if resistance is None or self._panels.layout.open[i]:
            return 0.0
        rate = self.profile.slip_rate_inside(i, at)
        return np.asarray(resistance * self._slip_rate_inside(i, at) + by_resistance * rate)

    def _edge_traction(self, panel: int, v: Array) -> Array | float:
        """Return the derivative of the traction unbounded at a stuck edge, at fixed slowness."""
        profile, nodes = self.profile, self._nodes
        if self._panels.right[panel] is not None:
            return 0.0
        left = self._panels.left[panel].v
        name = profile.fields.factors.mode
        mode = stuck_traction(profile.fields.factors.poisson_ratio, name)
        moved = nodes.ends[0, panel]
        started = self._stuck(left, name, False)
        if moved.any():  # near an edge, not at the shear front
            started = started + mode.derivative(left) * moved
        gained = self._stuck(v, name, False) - started
        return np.asarray(
            nodes.intensity * (mode(v) - mode(left)) + profile.edge_intensity * gained
        )


def _carried(slope: Array, velocity: Array) -> Array:
    """Return the contribution of moving nodes, slope times velocity; 0 where they rest."""
    with np.errstate(invalid="ignore"):
        return np.where(velocity == 0, 0.0, slope * velocity)


def _growth(pair: Array) -> float:
    """Return the growth of the log of a slope per y, from a point and one y inward."""
    if not np.all(pair[0] * pair[1] > 0):
        return 0.0
    growth = float(np.log(pair[0] / pair[1]))
    # Where the power is a multiple of 1/2, as near most edges, rounding makes it exact.
    halves = round(2 * growth) / 2
    # Powers at ends are multiples of one half.
    return halves if abs(growth - halves) < 1e-2 else growth
