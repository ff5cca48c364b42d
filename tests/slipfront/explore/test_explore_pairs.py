"""The page of two different bodies: controls, address, pictures, refusals and files."""

import tomllib

import numpy as np
import pytest
from bokeh.document import Document

import slipfront as sf
from semianalytic.scene.given.finding import find_scene
from slipfront.explore import controls
from slipfront.explore.downloads import FILES, program
from slipfront.explore.jobs import Moment, solved_field
from slipfront.explore.page import Session
from slipfront.explore.pictures import WAVES
from slipfront.explore.views import interface_view, space_time_view
from tests.slipfront.explore.test_explore import told_by

pytestmark = pytest.mark.usefixtures("alone")
NAMED_PAIRS = ("pair-slip", "pair-opening")
every = pytest.mark.parametrize("name", NAMED_PAIRS)


@every
def test_an_address_holds_both_bodies(name):
    pair = sf.find(name)
    values = controls.defaults(pair)
    assert controls.scene_of(values) == pair
    query = controls.query_of(values)
    assert "lower_body=another" in query
    assert controls.scene_of(controls.values_from_query(query, find_scene("preloaded"))) == pair


def test_addresses_of_identical_bodies_say_nothing_of_a_lower_one():
    values = controls.defaults(find_scene("preloaded"))
    assert "lower" not in controls.query_of(values)
    assert values["lower_body"] == controls.ALIKE
    alike = {"modulus_ratio": 1.0, "density_ratio": 1.0, "lower_body": controls.ANOTHER}
    assert controls.scene_of(values | alike) == find_scene("preloaded")


def test_the_menu_has_pairs_and_controls_are_shown_with_another_body():
    session = Session(Document(), find_scene("preloaded"), "")
    variables = session._document.template_variables
    assert set(NAMED_PAIRS) <= set(variables["scenes"])
    shown = variables["given"]["shown"]["lower_body"]
    assert shown[controls.ANOTHER] == controls.PARTS["lower_body"][controls.ANOTHER]
    assert set(shown[controls.ANOTHER]) <= set(variables["sliders"])


@pytest.mark.thinned(2)
@every
def test_a_move_is_answered_by_the_exact_solver_of_pairs(name, alone):
    pair = sf.find(name)
    session = Session(Document(), pair, "")
    values = controls.defaults(pair) | {"modulus_ratio": 2.4}
    session._show(values, True, 0.0)
    told = told_by(session)
    assert told["status"] == "converged"
    lower = sf.Material(2.4, 1.2, 0.25)
    moved = sf.Scene(pair.material, pair.friction, pair.base, pair.load, lower_material=lower)
    answer = sf.solve(moved, rtol=1e-5)  # three digits are shown
    outer = f"{answer.zones[0].outer:.3g}"
    assert outer in told["readings"][-1][1]
    assert session._answer.scene == moved
    assert [job[1] for job in alone] == [moved]  # its field, and no map
    kinds = [kind for kind, _ in told["readings"]]
    assert kinds == (["open", "slip"] if answer.openings else ["slip"])
    session._show(values, False, 0.0)
    assert told_by(session)["map"].startswith("Maps are drawn")
    assert len(alone) == 2 or session._asked_field is not None


def test_pictures_are_those_of_the_answer_and_reach_beyond_the_faster_body():
    answer = sf.solve("pair-opening", rtol=1e-5)
    view, zones = interface_view(answer, 50), space_time_view(answer)
    np.testing.assert_allclose(view.slip_rate * 2, answer.slip_rate(view.x, 1.0), atol=1e-12)
    np.testing.assert_allclose(view.pressure, answer.pressure(view.x, 1.0), atol=1e-12)
    fastest = answer.scene.lower_material.longitudinal_speed
    assert view.x[-1] == pytest.approx(1.05 * fastest)
    assert zones.waves["lower P"] == pytest.approx(fastest)
    assert WAVES.keys() >= zones.waves.keys()
    assert {kind for kind, *_ in zones.wedges} == {"open", "slip"}
    field = solved_field(answer.scene, 12, 1e-4, Moment(), None)
    assert field.size.shape == (12, 12)
    assert np.isfinite(field.size).all()


@pytest.mark.thinned(2)
@every
def test_files_hold_both_bodies(name, tmp_path, capsys):
    answer = sf.solve(name)
    _, _, text = FILES["toml"](answer)
    assert tomllib.loads(text.decode())["lower_material"]["shear_modulus"] == 2.5
    (tmp_path / "scene.toml").write_bytes(text)
    assert sf.find(tmp_path / "scene.toml") == answer.scene
    exec(program(answer.scene), {})
    assert f"{answer.zones[0].outer:.6f}"[:6] in capsys.readouterr().out
    assert FILES["csv"](answer)[2].decode().splitlines()[1].startswith("x,slip_rate")
    assert FILES["svg"](answer)[2].startswith(b"<?xml")
