"""Whole fields: limits on the interface, wave equation and Hooke's law, fronts, edge, energy."""

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, Problem, problems, unit_scene

from semianalytic import Coulomb, solve
from semianalytic.field import tuning
from tests.semianalytic.field.body_fields import (
    check_faces,
    departures_from_laws,
    edges_of,
    smooth_points,
)

FILM = {"law": Coulomb(1.0, viscosity=0.1)}
FILMS = {
    "a film that opens": unit_scene(0.5, (1.0, 0.2), (-1.0, 1.0), **FILM),
    "a film that opens and closes again": unit_scene(0.5, (0.02, 0.0), (1.0, 1.0), **FILM),
    "antiplane film that opens": unit_scene(0.5, (0.02, 0.0), (1.0, 1.0), mode="antiplane", **FILM),
}
"""Slip rate and traction are infinite or like a small power where they border on the opening."""
ALL = [
    *problems("exact"),
    *problems("opens"),
    *(Problem(name, scene, frozenset()) for name, scene in FILMS.items()),
]
every = pytest.mark.parametrize("problem", ALL, ids=[problem.name for problem in ALL])


def among(*names):
    """Run a test on these problems."""
    return pytest.mark.parametrize(
        "problem", [p for p in ALL if p.name in names], ids=lambda case: case.name
    )


few = among("two zones under a shock", "both senses", "opens and closes again", "antiplane shock")


def unit_time(scene):
    """Some time, and how far shear waves come in it."""
    time = 0.7e-3 / scene.material.shear_speed
    return time, scene.material.shear_speed * time


def largest(scene):
    """Stress, velocity and displacement by which errors are measured."""
    time, _ = unit_time(scene)
    held, load = scene.superposition
    parts = (load.pressure, load.shear, scene.coefficient * held.pressure)
    stress = max(*map(abs, parts), abs(held.shear))
    velocity = stress / scene.material.shear_impedance
    return stress, velocity, velocity * time


def along(scene):
    """Rows of the shear components: of velocity and displacement, of stress."""
    return (2, 4) if scene.antiplane else (0, 2)


def interface_positions(solution):
    """Positions over what shear waves do in a unit time, away from zone edges and fronts."""
    _, reach = unit_time(solution.scene)
    x = np.linspace(0.0137, 2.1, 41) * reach
    material, (time, _) = solution.scene.material, unit_time(solution.scene)
    speeds = [material.rayleigh_speed, material.shear_speed, material.longitudinal_speed]
    speeds += edges_of(solution)
    gaps = np.abs(x[:, None] / time - np.array(speeds)[np.isfinite(speeds)])
    return x[gaps.min(axis=1) > 0.02 * material.shear_speed]


@pytest.mark.thinned(40)
@pytest.mark.parametrize(("rtol", "within"), [(1e-8, 1e-8), (1e-11, 1e-10)])
@every
def test_faces_move_and_carry_what_the_interface_does(problem, rtol, within):
    scene, solution = problem.scene, solve(problem.scene, rtol=rtol)
    time, _ = unit_time(scene)
    check_faces(solution, interface_positions(solution), time, within, largest(scene))


@pytest.mark.thinned(20)
@every
def test_slot_faces_carry_the_load_alone_and_move_as_the_other_formula_says(problem):
    scene, solution = problem.scene, solve(problem.scene)
    time, reach = unit_time(scene)
    x, (slip, shear) = -np.linspace(0.0137, 2.3, 37) * reach, along(scene)
    (stress, velocity, _), (held, load) = largest(scene), scene.superposition
    for face in (0.0, -0.0):
        fields = solution.stress(x, face, time)
        np.testing.assert_allclose(fields[shear], held.shear - load.shear, atol=1e-8 * stress)
        np.testing.assert_allclose(-fields[1], held.pressure - load.pressure, atol=1e-8 * stress)
    tangential, normal = solution.slot_velocity(x, time)
    rates = solution.velocity(x, 0.0, time)
    np.testing.assert_allclose(rates[slip], tangential, atol=1e-8 * velocity, rtol=1e-8)
    np.testing.assert_allclose(rates[1], normal, atol=1e-8 * velocity, rtol=1e-8)


def points_of(solution):
    """Points of the upper body at a unit time that no front is near, and of the lower one."""
    material, (time, _) = solution.scene.material, unit_time(solution.scene)
    speeds = (material.longitudinal_speed, material.shear_speed)
    sides = np.where(np.arange(60) % 2, 1, -1)
    return smooth_points(solution, material, speeds, time, side=sides, count=60, apart=0.07)


@pytest.mark.thinned(4)
@few
def test_fields_obey_the_equation_of_motion_and_hookes_law(problem):
    scene, solution = problem.scene, solve(problem.scene)
    (_, reach), (stress, _, _) = unit_time(scene), largest(scene)
    at = points_of(solution)
    found = departures_from_laws(solution, at, scene.material, 0.01 * reach)
    assert found.max() < 2e-6 * stress
    assert len(found) == (9 if scene.antiplane else 6)


