"""Derivatives of a solved pair with respect to a parameter of its bodies, friction or tractions.

The edges satisfy their conditions for every nearby value of a parameter p.  Fields are not smooth
in p at fixed slowness, past which an edge or a wave front moves, but they are at fixed places x
between the edges and fronts.  They are differenced there, to fourth order, between neighbours whose
edges Newton's method places, and the motion of the places is taken off again:

    dF/dp = dF/dp at x - ds/dp at x (dF/dx) / (ds/dx),

s being the slowness (docs/derivatives.md, "Two different bodies").
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.dissimilar.canonical import glued
from semianalytic.dissimilar.pair import PARAMETERS, TRACTIONS, Pair, changed, parameter_of
from semianalytic.dissimilar.stretch import Stretch
from semianalytic.dissimilar_slot.admissible import violations
from semianalytic.dissimilar_slot.densities.density import Density
from semianalytic.dissimilar_slot.densities.interface import interface_of
from semianalytic.dissimilar_slot.densities.panels import Rule, rule_for
from semianalytic.dissimilar_slot.densities.profile import (
    GAP,
    NORMAL,
    OPENING,
    RATE,
    SHEAR,
    SLIP,
    Profile,
)
from semianalytic.dissimilar_slot.densities.zones import Coordinates, edges_of
from semianalytic.dissimilar_slot.placement import Placement, place, polished
from semianalytic.halfplane.rayleigh import Array
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.selfsimilar.derivatives.derivative import OpenDerivative, ZoneDerivative
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone, is_open, over_slowness

_POINTS, _WEIGHTS = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / 12
"""A central difference of fourth order."""
_STEP = 2e-3
"""Step over the size of a parameter: half and twice of it change derivatives of the scenes of
docs/dissimilar.md by less than their error estimates."""
_LONGEST_MOVE, _MOST_SHORTENINGS = 0.02, 5
"""Largest change of an unknown of the edges in a step, in logarithms of distances: an edge beside a
front would cross it; and how often a step is shortened, by a tenth at most."""
_ALONG = 5e-3
"""Step in x of the differences along the interface."""
_TOLERANCE, _COARSER, _SHORTER = 1e-11, 10.0, 0.7
"""Tolerance of the rule of neighbours; that of the companion from which errors are estimated, over
it, and its step over that of the derivative."""
_LOOSE = 1e-5
"""Tolerance of the rule on which the Jacobian of the edges is formed."""
_SAFETY, _LEAST = 4.0, 1e-9
"""Error estimate over the difference from the companion, and the least one."""
_LAW = 1e-6
"""Violation of the law of contact beyond which zones of a neighbour count as others."""
_FARTHEST = 200.0
"""Largest |x| at which fields are looked up."""
_COMPARED, _BESIDE = 200, 0.03
"""Points at which derivative and companion are compared, and their distance from edges and fronts
over the slowest wave speed."""


@dataclass(frozen=True, eq=False)
class Member:
    """A pair near another one, with its own edges, in the units of that pair's parameter.

    Attributes
    ----------
    pair : Pair
    profile : Profile
    stress : float
        Unit of stress of the profile.
    """

    pair: Pair
    profile: Profile
    stress: float

    @cached_property
    def marks(self) -> list[float]:
        """Edges, wave fronts and poles of the rates, in slowness over b of the upper body."""
        density = self.profile.density
        poles = {pole.slowness for part in density.parts for pole in part.poles}
        fronts = density.interface.compliance.distinct_fronts
        return sorted({*fronts, *edges_of(density.zones), *poles})

    def slowness(self, v: Array) -> Array:
        """Return the slownesses [time / length] of those in units of the upper body."""
        return v / self.pair.upper.shear_speed

    def fields(self, v: Array) -> Array:
        """Return slip rate, rate of opening, slip and gap over x, shear traction and pressure."""
        values = self.profile.at(v)
        rate = self.stress / self.pair.upper.shear_impedance
        values[[RATE, OPENING]] *= rate
        values[[SLIP, GAP]] *= rate / self.pair.upper.shear_speed
        values[SHEAR] = self.pair.base.shear + self.stress * values[SHEAR]
        values[NORMAL] = self.pair.base.pressure - self.stress * values[NORMAL]
        return values

    def stretches(self) -> list[Stretch]:
        """Return what lies between neighbouring marks, and behind the last one."""
        rights: list[float | None] = [*self.marks[1:], None]
        return [Stretch(*ends) for ends in zip(self.marks, rights, strict=True)]


@dataclass(frozen=True, eq=False)
class Varied:
    """A solved pair and its neighbours along a parameter.

    Attributes
    ----------
    own : Member
    beside : tuple of Member
        At `_POINTS` times `step` of the parameter.
    step : float
    """

    own: Member
    beside: tuple[Member, ...]
    step: float

    def _difference(self, values: list[Any]) -> Array:
        """Return the derivative from values of the neighbours."""
        return np.asarray(np.tensordot(_WEIGHTS, np.array(values), 1) / self.step)

    @cached_property
    def edges(self) -> Array:
        """Derivatives (e,) of the velocities of the edges, from the fastest to the slowest."""
        velocities = [
            1 / one.slowness(np.array(edges_of(one.profile.density.zones))) for one in self.beside
        ]
        return self._difference(velocities)

    @cached_property
    def _ahead(self) -> Array:
        """Derivatives of all fields ahead of all waves."""
        return self._difference([one.fields(np.zeros(1))[:, 0] for one in self.beside])

    @cached_property
    def at_edge(self) -> float:
        """Derivative of the slip rate at the contact edge."""
        # Slowness at the contact edge is infinite; the rate has reached its limit long before this.
        far = np.array([1e12])
        return float(self._difference([one.fields(far)[RATE, 0] for one in self.beside]))

    def fields(self, v: Array) -> Array:
        """Return the derivatives (6, n) of `Member.fields` at slownesses v of the pair itself."""
        result = np.repeat(self._ahead[:, None], len(v), axis=1)
        stretches = [one.stretches() for one in (self.own, *self.beside)]
        index = np.searchsorted(self.own.marks, v, side="right") - 1
        for k, (stretch, *others) in enumerate(zip(*stretches, strict=True)):
            here = index == k
            if not here.any():
                continue
            x = np.clip(stretch.coordinates(v[here]), -_FARTHEST, _FARTHEST)
            places = [other.at(x).v for other in others]
            at_place = self._difference(
                [one.fields(place) for one, place in zip(self.beside, places, strict=True)]
            )
            moved = self._difference(
                [one.slowness(place) for one, place in zip(self.beside, places, strict=True)]
            )
            along = [stretch.at(x + _ALONG * point).v for point in _POINTS]
            slope = np.tensordot(_WEIGHTS, [self.own.fields(one) for one in along], 1)
            run = np.tensordot(_WEIGHTS, [self.own.slowness(one) for one in along], 1)
            with np.errstate(divide="ignore", invalid="ignore"):
                # At a fixed place between the marks fields change smoothly; the place itself has
                # moved, which is taken back along the slope of the fields.
                share = np.where(run == 0, 0.0, moved / run)
            result[:, here] = at_place - share * slope
        return result


@dataclass(frozen=True, eq=False)
class PairDerivative:
    """Derivatives of a solved pair with respect to one parameter, all others held.

    Fields broadcast over positions x > 0 [length] and times t [time], in units of the field per
    unit of the parameter, and hold for the present set of zones, whose edges move.

    Attributes
    ----------
    pair : Pair
    name : str
        "friction", "viscosity", "base_pressure", "base_shear", "load_pressure", "load_shear",
        "shear_modulus", "density" or "poisson_ratio" of the upper body, or the last three of the
        lower one with "lower_" before them.
    zones : tuple of ZoneDerivative
        From the contact edge outward, like `PairSolution.zones`.
    openings : tuple of OpenDerivative
    status : str
        "converged"; a sentence where zones are about to change, so that the derivative holds to one
        side only, or what to distrust in the solution.
    varied : Varied
        The pair and its neighbours.
    opened : tuple of OpenZone
        Open parts of the solution, where tractions stay zero.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> pair = sa.Pair(gouge, rock, 0.4, sa.Tractions(10e6, 0.0), sa.Tractions(0.0, 4e6))
    >>> by_friction = sa.solve_pair(pair).derivative("friction")
    >>> [round(zone.outer) for zone in by_friction.zones]  # m/s per unit of friction
    [-2108]
    """

    pair: Pair
    name: str
    zones: tuple[ZoneDerivative, ...]
    openings: tuple[OpenDerivative, ...]
    status: str
    varied: Varied
    opened: tuple[OpenZone, ...]

    def __repr__(self) -> str:
        speeds = ", ".join(f"{one.inner:.4g} and {one.outer:.4g}" for one in self.zones)
        zones = f"edges move by {speeds}" if self.zones else "no slip"
        return f"<PairDerivative with respect to {self.name}: {zones}; {self.status}>"

    def _evaluate(self, x: ArrayLike, t: ArrayLike, row: int) -> Array:
        return over_slowness(
            self.pair.upper.shear_speed, x, t, lambda v: self.varied.fields(v)[row]
        )

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the relative slip rate [length / time per unit of the parameter].

        It grows without bound towards edges where the slip rate has a root.

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._evaluate(x, t, RATE)

    def gap_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the rate of opening [length / time per unit]; raises as `slip_rate`."""
        return self._evaluate(x, t, OPENING)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the relative slip [length per unit]; raises as `slip_rate`."""
        return np.asarray(x, dtype=float) * self._evaluate(x, t, SLIP)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the gap [length per unit], 0 where closed; raises as `slip_rate`."""
        gap = np.asarray(x, dtype=float) * self._evaluate(x, t, GAP)
        return np.where(is_open(self.opened, x, t), gap, 0.0)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the total shear traction [stress per unit]; raises as `slip_rate`."""
        return self._traction(x, t, SHEAR, "base_shear")

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the contact pressure [stress per unit]; raises as `slip_rate`."""
        return self._traction(x, t, NORMAL, "base_pressure")

    def _traction(self, x: ArrayLike, t: ArrayLike, row: int, base: str) -> Array:
        before = np.asarray(t, dtype=float) < 0
        # Before the load there is the base alone.
        values = np.where(before, float(self.name == base), self._evaluate(x, t, row))
        return np.where(is_open(self.opened, x, t), 0.0, values)

    @property
    def edge_slip_rate(self) -> float:
        """Derivative of the relative slip rate at the contact edge [length / time per unit]."""
        return self.varied.at_edge

    @cached_property
    def error_estimate(self) -> float:
        """Estimate of the error of edges and fields, relative to their largest derivative.

        It holds further than 0.03 of the slowest wave speed from edges and fronts, and takes a
        second, coarser derivative, which is computed on first access.
        """
        fine = self.varied
        coarse = neighbours(fine.own, self.name, _COARSER * _TOLERANCE, _SHORTER * fine.step)
        worst = _share(fine.edges, coarse.edges)
        pair, marks = self.pair, np.array(fine.own.marks)
        slowest = fine.own.profile.density.interface.compliance.last
        velocity = np.linspace(0.0, 1.1 / marks[0], _COMPARED + 2)[1:-1]
        apart = np.abs(velocity[:, None] - 1 / marks).min(axis=1) * slowest
        v = 1 / velocity[apart > _BESIDE]
        one, other = fine.fields(v), coarse.fields(v)
        opened = is_open(self.opened, pair.upper.shear_speed / v, 1.0)
        # Where it is open tractions are 0 whatever the parameter; what is left of them is rounding.
        one[SHEAR:, opened] = other[SHEAR:, opened] = 0.0
        worst = max([worst, *(_share(*rows) for rows in zip(one, other, strict=True))])
        return _LEAST + _SAFETY * worst


