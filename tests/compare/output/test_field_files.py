"""Fields as files: what stands in them is what the fields are; files are whole or not there."""

import csv

import meshio
import numpy as np
import pytest

from compare.output.field_files import grid_of, in_parts, record_fields, write_frames, write_record
from semianalytic import find, solve, strain


@pytest.fixture(scope="module")
def solution():
    return solve(find("preloaded"))


def test_grid_has_the_interface_twice():
    x, y, cells = grid_of((-1.0, 1.0, -1.0, 2.0), (4, 6))
    assert cells.shape == (24, 4)
    face = y == 0
    assert np.signbit(y[face]).sum() == 5
    assert face.sum() == 10
    corners = np.stack([x[cells], y[cells]])
    areas = (corners[0, :, 2] - corners[0, :, 0]) * (corners[1, :, 2] - corners[1, :, 0])
    assert areas == pytest.approx(0.25)
    below = (y[cells] < 0) | np.signbit(y[cells])
    assert np.all(below.all(axis=1) | ~below.any(axis=1))


@pytest.mark.parametrize(("y0", "y1", "below"), [(0.0, 1.0, False), (-1.0, 0.0, True)])
def test_grid_of_one_body_has_its_own_face(y0, y1, below):
    _, y, _ = grid_of((0.0, 1.0, y0, y1), (2, 3))
    assert np.all(np.signbit(y[y == 0]) == below)
    assert len(y) == 12


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["preloaded", "antiplane"])
def test_frames_hold_the_fields(name, tmp_path):
    solution = solve(find(name))
    window, shown = (-0.5, 0.5, -0.4, 0.4), []
    write_frames(tmp_path, solution, [0.5, 1.0, 1.5], window, (3, 4))
    index = write_frames(tmp_path, solution, [0.5, 1.0], window, (3, 4), lambda *n: shown.append(n))
    assert shown == [(1, 2), (2, 2)]
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "fields-0001.vtu", "fields-0002.vtu", "fields.pvd",
    ]  # fmt: skip
    assert index.read_text().count("timestep") == 2
    mesh = meshio.read(tmp_path / "fields-0002.vtu")
    x, y, z = mesh.points.T
    assert not z.any()
    for name in ("velocity", "displacement"):
        rows = getattr(solution, name)(x, y, 1.0)
        assert np.array_equal(mesh.point_data[name].T[: len(rows)], rows)
    cells = mesh.cells_dict["quad"]
    rows = solution.stress(x[cells].mean(axis=1), y[cells].mean(axis=1), 1.0)
    names = ["sigma_xx", "sigma_yy", "sigma_xy", "sigma_xz", "sigma_yz"][: len(rows)]
    assert sorted(mesh.cell_data) == sorted(names)
    for name, row in zip(names, rows, strict=True):
        assert mesh.cell_data[name][0] == pytest.approx(row, rel=1e-12, abs=1e-14)


def test_many_points_are_taken_in_parts(solution, monkeypatch):
    monkeypatch.setattr("compare.output.field_files.AT_ONCE", 7)
    x, y = np.random.default_rng(0).normal(size=(2, 30))
    whole = solution.stress(x, y, 1.0)
    assert in_parts(solution.stress, x, y, 1.0) == pytest.approx(whole, rel=1e-13, abs=1e-15)


def test_record_is_written_as_it_is(solution, tmp_path):
    t = np.linspace(0, 1, 11)
    record = record_fields(solution, 0.4, 0.2, t)
    assert record.stress[1, 0] == -1.0
    assert not record.strain[:, 0].any()
    change = solution.stress(0.4, 0.2, t) - np.array([[0.0], [-1.0], [0.0]])
    assert record.strain == pytest.approx(strain(change, solution.scene.material))
    write_record(tmp_path / "one.csv", record, "SI", "slipfront field preloaded")
    first, *rest = (tmp_path / "one.csv").read_text().splitlines()
    assert first == "# slipfront field preloaded"
    heading, *rows = csv.reader(rest)
    assert heading[:5] == ["t [s]", "x [m]", "y [m]", "v_x [m/s]", "v_y [m/s]"]
    assert heading[-1] == "eps_xy [1]"
    table = np.array(rows, dtype=float)
    assert np.array_equal(table[:, 1:3], np.tile([0.4, 0.2], (len(t), 1)))
    assert np.array_equal(table[:, 3:5].T, record.velocity)
    assert np.array_equal(table[:, -3:].T, record.strain)


def test_infinite_values_stay_infinite_in_tables(solution, tmp_path):
    """On the upper slot face the Rayleigh front is one instant of a record."""
    rayleigh = solution.scene.material.rayleigh_speed
    record = record_fields(solution, -rayleigh, 0.0, np.array([0.5, 1.0, 1.5]))
    assert np.isinf(record.velocity[0]).tolist() == [False, True, False]
    write_record(tmp_path / "one.csv", record, "", "slipfront field")
    assert "inf" in (tmp_path / "one.csv").read_text().splitlines()[3]
