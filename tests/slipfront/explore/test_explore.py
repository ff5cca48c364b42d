"""The page of `slipfront explore` without a browser: controls, addresses, arrays, files, server."""

from __future__ import annotations

import contextlib
import json
import math
import socket
import tomllib
from dataclasses import asdict, replace

import numpy as np
import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Range1d
from catalogue import solved, unit_scene
from matplotlib.path import Path

from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.figures.fronts import moving_parts
from semianalytic import (
    Harmonic,
    Material,
    Ramp,
    Scene,
    SceneError,
    SlipWeakening,
    Step,
    Tractions,
    ViscousFriction,
    march,
    solve,
)
from semianalytic.regimes import regime
from semianalytic.scene.given.named import NAMED_SCENES, find_scene
from semianalytic.scene.units import unit
from slipfront.cli.commands import main
from slipfront.explore import controls, downloads, jobs, maps, views
from slipfront.explore.jobs import MarchViews, Moment, marched_field, marched_views, moment_in
from slipfront.explore.page import MOVING_NODES, MOVING_RTOL, Session
from slipfront.explore.pictures import SHADES, Board, SpaceTimePicture
from slipfront.explore.serving import make_server
from slipfront.explore.work import Worker

STEEL = Scene(
    Material(80e9, 7800.0, 0.29), 0.25, Tractions(5e6, 0.0), Tractions(0.0, 5e6), units="SI"
)
SCENES = {name: one.scene for name, one in NAMED_SCENES.items()} | {"steel": STEEL}


@pytest.mark.parametrize("name", SCENES)
def test_an_address_holds_the_scene(name):
    scene = SCENES[name]
    values = controls.defaults(scene)
    assert controls.scene_of(values) == scene
    query = controls.query_of(values)
    assert controls.scene_of(controls.values_from_query(query, STEEL)) == scene
    assert controls.values_from_query(query, STEEL)["units"] == scene.units


@pytest.mark.parametrize("name", ["preloaded", "viscous", "pulse", "steel", "incident-sv"])
def test_sliders_reach_their_own_scene(name):
    scene = SCENES[name]
    values = controls.defaults(scene)
    for slider in controls.sliders(scene):
        assert slider.low <= values[slider.name] <= slider.high
        assert 200 <= (slider.high - slider.low) / slider.step < 2001


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("?friction=-1", "must not be negative"),
        ("?friction=much", "must be a number"),
        ("?viscosity=nan", "must be a number"),  # though no film is asked for
        ("?load_shear=-inf", "must be a number"),
        ("?load_shear=5e-324", "neither so large nor so small"),
        ("?nonsense=1", "no scene has"),
        ("?law=none", "must be one of"),
        ("?poisson_ratio=0.7", "0.5"),
    ],
)
def test_an_address_that_is_no_scene_is_refused(query, words):
    with pytest.raises(SceneError, match=words):
        controls.values_from_query(query, STEEL)


def test_numbers_of_any_size_are_a_scene_or_a_refusal():
    """What an address may hold is not only what sliders reach."""
    numbers = [one.name for one in controls.sliders(STEEL)] + ["shear_modulus", "density"]
    sizes = ("0", "-1", "0.3", "5e6", "1e30", "1e-30", "1e155", "1e308", "-1e308", "5e-324", "nan")
    draw, shown = np.random.default_rng(8), 0
    for _ in range(300):
        names = draw.choice(numbers, draw.integers(1, 4), replace=False)
        query = "?" + "&".join(f"{name}={draw.choice(sizes)}" for name in names)
        with contextlib.suppress(SceneError):
            values = controls.values_from_query(query, STEEL)
            sliders = controls.sliders(controls.scene_of(values))
            json.dumps([values, [asdict(one) for one in sliders]], allow_nan=False)
            shown += 1
    assert shown > 30


@pytest.fixture
def alone(monkeypatch):
    """Sessions start no process beside them."""
    monkeypatch.setattr(Worker, "start", lambda *_: None)


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


def test_sliders_have_ranges_and_units_of_the_scene_in_the_address():
    query = controls.query_of(controls.defaults(STEEL))
    session = Session(Document(), find_scene("preloaded"), query)
    sliders = {one["name"]: one for one in given_to(session)["sliders"]}
    for name, dimension in UNITS_OF.items():
        assert sliders[name]["unit"] == unit(dimension, "SI")
    assert sliders["base_pressure"]["high"] == 1e7
    assert sliders["base_pressure"]["step"] == 1e4
    values = given_to(session)["values"]
    for slider in controls.sliders(STEEL):  # those of no part of the scene too
        assert slider.low <= values[slider.name] <= slider.high
    session._answer_to({"query": controls.query_of(controls.defaults(find_scene("tap")))})
    told = told_by(session)
    assert {one["unit"] for one in told["sliders"]} >= {"stress", "time"}
    assert told["values"]["units"] == ""


