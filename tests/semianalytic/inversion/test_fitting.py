"""Fits recover what made their records, as well as they say, and say what they cannot tell."""

import re
from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, STEEL, unit_scene
from scipy.stats import binom, chi2

import semianalytic as sf
from semianalytic.inversion.samples import Samples
from semianalytic.inversion.search import descend
from semianalytic.inversion.unknowns import Setup
from semianalytic.selfsimilar.derivatives.parameters import parameter

NOISE = 0.02
START = replace(PRELOADED, friction=0.4, load=sf.Tractions(0.0, 1.1))


@pytest.fixture(scope="module")
def truth():
    return sf.solve(PRELOADED, rtol=1e-9)


def records(solution, seed, noise=NOISE, places=(0.4, 0.9)):
    random = np.random.default_rng(seed)
    for x in places:
        t = np.linspace(0.4 * x, 4 * x, 60)
        rate = solution.slip_rate(x, t)
        yield sf.Gauge(x, t, rate + random.normal(scale=noise, size=len(t)), noise)


FAR = replace(START, load=PRELOADED.load, material=sf.Material(1.0, 1.0, 0.25))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("start", "names", "noise", "trials"),
    [
        (START, ("friction", "load_shear"), NOISE, 10),
        (FAR, ("friction", "poisson_ratio"), 0.005, 6),
        (replace(START, friction=0.3), ("base_pressure", "load_shear"), NOISE, 6),
    ],
)
def test_truth_is_within_the_error_bars_at_the_stated_rate(truth, start, names, noise, trials):
    """Within what happens to an honest ellipse of 90 % in all but one of a thousand such tests.

    Sums of squares as well: of (friction, Poisson ratio) at small noise one search of three ended
    in a minimum of its own, before there was a scan.
    """
    inside, squares = 0, []
    true = np.array([parameter(truth.scene, name) for name in names])
    for seed in range(trials):
        found = sf.fit(tuple(records(truth, seed, noise)), start, names, rtol=1e-6)
        assert found.status == "converged"
        assert found.unconstrained == ()
        squares.append(found.chi2 / found.freedom)
        away = found.values - true
        inside += away @ np.linalg.solve(found.covariance, away) < chi2.ppf(0.9, len(names))
    low, high = binom.ppf([5e-4, 1 - 5e-4], trials, 0.9)
    assert low <= inside <= high
    assert np.mean(squares) == pytest.approx(1, abs=4 * np.sqrt(2 / (120 * trials)))


@pytest.mark.slow
def test_a_minimum_beside_the_least_is_left(truth):
    """The search from the first guess alone ends at 150.57, 42 above what the truth itself has."""
    gauges, names = tuple(records(truth, 0, 0.005)), ("friction", "poisson_ratio")
    found = sf.fit(gauges, FAR, names, rtol=1e-6)
    alone = descend(found.trials, found.trials.start)
    at_truth = np.array([0.3, 1 / 3]) / found.trials.sizes
    assert alone.chi2 > np.sum(found.trials.misfit(at_truth) ** 2) + 20
    assert found.chi2 <= descend(found.trials, at_truth).chi2 + 1e-3
    np.testing.assert_array_less(found.chi2_of_minima[0] - 1e-9, found.chi2_of_minima)
    assert found.next_minimum == pytest.approx(found.chi2_of_minima[1] - found.chi2)


@pytest.mark.slow
def test_a_fit_from_other_zones_finds_its_way(truth):
    """From the only zone of f = 1.2 to the two of f = 0.3."""
    found = sf.fit(tuple(records(truth, 1)), unit_scene(1.2), ("friction",), rtol=1e-6)
    assert abs(found.values[0] - 0.3) < 4 * found.standard_errors[0]
    assert len(found.solution.zones) == 2


