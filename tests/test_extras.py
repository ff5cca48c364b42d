"""What an installation without extras can do, and the one sentence it says where it cannot."""

import importlib
import json
import sys
import tomllib
from functools import cache
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import packages
import pytest

import fem
import semianalytic
import slipfront
from compare import validation
from compare.comparison import comparing
from semianalytic import MissingLibraryError
from semianalytic.scene.extras import (
    CLUSTER,
    EXPLORE,
    FEM,
    HDF5,
    PLOT,
    UNITS,
    XARRAY,
    needing,
    require,
)
from slipfront import fits, loading, surveys

INSTALL = "run `pip install '.[{}]'` in the folder of slipfront."
ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGES = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
SLIM = """
import sys
from importlib.machinery import PathFinder

class Slim(PathFinder):
    blocked = {blocked}

    @staticmethod
    def find_spec(name, path=None, target=None):
        missing = name.split(".")[0] in Slim.blocked
        return None if missing else PathFinder.find_spec(name, path, target)

sys.meta_path[sys.meta_path.index(PathFinder)] = Slim
"""
COMMANDS = """
import contextlib, io, json
from slipfront.cli.commands import main

for Slim.blocked, line in {lines}:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(line.split())
    print(json.dumps([code, out.getvalue(), err.getvalue()]))
"""
SOURCES = (fem, comparing, validation, fits, loading, surveys, semianalytic)
"""Packages from which slipfront takes its public names."""
MOST = (*FEM, *EXPLORE, *CLUSTER)
"""Left out together: no command needs both finite elements and any of the others."""
ALL = (*FEM, *PLOT, *EXPLORE, *XARRAY, *CLUSTER, *UNITS)
FINE = [
    "--help",
    "scenes",
    "solve preloaded",
    "solve preloaded --json",
    "solve ramp --nodes 100 --quiet",
    "compare --help",
    "fit --help",
]
REFUSED = [
    (PLOT, "solve preloaded --plot a.png", "plot"),
    (PLOT, "solve ramp --plot a.pdf", "plot"),
    (PLOT, "compare", "plot"),
    (MOST, "solve ramp --save a.h5", "fem"),
    (MOST, "solve ramp --go-on a.h5", "fem"),
    (MOST, "simulate preloaded", "fem"),
    (MOST, "compare --from somewhere", "fem"),
    (PLOT, "fit a.csv --scene preloaded --parameters friction --plot a.png", "plot"),
    (MOST, "explore", "explore"),
    (MOST, "survey preloaded --friction 0.1,0.2 --scheduler tcp://127.0.0.1:1", "cluster"),
    (ALL, "survey preloaded --friction 0.1,0.2", "xarray"),
    (ALL, "compare", "fem,plot"),
    (ALL, "chart", "fem,plot"),
]


def run_without(blocked, code, folder):
    """What a new process that lacks some packages does."""
    return packages.run("", "-c", SLIM.format(blocked=tuple(blocked)) + code, cwd=folder)


def told_without(lines, folder):
    """Exit code, output and errors by (what is missing, line of a command), in one process.

    What is missing must not have been imported by a line before.
    """
    run = run_without((), COMMANDS.format(lines=lines), folder)
    assert run.returncode == 0, run.stderr
    assert list(folder.iterdir()) == []
    return dict(zip(lines, map(json.loads, run.stdout.splitlines()), strict=True))


@cache
def refusals(*lacking):
    """What the commands of `REFUSED` tell in one process in which those are missing in turn."""
    lines = [(extra, line) for extra in lacking for missing, line, _ in REFUSED if missing == extra]
    with TemporaryDirectory() as folder:
        return told_without(lines, Path(folder))


@pytest.mark.slow
def test_solver_and_help_need_no_extra(tmp_path):
    lines = [(ALL, line) for line in FINE]
    for line, (code, out, err) in told_without(lines, tmp_path).items():
        assert (code, err) == (0, ""), line
        assert out


@pytest.mark.parametrize(
    ("blocked", "line", "extras"),
    [pytest.param(*case, marks=[pytest.mark.slow] * (case[0] == MOST)) for case in REFUSED],
)
def test_missing_extra_is_one_sentence(blocked, line, extras):
    # where nothing is there nothing is imported, so that another lack may follow
    code, out, err = refusals(*((MOST,) if blocked == MOST else (ALL, PLOT)))[blocked, line]
    assert (code, out) == (5, "")
    assert err.count("\n") == 1
    assert err.endswith(f"not installed; {INSTALL.format(extras)}\n")


