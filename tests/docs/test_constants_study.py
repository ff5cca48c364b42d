"""The study of tuning constants: it sees what a value does, and names none that is not there."""

from functools import partial

import pytest

from docs.studies import constants
from docs.studies.constants import constant_rows, random_scenes, solved
from semianalytic.selfsimilar.zones import tuning


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
