"""Machines without gmsh: squares need none, triangles are refused."""

import builtins
import re
from dataclasses import replace
from pathlib import Path

import pytest
from faults import FULL, full_disk

from meshes import Blocks, mesh_of
from meshes.build import APT_PACKAGES, cache_path
from meshes.read import read_mesh
from semianalytic.scene.errors import DataFileError, MissingLibraryError

ROOT = Path(__file__).parents[2]
BLOCKS = Blocks(size=0.1, left=4, right=6, height=3, pattern="triangles")
LACK = "libGLU.so.1: cannot open shared object file"


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


def test_squares_need_no_gmsh_and_no_file(without_gmsh, own_cache):
    assert mesh_of(replace(BLOCKS, pattern="squares")).nelements == BLOCKS.elements
    assert not own_cache.exists()


def test_triangles_are_refused_with_the_packages(without_gmsh):
    with pytest.raises(MissingLibraryError, match="a mesh of triangles needs gmsh") as refused:
        mesh_of(BLOCKS)
    (sentence,) = str(refused.value).splitlines()
    assert LACK in sentence
    assert f"apt install {APT_PACKAGES}`" in sentence


def test_triangles_without_the_package_name_the_extra(monkeypatch):
    hide_gmsh(monkeypatch, ModuleNotFoundError("No module named 'gmsh'", name="gmsh"))
    with pytest.raises(MissingLibraryError, match=r"pip install '\.\[fem\]'"):
        mesh_of(BLOCKS)


def test_the_command_refuses_triangles_with_exit_code_5(without_gmsh, tmp_path, refused):
    options = f"--mesh triangles --resolution 10 --output {tmp_path / 'run'}"
    assert "gmsh" in refused(f"simulate preloaded {options} --quiet", 5)


@pytest.mark.gmsh
@pytest.mark.parametrize("how", FULL)
def test_a_full_disk_is_one_sentence(how, tmp_path, monkeypatch):
    blocks = Blocks(0.01, 40, 40, 40, pattern="triangles")
    with full_disk(how, tmp_path) as (folder, make_room):
        monkeypatch.setenv("SLIPFRONT_CACHE", str(folder))
        with pytest.raises(DataFileError, match=r"[\d,]+ bytes are needed in .* and [\d,]+ are"):
            mesh_of(blocks)
        make_room()
        mesh_of(blocks)
        read_mesh(cache_path(blocks), blocks)


def test_readme_and_ci_install_what_the_message_names():
    """The packages stand in meshes/apt-packages.txt alone, but for the line of the README."""
    readme = (ROOT / "README.md").read_text()
    (line,) = re.findall(r"^    apt install (.*libglu1-mesa.*)$", readme, re.MULTILINE)
    assert line == f"python3-venv {APT_PACKAGES}"
    ci = (ROOT / ".ci" / "run").read_text()
    assert "meshes/apt-packages.txt" in ci
    assert not any(name in ci for name in APT_PACKAGES.split())
