"""Zone edges: three readings, what is too narrow for a mesh, what is there and not predicted."""

import math
from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved
from compare_cases import sampled_run, simulated

from compare.comparison.judgement import side_by_side
from compare.comparison.quantities.edge_rows import narrow_obstacle, zone_rows
from semianalytic import Material, Scene, Tractions
from semianalytic.results.answer import SlipInterval
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.overriding import override_scene

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
        run,
        interface=changed,
        companion=run.companion and on_all_meshes(run.companion, change),
    )


def test_edges_off_by_five_percent_differ_by_five_percent(solution):
    rows = edge_rows(solution, sampled_run(solution, stretch=1.05))
    assert list(rows) == EDGES
    for row in rows.values():
        # Half an element, 0.01: the edge moves past the samples it is read from.
        assert row.difference == pytest.approx(0.05 * row.exact, abs=5e-3)
        assert row.verdict == "differs"


@pytest.mark.slow
def test_edges_off_by_what_coarser_meshes_are_off_agree(solution):
    """By 2 % at h, 5 % at 2h, 12 % at 4h: a little better than first order."""
    run = sampled_run(solution, resolution=200, stretch=1.02, growth=2.5)
    for row in edge_rows(solution, run).values():
        assert row.difference == pytest.approx(0.02 * row.exact, abs=5e-3)
        assert row.bar > 0.02 * row.exact
        assert row.verdict == "agrees"


@pytest.mark.slow
def test_edges_are_read_off_the_nodes_of_the_prediction_too(solution):
    """On a coarse mesh not even the exact answer has its edge where it is."""
    coarse, fine = (edge_rows(solution, sampled_run(solution, n)) for n in (50, 400))
    for name in EDGES:
        assert coarse[name].exact == fine[name].exact
        assert coarse[name].at_nodes == coarse[name].simulated
        # Slip counts from a hundredth of its largest rate on, which is reached within the zone.
        assert fine[name].at_nodes == pytest.approx(fine[name].exact, abs=2e-3)
    inner = coarse["zone 2, inner edge"]
    assert inner.at_nodes != pytest.approx(inner.exact, abs=2e-3)


def test_a_zone_that_no_mesh_shows_differs(solution):
    run = on_all_meshes(sampled_run(solution), lambda v, rate: np.where(v > 0.95, 0.0, rate))
    rows = edge_rows(solution, run)
    assert rows["zone 1, outer edge"].verdict == "agrees"
    for name in EDGES[1:]:
        assert rows[name].simulated is None
        assert rows[name].verdict == "differs"


def test_slip_the_other_way_is_no_zone(solution):
    rows = edge_rows(solution, on_all_meshes(sampled_run(solution), lambda _, rate: -rate))
    assert [rows[name].verdict for name in EDGES] == 3 * ["differs"]
    unpredicted = [row for name, row in rows.items() if name.startswith("unpredicted slip")]
    assert [row.verdict for row in unpredicted] == 2 * ["differs"]
    # From the edge to 0.884 c_t, and from 0.977 to 1.061 c_t.
    assert [row.simulated for row in unpredicted] == pytest.approx([0.884, 0.084], abs=0.01)


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
