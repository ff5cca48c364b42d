"""Blocks laid in numpy where gmsh cannot be loaded: the same as gmsh's, and said."""

import builtins
import re
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from catalogue import PRELOADED
from faults import FULL, full_disk

from fem import simulate
from meshes import Blocks, build_mesh, cached_mesh, read_mesh
from meshes.build import APT_PACKAGES
from semianalytic.scene.errors import DataFileError, MissingLibraryError

ROOT = Path(__file__).parents[2]
BLOCKS = Blocks(size=0.1, left=4, right=6, height=3, lower=True)
LACK = "libGLU.so.1: cannot open shared object file"
RANDOM = np.random.default_rng(26)
SHAPES = [(2, 2, 2), (3, 2, 5), *RANDOM.integers(2, 30, (4, 3)).tolist()]


def hide_gmsh(monkeypatch, error):
    original = builtins.__import__

    def hidden(name, *args, **kwargs):
        if name == "gmsh":
            raise error
        return original(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", hidden)


@pytest.fixture
def without_gmsh(monkeypatch):
    hide_gmsh(monkeypatch, OSError(LACK))


def groups(file):
    """All that a mesh file says of its parts, in its order."""
    for cells in file.cells:
        yield cells.type, cells.data.tolist()
    yield "point entities", file.point_data["gmsh:dim_tags"].tolist()
    for name in ("gmsh:physical", "gmsh:geometrical"):
        yield name, [tags.tolist() for tags in file.cell_data[name]]
    for name, members in file.cell_sets.items():
        yield name, [np.asarray(one).tolist() for one in members]
    for name, tag in file.field_data.items():
        yield f"physical group {name}", tag.tolist()


@pytest.mark.thinned(5)
@pytest.mark.gmsh
@pytest.mark.parametrize("lower", [False, True])
@pytest.mark.parametrize("pattern", ["squares", "graded"])
@pytest.mark.parametrize("sides", SHAPES, ids=str)
def test_blocks_are_those_of_gmsh_node_for_node_and_tag_for_tag(
    sides, pattern, lower, tmp_path, monkeypatch
):
    blocks = Blocks(float(10 ** RANDOM.uniform(-6, 3)), *sides, lower, pattern)
    build_mesh(blocks, tmp_path / "gmsh.msh")
    hide_gmsh(monkeypatch, OSError(LACK))
    build_mesh(blocks, tmp_path / "laid.msh")
    ours, theirs = (meshio.gmsh.read(tmp_path / f"{name}.msh") for name in ("laid", "gmsh"))
    # gmsh's own places are off by up to 1e-10 elements, of graded meshes by 7e-8
    np.testing.assert_allclose(ours.points, theirs.points, rtol=0, atol=2e-7 * blocks.size)
    assert list(groups(ours)) == list(groups(theirs))
    for name in ("p", "t"):
        np.testing.assert_array_equal(
            *(getattr(read_mesh(tmp_path / f"{one}.msh", blocks), name) for one in ("laid", "gmsh"))
        )


@pytest.mark.parametrize(
    ("pattern", "words"), [("squares", "mesh of squares"), ("graded", "graded mesh")]
)
def test_what_is_laid_is_said_once_and_kept(pattern, words, without_gmsh):
    said, blocks = [], replace(BLOCKS, pattern=pattern)
    mesh = cached_mesh(blocks, said.append)
    assert said == [
        f"gmsh cannot be loaded ({LACK}), so the {words} is laid without it, "
        "node for node the same."
    ]
    assert set(mesh.subdomains) == {"upper", "lower"}
    np.testing.assert_array_equal(cached_mesh(blocks, said.append).p, mesh.p)
    assert len(said) == 1


@pytest.mark.gmsh
def test_a_simulation_is_the_same_to_the_last_bit(tmp_path, monkeypatch):
    monkeypatch.setenv("SLIPFRONT_CACHE", str(tmp_path / "other"))
    expected = simulate(PRELOADED, resolution=10)
    monkeypatch.setenv("SLIPFRONT_CACHE", str(tmp_path / "cache"))
    hide_gmsh(monkeypatch, OSError(LACK))
    found = simulate(PRELOADED, resolution=10)
    assert (expected.remark, found.remark.count("laid without it")) == ("", 1)
    assert found.run == expected.run
    for name in ("slip", "slip_rate", "shear_traction", "pressure"):
        np.testing.assert_array_equal(*(getattr(one.interface, name) for one in (found, expected)))


def test_a_command_says_it_in_one_line(without_gmsh, tmp_path, shown):
    line = f"simulate preloaded --no-snapshots --output {tmp_path / 'run'} --resolution"
    (said,) = [one for one in shown(f"{line} 16").err.splitlines() if "gmsh" in one]
    assert said.startswith(f"preloaded: gmsh cannot be loaded ({LACK})")
    assert shown(f"{line} 17 --quiet").err == ""


@pytest.mark.parametrize(
    ("blocks", "words"),
    [
        (replace(BLOCKS, pattern="triangles"), "a mesh of triangles needs gmsh"),
        (replace(BLOCKS, height=1), "a mesh of squares with a side of a single element needs gmsh"),
    ],
)
def test_what_only_gmsh_can_do_is_refused_with_the_packages(blocks, words, without_gmsh):
    with pytest.raises(MissingLibraryError, match=words) as refused:
        cached_mesh(blocks)
    (sentence,) = str(refused.value).splitlines()
    assert LACK in sentence
    assert f"apt install {APT_PACKAGES}`" in sentence


def test_triangles_without_the_package_name_the_extra(monkeypatch):
    hide_gmsh(monkeypatch, ModuleNotFoundError("No module named 'gmsh'", name="gmsh"))
    assert cached_mesh(BLOCKS).nelements == BLOCKS.elements
    with pytest.raises(MissingLibraryError, match=r"pip install '\.\[fem\]'"):
        cached_mesh(replace(BLOCKS, pattern="triangles"))


def test_the_command_refuses_triangles_with_exit_code_5(without_gmsh, tmp_path, refused):
    options = f"--element P1 --mesh triangles --resolution 10 --output {tmp_path / 'run'}"
    assert "gmsh" in refused(f"simulate preloaded {options} --quiet", 5)


@pytest.mark.parametrize("how", FULL)
def test_a_full_disk_is_one_sentence(how, without_gmsh, tmp_path):
    blocks = Blocks(0.01, 40, 40, 40)
    with full_disk(how, tmp_path) as (folder, make_room):
        with pytest.raises(DataFileError, match=r"[\d,]+ bytes are needed in .* and [\d,]+ are"):
            build_mesh(blocks, folder / "blocks.msh")
        make_room()
        build_mesh(blocks, folder / "blocks.msh")
        read_mesh(folder / "blocks.msh", blocks)


def test_readme_and_ci_install_what_the_message_names():
    """The packages stand in meshes/apt-packages.txt alone, but for the line of the README."""
    readme = (ROOT / "README.md").read_text()
    (line,) = re.findall(r"^    apt install (.*libglu1-mesa.*)$", readme, re.MULTILINE)
    assert line == f"python3-venv {APT_PACKAGES}"
    ci = (ROOT / ".ci" / "run").read_text()
    assert "meshes/apt-packages.txt" in ci
    assert not any(name in ci for name in APT_PACKAGES.split())
