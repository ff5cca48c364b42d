"""Every scene of the catalogue, and random ones: what each solver says of it, the physics that must
hold (Coulomb, dissipation, causality, self-similarity), and whether its error is honest."""

import dataclasses

import numpy as np
import pytest
from catalogue import PROBLEMS, STEEL, over, under
from hypothesis import HealthCheck, given, settings
from laws import check_invariants, random_scenes, scenes

from semianalytic import Coulomb, SceneError, TensionError, Tractions
from semianalytic.engine.march import march
from semianalytic.selfsimilar.solver import solve
from tests.semianalytic.selfsimilar.test_separation import errors


def test_names_are_unique():
    assert len({problem.name for problem in PROBLEMS}) == len(PROBLEMS)


@pytest.mark.thinned(2)
@over("exact")
def test_zones_are_the_known_ones(problem):
    solution = solve(problem.scene)
    assert solution.status == "converged"
    assert tuple(zone.sense for zone in solution.zones) == problem.senses


@pytest.mark.thinned(2)
@over("exact")
def test_laws_hold(problem):
    check_invariants(problem.scene)


@over("rated")
def test_laws_hold_where_strength_follows_slip_rate(problem):
    check_invariants(problem.scene)


@pytest.mark.thinned(8)
@over("exact")
def test_error_is_honest(problem):
    fine = solve(problem.scene, rtol=1e-11)
    assert fine.status == "converged"
    speed = fine.scene.material.shear_speed
    x = np.linspace(0.02, 1.95, 300)
    scale = np.abs(fine.slip_rate(x * speed, 1.0)).max()
    fronts = [1.0, fine.scene.material.rayleigh_speed / speed]
    fronts += [v / speed for v in fine.edge_speeds.ravel()]
    # The logarithm at c_R and the square roots at edges amplify a shift of the edge; the
    # estimate is for the slip rate away from them by more than the shift itself.
    x = x[np.min(np.abs(x[:, None] - np.array(fronts)), axis=1) > 0.01] * speed
    for rtol in (1e-3, 1e-5, 1e-8):
        solution = solve(problem.scene, rtol=rtol)
        assert solution.status == "converged"
        assert solution.error_estimate <= rtol
        assert tuple(zone.sense for zone in solution.zones) == problem.senses
        finite = np.isfinite(fine.edge_speeds)
        shift = np.abs(solution.edge_speeds[finite] - fine.edge_speeds[finite]) / speed
        assert shift.max(initial=0.0) <= solution.error_estimate
        error = np.abs(solution.slip_rate(x, 1.0) - fine.slip_rate(x, 1.0)).max()
        assert error <= solution.error_estimate * scale


@pytest.mark.thinned(3)
@over("exact")
def test_mirrored_tractions_mirror_slip(problem):
    scene = problem.scene
    base, load = (Tractions(pair.pressure, -pair.shear) for pair in (scene.base, scene.load))
    solution, mirrored = solve(scene), solve(dataclasses.replace(scene, base=base, load=load))
    np.testing.assert_array_equal(solution.edge_speeds, mirrored.edge_speeds)
    assert tuple(-zone.sense for zone in mirrored.zones) == problem.senses
    x = np.linspace(0.02, 1.95, 50) * scene.material.shear_speed
    np.testing.assert_array_equal(solution.slip_rate(x, 1.0), -mirrored.slip_rate(x, 1.0))


