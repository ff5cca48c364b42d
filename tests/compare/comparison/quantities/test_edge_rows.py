"""Edges of zones and of openings: three readings, what is too narrow, what is missing."""

import math
from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved
from compare_cases import sampled_run, simulated

from compare.comparison.bars import SAFETY
from compare.comparison.judgement import judge, side_by_side
from compare.comparison.prediction import planned
from compare.comparison.quantities.edge_rows import (
    OPEN_FROM,
    narrow_obstacle,
    opening_rows,
    read_off_bar,
    zone_rows,
)
from compare.comparison.quantities.history_rows import sense_rows
from compare.comparison.quantities.profile_rows import gap_rows
from docs.studies.trials.wrong_answers import spoilt
from fem import simulate, with_companions
from semianalytic import Material, Scene, Tractions
from semianalytic.parameters.overriding import override_scene
from semianalytic.regimes import opening_threshold
from semianalytic.results.answer import SlipInterval
from semianalytic.scene.given.finding import find_scene

PRELOADED = find_scene("preloaded")
EDGES = ["zone 1, outer edge", "zone 2, inner edge", "zone 2, outer edge"]


def edge_rows(prediction, run):
    return {row.name: row for row in zone_rows(side_by_side(prediction, run))}


def on_all_meshes(run, change):
    """A run and its companions with another slip rate, change(x/t, slip rate)."""
    seen = run.interface
    velocity = seen.x / np.maximum(seen.t, 1e-300)[:, None]
    changed = replace(seen, slip_rate=change(velocity, seen.slip_rate))
    return replace(
        run, interface=changed, companion=run.companion and on_all_meshes(run.companion, change)
    )


@pytest.mark.parametrize(
    ("resolution", "stretch", "growth", "verdict"),
    [
        (100, 1.05, 1.0, "differs"),
        # 2 % at h, 5 % at 2h, 12 % at 4h: a little better than first order
        pytest.param(200, 1.02, 2.5, "agrees", marks=pytest.mark.slow),
    ],
)
def test_edges_off_differ_unless_coarser_meshes_are_off_too(
    solution, resolution, stretch, growth, verdict
):
    rows = edge_rows(solution, sampled_run(solution, resolution, stretch=stretch, growth=growth))
    assert list(rows) == EDGES
    for row in rows.values():
        # Half an element at h = 0.01: the edge moves past the samples it is read from.
        assert row.difference == pytest.approx((stretch - 1) * row.exact, abs=5e-3)
        assert row.verdict == verdict
        assert verdict == "differs" or row.bar > 0.02 * row.exact


def test_a_zone_that_no_mesh_shows_differs(solution):
    run = on_all_meshes(sampled_run(solution), lambda v, rate: np.where(v > 0.95, 0.0, rate))
    rows = edge_rows(solution, run)
    assert rows["zone 1, outer edge"].verdict == "agrees"
    for name in EDGES[1:]:
        assert rows[name].simulated is None
        assert rows[name].verdict == "differs"


def test_slip_the_other_way_is_no_zone_and_a_difference_of_the_maps(solution):
    run = on_all_meshes(sampled_run(solution), lambda _, rate: -rate)
    rows = edge_rows(solution, run)
    assert [rows[name].verdict for name in EDGES] == 3 * ["differs"]
    unpredicted = [row for name, row in rows.items() if name.startswith("unpredicted slip")]
    assert [row.verdict for row in unpredicted] == 2 * ["differs"]
    # From the edge to 0.884 c_t, and from 0.977 to 1.061 c_t.
    assert [row.simulated for row in unpredicted] == pytest.approx([0.884, 0.084], abs=0.01)
    forward, reverse, other = sense_rows(side_by_side(solution, run))
    assert (forward.simulated, reverse.at_nodes, other.at_nodes) == (0.0, 0.0, 0.0)
    assert forward.at_nodes == reverse.simulated == other.difference
    assert {row.verdict for row in (forward, reverse, other)} == {"differs"}


def unpredicted(solution, run):
    (row,) = (row for name, row in edge_rows(solution, run).items() if name not in EDGES)
    return row


def slipping_strip(start, end):
    return lambda velocity, rate: np.where((velocity > start) & (velocity < end), 0.5, rate)


@pytest.mark.slow
def test_slip_in_a_strip_is_unpredicted_if_the_coarser_mesh_shows_it_too(solution):
    both = on_all_meshes(sampled_run(solution), slipping_strip(1.3, 1.4))
    row = unpredicted(solution, both)
    assert row.name.startswith("unpredicted slip at 1.3")
    # An even strip of 0.1 has no square-root edges: up to an element is missing at either end.
    assert row.simulated == pytest.approx(0.09, abs=0.015)
    assert row.verdict == "differs"
    row = unpredicted(solution, replace(both, companion=sampled_run(solution).companion))
    assert (row.verdict, row.obstacle) == ("unresolved", "the coarser mesh does not show it")


def test_a_strip_narrower_than_four_elements_is_not_held_against_the_prediction(solution):
    run = on_all_meshes(sampled_run(solution), slipping_strip(1.3, 1.33))
    row = unpredicted(solution, run)
    assert (row.verdict, row.obstacle) == ("unresolved", "it is narrower than 4 elements")


