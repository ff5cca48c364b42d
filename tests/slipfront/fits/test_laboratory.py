"""Records of a march in PMMA, as they are committed: fitted from the command line."""

import json
from pathlib import Path

import numpy as np
import pytest

import compare
from docs.studies import samples
from slipfront.cli.commands import main
from slipfront.fits import read_gauges

DATA = Path(compare.__file__).parents[1] / "docs" / "data"
TRUTH = {"friction": 0.35, "load_shear": 4e6, "t0": 3e-6}
SCENE = f"--scene {DATA / 'pmma.toml'} --parameters {','.join(TRUTH)}"


def fitted(line, capsys, folder):
    document, picture = folder / "fit.json", folder / "fit.png"
    code = main(f"fit {line} --output {document} --plot {picture}".split())
    assert code == 0, capsys.readouterr().err
    assert picture.stat().st_size > 10_000
    return json.loads(document.read_text())


def check(found):
    """The truth lies within the ellipse that all but a thousandth of such fits have it in."""
    assert list(found["parameters"]) == list(TRUTH)
    away = [found["parameters"][name]["value"] - value for name, value in TRUTH.items()]
    assert away @ np.linalg.solve(found["covariance"], away) < 16.3
    assert found["misfit"] == "misfits are as large as the noise"
    assert found["units"]["parameters"] == {"friction": "1", "load_shear": "Pa", "t0": "s"}


@pytest.mark.slow
def test_slip_across_the_interface_is_fitted(tmp_path, capsys):
    check(fitted(f"{DATA / 'pmma_slip.csv'} {SCENE}", capsys, tmp_path))


@pytest.mark.slow
def test_strain_gauges_and_a_line_off_the_interface_are_fitted(tmp_path, capsys):
    files = f"{DATA / 'pmma_gauges.csv'} {DATA / 'pmma_line.csv'}"
    noise = f"--noise {samples.STRAIN_NOISE} --noise ux={samples.MOTION_NOISE}"
    found = fitted(f"{files} {SCENE} {noise}", capsys, tmp_path)
    check(found)
    assert found["parameters"]["friction"]["standard_error"] < 0.005
    assert 0 < found["derivative_error"] < 0.2


@pytest.mark.slow
def test_the_committed_records_are_those_of_their_command(tmp_path):
    samples.main(tmp_path)
    for name in ("pmma_gauges.csv", "pmma_line.csv", "pmma_slip.csv"):
        noise = {"": 1.0}
        pairs = zip(
            read_gauges([tmp_path / name], noise), read_gauges([DATA / name], noise), strict=True
        )
        for new, old in pairs:
            np.testing.assert_allclose(new.values, old.values, atol=1.1e-6)
    assert (tmp_path / "pmma.toml").read_text() == (DATA / "pmma.toml").read_text()
