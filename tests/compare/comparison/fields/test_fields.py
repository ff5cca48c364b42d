"""Field snapshots held against exact fields: right ones converge, spoilt ones are seen."""

import math
from dataclasses import dataclass, replace
from functools import cache

import meshio
import numpy as np
import pytest
from catalogue import solved

from compare.comparison.fields import errors as fields
from compare.comparison.fields.errors import field_errors, frame_pairs, pair_errors
from compare.comparison.fields.frames import read_frame
from compare.comparison.fields.fronts import StraightFront, fronts_of
from compare.comparison.snapshots import listed_frames
from fem import simulate
from semianalytic import Pulse
from semianalytic.results.answer import BodyFields
from semianalytic.results.files import Seal, new_file
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.overriding import override_scene

SCENE = find_scene("preloaded")
EXACT = solved(SCENE)


@dataclass
class Spoilt:
    """Exact fields of a solution, changed on purpose: by(name of field, values, y)."""

    exact: object
    by: object
    zones: tuple = ()

    def velocity(self, x, y, t):
        return self.by("velocity", self.exact.velocity(x, y, t), y)

    def stress(self, x, y, t):
        return self.by("stress", self.exact.stress(x, y, t), y)

    def displacement(self, x, y, t):
        return self.by("displacement", self.exact.displacement(x, y, t), y)


