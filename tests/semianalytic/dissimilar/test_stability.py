"""`sliding_stability`: verdicts, units, exchange of the bodies, and what is refused."""

import numpy as np
import pytest
from dissimilar_pairs import ALUMINIUM_ON_STEEL, GOUGE_ON_ROCK, PAIRS, ROCK, RUBBER_ON_STEEL

import slipfront as sf
from semianalytic import Material, SceneError


def test_verdicts():
    known = sf.sliding_stability(*GOUGE_ON_ROCK, 0.5)
    assert known.well_posed
    assert known.verdict.endswith("under friction below 0.5314.")
    assert known.delayed_growth > 0  # a delay makes waves grow that decay without it
    assert sf.sliding_stability(ROCK, ROCK, 3.0).verdict.endswith("slide under any friction.")


@pytest.mark.slow
def test_verdicts_on_pairs_between_which_waves_grow():
    verdict = sf.sliding_stability(*ALUMINIUM_ON_STEEL, 0.2).verdict
    assert "with the upper body grow by 0.855 % over every wavelength" in verdict
    assert "no friction is too low" in verdict
    verdict = sf.sliding_stability(*PAIRS["PMMA on aluminium"], 0.2).verdict
    assert "against the upper body grow by 3.09 %" in verdict
    assert "lower it below 0.00954" in verdict
    assert "no friction is too low" in sf.sliding_stability(*RUBBER_ON_STEEL, 0.2).verdict


@pytest.mark.slow
def test_from_below_waves_with_the_upper_body_run_against_it():
    one, other = (sf.sliding_stability(*pair, 0.3) for pair in (PAIRS["C"], PAIRS["C"][::-1]))
    assert one.threshold_with == other.threshold_against
    assert one.threshold_against == pytest.approx(other.threshold_with, rel=1e-12)
    assert one.dundurs == pytest.approx(-other.dundurs, rel=1e-12)
    assert one.delayed_growth == pytest.approx(other.delayed_growth, rel=1e-9)
    here, there = one.waves[0], other.waves[0]
    assert here.velocity == pytest.approx(-there.velocity, rel=1e-9)
    assert here.growth == pytest.approx(there.growth, rel=1e-8)


@pytest.mark.slow
def test_units_of_the_bodies():
    scaled = [
        Material(4e9 * one.shear_modulus, 1e3 * one.density, one.poisson_ratio)
        for one in PAIRS["C"]
    ]
    known, plain = (sf.sliding_stability(*pair, 0.2) for pair in (scaled, PAIRS["C"]))
    assert known.generalised_rayleigh_speed == pytest.approx(2000 * 0.95866882, rel=1e-8)
    assert known.waves[0].growth == pytest.approx(2000 * plain.waves[0].growth, rel=1e-9)
    assert known.waves[0].per_wavelength == pytest.approx(plain.waves[0].per_wavelength, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("steel", ROCK, 0.3), "upper must be a Material"),
        ((ROCK, ROCK, 0.0), "friction must be positive"),
        ((ROCK, ROCK, np.nan), "friction must be"),
        ((ROCK, Material(1e11, 1.0, 0.25), 0.3), "factor of 1e\\+10"),
    ],
)
def test_what_cannot_be_told_is_refused(arguments, complaint):
    with pytest.raises(SceneError, match=complaint):
        sf.sliding_stability(*arguments)