@pytest.mark.thinned(4)
@pytest.mark.parametrize("seed", [110, 104, 107, 112])
def test_what_is_bounded_from_one_side_alone_is_told(seed):
    """Records at friction 4 see no slip; noise makes shallow minima at 2.2, where slip begins."""
    noise, t = np.random.default_rng(seed), np.linspace(0.02, 1.5, 60)
    gauges = [sf.Gauge(x, t, 0.01 * noise.normal(size=60), 0.01) for x in (0.2, 0.5)]
    found = sf.fit(gauges, PRELOADED, "friction", rtol=1e-6)
    if found.unconstrained:
        return
    assert found.standard_errors[0] < 0.15
    said = r"friction is poorly bounded from above: \d\.\d+, 20 standard errors away, fits almost"
    assert re.match(said, found.status)


def test_a_prior_wider_than_the_value_is_the_error_where_records_say_nothing():
    """The records were taken before any wave arrived."""
    ahead = sf.Gauge(5.0, np.array([0.1, 0.2, 0.3]), np.zeros(3), NOISE)
    assert sf.fit([ahead], PRELOADED, "friction", rtol=1e-6).unconstrained == ("friction",)
    prior = {"friction": sf.Normal(2.0, 2.0)}
    found = sf.fit([ahead], PRELOADED, "friction", priors=prior, rtol=1e-6)
    assert found.unconstrained == ()
    assert found.values == pytest.approx([2.0], rel=1e-6)
    assert found.standard_errors == pytest.approx([2.0], rel=1e-6)
    assert found.interval == pytest.approx(np.array([[0.0, 4.0]]), abs=1e-6)


def test_a_value_that_changes_nothing_leaves_the_intervals_of_the_others():
    """Slip in antiplane shear does not depend on Poisson's ratio."""
    scene, t = sf.find("antiplane"), np.linspace(0.3, 1.5, 6)
    record = sf.Gauge(0.2, t, sf.solve(scene).slip(0.2, t), 1e-3, "slip")
    found = sf.fit([record], scene, ("friction", "poisson_ratio"), rtol=1e-6)
    assert found.unconstrained == ("poisson_ratio",)
    low, high = found.interval[0]
    assert 0.49 < low < found.values[0] < high < 0.51


def late_rates():
    """Slip rates of a load that acts at 0.02; their front makes chi2 uneven in its time."""
    t, noise = np.linspace(0.03, 1.5, 40), np.random.default_rng(1)
    rates = [sf.solve(PRELOADED).slip_rate(x, t - 0.02) for x in (0.25, 0.55)]
    noisy = [rate + 0.02 * noise.normal(size=40) for rate in rates]
    return [sf.Gauge(x, t, rate, 0.02) for x, rate in zip((0.25, 0.55), noisy, strict=True)]


def test_the_interval_of_one_value_ends_where_chi2_is_one_above_its_least():
    found = sf.fit(late_rates(), PRELOADED, "t0", rtol=1e-6)
    below, above = np.abs(found.interval[0] - found.values[0])
    assert above > 1.3 * below
    assert repr(found).startswith(f"<Fit: t0 {found.values[0]:.5g} +{above:.2g} -{below:.2g};")
    for end in found.interval:
        square = np.sum(found.trials.misfit(end[:1] / found.trials.sizes) ** 2)
        assert square - found.chi2 == pytest.approx(1.0, abs=0.15)


@pytest.mark.slow
def test_intervals_end_where_chi2_is_one_above_its_least_with_other_values_fitted_anew():
    gauges, names = late_rates(), ("friction", "t0")
    found = sf.fit(gauges, PRELOADED, names, rtol=1e-6)
    errors = np.abs(found.interval - found.values[:, None])
    assert np.any(np.abs(errors / found.standard_errors[:, None] - 1) > 0.15)
    for name, ends in zip(names, found.interval, strict=True):
        for end in ends:
            held = sf.fit(gauges, PRELOADED, names, priors={name: sf.Normal(end, 1e-7)}, rtol=1e-6)
            assert held.chi2 - found.chi2 == pytest.approx(1.0, abs=0.25)


