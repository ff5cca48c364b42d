"""The command line through its entry point."""

import csv
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from catalogue import UNIT_FILE

import compare.comparison.prediction
import slipfront.cli.solve_command
from compare.comparison.judgement import Judgement
from compare.comparison.rows import Row
from semianalytic import solve
from semianalytic.scene.errors import ComputationError, MissingLibraryError
from slipfront.cli.commands import main
from slipfront.cli.terminal import verdict_text

COARSE = ("--resolution", "40", "--frames", "2")

COMPARISON_FIGURES = {
    f"{name}.png" for name in ("slip_rate", "tractions", "fronts", "sense", "history", "wear")
}
COMPARED_FIELDS = {"fields.png", "fields.csv"}


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    """Relative paths of the commands end up in a fresh folder; tables get room."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Folder of a coarse simulation of the default scene."""
    folder = tmp_path_factory.mktemp("simulated") / "preloaded"
    assert main(["simulate", "preloaded", *COARSE, "--output", str(folder)]) == 0
    return folder


def run_apart(*arguments, **variables):
    """Run the command in a process of its own, with environment variables."""
    code = "import sys; from slipfront.cli.commands import main; sys.exit(main())"
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | variables
    )


def test_scenes_lists_every_name(capsys):
    assert main(["scenes"]) == 0
    out = capsys.readouterr().out
    for name in ("preloaded", "remote-shock", "stuck"):
        assert name in out


def test_solve_prints_zones_and_edge(capsys):
    assert main(["solve", "preloaded"]) == 0
    out = capsys.readouterr().out
    assert "sub-Rayleigh" in out
    assert "c_t–c_l" in out
    assert "converged" in out


def test_viscosity_is_an_option_like_others(printed):
    named = printed("solve viscous")
    given = printed("solve preloaded --friction 0.2 --viscosity 0.1")
    assert given["scene"]["friction_law"] == {"kind": "viscous", "viscosity": 0.1}
    assert given["scene"] == named["scene"]
    assert given["zones"] == named["zones"]


def test_an_open_contact_edge_has_no_intensity_and_no_minus(capsys):
    assert main(["solve", "lift-off-shear", "--load-shear", "-1"]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "K_I" in line]
    assert "0, 0" in line
    assert "-0" not in line


def test_solve_of_a_stuck_scene_says_so(capsys):
    assert main(["solve", "stuck"]) == 0
    assert "stuck everywhere" in capsys.readouterr().out


def test_solve_json_is_nothing_but_json(printed):
    document = printed("solve preloaded --friction 1")
    (zone,) = document["zones"]
    # Closed form of theory.md, section 4: c_t / ((1 - nu) (1 + chi)^2).
    assert zone["outer"] == pytest.approx(0.375, rel=0.01)
    assert zone["outer_regime"] == "sub-Rayleigh"


def test_solve_draws_a_plot(tmp_path, capsys):
    path = tmp_path / "plots" / "prediction.png"
    assert main(["solve", "preloaded", "--plot", str(path)]) == 0
    assert path.read_bytes().startswith(b"\x89PNG")
    assert "prediction.png" in capsys.readouterr().out


