"""Whatever is typed or written into a scene file ends in a documented exit code and a sentence."""

from __future__ import annotations

import contextlib
import io
import json

import pytest
from fuzz_cases import REFUSED, Case, prepare, random_case

from slipfront.cli.commands import main

DOCUMENTED = {0, 1, 2, 3, 4, 5, 130}
CASES, SHARE = 500, 10


def outcome(case, folder):
    """Exit code and what was printed on both streams."""
    out, err = io.StringIO(), io.StringIO()
    prepare(folder, case)
    with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(case.arguments)
    return code, out.getvalue(), err.getvalue()


def faults(case, folder):
    """What is wrong with how a case ends; nothing if all is well."""
    code, out, err = outcome(case, folder)
    if code not in DOCUMENTED:
        yield f"exit code {code}"
    if "Traceback" in out + err:
        yield "a traceback"
    if code in (0, 1) and err and "it starts at t = 0" not in err:  # which --resume notes
        yield f"exit code {code} with {err!r}"
    if code in (2, 3, 4, 5):
        lines = err.splitlines()
        usage = err.count("─ Error ─") == 1 and lines[-1].startswith("╰─")
        sentence = len(lines) == 1 and lines[0].endswith((".", "?")) and len(lines[0]) < 1000
        if not (usage or sentence) and case.arguments:
            yield f"exit code {code} with {err!r}"
        if usage and code != 2:
            yield f"a usage error with exit code {code}"
    if "--json" in case.arguments and code == 0 and case.arguments[0] == "solve" and "{" in out:
        json.loads(out, parse_constant=lambda constant: pytest.fail(f"{constant} in JSON"))
    yield from (f"{path.name} is left" for path in folder.rglob("*.part"))


def check(seeds, tmp_path):
    found = {}
    for seed in seeds:
        folder = tmp_path / str(seed)
        folder.mkdir()
        wrong = list(faults(random_case(seed), folder))
        if wrong:
            found[seed] = wrong
    assert found == {}


@pytest.mark.thinned(50)
@pytest.mark.parametrize("first", range(0, CASES, SHARE))
def test_random_files_and_command_lines(first, tmp_path):
    check(range(first, first + SHARE), tmp_path)


@pytest.mark.thinned(10)
@pytest.mark.parametrize("arguments", REFUSED, ids=" ".join)
def test_what_cannot_be_is_refused_at_once(arguments, tmp_path):
    """Before anything is computed, that is without what it would have taken minutes for."""
    (tmp_path / "taken").touch()
    assert list(faults(Case(tuple(arguments)), tmp_path)) == []
    assert outcome(Case(tuple(arguments)), tmp_path)[0] in (2, 3)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken.h5", "taken"]


@pytest.mark.parametrize(
    "make", [lambda path: path.mkdir(), lambda path: path.symlink_to(path), lambda path: None]
)
def test_a_scene_file_that_is_none(make, tmp_path):
    """A folder, a link to itself, and no file at all."""
    make(tmp_path / "scene.toml")
    assert list(faults(Case(("solve", "scene.toml")), tmp_path)) == []
