"""Evaluation anywhere: consistent fields, limits, refusals, and integrals against quadrature."""

from itertools import pairwise

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, SHOCK, solved, unit_scene
from laws import random_scenes

from semianalytic import SceneError, solve
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.given.named import NAMED_SCENES

STUCK = unit_scene(2.0, **REMOTE)


def test_shear_traction_of_the_stuck_scene_is_the_diffracted_load():
    stuck = solved(STUCK)
    x = np.array([0.05, 0.5, 0.99, 1.2, 1.8])
    np.testing.assert_allclose(
        stuck.shear_traction(x, 1.0), 1 + stuck_traction(1 / 3, "II")(1 / x), rtol=1e-8
    )
    np.testing.assert_allclose(
        stuck.pressure(x, 1.0), 1 + stuck_traction(1 / 3, "I")(1 / x), rtol=1e-12
    )
    assert np.all(stuck.slip(x, 1.0) == 0)


@pytest.mark.parametrize("friction", [1.25, 1.5, 2.0])
def test_stress_intensity_is_the_limit_of_the_tractions(friction):
    solution = solve(unit_scene(friction, **REMOTE))
    x = 1e-10
    mode_one, mode_two = solution.stress_intensity(1.0)
    near = np.sqrt(2 * np.pi * x)
    # The next term is the base traction itself, smaller by sqrt(x).
    assert solution.pressure(x, 1.0) * near == pytest.approx(mode_one, rel=1e-4)
    assert solution.shear_traction(x, 1.0) * near == pytest.approx(mode_two, rel=1e-4)


def test_slot_and_contact_meet_with_one_velocity():
    """x -> 0 from the slot and from the contact: the slipping edge is continuous."""
    preloaded = solved(PRELOADED)
    behind, ahead = preloaded.slot_velocity(-1e-7, 1.0)[0], preloaded.slip_rate(1e-9, 1.0)
    assert 2 * float(behind) == pytest.approx(preloaded.edge_slip_rate, rel=1e-3)
    assert float(ahead) == pytest.approx(preloaded.edge_slip_rate, rel=1e-7)
    assert solved(STUCK).edge_slip_rate == 0
    with pytest.raises(SceneError, match="x < 0"):
        preloaded.slot_velocity(0.1, 1.0)


def test_energy_leaves_through_friction_alone():
    """The fronts are free of singular energy flux: slip rate or stick margin vanishes beside one.

    That power is traction times slip rate over the contact is in test_totals.py.
    """
    shock = solved(SHOCK)
    stuck = solved(STUCK)
    sliding = solved(unit_scene(0.5, **REMOTE))
    edges = shock.edge_speeds
    for edge in edges[edges > 0]:
        distance = np.array([1e-4, 1e-6, 1e-8])
        for side in (-1, 1):
            x = edge * (1 + side * distance)
            product = np.abs(shock.slip_rate(x, 1.0) * shock.stick_margin(x, 1.0))
            assert np.all(product < 1e-9)  # one of them vanishes on either side
            concentration = np.abs(shock.shear_traction(x, 1.0)) * np.sqrt(distance)
            assert np.all(np.diff(concentration) < 0)
        below, above = shock.shear_traction(edge * np.array([1 - 1e-9, 1 + 1e-9]), 1.0)
        assert below == pytest.approx(above, abs=1e-3)  # square root of 1e-9 beside an edge
    assert stuck.frictional_power(1.0) == sliding.frictional_power(0.0) == 0
    assert sliding.frictional_power(1.0) == np.inf


# --- integrals against independent quadrature, parts of the contact, and balances -----------------


SCENES = {name: named.scene for name, named in NAMED_SCENES.items()}
SCENES["sliding"] = unit_scene(0.5, **REMOTE)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


def graded(steps):
    """Nodes and weights on (0, 1/2), on intervals that shrink fivefold towards 0."""
    ends = np.append(0.0, 0.5 * 5.0 ** -np.arange(steps, -1.0, -1.0))
    half, middle = np.diff(ends) / 2, (ends[1:] + ends[:-1]) / 2
    return (middle[:, None] + half[:, None] * _NODES).ravel(), np.outer(half, _WEIGHTS).ravel()


def integral(function, start, stop, singular, steps=22):
    """Integral by Gauss' rule on intervals that shrink towards the singular points."""
    ends = [start, *sorted(point for point in singular if start < point < stop), stop]
    total = 0.0
    for left, right in pairwise(ends):
        share, weight = graded(steps if left else 44)  # pressure is infinite at the edge itself
        total += (right - left) * float(weight @ function(left + (right - left) * share))
        share, weight = graded(steps)
        total += (right - left) * float(weight @ function(right - (right - left) * share))
    return total


def singular_speeds(solution):
    """Zone edges and wave fronts."""
    material = solution.scene.material
    fronts = [material.rayleigh_speed, material.shear_speed, material.longitudinal_speed]
    return [*fronts, *(v for v in solution.edge_speeds.ravel() if 0 < v < np.inf)]


