"""Continuous phase of a function on the cut k = -v + i0, which is 0 ahead of all waves.

The phases of the two symbols of frictional contact, K = (A + s f k D) / (A B + k^2 D^2) and
N = 1 / (A + s f k D), give every exponent at a zone edge, and their limits for v -> infinity give
how many solutions there are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from semianalytic.dissimilar.compliance import Complex, Compliance, Entries
from semianalytic.dissimilar.stretch import Stretch, stretches
from semianalytic.scene.arrays import Array

_LARGEST_TURN = 0.5
"""Largest turn between points [rad]: half of it gives the same phases of 200 random pairs."""


@lru_cache(maxsize=64)
def _on_cut(compliance: Compliance, v: float) -> Entries:
    """Return the matrix at one slowness, whose entries all phases there share."""
    return compliance.on_cut(np.array([v]))


@dataclass(frozen=True)
class StretchPhase:
    """The phase at increasing x (n,) of one stretch, and slownesses where the function vanishes."""

    stretch: Stretch
    x: Array
    phase: Array
    zeros: tuple[float, ...]


@dataclass(frozen=True)
class CutPhase:
    """Phase of a function of the compliance, from its entries at n slownesses, regular on the cut.

    At a zero on the cut the phase grows by pi: any damping moves a wave that neither grows nor
    decays below the axis, past which the phase grows.
    """

    compliance: Compliance
    function: Callable[[Entries], Complex]

    @cached_property
    def table(self) -> tuple[StretchPhase, ...]:
        """Phase on every stretch between wave fronts, on points as fine as it turns."""
        # Ahead of all waves the function is real and positive: the phase is counted from there.
        start, before, result = 0.0, 1 + 0j, []
        for stretch in stretches([0.0, *self.compliance.distinct_fronts]):
            x, values = self._resolved(stretch)
            turns = np.angle(values / np.concatenate([[before], values[:-1]]))
            # At a zero on the cut the phase grows by pi: a turn of the other sign is 2 pi short.
            vanishes = np.abs(turns) > _LARGEST_TURN
            turns[vanishes & (turns < 0)] += 2 * np.pi
            phase = start + np.cumsum(turns)
            zeros = stretch.at(x[vanishes]).v
            result.append(StretchPhase(stretch, x, phase, tuple(zeros.tolist())))
            start, before = float(phase[-1]), values[-1]
        return tuple(result)

    @property
    def zeros(self) -> tuple[float, ...]:
        """Slownesses at which the function vanishes on the axis."""
        return tuple(zero for part in self.table for zero in part.zeros)

    @property
    def limit(self) -> float:
        """Phase for v -> infinity."""
        return float(self.table[-1].phase[-1])

    def at(self, v: float) -> float:
        """Return the phase at a slowness v > 0."""
        for part in self.table:
            right = part.stretch.right
            if part.stretch.left < v and (right is None or v < right):
                near = float(np.interp(part.stretch.coordinate(v), part.x, part.phase))
                angle = float(np.angle(self.function(_on_cut(self.compliance, v))[0]))
                return angle + 2 * np.pi * round((near - angle) / (2 * np.pi))
        # A slowness that is a front lies in no open stretch: the phase just behind it is meant.
        return next(float(part.phase[0]) for part in self.table if part.stretch.left == v)

    def on(self, stretch: Stretch, x: Array) -> Array:
        """Return the phase at coordinates x (n,) of a stretch between two wave fronts."""
        # The table gives the multiple of 2 pi that the angle of the function leaves open.
        part = next(row for row in self.table if row.stretch == stretch)
        near, angle = np.interp(x, part.x, part.phase), np.angle(self._on(stretch, x))
        return np.asarray(angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)))

    @cached_property
    def sharp_turns(self) -> tuple[float, ...]:
        """Slownesses at which the phase turns fastest, by more than 0.6 per unit of x.

        They are the real parts of zeros on other sheets that lie next to the cut.
        """
        found = []
        for part in self.table:
            rate = np.abs(np.diff(part.phase) / np.diff(part.x))
            # A zero 1.7 away in x turns it as fast.  Uncut, densities converge at half the rate;
            # at 0.8 some took four rules to 1e-8, at 0.45 there are a fifth more cuts.
            peak = (rate[1:-1] > rate[:-2]) & (rate[1:-1] >= rate[2:])
            for top in np.flatnonzero((rate[1:-1] > 0.6) & peak) + 1:
                # Neighbouring points are about as far apart as the zero is from the cut.
                fine = np.linspace(part.x[top - 1], part.x[top + 2], 121)
                values = self._on(part.stretch, fine)
                fastest = int(np.argmax(np.abs(np.angle(values[1:] / values[:-1]))))
                place = (fine[fastest] + fine[fastest + 1]) / 2
                found.append(float(part.stretch.at(np.array([place])).v[0]))
        return tuple(found)

    def _resolved(self, stretch: Stretch) -> tuple[Array, Complex]:
        """Return points on a stretch between which the function turns little, and its direction."""
        # exp(-38) of the slowness of a front is below its rounding.
        x = np.arange(-38.0, 38.25, 0.5)
        values = self._on(stretch, x)
        while True:
            turns, widths = np.abs(np.angle(values[1:] / values[:-1])), np.diff(x)
            # A turn of nearly half a circle between nearer points is a zero on the cut.
            wide = np.flatnonzero((turns > _LARGEST_TURN) & (widths > 1e-12))
            if not len(wide):
                return x, values
            between = (x[wide] + x[wide + 1]) / 2
            # Only where it turns fast: elsewhere the first points are close enough for any pair.
            x = np.insert(x, wide + 1, between)
            values = np.insert(values, wide + 1, self._on(stretch, between))

    def _on(self, stretch: Stretch, x: Array) -> Complex:
        """Return the direction of the function at points, or near a point where it vanishes."""
        points = stretch.at(x)
        from_fronts = stretch.minus(points, self.compliance.fronts)
        values = self.function(self.compliance.on_cut(points.v, from_fronts))
        size = np.abs(values)
        if not size.all():
            return self._on(stretch, np.where(size, x, x + 1e-10))
        return np.asarray(values / size)


@dataclass(frozen=True)
class SlipPhase:
    """Phase of K + eta, K = (A + s f k D) / (A B + k^2 D^2), where tau + s f sigma = -K W.

    `numerator` and `denominator` are times R_1 R_2, the first with eta (A B + k^2 D^2) added.
    """

    numerator: CutPhase
    denominator: CutPhase

    @property
    def limit(self) -> float:
        """Phase for v -> infinity."""
        return self.numerator.limit - self.denominator.limit

    def at(self, v: float) -> float:
        """Return the phase at a slowness v > 0."""
        return self.numerator.at(v) - self.denominator.at(v)

    def on(self, stretch: Stretch, x: Array) -> Array:
        """Return the phase at coordinates x (n,) of a stretch between two wave fronts."""
        return self.numerator.on(stretch, x) - self.denominator.on(stretch, x)

    def is_regular(self, friction: float) -> bool:
        """Tell whether no wave that runs ahead of slip grows.

        Then theta_K / pi tends to 1/2 + arctan(s f beta) / pi, and to 2 less for each such wave.
        """
        compliance = self.numerator.compliance
        expected = np.pi / 2 + np.arctan(friction * compliance.dundurs)
        return bool(abs(self.limit - expected) < 0.6)  # the next possible value is 2 pi away


def slip_phase(compliance: Compliance, friction: float, resistance: float = 0.0) -> SlipPhase:
    """Return the phase of K + eta, for `friction` s f and a film of traction eta per slip rate."""

    def numerator(entries: Entries) -> Complex:
        value = entries.frictional(friction)
        return np.asarray(value + resistance * entries.determinant)

    return SlipPhase(CutPhase(compliance, numerator), bonded_phase(compliance))


def bonded_phase(compliance: Compliance) -> CutPhase:
    """Return the phase of (A B + k^2 D^2) R_1 R_2, which is 0 for waves of a bonded interface."""
    return CutPhase(compliance, lambda entries: entries.determinant)


def rayleigh_phases(compliance: Compliance) -> tuple[CutPhase, CutPhase]:
    """Return the phases of R_1 and R_2, which vanish for the Rayleigh waves of the free bodies."""
    upper = CutPhase(compliance, lambda entries: entries.bodies[0].rayleigh)
    return upper, CutPhase(compliance, lambda entries: entries.bodies[1].rayleigh)


def contact_phase(compliance: Compliance, friction: float) -> CutPhase:
    """Return the phase of Phi R_1 R_2, Phi = A + s f k D, for waves of a sliding interface."""
    return CutPhase(compliance, lambda entries: entries.frictional(friction))