@pytest.mark.slow
def test_samples_on_edges_and_fronts_do_no_harm(truth):
    material, speeds = PRELOADED.material, truth.edge_speeds
    fronts = [material.rayleigh_speed, material.shear_speed, material.longitudinal_speed]
    marks = np.concatenate([speeds[speeds > 0], fronts])
    t = np.unique(np.concatenate([0.5 / marks, np.linspace(0.2, 2.0, 40)]))
    gauge = sf.Gauge(0.5, t, truth.slip_rate(0.5, t), NOISE)
    found = sf.fit([gauge], replace(PRELOADED, friction=0.31), ("friction",), rtol=1e-6)
    assert found.values[0] == pytest.approx(0.3, abs=0.1 * found.standard_errors[0])
    assert 0 < found.standard_errors[0] < 0.05


@pytest.mark.slow
def test_units_and_residuals():
    scene = sf.Scene(STEEL, 0.3, sf.Tractions(5e6, 0.0), sf.Tractions(0.0, 5e6))
    solution = sf.solve(scene)
    t = np.linspace(1e-5, 8e-5, 50)
    clean = solution.slip_rate(0.05, t)
    gauge = sf.Gauge(0.05, t, clean + 0.01 * np.sin(np.arange(50)), 0.01)
    found = sf.fit(
        [gauge], replace(scene, load=sf.Tractions(0.0, 5.5e6)), ("load_shear",), rtol=1e-6
    )
    assert found.values[0] == pytest.approx(5e6, abs=3 * found.standard_errors[0])
    assert 1e3 < found.standard_errors[0] < 1e6
    (residual,) = found.residuals
    assert np.sum((residual / 0.01) ** 2) == pytest.approx(found.chi2, rel=1e-9)
    assert repr(found).startswith("<Fit: load_shear ")


# --- what contradicts a fit ---------------------------------------------------------------------


@pytest.mark.slow
def test_a_fit_that_holds_a_wrong_load_says_so(truth):
    """README's own example of old: friction .65 instead of .35, and "converged"."""
    gauges = tuple(records(truth, 3))
    found = sf.fit(gauges, START, ("friction",), rtol=1e-6)
    assert abs(found.values[0] - 0.3) > 4 * found.standard_errors[0]
    assert found.status.startswith("misfits are ")
    assert f"(chi2 {found.chi2:.4g} of {found.freedom})" in found.status
    assert sf.fit(gauges, PRELOADED, ("friction",), rtol=1e-6).status == "converged"


@pytest.mark.slow
@pytest.mark.parametrize(("more", "status"), [(1.2, "converged"), (1.6, "misfits are 1.6 times")])
def test_noise_that_is_more_than_said_is_told_from_what_chance_does(truth, more, status):
    """120 samples tell 1.33 times the noise from chance."""
    told = [replace(record, noise=NOISE / more) for record in records(truth, 4)]
    assert sf.fit(told, PRELOADED, ("friction",), rtol=1e-6).status.startswith(status)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mean", "sd", "noise", "contradicts"),
    [
        (0.32, 0.01, 0.2, False),  # within two standard deviations
        (0.45, 0.05, NOISE, False),  # within three
        (0.45, 0.02, NOISE, True),
        (0.6, 0.01, 0.2, True),  # drawn to its prior, of which it is but 2.6 away; chi2 166 of 120
    ],
)
def test_records_and_priors_that_contradict_are_told(truth, mean, sd, noise, contradicts):
    gauges, priors = tuple(records(truth, 5, noise)), {"friction": sf.Normal(mean, sd)}
    found = sf.fit(gauges, PRELOADED, ("friction",), priors=priors, rtol=1e-6)
    said = "records and priors contradict each other" in found.status
    assert said is contradicts
    assert said or found.status == "converged"


