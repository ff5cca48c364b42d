"""Ruptures that weaken with slip: speed of their fronts, where they overtake shear waves, maps."""

import math

import pytest

from docs.studies.pages import read_data
from docs.studies.supershear import (
    SUB_RAYLEIGH,
    SUPERSHEAR,
    front_speeds,
    onsets,
    rupture_rows,
    transition,
)

MARCHED = {0.8: (8.44, 8.47), 0.9: (11.88, 11.88), 1.0: (16.50, 16.09)}
"""Transitions [L_c] of an independent march, 16 and 32 nodes per L_c
(../shared/theory-engine-checks.md, section 5)."""


def found_transition(strength, nodes, farthest):
    return transition(*front_speeds(*onsets(strength, nodes, farthest)))


def test_a_weak_fault_is_overtaken_soon():
    """3.25 to 3.38 L_c in the march of the notes, with 8 to 32 nodes per L_c."""
    assert found_transition(0.5, 8, 5.0) == pytest.approx(3.3, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("strength", MARCHED)
def test_transitions_are_those_of_an_independent_march(strength):
    """The rules at the front of slip differ, so that the grids' errors do: 5 % with 16 nodes."""
    found = found_transition(strength, 16, 1.2 * MARCHED[strength][0])
    assert found == pytest.approx(MARCHED[strength][1], rel=0.05)


@pytest.mark.slow
def test_stronger_faults_carry_ruptures_farther_before_they_overtake_shear_waves():
    changes = [found_transition(strength, 8, 14.0) for strength in (0.5, 0.7, 0.9)]
    assert changes == sorted(changes)
    assert math.isnan(found_transition(1.4, 8, 14.0))


@pytest.mark.slow
def test_fronts_are_slower_than_rayleigh_waves_before_and_faster_than_shear_waves_after():
    for row in rupture_rows(0.7, 8, 12.0, 12):
        distance, change = row["distance"], row["transition"]
        assert 4 < change < 8
        assert row["style"] == (SUPERSHEAR if distance >= change else SUB_RAYLEIGH)
        if distance > change + 1:
            assert 1.02 < row["speed"] < 1.8
        elif 3 < distance < change - 1:
            assert 0.5 < row["speed"] < 0.95


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