def test_sliders_stay_as_they_are_while_they_serve():
    """On the way back through the addresses of one scene."""
    session = Session(Document(), STEEL, "")
    before = given_to(session)["sliders"]
    session._answer_to({"query": "?load_shear=100000"})
    assert told_by(session)["sliders"] == before
    session._answer_to({"query": "?load_shear=1e9"})
    (slider,) = (one for one in told_by(session)["sliders"] if one["name"] == "load_shear")
    assert slider["high"] == 2e9


def test_the_address_holds_the_moment():
    scene = controls.query_of(controls.defaults(STEEL))
    for moment in (Moment(), Moment(0.4), Moment(0.05, "displacement")):
        assert moment_in(scene + moment.query) == (moment, scene)
    session = Session(Document(), find_scene("preloaded"), scene + moment.query)
    assert given_to(session)["moment"] == moment._asdict()
    assert given_to(session)["values"] == controls.defaults(STEEL)


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
    assert "already slide" in refused_by(session)
    session._show(values | {"history": "ramp"}, True, 0.0)
    assert (told_by(session)["readings"], told_by(session)["stale"]) == ([], True)
    session._march_news("refusal", "The contact opens.")
    assert refused_by(session) == "The contact opens."

    def fail(*_, **__):
        raise ValueError("shapes do not match")

    session._show(values, True, 0.0)
    monkeypatch.setattr("slipfront.explore.page.solved", fail)
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
    assert [float(one) for one in ends] == sorted(map(float, ends))
    zones = solve(scene, rtol=MOVING_RTOL).zones
    expected = ["slip" if zone.sense > 0 else "reverse slip" for zone in zones]
    assert [kind for kind, _ in readings] == expected


def test_what_has_no_controls_is_refused():
    scene = unit_scene(load=(0.5, 1.0), shear_history=Ramp(0.5))
    with pytest.raises(SceneError, match="one history"):
        controls.defaults(scene)


@pytest.mark.parametrize("name", ["preloaded", "auxetic", "lift-off-shear", "antiplane", "steel"])
def test_views_are_those_of_the_answer(name):
    scene = SCENES[name]
    solution, time = solved(scene), views.end_time(scene)
    view = views.interface_view(solution)
    length = scene.material.shear_speed * time
    assert np.all(np.diff(view.x) > 0)
    rate = solution.slip_rate(view.x * length, time)
    scale = slip_rate_scale(scene)
    np.testing.assert_allclose(view.slip_rate * scale, rate, atol=1e-9 * scale)
    strength = scene.friction * solution.pressure(view.x * length, time)
    np.testing.assert_allclose(view.bound * stress_scale(scene), strength, rtol=1e-9)
    assert np.all(np.abs(view.shear) <= view.bound + 1e-7)
    wedges = views.space_time_view(solution).wedges
    slipping = [(start, end) for kind, start, end in wedges if kind != "open"]
    edges = [(zone.inner, zone.outer) for zone in solution.zones]
    np.testing.assert_allclose(slipping, np.array(edges) / scene.material.shear_speed)


def test_a_march_is_shown_by_its_senses():
    marched = march(unit_scene(0.1, shear_history=Harmonic(3.0)), 1.0, nodes=64)
    image = views.space_time_view(marched).image
    assert set(np.unique(image)) == {0.0, 1.0, 2.0}
    assert image[image.any(axis=1)][0].max() == views.KINDS.index("slip")  # forward comes first
    field = views.field_view(marched, 6)
    assert field.size.shape == (6, 6)
    assert np.all((field.size >= 0) & (field.size <= field.largest))


def test_the_field_is_the_speed_around_the_edge():
    solution = solved(unit_scene())
    view = views.field_view(solution, 9)
    middle = view.reach * (2 * 7.5 / 9 - 1)
    speed = np.hypot(*solution.velocity(middle, middle, 1.0)) / 2
    assert view.size[7, 7] == pytest.approx(min(speed, view.largest))


