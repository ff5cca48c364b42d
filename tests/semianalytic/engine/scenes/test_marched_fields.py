"""Fields in the bodies after a march: against exact ones, the interface, and the laws of solids."""

from dataclasses import replace
from functools import cache

import meshio
import numpy as np
import pytest
from catalogue import STEEL, unit_scene

import semianalytic as sf
from fem import simulate
from semianalytic.engine.bodies import spectrum
from semianalytic.scene.given.finding import find_scene
from tests.semianalytic.engine.scenes.runs import march

QUANTITIES = ("velocity", "stress", "displacement")
HARD = {"friction": 300.0, "base": (3.0, 0.3)}


@cache
def marched_once(scene, end_time, nodes):
    return march(scene, end_time=end_time, nodes=nodes, estimate=False)


def points(scene, count, far=1.2):
    """Random ones on six depths of both bodies, where waves have come and a little beyond."""
    reach = scene.fastest_speed / scene.material.shear_speed
    x = far * reach * np.random.default_rng(0).uniform(-1, 1, (count // 6, 6))
    y = reach * np.array([0.06, -0.06, 0.3, -0.3, 0.7, -0.7]) + 0 * x
    return x.ravel(), y.ravel()


def off_by(values, exact, at_rest):
    """L1 of the error over that of what has changed, where the exact values are finite."""
    known = np.isfinite(exact).all(axis=0)
    change = np.abs(exact - at_rest)[:, known].sum()
    return np.abs(values - exact)[:, known].sum() / change


def errors(scene, nodes, count=60, reach=1.2):
    """Of all quantities after a march, against the self-similar solution."""
    end = 1 / scene.material.shear_speed
    marched, exact = marched_once(scene, end, nodes), sf.solve(scene)
    at = *points(scene, count, reach), 0.97 * end
    return [
        off_by(
            getattr(marched, name)(*at),
            getattr(exact, name)(*at),
            getattr(marched, name)(*at[:2], 0.0),
        )
        for name in QUANTITIES
    ]


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    "scene",
    [
        find_scene("preloaded"),
        find_scene("remote-shock"),
        find_scene("antiplane"),
        unit_scene(0.5, (1.0, 0.3), (0.8, -0.9), nu=-0.25),
        unit_scene(0.4, (0.0, 0.0), (1.0, -0.6), load_on="remote"),
        unit_scene(0.4, (0.5, -0.1), (0.5, 0.7), mode="antiplane", load_on="remote"),
    ],
    ids=["preloaded", "shock", "antiplane", "auxetic shock", "slides", "slides along z"],
)
def test_fields_of_steps_are_those_of_the_exact_solution(scene):
    velocity, stress, displacement = errors(scene, 256)
    assert max(velocity, stress) < 1e-3
    assert displacement < 4e-4


def on_interface(marched, name, row, side):
    """A row of a quantity at all nodes, on the upper face or the lower one, at the end."""
    return getattr(marched, name)(marched.interface.x, side * 0.0, marched.end_time)[row]


def test_antiplane_slip_leaves_the_waves_of_pressure_to_the_plane():
    scene = unit_scene(0.4, (0.5, -0.1), (0.3, 0.7), mode="antiplane")
    marched, at = march(scene, nodes=64, estimate=False), (*points(scene, 30), 0.97)
    exact = sf.solve(scene).velocity(*at)
    for rows in (slice(2), slice(2, 3)):
        assert off_by(marched.velocity(*at)[rows], exact[rows], 0.0) < 0.01


@pytest.mark.parametrize("side", [1, -1])
def test_fields_end_in_the_traction_of_the_interface(side):
    marched = marched_once(find_scene("ramp"), 1.0, 256)
    x, depth = marched.interface.x[20:], side * marched.nearest_depth
    near, far = (marched.stress(x, y, marched.end_time)[2] for y in (depth, 2 * depth))
    shear = 2 * near - far
    known = marched.interface.shear_traction[-1, 20:]
    assert np.abs(shear - known).sum() < 0.01 * np.abs(known).sum()


def test_faces_move_apart_by_slip():
    marched = marched_once(find_scene("ramp"), 1.0, 256)
    for name, recorded in (("velocity", "slip_rate"), ("displacement", "slip")):
        apart = on_interface(marched, name, 0, 1) - on_interface(marched, name, 0, -1)
        known = getattr(marched.interface, recorded)[-1]
        assert np.abs(apart - known).sum() < 5e-3 * np.abs(known).sum()


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("wave", "within"),
    [
        (sf.IncidentWave("SH", angle=-40.0, stress=0.3), 1e-3),
        (sf.IncidentWave("SV", angle=-20.0, stress=0.3), 3e-3),
        (sf.IncidentWave("P", angle=30.0, stress=0.3, from_="above"), 0.012),  # from the slot on
    ],
)
def test_under_an_incident_wave_the_plane_wave_is_added(wave, within):
    mode = "antiplane" if wave.kind == "SH" else "in-plane"
    scene = replace(unit_scene(0.3, load=(0.0, 0.0), nu=0.25, mode=mode), load=wave)
    for error in errors(scene, 192, reach=0.95):
        assert error < within


