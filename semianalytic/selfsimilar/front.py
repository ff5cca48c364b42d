"""Slip just behind the longitudinal front, where zones may be narrower than any grid sees.

There q* falls behind p*: behind c_l the pressure falls like (v - a)^(1/2), shear rises like
(v - a)^(3/2).  A base at friction against the step therefore slips from the front itself as soon as
pressure falls at all, until the step of shear has the upper hand.
"""

from __future__ import annotations

import numpy as np

from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.selfsimilar.edges import Edges, edges_of
from semianalytic.selfsimilar.layout import Zone
from semianalytic.selfsimilar.zones import Load

_NEAREST = 1e-16  # to the front, in slowness
_NARROWEST = 1e-11  # zone; of less rounding shows nothing
_STEP = 0.1  # of the logarithm of the distance


def _behind(factors: RayleighFactors) -> CutPoints:
    """Points closer and closer to the front, outermost first, up to the shear front."""
    return factors.beside("a", np.exp(np.arange(np.log(_NEAREST), np.log(1 - factors.a), _STEP)))


def opening_behind_front(factors: RayleighFactors, load: Load, sense: int) -> CutPoints | None:
    """Where a zone opens that slips behind the longitudinal front nearly as without friction.

    There T = Q_0, turned by the phase of the impedance, has raised the traction to friction; None
    if that is nowhere ahead of the shear front.
    """
    at = _behind(factors)
    slope = load.load_shear * np.sin(factors.phase(at)) / (np.pi * at.v) * at.from_a
    gained = np.cumsum((slope[1:] + slope[:-1]) / 2 * _STEP)
    mode_one = stuck_traction(factors.poisson_ratio, "I")
    strength = load.friction * (load.base_pressure + load.load_pressure * mode_one(at.v[1:]))
    above = np.flatnonzero(sense * (load.base_shear + gained) >= strength)
    return at[[above[0] + 1]] if len(above) else None


def with_slip_at_front(edges: Edges, unknowns: Array, load: Load) -> tuple[Edges, Array]:
    """The zones, and ahead of them that of a base at friction which pressure lets go at the front.

    It ends about where the stuck interface would keep Coulomb's law again.
    """
    zones, factors = edges.zones(unknowns), edges.factors
    sense = int(np.sign(load.base_shear))
    at_rest = not (load.critical and sense and load.load_pressure) or bool(load.far_slip_rate)
    if at_rest or (zones and zones[0].left is None):
        return edges, unknowns
    at, nu = _behind(factors), factors.poisson_ratio
    at = at[at.from_a > _NARROWEST]
    pressure = load.friction * load.load_pressure * stuck_traction(nu, "I")(at.v)
    excess = sense * load.load_shear * stuck_traction(nu, "II")(at.v) - pressure
    kept = np.flatnonzero(excess <= 0)
    if not len(kept) or not kept[0]:  # at nu = 0 pressure falls too late
        return edges, unknowns
    right = at[[kept[0]]]
    if zones and zones[0].left is not None and not right.first_below(zones[0].left):
        return edges, unknowns
    return edges_of(factors, [Zone(None, right, sense), *zones])
