"""The piecewise-linear first stage: right to the width of a grid cell."""

import numpy as np
import pytest
from catalogue import UNIT, unit_scene

from semianalytic import solve
from semianalytic.cut.load import Load
from semianalytic.reference import edge_speed_under_shear_step, slip_rate_under_shear_step
from semianalytic.selfsimilar.zones.collocation import slip_grid, slip_on_grid


@pytest.mark.parametrize("strength", [1.0, 0.5])
def test_shear_step_on_constant_strength(strength):
    grid = slip_on_grid(1 / 3, Load(strength, 1.0, 0.0, 0.0, 1.0, 0.0), 96)
    slipping = np.flatnonzero(grid.slip_rate)
    edge = edge_speed_under_shear_step(UNIT, strength)
    assert grid.xi[slipping[-1]] < edge < grid.xi[slipping[-1] + 2]
    at_edge = slip_rate_under_shear_step(UNIT, 1.0, strength, np.array(0.0)) / 2
    assert grid.slip_rate[0] == pytest.approx(float(at_edge), rel=0.01)


def test_slip_rate_converges_to_the_exact_zones():
    """Second zone ahead of the shear wave: the error falls with the cell, edges snap to nodes."""
    exact = solve(unit_scene(0.3))
    errors = []
    for size in (48, 96, 192):
        grid = slip_on_grid(1 / 3, Load(0.3, 1.0, 0.0, 0.0, 1.0, 0.0), size)
        x = np.linspace(0.02, 1.9, 400)
        difference = 2 * np.interp(x, grid.xi, grid.slip_rate) - exact.slip_rate(x, 1.0)
        errors.append(np.abs(difference).sum() / np.abs(exact.slip_rate(x, 1.0)).sum())
    assert errors[0] < 0.05
    assert errors[2] < errors[1] < errors[0]


def test_operator_balances_the_exact_solution():
    """The independent operator of section 4, applied to the exact slip rate, gives f p there."""
    scene = unit_scene(1.25, (1.0, 1.0), (1.0, 1.0))
    exact = solve(scene)
    grid = slip_grid(1 / 3, 400)
    rate = np.zeros(len(grid.xi) - 1)
    rate[1:] = exact.slip_rate(grid.xi[1:-1], 1.0) / 2
    rate[0] = exact.edge_slip_rate / 2
    traction = (grid.weight + grid.shear + grid.operator @ rate) / grid.weight
    strength = 1.25 * (grid.weight + grid.pressure) / grid.weight
    inner = (grid.xi[:-1] > 0.05) & (grid.xi[:-1] < 1.9)
    slipping = inner & (rate > 1e-3 * rate.max())
    # Piecewise-linear V on 400 nodes: quadrature error of the operator about (1/400) ln 400.
    assert np.abs(traction - strength)[slipping].max() < 5e-3
    assert np.all((traction <= strength + 5e-3)[inner])


def test_uniform_slip_cancels_the_shear_load():
    """A whole interface moving with V(inf) = Q_0 / mu b carries no shear traction at all."""
    grid = slip_grid(0.2, 60)
    uniform = grid.operator @ np.ones(len(grid.xi) - 1) + grid.far
    np.testing.assert_allclose(uniform, -(grid.weight + grid.shear), atol=2e-3 * grid.weight.max())
