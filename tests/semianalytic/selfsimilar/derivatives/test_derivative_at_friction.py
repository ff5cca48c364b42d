"""Derivatives of bases at friction, and of ones that lack so little that differences do not see."""

from typing import Any

import numpy as np
import pytest
from catalogue import unit_scene
from test_derivative_homogeneity import check_scaling

from semianalytic import ViscousFriction, solve

X = np.array([0.05, 0.3, 0.9, 1.2])
STEP = 1e-4
# friction, load, and what else a scene says; the first and the last two open beside slip
SCENES: list[tuple[float, tuple[float, float], dict[str, Any]]] = [
    (1.3186, (24.54, 1.2), {"nu": 0.45}),
    (0.3, (0.5, 1.0), {}),
    (0.6, (0.5, 0.4), {"mode": "antiplane"}),
    (0.3, (0.5, 1.0), {"friction_law": ViscousFriction(0.2)}),
    (0.4, (1.2, -1.0), {"nu": 0.0}),
    (0.3, (50.0, 25.0), {"friction_law": ViscousFriction(0.4)}),
]


@pytest.mark.thinned(18)
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


# friction, base pressure, load, and what else; all open, and slip starts at the longitudinal front
OPENINGS: list[tuple[float, float, tuple[float, float], dict[str, Any]]] = [
    (6.4187, 0.056, (1.0, -0.0206), {"nu": -0.37966}),
    (0.5, 0.1, (-1.0, 0.3), {}),
    (0.3, 0.02, (1.0, 0.5), {}),
    (0.3, 0.02, (1.0, 0.5), {"friction_law": ViscousFriction(0.4)}),
    (0.3, 0.02, (1.0, 0.5), {"friction_law": ViscousFriction(0.4), "mode": "antiplane"}),
]


@pytest.mark.thinned(6)
@pytest.mark.parametrize(("friction", "pressure", "load", "parts"), OPENINGS)
def test_derivative_by_a_base_pressure_at_friction_knows_that_the_opening_moves(
    friction: float, pressure: float, load: tuple[float, float], parts: dict[str, Any]
) -> None:
    """A larger base pressure makes the base stick; a difference to that side is of second order."""
    base_shear = friction * pressure
    step = STEP * pressure

    def rates(more: float) -> np.ndarray:
        scene = unit_scene(friction, (pressure + more, base_shear), load, **parts)
        return solve(scene, rtol=1e-11).slip_rate(X, 1.0)

    solution = solve(unit_scene(friction, (pressure, base_shear), load, **parts), rtol=1e-9)
    assert solution.openings
    derivative = solution.derivative("base_pressure")
    difference = -(3 * rates(0.0) - 4 * rates(step) + rates(2 * step)) / (2 * step)
    away = np.abs(derivative.slip_rate(X, 1.0) - difference).max()
    assert away < 1e-4 * np.abs(difference).max()
    assert derivative.error_estimate < 1e-6


@pytest.mark.thinned(8)
@pytest.mark.parametrize(("friction", "pressure", "load", "parts"), OPENINGS)
def test_derivatives_scale_where_a_base_at_friction_opens(
    friction: float, pressure: float, load: tuple[float, float], parts: dict[str, Any]
) -> None:
    """The base stays at friction where all tractions double, whichever side each derivative is
    of."""
    scene = unit_scene(friction, (pressure, friction * pressure), load, **parts)
    check_scaling(solve(scene, rtol=1e-8))