def test_missing_extra_of_a_function_is_one_sentence(tmp_path):
    calls = (
        *("sf.simulate(sf.Scene)", "sf.load('.')", "sf.cost"),
        *("import fem", "import meshes", "sf.Marched.load('a')"),
    )
    code = "import slipfront as sf\n" + "".join(
        f"try:\n    {call}\nexcept sf.MissingLibraryError as error:\n    print(error)\n"
        for call in calls
    )
    run = run_without(FEM, code, tmp_path)
    assert run.returncode == 0, run.stderr
    said = run.stdout.splitlines()
    assert len(said) == len(calls)
    assert all(line.endswith(f"not installed; {INSTALL.format('fem')}") for line in said)


@pytest.mark.slow
def test_results_are_saved_with_h5py_only(tmp_path):
    code = (
        "import slipfront as sf\n"
        "one = sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 1.0)\n"
        "scene = sf.Scene(sf.Material(1.0, 1.0, 0.3), 0.3, *one, shear_history=sf.Ramp(0.5))\n"
        "march = sf.solve(scene, nodes=50)\n"
        "try:\n    march.save('a.h5')\nexcept sf.MissingLibraryError as error:\n    print(error)\n"
    )
    assert "needs h5py" in run_without(HDF5, code, tmp_path).stdout
    others = [module for module in ALL if module != "h5py"]
    assert run_without(others, code, tmp_path).stderr == ""
    assert (tmp_path / "a.h5").exists()


def test_what_is_missing_is_listed_with_its_extras(monkeypatch):
    require("this", *FEM, *PLOT)
    for module in ("skfem", "matplotlib"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingLibraryError) as raised:
        require("this", *FEM, *PLOT)
    lacking = "this needs scikit-fem and matplotlib, which are not installed; "
    assert str(raised.value) == lacking + INSTALL.format("fem,plot")


def test_other_missing_modules_stay_what_they_are():
    with pytest.raises(ModuleNotFoundError, match="no_such_module"), needing("this"):
        importlib.import_module("no_such_module")


def test_extras_hold_what_they_are_said_to():
    extras = PROJECT["project"]["optional-dependencies"]
    names = {"skfem": "scikit-fem"}
    brought = {"fem": FEM, "plot": PLOT, "explore": EXPLORE, "xarray": XARRAY}
    brought |= {"cluster": CLUSTER, "units": UNITS}
    for extra, modules in brought.items():
        listed = {requirement.split(">")[0] for requirement in extras[extra]}
        assert listed - {"slipfront[plot]"} == {names.get(module, module) for module in modules}
    assert "slipfront[plot]" in extras["explore"]
    assert extras["all"] == ["slipfront[fem,plot,xarray,explore,cluster,units]"]
    assert "slipfront[all]" in extras["test"]
    needed = {requirement.split(">")[0] for requirement in PROJECT["project"]["dependencies"]}
    assert needed == {"numpy", "scipy", "rich", "typer"}


def test_slipfront_holds_all_public_names_and_nothing_of_its_own():
    public = [name for name in slipfront.__all__ if name != "__version__"]
    assert sorted(public) == sorted([name for source in SOURCES for name in source.__all__])
    assert len(set(public)) == len(public)
    for name in public:
        source = next(source for source in SOURCES if name in source.__all__)
        assert getattr(slipfront, name) is getattr(source, name)
    assert slipfront.__version__ == version("slipfront")
    assert slipfront.regimes is semianalytic.regimes
    assert slipfront.reference is semianalytic.reference
    assert dir(slipfront) == sorted(slipfront.__all__)
    with pytest.raises(AttributeError, match="no attribute 'solved'"):
        _ = slipfront.solved


def test_slipfront_stays_light(tmp_path):
    code = (
        "import slipfront\n"
        "print(sorted({'skfem', 'gmsh', 'meshio', 'h5py', 'matplotlib', 'xarray', 'rich', 'fem'}"
        " & set(sys.modules)))"
    )
    run = run_without((), code, tmp_path)
    assert run.stdout.strip() == "[]", run.stderr


def test_every_package_says_that_it_is_typed():
    folders = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"tests"}
    typed = {name for name in PROJECT["tool"]["mypy"]["packages"] if not name.startswith("docs.")}
    assert folders == set(PACKAGES) == typed
    for package in PACKAGES:
        assert (ROOT / package / "py.typed").read_text() == ""
