"""Slip rates read back from snapshots, and what happens to damaged ones."""

import meshio
import numpy as np
import pytest

from compare.comparison.snapshots import last_snapshot
from semianalytic.results.files import Seal, new_file, write_bytes
from semianalytic.scene.errors import DataFileError

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
    frame = meshio.Mesh(points, cells, point_data={"velocity": velocity})
    write_sealed(tmp_path / "last.vtu", frame)
    write_bytes(tmp_path / "fields.pvd", PVD.format("last.vtu").encode(), Seal.XML)
    return tmp_path


def write_sealed(path, frame):
    with new_file(path, seal=Seal.XML) as part:
        meshio.write(part, frame, file_format="vtu")


def test_slip_rate_is_upper_minus_lower_velocity_on_the_contact(folder):
    profile = last_snapshot(folder)
    assert profile.time == 1.5
    np.testing.assert_array_equal(profile.x, [1.0, 2.0])
    np.testing.assert_array_equal(profile.slip_rate, [4.0, 6.0])


@pytest.mark.parametrize("text", ["", "<VTKFile/>", PVD.replace("1.5", "soon")])
def test_a_damaged_index_is_named(folder, text):
    write_bytes(folder / "fields.pvd", text.encode(), Seal.XML)
    with pytest.raises(DataFileError, match=r"fields\.pvd lists no snapshot"):
        last_snapshot(folder)


def test_a_missing_index_is_named(tmp_path):
    with pytest.raises(DataFileError, match=r"fields\.pvd lists no snapshot"):
        last_snapshot(tmp_path)


@pytest.mark.parametrize("content", [None, b"", b"<VTKFile/>"])
def test_a_damaged_or_missing_frame_is_named(folder, content):
    frame = folder / "last.vtu"
    frame.unlink()
    if content is not None:
        write_bytes(frame, content, Seal.XML)
    with pytest.raises(DataFileError, match=r"last\.vtu cannot be read"):
        last_snapshot(folder)


def test_values_that_are_not_finite_are_refused(folder):
    frame = meshio.read(folder / "last.vtu")
    frame.point_data["velocity"][:] = np.nan
    write_sealed(folder / "last.vtu", frame)
    with pytest.raises(DataFileError, match="not finite"):
        last_snapshot(folder)
