"""The page of `slipfront explore` without a browser: controls, addresses, arrays, files, server."""

from __future__ import annotations

import json
import socket
from dataclasses import replace

import numpy as np
import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Range1d
from catalogue import solved, unit_scene
from matplotlib.path import Path

from compare.figures.fronts import moving_parts
from semianalytic import Material, Scene, SceneError, SlipWeakening, Step, Tractions, solve
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.units import unit
from slipfront.explore import controls, jobs, maps, views
from slipfront.explore.board import Board
from slipfront.explore.jobs import Moment, Worker, marched_field, moment_in
from slipfront.explore.page import MOVING_NODES, MOVING_RTOL, NO_FIELD, Session
from slipfront.explore.pictures import SHADES, SpaceTimePicture
from slipfront.explore.serving import make_server

STEEL = Scene(
    Material(80e9, 7800.0, 0.29), 0.25, Tractions(5e6, 0.0), Tractions(0.0, 5e6), units="SI"
)
NAMED = {name: scene.scene for name, scene in NAMED_SCENES.items()}
SCENES = {name: listed for name, listed in NAMED.items() if listed.has_slot and not listed.grows}
SCENES["steel"] = STEEL


@pytest.fixture(scope="module")
def opened():
    """A page of steel, which takes most of a second."""
    return Session(Document(), STEEL, "")


@pytest.fixture
def steel(opened, alone):
    """The page of a scene, told to show it at its end time."""
    opened._moment = Moment()
    opened._show(controls.defaults(STEEL), True, 0.0)
    return opened


def given_to(session):
    """What the program of the page starts from."""
    return session._document.template_variables["given"]


def told_by(session):
    return json.loads(session._told.value)


UNITS_OF = {"base_pressure": "stress", "viscosity": "stress time / length", "rise_time": "time"}


def test_the_address_holds_the_scene_its_units_and_the_moment():
    query = controls.query_of(controls.defaults(STEEL))
    for moment in (Moment(), Moment(0.4), Moment(0.05, "displacement")):
        assert moment_in(query + moment.query) == (moment, query)
    session = Session(Document(), find_scene("preloaded"), query + moment.query)
    assert given_to(session)["moment"] == moment._asdict()
    values = given_to(session)["values"]
    assert values == controls.defaults(STEEL)
    sliders = {slider["name"]: slider for slider in given_to(session)["sliders"]}
    for name, dimension in UNITS_OF.items():
        assert sliders[name]["unit"] == unit(dimension, "SI")
    assert sliders["base_pressure"]["high"] == 1e7
    assert sliders["base_pressure"]["step"] == 1e4
    session._answer_to({"query": controls.query_of(controls.defaults(find_scene("tap")))})
    told = told_by(session)
    assert {slider["unit"] for slider in told["sliders"]} >= {"stress", "time"}
    assert told["values"]["units"] == ""


def test_sliders_stay_as_they_are_while_they_serve():
    """On the way back through the addresses of one scene."""
    session = Session(Document(), STEEL, "")
    before = given_to(session)["sliders"]
    session._answer_to({"query": "?load_shear=100000"})
    assert told_by(session)["sliders"] == before
    session._answer_to({"query": "?load_shear=1e9"})
    (slider,) = (slider for slider in told_by(session)["sliders"] if slider["name"] == "load_shear")
    assert slider["high"] == 2e9


@pytest.mark.parametrize("query", ["?time=0.01", "?time=2", "?time=nan", "?picture=heat"])
def test_a_moment_that_is_none_is_refused(query):
    with pytest.raises(SceneError, match="must be"):
        moment_in(query)


def test_a_moment_that_is_none_is_a_message():
    session = Session(Document(), STEEL, "?time=2")
    assert "must be" in given_to(session)["message"]
    assert given_to(session)["moment"] == Moment()._asdict()


def test_what_axes_are_over_is_told(steel):
    solid = STEEL.material
    expected = {
        "c_t T": (1.0, "m"),
        "T": (1 / solid.shear_speed, "s"),
        "τ₀": (5e6, "Pa"),
        "V₀": (1e7 / (solid.density * solid.shear_speed), "m/s"),
    }
    told = {symbol: text.split() for symbol, text in told_by(steel)["scales"]}
    assert told.keys() == expected.keys()
    for symbol, (value, name) in expected.items():
        assert float(told[symbol][0]) == pytest.approx(value, rel=5e-4)
        assert told[symbol][1] == name


def refused_by(session):
    told = told_by(session)
    assert told["stale"]
    assert told["status"] == "no answer"
    assert "error" not in told
    assert (told["readings"], told["scales"]) == ([], [])
    session._answer_to({"file": "csv"})
    assert "file" not in told_by(session)
    return told["message"]


