"""How far an answer may be off: two rules compared, and the canonical matrix against itself."""

from __future__ import annotations

import numpy as np

from semianalytic.dissimilar_slot.density import Density, density_of
from semianalytic.dissimilar_slot.panels import rule_for
from semianalytic.dissimilar_slot.placement import Placement, edge_tractions, mismatch
from semianalytic.dissimilar_slot.zones import edges_of
from semianalytic.halfplane.rayleigh import Array

_COARSER = 6.0
"""Tolerance of the rule an answer is compared with, over its own."""
_SAFETY = 2.0
"""Error estimate over the difference of two rules, which is that of the coarser one."""
_BETWEEN = 4.0
"""Error of rates and pressure between the points that are compared, over the tolerance of the rule:
up to 3 was seen (docs/dissimilar.md, "What it is worth")."""
_LEAST = 3e-13
"""Rounding, part of every estimate."""


def numerical_error(placement: Placement, tolerance: float) -> float:
    """Error estimate of placed zones on the rule of a tolerance.

    From fields of the same zones on a coarser rule: where that wants the edges, over the lesser of
    themselves and the speed of the slowest wave, and how its rates and tractions differ.
    """
    fine = placement.density
    coarse = density_of(fine.interface, fine.glued, fine.zones, rule_for(_COARSER * tolerance))
    error = _LEAST + fine.glued.error(np.array([0.0, fine.interface.compliance.last]))
    if not fine.zones:
        return error
    error += _BETWEEN * tolerance
    move = -placement.inverse @ (mismatch(coarse) - mismatch(fine))
    edges = np.array(edges_of(fine.zones))
    shifted = np.array(placement.coordinates.edges(placement.unknowns + move))
    slowest = fine.interface.compliance.last
    shifts = np.abs(shifted / edges - 1) * np.maximum(1.0, slowest / edges)
    left = placement.move * np.ones(1)
    changes = [shifts, left, _rate_change(fine, coarse), _traction_change(fine, coarse)]
    return error + _SAFETY * max(float(change.max()) for change in changes)


def _rate_change(fine: Density, coarse: Density) -> Array:
    """Differences of V and U at the ends of all panels and within them, over the largest."""
    values = [_rates(density) for density in (fine, coarse)]
    scale = np.abs(values[0]).max(axis=0)
    return np.asarray(np.abs(values[0] - values[1]) / np.where(scale > 0, scale, 1.0))


def _rates(density: Density) -> Array:
    """V and U, (n, 2): at the end of every panel, and in the middle of it, x = 0."""
    from scipy.special import sici  # here, for a quick import

    rate, result = np.zeros(2), []
    zone = -1
    on_panels = zip(density.parts, density.slopes, density.amplitudes, strict=True)
    for part, slope, amplitude in on_panels:
        panel = part.panel
        if panel.zone != zone and density.zones[panel.zone].left != stop_of(density, zone):
            rate = np.zeros(2)
        zone = panel.zone
        steps = -(panel.first + np.arange(panel.count))
        result.append(rate + (0.5 + sici(np.pi * steps)[0] / np.pi) @ slope)
        rate = rate + density.panel_change(part, slope, amplitude)
        result.append(rate)
    return np.array(result)


def stop_of(density: Density, zone: int) -> float | None:
    """Where a zone ends; None for none."""
    return density.zones[zone].right if zone >= 0 else None


def _traction_change(fine: Density, coarse: Density) -> Array:
    """Differences of tau and sigma at all edges, over themselves and the base."""
    one, other = edge_tractions(fine).values, edge_tractions(coarse).values
    interface = fine.interface
    held = np.array([interface.friction * interface.base_pressure, interface.base_pressure])
    return np.asarray(np.abs(one - other) / (np.abs(one) + held))