def superposed(scene, x, y, t):
    """Velocity of a stuck interface: a kink makes of it what a step makes of displacement."""
    total = np.zeros((3 if scene.antiplane else 2, *np.shape(x)))
    for mode, load, history in (
        ("I", scene.load.pressure, scene.pressure_history),
        (scene.shear_mode, scene.load.shear, scene.shear_history),
    ):
        sizes = (1.0, 0.0) if mode == "I" else (0.0, 1.0)
        step = sf.solve(unit_scene(**HARD, load=sizes, mode=scene.mode))
        rows = slice(2, None) if mode == "III" else slice(2)
        for start, height in history.pieces.jumps:
            total[rows] += load * height * step.velocity(x, y, t - start)[rows]
        for start, slope in history.pieces.kinks:
            total[rows] += load * slope * step.displacement(x, y, t - start)[rows]
    return total


@pytest.mark.thinned(2)
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_kinks_on_a_stuck_interface_are_superposed(mode):
    scene = unit_scene(
        **HARD,
        load=(1.0, 1.0),
        mode=mode,
        shear_history=sf.Pulse(0.6, "triangle"),
        pressure_history=sf.Tabulated((0.0, 0.2, 0.2, 0.5), (0.0, 1.0, 0.5, 0.9)),
    )
    marched, (x, y) = (march(scene, nodes=256, estimate=False), points(scene, 60))
    velocity = marched.velocity(x, y, 0.93)
    assert marched.interface.slip.max() == 0
    assert off_by(velocity, superposed(scene, x, y, 0.93), 0.0) < 1e-3


def test_far_behind_the_edge_the_slot_sends_plane_waves():
    scene = unit_scene(
        **HARD, load=(0.4, 1.0), shear_history=sf.Ramp(0.5), pressure_history=sf.Ramp(0.25)
    )
    marched, solid = march(scene, nodes=64, estimate=False), scene.material
    y = np.array([0.6, -0.6, 1.9])
    v_x, v_y = marched.velocity(-50.0, y, 0.9)
    sheared = scene.load.shear * scene.shear_history.value(0.9 - np.abs(y))
    pressed = scene.load.pressure * scene.pressure_history.value(
        0.9 - np.abs(y) / solid.longitudinal_speed
    )
    np.testing.assert_allclose(v_x, np.sign(y) * sheared, atol=1e-3)
    np.testing.assert_allclose(v_y, -np.sign(y) * pressed / solid.longitudinal_speed, atol=1e-3)
    np.testing.assert_allclose(marched.stress(-50.0, y, 0.9)[1], pressed - 3.0, atol=1e-3)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_fields_obey_hookes_law_and_move_as_they_say(mode):
    scene = unit_scene(
        0.1,
        load=(0.1, 1.0),
        mode=mode,
        shear_history=sf.Harmonic(1.5),
        pressure_history=sf.Ramp(0.7),
        law=sf.SlipWeakening(1.0, 0.5, 0.1),
    )
    marched = march(scene, nodes=64, estimate=False)
    x, y, step = *np.array([[-0.6, -0.3, 0.7], [0.3, -0.35, -0.25]]), 1e-3

    def slope(dx, dy, dt):
        ends = (
            marched.displacement(x + s * dx * step, y + s * dy * step, 0.9 + s * dt * step)
            for s in (1, -1)
        )
        return np.subtract(*ends) / (2 * step)

    along, across, moving = slope(1, 0, 0), slope(0, 1, 0), slope(0, 0, 1)
    lame = 2 * scene.material.poisson_ratio / (1 - 2 * scene.material.poisson_ratio)
    dilation = lame * (along[0] + across[1])
    expected = [dilation + 2 * along[0], dilation + 2 * across[1], across[0] + along[1]]
    expected += [along[2], across[2]] if scene.antiplane else []
    change = marched.stress(x, y, 0.9) - marched.stress(x, y, 0.0)
    assert np.abs(change - expected).max() < 2e-3 * np.abs(change).max()
    velocity = marched.velocity(x, y, 0.9)
    assert np.abs(velocity - moving).max() < 2e-3 * np.abs(velocity).max()


