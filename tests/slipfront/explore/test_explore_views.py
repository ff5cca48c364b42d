"""Addresses, arrays, maps and files of the page, which need no page."""

from __future__ import annotations

import contextlib
import json
import math
import tomllib
from dataclasses import asdict, replace

import numpy as np
import pytest
from catalogue import solved, unit_scene

from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.figures.fronts import MARGIN
from semianalytic import Coulomb, Harmonic, Ramp, SceneError, SlipWeakening, solve
from semianalytic.regimes import regime
from semianalytic.scene.given.finding import find_scene
from slipfront.explore import controls, downloads, maps, views
from tests.slipfront.explore.test_explore import SCENES, STEEL


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
        ("?friction=-1", "friction must be 0 or more"),
        ("?friction=much", "must be a number"),
        ("?nonsense=1", "no scene has"),
        ("?law=none", "must be one of"),
        ("?poisson_ratio=0.7", "0.5"),
        ("?lower_body=another&modulus_ratio=0", "shear_modulus must be positive"),
        ("?lower_body=another&density_ratio=1e9", "must not differ by more than a factor"),
        ("?lower_body=another&mode=antiplane", "between different bodies the exact solver takes"),
    ],
)
def test_an_address_that_is_no_scene_is_refused(query, words):
    with pytest.raises(SceneError, match=words):
        controls.values_from_query(query, STEEL)


def test_numbers_of_any_size_are_a_scene_or_a_refusal():
    """What an address may hold is not only what sliders reach."""
    numbers = [slider.name for slider in controls.sliders(STEEL)] + ["shear_modulus", "density"]
    sizes = ("0", "-1", "0.3", "5e6", "1e30", "1e-30", "1e155", "1e308", "-1e308", "5e-324", "nan")
    draw, shown = np.random.default_rng(8), 0
    for _ in range(300):
        names = draw.choice(numbers, draw.integers(1, 4), replace=False)
        query = "?" + "&".join(f"{name}={draw.choice(sizes)}" for name in names)
        with contextlib.suppress(SceneError):
            values = controls.values_from_query(query, STEEL)
            sliders = controls.sliders(controls.scene_of(values))
            json.dumps([values, [asdict(slider) for slider in sliders]], allow_nan=False)
            shown += 1
    assert shown > 30


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
    strength = scene.coefficient * solution.pressure(view.x * length, time)
    np.testing.assert_allclose(view.bound * stress_scale(scene), strength, rtol=1e-9)
    assert np.all(np.abs(view.shear) <= view.bound + 1e-7)
    wedges = views.space_time_view(solution).wedges
    slipping = [(start, end) for kind, start, end in wedges if kind != "open"]
    edges = [(zone.inner, zone.outer) for zone in solution.zones]
    np.testing.assert_allclose(slipping, np.array(edges) / scene.material.shear_speed)


def test_a_march_is_shown_by_its_senses():
    marched = solve(
        unit_scene(0.1, shear_history=Harmonic(3.0)), method="space-time", end_time=1.0, nodes=64
    )
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


def test_pictures_end_near_what_happens_where_the_p_wave_is_far_ahead():
    """At a Poisson ratio of 0.4999 it is 71 times faster than the shear wave."""
    usual, rubber = (solved(unit_scene(0.3, (1.0, 0.0), nu=nu)) for nu in (0.25, 0.4999))
    for solution, far in ((usual, 3**0.5), (rubber, 4 * rubber.zones[-1].outer)):
        end = views.end_time(solution.scene)
        assert far * end == pytest.approx(views.field_view(solution, 20).reach / MARGIN)
        assert far * end == pytest.approx(views.space_time_view(solution).reach / MARGIN)
        assert far * end == pytest.approx(views.interface_view(solution).x[-1] / MARGIN)
    assert {"P", "S"} - {name for name, *_ in views.field_view(usual, 20).names} == set()
    assert "P" not in {name for name, *_ in views.field_view(rubber, 20).names}


def test_the_angle_of_a_wave_has_a_slider_and_its_front_is_drawn():
    scene = find_scene("incident-sv")
    (slider,) = (slider for slider in controls.sliders(scene) if slider.name == "angle")
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


@pytest.mark.parametrize("law", [None, Coulomb(1.0, viscosity=0.1)])
def test_a_map_names_regimes(law, monkeypatch):
    monkeypatch.setattr(maps, "SIZE", 4)
    monkeypatch.setattr(maps, "SIZE_ONE_BY_ONE", 3)
    scene = unit_scene(law=law)
    told = []
    drawn = maps.regime_map(scene, lambda *arguments: told.append(arguments))
    size = len(drawn.image)
    assert told[-1] == (size, size)
    low, high = drawn.friction
    friction = low + (high - low) * 1.5 / size
    nu = maps.POISSON_RATIOS[0] + np.ptp(maps.POISSON_RATIOS) * (size - 0.5) / size
    solution = solved(unit_scene(friction, nu=nu, law=law))
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
    scene = unit_scene(law=SlipWeakening(1.0, 0.5, 0.1))
    assert "sf.solve(scene, end_time=1.0)" in downloads.program(scene)


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


def test_displacement_in_the_bodies_jumps_by_the_slip():
    solution = solved(unit_scene())
    view = views.field_view(solution, 10, 0.5, views.DISPLACEMENT)
    middles = view.reach * (2 * (np.arange(10) + 0.5) / 10 - 1)
    expected = np.hypot(*solution.displacement(middles[6], middles[7], 0.5)) / 2
    assert view.size[7, 6] == pytest.approx(min(expected, view.largest))
    names = {name for name, *_ in view.names}
    assert {"S", "P"} <= names