@pytest.mark.slow
def test_solve_imports_only_what_it_uses():
    """No finite elements, no figures, and no part of scipy that takes longer than the solution."""
    unused = [
        *("skfem", "gmsh", "meshio", "matplotlib"),
        *("scipy.interpolate", "scipy.ndimage", "scipy.optimize", "scipy.stats"),
    ]
    code = (
        "import sys; from slipfront.cli.commands import main\n"
        "main(['solve', 'preloaded']); main(['scenes'])\n"
        f"sys.exit(any(name in sys.modules for name in {unused}))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


def test_a_scene_file_is_as_good_as_a_name(tmp_path, printed):
    path = tmp_path / "mine.toml"
    path.write_text(UNIT_FILE)
    assert printed(["solve", path])["scene"]["material"]["poisson_ratio"] == 0.3


def test_entry_point_as_a_process():
    run = run_apart("solve", "nowhere")
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.startswith("There is no scene called 'nowhere'")


@pytest.mark.parametrize(
    ("error", "code"), [(ComputationError("It diverged."), 4), (MissingLibraryError("No GLU."), 5)]
)
def test_other_errors_have_exit_codes_of_their_own(error, code, monkeypatch, refused):
    def fail(scene):
        raise error

    monkeypatch.setattr(slipfront.cli.solve_command, "solve", fail)
    assert refused("solve preloaded", code) == f"{error}\n"


UNCONVERGED = "no set of slip zones was found that fulfils Coulomb's law everywhere"


@pytest.fixture
def unconverged(monkeypatch):
    """A solver that does not converge."""

    def fail(scene):
        return replace(solve(scene), status=UNCONVERGED, error_estimate=np.inf)

    for module in (slipfront.cli.solve_command, compare.comparison.prediction):
        monkeypatch.setattr(module, "solve", fail)


def test_solve_prints_an_answer_that_has_not_converged_and_exits_with_four(unconverged, capsys):
    assert main(["solve", "preloaded"]) == 4
    captured = capsys.readouterr()
    assert "sub-Rayleigh" in captured.out
    assert captured.err.startswith(f"preloaded has not converged: {UNCONVERGED};")
    assert captured.err.count("\n") == 1
    assert main(["solve", "preloaded", "--json"]) == 4
    captured = capsys.readouterr()
    document = json.loads(captured.out, parse_constant=pytest.fail)
    assert document["status"] == UNCONVERGED
    assert document["error_estimate"] is None
    assert document["zones"]
    assert captured.err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_compare_with_an_answer_that_has_not_converged_writes_and_exits_with_four(
    unconverged, simulated, tmp_path, capsys
):
    command = ["compare", "--from", str(simulated), "--no-snapshots", "--output", str(tmp_path)]
    assert main(command) == 4
    assert "has not converged" in capsys.readouterr().err
    document = json.loads((tmp_path / "report.json").read_text(), parse_constant=pytest.fail)
    assert document["semianalytic"]["error_estimate"] is None
    assert "the prediction has not converged" in {row["obstacle"] for row in document["rows"]}


def test_where_the_load_acts_is_an_option_a_key_and_said(tmp_path, capsys, printed, refused):
    options = "--friction 1.25 --base-pressure 0 --load-pressure 1 --load-on remote"
    found, known = printed(f"solve preloaded {options}"), printed("solve remote-shock")
    assert found["scene"] == known["scene"]
    assert (found["scene"]["load_on"], found["zones"]) == ("remote", known["zones"])
    assert main(["init", str(tmp_path / "shock.toml"), "--from", "remote-shock"]) == 0
    assert 'load_on = "remote"' in (tmp_path / "shock.toml").read_text()
    capsys.readouterr()
    assert main(["solve", str(tmp_path / "shock.toml")]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"pressure, shear before\s*│ 0, 0 ", shown)
    assert re.search(r"load from far away\s*│ 1, 1 ", shown)
    assert "comes as a step" in refused("solve ramp --load-on remote")
    said = refused("solve preloaded --load-on far")
    assert said == "--load-on must be slot or remote, got 'far'.\n"


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    "arguments", [["scenes"], ["solve", "remote-shock", "--friction", "0.5"], ["solve", "--help"]]
)
def test_a_terminal_of_ascii_is_no_obstacle(arguments):
    run = run_apart(*arguments, PYTHONIOENCODING="ascii")
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.isascii()


@pytest.mark.slow
def test_names_that_cannot_be_printed_are_escaped(refused):
    assert r"called '\udcff\n\x1b[31mß'" in refused(["solve", "\udcff\n\x1b[31mß"])
    run = run_apart("solve", "ß", PYTHONIOENCODING="ascii")
    assert run.returncode == 2
    assert run.stderr.startswith(r"There is no scene called '\xdf'")


@pytest.mark.slow
def test_a_drawing_library_set_up_for_windows_that_do_not_exist_draws(tmp_path):
    path = tmp_path / "plot.png"
    run = run_apart("solve", "stuck", "--plot", str(path), MPLBACKEND="nonsense")
    assert (run.returncode, run.stderr) == (0, "")
    assert path.is_file()


def test_huge_numbers_are_refused_in_one_sentence(tmp_path, refused):
    many = "1" * 400
    path = tmp_path / "huge.toml"
    path.write_text(UNIT_FILE.replace("friction = 0.3", f"friction = {many}"))
    for arguments in (
        f"solve {path}",
        f"solve preloaded --friction {many}",
        "solve preloaded --density 1e300",
        "solve ramp --end-time 1e300",
        f"solve ramp --nodes {many}",
        "simulate ramp --end-time 1e300",
        f"simulate ramp --resolution {many}",
        "compare ramp --end-time 1e300",
    ):
        assert len(refused(arguments)) < 400


def test_interrupt_is_a_short_sentence_and_130(monkeypatch, refused):
    def interrupt(scene):
        raise KeyboardInterrupt

    monkeypatch.setattr(slipfront.cli.solve_command, "solve", interrupt)
    assert "Interrupted" in refused("solve preloaded", 130)


