"""Who may import whom: the witness stays independent, the product stays light."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
DESCRIPTION = {
    f"semianalytic.{name}"
    for name in ("checks", "errors", "files", "friction", "history", "loads", "memory", "scene")
}
"""What a scene and a result are, and how files are written; `files` holds no numerics at all."""


def imported_modules(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


def sources(package, root=ROOT):
    """All modules of a package, those of its folders included."""
    return sorted((root / package).rglob("*.py"))


def undue_imports(package, root=ROOT):
    """What a package that is to stay independent imports though it must not."""
    for path in sources(package, root):
        for name in imported_modules(path):
            known = name in DESCRIPTION or not name.startswith("semianalytic")
            if not known or name.startswith("compare"):
                yield path.name, name


@pytest.mark.parametrize("package", ["fem", "meshes"])
def test_witness_sees_only_the_description_of_a_scene(package):
    assert list(undue_imports(package)) == []


def test_an_undue_import_is_found_in_a_folder_of_the_witness(tmp_path):
    (tmp_path / "fem" / "deeper").mkdir(parents=True)
    planted = "from semianalytic.solver import solve\nfrom semianalytic.scene import Scene\n"
    (tmp_path / "fem" / "deeper" / "planted.py").write_text(planted)
    assert list(undue_imports("fem", tmp_path)) == [("planted.py", "semianalytic.solver")]


def test_description_imports_no_numerics():
    for module in DESCRIPTION:
        path = ROOT / (module.replace(".", "/") + ".py")
        own = {name for name in imported_modules(path) if name.startswith("semianalytic")}
        assert own <= DESCRIPTION, path


def test_files_hold_no_numerics():
    path = ROOT / "semianalytic" / "files.py"
    allowed = {"h5py", "semianalytic.errors"} | set(sys.stdlib_module_names)
    for name in imported_modules(path):
        assert name in allowed or name.split(".")[0] in sys.stdlib_module_names, name


def test_product_needs_numpy_and_scipy_only():
    allowed = {"numpy", "scipy", "semianalytic", "h5py", "xarray"} | set(sys.stdlib_module_names)
    for path in sources("semianalytic"):
        assert {name.split(".")[0] for name in imported_modules(path)} <= allowed, path
    code = (
        "import sys, semianalytic;"
        "heavy = {'h5py', 'xarray', 'matplotlib', 'skfem', 'gmsh', 'meshio', 'rich'};"
        "print(sorted(heavy & set(sys.modules)))"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"


def test_meshes_know_nothing_of_the_solvers():
    for path in sources("meshes"):
        assert not any(name.startswith(("fem", "compare")) for name in imported_modules(path))
