"""The map of regimes around a scene: modes of slip at other Poisson ratios and frictions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from compare.comparison.scales import stress_scale
from semianalytic import Scene, Solution, TensionError, Tractions, solve
from semianalytic.parameters.overriding import override_scene
from semianalytic.regimes import regime
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.sweeps.sweep import sweep

REGIMES = {
    "stuck": "stuck",
    "slow": "slower than c_R",
    "front": "at the shear wave",
    "two": "two zones",
    "one": "one zone past c_R",
    "everywhere": "everywhere",
    "reverse": "some reverse slip",
    "open": "opens",
    "failed": "no answer",
}
"""Descriptions of regimes by name; maps store the index of a regime in this order."""

SIZE, SIZE_ONE_BY_ONE = 24, 12
"""Cells along each side of a map, and of a map whose scenes are solved one by one."""
POISSON_RATIOS = (-0.9, 0.48)
RTOL = 1e-4

Progress = Callable[[int, int], object]


@dataclass(frozen=True, eq=False)
class RegimeMap:
    """Indices of `REGIMES`, (ratios, frictions), and the ranges of both."""

    image: Array
    poisson_ratio: tuple[float, float]
    friction: tuple[float, float]


def map_key(scene: Scene) -> tuple[object, ...]:
    """Return all that a map depends on: the scene without Poisson ratio and friction, scaled."""
    stress = stress_scale(scene)
    tractions = [value for part in scene.superposition for value in (part.pressure, part.shear)]
    shares = tuple(round(traction / stress, 9) for traction in tractions)
    front = None if isinstance(scene.load, Tractions) else scene.load
    return (*shares, front, scene.mode, scene.law.with_coefficient(1.0))


def highest_friction(scene: Scene) -> float:
    """Return the largest friction of the map of a scene."""
    return float(max(1, math.ceil(1.5 * scene.coefficient)))


def can_map(scene: Scene) -> bool:
    """Return whether the map of a scene takes seconds, not minutes."""
    alike = scene.lower_material is None
    return alike and scene.is_self_similar and scene.law.fall_with_rate == 0


def regime_map(scene: Scene, progress: Progress) -> RegimeMap:
    """Map the regimes of a self-similar scene over Poisson ratio and friction, a column at a time.

    Its own Poisson ratio and friction do not matter; `progress` gets the numbers of finished
    columns and of all columns.
    """
    swept = isinstance(scene.friction, float)
    size = SIZE if swept else SIZE_ONE_BY_ONE
    highest = highest_friction(scene)
    friction, ratios = _middles((0.0, highest), size), _middles(POISSON_RATIOS, size)
    names = list(REGIMES)
    image = np.full((size, size), float(names.index("failed")))
    for row, ratio in enumerate(ratios):
        at = override_scene(scene, poisson_ratio=float(ratio))
        there = [i for i, value in enumerate(friction) if _exists(at, float(value))]
        for i, word in zip(there, _words(at, friction[there], swept), strict=True):
            image[row, i] = names.index(word)
        progress(row + 1, size)
    return RegimeMap(image, POISSON_RATIOS, (0.0, highest))


def _middles(ends: tuple[float, float], count: int) -> Array:
    return ends[0] + (ends[1] - ends[0]) * (np.arange(count) + 0.5) / count


def _exists(scene: Scene, friction: float) -> bool:
    try:
        _under(scene, friction).check_self_similar()
    except SceneError:
        return False
    return True


def _under(scene: Scene, friction: float) -> Scene:
    """Return a scene with another friction coefficient at rest."""
    return replace(scene, friction=scene.law.with_coefficient(friction))


def _words(scene: Scene, friction: Array, swept: bool) -> list[str]:
    """Return the names of the regimes at several frictions."""
    try:
        if swept:
            return [_word(solution) for solution in sweep(scene, friction, RTOL)]
        return [_word(solve(_under(scene, float(value)), rtol=RTOL)) for value in friction]
    except TensionError:
        return ["failed"] * len(friction)


def _word(solution: Solution) -> str:
    if solution.status == "converged" and solution.openings:
        return "open"
    return regime(solution)
