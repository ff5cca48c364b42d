"""The page of `slipfront explore` without a browser: controls, addresses, arrays, files, server."""

from __future__ import annotations

import json
import socket
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Range1d
from catalogue import unit_scene

from compare.cli.commands import main
from compare.explore import controls, downloads, maps, views
from compare.explore.jobs import marched_views
from compare.explore.page import MOVING_NODES, MOVING_RTOL, Session
from compare.explore.pictures import Board
from compare.explore.serving import make_server
from compare.explore.work import Worker
from semianalytic import (
    Harmonic,
    Material,
    Ramp,
    Scene,
    SceneError,
    SlipWeakening,
    Tractions,
    ViscousFriction,
    march,
    solve,
)
from semianalytic.regimes import regime
from semianalytic.scene.named import NAMED_SCENES, find_scene

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


@pytest.mark.parametrize("name", ["preloaded", "viscous", "pulse", "steel"])
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
        ("?nonsense=1", "no scene has"),
        ("?law=none", "must be one of"),
        ("?poisson_ratio=0.7", "0.5"),
    ],
)
def test_an_address_that_is_no_scene_is_refused(query, words):
    with pytest.raises(SceneError, match=words):
        controls.values_from_query(query, STEEL)


def test_what_has_no_controls_is_refused():
    scene = unit_scene(load=(0.5, 1.0), shear_history=Ramp(0.5))
    with pytest.raises(SceneError, match="one history"):
        controls.defaults(scene)


@pytest.mark.parametrize("name", ["preloaded", "auxetic", "lift-off-shear", "antiplane", "steel"])
def test_views_are_those_of_the_answer(name):
    scene = SCENES[name]
    solution, time = solve(scene), views.end_time(scene)
    view = views.interface_view(solution)
    length = scene.material.shear_speed * time
    assert np.all(np.diff(view.x) > 0)
    rate = solution.slip_rate(view.x * length, time)
    scale = rate[np.abs(rate).argmax()] / view.slip_rate[np.abs(view.slip_rate).argmax()]
    np.testing.assert_allclose(view.slip_rate * scale, rate, atol=1e-9 * abs(scale))
    assert np.all(np.abs(view.shear) <= view.bound + 1e-7)
    wedges = views.space_time_view(solution).wedges
    slipping = [(start, end) for kind, start, end in wedges if kind != "open"]
    edges = [(zone.inner, zone.outer) for zone in solution.zones]
    np.testing.assert_allclose(slipping, np.array(edges) / scene.material.shear_speed)


def test_a_march_is_shown_by_its_senses():
    marched = march(unit_scene(0.1, shear_history=Harmonic(3.0)), 1.0, nodes=64)
    image = views.space_time_view(marched).image
    assert set(np.unique(image)) == {0.0, 1.0, 2.0}
    field = views.field_view(marched, 6)
    assert field.speed.shape == (6, 6)
    assert np.all((field.speed >= 0) & (field.speed <= field.largest))


def test_the_field_is_the_speed_around_the_edge():
    solution = solve(unit_scene())
    view = views.field_view(solution, 9)
    middle = view.reach * (2 * 7.5 / 9 - 1)
    speed = np.hypot(*solution.velocity(middle, middle, 1.0)) / 2
    assert view.speed[7, 7] == pytest.approx(min(speed, view.largest))


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
    solution = solve(unit_scene(friction, nu=nu, **({} if law is None else {"friction_law": law})))
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
    assert names["answer"].zones == solve(scene).zones
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
    solution = solve(STEEL)
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
def test_what_is_told_is_the_answer(law):
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
    late = views.field_view(solve(STEEL), 4)
    session._field_news("result", late)
    drawn = session._field._image.data
    assert len(drawn["image"]) == 1
    session._show(values | {"law": "slip-weakening"}, False, 0.0)
    session._field_news("result", views.field_view(solve(STEEL), 6))
    assert session._field._image.data is drawn
    assert asked[-1] is marched_views


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
