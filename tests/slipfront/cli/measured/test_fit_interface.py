"""``slipfront fit`` of an interface: the document, the figure, and what is refused."""

import numpy as np
import pytest
from json_checks import checked

import semianalytic as sf
from slipfront.cli.commands import main

FAULT = """
length = 12.0
shear = 0.3
[material]
shear_modulus = 1.0
density = 1.0
poisson_ratio = 0.25
[law]
kind = "slip-dependent"
static = 0.6
dynamic = 0.2
distance = 1.0
[load]
shear = "1.2 * exp(-x**2)"
history = {kind = "ramp", rise_time = 1.0}
[run]
end_time = 2.0
nodes = 32
"""
FIT = ["fit", "r.csv", "--scene", "f.toml", "--noise", "slip=0.2"]


@pytest.fixture(autouse=True)
def records(tmp_path, monkeypatch):
    (tmp_path / "f.toml").write_text(FAULT)
    monkeypatch.chdir(tmp_path)
    found = sf.find_interface("f.toml")
    t = [0.5, 1.0, 1.5, 2.0]
    done = sf.run(found.interface, 2.0, 32, times=t, estimate=False)
    slip = done.at(done.slip, np.array([-1.0]))[:, 0]
    rows = "".join(f"{at},-1,{1.1 * value}\n" for at, value in zip(t, slip, strict=True))
    (tmp_path / "r.csv").write_text("t,x,slip\n" + rows)


def test_a_gain_is_fitted(capsys):
    assert main([*FIT, "--parameters", "gain", "--json"]) in (0, 4)
    document = checked(capsys.readouterr().out)
    assert document["parameters"]["gain"]["value"] == pytest.approx(1.1, abs=0.02)
    assert document["scene"]["interface"]["law"]["kind"] == "SlipDependent"
    assert document["scene"]["options"]["nodes"] == 32


@pytest.mark.slow
def test_a_fit_is_drawn(tmp_path, capsys):
    assert main([*FIT, "--parameters", "gain", "--plot", "p.png"]) in (0, 4)
    assert (tmp_path / "p.png").stat().st_size > 10_000
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--parameters", "law.dyn"], "must be among length, pressure"),
        (["--parameters", "gain", "--friction", "0.3"], "--friction: an interface takes no other"),
        (["--parameters", "law.distance", "--prior", "law.distance=normal(1mm,1)"], "unit"),
        (["--parameters", "gain", "--nodes", "30"], "multiple of 4"),
    ],
)
def test_what_cannot_be_fitted_is_refused(arguments, message, refused):
    assert message in refused([*FIT, *arguments])
