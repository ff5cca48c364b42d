"""What all tests share."""

import gc
import os
import sys
from collections import Counter
from functools import cache
from importlib import import_module

import pytest
from hypothesis import settings

from docs.chromium import CHROMIUM, Browser
from meshes.build import APT_PACKAGES

collect_ignore = (
    []
    if sys.platform != "win32"
    else [
        "compare/output/test_fault_processes.py",
        "compare/output/test_faults.py",
        "compare/records/test_bounds.py",
        "compare/tasks/test_cluster.py",
        "fem/files/test_fem_checkpoint.py",
        "fem/files/test_fem_disk.py",
        "slipfront/cli/endings/test_endings.py",
        "slipfront/surveys/test_survey_files.py",
    ]
)
"""Tests that send signals, fork, limit resources or give up rights, none of which Windows can."""


RARELY = 5_000
"""New objects between two searches for garbage, which take 2 % of the run at Python's own 700."""


settings.register_profile("repeatable", derandomize=True)
settings.register_profile("searching")
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
# The same scenes in every run, so that a failing run is a fault of the change it tests;
# HYPOTHESIS_PROFILE=searching draws others.


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes():
    """One thread for each process, as there are as many of them as cores.

    Processes inherit it: within one it would be too late, since plug-ins import numpy earlier.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.fixture(autouse=True, scope="session")
def mesh_cache(tmp_path_factory):
    """Meshes are built anew by every test run, and once for all tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SLIPFRONT_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def exact_once():
    """Records of the exact answer are computed once for all validations of a module.

    For modules that hold many records against few scenes: most of the time of a validation.
    """
    from compare.validation import detection

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(detection, "exact_answer", cache(detection.exact_answer))
        yield


@pytest.fixture
def undrawn(monkeypatch):
    """Figures are made, and their files, but not drawn: most of the time of a comparison.

    For tests that look at other results; those of figures are in compare/figures/test_figures.py.
    """
    monkeypatch.setattr("compare.figures.saving.save_figure", lambda figure, path: path.touch())


@pytest.fixture
def shown(capsys):
    """Run a command, and return what it prints: `out` and `err`."""
    from slipfront.cli.commands import main

    def run(line, code=0):
        capsys.readouterr()
        assert main(line.split() if isinstance(line, str) else [str(word) for word in line]) == code
        return capsys.readouterr()

    return run


@pytest.fixture
def refused(shown):
    """Run a command that is to be refused, and return the one sentence that it prints alone."""

    def sentence(line, code=2):
        said = shown(line, code)
        assert said.out == ""
        assert said.err.count("\n") == 1, said.err
        assert "Traceback" not in said.err
        return said.err

    return sentence


@pytest.fixture
def printed(shown):
    """Run a command with --json, and return its document, which fits the schema."""
    from json_checks import checked

    def document(line, code=0):
        words = line.split() if isinstance(line, str) else line
        return checked(shown([*words, "--json"], code).out)

    return document


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    if CHROMIUM is None:
        pytest.skip("no chromium: apt install chromium")
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


@cache
def what_gmsh_lacks():
    """Why gmsh cannot be loaded here; empty if it can."""
    try:
        import_module("gmsh")
    except (ImportError, OSError) as error:
        return str(error)
    return ""


def pytest_runtest_setup(item):
    """Tests marked `gmsh` call for what nothing else can do: triangles, and meshes of its own."""
    if item.get_closest_marker("gmsh") and what_gmsh_lacks():
        pytest.skip(f"no gmsh ({what_gmsh_lacks()}): apt install {APT_PACKAGES}")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collect without looking for garbage: what is collected stays, and is not searched again.

    It is a tenth of the time that collecting takes, in each process.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()
        gc.set_threshold(RARELY, 10, 10)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark all cases of a test `thinned(n)` but every n-th one as slow."""
    cases = Counter()
    for item in items:
        thinned = item.get_closest_marker("thinned")
        if thinned is None:
            continue
        test = item.nodeid.partition("[")[0]
        if cases[test] % thinned.args[0]:
            item.add_marker(pytest.mark.slow)
        cases[test] += 1
