"""Ratios of the time of jobs in two checkouts: both are run, in turn, and a slower one is told."""

import math

import pytest

from docs.studies import goals, ratios
from docs.studies.pages import read_data

SOLVE = "`solve` of `preloaded` to 1e-9"


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