def power_density(solution):
    return lambda x: solution.shear_traction(x, 1.0) * solution.slip_rate(x, 1.0)


def test_frictional_power_where_slip_covers_the_rayleigh_front():
    """At any rtol; the nodes of a rule alone, as if V were smooth there, give 0.4 % less."""
    for rtol in (1e-4, 1e-6, 1e-10):
        solution = solve(SCENES["auxetic"], rtol=rtol)
        assert solution.frictional_power(1.0) == pytest.approx(0.00235181045, rel=max(rtol, 1e-8))


def check_integrals(exact):
    """Power, heat, work, path and slip of a solution, and its totals, are those of its fields."""
    speeds, scene = singular_speeds(exact), exact.scene
    tolerance = exact.error_estimate
    largest = max(speeds) * 1.1
    density = power_density(exact)
    whole = integral(density, 0.0, largest, speeds)
    if scene.far_slip_rate:
        assert np.isinf(exact.frictional_power(1.0)) == (whole != 0)
    else:
        assert exact.frictional_power(1.0) == pytest.approx(whole, rel=tolerance)
        assert exact.frictional_work(3.0) == pytest.approx(4.5 * whole, rel=tolerance)
        slipped = integral(lambda x: exact.path(x, 1.0), 0.0, largest, speeds, 12)
        assert exact.accumulated_slip(3.0) == pytest.approx(9 * slipped, rel=max(tolerance, 1e-9))
    places = np.concatenate([np.geomspace(1e-9, 0.05, 300), np.linspace(0.05, 1.0, 3000)]) * largest
    slips = np.abs(exact.slip(places, 1.0)).max()
    assert slips <= exact.max_slip(1.0) * (1 + tolerance)
    assert slips == pytest.approx(exact.max_slip(1.0), rel=1e-3)
    inner, outer = 0.3 * scene.material.rayleigh_speed, 1.02 * scene.material.shear_speed
    part = integral(density, inner, outer, speeds)
    scale = tolerance * max(whole, 1e-300)
    assert exact.frictional_power(1.0, inner, outer) == pytest.approx(part, abs=scale)
    x, times = inner, sorted(inner / speed for speed in speeds)
    rate, traction = exact.slip_rate, exact.shear_traction
    work = integral(lambda t: rate(x, t) * traction(x, t), 0.0, 1.0, times)
    path = integral(lambda t: np.abs(rate(x, t)), 0.0, 1.0, times)
    slip = integral(lambda t: rate(x, t), 0.0, 1.0, times)
    assert exact.work_density(x, 1.0) == pytest.approx(work, rel=tolerance)
    assert exact.path(x, 1.0) == pytest.approx(path, rel=tolerance)
    top = exact.max_slip(1.0)  # to which the estimate is relative; beside an edge slip is less
    scale = tolerance * (top if np.isfinite(top) else path)
    assert exact.slip(x, 1.0) == pytest.approx(slip, abs=scale)
    assert exact.frictional_work(1.0, inner, outer) == pytest.approx(
        integral(lambda y: exact.work_density(y, 1.0), inner, outer, speeds, 12), abs=scale
    )


@pytest.mark.parametrize("name", ["preloaded", "auxetic", "remote-shock", "sliding"])
def test_slip_without_a_film_is_the_integral_of_its_rate_to_rounding(name):
    """Its tail at a slipping edge is in closed form: without it 4e-13 of the largest slip is left,
    where the rule ends."""
    exact = solve(SCENES[name], rtol=1e-10)
    fastest, speeds = exact.scene.material.longitudinal_speed, singular_speeds(exact)
    for x in fastest * np.array([1e-5, 0.03, 0.3, 0.4, 0.6, 0.7]):
        times = sorted(x / speed for speed in speeds)
        slip = integral(lambda t, x=x: exact.slip_rate(x, t), 0.0, 1.0, times)
        assert exact.slip(x, 1.0) == pytest.approx(slip, abs=1e-13 * exact.max_slip(1.0))


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", ["preloaded", "remote-shock", "auxetic", "pressure-drop"])
def test_integrals_of_named_scenes(name):
    check_integrals(solve(SCENES[name], rtol=1e-10))


@pytest.mark.slow
def test_integrals_of_random_scenes():
    for exact in random_scenes(40, rtol=1e-10):
        check_integrals(exact)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["preloaded", "auxetic"])
