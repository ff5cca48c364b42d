"""Studies as rows, on the terminal and in data files; small studies, of constants and of speed."""

import math
from collections import Counter
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from compare.studies.tables import run_studies
from docs.studies import constants, goals, ratios
from docs.studies.accuracy import scenes
from docs.studies.constants import constant_rows, random_scenes, solved
from docs.studies.pages import read_data
from semianalytic.selfsimilar.zones import tuning

SOLVE = "`solve` of `preloaded` to 1e-9"


@dataclass(frozen=True)
class Row:
    scene: str
    unknowns: int
    error: float


ROWS = [Row("one", 82940, 1.23456789e-7), Row("two", 1, float("nan"))]


def test_rows_are_printed_and_written_with_their_command(tmp_path, capsys):
    command = ["errors", "--csv", str(tmp_path)]
    assert run_studies("compare.some", "fem", {"errors": lambda: ROWS}, command) == 0
    shown = capsys.readouterr().out
    assert "82,940" in shown
    assert "1.235e-07" in shown
    assert "nan" not in shown
    assert read_data("fem-errors", tmp_path) == (
        "python -m compare.some errors --csv docs/data",
        [
            {"scene": "one", "unknowns": "82940", "error": "1.23456789e-07"},
            {"scene": "two", "unknowns": "1", "error": "nan"},
        ],
    )


def test_unknown_study_is_refused(capsys):
    with pytest.raises(SystemExit, match="2"):
        run_studies(
            "compare.some", "fem", {"errors": lambda: ROWS, "cost": lambda: ROWS}, ["speed"]
        )
    assert "errors, cost" in capsys.readouterr().err.replace("'", "")


@pytest.mark.slow
def test_scenes_have_a_summary_and_every_quantity(monkeypatch):
    few = ("preloaded", "stuck", "unload")
    monkeypatch.setattr(scenes, "COMPARED", few)
    chosen = {name: scenes.QUANTITIES[name] for name in few if name != "stuck"}
    monkeypatch.setattr(scenes, "QUANTITIES", chosen)
    rows = {row.scene: row for row in scenes.summary(32)}
    assert tuple(rows) == few
    assert rows["unload"].profile == rows["unload"].slip_rate > 0
    assert rows["preloaded"].profile != rows["preloaded"].slip_rate
    assert np.isnan(rows["stuck"].sense)
    assert 0 < rows["stuck"].pressure < 0.1
    assert rows["unload"].solver == "space-time"
    for row in (rows["preloaded"], rows["unload"]):
        assert 0 <= row.sense <= row.sense_bar
        assert 0 < row.profile <= row.profile_bar
    found = scenes.quantities(32)
    assert len(found) == sum(len(named) + 1 for named in chosen.values())
    assert found[0].at_nodes == pytest.approx(found[0].simulated, rel=0.1)
    assert np.isnan(found[0].bar)
    work = next(row for row in found if row.quantity == "frictional work, integral")
    assert abs(work.simulated - work.at_nodes) < work.bar < 0.1 * work.at_nodes
    assert work.verdict == "agrees"
    missed = scenes.unresolved(32)
    counts = Counter({row.scene: row.unresolved for row in rows.values()})
    assert Counter(row.scene for row in missed) == counts
    assert all(row.obstacle for row in missed)


def test_no_named_scene_differs_anywhere():
    """In the tables of docs/scenes.md, which says so."""
    _, rows = read_data("scenes-summary")
    assert [row["scene"] for row in rows] == list(scenes.COMPARED)
    for row in rows:
        assert row["verdict"] == "agrees"
        assert (int(row["agree"]) > 5, int(row["differ"])) == (True, 0)
    _, missed = read_data("scenes-unresolved")
    assert len(missed) == sum(int(row["unresolved"]) for row in rows)


@pytest.mark.slow
def test_every_quantity_of_every_scene_is_in_its_report():
    rows = scenes.quantities(60)
    for scene, quantities in scenes.QUANTITIES.items():
        found = [row.quantity for row in rows if row.scene == scene]
        backward = ("lift-off", "tap", "incident-p", "incident-sv", "incident-pulse")
        slips = ["largest forward V"] if scene not in backward else []
        assert found == slips + [name for name, _ in quantities]