@pytest.mark.slow
@pytest.mark.parametrize("resolution", [40, 100])
def test_a_narrow_zone_says_how_narrow_and_which_mesh_would_do(resolution):
    """The second zone at ν = 0.29 is 0.0144 c_t T wide."""
    exact = solved(override_scene(PRELOADED, poisson_ratio=0.29))
    rows = edge_rows(exact, sampled_run(exact, resolution))
    inner, outer = exact.zones[1].inner, exact.zones[1].outer
    elements = (outer - inner) * resolution
    for name in EDGES[1:]:
        row = rows[name]
        assert row.verdict == "unresolved"
        assert row.obstacle == f"the zone is 0.014 c_t T wide, {elements:.2g} elements"
        assert row.resolution == math.ceil(8 / (outer - inner)) == 555
    enough = edge_rows(exact, sampled_run(exact, 556))
    assert not any("wide" in enough[name].obstacle for name in EDGES)


ZONE, NEXT, BACK = (
    SlipInterval(0.0, 1.0, 1),
    SlipInterval(1.1, 2.0, 1),
    SlipInterval(1.0, 1.2, -1),
)


@pytest.mark.parametrize(
    ("zones", "number", "end", "least", "reason", "width"),
    [
        ((ZONE,), 0, "end", 0.9, None, None),
        ((ZONE,), 0, "end", 1.1, "the zone is", 1.0),
        ((ZONE, NEXT), 0, "end", 0.05, None, None),
        ((ZONE, NEXT), 0, "end", 0.2, "the gap to the next zone is", 0.1),
        ((ZONE, NEXT), 1, "start", 0.2, "the gap to the next zone is", 0.1),
        ((ZONE, NEXT), 1, "end", 0.2, None, None),
        ((ZONE, BACK), 0, "end", 0.15, None, None),  # slip the other way is seen without a gap
        ((ZONE, BACK), 0, "end", 0.3, "the zone next to it is", 0.2),
        ((ZONE, BACK), 1, "start", 0.3, "the zone is", 0.2),
    ],
)
def test_why_nodes_cannot_show_an_edge(zones, number, end, least, reason, width):
    obstacle = narrow_obstacle(zones, number, end, least)
    if reason is None:
        assert obstacle is None
    else:
        assert obstacle.reason.startswith(reason)
        assert obstacle.width == pytest.approx(width)


@pytest.mark.parametrize(("share", "verdict"), [(0.005, "unresolved"), (0.0, "differs")])
def test_a_zone_that_is_too_slow_to_be_read_is_not_missing(solution, share, verdict):
    run = sampled_run(solution, resolution=200)
    most = np.abs(run.interface.slip_rate).max()
    feeble = on_all_meshes(run, lambda u, rate: np.where(u > 0.93, share * most * (rate > 0), rate))
    rows = edge_rows(solution, feeble)
    assert [rows[name].verdict for name in EDGES[1:]] == [verdict, verdict]
    assert ("the simulation slips there" in rows[EDGES[1]].obstacle) == (share > 0)


@pytest.mark.slow
def test_zones_that_touch_read_one_edge_with_one_bar():
    """Slip without friction turns at 0.857 c_t: read from one side, that edge was 1.6 bars off."""
    material = Material(1.0, 1.0, -0.3137300729)
    scene = Scene(material, 0.0, Tractions(1.0, 0.0), Tractions(-0.13262620, 1.04301265))
    rows = {row.name: row for row in zone_rows(side_by_side(solved(scene), simulated(scene, 100)))}
    outer, inner = rows["zone 2, outer edge"], rows["zone 3, inner edge"]
    assert outer.exact == pytest.approx(inner.exact, rel=1e-6)
    assert outer.bar == inner.bar > 1.5 * abs(outer.difference)
    assert outer.verdict == "agrees"


# --- what opens -----------------------------------------------------------------------------------

NAMES = ("lift-off", "lift-off-shear", "tap")
SPOILT = ("gap +3 %", "no opening")
RESOLUTION = 100


def case_of(name, resolution=RESOLUTION):
    scene = find_scene(name)
    return side_by_side(solved(scene), simulated(scene, resolution))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_rows_of_openings_agree_most_within_half_their_bars(name):
    case = case_of(name)
    rows = {row.name: row for row in (*opening_rows(case), *gap_rows(case))}
    ends = ("inner", "outer") if name == "tap" else ("outer",)
    edges = [f"opening 1, {end} edge" for end in ends]
    assert list(rows) == [*edges, "gap, L1"]
    for row in rows.values():
        assert row.verdict == "agrees"
    assert np.median([abs(row.difference) / row.bar for row in rows.values()]) < 0.5


