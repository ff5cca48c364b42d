"""Physics that must hold in every scene: Coulomb, dissipation, causality, self-similarity."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from laws import check_invariants, random_scenes, scenes

from semianalytic import solve


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_coulomb_dissipation_causality_and_self_similarity(scene):
    check_invariants(scene)


@pytest.mark.slow
@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_invariants_in_two_hundred_scenes(scene):
    check_invariants(scene)


CLEAR = 0.03
"""Distance from zone edges and c_R, over c_t, beyond which the estimate holds at every point."""


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
            assert max(pointwise_errors(solution, exact)) <= bound, exact.scene
            for name, integral in errors_of_integrals(solution, exact).items():
                assert integral <= bound, (name, exact.scene)


def pointwise_errors(solution, exact):
    """Largest errors of slip rate and shear traction away from zone edges and c_R."""
    material = exact.scene.material
    edges = exact.edge_speeds[np.isfinite(exact.edge_speeds)]
    marks = np.array([material.rayleigh_speed, *edges[edges > 0]])
    steps = CLEAR * np.array([1.0, 1.1, 1.5, 3.0])
    x = np.linspace(0.002, 1.1 * material.longitudinal_speed, 300)
    x = np.concatenate([x, (marks[:, None] + steps).ravel(), (marks[:, None] - steps).ravel()])
    x = x[(x > 0) & (np.abs(x[:, None] - marks).min(axis=1) >= 0.999 * CLEAR)]
    rate, traction = exact.slip_rate(x, 1.0), exact.shear_traction(x, 1.0)
    rates = np.abs(solution.slip_rate(x, 1.0) - rate) / max(np.abs(rate).max(), 1e-300)
    tractions = np.abs(solution.shear_traction(x, 1.0) - traction)
    return rates.max(), (tractions / (exact.stress_unit + np.abs(traction))).max()


def errors_of_integrals(solution, exact):
    """Errors of what is integrated over the contact or over time, and of the state of its edge."""
    x = np.concatenate([np.geomspace(1e-3, 0.05, 4), np.linspace(0.06, 2.2, 40)])
    power = float(exact.frictional_power(1.0))
    errors = {"power": 0.0}
    if np.isfinite(power) and power:
        errors["power"] = abs(float(solution.frictional_power(1.0)) / power - 1)
        part = solution.frictional_power(1.0, x) - exact.frictional_power(1.0, x)
        errors["power of a part"] = np.abs(part).max() / power
    for name in ("slip", "path", "work_density"):
        wanted, found = (getattr(one, name)(x, 1.0) for one in (exact, solution))
        errors[name] = np.abs(found - wanted).max() / max(np.abs(wanted).max(), 1e-300)
    for name in ("max_slip", "accumulated_slip"):
        wanted, found = (float(getattr(one, name)(1.0)) for one in (exact, solution))
        if np.isfinite(wanted):
            errors[name] = abs(found - wanted) / max(wanted, 1e-300)
    wanted, found = exact.edge_slip_rate, solution.edge_slip_rate
    errors["edge slip rate"] = abs(found - wanted) / max(abs(wanted), 1e-300)
    wanted, found = exact.stress_intensity(1.0)[1], solution.stress_intensity(1.0)[1]
    errors["stress intensity"] = abs(found - wanted) / max(abs(wanted), 1e-300)
    return errors


def test_error_estimates_bound_errors_in_random_scenes():
    check_estimates(6, thorough=1)


@pytest.mark.slow
def test_error_estimates_bound_errors_in_a_hundred_scenes():
    check_estimates(100, thorough=25)
