"""A simulation answers what every solver does, and says what else happened."""

from dataclasses import fields, replace

import numpy as np
import pytest
from catalogue import solved, unit_scene

import semianalytic as sf
from fem import Settings, cost, simulate
from fem.resolution import LEAST_CROSSED
from fem.results import load_simulation, opening_sentence
from fem.run import levels
from semianalytic.results.answer import FIELDS, TOTALS
from semianalytic.scene.given.finding import find_scene
from tests.fem.runs import prepare, run

BACK_AND_FORTH = find_scene("harmonic")


def named(name, resolution=50, **options):
    return run(find_scene(name), resolution, **options)


# --- the questions every solver answers -------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "field", "most"),
    [
        # measured: 1.1e-2, 2.9e-3, 8.6e-3, 1e-16 and 4.2e-2, 2.2e-2, 4.5e-3, 3.5e-3
        ("preloaded", "slip_rate", 0.015),
        ("preloaded", "slip", 0.004),
        ("preloaded", "shear_traction", 0.012),
        ("preloaded", "pressure", 1e-12),
        ("remote-shock", "slip_rate", 0.06),
        ("remote-shock", "slip", 0.03),
        ("remote-shock", "shear_traction", 0.006),
        ("remote-shock", "pressure", 0.005),
    ],
)
def test_fields_are_those_of_the_exact_solution(name, field, most):
    x, t = np.linspace(0.05, 1.85, 181), np.array([[0.5], [0.77], [1.0]])
    exact = getattr(solved(name), field)(x, t)
    seen = getattr(named(name), field)(x, t)
    assert seen.shape == (3, 181)
    assert np.abs(seen - exact).sum() < most * np.abs(exact).sum()


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    ("name", "total", "most"),
    [
        ("preloaded", "accumulated_slip", 0.003),
        ("preloaded", "frictional_work", 0.003),
        ("remote-shock", "accumulated_slip", 0.01),
        ("remote-shock", "frictional_work", 0.035),  # what rubs at the edge node, of order sqrt(h)
    ],
)
def test_totals_are_those_of_the_exact_solution(name, total, most):
    t = np.array([0.5, 0.77, 1.0])
    exact = getattr(solved(name), total)(t)
    np.testing.assert_allclose(getattr(named(name, 100), total)(t), exact, rtol=most)


@pytest.mark.parametrize(("name", "most"), [("preloaded", 0.01), ("remote-shock", 0.015)])
def test_largest_slip_is_that_of_the_first_node_beyond_the_edge(name, most):
    sim, exact, t = named(name), solved(name), np.array([0.5, 0.77, 1.0])
    np.testing.assert_allclose(sim.max_slip(t), exact.slip(sim.element_size, t), rtol=most)
    assert (0.85 * exact.max_slip(t) < sim.max_slip(t)).all()  # which is at the edge, one h away
    assert (sim.max_slip(t) < exact.max_slip(t)).all()


def test_zones_are_those_of_the_exact_solution():
    exact = solved("preloaded").zones_at(0.77)
    seen = named("preloaded", 100).zones_at(0.77)
    assert [zone.sense for zone in seen] == [zone.sense for zone in exact]
    for answer, other in zip(seen, exact, strict=True):
        assert answer.start == pytest.approx(other.start, abs=0.02)
        assert answer.end == pytest.approx(other.end, abs=0.02)


def tributary(sim):
    """Lengths that belong to the nodes of the result: h, and h/2 at the far wall."""
    length = np.full(len(sim.interface.x), sim.element_size)
    length[-1] /= 2
    return length


def edge_pair(scene, resolution=40):
    """|slip| of the edge node by each step, and the work per area friction took there."""
    model, path = prepare(scene, resolution=resolution), []
    for _ in levels(model):
        path.append(model.joint.path[0])
        model.drift()
    return np.array(path), model.joint.work_density()[0]


def test_totals_are_sums_of_every_step_stored_or_not():
    whole, thinned = (simulate(BACK_AND_FORTH, resolution=40, every=every) for every in (1, 10**6))
    for field in fields(whole.totals):
        first, other = getattr(whole.totals, field.name), getattr(thinned.totals, field.name)
        np.testing.assert_array_equal(first, other)
    length, history = tributary(whole), whole.interface
    at_edge, _ = edge_pair(BACK_AND_FORTH)
    path = np.abs(np.diff(history.slip, axis=0, prepend=0.0)).cumsum(axis=0)
    beyond = whole.totals.accumulated_slip - whole.element_size / 2 * at_edge
    np.testing.assert_allclose(beyond, path @ length, atol=1e-14)
    largest = np.abs(history.slip).max(axis=1)
    np.testing.assert_allclose(whole.totals.max_slip, largest, atol=1e-16)
    assert whole.accumulated_slip(1.0) > 1.05 * np.abs(history.slip[-1]) @ length  # it went back


def test_frictional_work_is_that_of_the_energy_balance():
    """Totals belong to time levels, energies to the middle of the steps between them."""
    sim = simulate(BACK_AND_FORTH, resolution=40)
    work = sim.frictional_work(sim.energy.t)
    np.testing.assert_allclose(work, sim.energy.friction, atol=2e-4 * work[-1])
    path, rubbed = edge_pair(BACK_AND_FORTH)
    for total, density, at_edge in (
        (sim.frictional_work, sim.final_work_density, rubbed),
        (sim.accumulated_slip, sim.final_path, path[-1]),
    ):
        beyond = density @ tributary(sim)
        assert total(1.0) == pytest.approx(beyond + sim.element_size / 2 * at_edge, rel=1e-12)
        assert total(1.0) > 1.01 * beyond


