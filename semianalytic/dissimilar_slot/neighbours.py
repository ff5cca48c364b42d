"""Neighbours of a solved pair along a parameter, and differences of its fields between them.

Fields are not smooth in a parameter p at fixed slowness, past which an edge or a wave front moves,
but they are at fixed places x between the edges and fronts.  They are differenced there, to fourth
order, between neighbours whose edges Newton's method places, and the motion of the places is taken
off again:

    dF/dp = dF/dp at x - ds/dp at x (dF/dx) / (ds/dx),

s being the slowness.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from semianalytic.dissimilar.canonical import glued
from semianalytic.dissimilar.stretch import Stretch
from semianalytic.dissimilar_slot.admissible import violations
from semianalytic.dissimilar_slot.densities.density import Density
from semianalytic.dissimilar_slot.densities.interface import interface_of
from semianalytic.dissimilar_slot.densities.panels import PanelRule, rule_for
from semianalytic.dissimilar_slot.densities.profile import (
    GAP,
    NORMAL,
    OPENING,
    RATE,
    SHEAR,
    SLIP,
    PairProfile,
)
from semianalytic.dissimilar_slot.densities.zones import Coordinates, edges_of
from semianalytic.dissimilar_slot.placement import PlacedZones, place, polished
from semianalytic.halfplane.polynomials import FOURTH_ORDER
from semianalytic.parameters.numbers import numbers_of, with_numbers
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.scene import Scene

_POINTS, _WEIGHTS = FOURTH_ORDER


@dataclass(frozen=True, eq=False)
class Member:
    """A pair near another one, with its own edges, and the unit of stress of its profile."""

    scene: Scene
    profile: PairProfile
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
        return v / self.scene.material.shear_speed

    def fields(self, v: Array) -> Array:
        """Return slip rate, rate of opening, slip and gap over x, shear traction and pressure."""
        values = self.profile.at(v)
        rate = self.stress / self.scene.material.shear_impedance
        values[[RATE, OPENING]] *= rate
        values[[SLIP, GAP]] *= rate / self.scene.material.shear_speed
        values[SHEAR] = self.scene.base.shear + self.stress * values[SHEAR]
        values[NORMAL] = self.scene.base.pressure - self.stress * values[NORMAL]
        return values

    def stretches(self) -> list[Stretch]:
        """Return what lies between neighbouring marks, and behind the last one."""
        rights: list[float | None] = [*self.marks[1:], None]
        return [Stretch(*ends) for ends in zip(self.marks, rights, strict=True)]


@dataclass(frozen=True, eq=False)
class Varied:
    """A solved pair and its neighbours at `_POINTS` times `step` of a parameter."""

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
            1 / near.slowness(np.array(edges_of(near.profile.density.zones)))
            for near in self.beside
        ]
        return self._difference(velocities)

    @cached_property
    def _ahead(self) -> Array:
        """Derivatives of all fields ahead of all waves."""
        return self._difference([neighbour.fields(np.zeros(1))[:, 0] for neighbour in self.beside])

    @cached_property
    def at_edge(self) -> float:
        """Derivative of the slip rate at the contact edge."""
        # Slowness at the contact edge is infinite; the rate has reached its limit long before this.
        far = np.array([1e12])
        return float(self._difference([near.fields(far)[RATE, 0] for near in self.beside]))

    def fields(self, v: Array) -> Array:
        """Return the derivatives (6, n) of `Member.fields` at slownesses v of the pair itself."""
        result = np.repeat(self._ahead[:, None], len(v), axis=1)
        stretches = [solution.stretches() for solution in (self.own, *self.beside)]
        index = np.searchsorted(self.own.marks, v, side="right") - 1
        for k, (stretch, *others) in enumerate(zip(*stretches, strict=True)):
            here = index == k
            if not here.any():
                continue
            x = np.clip(stretch.coordinates(v[here]), -200.0, 200.0)
            places = [other.at(x).v for other in others]
            beside = list(zip(self.beside, places, strict=True))
            at_place = self._difference([neighbour.fields(place) for neighbour, place in beside])
            moved = self._difference([neighbour.slowness(place) for neighbour, place in beside])
            along = [stretch.at(x + 5e-3 * point).v for point in _POINTS]
            slope = np.tensordot(_WEIGHTS, [self.own.fields(point) for point in along], 1)
            run = np.tensordot(_WEIGHTS, [self.own.slowness(point) for point in along], 1)
            with np.errstate(divide="ignore", invalid="ignore"):
                # At a fixed place between the marks fields change smoothly; the place itself has
                # moved, which is taken back along the slope of the fields.
                share = np.where(run == 0, 0.0, moved / run)
            result[:, here] = at_place - share * slope
        return result


def neighbours(own: Member, name: str, tolerance: float, step: float) -> Varied:
    """Return a solved pair with its neighbours along a parameter, each with its own edges."""
    density, rule = own.profile.density, rule_for(tolerance)
    value = numbers_of(own.scene)[name].value
    start = place(density.interface, density.glued, density.zones, rule_for(1e-5), 1e-5)
    # The loose rule gives the Jacobian alone: neighbours start from the edges themselves.
    start = replace(start, unknowns=start.coordinates.unknowns(edges_of(density.zones)))

    def at(point: float) -> tuple[Member, float]:
        scene = with_numbers(own.scene, {name: value + step * point})
        return _neighbour(scene, start, density, rule, tolerance)

    for attempt in range(6):
        try:
            ahead, moved = at(1.0)
        except (ComputationError, SceneError):
            if attempt == 5:
                raise
            moved = np.inf
        if moved <= 0.02:  # an edge next to a front would cross it
            break
        # Edges near a front move fast: the step is chosen by them, not by the parameter.
        step *= max(0.02 / moved, 0.1)
    beside = [ahead if point == 1 else at(float(point))[0] for point in _POINTS]
    return Varied(own, tuple(beside), step)


def _neighbour(
    scene: Scene, start: PlacedZones, density: Density, rule: PanelRule, tolerance: float
) -> tuple[Member, float]:
    """Return a pair of like zones with its own edges, and how far these moved as unknowns."""
    interface, unit = interface_of(scene)
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
    varied = replace(start.density, interface=interface, zones=density.zones)
    moved = replace(start, coordinates=Coordinates(segments), density=varied)
    placed = polished(moved, glued(interface.compliance, 0.1 * tolerance), rule, tolerance, 12)
    if not placed.converged:
        raise ComputationError(
            "derivative: zones of this kind have no edges at a nearby value of the parameter; "
            "difference two solutions on the side that is wanted."
        )
    moves = np.abs(placed.unknowns - start.unknowns)
    return Member(scene, PairProfile(placed.density), unit), float(moves.max(initial=0.0))


def border(varied: Varied, name: str) -> str:
    """Return a sentence if neighbours break the law of contact; "" if all obey it."""
    slowest = 1e6 * varied.beside[0].profile.density.interface.compliance.last
    for neighbour, point in zip(varied.beside, _POINTS, strict=True):
        if violations(neighbour.profile, 1e-6, slowest):  # its zones are others
            side = "above" if point > 0 else "below"
            return (
                f"one-sided: {side} this value of {name} zones of another kind begin, and the "
                "derivative is that of the present ones"
            )
    return ""
