"""The edges of a set of zones, and how their velocities change with a parameter."""

from __future__ import annotations

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.halfplane.cut_points import CutPoints
from semianalytic.halfplane.rayleigh import Array
from semianalytic.selfsimilar.derivatives.varied import VariedProfile


def edges_of_zones(profile: Profile) -> list[CutPoints]:
    """Return the edges of slip zones, from the longitudinal front inward, and of the opening."""
    zones, opened = profile.fields.zones, profile.fields.load.opened
    if opened is not None:
        zones = (*zones, opened.zone)
    return [edge for zone in zones for edge in (zone.left, zone.right) if edge is not None]


def edges_moved(varied: VariedProfile) -> Array:
    """Return the derivatives (e,) of the velocities of these edges [c_t]."""
    edges = edges_of_zones(varied.profile)
    return np.array([edge_moved(varied, edge) for edge in edges])


def edge_moved(varied: VariedProfile, edge: CutPoints) -> float:
    """Return the derivative of the velocity [c_t] of an edge or front where a panel begins."""
    # The velocity is 1 / v, so that d(1/v) = -dv / v^2.
    return float(-varied.moved(edge)[0] / edge.v[0] ** 2)