@pytest.mark.slow
def test_records_are_as_far_from_a_prior_as_a_fit_without_it(truth):
    """Where all is linear: (x - mean)^2 / (error^2 + sd^2), x being what the records say alone."""
    gauges = tuple(records(truth, 6))
    alone = sf.fit(gauges, PRELOADED, ("load_shear",), rtol=1e-6)
    value, error = alone.values[0], alone.standard_errors[0]
    prior = {"load_shear": sf.Normal(value + 8 * error, error / 2)}
    found = sf.fit(gauges, PRELOADED, ("load_shear",), priors=prior, rtol=1e-6)
    (apart,) = re.findall(r"they are (.+) standard deviations apart in load_shear", found.status)
    assert float(apart) == pytest.approx(8 / np.hypot(1, 0.5), rel=0.1)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ((), "at least one parameter"),
        (("friction", "friction"), "each one once"),
        (("youngs_modulus",), "parameters must be among"),
        (np.zeros((2, 0)), "parameters must be among"),
        (("gain:left",), "belongs to no gauge"),
        (("viscosity",), "needs a scene with friction of a positive"),
    ],
)
def test_what_cannot_be_fitted_is_refused(truth, names, message):
    with pytest.raises(sf.SceneError, match=message):
        sf.fit(tuple(records(truth, 0)), PRELOADED, names)


def test_bad_records_are_refused(truth):
    t = np.array([0.1, 0.2])
    with pytest.raises(sf.SceneError, match="at least one Gauge"):
        sf.fit([], PRELOADED, ("friction",))
    with pytest.raises(sf.SceneError, match="number of samples"):
        sf.fit([sf.Gauge(0.5, t[:1], t[:1], 1.0)], PRELOADED, ("friction", "load_shear"))
    for bad in ((1.0, t, t[:1], 1.0), (1.0, t[::-1], t, 1.0), (1.0, t, t, 0.0)):
        with pytest.raises(sf.SceneError, match="gauge"):
            sf.Gauge(*bad)
    for noise in (1e-160, 1e-18, 1e61):  # squares of misfits would leave floating point
        with pytest.raises(sf.SceneError, match="gauge: noise must lie within"):
            sf.Gauge(1.0, t, t, noise)
    with pytest.raises(sf.SceneError, match="must not exceed 1e"):
        sf.Gauge(1.0, t, 1e100 * t, 1.0)


def test_progress_counts_up_to_what_it_foretells():
    """With a gauge in a body, the computation of which takes nearly all of the time."""
    scene = sf.find("antiplane")
    t = np.linspace(0.2, 1.5, 4)
    record = sf.Gauge(0.4, t, np.zeros(4), 0.02, "vz", y=0.1)
    exact = Samples((record,)).of(sf.solve(scene), Setup())
    told = []
    found = sf.fit(
        [replace(record, values=exact)],
        scene,
        "load_shear",
        priors={"load_shear": sf.Normal(1.0, 0.05)},
        rtol=1e-6,
        progress=lambda done, total: told.append((done, total)),
    )
    assert found.values == pytest.approx([1.0], abs=1e-6)
    done, total = np.array(told).T
    assert np.all(np.diff(done) >= 0)
    assert np.all(done <= total)
    # the search goes on for a round or two that were not foretold, at most
    assert 0.4 * done[-1] < total[1] < 5 * done[-1]
    assert found.trials.progress is None


def test_the_density_of_a_gain_is_that_of_least_squares():
    """A gain multiplies what is seen: -2 log density is a parabola with the sum of its squares."""
    t, clean = np.linspace(0.5, 2.0, 10), sf.solve(PRELOADED)
    seen = clean.slip(0.4, t)
    gauge = sf.Gauge(0.4, t, 1.1 * seen, 0.02, "slip")
    found = sf.fit([gauge], PRELOADED, ("gain",))
    for gain in (0.7, 1.0, 2.0):
        expected = -np.sum((gain - 1.1) ** 2 * seen**2) / (2 * 0.02**2)
        assert found.log_density([gain]) == pytest.approx(expected, rel=1e-6)
    assert found.log_density([-1.0]) == -np.inf
    with pytest.raises(sf.SceneError, match="one value for each of gain, got an array of shape"):
        found.log_density([1.0, 2.0])
    # times a density in the parameter itself: of a lognormal prior with the Jacobian of ln
    prior = {"gain": sf.LogNormal(1.0, 1.4)}
    known = sf.fit([gauge], PRELOADED, ("gain",), priors=prior)
    for gain in (0.9, 1.2):
        expected = -((np.log(gain) / np.log(1.4)) ** 2) / 2 - np.log(gain)
        assert known.log_density([gain]) - found.log_density([gain]) == pytest.approx(expected)