def test_nothing_of_an_answer_stays_beside_a_refusal(steel, monkeypatch):
    session, values = steel, controls.defaults(STEEL)
    assert told_by(session)["status"] == "converged"
    session._show(values | {"base_shear": -4e6}, True, 0.0)
    # the address is that of the controls, not of the last scene that had an answer
    assert "base_shear=-4000000.0" in told_by(session)["query"]
    assert "already slide" in refused_by(session)
    session._show(values | {"history": "ramp"}, True, 0.0)
    assert (told_by(session)["readings"], told_by(session)["stale"]) == ([], True)
    session._march_news("refusal", "The contact opens.")
    assert refused_by(session) == "The contact opens."

    def fail(*_, **__):
        raise ValueError("shapes do not match")

    session._show(values, True, 0.0)
    monkeypatch.setattr("slipfront.explore.page.solve", fail)
    with pytest.raises(ValueError, match="shapes"):
        session._show(values, True, 0.0)
    assert "ValueError: shapes do not match" in refused_by(session)


def test_a_field_that_cannot_be_drawn_is_said(steel):
    steel._asked_field = None
    steel._field_news("refusal", "The process that computes it has ended; move a slider.")
    assert "has ended" in told_by(steel)["message"]


def test_that_there_is_no_map_is_said_of_the_first_scene_too(alone):
    scene = find_scene("ramp")
    session = Session(Document(), scene, "")
    session._draw_map(scene)
    assert "Maps are drawn" in told_by(session)["map"]


INFINITE = {
    f"{name} {friction}": replace(find_scene(name), friction=friction)
    for name, friction in (("remote-shock", 0.3), ("remote-shock", 0.0), ("stuck", 0.9))
}


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["preloaded", "auxetic", "lift-off-shear", "steel", *INFINITE])
def test_what_is_painted_is_what_the_contact_does(name):
    scene = (SCENES | INFINITE)[name]
    solution, view = solved(scene), views.space_time_view(solved(scene))
    board = Board()
    picture = SpaceTimePicture(board)
    picture.draw(view)
    drawn = board.news()[picture._wedges.id]["data"]
    kinds = {colour: kind for kind, colour in SHADES.items()}
    length, draw = scene.material.shear_speed * views.end_time(scene), np.random.default_rng(3)
    for _ in range(100):
        x, t = draw.uniform(0, view.reach), draw.uniform(0.01, 1)
        painted = [
            kinds[colour]
            for xs, ys, colour in zip(drawn["xs"], drawn["ys"], drawn["colour"], strict=True)
            if Path(list(zip(xs, ys, strict=True))).contains_point((x, t))
        ]
        parts = moving_parts(solution, t * views.end_time(scene))
        assert painted == [part.kind for part in parts if part.covers(x * length)]


@pytest.mark.thinned(9)
@pytest.mark.parametrize("nu", [0.0, 1 / 3, 0.45])
@pytest.mark.parametrize("friction", [0.0, 1e-9, 0.05])
def test_strips_that_are_not_empty_do_not_read_so(friction, nu, alone):
    """Slip without friction does reverse at c_R; only how wide that is differs."""
    scene = unit_scene(friction, nu=nu)
    session = Session(Document(), scene, "")
    session._show(controls.defaults(scene), True, 0.0)
    readings, ends = told_by(session)["readings"], []
    for _, text in readings:
        ends += text.removesuffix(" c_t").split(" … ")
        assert float(ends[-2]) < float(ends[-1])
    assert [float(end) for end in ends] == sorted(map(float, ends))
    zones = solve(scene, rtol=MOVING_RTOL).zones
    expected = ["slip" if zone.sense > 0 else "reverse slip" for zone in zones]
    assert [kind for kind, _ in readings] == expected


@pytest.mark.slow
def test_a_pulse_at_an_angle_is_marched_without_a_field(alone):
    values = controls.defaults(find_scene("incident-sv")) | {"history": "pulse", "duration": 0.4}
    scene = controls.scene_of(values | {"shape": "triangle"})
    assert scene.pressure_history == scene.shear_history != Step()
    marched = jobs.marched(scene, lambda *_: None)
    assert marched.status == "resolved"
    session = Session(Document(), scene, "")
    session._march_news("result", marched)
    assert told_by(session)["message"] == NO_FIELD
    assert alone == []


def test_a_worker_answers_refuses_and_is_stopped():
    worker = Worker()
    try:
        worker.start(maps.regime_map, replace(find_scene("stuck"), friction=1.0))
        worker.start(float, "no number")
        first = None
        while first is None:
            first = worker.news()
        assert first.kind == "refusal"
        assert worker.news() is None
    finally:
        worker.stop()
    assert not worker.busy


def test_only_what_differs_is_told():
    board, source, axis = Board(), ColumnDataSource(), Range1d()
    board.fill(source, x=[1.0])
    board.follow(axis, 0.0, 1.0)
    news = board.news()
    assert news[source.id] == {"data": {"x": [1.0]}}
    assert news[axis.id]["start"] < 0.0 < 1.0 < news[axis.id]["end"]
    board.fill(source, x=[1.0])
    for low, high in ((0.0, 0.7), (0.3, 1.0)):
        board.follow(axis, low, high)
        assert board.news() == {}
    for low, high in ((0.0, 0.4), (0.0, 1.5), (-1.0, 1.0)):
        board.follow(axis, low, high)
        told = board.news()[axis.id]
        assert told["start"] <= low < high <= told["end"]
        assert told["reset_start"] == told["start"]


