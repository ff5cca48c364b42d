"""The finite-element model against exact solutions; its histories, slip rates and options."""

from dataclasses import fields, replace

import numpy as np
import pytest
from catalogue import PRELOADED, SHOCK, STEEL, UNIT, unit_scene

import semianalytic as sf
from fem import simulate
from fem.run import levels
from semianalytic.reference import slip_rate_under_shear_step
from tests.fem.runs import SCENES, l1, prepare, run


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_critical_step_itself_is_stable(damping):
    sim = simulate(SHOCK, resolution=24, step_ratio=1.0, damping=damping)
    reference = simulate(SHOCK, resolution=24, step_ratio=0.5, damping=damping)
    assert sim.time_step <= sim.critical_step
    # growth of the fastest mode by a factor of two would be seen in the kinetic energy
    assert sim.energy.kinetic[-1] == pytest.approx(reference.energy.kinetic[-1], rel=0.1)


# --- against exact solutions ------------------------------------------------------------------


@pytest.mark.slow
def test_slip_rate_converges_to_the_closed_form():
    grid = np.linspace(1e-9, 0.375, 120)
    exact = slip_rate_under_shear_step(UNIT, 1.0, 1.0, grid)
    errors = []
    for resolution in (50, 100, 200):
        history = run(unit_scene(1.0), resolution).interface
        here = (history.x > 0.02) & (history.x < 1.9)
        expected = np.interp(history.x[here], grid, exact, right=0.0)
        errors.append(l1(history.slip_rate[-1, here], expected))
    # measured: 4.9e-3, 2.1e-3, 1.5e-3; what is left at 200 is the front passing node by node
    assert errors[1] < 3e-3
    assert errors[2] < 2e-3
    assert errors[0] > 1.5 * errors[1] > 1.5 * errors[2]
    assert errors[0] > 1.5**2 * errors[2]  # at least of order log2(1.5)


def test_whole_interface_slips_at_the_closed_form_rate():
    history = run(SCENES["sliding"], 64).interface
    x, rate = history.x, history.slip_rate[-1]
    # 2 [(Q - f P) + f P Lambda], Lambda = 0.210079 behind the shear front, 0.147124 at 1.6 c_t
    assert rate[x < 0.9].mean() == pytest.approx(1.210079, rel=2e-3)
    assert np.interp(1.6, x, rate) == pytest.approx(1.147124, rel=2e-3)
    far = x > UNIT.longitudinal_speed * 1.08
    np.testing.assert_allclose(rate[far], SCENES["sliding"].far_slip_rate, rtol=1e-3)


def test_slot_faces_move_like_a_half_plane_until_the_edge_is_felt():
    slot = run(unit_scene(2.0, load=(0.5, 1.0)), 80).slot
    far = slot.x < -0.9
    early = (slot.t > 0.1) & (slot.t < 0.35)  # the edge is felt at 0.45
    vx, vy = (v[np.ix_(early, far)] for v in (slot.velocity_x, slot.velocity_y))
    # single steps still ring by a few percent after a sudden load; their mean does not
    np.testing.assert_allclose(vx.mean(axis=0), 1.0 / UNIT.shear_impedance, rtol=5e-3)
    np.testing.assert_allclose(vy.mean(axis=0), -0.5 / UNIT.longitudinal_speed, rtol=5e-3)


def test_nothing_moves_ahead_of_the_pressure_front():
    history = run(PRELOADED, 64).interface
    ahead = history.x[None, :] > UNIT.longitudinal_speed * history.t[:, None] + 0.25
    assert ahead.any()
    assert np.abs(history.slip[ahead]).max() < 1e-9
    assert np.abs(history.shear_traction[ahead]).max() < 1e-7


# --- opening and closing ----------------------------------------------------------------------


def test_pressing_faces_together_keeps_them_closed():
    pressure = run(SCENES["pressed"], 64).interface.pressure
    # stuck minimum of 1 + p*: 0.949 just behind the shear front, less what the mesh rings
    assert 0.92 < pressure.min() < 0.96


