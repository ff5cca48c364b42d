"""The verb `solve`: who answers, which settings are known, and what is refused."""

import pickle
import signal
from copy import deepcopy
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from catalogue import under

import slipfront as sf
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.methods import METHODS, chosen, settings_of
from semianalytic.parameters.numbers import numbers_of, with_numbers
from semianalytic.results.interruption import whole
from semianalytic.scene.given.finding import names
from semianalytic.scene.given.named import NAMED_LINES
from semianalytic.whole_line.growing import GrowingSolution
from semianalytic.whole_line.solution import LineSolution

PAGE = (Path(__file__).parents[2] / "docs" / "methods.md").read_text()
SOLID, PRESSED, SHEARED = sf.Material(1.0, 1.0, 1 / 3), sf.Tractions(1.0, 0.0), sf.Tractions(0, 1)
SCENE = sf.Scene(SOLID, 0.3, PRESSED, SHEARED)
KINDS = {
    "preloaded": ("self-similar", sf.Solution),
    "pair-slip": ("self-similar", PairSolution),
    "whole-line-patch": ("self-similar", LineSolution),
    "growing-load": ("self-similar", GrowingSolution),
    "ramp": ("space-time", sf.Marched),
    "punch": ("space-time", sf.Marched),
}
"""A name for each row of the table, the method that answers, and the class of the answer."""
BRIEFLY = {"ramp": {"nodes": 64}, "punch": {"nodes": 256, "end_time": 0.5, "estimate": False}}


def solved(row):
    """The names of the settings of a row."""
    problem = sf.find("punch") if row.problem == "Scene on a line" else SCENE
    return settings_of(import_module(f"semianalytic.{row.module}"), problem)


def test_the_table_stands_in_the_documentation_as_in_the_code():
    for row in METHODS:
        cells = (row.name, f"`{row.problem}`", f"`{row.module}`", row.takes)
        assert f"| {' | '.join(cells)} |" in PAGE
        settings = ", ".join(f"`{entry}`" for entry in solved(row)) or "none"
        assert f"| {row.name} | `{row.problem}` | {settings} |" in PAGE


@pytest.mark.parametrize("name", KINDS)
def test_one_verb_answers_every_kind(name):
    method, kind = KINDS[name]
    answer = sf.solve(name, **BRIEFLY.get(name, {}))
    assert chosen(sf.find(name)).name == method
    assert isinstance(answer, kind)


def test_there_is_one_catalogue_of_names():
    known = names()
    assert len(known) == len(set(known))
    assert {*NAMED_LINES} <= {*known}
    for name in known:
        assert chosen(sf.find(name)).name in ("self-similar", "space-time")
    with pytest.raises(sf.SceneError, match=r"no scene called 'tpv206'; did you mean tpv205\?"):
        sf.solve("tpv206")


@pytest.mark.parametrize("name", names())
def test_equal_inputs_are_equal_problems_that_travel(name):
    """Scenes of numbers, tables and expressions; one number more makes another problem."""
    scene = sf.find(name)
    for other in (sf.find(name), pickle.loads(pickle.dumps(scene)), deepcopy(scene)):
        assert other == scene
        assert hash(other) == hash(scene)
    number = next(key for key, known in numbers_of(scene).items() if known.value)
    moved = with_numbers(scene, {number: 0.99 * numbers_of(scene)[number].value})
    assert moved != scene


def test_a_table_keeps_its_own_numbers():
    x, values = np.array([0.0, 1.0]), np.array([2.0, 3.0])
    table, again = sf.Table(x, values), sf.Table(x, values)
    values[0] = 7.0
    assert table == again
    assert table(0.0) == 2.0
    assert table != sf.Table(x, values)


def test_settings_of_a_march_in_a_scene_leave_its_method_alone():
    """An exact answer passes over them, and a march takes those that it knows."""
    given = {"end_time": 0.25, "nodes": 64, "frames": 10}
    exact, marched = (sf.solve(replace(sf.find(name), run=given)) for name in ("preloaded", "ramp"))
    assert exact.zones == sf.solve("preloaded").zones
    assert (marched.end_time, marched.nodes) == (0.25, 64)
    with pytest.raises(sf.SceneError, match=r"unknown key run\.node; did you mean nodes"):
        replace(sf.find("ramp"), run={"node": 64})