@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_nothing_moves_ahead_of_the_waves_and_plane_waves_follow_behind_the_slot(mode):
    scene = unit_scene(1.25, **REMOTE, mode=mode)
    solution, slip = solve(scene), 2 if scene.antiplane else 0
    x, y = np.array([1.9, -2.5, 0.3, -0.5]), np.array([0.7, 2.1, -2.1, 2.01])
    assert np.all(solution.velocity(x, y, 1.0) == 0)
    assert np.all(solution.displacement(x, y, 1.0) == 0)
    heights = np.array([0.99, 1.01, 1.99, 2.01])
    for side in (1, -1):
        rates = solution.velocity(-3.0, side * heights, 1.0)
        np.testing.assert_allclose(rates[slip], side * np.array([1, 0, 0, 0]), atol=1e-9)
        np.testing.assert_allclose(rates[1], side * np.array([-1, -1, -1, 0]) / 2, atol=1e-9)
        stresses = solution.stress(-3.0, side * heights, 1.0)
        np.testing.assert_allclose(stresses[1], [0, 0, 0, -1], atol=1e-8)
        np.testing.assert_allclose(stresses[-1], [0, 1, 1, 1], atol=1e-8)


def test_a_stuck_antiplane_step_has_the_closed_form():
    """v_z = 2/pi Im artanh (1 - k)^-1/2, sigma_yz = 2/pi Im [(1 + k)^1/2 - artanh (1 + k)^-1/2]."""
    solution = solve(unit_scene(5.0, **REMOTE, mode="antiplane"))
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-0.99, 0.99, (2, 400)) / np.sqrt(2)
    radius, angle = 1 - np.geomspace(1e-12, 1e-3, 40), rng.uniform(0, np.pi, 40)
    close, around = (row.ravel() for row in np.meshgrid([1e-2, 1e-5, 1e-8], np.linspace(0.1, 3, 9)))
    x = np.concatenate([x, radius * np.cos(angle), close * np.cos(around)])
    y = np.concatenate([np.abs(y), radius * np.sin(angle), close * np.sin(around)])
    square = x**2 + y**2
    k = (-x + 1j * y * np.sqrt(1 - square)) / square
    rate = 2 / np.pi * np.arctanh(1 / np.sqrt(1 - k)).imag
    root = np.sqrt(1 + k)
    shear = 2 / np.pi * (root - np.arctanh(1 / root)).imag
    np.testing.assert_allclose(solution.velocity(x, y, 1.0)[2], rate, atol=1e-9)
    found, far = solution.stress(x, y, 1.0)[4], len(x) - len(close)
    np.testing.assert_allclose(found[:far], shear[:far], atol=1e-9, rtol=1e-9)
    np.testing.assert_allclose(found[far:], shear[far:], rtol=2e-8)


def test_stresses_beside_a_stuck_edge_are_those_of_its_intensity():
    solution = solve(unit_scene(2.0, **REMOTE))
    mode_one, mode_two = solution.stress_intensity(1.0)
    angle, r = np.linspace(-3, 3, 13), 1e-10
    at = r * np.cos(angle), r * np.sin(angle), 1.0
    sine, cosine = np.sin(angle / 2), np.cos(angle / 2)
    high, low = np.sin(3 * angle / 2), np.cos(3 * angle / 2)
    pressed = [cosine * (1 - sine * high), cosine * (1 + sine * high), sine * cosine * low]
    sheared = [-sine * (2 + cosine * low), sine * cosine * low, cosine * (1 - sine * high)]
    expected = (-mode_one * np.array(pressed) + mode_two * np.array(sheared)) / np.sqrt(
        2 * np.pi * r
    )
    np.testing.assert_allclose(solution.stress(*at) / expected, 1, atol=2e-4)


@pytest.mark.thinned(4)
@among("two zones under a shock", "both senses", "pressure on the slot", "slip everywhere")
def test_both_waves_added_first_are_what_they_are_apart(problem, monkeypatch):
    """Beside the edge, where it matters, at distances where either loses little."""
    solution, (time, reach) = solve(problem.scene), unit_time(problem.scene)
    rng = np.random.default_rng(8)
    r, angle = reach * rng.uniform(1 / 40, 1 / 7, 60), rng.uniform(-np.pi, np.pi, 60)
    at = r * np.cos(angle), r * np.sin(angle), time
    fields = ("velocity", "stress", "displacement")
    together = [getattr(solution, field)(*at) for field in fields]
    monkeypatch.setattr(tuning, "NEAR_EDGE", 1e3)
    for whole, field, unit in zip(together, fields, largest(problem.scene), strict=True):
        np.testing.assert_allclose(getattr(solution, field)(*at), whole, atol=1e-6 * unit)


