"""Frames read back from snapshots, and what happens to damaged ones."""

import meshio
import numpy as np
import pytest

from compare.comparison.fields.frames import last_frame
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


@pytest.mark.parametrize("text", ["", "<VTKFile/>", PVD.replace("1.5", "soon")])
def test_a_damaged_index_is_named(folder, text):
    write_bytes(folder / "fields.pvd", text.encode(), Seal.XML)
    with pytest.raises(DataFileError, match=r"fields\.pvd lists no snapshot"):
        last_frame(folder)


def test_a_missing_index_is_named(tmp_path):
    with pytest.raises(DataFileError, match=r"fields\.pvd lists no snapshot"):
        last_frame(tmp_path)


@pytest.mark.parametrize("content", [None, b"", b"<VTKFile/>"])
def test_a_damaged_or_missing_frame_is_named(folder, content):
    frame = folder / "last.vtu"
    frame.unlink()
    if content is not None:
        write_bytes(frame, content, Seal.XML)
    with pytest.raises(DataFileError, match=r"last\.vtu cannot be read"):
        last_frame(folder)


def test_values_that_are_not_finite_are_refused(folder):
    frame = meshio.read(folder / "last.vtu")
    frame.point_data["velocity"][:] = np.nan
    write_sealed(folder / "last.vtu", frame)
    with pytest.raises(DataFileError, match="not finite"):
        last_frame(folder)
