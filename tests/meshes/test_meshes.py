"""The blocks: their size, their two separate faces, their files."""

import signal
from dataclasses import replace

import meshio
import numpy as np
import pytest
from faults import as_nobody, open_folder

from meshes import Blocks, causal_blocks, mesh_of, side_nodes
from meshes.build import cache_path, new_mesh_file, write_mesh
from meshes.read import read_mesh
from semianalytic.scene.errors import DataFileError, SceneError

BLOCKS = Blocks(size=0.1, left=4, right=6, height=3)
TRIANGLES = replace(BLOCKS, pattern="triangles")


def build_mesh(blocks, path):
    """Fill blocks with triangles and write them to a file."""
    with new_mesh_file(blocks, path) as part:
        write_mesh(blocks, part)


def nodes_of(mesh, side):
    """Nodes of a side, which are the ends of so many element sides on the boundary."""
    nodes = side_nodes(mesh.p, side)
    outer = np.isin(mesh.facets[:, mesh.boundary_facets()], nodes).all(axis=0)
    assert outer.sum() >= len(nodes) - 1
    return nodes


def test_elements_are_squares_on_the_grid():
    mesh = mesh_of(BLOCKS)
    x, y = mesh.p[:, mesh.t]
    area = (np.roll(y, -1, axis=0) * x - np.roll(x, -1, axis=0) * y).sum(axis=0) / 2
    np.testing.assert_allclose(area, 0.01, rtol=1e-12)  # positive: counter-clockwise
    assert mesh.nelements == 10 * 3
    for side, count in BLOCKS.sides.items():
        assert len(nodes_of(mesh, side)) == count + 1


