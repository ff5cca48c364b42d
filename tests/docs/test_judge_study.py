"""How far the judge can be trusted: what is made wrong, and what the trial comes to."""

import csv
from pathlib import Path

import numpy as np
import pytest
from catalogue import solved
from compare_cases import simulated

import slipfront as sf
from docs.studies.runner import main
from docs.studies.trials import judge as trial
from docs.studies.trials.wrong_answers import RUNS, Distorted
from tests.catalogue import over


@over("exact", without="thin")
def test_a_distorted_answer_without_distortion_is_the_answer(problem):
    right = solved(problem.scene)
    table, x = Distorted(right), problem.scene.material.shear_speed * np.linspace(0.01, 2.0, 50)
    for field in ("slip_rate", "slip", "shear_traction", "pressure", "gap"):
        expected = getattr(right, field)(x, 0.7)
        np.testing.assert_array_equal(getattr(table, field)(x, 0.7), expected)
    assert table.zones_at(0.7) == right.zones_at(0.7)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_one_run_of_three_is_wrong_by_its_size(number):
    """Scaled by 1 %, and late by 1 % of the end time; the two other runs stay."""
    run = simulated(sf.find("preloaded"), 40)
    for _ in range(number):
        run = run.companion
    scaled, late = (RUNS[True][name](run, 0.01) for name in ("scaled", "late"))
    np.testing.assert_allclose(scaled.interface.slip, 1.01 * run.interface.slip)
    t, slip = run.interface.t, run.interface.slip
    moved = np.array([np.interp(t - 0.01, t, row) for row in slip.T]).T
    inner = slice(len(t) // 2, -1)
    assert np.abs(late.interface.slip - moved)[inner].max() < 2e-3 * np.abs(slip).max()


@pytest.mark.parametrize(("count", "trials", "limit"), [(0, 59, 0.0495), (1, 93, 0.05), (5, 5, 1)])
def test_the_limit_of_a_rate_is_that_of_tables(count, trials, limit):
    """No alarm in 59 scenes, or one in 93, says that there are less than 5 %."""
    assert trial.upper_limit(count, trials) == pytest.approx(limit, rel=0.02)


@pytest.mark.slow
def test_the_judge_is_right_at_a_glance(tmp_path, monkeypatch):
    """No false alarm in a short trial, which is continued from its file; mistakes are caught."""
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        assert main("docs.studies.trials.judge", trial.STUDIES, ["--quick", "--count", "6"]) == 0
    alarms, found = (
        list(csv.DictReader(path.read_text().splitlines()[1:]))
        for path in (Path("results/data/judge-right.csv"), Path("results/data/judge-wrong.csv"))
    )
    assert alarms[-1]["kind"] == "all"
    assert int(alarms[-1]["cases"]) >= 6
    assert int(alarms[-1]["differs"]) == 0
    sure = [row for row in found if float(row["bars_from"]) > 2 and row["wrong"] != "4h"]
    assert sum(int(row["tried"]) for row in sure) > 12
    assert all(float(row["caught"]) == 1 for row in sure if row["wrong"] in ("h", "prediction"))
    assert len(list(Path(trial.FOLDER).glob("*.pkl"))) >= 6