def _share(one: Array, other: Array) -> float:
    """Return the largest difference over the largest value."""
    largest = float(np.abs(one).max(initial=0.0))
    return float(np.abs(one - other).max(initial=0.0)) / largest if largest else 0.0


def differentiated(
    own: Member,
    name: str,
    known: tuple[tuple[SlipZone, ...], tuple[OpenZone, ...]],
    status: str,
) -> PairDerivative:
    """Return the derivative of a solved pair with respect to one of `PARAMETERS`.

    Parameters
    ----------
    own : Member
        The pair as it was solved.
    name : str
    known : (slip zones, openings)
        Those of the solution.
    status : str
        That of the solution.

    Raises
    ------
    SceneError
        If there is no such parameter, or the pair has no viscous film to differentiate.
    ComputationError
        If zones of this kind have no edges at a nearby value.
    """
    if name not in PARAMETERS:
        raise SceneError(f"derivative: name must be one of {', '.join(PARAMETERS)}, got {name!r}.")
    if name == "viscosity" and not parameter_of(own.pair, name) > 0:
        raise SceneError(
            "derivative: with respect to viscosity the pair needs ViscousFriction of a positive "
            "viscosity."
        )
    varied = neighbours(own, name, _TOLERANCE, _STEP * _size(own, name))
    if status == "converged":
        status = _border(varied, name) or status
    ends = edges_of(own.profile.density.zones)
    speed = own.pair.upper.shear_speed
    rates = dict(zip(ends, varied.edges.tolist(), strict=True))

    def moved(velocity: float) -> float:
        """Return the derivative of the velocity of an edge, 0 at the contact edge."""
        if velocity == 0:
            return 0.0
        return rates[min(ends, key=lambda end: abs(speed / end - velocity))]

    zones, openings = known
    return PairDerivative(
        own.pair,
        name,
        tuple(ZoneDerivative(moved(one.inner), moved(one.outer), one.sense) for one in zones),
        tuple(OpenDerivative(moved(one.inner), moved(one.outer)) for one in openings),
        status,
        varied,
        openings,
    )


