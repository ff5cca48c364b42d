"""Evaluate all fields on the interface as functions of slowness, from the densities on zones.

Rates V and U are sinc series between the nodes of the densities, and so is the normal traction
where the interface slips; elsewhere the slopes of tractions are evaluated as they are.  Everything
is then kept as piecewise Chebyshev series, which are quick to evaluate and local.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from semianalytic.dissimilar.stretch import (
    Bend,
    Intervals,
    Series,
    Stretch,
    from_values,
    integrated,
    interval_weights,
    padded,
)
from semianalytic.dissimilar_slot.densities.density import Density, OnPanel
from semianalytic.dissimilar_slot.densities.poles import Pole
from semianalytic.halfplane.rules import sinc_step
from semianalytic.scene.arrays import Array

RATE, OPENING, SLIP, GAP, SHEAR, NORMAL = range(6)
"""Functions of a profile: V, U, their integrals over slowness, tau and sigma beyond the base."""

_LENGTH = 60.0
"""Length in x, times digits, of an interval on which slopes of tractions are evaluated directly."""
_LAST = 1e20
"""Slowness [1 / c_t] from which on rates are constant; the parts end soon behind it."""
_STEPS = 3
"""Steps between the nodes of a density per interval of its series."""


@dataclass(frozen=True, eq=False)
class ProfilePart:
    """Series of the six functions on one stretch, of a zone or -1 where the interface sticks.

    `poles` and their amplitudes (2,) add to the first four functions.
    """

    series: Series
    zone: int
    poles: tuple[tuple[Pole, Array], ...] = ()

    @property
    def stretch(self) -> Stretch:
        """Stretch of the intervals of the series."""
        return self.series.intervals.stretch

    def at(self, x: Array, v: Array) -> Array:
        """Return the functions at coordinates x (n,) of slownesses v, (6, n)."""
        return self._with_poles(self.series.at(x), v)

    @property
    def values(self) -> Array:
        """The functions at the points of its intervals, (6, n)."""
        return self._with_poles(self.series.values.copy(), self.series.intervals.points.v)

    def _with_poles(self, values: Array, v: Array) -> Array:
        for pole, size in self.poles:
            values[[RATE, OPENING]] += (pole.change(v) @ size).T
            values[[SLIP, GAP]] += (pole.area(v) @ size).T
        return values

    @property
    def end(self) -> Array:
        """The functions at its right end, (6,)."""
        stop = np.array([np.inf if self.stretch.right is None else self.stretch.right])
        if not self.poles:
            return self.series.ends[1].copy()
        return self.at(np.array([np.inf]), stop)[:, 0]


@dataclass(frozen=True, eq=False)
class PairProfile:
    """Fields on the interface over slowness, in the units of the `Scene`."""

    density: Density

    @cached_property
    def parts(self) -> tuple[ProfilePart, ...]:
        """Stretches from the first wave to the contact edge."""
        density, result = self.density, []
        state = np.zeros(6)
        starts = {p.panel.stretch.left: p for p in density.parts}
        slowness = density.interface.compliance.first
        while True:
            on = starts.get(slowness)
            if on is None or not on.panel.open:  # closed: what is left of a gap is rounding
                state[[OPENING, GAP]] = 0.0
            if on is None:
                state[RATE] = 0.0
            part = self._stuck(slowness, state) if on is None else self._moving(on, state)
            result.append(part)
            state, stop = part.end, part.stretch.right
            if stop is None:
                return tuple(result)
            slowness = stop

    def _stuck(self, left: float, state: Array) -> ProfilePart:
        """Return the part that sticks from one slowness to the next front or edge."""
        density = self.density
        compliance = density.interface.compliance
        turns = density.interface.slip_phase(1).denominator.sharp_turns
        # Hidden zeros of the bonded interface lie next to the cut, and tractions change fast there.
        ends = [v for v in (*compliance.distinct_fronts, *turns, *density.exponents) if v > left]
        stretch = Stretch(left, min(ends, default=None))
        digits, exponents = density.digits, density.exponents

        def reach(end: float) -> float:
            # At a front of both bodies slopes are like d^(-1/2); the integrand falls to e^-digits.
            return digits / (1 + min(-0.5, exponents.get(end, 0.0)))

        before, after = stretch.lead + reach(left), 46.0  # x/t down to 1e-20 of the wave speeds
        if stretch.right is not None:
            after = reach(stretch.right)
        # As in `Density._traction_change` intervals may grow as the integrand falls.
        bend, length = Bend(0.2 * max(before, after) + stretch.lead), _LENGTH / digits
        first, last = bend.s([-before, after])
        count = int(np.ceil((last - first) / length))
        intervals = Intervals(stretch, first, length, count, bend)
        points = intervals.points
        tractions = density.tractions(stretch, points).imag
        # dT/dx = Im T(-v + i0) / (pi v) dv/dx: T is analytic above the cut.
        slope = np.asarray(stretch.slope(points)) * bend.slope(points.x)
        slopes = tractions * (slope / (np.pi * points.v))[:, None]
        slopes = slopes.reshape(count, -1, 2)
        constant = [np.full((count, 1), value) for value in state[:SHEAR]]
        moving = [integrated(slopes[..., k], length, state[SHEAR + k]) for k in range(2)]
        return ProfilePart(Series(intervals, padded([*constant, *moving])), -1)

    def _moving(self, on: OnPanel, state: Array) -> ProfilePart:
        """Return the part on a panel of a zone."""
        panel = on.panel
        density, interface = self.density, self.density.interface
        length = _STEPS * panel.spacing
        count = int(np.ceil((panel.count - 1) / _STEPS)) + 2
        start = panel.spacing * (panel.first - _STEPS)
        intervals = Intervals(panel.stretch, start, length, count)
        slopes = density.slopes[density.parts.index(on)]
        running = _running(panel.count, count)
        rates = [state[k] + (running @ slopes[:, k]).reshape(count, -1) for k in range(2)]
        jacobian = np.asarray(panel.stretch.slope(intervals.points)).reshape(count, -1)
        integrals = [
            integrated(rate * jacobian, length, state[SLIP + k]) for k, rate in enumerate(rates)
        ]
        normal = np.full((count, 1), state[NORMAL])
        shear = np.full((count, 1), state[SHEAR])
        if not panel.open:
            normal = self._normal(on, intervals, state[NORMAL])
            held = -panel.sense * interface.friction * normal
            # tau + s f sigma = s f P_b - Q_b + eta V where it slips; the first coefficient is the
            # constant.
            held[:, 0] += interface.level(panel.sense)
            film = interface.resistance * from_values(rates[0])
            shear = padded([held, film]).sum(axis=0)
        series = [from_values(rate) for rate in rates] + integrals + [shear, normal]
        amplitudes = density.amplitudes[density.parts.index(on)]
        poles = tuple(zip(on.poles, amplitudes, strict=True))
        return ProfilePart(Series(intervals, padded(series)), panel.zone, poles)

    def _normal(self, on: OnPanel, intervals: Intervals, start: float) -> Array:
        """Return the coefficients of sigma on a panel that slips, over a power near the edge."""
        panel, density = on.panel, self.density
        slope = density.normal_slope(on)
        if panel.stretch.right is not None:
            running = _running(panel.count, intervals.count, between=True)
            return from_values(start + (running @ slope).reshape(intervals.count, -1))
        # A power a little above that of the slope: what is interpolated then decays towards the end
        # of the panel.
        power = density.interface.edge_decay(panel.sense) + panel.right.decay
        left = panel.stretch.left
        scaled = slope * (left / panel.points.v[panel.count :]) ** power
        values = _interpolating(panel.count, intervals.count) @ scaled
        values *= (intervals.points.v / left) ** power / panel.spacing
        return integrated(values.reshape(intervals.count, -1), intervals.length, start)

    @cached_property
    def largest_rate(self) -> float:
        """Largest |V|; 1 where nothing slips."""
        return self._largest(RATE)

    @cached_property
    def largest_gap(self) -> float:
        """Largest gap over time; 1 where nothing opens."""
        return self._largest(GAP)

    @property
    def _moving_parts(self) -> list[ProfilePart]:
        """Parts on zones."""
        return [part for part in self.parts if part.zone >= 0]

    def _largest(self, function: int) -> float:
        """Return the largest |V|, or the largest gap over time, at the points of all intervals."""
        largest = 0.0
        for part in self._moving_parts:
            over = part.series.intervals.points.v if function == GAP else 1.0
            largest = max(largest, float((np.abs(part.values[function]) / over).max()))
        return largest or 1.0

    @cached_property
    def most_slip(self) -> float:
        """Largest |slip| over time."""
        largest = 0.0
        for part in self._moving_parts:
            points = part.series.intervals.points
            x, best = points.x, int(np.argmax(np.abs(part.values[SLIP] / points.v)))
            # The largest slip is then known to 1e-4 of their distance squared.
            near = np.linspace(x[max(best - 1, 0)], x[min(best + 1, len(x) - 1)], 101)
            v = part.stretch.at(near).v
            largest = max(largest, float(np.abs(part.at(near, v)[SLIP] / v).max()))
        return largest

    @cached_property
    def slipped(self) -> float:
        """Integral of |V| over x/t."""
        return sum(float(w @ np.abs(f[RATE])) for f, w in self._moving_points)

    @cached_property
    def dissipated(self) -> float:
        """Integral of traction times V over x/t."""
        interface = self.density.interface
        return sum(
            float(w @ ((interface.base_shear + f[SHEAR]) * f[RATE]))
            for (f, w), part in zip(self._moving_points, self._moving_parts, strict=True)
            if not self.density.zones[part.zone].open
        )

    @cached_property
    def _moving_points(self) -> list[tuple[Array, Array]]:
        """Functions at points, and weights of integrals over x/t, for every moving part."""
        result = []
        for part in self._moving_parts:
            intervals = part.series.intervals
            points = intervals.points
            # d(x/t) = dv / v^2 turns integrals over slowness into integrals over velocity.
            slope = np.asarray(part.stretch.slope(points)) / np.square(points.v)
            weights = np.tile(interval_weights(), intervals.count) * intervals.length / 2
            result.append((part.values, weights * slope))
        return result

    def at(self, u: Array) -> Array:
        """Return the six functions at slownesses u >= 0, (6, n); they are 0 ahead of all waves."""
        u, beyond = np.minimum(u, _LAST), np.maximum(u / _LAST, 1.0)
        result = np.zeros((6, len(u)))
        parts = self.parts
        ends = np.array([part.stretch.left for part in parts])
        index = np.searchsorted(ends, u, side="right") - 1
        for k, part in enumerate(parts):
            here = index == k
            if here.any():
                result[:, here] = part.at(part.stretch.coordinates(u[here]), u[here])
        result[[SLIP, GAP]] *= beyond  # integrals of rates that do not change any more
        return result


@lru_cache(maxsize=64)
def _offsets(between: bool) -> Array:
    """Return the Chebyshev points (POINTS,) of an interval from its node or half step, in steps."""
    unit = Intervals(Stretch(1.0, None), 0.0, float(_STEPS), 1).x.ravel()
    return unit - (0.5 if between else 0.0)


@lru_cache(maxsize=64)
def _running(nodes: int, intervals: int, between: bool = False) -> Array:
    """Return integrals of sinc functions, over the spacing, up to all points of intervals."""
    return sinc_step(_apart(nodes - between, intervals, between))


@lru_cache(maxsize=64)
def _interpolating(nodes: int, intervals: int) -> Array:
    """Return sinc functions of half steps at points of intervals, (intervals POINTS, n - 1)."""
    return np.sinc(_apart(nodes - 1, intervals, True))


def _apart(count: int, intervals: int, between: bool) -> Array:
    """Return points of intervals, from _STEPS before the first node, less nodes or half steps."""
    places = _STEPS * (np.arange(intervals) - 1)[:, None] + _offsets(between)
    return np.asarray(places.reshape(-1, 1) - np.arange(count))
