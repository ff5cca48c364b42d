"""``slipfront sliding`` and the map of ``slipfront regimes --dissimilar``."""

import pytest

from slipfront.cli.commands import main

GOUGE, ROCK = "12e9,2300,0.25", "30e9,2700,0.25"


def sliding(upper=GOUGE, lower=ROCK, friction="0.4"):
    return f"sliding --upper {upper} --lower {lower} --friction {friction}"


def test_a_verdict_and_thresholds_are_printed(capsys):
    assert main(sliding().split()) == 0
    shown = capsys.readouterr().out
    assert "0.531417" in shown
    assert "well posed" in shown


def test_json_has_the_waves(printed):
    document = printed(sliding(friction="0.6"))
    assert document["well_posed"] is False
    assert document["waves"][0]["per_wavelength"] == pytest.approx(1.0533, abs=1e-4)
    assert document["threshold_with"] == pytest.approx(0.5314169, abs=1e-7)


def test_what_is_infinite_is_null_and_bodies_may_have_units(printed):
    document = printed(sliding(lower=GOUGE))
    upper, lower = "12GPa,2.3g/cm3,0.25", "12e6kPa,2300kg/m3,25%"
    assert printed(sliding(upper=upper, lower=lower, friction="40%")) == document
    assert document["threshold_with"] is None
    assert document["delayed_growth"] is None


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"upper": "12e9,2300"}, "--upper has to be three numbers"),
        ({"lower": "30e9,2700,0.5"}, "--lower: poisson_ratio must lie"),
        ({"lower": "0,2700,0.25"}, "--lower: shear_modulus must be positive"),
        ({"upper": "12GPa,2300,0.25"}, "units at all moduli and densities or at none"),
        ({"upper": "12cm,2300,0.25"}, "--upper: the shear modulus must be a number alone or in pa"),
        ({"friction": "-1"}, "friction must be positive"),
    ],
)
def test_what_is_no_pair_is_one_sentence(given, complaint, refused):
    assert complaint in refused(sliding(**given)).lower()


def test_a_map_of_nothing_is_refused(tmp_path, refused):
    assert "from 2" in refused(f"regimes --dissimilar --size 1 --output {tmp_path / 'map'}")