def _size(own: Member, name: str) -> float:
    """Return the size of a parameter over which its step is taken."""
    value = abs(parameter_of(own.pair, name))
    if name in TRACTIONS:
        return max(value, own.stress)
    if name.endswith("poisson_ratio"):
        return 0.25
    return value


def neighbours(own: Member, name: str, tolerance: float, step: float) -> Varied:
    """Return a solved pair with its neighbours along a parameter, each with its own edges."""
    density, rule = own.profile.density, rule_for(tolerance)
    value = parameter_of(own.pair, name)
    start = place(density.interface, density.glued, density.zones, rule_for(_LOOSE), _LOOSE)
    # The loose rule gives the Jacobian alone: neighbours start from the edges themselves.
    start = replace(start, unknowns=start.coordinates.unknowns(edges_of(density.zones)))

    def at(point: float) -> tuple[Member, float]:
        pair = changed(own.pair, name, value + step * point)
        return _neighbour(pair, start, density, rule, tolerance)

    for attempt in range(_MOST_SHORTENINGS + 1):
        try:
            ahead, moved = at(1.0)
        except (ComputationError, SceneError):
            if attempt == _MOST_SHORTENINGS:
                raise
            moved = np.inf
        if moved <= _LONGEST_MOVE:
            break
        # Edges beside a front move fast: the step is chosen by them, not by the parameter.
        step *= max(_LONGEST_MOVE / moved, 0.1)
    beside = [ahead if point == 1 else at(float(point))[0] for point in _POINTS]
    return Varied(own, tuple(beside), step)