def test_a_constant_that_matters_is_told_from_one_that_does_not():
    compute = partial(solved, random_scenes(1))
    rows = list(constant_rows(tuning, ["FINEST_RULE", "RULE_SHARE"], compute))
    assert [row.value for row in rows] == [5e-17, 2e-16, 5.0, 20.0]
    idle, finer = rows[0], rows[3]
    assert (idle.failed, idle.changed, idle.work) == (0, 0, 1.0)
    assert finer.work > 1.0
    assert finer.changed
    assert all(row.worst < 1 for row in rows)


def test_an_unknown_constant_is_refused(capsys):
    with pytest.raises(SystemExit, match="2"):
        constants.main(["NO_SUCH_NUMBER"])
    assert "NO_SUCH_NUMBER is no number of semianalytic.selfsimilar.zones.tuning" in (
        capsys.readouterr().err
    )


def test_a_job_runs_in_both_checkouts():
    (row,) = ratios.compared([SOLVE], ratios.ROOT, ratios.ROOT, times=0.1)
    assert row.job == SOLVE
    assert row.before > 0
    assert row.ratio == row.now / row.before
    assert row.error_before == row.error_now < 1e-9


def test_a_checkout_that_fails_is_named(tmp_path):
    (tmp_path / "slipfront.py").write_text("")  # a package without a single name
    with pytest.raises(SystemExit, match="`solve` of `preloaded`"):
        ratios.compared([SOLVE], tmp_path, ratios.ROOT, times=0.1)


@pytest.mark.parametrize(("ratio", "code"), [(1.2, 0), (1.3, 1), (0.5, 0)])
def test_exit_code_tells_of_a_slower_job(ratio, code, monkeypatch, tmp_path):
    row = ratios.RatioRow(SOLVE, 1.0, ratio, ratio, math.nan, 1e-10)
    packed = []
    monkeypatch.setattr(ratios, "unpacked", lambda commit, folder: packed.append(commit))
    monkeypatch.setattr(ratios, "compared", lambda *given: [row])
    assert ratios.main(["--against", "some", "--csv", str(tmp_path)]) == code
    assert packed == ["some"]
    assert (tmp_path / "speed-ratios.csv").read_text().startswith("# python -m docs.studies.ratios")


def test_all_jobs_are_in_the_table():
    _, rows = read_data("speed-ratios")
    assert [str(row["job"]) for row in rows] == list(ratios.JOBS)


def test_jobs_that_were_not_run_keep_their_row(monkeypatch, tmp_path):
    monkeypatch.setattr(ratios, "unpacked", lambda commit, folder: None)
    for job, ratio in ((SOLVE, 0.5), ("`march` with 256 nodes", 0.4), (SOLVE, 0.6)):
        row = ratios.RatioRow(job, 1.0, ratio, ratio, math.nan, 1e-10)
        monkeypatch.setattr(ratios, "compared", lambda *given, row=row: [row])
        ratios.main(["--csv", str(tmp_path), "--jobs", job])
    _, rows = read_data("speed-ratios", tmp_path)
    assert [(row["job"], float(row["ratio"])) for row in rows] == [
        (SOLVE, 0.6),
        ("`march` with 256 nodes", 0.4),
    ]


def test_all_goals_are_in_the_table_and_judged():
    _, rows = read_data("speed-goals")
    assert [row["job"] for row in rows] == list(goals.GOALS)
    for row in rows:
        goal, now = goals.GOALS[row["job"]], float(row["now"])
        here = goal.here(goals.pace_of(goals.DATA))
        assert float(row["here"]) == pytest.approx(here)
        assert (row["met"] == "yes") == (now >= here if goal.more else now <= here)


def test_goals_in_seconds_follow_the_pace_of_the_machine():
    jobs = {"`solve` of `viscous` to 1e-10": 2.0, "stress at 200,000 points to 1e-9": 0.5}
    for job, factor in {**jobs, "survey on two processes": 1.0}.items():
        assert goals.GOALS[job].here(2.0) == pytest.approx(factor * goals.GOALS[job].goal)
