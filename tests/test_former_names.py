"""Former names work for one version, and warn at the line that uses them."""

import re
import warnings
from pathlib import Path

import pytest
from catalogue import unit_scene

import slipfront as sf

CHANGES = (Path(__file__).parents[1] / "CHANGELOG.md").read_text()
VERSION = tuple(map(int, sf.__version__.split(".")[:2]))
FORMER = {
    "Solution": {
        "front_speeds": "edge_speeds",
        "heat": "frictional_work",
        "friction_work": "work_density",
        "energy_flux": "frictional_power",
    },
    "Marched": {"path": "final_path", "friction_work": "final_work_density"},
    "Simulation": {"path": "final_path", "friction_work": "final_work_density"},
}


@pytest.fixture(scope="module")
def answers():
    scene = unit_scene()
    made = (
        sf.solve(scene),
        sf.solve(scene, method="space-time", nodes=40),
        sf.simulate(scene, resolution=8),
    )
    return {type(one).__name__: one for one in made}


@pytest.mark.parametrize(
    ("kind", "former", "name"),
    [(kind, *pair) for kind, names in FORMER.items() for pair in names.items()],
)
def test_a_former_name_gives_the_same_and_warns_here(kind, former, name, answers):
    answer = answers[kind]
    with pytest.warns(DeprecationWarning, match=rf"{kind}\.{former} is called {name} now") as told:
        found = getattr(answer, former)
    assert told[0].filename == __file__
    expected = getattr(answer, name)
    assert found == expected if callable(expected) else (found == expected).all()
    assert f"`{kind}.{former}`" in CHANGES


@pytest.mark.parametrize(("former", "name"), sf._FORMER.items())
def test_a_former_name_of_the_package_warns_here(former, name):
    with pytest.warns(DeprecationWarning, match=f"called {name} now") as told:
        assert getattr(sf, former) is getattr(sf, name)
    assert told[0].filename == __file__
    assert f"`{former}`" in CHANGES


def test_present_names_do_not_warn(answers):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind, names in FORMER.items():
            for name in names.values():
                getattr(answers[kind], name)


def test_former_names_go_when_they_are_due():
    """Fails once the version has come for which a message says that the name is gone."""
    root = Path(__file__).parents[1]
    text = "".join(
        path.read_text(encoding="utf-8")
        for package in ("semianalytic", "fem", "slipfront")
        for path in (root / package).rglob("*.py")
    )
    due = re.findall(r'(?:renamed|warn_of)\(.*"(\d+)\.(\d+)"\)', text)
    assert len(due) == sum(map(len, FORMER.values())) + 1 + 1  # and the example of `renamed`
    assert all(tuple(map(int, one)) > VERSION for one in due)
