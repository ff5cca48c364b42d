"""Snapshots held against exact fields: right ones converge, spoilt and damaged ones are seen."""

import math
from dataclasses import replace
from functools import cache

import meshio
import numpy as np
import pytest
from catalogue import solved
from compare_cases import Spoilt

from compare.comparison.fields import errors as fields
from compare.comparison.fields.errors import field_errors, frame_pairs, pair_errors
from compare.comparison.fields.frames import last_frame, listed_frames, read_frame
from compare.comparison.fields.fronts import StraightFront, fronts_of
from fem import simulate
from semianalytic import IncidentWave, Material, MovingLoad, Pulse, Scene, Tractions, solve
from semianalytic.results.files import Seal, new_file, write_bytes
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.finding import find_scene

SCENE = find_scene("preloaded")
EXACT = solved(SCENE)


def changed(exact, **by):
    """An answer with fields changed on purpose, each by a function of its values and of y."""

    def spoilt(name):
        change = by.get(name, lambda values, y: values)
        return lambda x, y, t: change(getattr(exact, name)(x, y, t), y)

    return Spoilt(exact, **{name: spoilt(name) for name in ("velocity", "stress", "displacement")})


def simulated(folder, scene, resolution, frames=1, **options):
    """A simulation with its frames, and the folder that they are in."""
    run = simulate(scene, resolution=resolution, snapshots=folder, frames=frames, **options)
    return run, folder


def frame_of(run, folder):
    """The last frame."""
    *_, (time, path) = listed_frames(folder, run.run)
    return read_frame(time, path)


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
    ratios = [
        late.whole / early.whole for early, late in zip(half, whole, strict=True) if early.whole
    ]
    # 0.55 to 0.67 in the mean of lift-off on meshes of 24 to 64, up to 0.93 of one component
    assert max(ratios) < 1
    assert np.mean(ratios) < 0.7


def test_a_sign_of_one_component_is_seen(runs, right):
    spoilt = last(changed(EXACT, velocity=lambda values, y: values * [[1], [-1]]), *runs(20))
    assert spoilt.pop("v_y").whole > 1.9
    assert all(spoilt[name] == right(20)[name] for name in spoilt)


def test_a_lower_body_mirrored_wrongly_is_seen(runs):
    def mirrored(values, y):
        return np.where(np.signbit(y), -values, values)

    spoilt = changed(EXACT, velocity=mirrored, stress=mirrored, displacement=mirrored)
    errors = last(spoilt, *runs(20)).values()
    assert all(error.whole > 0.8 and error.outside > 0.8 for error in errors)


def planted(frame, change):
    """A frame with the exact fields in it, changed."""
    exact = {
        "nodes": np.concatenate(
            [
                getattr(EXACT, name)(frame.nodes.x, frame.nodes.y, frame.time)
                for name in ("velocity", "displacement")
            ]
        ),
        "elements": EXACT.stress(frame.elements.x, frame.elements.y, frame.time),
    }
    held = {}
    for kind, values in exact.items():
        part = getattr(frame, kind)
        fields = {name: change(v) for name, v in zip(part.fields, values, strict=True)}
        held[kind] = replace(part, fields=fields)
    return replace(frame, **held)


def errors_of(frame, most=10**6):
    fronts = fields.fronts_in(EXACT, SCENE)
    (pairs,) = frame_pairs(EXACT, [frame.thinned(most)])
    return list(pair_errors(pairs, fronts, frame.time, 0.1))


def test_the_exact_answer_itself_has_no_error_and_a_known_one_has_its_own(runs):
    frame = frame_of(*runs(20))
    for error in errors_of(planted(frame, lambda values: values)):
        assert error.whole == error.outside == 0
    for error in errors_of(planted(frame, lambda values: 0 * values)):
        if not error.component.startswith("sigma"):  # of stress the change since t = 0 counts
            assert error.whole == error.outside == 1


def test_a_part_of_the_places_tells_the_same_in_two_digits(runs):
    frame = frame_of(*runs(40))
    for some, every in zip(errors_of(frame, 5000), errors_of(frame), strict=True):
        assert some.whole == pytest.approx(every.whole, rel=0.1)
        assert some.outside == pytest.approx(every.outside, rel=0.1)


@pytest.mark.parametrize("mesh", ["squares", pytest.param("triangles", marks=pytest.mark.gmsh)])
def test_nodes_and_elements_of_any_mesh_cover_both_bodies_once(tmp_path, mesh):
    run = simulated(tmp_path, SCENE, 12, mesh=mesh)
    frame = frame_of(*run)
    for places in (frame.nodes, frame.elements):
        for side in (1, -1):
            on = np.copysign(1, places.y) == side
            whole = np.ptp(frame.nodes.x) * np.ptp(frame.nodes.y) / 2
            assert places.area[on].sum() == pytest.approx(whole)
            assert places.x[on].min() < 0 < places.x[on].max()
            assert np.all(side * places.y[on] >= 0)
    faces = frame.nodes.y == 0
    assert np.signbit(frame.nodes.y[faces]).sum() == faces.sum() / 2
    assert all(error.whole < 0.3 for error in last(EXACT, *run).values())


def test_a_component_that_vanishes_is_measured_by_the_largest(tmp_path):
    scene = find_scene("antiplane")
    run = simulated(tmp_path, scene, 20)
    found = last(solved(scene), *run)
    assert found["v_x"].whole == found["sigma_xy"].whole == 0
    assert 0.01 < found["v_z"].whole < 0.1

    def moved(values, y):
        return np.concatenate([values[:1] + np.abs(values[-1]), values[1:]])

    assert last(changed(solved(scene), velocity=moved), *run)["v_x"].whole == pytest.approx(1)


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
    assert fronts.bodies[0].starts == (0.0, 0.3)
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
    assert EXACT.has_bodies
    assert field_errors(run, run, folder) is None


