"""``slipfront sliding`` and the map of ``slipfront regimes --dissimilar``."""

import json

import pytest

from slipfront.cli.commands import main

GOUGE, ROCK = "12e9,2300,0.25", "30e9,2700,0.25"


def sliding(*more, upper=GOUGE, lower=ROCK, friction="0.4"):
    return main(["sliding", "--upper", upper, "--lower", lower, "--friction", friction, *more])


def test_a_verdict_and_thresholds_are_printed(capsys):
    assert sliding() == 0
    shown = capsys.readouterr().out
    assert "0.531417" in shown
    assert "well posed" in shown


def test_bodies_may_have_units(capsys):
    upper, lower = "12GPa,2.3g/cm3,0.25", "30GPa,2700kg/m3,25%"
    assert sliding("--json", upper=upper, lower=lower, friction="60%") == 0
    with_units = json.loads(capsys.readouterr().out)
    assert sliding("--json", friction="0.6") == 0
    assert json.loads(capsys.readouterr().out) == with_units


def test_json_has_the_waves(capsys):
    assert sliding("--json", friction="0.6") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["well_posed"] is False
    assert document["waves"][0]["per_wavelength"] == pytest.approx(1.0533, abs=1e-4)
    assert document["threshold_with"] == pytest.approx(0.5314169, abs=1e-7)


def test_what_is_infinite_is_null(capsys):
    assert sliding("--json", lower=GOUGE) == 0
    document = json.loads(capsys.readouterr().out)
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
def test_what_is_no_pair_is_one_sentence(given, complaint, capsys):
    assert sliding(**given) == 2
    error = capsys.readouterr().err.strip()
    assert complaint in error.lower()
    assert "\n" not in error


def test_a_map_of_nothing_is_refused(tmp_path, capsys):
    command = ["regimes", "--dissimilar", "--size", "1", "--output", str(tmp_path / "map")]
    assert main(command) == 2
    assert "from 2" in capsys.readouterr().err
