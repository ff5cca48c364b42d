"""How far the judge can be trusted: what is made wrong, and what the trial comes to."""

import numpy as np
import pytest
from catalogue import solved

from compare.comparison.rows import DIFFERS
from docs.studies.trials import judge as trial
from docs.studies.trials.draws import KINDS
from docs.studies.trials.wrong_answers import profiled
from tests.catalogue import over

X = np.linspace(0.01, 2.0, 200)


def effect(field, wrong, right, x, t):
    """Relative L1 difference of a field over positions and times."""
    expected, given = (np.asarray(getattr(one, field)(x, t[:, None])) for one in (right, wrong))
    size = float(np.abs(expected).sum())
    return float(np.abs(given - expected).sum()) / size if size else 0.0


@pytest.mark.thinned(12)
@over("exact", without="thin")
def test_a_profile_is_told_from_its_solution_by_digits_only(problem):
    right = solved(problem.scene)
    table, speed = profiled(right), problem.scene.material.shear_speed
    for field in ("slip_rate", "slip", "shear_traction", "pressure"):
        assert effect(field, table, right, speed * X, np.array([0.7, 1.0])) < 1e-4
    for total in ("max_slip", "accumulated_slip", "frictional_work"):
        expected = getattr(right, total)(0.7)
        np.testing.assert_allclose(getattr(table, total)(0.7), expected, rtol=2e-3)
    assert table.zones_at(0.7) == right.zones_at(0.7)


@pytest.mark.parametrize(("count", "trials", "limit"), [(0, 59, 0.0495), (1, 93, 0.05), (5, 5, 1)])
def test_the_limit_of_a_rate_is_that_of_tables(count, trials, limit):
    """No alarm in 59 scenes, or one in 93, says that there are less than 5 %."""
    assert trial.upper_limit(count, trials) == pytest.approx(limit, rel=0.02)


@pytest.mark.slow
def test_the_judge_is_right_at_a_glance():
    """No false alarm in a few scenes of every kind; mistakes that show are caught."""
    rows = [row for point in trial.right_points(True) for row in trial.right_rows(*point)]
    alarms = trial.alarms(rows)
    assert {row["group"] for row in alarms} == {*KINDS, "all"}
    assert alarms[-1]["false_scenes"] == 0
    assert alarms[-1]["within"] > 0.97
    tried = trial.wrong_rows("preloaded", 60)
    assert tried[0]["verdict"] != DIFFERS
    caught = [row["verdict"] in (DIFFERS, "refused") for row in tried if row["bars"] > trial.SURE]
    assert len(caught) > 12
    assert np.mean(caught) >= 0.9
