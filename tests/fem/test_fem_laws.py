"""What holds at every node and step: laws of contact and friction, energy, mirror images."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, SHOCK, unit_scene

import semianalytic as sf
from fem import simulate
from fem.interface import BACKWARD, FORWARD, OPEN, STICK
from fem.stepping import MarchedBody
from semianalytic.scene.given.finding import find_scene
from tests.fem.runs import FIELDS, LAWS, RISING, SCENES, UNLOADED, mixed, run, sheared

RUNS = {
    f"{name}, damping {damping}": (scene, {"damping": damping})
    for name, scene in SCENES.items()
    for damping in (0.0, 0.02)
} | {
    f"{load.__name__} {history}, {law}": (load(RISING[history], LAWS[law]), {"resolution": 40})
    for load in (sheared, mixed)
    for law in LAWS
    for history in RISING
}
"""Sudden loads with and without damping, and histories of load under every law of friction."""
any_run = pytest.mark.parametrize("name", RUNS)


# --- the laws of the interface ----------------------------------------------------------------


@pytest.mark.thinned(7)
@any_run
def test_law_holds_at_every_node_and_step(name):
    """The traction at t_n governs the increment from t_n to t_n+1; states say what nodes do."""
    scene, options = RUNS[name]
    sim = run(scene, **options)
    seen, state = sim.interface, sim.state[:-1]
    assert (seen.pressure >= 0).all()
    np.testing.assert_array_equal(sim.state == OPEN, seen.pressure == 0)
    assert (seen.gap >= 0).all()
    before, after = sim.is_open[:-1], sim.is_open[1:]
    assert (seen.gap[1:][before & after] > 0).all()
    assert not seen.gap[1:][~before & ~after].any()
    increment = np.diff(seen.slip, axis=0)
    path = np.cumsum(np.abs(increment), axis=0) - np.abs(increment)
    shear = seen.shear_traction[:-1]
    bound = scene.strength(seen.pressure[:-1], increment / sim.time_step, path).copy()
    bound[state == OPEN] = 0.0
    rounding = 1e-13
    slack = 1e-14 * bound if isinstance(scene.friction, float) else rounding
    assert (np.abs(shear) <= bound + slack).all()
    assert (increment * shear >= -rounding * np.abs(shear)).all()
    slips = (np.abs(increment) > rounding) & (state != OPEN)
    np.testing.assert_allclose(np.abs(shear)[slips], bound[slips], atol=rounding)
    assert set(np.unique(state)) <= {STICK, FORWARD, BACKWARD, OPEN}
    np.testing.assert_array_equal(state[slips], np.sign(increment[slips]))
    stuck = (state == STICK) | (np.abs(shear) < bound * (1 - 1e-9))
    assert np.abs(increment[stuck]).max(initial=0) < rounding


@pytest.mark.thinned(7)
@any_run
def test_energy_balances_to_rounding(name):
    scene, options = RUNS[name]
    sim = run(scene, **options)
    energy = sim.energy
    assert energy.external[-1] > 0.5 if "damping" in options else energy.friction[-1] > 1e-3
    assert energy.residual < 1e-13
    for taken in (energy.friction, energy.impact):
        assert np.diff(taken, prepend=0).min() >= -1e-16
    assert energy.kinetic[energy.external != 0].min() > 0
    assert energy.strain.min() >= -1e-16
    assert sim.final_work_density.min() > -1e-16


def test_viscous_work_vanishes_without_damping_and_grows_with_it():
    without, with_damping = run(SHOCK, damping=0.0).energy, run(SHOCK).energy
    assert np.abs(without.damping).max() < 1e-13
    assert np.diff(with_damping.damping).min() > 0


def test_weakening_lets_more_slip():
    path = {name: run(sheared(law=law)).final_path.sum() for name, law in LAWS.items()}
    assert path["rate"] > 1.02 * path["coulomb"]
    assert path["slip"] > 1.05 * path["coulomb"]
    assert path["viscous"] < 0.9 * path["coulomb"]


def test_weakening_the_blocks_cannot_radiate_is_refused():
    # pressure rises ahead of the edge
    scene = unit_scene(0.5, (1.0, 0.2), (1.0, 0.8), law=sf.RateWeakening(1.0, 0.55, 0.5))
    with pytest.raises(sf.SceneError, match="faster than a node of the interface can radiate"):
        run(scene, 40)


def test_shorter_steps_let_nodes_radiate_more():
    """At nu = 0 a node radiates less per step than a half-plane, unless steps are shorter."""
    scene = replace(
        sheared(law=sf.RateWeakening(1.0, 0.4, 0.4)), material=sf.Material(1.0, 1.0, 0.0)
    )
    with pytest.raises(sf.SceneError, match="lower `step_ratio`"):
        run(scene, 40)
    assert run(scene, 40, step_ratio=0.7).energy.residual < 1e-13


# --- one model against another ----------------------------------------------------------------

HALVES = {
    "preloaded": (SCENES["preloaded"], {}),
    "antiplane": (unit_scene(0.5, load=(0.0, 1.0), mode="antiplane"), {"end_time": 0.5}),
    "weakening": (sheared(RISING["ramp"], LAWS["slip"]), {}),
}


@pytest.mark.thinned(6)
@pytest.mark.parametrize("name", HALVES)
def test_half_block_equals_two_blocks(name):
    scene, options = HALVES[name]
    half, two = run(scene, **options), run(scene, model="two-blocks", **options)
    assert "half" in half.model
    assert two.model == "two blocks"
    for part, names, zero in (
        # rounding of order 1e-13; near the edge tractions are up to 20 times the load
        ("interface", FIELDS, 1e-10),
        ("slot", ("velocity_x", "velocity_y"), 1e-10),
        ("energy", ("kinetic", "strain", "friction", "damping", "external", "impact"), 1e-12),
    ):
        for field in names:
            first, other = (getattr(getattr(sim, part), field) for sim in (half, two))
            np.testing.assert_allclose(first, other, rtol=1e-10, atol=zero, err_msg=field)


def test_scene_decides_the_model():
    assert run(SCENES["preloaded"]).model == "antisymmetric half"
    assert run(SCENES["pressed"]).model == run(SCENES["remote"]).model == "two blocks"


@pytest.mark.thinned(2)
@pytest.mark.parametrize("scene", [PRELOADED, SHOCK], ids=["preloaded", "remote"])
def test_trimmed_domain_and_window_change_nothing(scene, tmp_path, monkeypatch):
    """Same answer on the full domain with every node moving from the first step."""
    trimmed = run(scene)
    activate = MarchedBody.activate
    monkeypatch.setattr(MarchedBody, "activate", lambda body, _: activate(body, np.inf))
    full = simulate(scene, resolution=32, snapshots=tmp_path, frames=1)
    assert full.unknowns > 1.5 * trimmed.unknowns
    for name in FIELDS:
        first, other = getattr(trimmed.interface, name), getattr(full.interface, name)
        # forerunners beyond the margin of 8 h + 3 c_l sqrt(eta T)
        np.testing.assert_allclose(first, other, atol=1e-7, err_msg=name)
    # nothing comes back on the full domain: twice as much of the slot is recorded
    reach = -scene.material.longitudinal_speed
    assert full.slot.x[0] == pytest.approx(reach, abs=full.element_size)
    both = full.slot.x >= trimmed.slot.x[0]
    np.testing.assert_array_equal(trimmed.slot.x, full.slot.x[both])
    np.testing.assert_allclose(trimmed.slot.velocity_x, full.slot.velocity_x[:, both], atol=1e-7)


def test_turning_the_shear_round_turns_the_slip_round():
    turned = replace(SHOCK, load=replace(SHOCK.load, shear=-1.0))
    first, other = run(SHOCK).interface, run(turned).interface
    np.testing.assert_array_equal(first.slip, -other.slip)
    np.testing.assert_array_equal(first.shear_traction, -other.shear_traction)
    np.testing.assert_array_equal(first.pressure, other.pressure)


def test_states_are_named():
    assert {FORWARD, OPEN} <= set(np.unique(run(UNLOADED).state))
    back_and_forth = run(find_scene("harmonic"), 40).state
    assert set(np.unique(back_and_forth)) == {STICK, FORWARD, BACKWARD}