def test_all_frames_are_compared_and_progress_is_told(tmp_path):
    run, folder = simulated(tmp_path, SCENE, 16, frames=3)
    told = []
    found = field_errors(EXACT, run, folder, lambda *done: told.append(done))
    assert told == [(1, 3), (2, 3), (3, 3)]
    times = [time for time, _ in listed_frames(folder, run.run)]
    assert [error.time for error in found.rows] == [time for time in times for _ in range(7)]
    assert found.frames[0][0].whole > found.frames[-1][0].whole


def test_a_frame_that_holds_nan_is_refused(tmp_path):
    run, folder = simulated(tmp_path, SCENE, 10)
    ((_, path),) = listed_frames(folder, run.run)
    frame = meshio.read(path)
    frame.cell_data["sigma_xy"][0][3] = np.nan
    with new_file(path, seal=Seal.XML) as part:
        meshio.write(part, frame, file_format="vtu")
    with pytest.raises(DataFileError, match="not finite"):
        read_frame(1.0, path)


# --- reading snapshots ----------------------------------------------------------------------------

PVD = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
  <Collection>
    <DataSet timestep="0.5" part="0" file="absent.vtu"/>
    <DataSet timestep="1.5" part="0" file="{}"/>
  </Collection>
</VTKFile>
"""


@pytest.fixture
def folder(tmp_path):
    """Two blocks of three squares each, the upper one sliding at 2 + x, the lower one at -x."""
    x, y = np.meshgrid([-1.0, 0.0, 1.0, 2.0], [0.0, 1.0])
    upper = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    points = np.concatenate([upper, upper * [1, -1, 1]])
    quads = np.array([[i, i + 1, i + 5, i + 4] for i in range(3)])
    along = np.concatenate([2 + upper[:, 0], -upper[:, 0]])
    velocity = np.column_stack([along, 0 * along, 0 * along])
    cells = [("quad", np.concatenate([quads, quads + 8]))]
    stress = {name: [np.arange(6.0)] for name in ("sigma_xx", "sigma_yy", "sigma_xy")}
    moved = {"velocity": velocity, "displacement": 0.5 * velocity}
    frame = meshio.Mesh(points, cells, point_data=moved, cell_data=stress)
    write_sealed(tmp_path / "last.vtu", frame)
    write_bytes(tmp_path / "fields.pvd", PVD.format("last.vtu").encode(), Seal.XML)
    return tmp_path


def write_sealed(path, frame):
    with new_file(path, seal=Seal.XML) as part:
        meshio.write(part, frame, file_format="vtu")


def test_a_frame_has_both_bodies_and_tells_their_faces_apart(folder):
    frame = last_frame(folder)
    assert frame.time == 1.5
    nodes, elements = frame.nodes, frame.elements
    above = np.copysign(1.0, nodes.y) > 0
    np.testing.assert_array_equal(nodes.fields["v_x"], np.where(above, 2 + nodes.x, -nodes.x))
    np.testing.assert_array_equal(nodes.fields["u_x"], 0.5 * nodes.fields["v_x"])
    assert np.count_nonzero(nodes.y == 0) == 8  # four nodes on either face
    np.testing.assert_array_equal(elements.y, [0.5] * 3 + [-0.5] * 3)
    np.testing.assert_array_equal(elements.fields["sigma_xy"], np.arange(6.0))
    assert elements.area.sum() == nodes.area.sum() == pytest.approx(6.0)


DAMAGED = [None, "", "<VTKFile/>"]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        *(("fields.pvd", text, "lists no snapshot") for text in DAMAGED),
        ("fields.pvd", PVD.replace("1.5", "soon"), "lists no snapshot"),
        *(("last.vtu", text, "cannot be read") for text in DAMAGED),
    ],
)
def test_a_damaged_or_missing_file_is_named(folder, name, text, words):
    path = folder / name
    path.unlink()
    if text is not None:
        write_bytes(path, text.encode(), Seal.XML)
    with pytest.raises(DataFileError, match=rf"{name} {words}"):
        last_frame(folder)


OBLIQUE = {
    "P": IncidentWave("P", -11.0, stress=0.4, from_="above"),
    "SV": IncidentWave("SV", -3.0, stress=0.2),
    "SH": IncidentWave("SH", -15.0, stress=0.2, from_="above"),
    "6 c_t": MovingLoad(6.0, 0.0, 1.0),
    "25 c_t": MovingLoad(25.0, -0.1, 0.5),
}
"""Loads that come to the left side of the mesh before the end."""


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", OBLIQUE)
def test_waves_of_the_left_side_are_left_out(name, tmp_path):
    """It is no part of a slot that goes on, and sends out a wave when the load comes to it."""
    mode = "antiplane" if name == "SH" else "in-plane"
    scene = Scene(Material(1, 1, 0.25), 0.9, Tractions(1, 0), OBLIQUE[name], mode=mode)
    run, folder = simulated(tmp_path, scene, 40)
    shown = field_errors(solve(scene), run, folder)
    moved = [error for error in shown.frames[-1] if error.component.startswith("u")]
    assert max(error.outside for error in moved) < 0.003  # with these waves 0.001 to 0.02
    assert shown.last["u_x"].places.x.min() < -0.98 * scene.fastest_speed
    wrong = changed(solve(scene), displacement=lambda values, y: 1.01 * values)
    moved = field_errors(wrong, run, folder).frames[-1]
    assert max(error.outside for error in moved if error.component.startswith("u")) > 0.009
