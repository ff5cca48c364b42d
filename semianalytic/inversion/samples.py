"""The samples of all gauges in a row: their values in a solution, and the derivatives of these.

On the interface derivatives with respect to parameters of the scene are exact
(`Solution.derivative`).  Those with respect to modulus and density follow from similarity, since
these act through c_t and the impedance Z alone: with q the quantity, n = -1 for rates, motion and
strain and 0 for tractions, and m = -1 for slip, displacement and strain, else 0,

    dq/dln Z = n q ,   dq/dln c_t = m q + t dq/dt .

In the bodies there are no exact derivatives with respect to parameters of the scene: solutions are
differenced centrally, with a step that balances their own error with its square.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from semianalytic.inversion.gauges import INTERFACE, QUANTITIES, Gauge, component, seen
from semianalytic.inversion.unknowns import Setup
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.derivatives.derivative import Derivative
from semianalytic.selfsimilar.solution import Solution

CLOSE = 0.01
"""Step of differences over time and place, over half the time between samples."""


@dataclass(frozen=True, eq=False)
class _Look:
    """Samples of one kind: indices, first at each place and time, and which and axis of each."""

    part: np.ndarray
    first: np.ndarray
    which: np.ndarray
    axis: np.ndarray


@dataclass(frozen=True, eq=False)
class Samples:
    """All samples of gauges, n in number."""

    gauges: tuple[Gauge, ...]

    @cached_property
    def values(self) -> Array:
        """The recorded values, (n,)."""
        return np.concatenate([gauge.values for gauge in self.gauges])

    @cached_property
    def noise(self) -> Array:
        """The standard deviations, (n,)."""
        return self._spread([gauge.noise for gauge in self.gauges])

    @cached_property
    def t(self) -> Array:
        """The times of the records, (n,)."""
        return np.concatenate([gauge.t for gauge in self.gauges])

    @property
    def duration(self) -> float:
        """The time that records span; of a single sample its own time, and 1 the last resort."""
        return float(np.ptp(self.t)) or float(np.abs(self.t).max()) or 1.0

    @cached_property
    def half(self) -> Array:
        """Half the times between samples, (n,)."""
        return np.concatenate([gauge.half_interval for gauge in self.gauges])

    @cached_property
    def places(self) -> tuple[Array, Array]:
        """The positions x and y, (n,) each; y is 0 on the interface."""
        y = self._spread([gauge.y or 0.0 for gauge in self.gauges])
        return self._spread([gauge.x for gauge in self.gauges]), y

    @cached_property
    def groups(self) -> dict[str, np.ndarray]:
        """The samples of each quantity."""
        names = np.repeat([gauge.quantity for gauge in self.gauges], self._counts)
        return {str(name): np.flatnonzero(names == name) for name in np.unique(names)}

    @cached_property
    def on_interface(self) -> np.ndarray:
        """Whether each sample is of the interface, (n,)."""
        return np.repeat([gauge.on_interface for gauge in self.gauges], self._counts)

    @property
    def _counts(self) -> list[int]:
        return [len(gauge.t) for gauge in self.gauges]

    def _spread(self, numbers: list[float | Array]) -> Array:
        parts = zip(numbers, self._counts, strict=True)
        return np.concatenate([np.broadcast_to(number, count) for number, count in parts])

    def split(self, row: Array) -> tuple[Array, ...]:
        """Split a row (n,) by gauge."""
        return tuple(np.split(row, np.cumsum(self._counts)[:-1]))

    def gain(self, setup: Setup) -> Array:
        """Return the factors (n,) by which records are too large."""
        return self._spread([setup.gain_of(gauge) for gauge in self.gauges])

    def of_gauge(self, name: str) -> Array:
        """Return 1 for samples of gauges of a name, else 0, (n,)."""
        return self._spread([float(gauge.name == name) for gauge in self.gauges])

    def clear(self, solution: Solution, setup: Setup) -> Array:
        """Return the times since the load at which derivatives are formed, (n,).

        At an edge derivatives are infinite, but a sample represents an interval that ends half-way
        to its neighbours.  Nearer to an edge than half the time between samples, derivatives are
        therefore taken at that distance.
        """
        t, x = self.t - setup.t0, self.places[0] - setup.x0
        clear, half = t.copy(), self.half
        speeds = solution.edge_speeds
        # The contact edge does not move, and slip ahead of all waves has no edge that passes.
        for speed in speeds[(speeds > 0) & np.isfinite(speeds)]:
            since = t - x / speed
            near = self.on_interface & (np.abs(since) < half)
            # On the side of the edge on which the sample lies.
            clear[near] = (x / speed + np.where(since < 0, -half, half))[near]
        return clear

    def of(self, solution: Solution, setup: Setup, t: Array | None = None) -> Array:
        """Return what gauges would have recorded without their gain, (n,).

        Other times (n,) since the load may be given.
        """
        return self._finite(solution, setup.x0, self.t - setup.t0 if t is None else t)

    def of_each(self, solution: Solution, setups: Sequence[Setup]) -> Array:
        """Return what `of` returns in each of several set-ups, (s, n)."""
        x0, t0 = np.array([(setup.x0, setup.t0) for setup in setups]).T[..., None]
        return self._finite(solution, x0, self.t - t0)

    def _finite(self, solution: Solution, x0: float | Array, t: Array) -> Array:
        result = self._recorded(solution, x0, t)
        lost = ~np.isfinite(result)
        if lost.any():  # on a front: as it is a moment later
            result[lost] = self._recorded(solution, x0, t + CLOSE * self.half)[lost]
        # A value also infinite a moment later, at a stuck contact edge, becomes a huge misfit,
        # which least squares can still compare.
        return np.nan_to_num(result)

    def _recorded(self, solution: Solution, x0: float | Array, t: Array) -> Array:
        x, y = self.places[0] - x0, self.places[1]
        result = np.empty(t.shape)
        for kind, look in self._looks.items():
            rows = seen(solution, kind, x[..., look.first], y[look.first], t[..., look.first])
            result[..., look.part] = np.moveaxis(rows[look.axis, ..., look.which], 0, -1)
        return result

    @cached_property
    def _looks(self) -> dict[str, _Look]:
        """The samples of each recorded kind; components at one place and time come together."""
        kinds = [component(gauge.quantity) for gauge in self.gauges]
        of_kind = np.repeat([kind for kind, _ in kinds], self._counts)
        axes = np.repeat([axis for _, axis in kinds], self._counts)
        # Components recorded at one place and time are computed once. The interval belongs to the
        # key, since it decides how a sample on a front is moved.
        at = np.stack([*self.places, self.t, self.half], axis=1)
        looks = {}
        for kind in np.unique(of_kind):
            part = np.flatnonzero(of_kind == kind)
            _, first, which = np.unique(at[part], axis=0, return_index=True, return_inverse=True)
            looks[str(kind)] = _Look(part, part[first], np.ravel(which), axes[part])
        return looks

    def exact(self, derivative: Derivative, setup: Setup, t: Array) -> Array:
        """Return derivatives (n,) with respect to a parameter of the scene; 0 off the interface."""
        x, result = self.places[0] - setup.x0, np.zeros(len(t))
        for name, part in self.groups.items():
            if name in INTERFACE:
                result[part] = getattr(derivative, name)(x[part], t[part])
        return np.asarray(result)

    def over_time(self, solution: Solution, setup: Setup, t: Array) -> Array:
        """Return derivatives (n,) with respect to time at times since the load."""
        step = CLOSE * self.half
        later, earlier = self._finite(solution, setup.x0, np.stack([t + step, t - step]))
        return np.asarray((later - earlier) / (2 * step))

    def along_x(self, solution: Solution, setup: Setup, t: Array) -> Array:
        """Return derivatives (n,) with respect to position."""
        # One step for all samples: the way of a shear wave in the shortest interval, below which no
        # record resolves anything.
        step = CLOSE * float(self.half.min()) * solution.scene.material.shear_speed
        right, left = (
            self.of(solution, replace(setup, x0=setup.x0 - sign * step), t) for sign in (1, -1)
        )
        return np.asarray((right - left) / (2 * step))

    def over_moduli(self, solution: Solution, setup: Setup, t: Array) -> tuple[Array, Array]:
        """Return derivatives with respect to ln Z and ln c_t, (n,) each."""
        seen = self.of(solution, setup, t)
        # The formulae at the head of this file.
        by_speed = t * self.over_time(solution, setup, t)
        by_impedance = np.zeros(len(t))
        for name, part in self.groups.items():
            if QUANTITIES[name] in {"length / time", "length", "1"}:
                by_impedance[part] = -seen[part]
            if QUANTITIES[name] in {"length", "1"}:
                by_speed[part] -= seen[part]
        return by_impedance, by_speed