def test_reclosing_does_not_chatter():
    history = run(SCENES["reclosing"], 64).interface
    is_open = history.pressure == 0
    opened = is_open.any(axis=0)
    assert opened.sum() > 32
    switches = np.abs(np.diff(is_open.astype(int), axis=0)).sum(axis=0)
    assert switches.max() <= 2  # once open, once closed again
    assert (switches[opened & (history.x < 0.5)] == 2).all()


# --- units ------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [SHOCK, unit_scene(0.5, mode="antiplane")])
def test_units_do_not_matter(scene):
    stress, end = 5e6, 2e-5
    base, load = (
        sf.Tractions(stress * part.pressure, stress * part.shear)
        for part in (scene.base, scene.load)
    )
    steel = replace(scene, material=STEEL, base=base, load=load)
    first, other = run(scene).interface, run(steel, end_time=end).interface
    rate = stress / STEEL.shear_impedance
    np.testing.assert_allclose(other.slip_rate / rate, first.slip_rate, atol=1e-12)
    np.testing.assert_allclose(other.pressure / stress, first.pressure, rtol=1e-9)
    np.testing.assert_allclose(other.x / (end * STEEL.shear_speed), first.x, atol=1e-12)


# --- what simulate accepts and returns --------------------------------------------------------


def test_every_thins_the_histories():
    whole, thin = run(PRELOADED), run(PRELOADED, every=10)
    levels = [*range(0, whole.steps, 10), whole.steps]
    np.testing.assert_array_equal(thin.interface.t, whole.interface.t[levels])
    np.testing.assert_array_equal(thin.interface.slip_rate, whole.interface.slip_rate[levels])
    np.testing.assert_array_equal(thin.slot.velocity_x, whole.slot.velocity_x[levels])
    # sums over every step are not thinned out
    for part in fields(whole.energy):
        first, other = (getattr(sim.energy, part.name) for sim in (thin, whole))
        np.testing.assert_array_equal(first, other)
    assert thin.energy.residual == whole.energy.residual < 1e-13


def test_histories_cover_first_node_to_front_and_zero_to_end():
    sim = simulate(PRELOADED, end_time=0.5, resolution=20)
    assert sim.element_size == pytest.approx(0.025)
    assert sim.interface.x[0] == pytest.approx(0.025)
    assert sim.interface.x[-1] >= UNIT.longitudinal_speed * 0.5
    np.testing.assert_allclose(np.diff(sim.interface.x), 0.025)
    assert sim.slot.x[-1] == pytest.approx(-0.025)
    assert sim.slot.x[0] == pytest.approx(-UNIT.longitudinal_speed * 0.25)
    assert sim.interface.t[0] == 0
    assert sim.interface.t[-1] == pytest.approx(0.5, rel=1e-14)
    assert len(sim.interface.t) == sim.steps + 1
    assert (np.diff(sim.energy.t) > 0).all()
    assert sim.time_step <= 0.95 * sim.critical_step
    assert set(sim.seconds) == {"mesh", "assembly", "steps"}


def test_progress_counts_every_step():
    seen = []
    sim = simulate(PRELOADED, resolution=10, progress=lambda *step: seen.append(step))
    assert seen == [(n, sim.steps) for n in range(1, sim.steps + 1)]


@pytest.mark.parametrize(
    "options",
    [
        {"end_time": 0.0},
        {"resolution": 7},
        {"resolution": 10**6},
        {"damping": -0.1},
        {"step_ratio": 0.0},
        {"step_ratio": 1.51},
        {"mesh": "hexagons"},
        {"resume": True},
        {"checkpoint_every": 0},
        {"model": "three-blocks"},
        {"every": 0},
        {"frames": 0},
    ],
)
def test_options_out_of_range_are_refused(options):
    with pytest.raises(sf.SceneError, match=r"simulate|mesh"):
        simulate(PRELOADED, **options)