def test_simulate_writes_history_and_snapshots(simulated):
    names = {path.name for path in simulated.iterdir()}
    assert {"simulation.h5", "snapshots"} <= names
    snapshots = list((simulated / "snapshots").iterdir())
    assert {path.suffix for path in snapshots if path.is_file()} == {".vtu", ".pvd"}
    # the last frames of its companions, from which fields get their error bars
    folders = {path.name: path for path in snapshots if path.is_dir()}
    assert set(folders) == {"2h", "4h"}
    assert all(len(list(folder.glob("*.vtu"))) == 1 for folder in folders.values())


def test_simulate_quietly_and_without_snapshots(tmp_path, capsys):
    folder = tmp_path / "short"
    arguments = ["simulate", "stuck", "--resolution", "20", "--no-snapshots", "--quiet"]
    assert main([*arguments, "--output", str(folder)]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    assert captured.out == f"Written to {folder}/\n"
    assert not (folder / "snapshots").exists()


def test_an_output_folder_that_is_a_file_exits_with_three(tmp_path, refused):
    taken = tmp_path / "taken"
    taken.write_text("")
    assert "taken" in refused(f"simulate stuck --resolution 20 --quiet --output {taken}", 3)


@pytest.mark.slow
def test_compare_with_an_earlier_simulation(simulated, tmp_path, capsys):
    folder = tmp_path / "compared"
    code = main(["compare", "preloaded", "--from", str(simulated), "--output", str(folder)])
    document = json.loads((folder / "report.json").read_text())
    assert code == (1 if document["verdict"] == "differs" else 0)
    names = {path.name for path in folder.iterdir()}
    assert names == COMPARISON_FIGURES | COMPARED_FIELDS | {"report.json"}
    out = capsys.readouterr().out
    for row in document["rows"]:
        assert row["name"] in out
    assert f"Verdict: {document['verdict']} (" in out


def test_agreement_is_told_with_its_largest_difference_and_widest_bar():
    """In bars and per cent; rows that differ by more, or do not agree, are none of it."""
    rows = (
        Row("slip, L1", "slip", None, 1.0, 1.0, -0.03, 0.04, relative=True),
        Row("largest gap", "gap", None, 2.0, 2.1, 0.1, 0.5, "length"),
        Row("onset", "onset", None, 0.5, 0.7, 0.2, 0.3, place="x = 1"),
        Row("pressure", "pressure", None, 1.0, 1.0, 0.0, 0.0, "stress"),
        Row("front", "arrival", None, 1.0, 2.0, 1.0, 1.0, obstacle="not sharp"),
    )
    said = verdict_text(Judgement(SimpleNamespace(rests=False), rows)).splitlines()
    assert said[:3] == [
        "Verdict: agrees (4 agrees, 1 unresolved).",
        "Largest difference of what agrees: 0.75 bars (slip, L1: 3.0 % ± 4.0 %).",
        "Widest bar of what agrees: 25 % of the value compared (largest gap [length]).",
    ]
    worse = replace(rows[0], difference=0.2)
    said = verdict_text(Judgement(SimpleNamespace(rests=False), (worse, *rows[1:])))
    assert "differs" in said
    assert "Largest" not in said


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_compare_judges_whole_fields(simulated, tmp_path, capsys):
    command = ["compare", "--from", str(simulated), "--output", str(tmp_path)]
    main(command)
    document, out = json.loads((tmp_path / "report.json").read_text()), capsys.readouterr().out
    frames = document["fields"]["frames"]
    assert len(frames) == 7 * len(list((simulated / "snapshots").glob("*.vtu")))
    assert document["units"]["fields"]["frames"]["time"] == "time"
    rows = {row["name"]: row for row in document["rows"] if row["kind"] == "field"}
    for error in frames[-7:]:
        assert 0 < error["outside"] < error["whole"] < 0.2
        whole = rows[f"{error['component']}, whole"]
        assert whole["difference"] == pytest.approx(error["whole"])
        assert whole["bar"] > 0
        assert whole["verdict"] != "differs"
        assert f"{error['component']}, whole" in out
    assert len(rows) == 14
    assert sum(row["verdict"] == "agrees" for row in rows.values()) >= 10
    with (tmp_path / "fields.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["whole"]) for row in rows] == [error["whole"] for error in frames]
    main([*command, "--no-snapshots"])
    assert json.loads((tmp_path / "report.json").read_text())["fields"] is None
    assert not COMPARED_FIELDS & {path.name for path in tmp_path.iterdir()}
    assert ", whole" not in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_compare_without_output_writes_beside_the_simulation(simulated):
    main(["compare", "--from", str(simulated)])
    document = json.loads((simulated / "report.json").read_text())
    assert document["scene"] == simulated.name


def test_compare_refuses_a_simulation_of_another_scene(simulated, refused):
    assert "another scene" in refused(["compare", "stuck", "--from", simulated])


def test_compare_from_a_damaged_or_absent_simulation_exits_with_three(tmp_path, refused):
    refused(["compare", "--from", tmp_path / "absent"], 3)
    (tmp_path / "simulation.h5").write_text("not HDF5")
    refused(["compare", "--from", tmp_path], 3)


@pytest.mark.usefixtures("undrawn")
def test_main_job_writes_everything_under_the_name_of_the_scene(tmp_path, capsys):
    code = main(["compare", "--resolution", "30", "--frames", "2", "--friction", "1"])
    folder = tmp_path / "results" / "preloaded-friction-1"
    names = {path.name for path in folder.iterdir()}
    kept = {"report.json", "simulation.h5", "snapshots"}
    assert names == COMPARISON_FIGURES | COMPARED_FIELDS | kept
    captured = capsys.readouterr()
    assert "results/preloaded-friction-1/" in captured.out
    assert "mesh size" in captured.err
    document = json.loads((folder / "report.json").read_text())
    assert code == (1 if document["verdict"] == "differs" else 0)
    assert document["parameters"]["friction"] == 1.0


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_prediction_that_differs_exits_with_one(simulated, monkeypatch, tmp_path, capsys):
    """With the answer for more friction in place of the right one."""

    def spoilt(scene):
        return solve(replace(scene, friction=0.6))

    monkeypatch.setattr(compare.comparison.prediction, "solve", spoilt)
    arguments = ["compare", "--from", str(simulated), "--output", str(tmp_path / "out")]
    assert main(arguments) == 1
    out = capsys.readouterr().out
    assert "Verdict: differs (" in out
    document = json.loads((tmp_path / "out" / "report.json").read_text())
    assert document["verdict"] == "differs"
    assert document["counts"]["differs"] >= 3
    monkeypatch.undo()
    assert main(arguments) == 0


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_what_a_mesh_cannot_show_is_listed_with_what_would_and_exits_with_zero(tmp_path, capsys):
    options = ["--resolution", "20", "--no-snapshots", "--quiet", "--output", str(tmp_path / "out")]
    assert main(["compare", "preloaded", "--friction", "0.15", *options]) == 0
    out = capsys.readouterr().out
    table, unresolved = out.split("Unresolved:\n")
    assert "unresolved" in table
    told = " ".join(unresolved.split())
    assert (
        "· zone 1, outer edge; zone 2, inner edge: the gap to the next zone is 0.00053 c_t" in told
    )
    assert "(resolution 14995, h = 6.7e-05: " in told


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("columns", ["80", "100"])
def test_a_table_shows_all_columns_in_a_narrow_terminal(columns, simulated, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", columns)
    main(["compare", "--from", str(simulated)])
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert max(map(len, lines)) <= int(columns)
    assert "…" not in "".join(lines)
    (heads,) = (" ".join(line.split()) for line in lines if line.startswith(" quantity"))
    assert heads == "quantity exact at nodes FEM differ by bar ± verdict"
    verdicts = [line.split()[-1] for line in lines[3 : lines.index("", 3)] if line.split()]
    document = json.loads((simulated / "report.json").read_text())
    assert [one for one in verdicts if one in ("agrees", "differs", "unresolved")] == [
        row["verdict"] for row in document["rows"]
    ]


@pytest.mark.thinned(2)
@pytest.mark.parametrize("quiet", [False, True])
def test_long_simulations_say_what_they_will_cost(quiet, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("slipfront.cli.simulate_command.WORTH_SAYING", 0.0)
    options = ["--resolution", "16", "--no-snapshots", "--output", str(tmp_path / "out")]
    assert main(["simulate", "preloaded", *options, *["--quiet"] * quiet]) == 0
    first, *_ = (capsys.readouterr().err or "\n").splitlines()
    cost = r"preloaded: [\d,]+ unknowns and 36 steps will take about 1 minute and 0\.\d GB\."
    assert bool(re.fullmatch(cost, first)) == (not quiet)


def test_short_simulations_do_not(tmp_path, capsys):
    options = ["--resolution", "16", "--no-snapshots", "--output", str(tmp_path / "out")]
    assert main(["simulate", "preloaded", *options]) == 0
    assert "will take" not in capsys.readouterr().err


def test_help_shows_units(capsys):
    """In brackets, which the help would otherwise take for markup."""
    assert main(["solve", "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "Shear modulus [stress]." in shown
    assert "[mass / length³]" in shown
    assert "[GB]" in shown


@pytest.mark.parametrize("command", ["compare", "explore"])
def test_help_shows_tables_of_files(command, capsys):
    assert main([command, "--help"]) == 0
    assert "the file's [lower_material]" in " ".join(capsys.readouterr().out.split())