@pytest.mark.thinned(3)
@over("exact", without="SI")
def test_units_do_not_matter(problem):
    """Steel of the same Poisson ratio under MPa, millisecond for second."""
    scene, stress, time = problem.scene, 3e6, 1e-3
    material = dataclasses.replace(STEEL, poisson_ratio=scene.material.poisson_ratio)
    base, load = (
        Tractions(stress * pair.pressure, stress * pair.shear) for pair in (scene.base, scene.load)
    )
    law, speed = scene.law, material.shear_speed
    if isinstance(law, Coulomb):
        law = Coulomb(1.0, viscosity=law.viscosity * material.shear_impedance)
    there = under(dataclasses.replace(scene, material=material, base=base, load=load), law)
    solution, other = solve(scene), solve(there)
    np.testing.assert_allclose(other.edge_speeds, solution.edge_speeds * speed, rtol=1e-7)
    x = np.linspace(0.02, 1.95, 50)
    clear = np.abs(x[:, None] - np.append(solution.edge_speeds, 9.0)).min(axis=1) > 0.01
    x = x[clear]
    rate = stress / material.shear_impedance
    for name, unit in (("slip_rate", rate), ("slip", rate * time), ("shear_traction", stress)):
        expected = getattr(solution, name)(x, 1.0)
        in_units = getattr(other, name)(x * speed * time, time) / unit
        size = np.abs(expected).max(initial=1e-300)
        np.testing.assert_allclose(in_units, expected, atol=1e-7 * size, err_msg=name)


@pytest.mark.thinned(6)
@over("exact", "witness")
def test_march_agrees(problem):
    scene = problem.scene
    marched = march(scene, nodes=400)
    assert marched.status == "resolved"
    x = marched.interface.x
    seen = (x > 0.02) & (x < 1.9)
    exact = solve(scene).slip_rate(x[seen], 1.0)
    error = np.abs(marched.interface.slip_rate[-1, seen] - exact).sum()
    assert error <= 0.01 * np.abs(exact).sum()


@pytest.mark.thinned(3)
@over("march")
def test_what_is_not_self_similar_is_refused_and_marched(problem):
    with pytest.raises(SceneError, match="space-time"):
        solve(problem.scene)
    marched = march(problem.scene, nodes=400)
    assert marched.status == "resolved"
    strength = problem.scene.coefficient * marched.interface.pressure
    assert np.all(np.abs(marched.interface.shear_traction) <= strength * (1 + 2e-3))
    assert np.abs(marched.interface.slip).max() > 0


@over("opens")
def test_a_contact_that_opens_is_solved_and_not_marched(problem):
    solution = solve(problem.scene)
    assert solution.status == "converged"
    assert len(solution.openings) == 1
    with pytest.raises(TensionError):
        march(problem.scene, nodes=100)


# --- random scenes --------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_coulomb_dissipation_causality_and_self_similarity(scene):
    check_invariants(scene)


@pytest.mark.slow
@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_invariants_in_two_hundred_scenes(scene):
    check_invariants(scene)


def check_estimates(count, thorough):
    """Senses in which `Solution.error_estimate` is documented to bound an error.

    Edges and slip rate in L1; of the first scenes also those at every point and of integrals.
    """
    x = np.linspace(0.01, 2.2, 400)
    for index, exact in enumerate(random_scenes(count)):
        rate = exact.slip_rate(x, 1.0)
        for rtol in (1e-3, 1e-6, 1e-9):
            solution = solve(exact.scene, rtol=rtol)
            assert solution.status == "converged", exact.scene
            error = np.abs(solution.slip_rate(x, 1.0) - rate).sum() / max(
                np.abs(rate).sum(), 1e-300
            )
            if len(solution.zones) == len(exact.zones):  # else one that hardly slips is missing
                edges = np.abs(solution.edge_speeds - exact.edge_speeds)
                error = max(error, edges[np.isfinite(edges)].max(initial=0.0))
            assert error <= solution.error_estimate <= rtol, exact.scene
            if index >= thorough:
                continue
            bound = solution.error_estimate + exact.error_estimate
            for name, each in errors(solution, exact).items():
                assert each <= bound, (name, exact.scene)


def test_error_estimates_bound_errors_in_random_scenes():
    check_estimates(6, thorough=1)


@pytest.mark.slow
def test_error_estimates_bound_errors_in_a_hundred_scenes():
    check_estimates(100, thorough=25)
