"""Fields in the bodies after a march, compared with those of the self-similar solver."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic import Scene, solve
from semianalytic.scene.given.named import NAMED_SCENES

Array = NDArray[np.float64]

GRIDS = (64, 128, 256, 512, 1024)
SCENES = ("preloaded", "remote-shock", "auxetic", "antiplane")
POINTS = 300
"""Number of random points in both bodies, within 1.1 times the reach of the waves."""
QUANTITIES = ("velocity", "stress", "displacement")


@dataclass(frozen=True)
class FieldRow:
    """L1 errors of whole fields over their change, and the observed order of stress."""

    scene: str
    nodes: int
    velocity: float
    stress: float
    displacement: float
    order: float


def fields() -> list[FieldRow]:
    """Measure the errors at T = 1 by nodes."""
    rows = []
    for name in SCENES:
        scene, before = NAMED_SCENES[name].scene, math.nan
        for nodes in GRIDS:
            velocity, stress, displacement = field_errors(scene, nodes)
            order = math.log2(before / stress)
            rows.append(FieldRow(name, nodes, velocity, stress, displacement, order))
            before = stress
    return rows


def field_errors(scene: Scene, nodes: int, points: int = POINTS) -> list[float]:
    """Return errors of velocity, stress and displacement where the exact fields are finite."""
    end = 1 / scene.material.shear_speed
    marched, exact = (
        solve(scene, method="space-time", end_time=end, nodes=nodes, companion=False),
        solve(scene),
    )
    reach = 1.1 * scene.fastest_speed * end
    at = *np.random.default_rng(1).uniform(-reach, reach, (2, points)), end
    errors = []
    for name in QUANTITIES:
        true, rest = getattr(exact, name)(*at), getattr(exact, name)(*at[:2], 0.0)
        off, change = np.abs(getattr(marched, name)(*at) - true), np.abs(true - rest)
        known = np.isfinite(change).all(axis=0)
        errors.append(float(off[:, known].sum() / change[:, known].sum()))
    return errors
