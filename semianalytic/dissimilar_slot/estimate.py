"""Estimate the error of an answer from two rules and from the identity Psi^T R(-k) = n_inf."""

from __future__ import annotations

import numpy as np

from semianalytic.dissimilar_slot.densities.density import Density, density_of
from semianalytic.dissimilar_slot.densities.panels import rule_for
from semianalytic.dissimilar_slot.densities.zones import edges_of
from semianalytic.dissimilar_slot.placement import PlacedZones, edge_tractions, mismatch
from semianalytic.halfplane.rules import sinc_step
from semianalytic.scene.arrays import Array

_COMPARED = np.linspace(-6.0, 6.0, 25)
"""Coordinates x of a panel at which rates are compared: between them they differ no more."""


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
    finer, other = edge_tractions(fine), edge_tractions(coarse)
    move = -placement.inverse @ (mismatch(coarse, other) - mismatch(fine, finer))
    edges = np.array(edges_of(fine.zones))
    shifted = np.array(placement.coordinates.edges(placement.unknowns + move))
    slowest = fine.interface.compliance.last
    shifts = np.abs(shifted / edges - 1) * np.maximum(1.0, slowest / edges)
    left = placement.move * np.ones(1)
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
    at_edges = np.abs(finer.values - other.values) / (np.abs(finer.values) + held)
    changes = [shifts, left, of_rates, of_film, at_edges]
    return error + 2.0 * max(float(change.max()) for change in changes)


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
