"""Fits recover what made their records, as well as they say, and say what they cannot tell."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, STEEL, unit_scene
from scipy.stats import binom, chi2

from semianalytic import Gauge, Scene, SceneError, Tractions, fit, solve

NOISE = 0.02
START = replace(PRELOADED, friction=0.4, load=Tractions(0.0, 1.1))


@pytest.fixture(scope="module")
def truth():
    return solve(PRELOADED, rtol=1e-9)


def records(solution, seed, noise=NOISE, places=(0.4, 0.9)):
    random = np.random.default_rng(seed)
    for x in places:
        t = np.linspace(0.4 * x, 4 * x, 60)
        rate = solution.slip_rate(x, t)
        yield Gauge(x, t, rate + random.normal(scale=noise, size=len(t)), noise)


FLAGGED = 0.02
"""Share of trials whose noise may hide what tells parameters apart."""


def loose(found):
    """Whether the derivatives where a fit ends give one of those it names no error below its size,
    by the inverse of the normal matrix."""
    columns = []
    for name in found.parameters:
        derivative = found.solution.derivative(name)
        rows = [gauge.sensitivity(found.solution, derivative) for gauge in found.gauges]
        columns.append(np.concatenate(rows))
    jacobian = np.stack(columns, axis=1)
    errors = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    named = np.isin(found.parameters, found.unconstrained)
    return bool(np.all(errors[named] > np.abs(found.values[named])))


def coverage(solution, trials, start, names, true, noise):
    """How many fits have the truth within their ellipse of 90 %, all sums of squares, and how many
    say that the data leave something free: no better known than by its size, at a chi2 below that
    of the truth."""
    inside, squares, flagged = 0, [], 0
    for seed in range(trials):
        gauges = tuple(records(solution, seed, noise))
        found = fit(gauges, start, names, rtol=1e-6)
        squares.append(found.chi2 / found.freedom)
        if found.unconstrained:
            flagged += 1
            assert loose(found)
            assert found.chi2 < sum(np.sum(gauge.misfit(solution) ** 2) for gauge in gauges)
            continue
        assert found.status == "converged"
        away = found.values - true
        inside += away @ np.linalg.solve(found.covariance, away) < chi2.ppf(0.9, len(names))
    return inside, squares, flagged


def check_coverage(solution, trials, start, names, true, noise=NOISE):
    """Within what happens to an honest ellipse in all but one of a thousand such tests."""
    inside, squares, flagged = coverage(solution, trials, start, names, true, noise)
    assert flagged <= FLAGGED * trials
    low, high = binom.ppf([5e-4, 1 - 5e-4], trials - flagged, 0.9)
    assert low <= inside <= high
    spread = np.sqrt(2 / (120 * trials))
    assert np.mean(squares) == pytest.approx(1, abs=4 * spread)


def test_truth_is_within_the_error_bars_at_the_stated_rate(truth):
    check_coverage(truth, 20, START, ("friction", "load_shear"), np.array([0.3, 1.0]))


def test_without_noise_the_truth_is_met(truth):
    (gauge,) = records(truth, 0, noise=1e-9, places=(0.4,))
    found = fit([gauge], START, ("friction", "load_shear"), rtol=1e-9)
    np.testing.assert_allclose(found.values, [0.3, 1.0], rtol=1e-6)
    assert found.scene.friction == pytest.approx(0.3, rel=1e-6)


def test_a_fit_from_other_zones_finds_its_way(truth):
    """From the only zone of f = 1.2 to the two of f = 0.3."""
    found = fit(tuple(records(truth, 1)), unit_scene(1.2), ("friction",), rtol=1e-6)
    assert abs(found.values[0] - 0.3) < 4 * found.standard_errors[0]
    assert len(found.solution.zones) == 2


def test_what_the_data_leave_free_is_named(truth):
    found = fit(tuple(records(truth, 2)), START, ("friction", "base_pressure"), rtol=1e-6)
    assert found.unconstrained == ("friction", "base_pressure")
    assert "do not constrain friction and base_pressure apart" in found.status
    assert np.all(np.isinf(found.standard_errors))
    ahead = Gauge(5.0, np.array([0.1, 0.2, 0.3]), np.zeros(3), NOISE)
    found = fit([ahead], PRELOADED, ("friction",), rtol=1e-6)
    assert found.unconstrained == ("friction",)


def test_samples_on_edges_and_fronts_do_no_harm(truth):
    material, speeds = PRELOADED.material, truth.edge_speeds
    fronts = [material.rayleigh_speed, material.shear_speed, material.longitudinal_speed]
    marks = np.concatenate([speeds[speeds > 0], fronts])
    t = np.unique(np.concatenate([0.5 / marks, np.linspace(0.2, 2.0, 40)]))
    gauge = Gauge(0.5, t, truth.slip_rate(0.5, t), NOISE)
    found = fit([gauge], replace(PRELOADED, friction=0.31), ("friction",), rtol=1e-6)
    assert found.values[0] == pytest.approx(0.3, abs=0.1 * found.standard_errors[0])
    assert 0 < found.standard_errors[0] < 0.05


def test_units_and_residuals():
    scene = Scene(STEEL, 0.3, Tractions(5e6, 0.0), Tractions(0.0, 5e6))
    solution = solve(scene)
    t = np.linspace(1e-5, 8e-5, 50)
    clean = solution.slip_rate(0.05, t)
    gauge = Gauge(0.05, t, clean + 0.01 * np.sin(np.arange(50)), 0.01)
    found = fit([gauge], replace(scene, load=Tractions(0.0, 5.5e6)), ("load_shear",), rtol=1e-6)
    assert found.values[0] == pytest.approx(5e6, abs=3 * found.standard_errors[0])
    assert 1e3 < found.standard_errors[0] < 1e6
    (residual,) = found.residuals
    assert np.sum((residual / 0.01) ** 2) == pytest.approx(found.chi2, rel=1e-9)
    assert repr(found).startswith("<Fit: load_shear ")


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ((), "at least one parameter"),
        (("friction", "friction"), "each of them once"),
        (("density",), "parameters must be among"),
        (("viscosity",), "needs ViscousFriction"),
    ],
)
def test_what_cannot_be_fitted_is_refused(truth, names, message):
    with pytest.raises(SceneError, match=message):
        fit(tuple(records(truth, 0)), PRELOADED, names)


def test_bad_records_are_refused(truth):
    t = np.array([0.1, 0.2])
    with pytest.raises(SceneError, match="at least one Gauge"):
        fit([], PRELOADED, ("friction",))
    with pytest.raises(SceneError, match="number of samples"):
        fit([Gauge(0.5, t[:1], t[:1], 1.0)], PRELOADED, ("friction", "load_shear"))
    for bad in ((0.0, t, t, 1.0), (1.0, t, t[:1], 1.0), (1.0, t[::-1], t, 1.0), (1.0, t, t, 0.0)):
        with pytest.raises(SceneError, match="gauge"):
            Gauge(*bad)