def test_fields_are_self_similar_and_at_rest_before():
    solution, rng = solve(PRELOADED), np.random.default_rng(6)
    x, y = rng.uniform(-2, 2, (2, 50))
    for field, power in (("velocity", 0), ("stress", 0), ("displacement", 1)):
        ask = getattr(solution, field)
        once, later = ask(x[:, None], y, 1.0), ask(3 * x[:, None], 3 * y, 3.0)
        np.testing.assert_allclose(later, 3**power * once, rtol=1e-7, atol=1e-9)
        assert once.shape == (3 if field == "stress" else 2, 50, 50)
    assert np.all(solution.velocity(x, y, 0.0) == 0)
    before = solution.stress(0.5, 0.1, [-1.0, 0.0])
    np.testing.assert_array_equal(before, [[0, 0], [-1, -1], [0, 0]])


def test_stuck_fields_superpose():
    rng = np.random.default_rng(7)
    x, y = rng.uniform(-2, 2, (2, 50))
    nothing, half, whole = (
        solve(unit_scene(9.0, (1.0, 0.2), (pressure, 0.0))).stress(x, y, 1.0)
        for pressure in (0.0, 0.35, 0.7)
    )
    np.testing.assert_allclose(whole - nothing, 2 * (half - nothing), atol=1e-8)


def energy(solution, time, radius):
    """Kinetic and strain energy of changes within a radius, per depth, by Gauss quadrature."""
    material = solution.scene.material
    nodes, weights = np.polynomial.legendre.leggauss(400)
    r, angle = radius * (nodes + 1) / 2, np.pi * (nodes + 1) / 2
    x, y = r * np.cos(angle[:, None]), r * np.sin(angle[:, None])
    total = 0.0
    for side in (1, -1):
        xx, yy, xy = solution.stress(x, side * y, time) - solution.stress(x, side * y, -1.0)
        rates = solution.velocity(x, side * y, time)
        nu = material.poisson_ratio
        strain = (xx**2 + yy**2 - nu * (xx + yy) ** 2 + 2 * xy**2) / (4 * material.shear_modulus)
        density = material.density * (rates**2).sum(axis=0) / 2 + strain
        total += np.einsum("ij,i,j", density * r, weights, weights) * radius / 2 * np.pi / 2
    return total


@pytest.mark.slow
def test_energy_flows_in_through_a_circle_and_the_faces_and_out_as_heat():
    solution, radius = solve(PRELOADED), 0.8
    scene = solution.scene
    step = 0.02
    gained = (energy(solution, 1 + step, radius) - energy(solution, 1 - step, radius)) / (2 * step)
    nodes, weights = np.polynomial.legendre.leggauss(800)
    angle, x = np.pi * (nodes + 1) / 2, radius * (nodes + 1) / 2
    flux = 0.0
    for side in (1, -1):
        at = radius * np.cos(angle), side * radius * np.sin(angle), 1.0
        xx, yy, xy = solution.stress(*at) - solution.stress(at[0], at[1], -1.0)
        v_x, v_y = solution.velocity(*at)
        c, s = np.cos(angle), side * np.sin(angle)
        flux += (xx * c + xy * s) * v_x + (xy * c + yy * s) * v_y
    through_circle = radius * np.pi / 2 * weights @ flux
    above, below = (solution.velocity(-x, face, 1.0)[0] for face in (0.0, -0.0))
    loads = scene.load.shear * radius / 2 * weights @ (above - below)
    heat = solution.frictional_power(1.0, 0.0, radius)  # the base shear is zero
    assert gained == pytest.approx(float(through_circle + loads - heat), rel=5e-3)
    assert heat > 0.05 * loads


@pytest.mark.thinned(4)
@few
def test_error_is_honest(problem):
    scene = problem.scene
    solution, fine = solve(scene, rtol=1e-5), solve(scene, rtol=1e-10)
    x, y, t = points_of(fine)
    error = np.abs(solution.stress(x, y, t) - fine.stress(x, y, t)).max()
    assert error <= solution.field_error * largest(scene)[0]
    assert solution.field_error < 1e-4


def test_a_zone_far_slower_than_waves_spoils_nothing_elsewhere():
    """Integrals grow like k^2.5 towards its edge, and must not come back from there."""
    coarse, fine = (solve(unit_scene(98.0), rtol=rtol) for rtol in (1e-8, 1e-11))
    rng = np.random.default_rng(0)
    radius, angle = rng.uniform(0.1, 1.0, 40), rng.uniform(-np.pi, np.pi, 40)
    at = radius * np.cos(angle), radius * np.sin(angle), 1.0
    np.testing.assert_allclose(coarse.stress(*at), fine.stress(*at), atol=1e-8)
    np.testing.assert_allclose(coarse.velocity(*at), fine.velocity(*at), atol=1e-8)
