"""Error estimates of derivatives bound their errors, in any unit; and what a derivative costs."""

from time import perf_counter

import numpy as np
import pytest
from catalogue import PRELOADED, SHOCK, unit_scene
from laws import random_scenes

from semianalytic import solve
from semianalytic.selfsimilar.derivatives.parameters import parameter
from tests.semianalytic.selfsimilar.derivatives.test_derivative import (
    NAMES,
    TRACTIONS,
    clear_positions,
    edges_of,
    unpressed,
)


def error_over_size(derivative, exact, right):
    """Return the error of fields and edges over their size, as `error_estimate` is meant."""
    x, worst = clear_positions(exact), []
    size = abs(parameter(exact.scene, right.name))
    if not size:
        size = exact.stress_unit if right.name in TRACTIONS else 1.0
    speed = exact.scene.material.shear_speed
    pairs = [(edges_of(derivative), edges_of(right), speed / size)]
    for field in ("slip_rate", "slip", "shear_traction"):
        expected = getattr(right, field)(x, 1.0)
        least = np.abs(getattr(exact, field)(x, 1.0)).max() / size
        pairs.append((getattr(derivative, field)(x, 1.0), expected, least))
    for found, expected, least in pairs:
        finite = np.isfinite(expected)
        error = np.abs(found[finite] - expected[finite]).max(initial=0.0)
        worst.append(error / max(np.abs(expected[finite]).max(initial=0.0), least, 1e-300))
    return max(worst)


@pytest.mark.thinned(10)
@pytest.mark.parametrize("rtol", [1e-5, 1e-8])
@pytest.mark.parametrize("name", ["friction", "load_shear", "poisson_ratio"])
def test_error_estimates_bound_errors(name, rtol):
    for scene in (PRELOADED, SHOCK, unit_scene(0.2, (1.0, -0.19), (0.5, 0.6))):
        exact, solution = solve(scene, rtol=1e-11), solve(scene, rtol=rtol)
        right, derivative = exact.derivative(name), solution.derivative(name)
        assert error_over_size(derivative, exact, right) <= derivative.error_estimate


@pytest.mark.slow
def test_error_estimates_bound_errors_in_random_scenes():
    """At several accuracies, and not by much too much."""
    shares = []
    for index, exact in enumerate(random_scenes(60)):
        name = NAMES[index % len(NAMES)]
        if unpressed(exact.scene, name):
            continue
        solution = solve(exact.scene, rtol=10.0 ** -(4 + index % 5))
        if [zone.sense for zone in solution.zones] != [zone.sense for zone in exact.zones]:
            continue  # slip is missed, which only the estimate of the solution counts
        derivative = solution.derivative(name)
        error = error_over_size(derivative, exact, exact.derivative(name))
        assert error <= derivative.error_estimate, (name, exact.scene)
        shares.append(derivative.error_estimate / max(error, 1e-11))
    assert np.median(shares) < 100  # 20, of which 5 are `SAFETY`
    assert len(shares) >= 45


@pytest.mark.thinned(12)
@pytest.mark.parametrize("scale", [1e-6, 1e7])
@pytest.mark.parametrize("name", ["base_pressure", "load_shear", "base_shear"])
@pytest.mark.parametrize(("base", "load"), [((1.0, 0.0), (0.0, 1.0)), ((0.36, 0.0), (27.0, -0.42))])
def test_error_estimates_are_the_same_in_any_unit_of_stress(name, scale, base, load):
    """By a traction that is 0, too, and beside a pressure far larger than it."""
    here = unit_scene(0.5, base, load)
    there = unit_scene(0.5, np.multiply(scale, base), np.multiply(scale, load))
    first, other = (solve(scene, rtol=1e-6).derivative(name) for scene in (here, there))
    assert other.error_estimate == pytest.approx(first.error_estimate, rel=0.3, abs=2e-10)


def seconds(function):
    """The least of five, in turns with nothing."""
    best = np.inf
    for _ in range(5):
        start = perf_counter()
        function()
        best = min(best, perf_counter() - start)
    return best


@pytest.mark.slow
def test_a_derivative_costs_about_a_solution():
    """By tractions or friction, over scenes of several kinds; 0.8 on a quiet machine."""
    solving = deriving = 0.0
    for scene in (PRELOADED, SHOCK, unit_scene(0.1), unit_scene(0.2, (1.0, -0.19), (0.5, 0.6))):
        solving += seconds(lambda scene=scene: solve(scene))
        fresh = iter([solve(scene) for _ in range(5)])  # which share no Jacobian
        deriving += seconds(lambda fresh=fresh: next(fresh).derivative("friction"))
    assert deriving < 1.5 * solving
