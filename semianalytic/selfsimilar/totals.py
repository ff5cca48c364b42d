"""Integrals of slip rate and of what friction takes over position and time, and largest slip."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from semianalytic.halfplane.rayleigh import Array, CutPoints
from semianalytic.selfsimilar import tuning
from semianalytic.selfsimilar.profile import Profile


def largest_slip_over_time(profile: Profile) -> float:
    """Largest |slip| / t, b = mu = 1 and one-sided, on the contact; the limit at a slipping edge.

    The largest at the nodes of panels that slip, and at ever closer points around it; where it
    sticks slip / t falls.
    """
    limits = [abs(float(profile.fields.load.far_slip_rate)), abs(profile.edge_slip_rate)]
    slipping = list(profile.panels.layout.slip)
    if not slipping:
        return max(limits)
    u = np.sort(profile.panels.at.v[slipping].ravel())
    for _ in range(tuning.ZOOMS):
        size = np.abs(profile.slip_over_time(u))
        top = int(np.argmax(size))
        limits.append(float(size[top]))
        u = np.linspace(u[max(top - 1, 0)], u[min(top + 1, len(u) - 1)], tuning.ZOOM_POINTS)
    return max(limits)


def dissipation(profile: Profile, u: Array) -> Array:
    """(2, m): integrals of tau V over velocities from 1/u to c_l, and over slownesses up to u.

    At u (m,), in units b = mu = 1, with the one-sided slip rate.  The first is negative where
    the interface slips ahead of all waves and u is there.
    """
    panels, load = profile.panels, profile.fields.load
    front = panels.left[0].v[0]
    ahead = panels.sense[0] * load.friction * load.base_pressure * load.far_slip_rate
    reached = np.minimum(u, front)
    result = ahead * np.stack([1 / front - 1 / np.maximum(reached, tuning.EARLIEST), reached])
    at = profile.fields.factors.cut(u)
    for panel in panels.layout.slip:
        for left, right in _pieces(profile, int(panel), float(u.max(initial=0.0))):
            density = _density(profile, int(panel), left, right)
            from_left, to_right = at.minus(left), -at.minus(right)
            inside, behind = (from_left > 0) & (to_right > 0), to_right <= 0
            y = np.log(from_left[inside] / to_right[inside])
            result[:, inside] += panels.rule.interpolate_running(y, density).T
            result[:, behind] += panels.rule.spacing * density.sum(axis=1)[:, None]
    return result


def _pieces(profile: Profile, panel: int, most: float) -> Iterator[tuple[CutPoints, CutPoints]]:
    """Parts of a panel of which the slip rate is singular at ends only, to slowness `most` at
    least: a panel that covers c is cut there."""
    panels, factors = profile.panels, profile.fields.factors
    right = panels.right[panel]
    ends = [panels.left[panel]]
    if panel == panels.layout.pole:
        ends.append(factors.front_c)
    if right is not None:
        ends.append(right)
    while right is None and ends[-1].v[0] < most:
        ends.append(factors.cut(tuning.PIECE_GROWTH * ends[-1].v))
    return pairwise(ends)


def _density(profile: Profile, panel: int, left: CutPoints, right: CutPoints) -> Array:
    """(2, n): tau V / v^2 and tau V at the nodes of the rule between two points, times dv/dy."""
    panels, rule = profile.panels, profile.panels.rule
    width = right.minus(left)
    at = CutPoints(
        np.where(
            rule.y < 0, left.parts + width * rule.share, right.parts - width * rule.share[::-1]
        )
    )
    traction = panels.sense[panel] * profile.strength(at.v)
    power = traction * profile.slip_rate_inside(panel, at) * width * rule.bell
    return np.stack([power / np.square(at.v), power])
