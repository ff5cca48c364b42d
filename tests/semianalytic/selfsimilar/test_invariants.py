"""Physics that must hold in every scene: Coulomb, dissipation, causality, self-similarity."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from semianalytic import Material, Scene, SceneError, Tractions, solve


@st.composite
def scenes(draw):
    """Admissible scenes: preload and shear step, remote shock, or any base and step."""
    number = st.floats(-2, 2).map(lambda value: round(value, 3))
    poisson_ratio = draw(st.floats(-0.9, 0.49).map(lambda value: round(value, 3)))
    friction = round(10 ** draw(st.floats(-2, 0.5)), 4)
    kind = draw(st.sampled_from(["shear step", "remote shock", "any"]))
    shear = draw(number.filter(lambda value: value != 0))
    if kind == "shear step":
        base, step = Tractions(1.0, 0.0), Tractions(0.0, shear)
    elif kind == "remote shock":
        base = step = Tractions(1.0, shear)
    else:
        share = draw(st.floats(-0.99, 0.99).map(lambda value: round(value, 3)))
        base = Tractions(1.0, share * friction)
        step = Tractions(abs(draw(number)), shear)
    return Scene(Material(1.0, 1.0, poisson_ratio), friction, base, step)


# Positions over all velocities, denser towards the edge.
XI = np.concatenate([np.geomspace(1e-3, 0.05, 12), np.linspace(0.06, 1.99, 120)])


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_coulomb_dissipation_causality_and_self_similarity(scene):
    check_invariants(scene)


@pytest.mark.slow
@settings(max_examples=1000, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_invariants_in_a_thousand_scenes(scene):
    check_invariants(scene)


def check_invariants(scene):
    try:
        solution = solve(scene)
    except SceneError:
        return  # tension: refused, as it must be
    if solution.status != "converged":
        # Allowed only next to a threshold, where a zone is about to close at the contact edge.
        assert solution.zones[0].inner == 0
        assert solution.zones[0].outer < 0.01
        return
    rate, traction = solution.slip_rate(XI, 1.0), solution.shear_traction(XI, 1.0)
    strength = scene.friction * solution.pressure(XI, 1.0)
    largest = max(np.abs(rate).max(), abs(solution.edge_slip_rate), 1e-300)
    load = solution.stress
    slips = np.zeros(len(XI), dtype=bool)
    for zone in solution.zones:
        slips |= (zone.inner < XI) & (zone.outer > XI)
    tolerance = 100 * solution.error_estimate
    # Coulomb's law at every point
    assert np.all(np.abs(traction) <= strength + tolerance * (load + strength))
    assert np.all(rate[~slips] == 0)
    assert np.all(traction * rate >= -tolerance * largest * (load + strength))
    sliding = slips & (np.abs(rate) > tolerance * largest)
    np.testing.assert_allclose(
        np.abs(traction[sliding]), strength[sliding], rtol=0, atol=tolerance * load
    )
    # Causality
    ahead = np.array([1.001, 2.0]) * scene.material.longitudinal_speed
    np.testing.assert_allclose(solution.slip_rate(ahead, 1.0), scene.far_slip_rate, rtol=1e-15)
    assert np.all(solution.pressure(ahead, 1.0) == scene.base.pressure)
    # Self-similarity, to the rounding of t/x
    np.testing.assert_allclose(
        solution.shear_traction(3 * XI, 3.0), traction, rtol=1e-9, atol=1e-9 * load
    )


def random_scenes(count, rtol=1e-12):
    """Scenes of any load, a third of them with a base at friction; always the same ones."""
    random = np.random.default_rng(11)
    while count:
        nu = float(random.choice([1 / 3, 0.25, 0.0, 0.45, -0.5, random.uniform(-0.9, 0.49)]))
        friction = float(np.exp(random.uniform(np.log(0.02), np.log(3))))
        base = float(random.choice([0, 1, random.lognormal()]))
        share = float(random.choice([0, random.uniform(-1, 1), 1.0]))
        step = Tractions(float(random.choice([0, 1, random.lognormal()])), float(random.normal()))
        scene = Scene(
            Material(1.0, 1.0, nu), friction, Tractions(base, share * friction * base), step
        )
        try:
            exact = solve(scene, rtol=rtol)
        except SceneError:
            continue  # tension
        if exact.status == "converged":  # rounding may not leave twelve digits
            count -= 1
            yield exact


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
    return rates.max(), (tractions / (exact.stress + np.abs(traction))).max()


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
    check_estimates(60, thorough=4)


@pytest.mark.slow
def test_error_estimates_bound_errors_in_a_thousand_scenes():
    check_estimates(1000, thorough=200)
