"""Loads of scenes, the piecewise-linear first stage, and which zones are tried next where Newton's
method or Coulomb's law fails."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import unit_scene
from hypothesis import given, settings
from hypothesis import strategies as st

from semianalytic import ComputationError, Material, Scene, Tractions, solve
from semianalytic.cut.load import Load, Opened, common_load, scaled_load
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.selfsimilar.zones.collocation import lemke, slip_grid, slip_on_grid
from semianalytic.selfsimilar.zones.corrections import corrected, rearranged
from semianalytic.selfsimilar.zones.coulomb import Violation

FACTORS = rayleigh_factors(1 / 3)
LOAD = Load(0.3, 1.0, 0.0, 0.0, 1.0, 0.0)


def at(v):
    return FACTORS.cut([v])


def ends(zones):
    """Slownesses of the edges of zones, None where they are open, and their senses."""
    return [(*(edge and edge.v[0] for edge in (gap.left, gap.right)), gap.sense) for gap in zones]


def wrong(zone, left, right, touches=(False, False), sense=1):
    return Violation(zone, sense, at(left), right and at(right), *touches)


@pytest.mark.parametrize(
    ("violation", "expected"),
    [
        (wrong(0, 2.2, 2.4), [(2.0, 2.2, 1), (2.4, 3.0, 1)]),
        (wrong(0, 2.0, 2.4, (True, False)), [(2.4, 3.0, 1)]),
        (wrong(0, 2.6, 3.0, (False, True)), [(2.0, 2.6, 1)]),
        (wrong(0, 2.6, 3.0), [(2.0, 2.6, 1)]),  # between the last node and the end
        (wrong(0, 2.0, 2.4), [(2.4, 3.0, 1)]),
        (wrong(-1, 1.8, 2.0, (False, True)), [(1.8, 3.0, 1)]),
        (wrong(-1, 3.0, 3.5, (True, False)), [(2.0, 3.5, 1)]),
        (wrong(-1, 1.2, 1.5), [(1.2, 1.5, 1), (2.0, 3.0, 1)]),
        (wrong(-1, 3.5, None, sense=-1), [(2.0, 3.0, 1), (3.5, None, -1)]),
        (wrong(-1, 1.8, 2.0, (False, True), -1), [(1.8, 2.0, -1), (2.0, 3.0, 1)]),
    ],
)
def test_zones_are_cut_widened_or_joined_by_new_ones(violation, expected):
    assert ends(corrected([Zone(at(2.0), at(3.0), 1)], [violation], LOAD)) == expected


def test_new_zones_wait_until_the_present_ones_are_sound():
    violations = [wrong(-1, 1.2, 1.5), wrong(0, 2.2, 2.4)]
    zones = corrected([Zone(at(2.0), at(3.0), 1)], violations, LOAD)
    assert ends(zones) == [(2.0, 2.2, 1), (2.4, 3.0, 1)]
    critical = replace(LOAD, base_shear=0.3)  # under which the first zone starts at the front
    for sense, left in ((1, None), (-1, 1.2)):
        zones = corrected([], [wrong(-1, 1.2, 1.5, sense=sense)], critical)
        assert ends(zones) == [(left, 1.5, sense)]


def test_what_newtons_method_fails_on_is_rearranged():
    front, far = Zone(at(0.8), at(1 + 1e-6), 1), Zone(at(4.0), None, 1)
    (crossed, _) = rearranged(FACTORS, [front, far], LOAD)
    assert crossed.right.v[0] < 1  # an edge just behind the shear front starts ahead of it
    narrow = Zone(at(2.0), at(2.0 * (1 + 1e-5)), 1)
    assert ends(rearranged(FACTORS, [narrow, far], LOAD)) == [(4.0, None, 1)]
    assert rearranged(FACTORS, [narrow], LOAD) == []
    near = Zone(at(2.0), at(3.8), 1)
    assert ends(rearranged(FACTORS, [near, far], LOAD)) == [(2.0, None, 1)]
    assert rearranged(FACTORS, [near, replace(far, sense=-1)], LOAD) is None
    factors = rayleigh_factors(1 / 3, "III")  # out of the plane too
    (crossed,) = rearranged(factors, [Zone(factors.cut([1 - 1e-6]), None, 1)], LOAD)
    assert crossed.left.v[0] == pytest.approx(1.1)


def test_what_slips_behind_an_opening_is_joined_to_it_once_it_vanishes():
    opening = Zone(at(0.6), at(2.0), 1)
    known = np.array([[0.6, 2.0], [0.0, 0.0]])
    load = replace(LOAD, opened=Opened(opening, (), 1.0, 1.0, lambda at: at.v, known))
    held = Zone(at(0.55), opening.right, 1, held=True)
    vanished = Zone(at(2.5), at(2.5 * (1 + 1e-5)), -1)
    (joined,) = rearranged(FACTORS, [held, vanished], load)
    assert (joined.right, joined.last_sense, joined.held) == (vanished.left, -1, False)
    # slip ahead of the opening turns once
    (turned,) = rearranged(FACTORS, [replace(held, left=at(0.599))], load)
    assert (turned.sense, turned.last_sense) == (-1, 1)
    assert rearranged(FACTORS, [replace(held, left=at(0.599))], load, may_turn=False) is None


def test_a_narrow_gap_around_the_rayleigh_front_is_joined_where_slip_meets_resistance():
    c = FACTORS.c
    outer, inner = Zone(at(0.8), at(c - 1e-3), 1), Zone(at(c + 1e-3), None, 1)
    assert rearranged(FACTORS, [outer, inner], LOAD) is None
    assert ends(rearranged(FACTORS, [outer, inner], replace(LOAD, resistance=0.1))) == [
        (0.8, None, 1)
    ]


def test_loads_are_in_units_of_the_largest_traction():
    material = Material(3.0, 0.7, 0.25)
    scene = Scene(material, 0.4, Tractions(20.0, 3.0), Tractions(5.0, 10.0))
    load, unit = scaled_load(scene)
    assert unit == 10.0
    assert load == Load(0.4, 2.0, 0.3, 0.5, 1.0, 0.0)
    shock = replace(scene, base=Tractions(0.0, 0.0), load=Tractions(20.0, 3.0), load_on="remote")
    shocked = [replace(shock, friction=f) for f in (0.1, 0.2)]
    both = common_load(shocked, 2.0)
    np.testing.assert_array_equal(both.friction, [[0.1], [0.2]])
    # V(inf) is what the shock exceeds friction by
    np.testing.assert_allclose(both.far_slip_rate, [[0.5], [0.0]], atol=1e-15)
    assert both.base_pressure == 10.0


def test_loads_know_whether_friction_counts_and_is_reached():
    assert replace(LOAD, friction=0.0).frictionless
    assert replace(LOAD, friction=1e-16).frictionless
    assert not replace(LOAD, friction=1e-14).frictionless
    assert replace(LOAD, base_shear=-0.3).critical
    assert not replace(LOAD, base_shear=0.299).critical
    assert replace(LOAD, load_shear=0.0).rests
    assert not LOAD.rests


# --- the piecewise-linear first stage: right to the width of a grid cell --------------------------


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


# --- complementarity problems ---------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_positive_definite_problems_are_solved(n, seed):
    random = np.random.default_rng(seed)
    factor = random.standard_normal((n, n))
    matrix = factor @ factor.T + 0.1 * np.eye(n)
    q = random.standard_normal(n)
    solved = lemke(matrix, q)
    w = q + matrix @ solved.z
    scale = 1 + np.abs(matrix).max() * np.abs(solved.z).max()
    assert np.all(solved.z >= 0)
    assert np.all(w >= -1e-9 * scale)
    assert abs(w @ solved.z) < 1e-9 * scale**2


def test_problems_with_nothing_to_do_without_solution_and_over_the_limit_of_pivots():
    assert lemke(np.eye(3), np.ones(3)).pivots == 0
    with pytest.raises(ComputationError, match="ray"):
        lemke(np.array([[-1.0]]), np.array([-1.0]))
    with pytest.raises(ComputationError, match="over 1 pivots"):
        lemke(np.eye(4), -np.arange(1.0, 5.0), most_pivots=1)
