"""``slipfront simulate`` and ``compare``: files, verdicts, exit codes and what is said."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

import compare.comparison.prediction
from compare.comparison.judgement import Judgement
from compare.comparison.judging import BY_LITTLE
from compare.comparison.rows import UNLIKE, Row
from slipfront.cli.commands import main
from slipfront.cli.terminal import print_judgement, unresolved_lines, verdict_lines
from tests.slipfront.cli.test_cli import unconverged

COMPARISON_FIGURES = {f"{name}.png" for name in ("interface", "fronts", "sense", "history")}
COMPARED_FIELDS = {"fields.png", "fields.csv"}


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Folder of a coarse simulation of the default scene."""
    folder = tmp_path_factory.mktemp("simulated") / "preloaded"
    line = f"simulate preloaded --resolution 40 --frames 2 --output {folder}"
    assert main(line.split()) == 0
    return folder


def reported(folder="."):
    """What the report in a folder says; JSON knows no infinite numbers."""
    return json.loads((Path(folder) / "report.json").read_text(), parse_constant=pytest.fail)


def test_simulate_writes_history_and_snapshots(simulated):
    names = {path.name for path in simulated.iterdir()}
    assert {"simulation.h5", "snapshots"} <= names
    snapshots = list((simulated / "snapshots").iterdir())
    assert {path.suffix for path in snapshots if path.is_file()} == {".vtu", ".pvd"}
    # the last frames of its companions, from which fields get their error bars
    folders = {path.name: path for path in snapshots if path.is_dir()}
    assert set(folders) == {"2h", "4h"}
    assert all(len(list(folder.glob("*.vtu"))) == 1 for folder in folders.values())


def test_simulate_quietly_and_without_snapshots(tmp_path, shown):
    said = shown("simulate stuck --resolution 20 --no-snapshots --quiet --output short")
    assert (said.out, said.err) == ("Written to short/\n", "")
    assert not (tmp_path / "short" / "snapshots").exists()


ROWS = (
    Row("slip, L1", "slip", None, 1.0, 1.0, -0.03, 0.04, relative=True, order=1.2),
    Row("slip rate, L1", "slip rate", None, 1.0, 1.0, 0.01, 0.02, relative=True, obstacle="why"),
    Row("largest gap", "gap", None, 2.0, 2.1, 0.1, 0.5, "length"),
    Row("zone 1, outer edge", "zone edge", None, 0.8, 0.8, 0.002, 0.01, "c_t"),
    Row("zone 2, inner edge", "zone edge", None, 0.9, 0.9, 0.003, 0.02, "c_t"),
    Row("onset", "onset", None, 0.5, 0.7, 0.2, 0.3, place="x = 1"),
    Row("front", "arrival", None, 1.0, 2.0, 1.0, 1.0, obstacle="not sharp"),
)


def judgement(*rows):
    return Judgement(SimpleNamespace(rests=False, remedy=str, simulation=None), rows)


def test_the_verdict_says_first_what_is_quoted_of_a_comparison():
    """Bars above a tenth of what is compared stand beside the word; what is not known is said."""
    assert list(verdict_lines(judgement(*ROWS))) == [
        "Verdict: agrees within ± 25 % of largest gap (rows: 5 agree, 2 unresolved).",
        "Difference ± error bar of what decides: slip 3.0 ± 4.0 %, slip rate 1.0 ± 2.0 % "
        "(unresolved), gap 0.10 ± 0.50, edges 0.0020 ± 0.010 c_t.",
    ]
    worse = replace(ROWS[0], difference=0.2)
    assert next(verdict_lines(judgement(worse, *ROWS[1:]))).startswith("Verdict: differs (")


def test_what_is_little_beyond_its_bar_is_said_and_leaves_the_verdict_open():
    beyond = replace(ROWS[0], difference=-0.0403, obstacle=BY_LITTLE.format(1.4))
    found = judgement(beyond, *ROWS[1:])
    assert "slip 4.030 ± 4.000 % (beyond its bar), " in found.quoted
    assert next(reasons(found)) == ("Unresolved, which leaves the verdict open:", "slip, L1")


def reasons(found):
    """Names of unresolved rows, each below its heading."""
    heading = ""
    for line in unresolved_lines(found):
        if line.startswith("Unresolved"):
            heading = line
        else:
            yield heading, line.strip(" ·").split(":")[0]


def test_rows_that_decide_nothing_leave_no_verdict_open():
    """The deciding rows of an open verdict are said by themselves, the others after them."""
    without = "Unresolved, without effect on the verdict:"
    assert [*reasons(judgement(*ROWS))] == [(without, "slip rate, L1"), (without, "front")]
    open_ = "Unresolved, which leaves the verdict open:"
    found = judgement(ROWS[1], *ROWS[3:])
    assert found.verdict == "unresolved"
    assert [*reasons(found)] == [(open_, "slip rate, L1"), (without, "front")]


def test_meshes_that_are_not_alike_leave_a_comparison_unresolved():
    """A coarse mesh that is wrong by itself widens the bars of the others."""
    unlike = Row("coarser runs against this one", "law", None, 0.0, 2.0, 2.0, 1.0, obstacle=UNLIKE)
    assert judgement(*ROWS).verdict == "agrees"
    assert judgement(*ROWS, unlike).verdict == "unresolved"


