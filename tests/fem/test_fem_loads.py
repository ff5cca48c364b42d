"""Loads that rise and fall in the finite-element model, and sums over all of its steps."""

import numpy as np
import pytest
from catalogue import UNIT, unit_scene

from docs.studies.article.stuck import stuck_pressure, stuck_shear
from fem.elements.edge import edge_offset
from fem.loading import kick_means
from semianalytic.scene.loads import Harmonic, Pulse, Ramp, Step
from tests.fem.runs import FIELDS, LAWS, RISING, l1, mixed, run, sheared


def held(pressure, shear):
    """So much friction that nothing slips, so much pressure that nothing opens."""
    histories = {"pressure_history": pressure, "shear_history": shear}
    return unit_scene(50.0, (20.0, 0.0), (0.5, 0.8), **histories)


# --- loads ------------------------------------------------------------------------------------


@pytest.mark.parametrize("history", RISING.values(), ids=RISING)
def test_kicks_add_up_to_the_impulse_of_the_load(history):
    step, steps = 0.0137, 80
    impulse = np.cumsum(kick_means(history, step, steps) * np.r_[0.5, np.ones(steps)]) * step
    ends = (np.arange(steps + 1) + 0.5) * step
    np.testing.assert_allclose(impulse, history.mean(0.0, ends) * ends, atol=1e-14)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("scene", [sheared, mixed])
def test_ramp_in_no_time_is_a_step_to_the_bit(scene):
    left, other = run(scene(Step()), 40), run(scene(Ramp(0.0)), 40)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(left.interface, name), getattr(other.interface, name))
    for name in ("kinetic", "friction", "external"):
        np.testing.assert_array_equal(getattr(left.energy, name), getattr(other.energy, name))


@pytest.mark.slow
def test_rectangle_is_a_step_less_a_delayed_step_where_nothing_slips():
    step = run(held(Step(), Step()), 40)
    delay = 30
    pulse = Pulse(delay * step.time_step)
    rectangle = run(held(pulse, pulse), 40)
    for name in ("shear_traction", "pressure"):
        whole = getattr(step.interface, name)
        change = whole - whole[0]
        change[delay:] -= change[:-delay].copy()
        got = getattr(rectangle.interface, name)
        # at level 0 the edge already feels half a kick, at level `delay` it feels the other half
        assert np.abs((got - got[0] - change)[delay:, 1:]).max() < 1e-11
    assert np.abs(rectangle.interface.slip).max() < 1e-14
    assert rectangle.final_path.max() < 1e-12


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("history", "resolution", "most"),
    [
        # L1 over 0.1 < x < 1.9 at t = 1; measured: pressure 1.5e-3, 8.7e-4, 6.6e-3; shear 9.5e-4,
        # 2.0e-3, 7.3e-3; shear at the nodes' places on 100 6.8e-3 under a ramp, 1.8e-2 under a wave
        (Ramp(0.3), 64, 3e-3),
        (Step(), 100, 3e-3),
        (Harmonic(2.0), 100, 9e-3),
    ],
)
def test_stuck_tractions_follow_the_history(history, resolution, most):
    sim = run(held(history, history), resolution)
    seen, h = sim.interface, sim.element_size
    x = np.linspace(0.1003, 1.9, 91)
    # The edge that shear sees where the contact is stuck lies beside that of a closed contact.
    beside = edge_offset([UNIT], held=0) - edge_offset([UNIT])
    assert beside == pytest.approx(0.16, abs=0.005)
    assert np.abs(seen.slip_rate).max() < 1e-13
    for exact, amplitude, simulated, base, offset in (
        (stuck_pressure, 0.5, seen.pressure, 20.0, 0.0),
        (stuck_shear, 0.8, seen.shear_traction, 0.0, beside),
    ):
        expected = exact(history, amplitude, UNIT, x + offset * h, 1.0).value
        assert l1(np.interp(x, seen.x, simulated[-1]) - base, expected) < most


# --- sums over all steps ----------------------------------------------------------------------


@pytest.mark.thinned(7)
@pytest.mark.parametrize("every", [1, 50])
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_path_and_friction_work_count_every_step(law, every):
    scene = mixed(Harmonic(2.0), law)
    whole, sim = run(scene, 40), run(scene, 40, every=every)
    increment = np.diff(whole.interface.slip, axis=0)
    np.testing.assert_allclose(sim.final_path, np.abs(increment).sum(axis=0), atol=1e-14)
    assert sim.final_path.max() > 1.05 * np.abs(sim.interface.slip[-1]).max()  # it went back
    shear = whole.interface.shear_traction
    work = (increment * (shear[1:] + shear[:-1]) / 2).sum(axis=0) - increment[0] * shear[0] / 4
    np.testing.assert_allclose(sim.final_work_density, work, atol=1e-14)


def test_nothing_rubs_where_symmetry_forbids_slip():
    sim = run(unit_scene(load=(0.5, 0.0), pressure_history=Ramp(0.2)), 20)
    assert not sim.final_path.any()
    assert not sim.final_work_density.any()