def test_nothing_is_answered_beyond_what_was_recorded():
    sim = named("preloaded")
    for name in FIELDS:
        with pytest.raises(sf.SceneError, match="ends at t = 1"):
            getattr(sim, name)(0.5, 1.01)
        with pytest.raises(sf.SceneError, match="reaches to x"):
            getattr(sim, name)(10.0, 0.5)
    for name in TOTALS:
        with pytest.raises(sf.SceneError, match="ends at t = 1"):
            getattr(sim, name)(1.01)


@pytest.mark.slow
def test_largest_slip_rate_converges_to_that_of_the_march():
    """At the edge node it does not: it overshoots after jumps of load, to -1.65 against -0.93."""
    rate = sf.solve(
        BACK_AND_FORTH, method="space-time", end_time=1.0, nodes=500
    ).interface.slip_rate
    for largest in (np.max, np.min):
        coarse, fine = (
            abs(largest(named("harmonic", resolution).interface.slip_rate) / largest(rate) - 1)
            for resolution in (100, 200)
        )
        assert fine < 0.06
        assert fine < 0.6 * coarse


# --- opening ----------------------------------------------------------------------------------


def test_opening_is_told_with_its_place_time_width_and_length():
    sim = named("lift-off")
    opened, gap = sim.opened, sim.interface.gap
    level, node = np.argwhere(gap > 0)[0]
    assert opened.time == sim.interface.t[level]
    assert node == 0  # next to the edge
    assert opened.x == sim.interface.x[0]
    assert opened.gap == gap.max()
    # it opens to x = 0.186 t (Mode I, P_0 = -P_b)
    end = sim.interface.x[gap[-1] > 0].max() + sim.element_size / 2
    assert opened.length == pytest.approx(end)  # all of it, from x = 0 on
    assert opened.length == pytest.approx(0.186, abs=sim.element_size)
    sentence = opening_sentence(sim)
    for value in (opened.x, opened.time, opened.gap, opened.length):
        assert f"{value:.4g}" in sentence
    assert f"{opened.x:.4g} m at t = {opened.time:.4g} s" in opening_sentence(
        replace(sim, scene=replace(sim.scene, units="SI"))
    )


def test_opening_is_that_of_every_step_and_comes_back_from_a_file(tmp_path):
    whole, thinned = named("lift-off"), named("lift-off", every=10**6)
    assert thinned.opened == whole.opened
    thinned.save(tmp_path)
    assert load_simulation(tmp_path).opened == whole.opened


@pytest.mark.parametrize("name", ["preloaded", "remote-shock"])
def test_what_stays_closed_is_said_to(name):
    sim = named(name)
    assert sim.opened is None
    assert not sim.interface.gap.any()
    assert opening_sentence(sim) == "the contact stayed closed"


def test_no_pressure_before_the_load_is_no_gap():
    scene = unit_scene(0.5, base=(0.0, 0.0), load=(0.0, 0.0))
    sim = simulate(scene, resolution=20, model="two-blocks")
    assert sim.is_open.all()
    assert sim.opened is None


# --- one definition of the options ------------------------------------------------------------


def test_options_may_be_given_by_name_or_as_one_object():
    scene, coarse = find_scene("preloaded"), Settings(resolution=20, damping=0.03)
    by_name = simulate(scene, 0.5, resolution=20, damping=0.03, every=2)
    as_one = simulate(scene, 0.5, coarse, every=2)
    assert by_name.run == as_one.run
    assert cost(scene, 0.5, coarse) == cost(scene, 0.5, resolution=20, damping=0.03)
    assert cost(scene, 0.5, coarse).unknowns == as_one.unknowns


def test_what_is_no_option_is_refused():
    scene = find_scene("preloaded")
    with pytest.raises(sf.SceneError, match="give single options by name"):
        simulate(scene, 1.0, 50)
    for ask in (simulate, cost, prepare):
        with pytest.raises(TypeError, match="resolutions"):
            ask(scene, resolutions=50)


def test_prepared_model_is_that_of_the_simulation():
    scene = find_scene("remote-shock")
    model, sim = prepare(scene, resolution=20), simulate(scene, resolution=20)
    assert (model.unknowns, model.steps) == (sim.unknowns, sim.steps)
    assert (model.time_step, model.plan.size) == (sim.time_step, sim.element_size)
    np.testing.assert_array_equal(model.contact_x[1:], sim.interface.x)
    assert set(model.seconds) == {"mesh", "assembly"}
    whole = prepare(scene, resolution=20, full=True)
    assert whole.unknowns == cost(scene, resolution=20, snapshots=True).unknowns > model.unknowns


# --- two materials ----------------------------------------------------------------------------


def test_body_too_slow_for_the_mesh_is_named_with_a_resolution_that_would_do():
    scene, rubber = find_scene("preloaded"), sf.Material(1 / 16, 1.0, 0.45)
    scene = replace(scene, lower_material=rubber)
    with pytest.warns(UserWarning, match="the lower block is under-resolved") as caught:
        sim = simulate(scene, 0.5, resolution=20)
    assert str(caught[0].message) == sim.caution
    assert "crosses 5 elements" in sim.caution
    needed = int(sim.caution.split("a resolution of ")[1].split()[0])
    assert needed == 4 * LEAST_CROSSED
    for resolution, cautious in ((needed - 1, True), (needed, False)):
        model_free = replace(sim, resolution=resolution)
        assert bool(model_free.caution) == cautious


def test_faster_lower_body_needs_no_caution():
    assert not named("preloaded").caution
    fast = replace(find_scene("preloaded"), lower_material=sf.Material(4.0, 1.0, 0.3))
    assert not replace(named("preloaded"), scene=fast).caution