def test_the_angle_of_a_wave_has_a_slider_and_its_front_is_drawn():
    scene = find_scene("incident-sv")
    (slider,) = (one for one in controls.sliders(scene) if one.name == "angle")
    assert (slider.low, slider.high) == (-controls.STEEPEST, controls.STEEPEST)
    values = controls.defaults(scene)
    turned = controls.scene_of(values | {"angle": -35.0})
    assert turned == replace(scene, load=replace(scene.load, angle=-35.0))
    lines = views.field_view(solved(turned), 6).lines
    # of the incident front all points are on one line through x = -sin / c, at the angle
    slope = math.tan(math.radians(-35.0))
    straight = [
        np.ptp(y + x * slope) for x, y in lines if np.ptp(x) > 0.1 and abs(np.ptp(y)) > 0.01
    ]
    assert min(straight) < 1e-9


@pytest.mark.slow
def test_a_pulse_at_an_angle_is_marched_without_a_field():
    values = controls.defaults(find_scene("incident-sv")) | {"history": "pulse", "duration": 0.4}
    scene = controls.scene_of(values | {"shape": "triangle"})
    assert scene.pressure_history == scene.shear_history != Step()
    found = jobs.marched_views(scene, jobs.Moment(), lambda *_: None)
    assert found.field is None
    assert found.marched.status == "resolved"


@pytest.mark.parametrize("law", [None, ViscousFriction(0.1)])
def test_a_map_names_regimes(law, monkeypatch):
    monkeypatch.setattr(maps, "SIZE", 4)
    monkeypatch.setattr(maps, "SIZE_ONE_BY_ONE", 3)
    scene = unit_scene() if law is None else unit_scene(friction_law=law)
    told = []
    drawn = maps.regime_map(scene, lambda *one: told.append(one))
    size = len(drawn.image)
    assert told[-1] == (size, size)
    low, high = drawn.friction
    friction = low + (high - low) * 1.5 / size
    nu = maps.POISSON_RATIOS[0] + np.ptp(maps.POISSON_RATIOS) * (size - 0.5) / size
    solution = solved(unit_scene(friction, nu=nu, **({} if law is None else {"friction_law": law})))
    assert list(maps.REGIMES)[int(drawn.image[-1, 1])] == regime(solution)


def test_a_map_says_where_there_is_no_scene_and_where_it_opens(monkeypatch):
    monkeypatch.setattr(maps, "SIZE", 4)
    names = list(maps.REGIMES)
    drawn = maps.regime_map(unit_scene(0.5, (1.0, 0.4), (0.0, 1.0)), lambda *_: None)
    assert np.all(drawn.image[:, 0] == names.index("failed"))  # the base would slide
    drawn = maps.regime_map(unit_scene(0.5, (0.02, 0.0), (1.0, 0.0)), lambda *_: None)
    assert np.all(drawn.image == names.index("open"))


@pytest.mark.parametrize("name", ["preloaded", "viscous", "steel", "antiplane"])
def test_the_program_gives_the_same_answer(name, capsys):
    scene = SCENES[name]
    names: dict = {}
    exec(downloads.program(scene), names)
    assert names["scene"] == scene
    assert names["answer"].zones == solved(scene).zones
    assert capsys.readouterr().out
    lines = downloads.program(scene).splitlines()
    assert len(lines) <= 20
    assert max(map(len, lines)) <= 70  # the page shows them whole


def test_the_program_marches_what_is_marched():
    scene = unit_scene(friction_law=SlipWeakening(0.5, 0.1))
    assert "sf.march(scene, 1.0)" in downloads.program(scene)


@pytest.mark.thinned(6)
@pytest.mark.parametrize("form", downloads.FILES)
def test_files_hold_the_answer(form):
    solution = solved(STEEL)
    name, _, content = downloads.FILES[form](solution)
    if form in ("svg", "pdf", "png"):
        start = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}[form]
        assert content.startswith(start)
    elif form == "csv":
        lines = content.decode().splitlines()
        assert "m/s" in lines[0]
        assert lines[1] == "x,slip_rate,slip,shear_traction,pressure"
        x, rate, *_ = np.array([line.split(",") for line in lines[2:]], dtype=float).T
        np.testing.assert_allclose(rate, solution.slip_rate(x, views.end_time(STEEL)))
    elif form == "toml":
        assert tomllib.loads(content.decode())["friction"] == STEEL.friction
    assert name


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


