"""What a grid makes of ends of contacts, of slots beside them, and of fields that jump."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.engine.stepping.balance import freed_rate
from semianalytic.engine.stepping.line import Grid
from semianalytic.scene.laws.sampling import moving, sampled
from semianalytic.scene.line.contact import Contact
from semianalytic.scene.line.fields import Table, at_nodes
from tests.semianalytic.engine.runs import one_run

STRIP = Contact([(-2.0, 2.0)])
END = 1.5
ROCK = sf.Material(30e9, 2700.0, 0.25)
LAW = sf.RateAndState(a=0.01, b=0.014, f0=0.6, v0=1e-6, distance=1e-4)
PAGE = Path(__file__).parents[3] / "docs" / "engine.md"
NODES = 0.1 * np.arange(-20, 21)


def punch():
    solid = sf.Material(1.0, 1.0, 0.3)
    shape = {"contact": STRIP, "pressure": 1.0, "even": True, "loads": [sf.InterfaceLoad(0.2)]}
    return scene_along(solid, sf.Coulomb(0.4), 20.0, **shape)


def off(first, truth):
    """Relative L1 error of slip on the contact at the end."""
    inside = np.abs(first.interface.x) < 2
    exact = np.interp(first.interface.x[inside], truth.interface.x, truth.interface.slip[-1])
    return np.abs(first.interface.slip[-1][inside] - exact).sum() / np.abs(exact).sum()


@pytest.fixture(scope="module")
def truth():
    return one_run(punch(), END, 2560, times=[END])


def test_a_grid_knows_ends_between_its_nodes():
    assert STRIP.misfit(40.0, 500) == 0
    assert STRIP.misfit(40.0, 512) == pytest.approx(0.4)
    assert STRIP.misfit(40.0, 250) == pytest.approx(0.5)
    assert Contact().misfit(40.0, 513) == Contact.half_line().misfit(40.0, 513) == 0
    # an end beyond the period is none
    assert Contact([(-2.0, 70.0)]).misfit(40.0, 500) == 0


def test_nodes_that_fit_are_the_fewest():
    assert STRIP.fitting_nodes(40.0, 512, 0) == 520
    assert STRIP.fitting_nodes(40.0, 512, 2) == 560
    assert STRIP.fitting_nodes(40.0, 512, 4) == 640
    assert Contact().fitting_nodes(1.0, 512, 4) == 512
    # no common fraction: the fewest are as good as any, unless the grid can be moved
    odd = Contact([(-1.0, 2**0.5)])
    assert odd.fitting_nodes(7.3, 512, 4) == 512
    moved = odd.fitting_nodes(7.3, 512, 4, movable=True)
    assert 512 <= moved <= 768
    assert odd.misfit(7.3, moved, odd.shift(7.3, moved)) < 0.05 < odd.misfit(7.3, 512)


@settings(deadline=None, max_examples=80)
@given(st.floats(-9.9, 9), st.floats(0.3, 15), st.integers(16, 300))
def test_a_moved_grid_has_ends_closer_to_their_places(begin, width, quarter):
    """Half the nodes see displaced ends of a shortened contact one cell inward."""
    length, nodes = 20.0, 4 * quarter
    contact = Contact([(begin, begin + width)])
    shift = contact.shift(length, nodes)
    spacing = length / nodes
    assert abs(shift) <= spacing
    if contact.misfit(length, nodes) == 0:
        assert shift == 0
        return
    # two ends on a circle are never further than a quarter from the middle of their arc
    assert contact.misfit(length, nodes, shift) <= min(0.25, contact.misfit(length, nodes)) + 1e-9
    grids = [Grid(length, n, True, shift=shift) for n in (nodes, nodes // 2)]
    np.testing.assert_allclose((grids[0].x[::2] + grids[0].x[1::2]) / 2, grids[1].x, atol=1e-12)
    shorter = contact.shortened(length, nodes, shift)
    seen, found = (np.flatnonzero(contact_.touches(grids[1].x)) for contact_ in (contact, shorter))
    if len(seen) > 3:
        for end, first, sign in zip(contact.intervals[0], (0, -1), (-1, 1), strict=True):
            place = (end - shift) / spacing
            if abs(end) < length / 2 and abs(place - round(place)) > 1e-3:
                assert seen[first] - found[first] == sign


@pytest.mark.parametrize("nodes", [None, 200])
def test_a_grid_is_moved_with_the_interface(nodes):
    """Ends, loads and fields that all move by a distance have the same slip."""

    def face(by):
        loads = [sf.InterfaceLoad(lambda x: 0.9 * np.exp(-((x - by - 0.3) ** 2)))]
        base = {"pressure": lambda x: 1 + 0.1 * np.cos(np.pi * (x - by) / 10), "loads": loads}
        contact = Contact([(by - 2.1234, by + 3.3)])
        return scene_along(
            sf.Material(1.0, 1.0, 0.3), sf.Coulomb(0.4), 20.0, contact=contact, **base
        )

    first, other = (
        sf.solve(face(by), end_time=END, nodes=nodes, times=[END]) for by in (0.0, 0.0177)
    )
    assert other.shift != first.shift != 0
    assert first.contact_misfit == pytest.approx(other.contact_misfit, abs=1e-9)
    assert first.contact_misfit < (0.05 if nodes is None else 0.3)
    on = first.interface.touching
    steps = round(
        (other.interface.x[other.interface.touching][0] - 0.0177 - first.interface.x[on][0])
        / (20 / first.nodes)
    )
    assert steps == 0
    np.testing.assert_allclose(
        other.interface.slip[-1][other.interface.touching], first.interface.slip[-1][on], atol=1e-9
    )
    for name, error in first.error_estimates.items():
        assert error == pytest.approx(other.error_estimates[name], rel=1e-3), name


def test_by_default_ends_fit(truth):
    done = sf.solve(punch(), end_time=END, times=[END])
    assert done.contact_misfit == 0
    assert done.caution == ""
    assert off(done, truth) < 2e-3
    assert off(done, truth) < done.error_estimates["slip"] < 3e-2


def test_displaced_ends_are_told_and_estimated(truth):
    # the end lies at 25.6 node distances of the first grid, and half the nodes have it at the same
    # wrong place; it fits the second grid, and lies at 51.2 of the third
    for nodes in (256, 260, 512):
        done = sf.solve(punch(), end_time=END, nodes=nodes, times=[END])
        error = off(done, truth)
        if nodes == 260:
            assert done.caution == ""
            assert error < 5e-3
        else:
            assert "node distances from where the grid has it; choose" in done.caution
            assert 1e-2 < error < done.error_estimates["slip"]
    assert "choose 520 nodes" in done.caution
    odd = replace(punch(), period=7.3, even=False, contact=Contact([(-1, 2**0.5)]))
    assert "choose 72 nodes" in one_run(odd, 0.1, 68).caution
    assert "choose a period" in one_run(odd, 0.1, 64).caution


def test_a_contact_of_few_nodes_is_unresolved_and_gets_enough_by_default():
    """Two grids that share no node of the contact have nothing to compare."""
    push = sf.InterfaceLoad(0.5, on="slot")
    material, law = sf.Material(1.0, 1.0, 0.25), sf.Coulomb(0.05)
    face = scene_along(material, law, 16.0, loads=[push], contact=sf.Contact([(-0.11, 0.11)]))
    words = r"unresolved: a contact or slot of width 0\.22 has 2\.2 nodes; use 584 nodes or more"
    assert re.match(words, sf.solve(face, end_time=0.2, nodes=160).status)
    assert sf.solve(face, end_time=0.2, estimate=False).nodes >= 584
    with pytest.raises(sf.SceneError, match="no node lies on the contact; use 584 nodes or more"):
        sf.solve(face, end_time=0.2, nodes=64)
    slot = scene_along(
        material, law, 16.0, loads=[push], contact=sf.Contact([(-6, -0.05), (0.05, 6)])
    )
    assert "has 0.8 nodes" in one_run(slot, 0.2, 128).status


def test_nothing_is_known_beyond_the_period():
    done = sf.solve(
        scene_along(sf.Material(1.0, 1.0, 0.25), sf.Coulomb(0.3), 16.0), end_time=0.1, nodes=16
    )
    assert np.isnan(done.at(done.interface.slip, [-8.1, 0.0, 100.0])).tolist()[-1] == [
        True,
        False,
        True,
    ]


@pytest.mark.parametrize("even", [False, True])
def test_slots_carry_nothing_whatever_the_contact_does(even):
    """V + h * V = load on slots, by the whole matrix of the line."""
    rng = np.random.default_rng(1)
    grid = Grid(16.0, 64, True, even)
    touching = (np.abs(grid.x) > 1) & (np.abs(grid.x) < 6)
    count, waves = len(grid.x), len(grid.wavenumbers)
    rate, load = rng.normal(size=count), rng.normal(size=count)
    past = grid.amplitudes(rng.normal(size=count))
    feedback = 3.0 * np.arange(waves)
    found = freed_rate(grid, touching, rate, load, past, feedback)
    assert np.array_equal(found[touching], rate[touching])
    held = grid.values(past + feedback * grid.amplitudes(found))
    assert (found + held)[~touching] == pytest.approx(load[~touching], abs=1e-7)
    assert np.abs((found + held - load)[touching]).max() > 0.1


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("contact", "plate"), [([(-6.0, -1.0), (1.0, 6.0)], 0.0), ([(-3.0, 7.0)], 1e-6)]
)
def test_long_steps_beside_slots_give_the_answer_of_short_ones(contact, plate):
    push = sf.InterfaceLoad(lambda x: 3e5 * (abs(x) < 3), history=lambda t: min(t / 0.1, 1.0))
    face = scene_along(
        *(ROCK, LAW, 16.0),
        **{"pressure": 5e6, "shear": 3e6, "rate": 1e-6, "plate_rate": plate, "loads": [push]},
        contact=sf.Contact(contact),
    )
    times = [0.02, 0.05]
    found = one_run(face, 0.05, 32, times=times)
    fine = one_run(face, 0.05, 32, times=times, longest=6e-5)
    assert np.diff(fine.totals.t).max() < 6.1e-5  # the shortest steps, which need no solution
    assert found.steps < fine.steps / 5
    on = found.interface.touching
    for name, limit in (("slip", 2e-3), ("shear_traction", 2e-3), ("slip_rate", 5e-3)):
        first, other = getattr(found.interface, name), getattr(fine.interface, name)
        change = other - (3e6 if name == "shear_traction" else 0)
        assert np.abs(first - other)[:, on].sum() < limit * np.abs(change)[:, on].sum()
    slots = (
        np.abs(found.interface.slip - fine.interface.slip)[:, ~on].sum()
        / np.abs(fine.interface.slip)[:, ~on].sum()
    )
    assert slots < 1e-3


def test_the_file_of_the_page_runs(tmp_path, monkeypatch):
    """docs/engine.md, "Files": contacts, a table, an expression and a history."""
    block = re.search(r"## Files\n\n((?:    .*\n)+)", PAGE.read_text(encoding="utf-8")).group(1)
    text = re.sub("nodes = 512", "nodes = 64", re.sub("^    ", "", block, flags=re.MULTILINE))
    (tmp_path / "fault.toml").write_text(text, encoding="utf-8")
    table = "x [m],pressure [MPa]\n-8,4.8\n0,5\n8,4.8\n"
    (tmp_path / "pressure.csv").write_text(table, encoding="utf-8")
    found = sf.find(tmp_path / "fault.toml")
    done = sf.solve(found)
    assert done.status == "done"
    assert done.steps < 2000


def step(at):
    return lambda x: np.where(x < at, 1.0, 3.0)


@pytest.mark.parametrize("at", [0.0, 0.02, -0.037, 0.05, 1.2345])
def test_a_node_beside_a_jump_takes_the_mean(at):
    found = sampled("f", step(at), NODES, 0.1)
    part = np.clip((NODES + 0.05 - at) / 0.1, 0.0, 1.0)  # of its cell beyond the jump
    np.testing.assert_allclose(found, 1 + 2 * part, atol=2 / 100)
    assert np.sum((found != 1) & (found != 3)) <= 1
    # the integral is that of the field, which nodal values miss by up to half a node distance
    assert 0.1 * found.sum() == pytest.approx(1 * (at + 2.05) + 3 * (2.05 - at), abs=2e-3)


@pytest.mark.parametrize(
    "field",
    [
        lambda x: x**2,
        np.abs,
        lambda x: np.exp(-((x / 0.3) ** 2)),
        lambda x: np.tanh(x / 0.2),
        lambda x: 0 * x + 2,
        lambda x: 2.0,
        Table([-2.0, 0.01, 2.0], [0.0, 1.0, -1.0]),
    ],
)
def test_smooth_fields_keep_the_values_at_nodes(field):
    np.testing.assert_array_equal(sampled("f", field, NODES, 0.1), sampled("f", field, NODES))


def test_tables_and_formulas_need_not_reach_beyond_the_nodes():
    table = Table([-2.0, 0.02, 0.02, 2.0], [1.0, 1.0, 3.0, 3.0])
    np.testing.assert_allclose(
        sampled("f", table, NODES, 0.1), sampled("f", step(0.02), NODES, 0.1), atol=1e-12
    )
    inside = NODES[NODES > 0]
    root = sampled("f", lambda x: np.sqrt(x - 0.06), inside, 0.1)
    np.testing.assert_array_equal(root, np.sqrt(inside - 0.06))
    on_slot = at_nodes("f", step(0.0), NODES, NODES > 0.5, 0.1)
    np.testing.assert_array_equal(on_slot, np.where(NODES > 0.5, 3.0, 0.0))


@pytest.mark.parametrize("t", [0.0, 0.13, 0.15, 0.42])
def test_a_jump_that_moves_loads_its_share_of_a_cell(t):
    found = moving(lambda x, t: (np.abs(x) < t) * 2.0, NODES, t, 0.1)
    assert 0.1 * found.sum() == pytest.approx(4 * t, abs=5e-3)
    smooth = moving(lambda x, t: np.cos(x - t), NODES, t, 0.1)
    np.testing.assert_array_equal(smooth, np.cos(NODES - t))


def test_a_law_takes_means_but_of_barriers():
    weak, barrier = (sf.Coulomb(lambda x, to=to: np.where(x < 0.02, 0.3, to)) for to in (0.9, 90.0))
    assert 0.4 < weak.on(NODES, 0.1).friction[20] < 0.8
    assert barrier.on(NODES, 0.1).friction[20] == 0.3
    assert weak.on(NODES).friction[20] == 0.3


def patch(contact, friction=0.4):
    loads = [sf.InterfaceLoad(lambda x: 0.8 * (abs(x - 3) < 1))]
    solid = sf.Material(1.0, 1.0, 0.3)
    return scene_along(
        solid, sf.Coulomb(friction), 20.0, contact=contact, pressure=1.0, loads=loads
    )


@pytest.mark.thinned(2)
@pytest.mark.parametrize("contact", [sf.Contact.half_line(), sf.Contact()], ids=["slot", "line"])
def test_slip_of_a_patch_does_not_depend_on_where_its_ends_meet_the_grid(contact):
    truth = one_run(patch(contact), END, 2048, times=[END])

    def error(interface, nodes):
        done = one_run(interface, END, nodes, times=[END])
        exact = np.interp(done.interface.x, truth.interface.x, truth.interface.slip[-1])[
            done.interface.touching
        ]
        return (
            np.abs(done.interface.slip[-1][done.interface.touching] - exact).sum()
            / np.abs(exact).sum()
        )

    # ends at 20, 20.48 and 20.8 node distances: values at nodes were off by 1 to 5 %
    for nodes in (400, 408, 416):
        assert error(patch(contact), nodes) < 3e-3
    assert error(patch(contact, 0.4 * 0.97), 400) > 1e-2


@pytest.mark.parametrize(
    ("length", "status", "caution"),
    [(20.0, "done", ""), (14.0, "done", "arrived beyond"), (6.0, "unresolved", "raise `period`")],
)
def test_a_half_line_is_one_until_waves_come_back_from_the_end_of_its_period(
    length, status, caution
):
    """The exact answer of the same slot holds until then, and the run says when it does not."""
    scene = sf.find("preloaded")
    loads = [sf.InterfaceLoad(scene.load.shear, on="slot")]
    half = {"contact": Contact.half_line(), "loads": loads, "pressure": 1.0}
    face = scene_along(scene.material, sf.Coulomb(scene.friction), length, **half)
    done = sf.solve(face, end_time=2.0, nodes=int(32 * length))
    assert done.status.startswith(status), done.status
    assert caution in done.caution
    x = done.interface.x[done.interface.touching & (done.interface.x < 1.0)]
    exact = sf.solve(scene).slip(x, 2.0)
    off = np.abs(done.at(done.interface.slip[-1], x) - exact).sum() / exact.sum()
    assert off < 0.01 or status == "unresolved"