@pytest.mark.parametrize(
    ("problem", "settings", "said"),
    [
        ("preloaded", {"nodes": 9}, "nodes is no setting of self-similar for a Scene, which takes"),
        ("growing-load", {"rtol": 1.0}, "for a Scene, which takes none"),
        ("ramp", {"tol": 1e-3}, "which takes end_time, nodes, rtol, .*length"),
        ("punch", {"node": 9}, "which takes end_time, nodes, rtol, .*longest"),
        (replace(sf.find("punch"), run={}), {}, "give end_time"),
        ("preloaded", {"method": "fem"}, "method must be one of auto, self-similar, space-time"),
        ("pair-slip", {"method": "space-time"}, "got a Scene of two solids"),
        ("ramp", {"method": "self-similar"}, "takes step loads only"),
        (
            SOLID,
            {},
            "problem must be a Scene, or",
        ),
    ],
)
def test_what_a_method_does_not_know_is_refused(problem, settings, said):
    with pytest.raises(sf.SceneError, match=said):
        sf.solve(problem, **settings)


def test_where_no_method_takes_a_scene_each_that_came_close_says_why():
    wave = replace(SCENE, load=sf.IncidentWave("SV", 45.0, stress=0.05))
    with pytest.raises(sf.SceneError, match=r"self-similar: the front .* space-time: a march dep"):
        sf.solve(wave)
    assert sf.solve(wave, method="space-time", nodes=32, end_time=0.3).status
    held = replace(SCENE, load=sf.IncidentWave("SV", -10.0, stress=2.0))
    with pytest.raises(sf.SceneError) as refusal:  # both for the same reason, said once
        sf.solve(held)
    assert str(refusal.value).count("the wave alone exceeds friction") == 1


def test_friction_that_falls_with_slip_rate_is_marched_unless_the_exact_answer_is_asked_for():
    falling = under(SCENE, sf.RateWeakening(1.0, 0.9, 5.0))
    assert isinstance(sf.solve(falling, nodes=64), sf.Marched)
    assert isinstance(sf.solve(falling, method="self-similar", rtol=1e-2), sf.Solution)


# --- equal bodies given as two --------------------------------------------------------------------

EQUAL = {
    "stick gap at the Rayleigh wave": SCENE,
    "little friction": replace(SCENE, friction=0.03),
    "opening beside the slot": replace(SCENE, friction=0.2, load=sf.Tractions(-0.5, 2.0)),
    "opening ahead": sf.find("tap"),
    "viscous film": under(replace(SCENE, friction=0.2), sf.Coulomb(1.0, viscosity=0.1)),
    "reverse slip": sf.find("auxetic"),
}


def pair_of(scene, contrast=0.0):
    """A scene as two bodies, whose moduli differ by a share."""
    other = replace(scene.material, shear_modulus=scene.material.shear_modulus * (1 + contrast))
    return replace(scene, lower_material=other)


@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
@pytest.mark.parametrize("name", EQUAL)
def test_equal_bodies_given_as_two_are_one_body(name, rtol):
    scene = EQUAL[name]
    first, two = sf.solve(scene, rtol=rtol), sf.solve(pair_of(scene), rtol=rtol)
    assert two.zones == first.zones
    assert two.openings == first.openings
    assert (two.status, two.error_estimate) == (first.status, first.error_estimate)


@pytest.mark.parametrize("name", EQUAL)
def test_bodies_that_are_nearly_equal_are_one_body_with_a_larger_error(name):
    scene, contrast = EQUAL[name], 1e-9
    first, two = sf.solve(scene, rtol=1e-7), sf.solve(pair_of(scene, contrast), rtol=1e-7)
    assert two.zones == first.zones
    assert two.status == "converged"
    assert two.error_estimate == pytest.approx(first.error_estimate + 4 * contrast, rel=1e-6)
    doubtful = sf.solve(pair_of(scene, 1e-7), rtol=1e-7)
    assert doubtful.status.startswith("the error estimate 4")


def test_a_survey_and_a_derivative_of_equal_bodies_are_those_of_one():
    scene, friction = EQUAL["stick gap at the Rayleigh wave"], [0.2, 0.3]
    first, two = (sf.survey(each, friction=friction) for each in (scene, pair_of(scene)))
    for name in ("edges", "edge_slip_rate"):
        known = first[name].values
        assert two[name].values == pytest.approx(known, rel=1e-5, abs=1e-6, nan_ok=True)
    slopes = [sf.solve(each).derivative("friction").zones for each in (scene, pair_of(scene))]
    assert slopes[0] == slopes[1]


def test_what_goes_on_with_a_march_ends_if_that_was_interrupted():
    halted = sf.solve(
        "ramp", nodes=64, progress=lambda time, end: signal.raise_signal(signal.SIGINT)
    )
    assert halted.is_interrupted
    with pytest.raises(KeyboardInterrupt):
        whole(halted)
    exact = sf.solve("preloaded")
    assert whole(exact) is exact