@pytest.mark.parametrize("law", ["coulomb", "viscous"])
def test_what_is_told_is_the_answer(law, alone):
    session = Session(Document(), STEEL, "")
    values = controls.defaults(STEEL) | {"law": law, "viscosity": 1e6}
    session._show(values, True, 0.0)
    told = json.loads(session._told.value)
    lines = told["models"][session._interface._lines.id]["data"]
    view = views.interface_view(solve(controls.scene_of(values), rtol=MOVING_RTOL), MOVING_NODES)
    low, high = view.rate_limits
    shown = (view.slip_rate > low) & (view.slip_rate < high)
    assert shown.sum() > 100
    assert np.array(lines["rate"])[shown] == pytest.approx(
        view.slip_rate[shown], abs=1e-5 * (high - low)
    )
    assert np.array(lines["lower"]) == pytest.approx(-view.bound, rel=1e-4)


def test_a_field_that_comes_late_is_not_drawn_over_a_march(monkeypatch):
    asked = []
    monkeypatch.setattr(Worker, "start", lambda self, function, *rest: asked.append(function))
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
    assert asked[-1] is marched_views


@pytest.mark.thinned(2)
@pytest.mark.parametrize("share", [0.25, 1.0])
def test_pictures_show_the_moment_of_the_time_slider(share, alone):
    session = Session(Document(), STEEL, "")
    asked = {"values": controls.defaults(STEEL), "moving": True, "since": 0.0, "share": share}
    session._answer_to(asked)
    lines = told_by(session)["models"][session._interface._lines.id]["data"]
    solution, end = solve(STEEL, rtol=MOVING_RTOL), views.end_time(STEEL)
    x = np.array(lines["x"]) * STEEL.material.shear_speed * end
    scale = 2 * 5e6 / STEEL.material.shear_impedance * end
    expected = solution.slip(x, share * end) / scale
    assert np.array(lines["slip"]) == pytest.approx(expected, abs=2e-4 * expected.max())
    assert expected.max() > 0.1 * share


def test_displacement_in_the_bodies_jumps_by_the_slip():
    solution = solved(unit_scene())
    view = views.field_view(solution, 10, 0.5, views.DISPLACEMENT)
    middles = view.reach * (2 * (np.arange(10) + 0.5) / 10 - 1)
    expected = np.hypot(*solution.displacement(middles[6], middles[7], 0.5)) / 2
    assert view.size[7, 6] == pytest.approx(min(expected, view.largest))
    names = {name for name, *_ in view.names}
    assert {"S", "P"} <= names


def test_another_moment_of_a_march_is_not_marched_anew(monkeypatch):
    started = []
    monkeypatch.setattr(Worker, "start", lambda self, function, *rest: started.append(function))
    scene = unit_scene(friction_law=SlipWeakening(0.5, 0.3))
    marched = march(scene, 1.0, nodes=64)
    session = Session(Document(), scene, "")
    values = controls.defaults(scene)
    session._answer_to({"values": values, "moving": False, "since": 0.0})
    assert started[0] is marched_views
    moment = Moment()
    field = views.field_view(marched, 4)
    session._march_news("result", MarchViews(marched, moment, field))
    started.clear()
    session._answer_to({"values": values, "moving": False, "since": 0.0, "share": 0.5})
    assert started == [marched_field]
    assert not told_by(session).get("stale")
    session._answer_to({"values": values | {"friction": 0.2}, "moving": False, "since": 0.0})
    assert started[1] is marched_views


def test_a_map_is_kept_and_found_again(monkeypatch):
    started = []
    monkeypatch.setattr(
        Worker, "start", lambda self, function, *rest: started.append((function, rest))
    )
    session = Session(Document(), STEEL, "")

    def maps_after(scene):
        started.clear()
        session._draw_map(scene)
        return len(started)

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


def test_pages_of_other_addresses_are_not_answered():
    server = make_server(STEEL, 0)
    try:
        allowed = server._tornado.websocket_origins
        assert allowed == {f"{name}:{server.port}" for name in ("localhost", "127.0.0.1")}
    finally:
        server.stop()


def test_a_port_in_use_and_one_that_cannot_be(capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(SceneError, match=f"port {port} is in use"):
            make_server(STEEL, port)
    assert main(["explore", "--no-browser", "--port", "99999"]) == 2
    assert "between 0 and 65535" in capsys.readouterr().err


def test_only_this_machine_is_served():
    server = make_server(STEEL, 0)
    try:
        addresses = {one.getsockname()[0] for one in server._http._sockets.values()}
        assert addresses == {"127.0.0.1"}
    finally:
        server.stop()
