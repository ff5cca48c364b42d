"""The command line through its entry point."""

import json
import re
from dataclasses import replace

import numpy as np
import packages
import pytest
from catalogue import UNIT_FILE

import slipfront.cli.solve_command
from semianalytic import solve
from semianalytic.scene.errors import ComputationError, MissingLibraryError


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("scenes", ("preloaded", "remote-shock", "stuck")),
        ("solve preloaded", ("sub-Rayleigh", "c_t–c_l", "converged")),
        ("solve stuck", ("stuck everywhere",)),
        ("compare --help", ("the file's [lower_material]",)),
        ("explore --help", ("the file's [lower_material]",)),
        # in brackets, which the help would otherwise take for markup
        ("solve --help", ("Shear modulus [stress].", "[mass / length³]", "[GB]")),
    ],
)
def test_what_is_printed(line, words, shown):
    said = " ".join(shown(line).out.split())
    assert [word for word in words if word not in said] == []


def test_an_open_contact_edge_has_no_intensity_and_no_minus(shown):
    said = shown("solve lift-off-shear --load-shear -1").out
    (line,) = [line for line in said.splitlines() if "K_I" in line]
    assert "0, 0" in line
    assert "-0" not in line
    assert " -0 " not in shown("solve ramp --nodes 32 --length 100 --no-estimate", 4).out


def test_a_plot_is_of_the_time_that_is_asked_for(tmp_path, shown):
    """The last of --t, or the end time; without either that of a length of 1."""
    asked = {"a": "", "b": "--x 0.1 --t 0.5", "c": "--end-time 0.5"}
    for name, more in asked.items():
        shown(f"solve preloaded {more} --plot {name}.svg")
    a, b, c = ((tmp_path / f"{name}.svg").read_text() for name in asked)
    assert ("t = 1" in a, "t = 0.5" in b, "t = 0.5" in c) == (True, True, True)


def test_solve_draws_a_plot(tmp_path, shown):
    assert "prediction.png" in shown("solve preloaded --plot plots/prediction.png").out
    assert (tmp_path / "plots" / "prediction.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_solve_imports_only_what_it_uses():
    """No finite elements, figures or page for a refused scene, and no slow part of scipy."""
    unused = [
        *("skfem", "gmsh", "meshio", "matplotlib", "bokeh"),
        *("scipy.interpolate", "scipy.ndimage", "scipy.optimize", "scipy.stats"),
    ]
    code = (
        "import sys; from slipfront.cli.commands import main\n"
        "main(['solve', 'preloaded']); main(['scenes']); main(['explore', 'absent.toml'])\n"
        f"sys.exit(any(name in sys.modules for name in {unused}))"
    )
    run = packages.run("", "-c", code)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize(
    ("error", "code"), [(ComputationError("It diverged."), 4), (MissingLibraryError("No GLU."), 5)]
)
def test_other_errors_have_exit_codes_of_their_own(error, code, monkeypatch, refused):
    def fail(scene, **_):
        raise error

    monkeypatch.setattr(slipfront.cli.solve_command, "solve", fail)
    assert refused("solve preloaded", code) == f"{error}\n"


UNCONVERGED = "no set of slip zones was found that fulfils Coulomb's law everywhere"


def unconverged(scene, **_):
    """What a solver gives that does not converge."""
    return replace(solve(scene), status=UNCONVERGED, error_estimate=np.inf)


def test_solve_prints_an_answer_that_has_not_converged_and_exits_with_four(monkeypatch, shown):
    monkeypatch.setattr(slipfront.cli.solve_command, "solve", unconverged)
    table, text = (shown(f"solve preloaded {option}", 4) for option in ("", "--json"))
    assert "sub-Rayleigh" in table.out
    assert table.err.startswith(f"preloaded has not converged: {UNCONVERGED};")
    assert table.err.count("\n") == text.err.count("\n") == 1
    document = json.loads(text.out, parse_constant=pytest.fail)
    assert document["status"] == UNCONVERGED
    assert document["error_estimate"] is None
    assert document["zones"]


def test_where_the_load_acts_is_an_option_a_key_and_said(tmp_path, shown, printed):
    options = "--friction 1.25 --base-pressure 0 --load-pressure 1 --load-on remote"
    found, known = printed(f"solve preloaded {options}"), printed("solve remote-shock")
    assert found["scene"] == known["scene"]
    assert (found["scene"]["load_on"], found["zones"]) == ("remote", known["zones"])
    shown("init shock.toml --from remote-shock")
    assert 'load_on = "remote"' in (tmp_path / "shock.toml").read_text()
    said = shown("solve shock.toml").out
    assert re.search(r"pressure, shear before\s*│ 0, 0 ", said)
    assert re.search(r"load from far away\s*│ 1, 1 ", said)


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    "arguments", [["scenes"], ["solve", "remote-shock", "--friction", "0.5"], ["solve", "--help"]]
)
def test_a_terminal_of_ascii_is_no_obstacle(arguments):
    run = packages.run("", *arguments, PYTHONIOENCODING="ascii")
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.isascii()


def test_a_narrow_terminal_cuts_no_number(monkeypatch, shown):
    monkeypatch.setenv("COLUMNS", "40")
    out = shown("solve preloaded --x 0.5 --t 1").out
    assert max(map(len, out.splitlines())) <= 40
    assert "…" not in out
    rows = [line.split("│") for line in out.splitlines() if line.count("│") == 6]
    assert "0.47107491854" in "".join(row[3].strip() for row in rows)


@pytest.mark.slow
def test_names_that_cannot_be_printed_are_escaped(refused):
    assert r"called '\udcff\n\x1b[31mß'" in refused(["solve", "\udcff\n\x1b[31mß"])
    run = packages.run("", "solve", "ß", PYTHONIOENCODING="ascii")
    assert run.returncode == 2
    assert run.stderr.startswith(r"There is no scene called '\xdf'")


@pytest.mark.slow
def test_a_drawing_library_set_up_for_windows_that_do_not_exist_draws(tmp_path):
    path = tmp_path / "plot.png"
    run = packages.run("", "solve", "stuck", "--plot", str(path), MPLBACKEND="nonsense")
    assert (run.returncode, run.stderr) == (0, "")
    assert path.is_file()


def test_huge_numbers_are_refused_in_one_sentence(tmp_path, refused):
    many = "1" * 400
    huge = UNIT_FILE.replace("friction = 0.3", f"friction = {many}")
    (tmp_path / "huge.toml").write_text(huge)
    for arguments in (
        "solve huge.toml",
        f"solve preloaded --friction {many}",
        "solve preloaded --density 1e300",
        "solve ramp --end-time 1e300",
        f"solve ramp --nodes {many}",
        "simulate ramp --end-time 1e300",
        f"simulate ramp --resolution {many}",
        "compare ramp --end-time 1e300",
    ):
        assert len(refused(arguments)) < 400