def _neighbour(
    pair: Pair, start: Placement, density: Density, rule: Rule, tolerance: float
) -> tuple[Member, float]:
    """Return a pair whose zones are of the kind of others, with the edges that it asks for, and
    how far these have moved as unknowns of `Coordinates`."""
    interface, unit = interface_of(pair)
    before = density.interface.compliance.distinct_fronts
    fronts = interface.compliance.distinct_fronts
    if len(fronts) != len(before):
        raise ComputationError(
            "derivative: two wave fronts of these bodies coincide, and part as this parameter "
            "changes; change a modulus or density a little."
        )
    to: dict[float | None, float | None] = {0.0: 0.0, None: None}
    to.update(zip(before, fronts, strict=True))
    segments = tuple((to[left] or 0.0, to[right]) for left, right in start.coordinates.segments)
    moved = replace(
        start,
        coordinates=Coordinates(segments),
        density=replace(start.density, interface=interface, zones=density.zones),
    )
    placed = polished(moved, glued(interface.compliance, 0.1 * tolerance), rule, tolerance, 12)
    if not placed.converged:
        raise ComputationError(
            "derivative: zones of this kind have no edges at a nearby value of the parameter; "
            "difference two solutions on the side that is wanted."
        )
    moves = np.abs(placed.unknowns - start.unknowns)
    return Member(pair, Profile(placed.density), unit), float(moves.max(initial=0.0))


def _border(varied: Varied, name: str) -> str:
    """Return a sentence if neighbours break the law of contact; "" if all obey it."""
    slowest = 1 / _LAW
    for one, point in zip(varied.beside, _POINTS, strict=True):
        if violations(one.profile, _LAW, slowest):
            side = "above" if point > 0 else "below"
            return (
                f"one-sided: {side} this value of {name} zones of another kind begin, and the "
                "derivative is that of the present ones"
            )
    return ""