def simulated(folder, scene, resolution, frames=1):
    run = simulate(scene, resolution=resolution, snapshots=folder, frames=frames)
    return run, folder


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Simulations of the default scene at two resolutions, each made when it is asked for."""
    return cache(lambda resolution: simulated(tmp_path_factory.mktemp("frames"), SCENE, resolution))


@pytest.fixture(scope="module")
def right(runs):
    """Errors of the exact fields on the mesh of a resolution."""
    return cache(lambda resolution: last(EXACT, *runs(resolution)))


def last(prediction, run, folder):
    found = field_errors(prediction, run, folder)
    return {error.component: error for error in found.frames[-1]}


@pytest.mark.slow
def test_exact_fields_are_met_more_closely_by_a_finer_mesh(right):
    coarse, fine = right(20), right(40)
    assert list(fine) == ["v_x", "v_y", "u_x", "u_y", "sigma_xx", "sigma_yy", "sigma_xy"]
    for name, error in fine.items():
        assert error.outside < error.whole < 0.07
        assert error.whole < 0.65 * coarse[name].whole
        assert error.outside < 0.65 * coarse[name].outside
    assert max(fine["u_x"].whole, fine["u_y"].whole) < 0.005
    assert fine["v_x"].band < 0.65 * coarse["v_x"].band  # half the width, and a smaller mesh


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", ["antiplane", "auxetic", "lift-off"])
def test_frames_of_other_scenes_come_closer_with_time(name, tmp_path):
    # By similarity the frame at T / 2 is that of a mesh of elements twice as large at T.
    scene = find_scene(name)
    run, folder = simulated(tmp_path, scene, 32, frames=2)
    half, whole = field_errors(solved(scene), run, folder).frames
    assert all(late.whole < 0.08 for late in whole)
    for early, late in zip(half, whole, strict=True):
        assert late.whole < 0.75 * early.whole or late.whole == early.whole == 0


@pytest.mark.slow
def test_friction_off_by_three_percent_is_seen(runs, right):
    spoilt = last(solved(override_scene(SCENE, friction=1.03 * SCENE.friction)), *runs(40))
    assert spoilt["u_y"].whole > 1.5 * right(40)["u_y"].whole
    assert spoilt["u_y"].outside > 2 * right(40)["u_y"].outside
    assert all(spoilt[name].outside > error.outside for name, error in right(40).items())


def test_a_sign_of_one_component_is_seen(runs, right):
    def flipped(name, values, y):
        return values * ([[1], [-1]] if name == "velocity" else 1)

    spoilt = last(Spoilt(EXACT, flipped, EXACT.zones), *runs(20))
    assert spoilt.pop("v_y").whole > 1.9
    assert all(spoilt[name] == right(20)[name] for name in spoilt)


def test_a_lower_body_mirrored_wrongly_is_seen(runs):
    def mirrored(name, values, y):
        return np.where(np.signbit(y), -values, values)

    spoilt = last(Spoilt(EXACT, mirrored, EXACT.zones), *runs(20))
    assert all(error.whole > 0.8 and error.outside > 0.8 for error in spoilt.values())


def planted(folder, run, change):
    """The last frame with the exact fields in it, changed."""
    ((time, path),) = listed_frames(folder, run.run)
    frame = read_frame(time, path)
    places = {"nodes": frame.nodes, "elements": frame.elements}
    exact = {
        "nodes": np.concatenate(
            [
                getattr(EXACT, name)(frame.nodes.x, frame.nodes.y, time)
                for name in ("velocity", "displacement")
            ]
        ),
        "elements": EXACT.stress(frame.elements.x, frame.elements.y, time),
    }
    held = {
        kind: replace(
            part, fields={name: change(v) for name, v in zip(part.fields, exact[kind], strict=True)}
        )
        for kind, part in places.items()
    }
    return replace(frame, **held)


def errors_of(frame, most=10**6):
    fronts = fields.fronts_in(EXACT, SCENE)
    return list(pair_errors(frame_pairs(EXACT, frame, most), fronts, frame.time, 0.1))


def test_the_exact_answer_itself_has_no_error_and_a_known_one_has_its_own(runs):
    run, folder = runs(20)
    for error in errors_of(planted(folder, run, lambda values: values)):
        assert error.whole == error.outside == 0
    at_rest = planted(folder, run, lambda values: 0 * values)
    for error in errors_of(at_rest):
        if not error.component.startswith("sigma"):  # of stress the change since t = 0 counts
            assert error.whole == error.outside == 1


def test_a_part_of_the_places_tells_the_same_in_two_digits(runs):
    run, folder = runs(40)
    ((time, path),) = listed_frames(folder, run.run)
    frame = read_frame(time, path)
    for some, every in zip(errors_of(frame, 5000), errors_of(frame), strict=True):
        assert some.whole == pytest.approx(every.whole, rel=0.1)
        assert some.outside == pytest.approx(every.outside, rel=0.1)


@pytest.mark.parametrize(
    ("element", "mesh"), [("P1", "squares"), ("Q2", "squares"), ("Q1", "graded")]
)
def test_nodes_and_elements_of_any_mesh_cover_both_bodies_once(tmp_path, element, mesh):
    run = simulate(SCENE, resolution=12, snapshots=tmp_path, frames=1, element=element, mesh=mesh)
    ((time, path),) = listed_frames(tmp_path, run.run)
    frame = read_frame(time, path)
    for places in (frame.nodes, frame.elements):
        for side in (1, -1):
            x, y = (values[np.copysign(1, places.y) == side] for values in (places.x, places.y))
            covered = places.area[np.copysign(1, places.y) == side].sum()
            whole = np.ptp(frame.nodes.x) * np.ptp(frame.nodes.y) / 2
            assert covered == pytest.approx(whole)
            assert x.min() < 0 < x.max()
            assert np.all(side * y >= 0)
    faces = frame.nodes.y == 0
    assert np.signbit(frame.nodes.y[faces]).sum() == faces.sum() / 2
    assert all(error.whole < 0.3 for error in last(EXACT, run, tmp_path).values())


def test_a_component_that_vanishes_is_measured_by_the_largest(tmp_path):
    scene = find_scene("antiplane")
    found = last(solved(scene), *simulated(tmp_path, scene, 20))
    assert found["v_x"].whole == found["sigma_xy"].whole == 0
    assert 0.01 < found["v_z"].whole < 0.1

    def moved(name, values, y):
        values = values.copy()
        values[0] += np.abs(values[-1]) * (name == "velocity")
        return values

    run = simulate(scene, resolution=20, snapshots=tmp_path, frames=1)
    assert last(Spoilt(solved(scene), moved), run, tmp_path)["v_x"].whole == pytest.approx(1)


@pytest.mark.parametrize("side", [1, -1])
def test_fronts_are_where_waves_arrive(side):
    scene, t, y = find_scene("remote-shock"), 0.7, 0.2
    material = scene.material
    c_l, c_t, c_r = material.longitudinal_speed, material.shear_speed, material.rayleigh_speed
    edge = 1.5 * c_t
    fronts = fronts_of(scene, [edge, math.inf, 0.0])
    head, mach = (speed * (t - y * math.sqrt(c_t**-2 - speed**-2)) for speed in (c_l, edge))
    on = {
        "P": (0.6 * c_l * t, 0.8 * c_l * t),
        "S": (-0.6 * c_t * t, 0.8 * c_t * t),
        "plane S": (-1.3, c_t * t),
        "plane P": (-1.3, c_l * t),
        "Rayleigh": (c_r * t, 0.0),
        "Rayleigh on the slot": (-c_r * t, 0.0),
        "edge": (0.0, 0.0),
        "zone edge": (edge * t, 0.0),
        "head": (head, y),
        "head on the slot": (-head, y),
        "Mach": (mach, y),
    }
    for name, (x, height) in on.items():
        assert fronts.distance(np.array(x), np.array(side * height), t) < 1e-12, name
    beside = np.array([[-mach, 1.3, 1.3], [y, c_t * t, c_l * t]])
    assert np.all(fronts.distance(beside[0], side * beside[1], t) > 0.02)


@pytest.mark.parametrize("side", [1, -1])
def test_a_line_is_where_its_front_is_from_the_surface_to_the_circle(side):
    front, share = StraightFront(1.0, 0.6, side), np.linspace(0.0, 1.0, 9)
    x, y = front.line(0.5, share)
    np.testing.assert_allclose(front.distance(x, y, 0.5), 0.0, atol=1e-15)
    assert (x[0], y[0]) == (side * 0.5 / 0.6, 0.0)
    assert np.hypot(x[-1], y[-1]) == pytest.approx(0.5)


def test_each_jump_of_a_load_sends_out_fronts_and_a_rise_does_not():
    x, y = np.array([0.5, 0.6, 0.06]), np.array([0.5, 0.8, 0.08])
    radii = np.hypot(x, y)
    pulse = replace(find_scene("pulse"), shear_history=Pulse(0.3))
    fronts = fronts_of(pulse)
    assert fronts.starts == (0.0, 0.3)
    c_t = pulse.material.shear_speed
    assert fronts.distance(x, y, radii[1] / c_t)[1] < 1e-12
    assert fronts.distance(x, y, 0.3 + radii[2] / c_t)[2] < 1e-12
    np.testing.assert_array_equal(fronts_of(find_scene("ramp")).distance(x, y, 0.8), radii)


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", ["preloaded", "lift-off-shear", "antiplane"])
def test_exact_fields_change_suddenly_nowhere_but_at_fronts(name):
    scene = find_scene(name)
    solution, step = solved(scene), 0.005
    x, y = scene.fastest_speed * np.random.default_rng(16).uniform(-1.1, 1.1, (2, 12_000))
    kept = (np.hypot(x, y) > 0.1) & (np.abs(y) > step)  # away from the edge, in one body
    x, y = x[kept], y[kept]
    beyond = x + step, y + np.copysign(step, y)
    change = np.abs(solution.stress(*beyond, 1.0) - solution.stress(x, y, 1.0)).max(axis=0)
    distance = fields.fronts_in(solution, scene).distance(x, y, 1.0)
    sudden = change > 0.2
    assert sudden.sum() > 10
    assert distance[sudden].max() < 3 * step


def test_a_prediction_of_the_contact_alone_has_no_fields(runs):
    run, folder = runs(20)
    assert isinstance(EXACT, BodyFields)
    assert field_errors(run, run, folder) is None


def test_all_frames_are_compared_and_progress_is_told(tmp_path):
    run, folder = simulated(tmp_path, SCENE, 16, frames=3)
    told = []
    found = field_errors(EXACT, run, folder, lambda *done: told.append(done))
    assert told == [(1, 3), (2, 3), (3, 3)]
    times = [time for time, _ in listed_frames(folder, run.run)]
    assert [error.time for error in found.rows] == [time for time in times for _ in range(7)]
    assert found.frames[0][0].whole > found.frames[-1][0].whole


def test_a_frame_that_cannot_be_read_or_holds_nan_is_refused(tmp_path):
    run, folder = simulated(tmp_path, SCENE, 10)
    ((_, path),) = listed_frames(folder, run.run)
    frame = meshio.read(path)
    frame.cell_data["sigma_xy"][0][3] = np.nan
    with new_file(path, seal=Seal.XML) as part:
        meshio.write(part, frame, file_format="vtu")
    with pytest.raises(DataFileError, match="not finite"):
        read_frame(1.0, path)
    path.write_bytes(b"")
    with pytest.raises(DataFileError, match="cannot be read"):
        read_frame(1.0, path)
