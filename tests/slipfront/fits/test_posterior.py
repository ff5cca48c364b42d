"""Samples of posteriors: as closed forms have them, alike by seed, honest about their length."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from catalogue import PRELOADED

from compare.figures.saving import figure_png
from semianalytic import Gauge, LogNormal, SceneError, fit, solve
from slipfront.fits import posterior
from slipfront.fits.figures import fit_figure

T = np.linspace(0.5, 2.0, 10)
NOISE = 0.02


@cache
def found_gain():
    return of_gain(("gain",))


def of_gain(names, priors=None, noise=NOISE):
    """A fit that takes one solution: how much too large a record is."""
    clean = 1.1 * solve(PRELOADED).slip_rate(0.4, T)
    noisy = clean + np.random.default_rng(1).normal(scale=noise, size=len(T))
    return fit([Gauge(0.4, T, noisy, noise, name="left")], PRELOADED, names, priors=priors)


def test_what_is_linear_has_the_posterior_of_its_covariance():
    found = found_gain()
    sampled = posterior(found, walkers=6, seed=3)
    assert sampled.status == "converged"
    assert 0.2 < sampled.acceptance < 0.8
    error = found.standard_errors[0]
    count = len(sampled.samples)
    assert sampled.mean[0] == pytest.approx(found.values[0], abs=4 * error * (2 / count) ** 0.5)
    assert sampled.standard_deviations[0] == pytest.approx(error, rel=4 / count**0.5)


def test_the_same_seed_gives_the_same_samples():
    found = found_gain()
    one, same, other = (posterior(found, steps=20, walkers=6, seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.samples, same.samples)
    assert not np.array_equal(one.samples, other.samples)


BANANA = {"gain": LogNormal(1.0, 1.4), "gain:left": LogNormal(1.0, 1.4)}


@pytest.mark.slow
def test_a_product_bends_the_posterior_and_the_chains_follow():
    """Two gains act by their product c and are alike beforehand: ln gain is normal about
    half of ln c, with the width of their priors over the root of two."""
    found = of_gain(("gain", "gain:left"), BANANA, noise=0.1)
    sampled = posterior(found, seed=1)
    assert sampled.status == "converged"
    logarithms = np.log(sampled.samples)
    product = logarithms.sum(axis=1)
    width, middle = np.log(1.4) / 2**0.5, product.mean() / 2
    assert product.std() < 0.3 * logarithms[:, 0].std()
    effective = (len(sampled.samples) / 2) ** 0.5
    assert logarithms[:, 0].std() == pytest.approx(width, rel=4 / effective)
    assert logarithms[:, 0].mean() == pytest.approx(middle, abs=4 * width / effective)
    third = np.mean((sampled.samples[:, 0] - sampled.mean[0]) ** 3)
    assert third / sampled.standard_deviations[0] ** 3 > 0.4  # no ellipse is skew
    picture = figure_png(fit_figure(found, sampled), dpi=50)
    assert picture.startswith(b"\x89PNG")


@pytest.mark.slow
def test_friction_from_slip_has_the_posterior_of_its_covariance():
    """Slip is smooth where a zone ends, so its misfits are nearly linear in friction."""
    solution, random = solve(PRELOADED), np.random.default_rng(2)
    gauges = []
    for x in (0.3, 0.7):
        slip = solution.slip(x, T) + random.normal(scale=NOISE, size=len(T))
        gauges.append(Gauge(x, T, slip, NOISE, "slip"))
    found = fit(gauges, replace(PRELOADED, friction=0.4), ("friction",))
    sampled = posterior(found, seed=5)
    assert sampled.status == "converged"
    assert sampled.mean[0] == pytest.approx(found.values[0], abs=0.3 * found.standard_errors[0])
    assert sampled.standard_deviations[0] == pytest.approx(found.standard_errors[0], rel=0.15)


def test_short_chains_say_so():
    sampled = posterior(found_gain(), steps=30)
    assert sampled.status.startswith("unresolved: chains of 30 steps are shorter than 50")
    assert "unresolved" in repr(sampled)


def test_what_has_no_posterior_is_refused():
    free = of_gain(("gain", "gain:left"))
    with pytest.raises(SceneError, match="do not constrain gain and gain:left; give them a prior"):
        posterior(free)
    for name in ("steps", "walkers"):
        with pytest.raises(SceneError, match=f"{name} must be a whole number of at least 2"):
            posterior(found_gain(), **{name: 1})