@pytest.mark.parametrize("viscosity", [1e6, 0.0])
def test_what_is_told_is_the_answer(viscosity, steel):
    values = controls.defaults(STEEL) | {"viscosity": viscosity}
    steel._show(values | {"friction": 0.3}, True, 0.0)  # what stays is not told again
    steel._show(values, True, 0.0)
    lines = told_by(steel)["models"][steel._interface._lines.id]["data"]
    view = views.interface_view(solve(controls.scene_of(values), rtol=MOVING_RTOL), MOVING_NODES)
    low, high = view.rate_limits
    shown = (view.slip_rate > low) & (view.slip_rate < high)
    assert shown.sum() > 100
    assert np.array(lines["rate"])[shown] == pytest.approx(
        view.slip_rate[shown], abs=1e-5 * (high - low)
    )
    assert np.array(lines["lower"]) == pytest.approx(-view.bound, rel=1e-4)


def test_a_field_that_comes_late_is_not_drawn_over_a_march(alone):
    session = Session(Document(), STEEL, "")
    values = controls.defaults(STEEL)
    session._show(values, False, 0.0)
    late = views.field_view(solved(STEEL), 4)
    session._field_news("result", late)
    drawn = session._field._image.data
    assert len(drawn["image"]) == 1
    session._show(values | {"law": "slip-weakening"}, False, 0.0)
    session._field_news("result", views.field_view(solved(STEEL), 6))
    assert session._field._image.data is drawn
    assert alone[-1][0] is jobs.marched


@pytest.mark.thinned(2)
@pytest.mark.parametrize("share", [0.25, 1.0])
def test_pictures_show_the_moment_of_the_time_slider(share, steel):
    other = controls.defaults(STEEL) | {"friction": 0.3}
    steel._answer_to({"values": other, "moving": True, "since": 0.0, "share": 0.5})
    asked = {"values": controls.defaults(STEEL), "moving": True, "since": 0.0, "share": share}
    steel._answer_to(asked)
    lines = told_by(steel)["models"][steel._interface._lines.id]["data"]
    solution, end = solve(STEEL, rtol=MOVING_RTOL), views.end_time(STEEL)
    x = np.array(lines["x"]) * STEEL.material.shear_speed * end
    scale = 2 * 5e6 / STEEL.material.shear_impedance * end
    expected = solution.slip(x, share * end) / scale
    assert np.array(lines["slip"]) == pytest.approx(expected, abs=2e-4 * expected.max())
    assert expected.max() > 0.1 * share


def test_another_moment_of_a_march_is_not_marched_anew(alone):
    scene = unit_scene(law=SlipWeakening(1.0, 0.5, 0.3))
    marched = solve(scene, method="space-time", end_time=1.0, nodes=64)
    session = Session(Document(), scene, "")
    values = controls.defaults(scene)
    session._answer_to({"values": values, "moving": False, "since": 0.0})
    assert alone.pop()[0] is jobs.marched
    session._march_news("result", marched)
    assert alone.pop()[0] is marched_field
    alone.clear()
    session._answer_to({"values": values, "moving": False, "since": 0.0, "share": 0.5})
    assert [job[0] for job in alone] == [marched_field]
    assert not told_by(session).get("stale")
    session._answer_to({"values": values | {"friction": 0.2}, "moving": False, "since": 0.0})
    assert alone[1][0] is jobs.marched


def test_a_map_is_kept_and_found_again(alone):
    session = Session(Document(), STEEL, "")

    def maps_after(scene):
        alone.clear()
        session._draw_map(scene)
        return len(alone)

    def done(scene):
        size = maps.highest_friction(scene)
        drawn = maps.RegimeMap(np.zeros((2, 2)), maps.POISSON_RATIOS, (0.0, size))
        session._map_news("result", drawn)

    assert maps_after(STEEL) == 1
    done(STEEL)
    assert maps_after(replace(STEEL, friction=0.9)) == 0  # on the map, which ends at 1
    assert maps_after(replace(STEEL, material=Material(80e9, 7800.0, 0.1))) == 0
    other = replace(STEEL, base=Tractions(4e6, 0.0))
    assert maps_after(other) == 1
    done(other)
    assert maps_after(STEEL) == 0
    assert maps_after(replace(STEEL, friction=1.2)) == 1


def test_only_this_machine_and_its_own_pages_are_answered():
    server = make_server(STEEL, 0)
    try:
        allowed = server._tornado.websocket_origins
        assert allowed == {f"{name}:{server.port}" for name in ("localhost", "127.0.0.1")}
        addresses = {entry.getsockname()[0] for entry in server._http._sockets.values()}
        assert addresses == {"127.0.0.1"}
    finally:
        server.stop()


def test_a_port_in_use_and_one_that_cannot_be(refused):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(SceneError, match=f"port {port} is in use"):
            make_server(STEEL, port)
    assert "between 0 and 65535" in refused("explore --no-browser --port 99999")