@pytest.mark.slow
def test_many_depths_are_interpolated(monkeypatch):
    marched = march(find_scene("ramp"), nodes=128, estimate=False)
    x = np.linspace(-1.5, 1.5, 41)
    y = np.linspace(0.05, 2.0, 41)
    each = marched.stress(x, y, 1.0)
    monkeypatch.setattr(spectrum, "DEPTHS", 40)
    between = marched.stress(x, y, 1.0)
    assert 0 < off_by(between, each, marched.stress(x, y, 0.0)) < 0.02


def test_before_the_load_there_is_the_base():
    marched = march(find_scene("remote-shock"), nodes=32, estimate=False)
    np.testing.assert_array_equal(marched.stress(0.3, [0.1, -0.1], 0.0).T, [[0, -1, 1]] * 2)
    assert marched.velocity(0.3, np.zeros((4, 1)), np.zeros(5)).shape == (2, 4, 5)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("name", "nodes"), [("preloaded", 256), ("remote-shock", 128)])
def test_error_of_fields_is_bounded_by_its_estimate(name, nodes):
    scene = find_scene(name)
    _, error, _ = errors(scene, nodes)
    assert error < march(scene, nodes=nodes).field_error < 20 * error


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_finite_elements_under_slip_weakening_come_to_the_same_fields(tmp_path, mode):
    scene = unit_scene(
        base=(1.0, 0.0),
        load=(0.2, 1.0),
        mode=mode,
        pressure_history=sf.Ramp(0.3),
        shear_history=sf.Pulse(0.8, "triangle"),
        law=sf.SlipWeakening(1.0, 0.6, 0.05),
    )
    marched, off = march(scene, nodes=400, estimate=False), []
    for resolution in (16, 32):
        folder = tmp_path / str(resolution)
        simulate(scene, 1.0, resolution=resolution, snapshots=folder, frames=1)
        (picture,) = (meshio.read(path) for path in folder.glob("*.vtu") if "0000" not in path.name)
        x, y = picture.points[:, :2].T
        inside = (np.hypot(x, y) < 2.2) & (y != 0)
        exact = marched.velocity(x[inside], y[inside], 1.0)
        velocity = picture.point_data["velocity"][inside, : len(exact)].T
        off.append(off_by(velocity, exact, 0.0))
    assert off[1] < 0.7 * off[0] < 0.04


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("at", "reason"),
    [
        ((0.1, 0.1, 1.01), "ends at t = 1;"),
        ((np.nan, 0.1, 0.5), "finite"),
        ((0.1, 0.1, np.inf), "finite"),
        ((0.1, 0.1, 0.9), "covers the contact to x = 0.5 only"),
        ((0.6, 0.1, 0.9), "covers the contact to x = 0.5 only"),
    ],
)
def test_what_the_march_does_not_determine_is_refused(at, reason):
    marched = march(find_scene("preloaded"), end_time=1.0, nodes=32, length=0.5, estimate=False)
    with pytest.raises(sf.SceneError, match=reason):
        marched.velocity(*at)


def test_a_short_contact_determines_what_waves_from_beyond_have_not_reached():
    scene = find_scene("preloaded")
    short = march(scene, end_time=1.0, nodes=64, length=0.8, estimate=False)
    x, y, t = np.array([0.2, -0.4, 0.9]), np.array([0.3, -0.5, 0.9]), np.array([0.5, 0.9, 0.8])
    exact = sf.solve(scene).velocity(x, y, t)
    assert np.abs(short.velocity(x, y, t) - exact).max() < 5e-3


def test_any_units_will_do():
    scene, solid = unit_scene(0.3, load=(0.2, 1.0), shear_history=sf.Ramp(0.5)), STEEL
    length, stress = 0.25, 5e6
    time = length / solid.shear_speed
    base, load = sf.Tractions(stress, 0.0), sf.Tractions(0.2 * stress, stress)
    large = sf.Scene(solid, 0.3, base, load, shear_history=sf.Ramp(0.5 * time))
    first, other = (march(scene, end_time=1.0, nodes=32), march(large, end_time=time, nodes=32))
    x, y = points(scene, 10)
    units = {"velocity": stress / solid.shear_impedance, "stress": stress}
    for name in QUANTITIES:
        unit = units.get(name, stress * length / solid.shear_modulus)
        scaled = getattr(other, name)(length * x, length * y, 0.9 * time) / unit
        np.testing.assert_allclose(scaled, getattr(first, name)(x, y, 0.9), atol=1e-6)
