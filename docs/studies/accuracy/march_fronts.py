"""Marches of waves at an angle and moving loads against their exact answers, by nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from semianalytic import IncidentWave, Material, MovingLoad, Scene, Tractions, solve
from semianalytic.scene.given.named import NAMED_SCENES

GRIDS = (128, 256, 512, 1024)
TIMES = (0.7, 0.8, 0.9, 1.0)
_SOLID, _PRESSED = Material(1.0, 1.0, 1 / 3), Tractions(1.0, 0.0)
SCENES = {
    "SV, −20°": NAMED_SCENES["incident-sv"].scene,
    "SV, 18°": Scene(_SOLID, 0.4, Tractions(1.0, -0.1), IncidentWave("SV", 18.0, stress=-0.3)),
    "SH, −40°": Scene(_SOLID, 0.5, _PRESSED, IncidentWave("SH", -40.0, 0.4), mode="antiplane"),
    "load, 4 c_t": Scene(_SOLID, 1.8, _PRESSED, MovingLoad(4.0, 0.0, 1.0)),
    "load, 0.8 c_t": Scene(_SOLID, 0.3, _PRESSED, MovingLoad(0.8, 0.3, 1.0)),
    "load, −4 c_t": Scene(_SOLID, 0.4, _PRESSED, MovingLoad(-4.0, 0.0, 0.6)),
    "remote-shock": NAMED_SCENES["remote-shock"].scene,
}
"""Scenes by the name of their load; the last comes everywhere at once."""


@dataclass(frozen=True)
class FrontRow:
    """L1 errors of a scene on one grid, the mean over `TIMES`, and orders since the grid before."""

    scene: str
    slowness: float
    nodes: int
    slip_rate: float
    order: float
    shear_traction: float
    pressure: float
    estimate: float


def fronts() -> list[FrontRow]:
    """Measure errors against the self-similar solver, by nodes."""
    rows = []
    for name, scene in SCENES.items():
        exact, before = solve(scene), math.nan
        for nodes in GRIDS:
            marched = solve(scene, method="space-time", end_time=1.0, nodes=nodes)
            errors = []
            for quantity in ("slip_rate", "shear_traction", "pressure"):
                off, size = 0.0, 0.0
                for t in TIMES:
                    x = marched.grid.x[(marched.grid.x > 0.02 * t) & (marched.grid.x < 1.9 * t)]
                    right = getattr(exact, quantity)(x, t)
                    off += float(np.abs(getattr(marched, quantity)(x, t) - right).sum())
                    size += float(np.abs(right).sum())
                errors.append(off / size)
            rate, shear, pressure = errors
            order = math.log2(before / rate)
            sizes = rate, order, shear, pressure, marched.error_estimate
            rows.append(FrontRow(name, scene.front_slowness, nodes, *sizes))
            before = rate
    return rows