def test_momentum_balance(name):
    """Averaged over the line the solid moves like a plane shear wave: V = -tau / (rho c_t).

    The slip of the contact is thus known from tractions and from the slot alone; where it has one
    sense under constant pressure, so is the power.
    """
    solution = solve(SCENES[name], rtol=1e-10)
    scene, impedance = solution.scene, solution.scene.material.shear_impedance
    speeds, (held, load) = singular_speeds(solution), scene.superposition
    front = scene.material.longitudinal_speed
    traction = integral(lambda x: solution.shear_traction(x, 1.0) - held.shear, 0.0, front, speeds)
    slot = integral(
        lambda x: impedance * solution.slot_velocity(-x, 1.0)[0] - load.shear,
        0.0,
        front,
        speeds,
    )
    slipped = -2 / impedance * (traction + slot)
    assert integral(lambda x: solution.slip_rate(x, 1.0), 0.0, front, speeds) == pytest.approx(
        slipped, rel=1e-8
    )
    if name == "preloaded":
        strength = scene.coefficient * scene.base.pressure
        assert solution.frictional_power(1.0) == pytest.approx(strength * slipped, rel=1e-8)


def test_parts_of_the_contact_add_up():
    solution = solve(SCENES["pressure-drop"])
    ends = np.array([0.0, 1e-3, 0.4, 0.93, 1.1, np.inf])
    for taken in (solution.frictional_power, solution.frictional_work):
        parts, whole = taken(1.0, ends[:-1], ends[1:]), float(taken(1.0))
        assert np.all(parts >= -1e-12 * whole)  # differences, right to rounding of the whole
        assert parts.sum() == pytest.approx(whole, rel=1e-12)
        assert taken(1.0, 0.93) < 0.97 * whole


def test_slip_ahead_of_all_waves_takes_what_a_steady_slide_takes():
    solution = solve(SCENES["sliding"])
    rate = solution.scene.far_slip_rate
    x, t = np.array([3.0, 5.0]), 1.5
    np.testing.assert_allclose(solution.path(x, t), rate * t, rtol=1e-14)
    np.testing.assert_allclose(solution.work_density(x, t), 0.5 * rate * t, rtol=1e-14)
    assert solution.frictional_power(t, 3.0, 5.0) == pytest.approx(rate, rel=1e-13)
    assert solution.frictional_work(t, 3.0, 5.0) == pytest.approx(rate * t, rel=1e-13)
    assert solution.frictional_work(t) == solution.frictional_power(t, 3.0) == np.inf
    assert solution.accumulated_slip([0.0, t]).tolist() == [0.0, np.inf]
    (zone,) = solution.zones_at(t)
    assert (zone.start, zone.end) == (0.0, np.inf)


def test_largest_slip_inside_a_zone_is_found_to_rounding():
    """Slip of pressure-drop has its maximum inside its only zone, where V is slip over time."""
    solution = solve(SCENES["pressure-drop"], rtol=1e-10)
    (zone,) = solution.zones_at(1.0)
    low, high = zone.start, zone.end
    for _ in range(40):
        x = np.linspace(low, high, 21)
        top = int(np.argmax(solution.slip(x, 1.0)))
        low, high = x[max(top - 1, 0)], x[min(top + 1, 20)]
    assert solution.max_slip(2.0) == pytest.approx(2 * solution.slip(low, 1.0), rel=1e-12)
    assert solution.slip_rate(low, 1.0) == pytest.approx(float(solution.slip(low, 1.0)), rel=1e-5)


def test_nothing_is_taken_before_the_load_or_without_friction():
    solution = solve(SCENES["preloaded"])
    for taken in (solution.frictional_power, solution.frictional_work):
        assert np.all(taken(np.array([-1.0, 0.0]), 0.1) == 0)
    assert np.all(solution.path(0.3, np.array([-1.0, 0.0])) == 0)
    assert np.all(solution.work_density(0.3, np.array([-1.0, 0.0])) == 0)
    free = solve(unit_scene(0.0, nu=-0.5))
    assert (
        free.frictional_power(1.0)
        == free.frictional_work(1.0, 0.1)
        == free.work_density(0.3, 1.0)
        == 0
    )
    assert free.path(0.3, 1.0) > abs(free.slip(0.3, 1.0))  # it reverses around the Rayleigh front


@pytest.mark.thinned(2)
@pytest.mark.parametrize("shear", [1.0, -0.7])
def test_slip_accumulates_without_friction_whichever_way_it_goes(shear):
    scene = unit_scene(0.0, load=(0.0, shear), nu=-0.5)
    free = solve(scene, rtol=1e-10)
    speeds = singular_speeds(free)
    slipped = integral(lambda x: free.path(x, 1.0), 0.0, max(speeds), speeds, 12)
    net = integral(lambda x: free.slip(x, 1.0), 0.0, max(speeds), speeds, 12)
    assert free.accumulated_slip(1.0) == pytest.approx(slipped, rel=1e-9)
    assert slipped > 1.05 * abs(net)  # it reverses around the Rayleigh front


@pytest.mark.parametrize("ends", [(-0.1, 1.0), (0.5, 0.4), (np.nan, 1.0), (np.inf, np.inf)])
def test_bad_intervals_are_refused(ends):
    solution = solve(SCENES["preloaded"])
    with pytest.raises(SceneError, match="inner <= outer"):
        solution.frictional_work(1.0, *ends)
    with pytest.raises(SceneError, match="finite"):
        solution.frictional_power(np.inf)