@pytest.mark.slow
def test_an_opening_that_coarser_meshes_hardly_show_is_unresolved():
    """Its gap is about half of the exact one then, and changes little from mesh to mesh: two
    openings of eight elements were said to differ in the trial of docs/judge.md."""
    for resolution, reason in ((40, "no coarser mesh shows it"), (RESOLUTION, "")):
        rows = tuple(gap_rows(case_of("lift-off", resolution)))  # the zone is 0.185 c_t T long
        assert [row.name for row in rows] == ["gap, L1"]
        assert all(row.obstacle.startswith(reason) for row in rows)
        assert {row.verdict for row in rows} == {"unresolved" if reason else "agrees"}


@pytest.mark.thinned(3)
@pytest.mark.parametrize("mistake", SPOILT)
def test_mistakes_about_openings_are_caught(mistake):
    scene = find_scene("lift-off")
    run = simulated(scene, RESOLUTION)
    judgement = judge(spoilt(mistake, solved(scene), run.time_step), run)
    assert judgement.verdict == "differs"
    kinds = {row.kind for row in judgement.having("differs")}
    assert kinds <= {"gap", "opening edge", "pressure", "sense"}
    assert "gap" in kinds


def test_an_opening_that_is_not_predicted_differs(solution):
    case = side_by_side(solution, simulated(find_scene("lift-off"), RESOLUTION))
    rows = {row.name: row for row in opening_rows(case)}
    (name,) = (name for name in rows if name.startswith("unpredicted opening at 0.000"))
    assert rows[name].simulated == pytest.approx(0.1875, abs=0.005)
    assert rows[name].verdict == "differs"


def test_what_stays_closed_has_no_rows_of_openings():
    case = case_of("preloaded", 24)
    assert list(opening_rows(case)) == list(gap_rows(case)) == []


def with_gap_changes(run, change):
    """A run whose companions gape more everywhere than the next finer mesh, by `change` at the end
    and in proportion to time; the changes double with the element size."""

    def raised(first, more, change):
        if first is None:
            return None
        seen = first.interface
        gap = seen.gap + more * seen.t[:, None] / seen.t[-1]
        below = raised(first.companion, more + change, 2 * change)
        return replace(first, interface=replace(seen, gap=gap), companion=below)

    return raised(run, 0.0, change)


def test_the_end_of_an_opening_is_as_uncertain_as_its_gap():
    """Changes of first order, of growing shares of the largest gap: the end moves by some of the
    room that the answer itself needs to gape by the error bar; nowhere does it gape by 1.2."""
    solution = solved(find_scene("tap"))
    (opening,), (part,) = solution.openings, solution.openings_at(1.0)
    inside = np.linspace(opening.inner, opening.outer, 4001)
    gap = solution.gap(inside, 1.0)
    most, peak = float(gap.max()), int(gap.argmax())
    plain, shares = sampled_run(solution, times=9), (0.0, 1e-2, 0.1, 0.3)
    cases = [
        side_by_side(solution, with_gap_changes(plain, share * most)) for share in (*shares, 1.2)
    ]
    for end, rising in (("start", slice(peak)), ("end", slice(None, peak, -1))):
        found = [read_off_bar(case, part, end) for case in cases]
        # what first order leaves of the last change, times the safety factor
        levels = np.array([OPEN_FROM, *(SAFETY * share for share in shares[1:])]) * most
        room = np.abs(np.interp(levels, gap[rising], inside[rising]) - getattr(part, end))
        assert found[0] == 0
        assert found == sorted(found)
        assert np.all(found[1:-1] < room[1:] + plain.element_size)
        assert np.all(found[2:-1] > 0.25 * room[2:])
        assert found[-1] == np.inf
    assert {row.verdict for row in opening_rows(cases[-1])} == {"unresolved"}


def test_the_edge_of_slow_slip_is_as_uncertain_as_its_slip_rate():
    """The slip rate falls slowly to the outer edge of the second zone: what meshes change of it
    moves the edge by more than an element, though meshes happen to agree on the edge."""
    scene = find_scene("auxetic")
    prediction, _ = planned(scene, snapshots=False)
    run = with_companions(simulate(scene, resolution=100))
    case = side_by_side(prediction, run)
    parts = prediction.zones_at(1.0)
    slow, sharp = (read_off_bar(case, parts[number], "end") for number in (1, 0))
    assert slow > run.element_size > 10 * sharp
    row = edge_rows(prediction, run)["zone 2, outer edge"]
    assert (row.verdict, row.bar > slow) == ("agrees", True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("poisson_ratio", "friction", "below"), [(0.29, 0.7, 0.01), (0.29, 0.7, 0.05), (0.0, 0.5, 0.01)]
)
def test_openings_that_hardly_gape_do_not_differ(poisson_ratio, friction, below):
    """A pressure on a base a little below that from which on the contact stays shut, on the mesh
    that the command takes: the outer edge of the first was 1.7 bars off."""
    base = Tractions((1 - below) * opening_threshold(poisson_ratio), 0.0)
    scene = Scene(Material(1.0, 1.0, poisson_ratio), friction, base, Tractions(1.0, 0.5))
    prediction, choice = planned(scene, snapshots=True)
    run = with_companions(simulate(scene, resolution=choice.resolution))
    judgement = judge(prediction, run)
    assert "opening edge" in {row.kind for row in judgement.rows}
    assert judgement.verdict != "differs"