def test_rows_that_agree_are_printed_on_demand(capsys):
    heads = {"at_nodes": "at nodes", "simulated": "FEM"}
    for everything in (False, True):
        print_judgement(judgement(*ROWS), "title", heads, everything=everything)
        said = " ".join(capsys.readouterr().out.split())
        assert said.startswith("Verdict: agrees")
        assert ("largest gap [length]" in said) == everything
        assert ("5 rows agree; --all prints them." in said) != everything
        assert "slip rate, L1: why" in said
        if everything:
            assert "agrees ± 25 %" in said
            assert "onset at x = 1" in said


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_compare_judges_whole_fields(simulated, tmp_path, capsys):
    command = ["compare", "--from", str(simulated), "--output", str(tmp_path)]
    main(command)
    document = reported()
    frames = document["fields"]["frames"]
    assert len(frames) == 7 * len(list((simulated / "snapshots").glob("*.vtu")))
    assert document["units"]["fields"]["frames"]["time"] == "time"
    verdicts = [row["verdict"] for row in document["rows"] if row["kind"] == "field"]
    assert (len(verdicts), "differs" in verdicts) == (14, False)
    assert verdicts.count("agrees") >= 10
    with (tmp_path / "fields.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["whole"]) for row in rows] == [error["whole"] for error in frames]
    capsys.readouterr()
    main([*command, "--no-snapshots"])
    assert reported()["fields"] is None
    assert not COMPARED_FIELDS & {path.name for path in tmp_path.iterdir()}
    assert ", whole" not in capsys.readouterr().out


def test_compare_refuses_a_simulation_of_another_scene(simulated, refused):
    assert "another scene" in refused(["compare", "stuck", "--from", simulated])


def test_compare_from_a_damaged_or_absent_simulation_exits_with_three(tmp_path, refused):
    refused(["compare", "--from", tmp_path / "absent"], 3)
    (tmp_path / "simulation.h5").write_text("not HDF5")
    refused(["compare", "--from", tmp_path], 3)


@pytest.mark.usefixtures("undrawn")
def test_main_job_writes_everything_under_the_name_of_the_scene(shown):
    said = shown("compare --resolution 20 --frames 1 --friction 1")
    folder = Path("results/preloaded-friction-1")
    names = {path.name for path in folder.iterdir()}
    kept = {"report.html", "report.json", "simulation.h5", "snapshots"}
    assert names == COMPARISON_FIGURES | COMPARED_FIELDS | kept
    assert f"{folder}/" in said.out
    assert "mesh size" in said.err
    document = reported(folder)
    assert document["verdict"] != "differs"
    assert document["parameters"]["friction"] == 1.0


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_compare_with_an_answer_that_has_not_converged_writes_and_exits_with_four(
    simulated, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(compare.comparison.prediction, "solve", unconverged)
    command = ["compare", "--from", str(simulated), "--no-snapshots", "--output", str(tmp_path)]
    assert main(command) == 4
    assert "has not converged" in capsys.readouterr().err
    document = reported()
    assert document["semianalytic"]["error_estimate"] is None
    assert "the prediction has not converged" in {row["obstacle"] for row in document["rows"]}


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("columns", ["80", "100"])
def test_a_table_shows_all_columns_in_a_narrow_terminal(columns, simulated, monkeypatch, shown):
    monkeypatch.setenv("COLUMNS", columns)
    lines = [line.rstrip() for line in shown(f"compare --from {simulated} --all").out.splitlines()]
    assert max(map(len, lines)) <= int(columns)
    assert "…" not in "".join(lines)
    (heads,) = (" ".join(line.split()) for line in lines if line.startswith(" quantity"))
    assert heads == "quantity exact at nodes FEM differ by bar ± verdict"
    table = lines[lines.index(next(line for line in lines if line.startswith(" quantity"))) :]
    verdicts = [word for line in table[: table.index("")] for word in line.split()]
    assert [verdict for verdict in verdicts if verdict in ("agrees", "differs", "unresolved")] == [
        row["verdict"] for row in reported(simulated)["rows"]
    ]


@pytest.mark.thinned(2)
@pytest.mark.parametrize("quiet", ["", "--quiet"])
def test_long_simulations_say_what_they_will_cost(quiet, monkeypatch, shown):
    """Short ones do not, nor what their snapshots will take."""
    line = f"simulate preloaded --resolution 16 --frames 1 --output out {quiet}"
    said = shown(line).err
    assert "will take" not in said
    monkeypatch.setattr("slipfront.cli.simulate_command.WORTH_SAYING", 0.0)
    monkeypatch.setattr("slipfront.cli.simulate_command.WORTH_KEEPING", 0.0)
    said = shown(line).err
    cost = r"preloaded: [\d,]+ unknowns and 36 steps will take about 1 minute and 0\.\d GB\."
    assert bool(re.match(cost, said)) == (not quiet)
    said = " ".join(said.split())
    for words in ("field snapshots will take about", "--no-snapshots leaves them out"):
        assert (words in said) == (not quiet)
