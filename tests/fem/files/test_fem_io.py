"""Files of a simulation: its histories, and pictures of its fields."""

import dataclasses
import xml.etree.ElementTree as ET

import h5py
import meshio
import numpy as np
import pytest
from catalogue import UNIT

import semianalytic as sf
from fem import simulate
from fem.results import load_simulation
from fem.run import levels
from tests.fem.runs import MIXED, SHEARED_ALONG_Z, assert_same, interrupted, prepare


@pytest.fixture(scope="module")
def simulation(mesh_cache):
    return simulate(MIXED, resolution=12, every=3)


def index(directory):
    """Times and frames a PVD index lists."""
    entries = ET.parse(directory / "fields.pvd").getroot().iter("DataSet")
    return [(float(e.get("timestep")), meshio.read(directory / e.get("file"))) for e in entries]


def assert_comes_back(simulation, folder):
    simulation.save(folder / "new" / "folder")
    loaded = load_simulation(folder / "new" / "folder")
    assert [path.name for path in (folder / "new" / "folder").iterdir()] == ["simulation.h5"]
    assert_same(simulation, loaded, but=())
    assert loaded.energy.residual == simulation.energy.residual


def test_saved_simulation_comes_back_equal(simulation, tmp_path):
    assert_comes_back(simulation, tmp_path)


@pytest.mark.parametrize("law", [sf.RateWeakening(0.5, 0.3, 1.0), sf.SlipWeakening(0.5, 0.2, 0.02)])
def test_saved_simulation_knows_its_loads_and_law(law, mesh_cache, tmp_path):
    scene = dataclasses.replace(
        MIXED,
        friction=law,
        pressure_history=sf.Tabulated((0.1, 0.4, 0.6, 0.6), (0.0, 1.0, 1.0, 0.5)),
        shear_history=sf.Pulse(0.4, "haversine"),
    )
    assert_comes_back(simulate(scene, resolution=20), tmp_path)


def scene_with(old, new):
    """A change of the scene in a file."""

    def change(file):
        file.attrs["scene"] = file.attrs["scene"].replace(old, new, 1)

    return change


DAMAGES = {
    "a lost field": lambda file: file.__delitem__("slot/velocity_y"),
    "a lost group": lambda file: file.__delitem__("energy"),
    "negative friction": scene_with('"friction": 0.5', '"friction": -1'),
    "no friction": scene_with('"friction"', '"fiction"'),
    "a law of its own": scene_with("{", '{"friction_law": {"kind": "none"}, '),
    "a scene that is no table": lambda file: file.attrs.update(scene="[1, 2]"),
    "steps that are no number": lambda file: file.attrs.update(steps="1 2"),
    "an array that is announced alone": lambda file: (
        file.__delitem__("energy/damping"),
        file.create_dataset("energy/damping", (2**20, 2**12), float, chunks=(64, 64)),
    ),
    "a foreign format": lambda file: file.attrs.update(format="something else"),
}
"""Changes of a file that HDF5 can still read; others in compare/output/test_faults.py."""


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_simulation_is_an_error(damage, simulation, tmp_path):
    simulation.save(tmp_path)
    with h5py.File(tmp_path / "simulation.h5", "a") as file:
        DAMAGES[damage](file)
    with pytest.raises(sf.DataFileError, match=r"simulation\.h5"):
        load_simulation(tmp_path)


def test_pictures_are_evenly_spaced_and_indexed(tmp_path):
    sim = simulate(MIXED, resolution=16, snapshots=tmp_path, frames=4)
    frames = index(tmp_path)
    times = [time for time, _ in frames]
    np.testing.assert_allclose(times, [0.25, 0.5, 0.75, 1.0], atol=sim.time_step / 2)
    assert not list(tmp_path.glob("*.part"))
    assert sim.seconds["snapshots"] <= sim.seconds["steps"]


