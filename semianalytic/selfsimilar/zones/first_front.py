"""Zones just behind the longitudinal front, which may be narrower than any grid resolves.

Behind c_l the pressure falls like (v - a)^(1/2), and the shear traction rises like (v - a)^(3/2).
If the base is at friction and the step of shear opposes it, the interface therefore slips from the
front itself as soon as the pressure falls at all, until the step of shear prevails.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.cut_points import CutPoints
from semianalytic.halfplane.rayleigh import RayleighFactors
from semianalytic.selfsimilar.zones import tuning


def behind_front(factors: RayleighFactors) -> CutPoints:
    """Return points from the longitudinal to the shear front, even in the log of distance."""
    nearest, farthest = np.log(1e-16), np.log(1 - factors.a)
    return factors.beside("a", np.exp(np.arange(nearest, farthest, tuning.FRONT_STEP)))


def opening_behind_front(factors: RayleighFactors, load: Load, sense: int) -> CutPoints | None:
    """Return where a zone opens that slips behind the longitudinal front nearly without friction.

    There T = Q_0, turned by the phase of the impedance, has raised the traction to friction. The
    result is None if that happens nowhere ahead of the shear front.
    """
    at = behind_front(factors)
    # A front of slowness p makes T = Q_0 k / (k + p) of the load: v - p takes the place of v.
    over = np.pi * (at.v - load.slowness)
    slope = load.load_shear * np.sin(factors.phase(at)) / over * at.from_a
    # Trapezoidal sum of dtau/dv = Im T / (pi v) in the logarithm of v - a.
    gained = np.cumsum((slope[1:] + slope[:-1]) / 2 * tuning.FRONT_STEP)
    mode_one = load.stuck(factors, "I")
    strength = load.friction * (load.base_pressure + load.load_pressure * mode_one.at(at[1:]))
    above = np.flatnonzero(sense * (load.base_shear + gained) >= strength)
    return at[[above[0] + 1]] if len(above) else None


def with_slip_at_front(
    factors: RayleighFactors, zones: Sequence[Zone], load: Load
) -> Sequence[Zone]:
    """Return the zones with one ahead of them if a base at friction is released at the first front.

    This zone ends approximately where the stuck interface would satisfy Coulomb's law again.
    """
    sense = int(np.sign(load.base_shear))
    held = not (load.critical and sense and load.load_pressure) or bool(load.far_slip_rate)
    if held or (zones and zones[0].left is None):
        return zones
    first = zones[0] if zones else None
    if factors.mode == "III" and first and first.left is not None and first.left.from_b[0] < 0:
        # In antiplane shear no shear arrives ahead of the shear front, which would hold the strip.
        return [replace(first, left=None), *zones[1:]]
    at = behind_front(factors)
    at = at[at.from_a > 1e-11]  # of less rounding shows nothing
    if load.opened is None:
        pressure = load.friction * load.load_pressure * load.stuck(factors, "I").at(at)
    else:
        pressure = load.friction * (load.pressure(factors, at) - load.base_pressure)
    # Stuck traction less strength, both less their value ahead, where the base is exactly at
    # friction.
    excess = sense * load.load_shear * load.stuck(factors, factors.mode).at(at) - pressure
    kept = np.flatnonzero(excess <= 0)
    # At nu = 0 the pressure falls too late behind the front, and no strip is found.
    if not len(kept) or not kept[0]:
        return zones
    right = at[[kept[0]]]
    if zones and zones[0].left is not None and not right.first_below(zones[0].left):
        return zones
    return [Zone(None, right, sense), *zones]
