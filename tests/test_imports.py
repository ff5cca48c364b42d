"""Who may import whom: the witness stays independent, the product stays light."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
DESCRIPTION = {
    f"semianalytic.{name}" for name in ("errors", "friction", "history", "loads", "scene")
}


def imported_modules(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


def sources(package):
    return sorted((ROOT / package).glob("*.py"))


@pytest.mark.parametrize("package", ["fem", "meshes"])
def test_witness_sees_only_the_description_of_a_scene(package):
    for path in sources(package):
        own = {name for name in imported_modules(path) if name.startswith("semianalytic")}
        assert own <= DESCRIPTION, path
        assert not any(name.startswith("compare") for name in imported_modules(path)), path


def test_description_imports_no_numerics():
    for module in DESCRIPTION:
        path = ROOT / (module.replace(".", "/") + ".py")
        own = {name for name in imported_modules(path) if name.startswith("semianalytic")}
        assert own <= DESCRIPTION, path


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
