"""Answers of sweeps held against those that are solved one by one."""

import numpy as np

from semianalytic import solve
from semianalytic.parameters.numbers import with_numbers

SWEEPS = {"preloaded": (0.05, 1.0), "remote-shock": (1.05, 1.5)}
"""Frictions of sweeps of named scenes, which cross thresholds."""


def edge_difference(first, other):
    """The largest difference of zone edges over c_t; None if the zones differ in number.

    Zones that are closer to each other than rounding count as one.
    """
    speed = first.scene.material.shear_speed
    mine, theirs = (joined(solution.edge_speeds / speed) for solution in (first, other))
    if len(mine) != len(theirs):
        return None
    return max((abs(p - q) for p, q in zip(mine, theirs, strict=True) if p != q), default=0.0)


def joined(fronts):
    edges = fronts.ravel().tolist()
    gaps = [i for i in range(1, len(edges) - 1, 2) if edges[i + 1] - edges[i] < 1e-13]
    return [edge for i, edge in enumerate(edges) if i not in gaps and i - 1 not in gaps]


def check_against_single(swept, rtol):
    for friction, solution in zip(swept.friction, swept.solutions, strict=True):
        other = solve(with_numbers(swept.scene, {"friction": friction}), rtol=rtol)
        assert solution.scene == other.scene
        assert solution.status == other.status
        if other.status == "converged":
            difference = edge_difference(solution, other)
            assert difference is not None, (friction, solution.zones, other.zones)
            assert difference <= solution.error_estimate + other.error_estimate
            assert solution.error_estimate <= rtol


def check_one(first, rtol, strict=1e-10):
    """Edges and slip rate at the contact edge are off by no more than is estimated; the truth."""
    exact = solve(first.scene, rtol=strict)
    difference = edge_difference(first, exact)
    assert difference is not None, (first, exact)
    assert difference <= first.error_estimate <= rtol
    rate = np.abs(first.edge_slip_rate - exact.edge_slip_rate)
    assert rate <= first.error_estimate * max(1.0, abs(exact.edge_slip_rate))
    return exact
