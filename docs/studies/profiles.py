"""Errors of simulated and marched slip-rate profiles against exact ones, for several studies."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import in_profile, norm, relative_error
from fem import Simulation
from semianalytic import Marched, Scene, Solution, solve

Array = NDArray[np.float64]

LENGTH = 2.0
"""Length of the observed contact [length] until t = 1/c_t = 1."""

PROFILE = np.linspace(0.02, 1.9, 3761)
"""Velocities x / (c_t t) at which profiles are compared."""

AVERAGED = 0.6
"""Self-similar profiles are averaged over times from this fraction of T to T."""


def last_profile(simulation: Simulation) -> Array:
    """Return the final slip rate at the velocities `PROFILE`, interpolated between nodes."""
    return _sampled(simulation, -1)


def averaged_profile(simulation: Simulation) -> Array:
    """Return the slip rate averaged over x/t in the last 40 % of the time, at `PROFILE`."""
    t = simulation.interface.t
    rows = np.flatnonzero(t >= AVERAGED * t[-1]).tolist()
    return np.mean([_sampled(simulation, row) for row in rows], axis=0)


def profile_errors(solution: Solution, last: Array, averaged: Array) -> dict[str, float]:
    """Return the errors of two profiles at the velocities `PROFILE`: relative L1 errors, and those
    of the averaged one where the exact slip rate of the first and the second zone is largest.

    These are over the exact value there, the last one over the largest of all; nan if there is no
    such zone.
    """
    speed = solution.scene.material.shear_speed
    exact = solution.slip_rate(PROFILE * speed, 1.0)
    peaks = []
    for zone in solution.zones:
        inside = (PROFILE * speed > zone.inner) & (PROFILE * speed < zone.outer)
        peaks.append(int(np.argmax(np.where(inside, np.abs(exact), 0.0))))
    at_peak = [float(averaged[peak] - exact[peak]) for peak in peaks]
    relative = [error / exact[peak] for error, peak in zip(at_peak, peaks, strict=True)]
    return {
        "last": norm(last - exact, PROFILE, 1) / norm(exact, PROFILE, 1),
        "averaged": norm(averaged - exact, PROFILE, 1) / norm(exact, PROFILE, 1),
        "first_peak": relative[0] if peaks else math.nan,
        "second_peak": relative[1] if len(peaks) > 1 else math.nan,
        "second_over_largest": at_peak[1] / np.abs(exact).max() if len(peaks) > 1 else math.nan,
    }


def _sampled(simulation: Simulation, row: int) -> Array:
    history = simulation.interface
    place = PROFILE * simulation.scene.material.shear_speed * history.t[row]
    return np.interp(place, history.x, history.slip_rate[row])


def step_error(scene: Scene, marched: Marched) -> float:
    """Return the relative L1 error of the final slip rate on 0.02 < x/(c_t t) < 1.9."""
    x, end = marched.grid.x, marched.end_time
    seen = in_profile(x / (end * scene.material.shear_speed))
    exact = _exact(scene).slip_rate(x[seen], end)
    return relative_error(marched.interface.slip_rate[-1, seen], exact, x[seen], 1)


@lru_cache(maxsize=4)
def _exact(scene: Scene) -> Solution:
    return solve(scene, rtol=1e-9)


def last_march(scene: Scene, nodes: int, **options: float) -> Marched:
    """March a scene and keep only the last level; like all marches here, it has no companion."""
    given: dict[str, Any] = {"length": LENGTH, "every": 10**9, "companion": False, **options}
    return solve(scene, method="space-time", nodes=nodes, **given)
