"""Coulomb's law between the nodes of a rule, where a narrow zone may hide.

What the law forbids is followed as one number: traction over friction where the interface sticks,
slip rate against the sense of its zone where it slips.  Where a parabola through three nodes comes
near to what is allowed, the number is evaluated more and more closely around its peak.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.selfsimilar.profile import Profile

_NEAR = 8.0  # nodes further out in y lie closer together than anything hides
_DOUBTFUL = 3e-3  # what a parabola through nodes may be wrong by
_POINTS = 8  # per node distance, and again


@dataclass(frozen=True)
class Hidden:
    """An interval of slowness between nodes of a panel where Coulomb's law fails."""

    panel: int
    left: CutPoints
    right: CutPoints


def doubtful(profile: Profile) -> np.ndarray:
    """(p, ..., n - 2): inner nodes beside which the law may fail though it holds at all nodes."""
    value, y = profile.wrong_at_nodes, profile.panels.rule.y
    before, middle, after = value[..., :-2], value[..., 1:-1], value[..., 2:]
    bend = 2 * middle - before - after
    top = middle + np.square(after - before) / (8 * np.where(bend > 0, bend, np.inf))
    result = (middle >= before) & (middle > after) & (top > -_DOUBTFUL) & (np.abs(y[1:-1]) < _NEAR)
    if profile.panels.layout.pole >= 0:
        result[profile.panels.layout.pole] = False  # V is unbounded there
    return np.asarray(result)


def hidden(profile: Profile, tolerance: float) -> list[Hidden]:
    """Where the law of one set of zones fails between nodes by more than a tolerance."""
    panels, found = profile.panels, []
    steps = np.linspace(-1, 1, 2 * _POINTS + 1)
    for panel, node in np.argwhere(doubtful(profile)):
        centre, step = panels.rule.y[node + 1], panels.rule.spacing
        for _ in range(2):
            y = centre + step * steps
            value = profile.wrong(panel, panels.inside(panel, y))
            best = int(np.clip(np.argmax(value), 1, len(y) - 2))
            centre, step = y[best], step / _POINTS
        before, top, after = value[best - 1 : best + 2]
        bend = 2 * top - before - after
        if bend > 0 and (top := top + (after - before) ** 2 / (8 * bend)) > tolerance:
            half = step * np.sqrt(2 * top / bend)
            ends = panels.inside(panel, centre + np.array([-half, half]))
            found.append(Hidden(int(panel), ends[[0]], ends[[1]]))
    return found