def test_fields_agree_with_the_interface_history(tmp_path):
    sim = simulate(MIXED, resolution=16, snapshots=tmp_path, frames=1)
    (_, frame), history = index(tmp_path)[0], sim.interface
    displacement, velocity = frame.point_data["displacement"], frame.point_data["velocity"]
    on_contact = (frame.points[:, 1] == 0) & (frame.points[:, 0] > history.x[0] / 2)
    upper, lower = faces(frame, on_contact)
    # tractions are carried by nodes, stresses by elements: only displacements must agree exactly
    np.testing.assert_allclose(
        (displacement[upper] - displacement[lower])[:, 0], history.slip[-1], atol=1e-14
    )
    # the frame shows single steps, the history what is left of them over its window
    rate = (velocity[upper] - velocity[lower])[:, 0]
    np.testing.assert_allclose(rate, single_step_rate(MIXED, 16), atol=1e-14)
    assert np.abs(rate - history.slip_rate[-1]).sum() < 0.2 * np.abs(rate).sum()
    on_slot = (frame.points[:, 1] == 0) & (frame.points[:, 0] < 0)
    upper, _ = faces(frame, on_slot & (frame.points[:, 0] >= sim.slot.x[0] - 1e-9))
    np.testing.assert_allclose(velocity[upper, 1], sim.slot.velocity_y[-1], atol=1e-14)


def single_step_rate(scene, resolution):
    """Slip rate at the end over the steps before and after it, beyond the edge node."""
    model = prepare(scene, resolution=resolution, full=True)
    for step in levels(model):
        if step < model.steps:
            model.drift()
    return model.joint.sliding.mean_increment()[1:] / model.time_step


def faces(frame, nodes):
    """Nodes of the upper and of the lower face among `nodes`, both by increasing x."""
    cells = frame.cells[0].data
    above = np.unique(cells[frame.points[cells][:, :, 1].mean(axis=1) > 0])
    numbers = np.flatnonzero(nodes)
    numbers = numbers[np.argsort(frame.points[numbers, 0], kind="stable")]
    is_upper = np.isin(numbers, above)
    return numbers[is_upper], numbers[~is_upper]


def test_plane_waves_carry_the_right_stress(tmp_path):
    """Far left nothing is felt of the edge: behind each front stands the load itself."""
    simulate(MIXED, resolution=48, snapshots=tmp_path, frames=2)
    time, frame = index(tmp_path)[0]
    x, y, _ = frame.points[frame.cells[0].data].mean(axis=1).T / time
    c = UNIT.longitudinal_speed
    sxx, syy, sxy = (frame.cell_data[f"sigma_{name}"][0] for name in ("xx", "yy", "xy"))
    lateral = UNIT.poisson_ratio / (1 - UNIT.poisson_ratio)
    for side in (1, -1):
        height = np.where((x < -1.1 * c) & (x > -1.5 * c), side * y, np.inf)
        behind = (height > 0.1) & (height < 0.8)
        between = (height > 1.2) & (height < 0.8 * c)
        ahead = (height > 1.2 * c) & np.isfinite(height)
        for where, pressure, shear in (
            (behind, 1.0 - 0.5, 0.2 - 0.5),
            (between, 1.0 - 0.5, 0.2),
            (ahead, 1.0, 0.2),
        ):
            # means over each region, to 1 % of the step: single elements ring by a few percent
            assert where.sum() > 50
            assert syy[where].mean() == pytest.approx(-pressure, abs=5e-3)
            assert sxy[where].mean() == pytest.approx(shear, abs=5e-3)
            assert sxx[where].mean() == pytest.approx(lateral * (1.0 - pressure), abs=5e-3)


@pytest.mark.parametrize("scene", [MIXED, SHEARED_ALONG_Z], ids=["in plane", "antiplane"])
def test_mirrored_half_and_two_blocks_show_the_same_fields(scene, tmp_path):
    frames = []
    for model in ("auto", "two-blocks"):
        simulate(scene, resolution=16, snapshots=tmp_path / model, frames=1, model=model)
        ((_, frame),) = index(tmp_path / model)
        centre = frame.points[frame.cells[0].data].mean(axis=1).round(6)
        order = np.lexsort(centre.T)
        corners = frame.point_data["velocity"][frame.cells[0].data].mean(axis=1)
        fields = [value[0] for _, value in sorted(frame.cell_data.items())]
        frames.append([f[order] for f in (*fields, corners, centre)])
    for entry, two in zip(*frames, strict=True):
        np.testing.assert_allclose(entry, two, atol=1e-10)


def test_interrupted_run_leaves_a_valid_index(tmp_path):
    simulate(MIXED, resolution=10, snapshots=tmp_path, frames=5)  # an older run in the same folder
    middle = prepare(MIXED, resolution=12).steps // 2 + 1
    interrupted(MIXED, middle, resolution=12, snapshots=tmp_path, frames=4)
    assert len(index(tmp_path)) == 2
