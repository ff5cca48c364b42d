"""Ruptures that weaken with slip: speed of their fronts, where they overtake shear waves, maps."""

import math

import numpy as np
import pytest

from compare.studies.supershear.points import (
    SUB_RAYLEIGH,
    SUPERSHEAR,
    front_speeds,
    rupture_points,
    transition,
    transition_point,
)
from compare.studies.supershear.study import write_ruptures
from compare.studies.supershear.tables import transition_rows
from docs.studies.pages import read_data

MARCHED = {0.8: (8.44, 8.47), 0.9: (11.88, 11.88), 1.0: (16.50, 16.09)}
"""Transitions [L_c] of an independent march, 16 and 32 nodes per L_c
(../shared/theory-engine-checks.md, section 5)."""


def test_the_speed_of_a_front_is_read_from_the_first_onset_at_or_beyond():
    """A front at 0.5 that is overtaken, from x = 4 on, by slip which begins ahead at 2."""
    x = np.arange(0, 10.01, 0.125)
    begun = np.minimum(x / 0.5, np.where(x >= 5, 8 + (x - 5) / 2, math.inf))
    places, speeds = front_speeds(x, begun)
    assert speeds[places < 3.5] == pytest.approx(0.5)
    assert np.isinf(speeds[(places > 4.5) & (places < 4.51)]).all()
    assert speeds[places > 5.5] == pytest.approx(2.0)
    assert transition(places, speeds) == pytest.approx(4 - 0.5 + 0.5, abs=0.5)
    assert math.isnan(transition(*front_speeds(x, x / 0.9)))


def test_a_weak_fault_is_overtaken_soon():
    """3.25 to 3.38 L_c in the march of the notes, with 8 to 32 nodes per L_c."""
    assert transition_point(0.5, 8, 5.0).transition == pytest.approx(3.3, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("strength", MARCHED)
def test_transitions_are_those_of_an_independent_march(strength):
    """The rules at the front of slip differ, so that the grids' errors do: 5 % with 16 nodes."""
    found = transition_point(strength, 16, 1.2 * MARCHED[strength][0]).transition
    assert found == pytest.approx(MARCHED[strength][1], rel=0.05)


@pytest.mark.slow
def test_stronger_faults_carry_ruptures_farther_before_they_overtake_shear_waves():
    changes = [transition_point(strength, 8, 14.0).transition for strength in (0.5, 0.7, 0.9)]
    assert changes == sorted(changes)
    assert math.isnan(transition_point(1.4, 8, 14.0).transition)


@pytest.mark.slow
def test_fronts_are_slower_than_rayleigh_waves_before_and_faster_than_shear_waves_after():
    points, change = rupture_points(0.7, 8, 12.0, 12)
    assert 4 < change.transition < 8
    for point in points:
        assert point.style == (SUPERSHEAR if point.distance >= change.transition else SUB_RAYLEIGH)
        if point.distance > change.transition + 1:
            assert 1.02 < point.speed < 1.8
        elif 3 < point.distance < change.transition - 1:
            assert 0.5 < point.speed < 0.95


@pytest.mark.slow
def test_a_quick_map_is_written(tmp_path):
    results = write_ruptures(tmp_path, 4, quick=True)
    names = ["supershear-transitions.csv", "supershear.csv", "supershear.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    assert len(results.points) == 16


def test_transitions_of_docs_change_by_less_than_three_per_cent_between_grids():
    _, rows = read_data("supershear-transitions")
    assert [float(row["strength"]) for row in rows] == [0.8, 0.9, 1.0, 1.1, 1.2, 1.3]
    for row in rows:
        off = abs(float(row["coarse"]) / float(row["fine"]) - 1)
        assert float(row["difference"]) == pytest.approx(off)
        assert off < 0.03
        if float(row["strength"]) in MARCHED:
            assert float(row["coarse"]) == pytest.approx(
                MARCHED[float(row["strength"])][1], rel=0.03
            )


@pytest.mark.slow
def test_the_table_of_docs_is_what_its_command_makes(monkeypatch):
    monkeypatch.setattr("compare.studies.supershear.tables.DISTANCES", {0.8: 12.0})
    monkeypatch.setattr("compare.studies.supershear.tables._FINE", 32)
    (row,) = transition_rows()
    kept = read_data("supershear-transitions")[1][0]
    assert row.coarse == pytest.approx(float(kept["coarse"]), abs=1 / 32)
