"""Place zone edges by Newton's method, with one condition for each edge.

- Where slip starts, tau + s f sigma equals its level s f P_b - Q_b.
- Where slip heals, the slip rate is 0.
- Where slip turns to opening, sigma equals P_b, so that the contact pressure is 0.
- Where an opening closes, the gap is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from semianalytic.dissimilar.canonical import Glued
from semianalytic.dissimilar_slot.densities.density import Density, density_of
from semianalytic.dissimilar_slot.densities.interface import LoadedBodies
from semianalytic.dissimilar_slot.densities.panels import PanelRule, rule_for
from semianalytic.dissimilar_slot.densities.zones import (
    Coordinates,
    MovingZone,
    coordinates_of,
    edges_of,
    moved,
    neighbours,
)
from semianalytic.halfplane.rules import sinc_step
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones.edges import broyden

_NUDGE = 1e-6
"""Change of an unknown for its column of the Jacobian."""
_HARMLESS = 0.05
"""A step is not halved if the next one is shorter; after one the Jacobian is updated."""
_COMPARED = np.linspace(-6.0, 6.0, 25)
"""Coordinates x of a panel at which rates are compared: between them they differ no more."""


def mismatch(density: Density) -> Array:
    """Return the residual of the condition at each edge, (e,), in the order of `edges_of`."""
    interface = density.interface
    left_by: dict[float, float] = {}
    slip = 0.0
    for index, (before, zone, after) in enumerate(neighbours(density.zones)):
        tau, sigma = density.at_edges[zone.left]
        # The sides of an opening move along one another too: V goes on through joined zones.
        slip = density.change(index)[0] + (0.0 if before is None else slip)
        if zone.open:
            left_by[zone.left] = sigma - interface.base_pressure
        elif before is None:
            level = interface.level(zone.sense)
            left_by[zone.left] = tau + zone.sense * interface.friction * sigma - level
        if zone.right is None:
            continue
        if zone.open:
            left_by[zone.right] = density.gap_left(index)
        elif after is None:
            left_by[zone.right] = slip
    return np.array([left_by[edge] for edge in edges_of(density.zones)])


@dataclass(frozen=True)
class PlacedZones:
    """Zones whose edges Newton's method has placed, with the inverse Jacobian (e, e) there.

    `move` is the largest change of an unknown in the next step.
    """

    coordinates: Coordinates
    unknowns: Array
    inverse: Array
    density: Density
    converged: bool
    steps: int
    move: float

    @property
    def zones(self) -> tuple[MovingZone, ...]:
        """The zones as placed."""
        return self.density.zones


def place(
    interface: LoadedBodies,
    glued: Glued,
    zones: Sequence[MovingZone],
    rule: PanelRule,
    tolerance: float,
) -> PlacedZones:
    """Place the edges of zones by Newton's method, until a step is below a tolerance."""
    coordinates = coordinates_of(interface.compliance.distinct_fronts, edges_of(zones))

    def at(unknowns: Array, near: Density | None = None) -> Density:
        placed = moved(zones, coordinates.edges(unknowns))
        return density_of(interface, glued, placed, rule, near)

    unknowns = coordinates.unknowns(edges_of(zones))
    density, inverse = at(unknowns), np.zeros((len(unknowns), len(unknowns)))
    if not len(unknowns):
        return PlacedZones(coordinates, unknowns, inverse, density, True, 0, 0.0)
    values, before, renew, largest = mismatch(density), np.inf, True, np.inf
    for step in range(1, 15):  # two to five are usual from zones of the grid
        if renew:
            nudges = _NUDGE * np.eye(len(unknowns))
            beside = [mismatch(at(unknowns + nudge, density)) for nudge in nudges]
            try:
                jacobian = (np.array(beside).T - values[:, None]) / _NUDGE
                inverse = np.asarray(np.linalg.inv(jacobian), dtype=float)
            except np.linalg.LinAlgError:
                break
        move = -inverse @ values
        largest = float(np.abs(move).max())
        # An edge that has run into a front is no failure of the method: `rearranged` moves it
        # across.
        if not largest < np.inf or np.abs(unknowns).max() > 40.0:
            break
        if largest < tolerance:
            return PlacedZones(coordinates, unknowns, inverse, density, True, step, largest)
        # An updated Jacobian is formed anew when its steps shorten too little.
        if not renew and largest > 0.3 * before:  # steps that shrink slower renew the Jacobian
            renew = True
            continue
        move *= min(1.0, 1.2 / largest)
        for halvings in range(6):
            trial = at(unknowns + move)
            left = mismatch(trial)
            # Natural monotonicity: the next step, with the present Jacobian, must not be longer.
            if halvings == 5 or np.abs(inverse @ left).max() <= max(largest, _HARMLESS):
                break
            move = move / 2
        inverse = broyden(inverse, move, left - values)
        renew, before = largest > _HARMLESS, largest
        unknowns, density, values = unknowns + move, trial, left
    return PlacedZones(coordinates, unknowns, inverse, density, False, step, largest)