def test_overflow_names_the_step(monkeypatch):
    monkeypatch.setattr(
        "semianalytic.scene.checks.LARGEST", 1e301
    )  # else the scene refuses the load
    with pytest.raises(sf.ComputationError, match="at step 1;"):
        simulate(unit_scene(load=(0.0, 1e300)), resolution=10)


# --- slip rates are means over a short window, which takes the ringing out ---------------------

PULSED = unit_scene(0.5, (1.0, 0.2), (0.5, 0.5), nu=0.1, shear_history=sf.Pulse(0.6))


def slips(model):
    """Slip beyond the edge node at every level, those after the end included."""
    seen = []
    for _ in levels(model, 0, model.steps + model.half_window):
        seen.append(model.joint.sliding.offset()[1:])
        model.drift()
    return np.array(seen)


@pytest.mark.parametrize("every", [1, 7, 10**6])
def test_rate_is_the_mean_over_a_window_of_equal_parts_before_and_after(every):
    model, sim = prepare(PULSED, resolution=24), simulate(PULSED, resolution=24, every=every)
    slip, half, rate = slips(model), model.half_window, sim.interface.slip_rate
    assert 2 * half * sim.time_step == pytest.approx(2.8 * sim.element_size, abs=sim.time_step)
    assert len(slip) == sim.steps + half + 1
    for row, level in enumerate(np.rint(sim.interface.t / sim.time_step).astype(int)):
        near = min(half, level)
        window = 2 * near * sim.time_step
        expected = (slip[level + near] - slip[level - near]) / window if level else 0 * slip[0]
        np.testing.assert_array_equal(rate[row], expected)
        np.testing.assert_array_equal(sim.interface.slip[row], slip[level])
    assert sim.interface.t[-1] == pytest.approx(1.0)


def test_what_is_summed_ends_with_the_end_time():
    model, sim = prepare(PULSED, resolution=24), simulate(PULSED, resolution=24)
    for step in levels(model):
        if step < model.steps:
            model.drift()
    np.testing.assert_array_equal(sim.final_path, model.joint.path[1:])
    np.testing.assert_array_equal(sim.final_work_density, model.joint.work_density()[1:])
    assert len(sim.energy.t) == len(sim.totals.t) - 1 == sim.steps


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("scene", "most"),
    [
        # measured on meshes of 40 to 60: up to 0.83, 0.44, 0.74, 0.39
        (PRELOADED, 0.9),
        (SHOCK, 0.55),
        (unit_scene(0.15, (1.0, 0.1), (0.0, 0.9), nu=0.2), 0.8),
        (unit_scene(0.6, nu=0.0), 0.6),
    ],
)
def test_error_is_less_than_that_of_single_steps(scene, most):
    sim, exact = simulate(scene, resolution=50), sf.solve(scene)
    x, t = sim.interface.x, sim.interface.t
    shown, rows = (x > 0.08) & (x < 1.4), range(len(t) - 30, len(t) - 1, 3)
    single = (sim.interface.slip[2:] - sim.interface.slip[:-2]) / (2 * sim.time_step)
    errors = np.zeros(2)
    for row in rows:
        expected = exact.slip_rate(x, t[row])
        for values, rate in enumerate((sim.interface.slip_rate[row], single[row - 1])):
            errors[values] += np.abs(rate - expected)[shown].sum() / np.abs(expected[shown]).sum()
    assert errors[0] < most * errors[1]


# --- a viscous film that opens ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("base", "load"), [((1.0, 0.0), (-1.0, 1.0)), ((0.02, 0.0), (1.0, 0.5))], ids=["edge", "tap"]
)
def test_slip_beside_an_opening(base, load):
    """At the border slip rate is infinite, or nothing, where traction would jump."""
    sim = run(unit_scene(0.3, base, load, law=sf.Coulomb(1.0, viscosity=0.25)), 40)
    exact, x = sf.solve(sim.scene, rtol=1e-6), sim.interface.x
    assert l1(sim.interface.slip[-1], exact.slip(x, sim.end_time)) < 0.01
