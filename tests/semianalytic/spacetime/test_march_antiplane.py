"""Marches of antiplane shear: the memory, and what else has an answer for the same scene."""

import numpy as np
import pytest
from catalogue import UNIT, problems, unit_scene
from scipy.integrate import quad
from scipy.special import j1

from semianalytic import SlipWeakening, Step, march, solve
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.stuck_histories import stuck_shear
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import Antiplane
from semianalytic.reference import antiplane_slip, antiplane_slip_rate
from semianalytic.scene.contact import process_zone
from semianalytic.scene.scene import MODES
from semianalytic.spacetime.grid.nodes import causal_grid


def antiplane(friction, base=(1.0, 0.0), load=(0.0, 1.0), **parts):
    return unit_scene(friction, base, load, mode="antiplane", **parts)


def l1(found, wanted):
    return np.abs(found - wanted).sum() / np.abs(wanted).sum()


def test_transform_is_the_mode_three_impedance():
    """G(s) = sqrt(b^2 - k^2) / b at slowness k = i b / s."""
    s = np.array([0.01 + 0.3j, 0.2 + 1.4j, 3.0 + 0j, 0.5 + 9j])
    np.testing.assert_allclose(Antiplane()(s), np.sqrt(1 - (1j / s) ** 2), rtol=1e-13)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_memory_is_the_integral_of_a_bessel_function(tolerance):
    """h(x) = int_0^x J_1(y)/y dy, which tends to 1: what lasting slip exerts over mu q / 2."""
    memory = fit_memory(Antiplane(), 200.0, tolerance)
    assert memory.poles.real.max() < 0
    assert memory.static == 1
    x = np.array([0.0, 0.3, 1.0, 3.0, 10.0, 40.0])
    exact = [quad(lambda y: j1(y) / y if y else 0.5, 0, end, limit=200)[0] for end in x]
    np.testing.assert_allclose(memory(x), exact, atol=500 * tolerance + 1e-9)


def test_grid_is_as_large_as_shear_waves_reach():
    shear, pressed = antiplane(0.5), antiplane(0.5, load=(0.5, 1.0))
    sizes = [causal_grid(scene, 1.0, 1.0, 200).size for scene in (shear, pressed)]
    assert sizes[1] > 1.3 * sizes[0]
    assert march(shear, nodes=100).grid.x[-1] < UNIT.shear_speed
    assert march(pressed, nodes=100).grid.x[-1] > 1.9 * UNIT.shear_speed


@pytest.mark.slow
def test_step_converges_to_the_closed_form():
    """Measured 0.30, 0.14, 0.061 and 0.026 % of slip rate on four grids, each with its estimate."""
    scene, errors = antiplane(0.5), []
    for nodes in (125, 250, 500, 1000):
        marched = march(scene, nodes=nodes)
        x, now = marched.interface.x, marched.end_time
        errors.append(
            l1(marched.interface.slip_rate[-1], antiplane_slip_rate(UNIT, 1.0, 0.5, x / now))
        )
        assert errors[-1] < marched.error_estimate
        slip = antiplane_slip(UNIT, 1.0, 0.5, x, now)
        assert l1(marched.interface.slip[-1], slip) < errors[-1]
    assert errors[-1] < 4e-4
    assert np.log2(errors[0] / errors[-1]) / 3 > 1.0


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    "problem", [one for one in problems("exact") if one.scene.antiplane], ids=lambda one: one.name
)
def test_marches_converge_to_exact_solutions(problem):
    """Pressure that changes, viscosity, slip everywhere and ahead of the shear wave."""
    exact, errors = solve(problem.scene), []
    for nodes in (250, 500):
        marched = march(problem.scene, nodes=nodes, companion=False, every=10**6)
        x = marched.interface.x
        wanted = exact.slip_rate(x, marched.end_time)
        found = marched.interface.slip_rate[-1]
        errors.append(np.abs(found - wanted).sum() / max(np.abs(wanted).sum(), 1e-12))
    assert errors[-1] < 6e-3
    assert errors[-1] <= 0.75 * errors[0]


def test_march_of_a_stuck_interface_follows_the_stuck_traction():
    """Seen from the grid's own edge, as pressure is."""
    marched = march(antiplane(50.0, load=(0.0, 0.01)), nodes=400, companion=False, every=10**6)
    offset, factors = edge_offset_and_factors()
    x = marched.interface.x + (offset - 0.5) * marched.grid.spacing
    exact = stuck_shear(Step(), 0.01, UNIT, x, 1.0, "III").value + 0.01
    found = marched.interface.shear_traction[-1] + 0.01
    assert not marched.interface.slip_rate.any()
    assert l1(found, exact * factors[:400]) < 1e-3


def test_laws_that_weaken_have_the_process_zone_of_mode_three():
    law = SlipWeakening(0.5, 0.1)
    in_plane, out = (unit_scene(0.5, friction_law=law, mode=mode) for mode in MODES)
    assert process_zone(out) == pytest.approx((1 - UNIT.poisson_ratio) * process_zone(in_plane))
