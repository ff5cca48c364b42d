"""Derivatives of bases at friction, and of ones that lack so little that differences do not see."""

from typing import Any

import numpy as np
import pytest
from catalogue import unit_scene

from semianalytic import ViscousFriction, solve

X = np.array([0.05, 0.3, 0.9, 1.2])
STEP = 1e-4
# friction, load, and what else a scene says; the first and the last open beside slip
SCENES: list[tuple[float, tuple[float, float], dict[str, Any]]] = [
    (1.3186, (24.54, 1.2), {"nu": 0.45}),
    (0.3, (0.5, 1.0), {}),
    (0.6, (0.5, 0.4), {"mode": "antiplane"}),
    (0.3, (0.5, 1.0), {"friction_law": ViscousFriction(0.2)}),
    (0.4, (1.2, -1.0), {"nu": 0.0}),
]


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("friction", "load", "parts"), SCENES)
@pytest.mark.parametrize("lacking", [0.0, 3e-9, 1e-7])
def test_derivative_is_the_difference_to_one_side(
    friction: float, load: tuple[float, float], parts: dict[str, Any], lacking: float
) -> None:
    """By base shear, towards stick; differences of second order are off by 1e-5 or less."""

    def rates(step: float) -> np.ndarray:
        base = (1.0, friction * (1 - lacking) - step)
        return solve(unit_scene(friction, base, load, **parts), rtol=1e-11).slip_rate(X, 1.0)

    derivative = solve(
        unit_scene(friction, (1.0, friction * (1 - lacking)), load, **parts), rtol=1e-9
    ).derivative("base_shear")
    difference = (3 * rates(0.0) - 4 * rates(STEP) + rates(2 * STEP)) / (2 * STEP)
    away = np.abs(derivative.slip_rate(X, 1.0) - difference).max()
    assert away < 3e-5 * np.abs(difference).max()
    assert derivative.error_estimate < 1e-7
