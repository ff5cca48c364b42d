"""The solved normal problem: pressure and gap of a contact that opens, over slowness."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from semianalytic.cut.load import LEAST_BASE, Load, Opened, normal_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.cut_points import CutPoints
from semianalytic.halfplane.rayleigh import Array, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.separation.opening import OpenPart, opening_of

RULE_SHARE, LEAST_TOLERANCE = 1e-2, 1e-14
"""Tolerance over what is asked for, and at least: shear is to find nothing missing in it."""


@dataclass(frozen=True)
class NormalFields:
    """Pressure and gap where the contact opens: minus pressure as traction, gap as slip."""

    opening: OpenPart
    profile: Profile
    error: float

    def pressure(self, at: CutPoints) -> Array:
        """Return the contact pressure at points on the cut, any shape; 0 where it is open."""
        return -self.profile.traction_at(CutPoints(at.parts.reshape(4, -1))).reshape(at.v.shape)

    def known_pressure(self) -> Array:
        """Slownesses of the nodes, increasing, and approximate pressures there, (2, n).

        The pressures are sums over nodes, right to some thousandths.
        """
        fields, panels = self.profile.fields, self.profile.panels
        fall = (fields.traction_slope * panels.jacobian).ravel() * panels.rule.spacing
        # Half of what a node stands for lies behind it: the midpoint of the sums around it.
        pressure = -fields.base_traction - np.cumsum(fall) + fall / 2
        pressure[np.repeat(panels.layout.slipping, len(panels.rule.y))] = 0.0
        return np.stack([panels.at.v.ravel(), np.maximum(pressure, 0.0)])


def with_opening(
    load: Load, factors: RayleighFactors, rtol: float
) -> tuple[Load, NormalFields | None]:
    """Return the load with the contact open where it opens, and the normal problem; None if closed.

    `factors` are those of shear, in plane or antiplane.

    Raises
    ------
    ComputationError
        If the edges of the opening are not found.
    """
    # So little suction would open the contact within rounding of its edge.
    if -LEAST_BASE * load.base_pressure <= load.load_pressure < 0:
        return replace(load, load_pressure=0.0), None
    normal, of_mode = normal_problem(load, factors.poisson_ratio, rtol), factors.of_in_plane
    if normal is None:
        return load, None
    opened = Opened(
        normal.opening.zone.seen_by(of_mode),
        tuple((of_mode(edge), amount) for edge, amount in normal.opening.closing),
        load.base_pressure,
        load.load_pressure,
        partial(_pressure, normal, factors),  # a function that can be pickled
        normal.known_pressure(),
        load.slowness,
    )
    return replace(load, opened=opened), normal


def _pressure(normal: NormalFields, factors: RayleighFactors, at: CutPoints) -> Array:
    return normal.pressure(factors.seen_in_plane(at))


def normal_problem(load: Load, poisson_ratio: float, rtol: float) -> NormalFields | None:
    """Solve the normal problem of a load to an accuracy; None if the contact stays closed."""
    tolerance = max(rtol * RULE_SHARE, LEAST_TOLERANCE)
    of_load = poisson_ratio, load.base_pressure, load.load_pressure
    opening = opening_of(*of_load, tolerance, load.slowness)
    # Slip zones are placed with the rest of rtol, which the opening must not use up.
    while opening and opening.error > 0.2 * rtol and tolerance > LEAST_TOLERANCE:
        tolerance = max(tolerance * RULE_SHARE, LEAST_TOLERANCE)
        opening = opening_of(*of_load, tolerance, load.slowness)
    if opening is None:
        return None
    given = normal_load(load.base_pressure, load.load_pressure, load.slowness)
    factors, rule = rayleigh_factors(poisson_ratio, "I"), rule_for(tolerance)
    fields = ZoneFields(factors, given, (opening.zone,), rule, closing=opening.closing)
    # At most 4.5 tolerances between nodes, next to the threshold in all scenes.
    return NormalFields(opening, Profile(fields), opening.error + 6.0 * tolerance)
