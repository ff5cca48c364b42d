"""Rows of what opens: agreement with finite elements, mistakes that are caught, what is no slip."""

import numpy as np
import pytest
from compare_cases import simulated

from compare.comparison.judgement import judge, side_by_side
from compare.comparison.quantities.edge_rows import opening_rows, zone_rows
from compare.comparison.quantities.profile_rows import gap_rows
from docs.studies.judge.spoils import SPOILS, Window, spoilt
from semianalytic import solve
from semianalytic.scene.named import find_scene

NAMES = ("lift-off", "lift-off-shear", "tap")
SPOILT = ("opening +2 %", "opening -2 %", "gap +3 %", "gap -3 %", "no opening")
RESOLUTION = 100


def case_of(name, resolution=RESOLUTION):
    scene = find_scene(name)
    return side_by_side(solve(scene), simulated(scene, resolution))


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", NAMES)
def test_rows_of_openings_agree_most_within_half_their_bars(name):
    case = case_of(name)
    rows = {row.name: row for row in (*opening_rows(case), *gap_rows(case))}
    ends = ("inner", "outer") if name == "tap" else ("outer",)
    edges = [f"opening 1, {end} edge" for end in ends]
    assert list(rows) == [*edges, "length open", "gap, L1", "largest gap"]
    for row in rows.values():
        assert row.verdict == "agrees"
    assert np.median([abs(row.difference) / row.bar for row in rows.values()]) < 0.5


def test_slip_while_open_is_no_slip_zone():
    case = case_of("lift-off-shear")
    assert case.seen.slip_rate[-1, 0] > 0.1 * case.rate  # open, and moving
    names = [row.name for row in zone_rows(case)]
    assert names == ["zone 1, outer edge", "zone 2, inner edge", "zone 2, outer edge"]


@pytest.mark.thinned(3)
@pytest.mark.parametrize("mistake", SPOILT)
def test_mistakes_about_openings_are_caught(mistake):
    scene = find_scene("lift-off")
    run = simulated(scene, RESOLUTION)
    window = Window(run.end_time, run.time_step, float(run.interface.x[-1]))
    (spoil,) = (one for one in SPOILS if one.name == mistake)
    judgement = judge(spoilt(spoil, solve(scene), window), run)
    assert judgement.verdict == "differs"
    kinds = {row.kind for row in judgement.having("differs")}
    assert kinds <= {"gap", "opening edge", "pressure", "sense"}
    assert "gap" in kinds


def test_an_opening_that_is_not_predicted_differs():
    scene = find_scene("preloaded")
    case = side_by_side(solve(scene), simulated(find_scene("lift-off-shear"), RESOLUTION))
    rows = {row.name: row for row in opening_rows(case)}
    (name,) = (name for name in rows if name.startswith("unpredicted opening at 0.000"))
    assert rows[name].simulated == pytest.approx(0.1875, abs=0.005)
    assert rows[name].verdict == "differs"
    assert rows["length open"].verdict == "differs"


def test_what_stays_closed_has_no_rows_of_openings():
    case = case_of("preloaded")
    assert list(opening_rows(case)) == list(gap_rows(case)) == []