def polished(
    start: PlacedZones, glued: Glued, rule: PanelRule, tolerance: float, most_steps: int = 8
) -> PlacedZones:
    """Move the edges to their places on a finer rule, with the Jacobian of a coarser one."""
    unknowns, inverse, coordinates = start.unknowns, start.inverse, start.coordinates
    interface, zones = start.density.interface, start.density.zones
    move, before, largest, steps = np.zeros(len(unknowns)), None, 0.0, 0
    density: Density | None = None
    while True:
        placed = moved(zones, coordinates.edges(unknowns))
        density = density_of(interface, glued, placed, rule, density)
        if not len(unknowns):
            break
        values = mismatch(density)
        if before is not None:
            inverse = broyden(inverse, move, values - before)
        move, before = -inverse @ values, values
        largest = float(np.abs(move).max())
        steps += 1
        # A step of 1 is far from what a finer rule changes: the edges were not those of this
        # problem.
        if largest < tolerance or not largest < 1 or steps == most_steps:
            break
        unknowns = unknowns + move
    return PlacedZones(coordinates, unknowns, inverse, density, largest < tolerance, steps, largest)


def numerical_error(placement: PlacedZones, tolerance: float) -> float:
    """Return the error estimate of placed zones on the rule of a tolerance.

    It is from a coarser rule: the edges that it asks for, over the lesser of their speed and the
    slowest wave speed, and differences of rates and tractions.
    """
    fine = placement.density
    coarse = density_of(fine.interface, fine.glued, fine.zones, rule_for(6.0 * tolerance))
    error = 3e-13 + fine.glued.error(np.array([0.0, fine.interface.compliance.last]))  # rounding
    if not fine.zones:
        return error
    error += 4.0 * tolerance  # values up to 3 at points between those compared
    # One Newton step from the coarse mismatch shows where the coarse rule would put the edges.
    move = -placement.inverse @ (mismatch(coarse) - mismatch(fine))
    edges = np.array(edges_of(fine.zones))
    shifted = np.array(placement.coordinates.edges(placement.unknowns + move))
    slowest = fine.interface.compliance.last
    shifts = np.abs(shifted / edges - 1) * np.maximum(1.0, slowest / edges)
    rates, others = _rates(fine), _rates(coarse)
    scale = np.abs(rates).max(axis=0)
    of_rates = np.abs(rates - others) / np.where(scale > 0, scale, 1.0)
    # The traction of a film, over itself, what it changes the base by, and the load.
    loads = fine.interface
    film = 2.0 * loads.resistance * np.abs(rates[:, 0]) + abs(loads.load_shear)
    film += loads.friction * loads.base_pressure
    of_film = loads.resistance * np.abs(rates - others)[:, 0] / np.where(film > 0, film, 1.0)
    # Differences of tau and sigma at edges, over themselves plus f P_b or P_b.
    held = np.array([loads.friction * loads.base_pressure, loads.base_pressure])
    finer, other = (np.array([*both.at_edges.values()]) for both in (fine, coarse))
    at_edges = np.abs(finer - other) / (np.abs(finer) + held)
    changes = [shifts, of_rates, of_film, at_edges]
    return error + 2.0 * max(placement.move, *(float(change.max()) for change in changes))


def _rates(density: Density) -> Array:
    """Return V and U, (n, 2), at points of every panel and at its end."""
    rate, result = np.zeros(2), []
    zone = -1
    on_panels = zip(density.parts, density.slopes, density.amplitudes, strict=True)
    for part, slope, amplitude in on_panels:
        panel = part.panel
        stop = density.zones[zone].right if zone >= 0 else None
        if panel.zone != zone and density.zones[panel.zone].left != stop:
            rate = np.zeros(2)
        zone = panel.zone
        nodes = panel.first + np.arange(panel.count)
        steps = _COMPARED[:, None] / panel.spacing - nodes
        result += [*(rate + sinc_step(steps) @ slope)]
        rate = rate + density.panel_change(part, slope, amplitude)
        result.append(rate)
    return np.array(result)
