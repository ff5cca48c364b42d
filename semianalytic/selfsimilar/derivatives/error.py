"""The error of a derivative, from its difference from a coarser one."""

from __future__ import annotations

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.derivatives.varied import VariedProfile, edges_of_zones
from semianalytic.selfsimilar.zones import tuning


def difference_error(fine: VariedProfile, coarse: VariedProfile, size: float) -> float:
    """Return the error estimate of a derivative from a coarser one.

    It covers edges, slip rate, slip and tractions, relative to their largest derivative, or to c_t
    and the largest values of the fields per `size` of the parameter, if these are larger.
    """
    profile = fine.profile
    u = _compared(profile)
    worst = _share(fine.edges_moved(), coarse.edges_moved(), 1 / size)
    worst = max(worst, _largest_share(fine, coarse, u, size))
    if profile.edge_slips:
        # A film may slip at the contact edge alone, nearer than any of these points: one of
        # resistance 65 slipped on 0.046 c_t, and its estimate was 2.4 times too small.
        near = _compared(profile, 1e-6)
        worst = max(worst, _largest_share(fine, coarse, near, size))
    # No compared velocity lies between the edges: with 5 one of 60 random films was 1.7 times its
    # estimate off, with 10 0.6 times.
    edges = np.unique([edge.v[0] for edge in edges_of_zones(profile)])
    passed = len(edges) > 1 and bool(np.any(np.histogram(u, edges)[0] == 0))
    safety = 20.0 if passed else tuning.SAFETY
    return 1e-10 + safety * worst  # 1e-10 is rounding of differences


def _largest_share(fine: VariedProfile, coarse: VariedProfile, u: Array, size: float) -> float:
    """Return the largest difference at slownesses u over the largest value, or field per `size`."""
    profile, worst = fine.profile, 0.0
    compared = [
        (fine.slip_rate(u), coarse.slip_rate(u), profile.slip_rate(u)),
        (fine.slip_over_time(u), coarse.slip_over_time(u), profile.slip_over_time(u)),
        (fine.traction(u), coarse.traction(u), profile.shear_change(u)),
    ]
    if profile.normal and fine.normal and coarse.normal:
        near, far, normal = fine.normal, coarse.normal, profile.normal
        # In antiplane shear the panels have no nodes on either side of c_R, so that the gap is
        # left out.
        if profile.fields.factors.has_rayleigh_wave:
            compared.append((near.slip_rate(u), far.slip_rate(u), normal.slip_rate(u)))
        compared.append((near.traction(u), far.traction(u), normal.shear_change(u)))
    for finer, other, field in compared:
        worst = max(worst, _share(finer, other, float(np.abs(field).max()) / size))
    return worst


def _compared(profile: Profile, nearest: float = tuning.CLEAR_OF_EDGES) -> Array:
    """Return slownesses clear of edges and fronts, from the velocity `nearest` [c_t] on."""
    factors = profile.fields.factors
    marks = np.array([edge.v[0] for edge in edges_of_zones(profile)] + [factors.a, 1.0, factors.c])
    xi = np.geomspace(nearest, 1 / factors.a, 100)
    return np.asarray(1 / xi[np.abs(xi[:, None] - 1 / marks).min(axis=1) > tuning.CLEAR_OF_EDGES])


def _share(finer: Array, other: Array, least: float) -> float:
    """Return the largest difference of derivatives over the largest, or a lower bound."""
    away, size = np.abs(finer - other).max(initial=0.0), np.abs(finer).max(initial=0.0)
    return float(away / max(size, least)) if away else 0.0
