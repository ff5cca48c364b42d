"""Slip rates are means over a short window about their level, which takes the ringing out."""

import numpy as np
import pytest

from fem import prepare, simulate
from fem.run import drift, levels
from semianalytic import solve
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.loads import Pulse
from semianalytic.scene.scene import Material, Scene, Tractions

MIXED = Scene(
    Material(1.0, 1.0, 0.1), 0.5, Tractions(1.0, 0.2), Tractions(0.5, 0.5), shear_history=Pulse(0.6)
)


def slips(model):
    """Slip beyond the edge node at every level, those after the end included."""
    seen = []
    for step in levels(model, 0, model.steps + model.half_window):
        seen.append(model.interface.sliding.offset()[1:])
        drift(model, step)
    return np.array(seen)


@pytest.mark.parametrize("every", [1, 7, 10**6])
def test_rate_is_the_mean_over_a_window_of_equal_parts_before_and_after(every):
    model, sim = prepare(MIXED, resolution=24), simulate(MIXED, resolution=24, every=every)
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
    model, sim = prepare(MIXED, resolution=24), simulate(MIXED, resolution=24)
    for step in levels(model):
        if step < model.steps:
            drift(model, step)
    np.testing.assert_array_equal(sim.final_path, model.interface.path[1:])
    np.testing.assert_array_equal(sim.final_work_density, model.interface.work_density()[1:])
    assert len(sim.energy.t) == len(sim.totals.t) - 1 == sim.steps


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("scene", "most"),
    [
        # measured: 0.77, 0.43, 0.54, 0.39
        (find_scene("preloaded"), 0.9),
        (find_scene("remote-shock"), 0.55),
        (Scene(Material(1.0, 1.0, 0.2), 0.15, Tractions(1.0, 0.1), Tractions(0.0, 0.9)), 0.6),
        (Scene(Material(1.0, 1.0, 0.0), 0.6, Tractions(1.0, 0.0), Tractions(0.0, 1.0)), 0.6),
    ],
)
def test_error_is_less_than_that_of_single_steps(scene, most):
    sim, exact = simulate(scene, resolution=50), solve(scene)
    x, t = sim.interface.x, sim.interface.t
    shown, rows = (x > 0.08) & (x < 1.4), range(len(t) - 30, len(t) - 1, 3)
    single = (sim.interface.slip[2:] - sim.interface.slip[:-2]) / (2 * sim.time_step)
    errors = np.zeros(2)
    for row in rows:
        expected = exact.slip_rate(x, t[row])
        for one, rate in enumerate((sim.interface.slip_rate[row], single[row - 1])):
            errors[one] += np.abs(rate - expected)[shown].sum() / np.abs(expected[shown]).sum()
    assert errors[0] < most * errors[1]