@pytest.mark.gmsh
def test_triangles_cover_the_block():
    mesh = mesh_of(TRIANGLES)
    assert mesh.t.shape[0] == 3
    (x, y) = mesh.p[:, mesh.t]
    area = ((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / 2
    assert np.abs(area).sum() == pytest.approx(1.0 * 0.3, rel=1e-9)
    assert np.abs(area).min() > 0.1 * 0.1**2  # no slivers
    on_side = nodes_of(mesh, "contact")
    np.testing.assert_allclose(mesh.p[0, on_side], 0.1 * np.arange(7), atol=1e-15)


def cells_of(raw, kind):
    """The nodes of the first block of elements of a kind."""
    return next(block.data for block in raw.cells if block.type == kind)


def repeat(kind):
    """Fill the place of the first element of a kind with the second."""

    def damage(raw):
        cells_of(raw, kind)[0] = cells_of(raw, kind)[1]

    return damage


def move_an_inner_node(raw):
    raw.points[np.argmin(np.abs(raw.points - [0.0, 0.15, 0.0]).sum(axis=1))] += [0.0, 9.0, 0.0]


def move_an_outer_node(raw):
    raw.points[np.argmin(np.abs(raw.points - [0.2, 0.3, 0.0]).sum(axis=1))] += [0.01, 0.0, 0.0]


DAMAGED = [
    (repeat("triangle"), "cover it once|whole element sides"),
    (move_an_inner_node, "cover it once"),
    (move_an_outer_node, "whole element sides"),
]


@pytest.mark.gmsh
@pytest.mark.parametrize(("damage", "complaint"), DAMAGED)
def test_cells_are_those_of_the_blocks(damage, complaint, tmp_path, monkeypatch):
    build_mesh(TRIANGLES, tmp_path / "blocks.msh")
    read = meshio.gmsh.read

    def damaged(path):
        raw = read(path)
        damage(raw)
        return raw

    monkeypatch.setattr(meshio.gmsh, "read", damaged)
    with pytest.raises(DataFileError, match=complaint):
        read_mesh(tmp_path / "blocks.msh", TRIANGLES)


def test_free_walls_are_farther_away():
    held, free = (causal_blocks(2.0, 1.0, 0.02, free_walls=choice) for choice in (False, True))
    assert free.left * 0.02 > 2.0 * 1.5
    assert (free.right, free.height) == (held.right, held.height)


def test_faces_meet_at_the_edge():
    mesh = mesh_of(BLOCKS)
    slot, contact = (nodes_of(mesh, face) for face in ("slot", "contact"))
    assert slot[-1] == contact[0]
    np.testing.assert_array_equal(mesh.p[:, contact[0]], [0, 0])


@pytest.mark.parametrize("speed", [2.3, 2.8, 4.0, 6.6])
def test_extents_follow_causality(speed):
    end, size = 3.0, 0.05
    reach = speed * end
    blocks = causal_blocks(speed, end, size)
    left, right, height = (n * size for n in (blocks.left, blocks.right, blocks.height))
    slack = 10 * size  # 8 h of margin, and rounding up to whole elements
    assert reach < right < reach + slack
    assert reach < 2 * height < reach + slack + size
    assert reach < 2 * left - reach / 2 < reach + slack + size
    full = causal_blocks(speed, end, size, full=True)
    assert full.left == full.right == full.height == blocks.right


@pytest.mark.parametrize(
    "changes",
    [
        {"size": 0.0},
        {"size": np.inf},
        {"left": 0},
        {"height": -1},
        {"right": 10**7},
        {"pattern": "x"},
    ],
)
def test_impossible_blocks_are_refused(changes):
    with pytest.raises(SceneError, match="mesh:"):
        Blocks(**{"size": 0.1, "left": 4, "right": 6, "height": 3, **changes})


@pytest.mark.gmsh
def test_second_use_builds_nothing(own_cache, monkeypatch):
    first = mesh_of(TRIANGLES)
    assert [path.suffix for path in own_cache.iterdir()] == [".msh"]  # no temporary file is left
    monkeypatch.setattr("meshes.build.write_mesh", None)  # calling it would fail
    second = mesh_of(TRIANGLES)
    np.testing.assert_array_equal(first.p, second.p)


def test_every_parameter_has_its_own_cache_entry():
    variants = [
        Blocks(0.1, 4, 6, 3),
        Blocks(0.2, 4, 6, 3),
        Blocks(0.1, 5, 6, 3),
        Blocks(0.1, 4, 5, 3),
        Blocks(0.1, 4, 6, 4),
        TRIANGLES,
    ]
    assert len({cache_path(blocks) for blocks in variants}) == len(variants)


@pytest.mark.gmsh
def test_building_leaves_ctrl_c_alone(tmp_path):
    before = signal.getsignal(signal.SIGINT)
    build_mesh(TRIANGLES, tmp_path / "blocks.msh")
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.gmsh
def test_building_leaves_other_signals_alone(tmp_path):
    """gmsh sets SIGTERM and SIGPIPE back to what ends a process, behind the back of Python."""
    heard = []
    before = signal.signal(signal.SIGTERM, lambda number, frame: heard.append(number))
    try:
        build_mesh(TRIANGLES, tmp_path / "blocks.msh")
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGPIPE)  # which Python ignores
    finally:
        signal.signal(signal.SIGTERM, before)
    assert heard == [signal.SIGTERM]


@pytest.mark.gmsh
def test_building_leaves_an_open_gmsh_session_alone(tmp_path):
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.model.add("theirs")
        build_mesh(TRIANGLES, tmp_path / "blocks.msh")
        assert gmsh.isInitialized()
        assert gmsh.model.getCurrent() == "theirs"
    finally:
        gmsh.finalize()


def test_unusable_cache_is_named(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("SLIPFRONT_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(DataFileError, match="SLIPFRONT_CACHE"):
        mesh_of(TRIANGLES)


def test_a_cache_that_may_not_be_looked_into_is_named(monkeypatch):
    with open_folder() as folder:
        (folder / "closed").mkdir(mode=0)
        monkeypatch.setenv("SLIPFRONT_CACHE", str(folder / "closed"))
        with as_nobody(), pytest.raises(DataFileError, match="SLIPFRONT_CACHE"):
            mesh_of(TRIANGLES)


def move_a_node(path):
    """Overwrite the ordinate of one corner, stored as a binary double."""
    data = path.read_bytes()
    corner = np.array([6 * 0.1, 3 * 0.1, 0.0]).tobytes()
    assert corner in data
    path.write_bytes(data.replace(corner, np.array([0.6, 0.34, 0.0]).tobytes()))


def replace_by_a_quad(path):
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    meshio.write(path, meshio.Mesh(points, [("quad", [[0, 1, 2, 3]])]), file_format="gmsh")


DAMAGES = {
    "cut": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "empty": lambda path: path.write_bytes(b""),
    "no mesh": lambda path: path.write_bytes(bytes(range(256)) * 20),
    "a moved node": move_a_node,
    "a quadrilateral": replace_by_a_quad,
    "other blocks": lambda path: build_mesh(replace(TRIANGLES, left=6, right=4), path),
}


@pytest.mark.gmsh
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_file_is_an_error_and_in_the_cache_built_again(damage):
    intact, path = mesh_of(TRIANGLES), cache_path(TRIANGLES)
    DAMAGES[damage](path)
    with pytest.raises(DataFileError, match=path.name):
        read_mesh(path, TRIANGLES)
    np.testing.assert_array_equal(mesh_of(TRIANGLES).p, intact.p)
    read_mesh(path, TRIANGLES)


def test_missing_file_is_an_error(tmp_path):
    with pytest.raises(DataFileError, match="does not exist"):
        read_mesh(tmp_path / "nothing.msh", TRIANGLES)
