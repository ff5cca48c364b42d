"""Classification of solutions by slip regime, and the friction above which nothing slips."""

from __future__ import annotations

import math
from typing import Literal

from semianalytic.regimes.thresholds import edge_threshold_alone, front_threshold_stuck
from semianalytic.selfsimilar.solution import Solution

Regime = Literal["stuck", "slow", "front", "two", "one", "everywhere", "reverse", "failed"]


def regime(solution: Solution) -> Regime:
    """Return the slip regime of a solution, in one word.

    Slip counts as reverse if it opposes the shear of the load.

    Returns
    -------
    str
        "stuck"; "slow", one zone slower than the Rayleigh wave; "front", slip around the shear
        front with the contact edge stuck; "two", a slow zone and one around the shear front;
        "one", a zone that covers c_R (its stick gap there under 1e-14); "everywhere"; "reverse";
        "failed" unless the status of the solution is "converged".  In antiplane shear the shear
        wave stands for the Rayleigh wave.
    """
    if solution.status != "converged":
        return "failed"
    scene = solution.scene
    held, load = scene.superposition
    forward = math.copysign(1, load.shear or held.shear)
    if any(zone.sense != forward for zone in solution.zones):
        return "reverse"
    if not solution.zones:
        return "stuck"
    if math.isinf(solution.zones[-1].outer):
        return "everywhere"
    material = scene.material
    rayleigh = material.shear_speed if scene.antiplane else material.rayleigh_speed
    if any(zone.inner < rayleigh < zone.outer for zone in solution.zones):
        return "one"
    if solution.zones[0].inner > 0:
        return "front"
    return "slow" if len(solution.zones) == 1 else "two"


def stuck_threshold(poisson_ratio: float) -> float:
    """Return the friction f P_0/Q_0 above which a remotely loaded interface is fully stuck."""
    return max(edge_threshold_alone(poisson_ratio), front_threshold_stuck(poisson_ratio))
