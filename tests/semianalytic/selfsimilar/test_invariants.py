"""Physics that must hold in every scene: Coulomb, dissipation, causality, self-similarity."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from laws import check_invariants, random_scenes, scenes

from semianalytic import solve
from tests.semianalytic.selfsimilar.test_separation import errors


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
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
