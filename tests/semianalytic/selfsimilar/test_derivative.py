"""Derivatives of solutions: closed forms, differences of solutions, homogeneity, and refusals."""

from dataclasses import replace
from time import perf_counter

import numpy as np
import pytest
from catalogue import PRELOADED, SHOCK, STEEL, UNIT, over, unit_scene
from laws import random_scenes

from semianalytic import (
    Material,
    RateWeakening,
    Scene,
    SceneError,
    Tractions,
    ViscousFriction,
    solve,
)
from semianalytic.reference import edge_speed_under_shear_step, slip_rate_under_shear_step

TRACTIONS = ("base_pressure", "base_shear", "load_pressure", "load_shear")
NAMES = ("friction", "poisson_ratio", *TRACTIONS)
FIELDS = ("slip_rate", "slip", "shear_traction", "pressure")
CLEAR = 0.05
"""Distance from edges and fronts [c_t] from which differences of solutions are any good."""
EIGHTH_ORDER = ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))


def value(scene, name):
    if name == "poisson_ratio":
        return scene.material.poisson_ratio
    if name == "viscosity":
        return scene.friction_law.viscosity
    if name == "friction":
        return scene.friction
    part, kind = name.split("_")
    return getattr(getattr(scene, part), kind)


def changed(scene, name, number):
    if name == "poisson_ratio":
        return replace(scene, material=replace(scene.material, poisson_ratio=number))
    if name == "viscosity":
        return replace(scene, friction_law=ViscousFriction(number))
    if name == "friction":
        return replace(scene, friction=number)
    part, kind = name.split("_")
    return replace(scene, **{part: replace(getattr(scene, part), **{kind: number})})


def clear_positions(solution):
    """x at t = 1 away from zone edges and wave fronts."""
    material = solution.scene.material
    edges = solution.edge_speeds
    fronts = [material.longitudinal_speed, material.shear_speed, material.rayleigh_speed]
    marks = np.concatenate([edges[np.isfinite(edges)], fronts]) / material.shear_speed
    xi = np.concatenate([np.geomspace(0.02, 0.2, 6), np.linspace(0.25, 2.3, 60)])
    far = np.abs(xi[:, None] - marks).min(axis=1) > np.minimum(CLEAR, 0.3 * xi)
    return xi[far] * material.shear_speed


def differences(solution, name, derivative, x):
    """Derivatives of fields and edges from eight solutions; None where zones or the scene end.

    Edges move by at most a fiftieth of their distance from the positions.
    """
    scene, speeds = solution.scene, edges_of(derivative)
    speed = scene.material.shear_speed
    fastest = max(np.abs(speeds).max(initial=0.0) / speed, 1e-3)
    if name == "poisson_ratio":  # moves the longitudinal front
        fastest = max(
            fastest, speed / scene.material.longitudinal_speed / (1 - 2 * value(scene, name)) ** 2
        )
    size = max(abs(value(scene, name)), 0.05 if name == "poisson_ratio" else 1e-2)
    step = min(1e-3 / fastest, 5e-3 * size)
    senses = [zone.sense for zone in solution.zones]
    result = dict.fromkeys((*FIELDS, "edges"), 0.0)
    for steps, weight in EIGHTH_ORDER:
        for sign in (1, -1):
            try:
                beside = changed(scene, name, value(scene, name) + sign * steps * step)
                one = solve(beside, rtol=1e-12)
            except SceneError:
                return None
            if [zone.sense for zone in one.zones] != senses:
                return None
            for field in FIELDS:
                result[field] = result[field] + sign * weight / step * getattr(one, field)(x, 1.0)
            edges = np.where(np.isfinite(one.edge_speeds), one.edge_speeds, 0.0)
            result["edges"] = result["edges"] + sign * weight / step * edges
    return result


def edges_of(derivative):
    return np.array([(zone.inner, zone.outer) for zone in derivative.zones]).reshape(-1, 2)


def errors(solution, name):
    """Errors of a derivative relative to its largest values; None where nothing compares."""
    derivative, x = solution.derivative(name), clear_positions(solution)
    if "one-sided" in derivative.status:
        return None
    expected = differences(solution, name, derivative, x)
    if expected is None:
        return None
    found = {field: getattr(derivative, field)(x, 1.0) for field in FIELDS}
    found["edges"] = edges_of(derivative)
    scale = {field: solution._rate_unit for field in ("slip_rate", "slip")}
    scale |= {field: solution.stress_unit for field in ("shear_traction", "pressure")}
    unit = 1.0 if name in ("friction", "poisson_ratio") else solution.stress_unit
    scale["edges"] = solution.scene.material.shear_speed
    return {
        field: np.abs(found[field] - expected[field]).max(initial=0.0)
        / max(np.abs(expected[field]).max(initial=0.0), 0.01 * scale[field] / unit)
        for field in found
    }


@pytest.mark.parametrize("nu", [-0.5, 0.0, 1 / 3, 0.45])
@pytest.mark.parametrize("strength", [1.2, 2.5])
def test_edge_of_the_only_zone_moves_as_its_closed_form(nu, strength):
    """xi_s = c_t / ((1 - nu) (1 + f P_b / Q_0)^2)."""
    solution = solve(unit_scene(strength, nu=nu), rtol=1e-10)
    speed = edge_speed_under_shear_step(Material(1.0, 1.0, nu), strength)
    by_strength = -2 * speed / (1 + strength)
    expected = {
        "friction": by_strength,
        "base_pressure": strength * by_strength,
        "load_shear": -strength * by_strength,
        "base_shear": -by_strength,
        "poisson_ratio": speed / (1 - nu),
    }
    for name, moved in expected.items():
        derivative = solution.derivative(name)
        assert derivative.status == "converged"
        assert derivative.zones[0].outer == pytest.approx(moved, rel=1e-10)
        assert derivative.zones[0].inner == 0
        assert derivative.error_estimate < 1e-8


def test_slip_rate_of_the_only_zone_changes_as_its_closed_form():
    solution, x = solve(unit_scene(1.2), rtol=1e-11), np.array([0.02, 0.1, 0.2, 0.26])
    derivative, step = solution.derivative("friction"), 1e-3
    expected = sum(
        sign * weight / step * slip_rate_under_shear_step(UNIT, 1.0, 1.2 + sign * n * step, x)
        for n, weight in EIGHTH_ORDER
        for sign in (1, -1)
    )
    np.testing.assert_allclose(derivative.slip_rate(x, 1.0), expected, rtol=1e-9)
    assert derivative.edge_slip_rate == pytest.approx(
        float(derivative.slip_rate(1e-8, 1.0)), rel=1e-6
    )


@over("exact", without="stuck slides")
def test_differences_of_solutions_agree(problem):
    solution = solve(problem.scene, rtol=1e-11)
    name = NAMES[len(problem.name) % len(NAMES)]
    if problem.scene.friction == 0:
        name = "poisson_ratio"
    found = errors(solution, name)
    assert found is None or max(found.values()) < 1e-8, (name, found)


def check_random_scenes(count, names_of):
    """Derivatives in random scenes against differences, and how many of them there were."""
    compared = 0
    for index, exact in enumerate(random_scenes(count, rtol=1e-11)):
        if exact.openings:  # where there is none
            continue
        for name in names_of(index):
            found = errors(exact, name)
            if found is not None:
                compared += 1
                assert max(found.values()) < 1e-8, (name, found, exact.scene)
    return compared


def test_differences_of_solutions_agree_in_random_scenes():
    assert check_random_scenes(25, lambda index: [NAMES[index % len(NAMES)]]) >= 12


@over("exact", without="stuck")
def test_shear_is_homogeneous_in_tractions(problem):
    """Of degree 1 in all tractions, and a function of friction times pressure."""
    solution = solve(problem.scene)
    scene, x = problem.scene, clear_positions(solution)
    parts = {name: solution.derivative(name) for name in TRACTIONS}
    for field, size in (
        ("slip_rate", solution._rate_unit),
        ("shear_traction", solution.stress_unit),
    ):
        each = {n: value(scene, n) * getattr(one, field)(x, 1.0) for n, one in parts.items()}
        expected, tolerance = getattr(solution, field)(x, 1.0), 3e-7 * size
        np.testing.assert_allclose(sum(each.values()), expected, rtol=0, atol=tolerance)
        if scene.friction:
            by_friction = scene.friction * getattr(solution.derivative("friction"), field)(x, 1.0)
            pressures = each["base_pressure"] + each["load_pressure"]
            scale = 1 + np.abs(by_friction).max() / size
            np.testing.assert_allclose(by_friction, pressures, rtol=0, atol=scale * tolerance)
    edges = sum(value(scene, name) * edges_of(one) for name, one in parts.items())
    np.testing.assert_allclose(edges, 0, atol=1e-7 * scene.material.shear_speed)


@pytest.mark.parametrize(
    ("scene", "name"),
    [
        (unit_scene(0.5, mode="antiplane"), "friction"),
        (unit_scene(0.5, (1.0, 0.1), (0.4, 1.0), mode="antiplane"), "load_pressure"),
        (unit_scene(0.5, friction_law=ViscousFriction(0.2)), "viscosity"),
        (unit_scene(0.5, friction_law=ViscousFriction(0.2)), "poisson_ratio"),
        (unit_scene(0.4, mode="antiplane", friction_law=ViscousFriction(0.25)), "viscosity"),
    ],
)
def test_antiplane_and_viscous_scenes(scene, name):
    found = errors(solve(scene, rtol=1e-11), name)
    assert found is not None
    assert max(found.values()) < 1e-8, found


@pytest.mark.parametrize("viscosity", [1e-6, 1e-4, 1e-2])
def test_small_viscosity_where_slip_covers_the_shear_front(viscosity):
    """Next to that front, over distances as small, V turns from a square root to finite."""
    base = Tractions(1.0, -0.4059)
    law = ViscousFriction(viscosity)
    rock = Material(1.0, 1.0, 0.1542)
    remote = Scene(rock, 0.3095, base, base, mode="antiplane", friction_law=law)
    found = errors(solve(remote, rtol=1e-11), "poisson_ratio")
    assert found is not None
    assert max(found.values()) < 1e-8, found


def test_stick_behind_a_longitudinal_zone():
    """Its slope bends slowly all the way from the edge."""
    base, load = Tractions(1.7499937632324243, 0.2801462320297712), Tractions(1.0, -1.5025)
    found = errors(solve(Scene(UNIT, 0.16008413167845315, base, load), rtol=1e-11), "poisson_ratio")
    assert found is not None
    assert max(found.values()) < 1e-8, found


def test_slip_right_behind_the_longitudinal_front():
    friction = 0.6437263231181864
    base, load = Tractions(1.0, friction), Tractions(1.0, 0.7377745962954552)
    found = errors(solve(Scene(UNIT, friction, base, load), rtol=1e-11), "poisson_ratio")
    assert found is not None
    assert max(found.values()) < 1e-9, found


def test_slip_rate_changes_infinitely_fast_at_its_edges():
    solution = solve(PRELOADED)
    inner, outer = solution.zones
    just_behind = np.array([inner.outer, outer.outer]) * (1 - 1e-13)
    slow, fast = solution.derivative("friction").slip_rate(just_behind, 1.0)
    assert slow < -1e4
    assert fast < -10
    unit = solve(unit_scene(1.0), rtol=1e-12)  # at 3/8 c_t, which is no rounded number
    edge = unit.profile.fields.zones[0].left.v
    assert unit.derivative("friction").varied.slip_rate(edge) == -np.inf
    assert unit.derivative("load_shear").varied.slip_rate(edge) == np.inf


def test_before_the_load_only_the_base_changes():
    derivative = solve(unit_scene(0.5, (1.0, 0.1), (0.3, 1.0))).derivative("base_shear")
    assert derivative.slip_rate(0.5, -1.0) == derivative.slip(0.5, 0.0) == 0
    assert derivative.shear_traction(0.5, -1.0) == derivative.shear_traction(5.0, 1.0) == 1
    assert derivative.pressure(0.5, 1.0) == 0


def test_units():
    stress, x, t = 5e6, np.array([0.3, 0.8, 1.2]), 1e-4
    steel = solve(Scene(STEEL, 0.3, Tractions(stress, 0.0), Tractions(0.0, stress)), rtol=1e-10)
    unit, speed = solve(PRELOADED, rtol=1e-10), STEEL.shear_speed
    for name, per in (("friction", 1.0), ("load_shear", stress), ("poisson_ratio", 1.0)):
        one, other = steel.derivative(name), unit.derivative(name)
        rate = stress / STEEL.shear_impedance / per
        for found, expected in (
            (one.slip_rate(x * speed * t, t), rate * other.slip_rate(x, 1.0)),
            (one.slip(x * speed * t, t), rate * t * other.slip(x, 1.0)),
            (one.shear_traction(x * speed * t, t), stress / per * other.shear_traction(x, 1.0)),
            (edges_of(one), speed / per * edges_of(other)),
        ):
            np.testing.assert_allclose(
                found, expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max()
            )


def test_zones_about_to_change_are_flagged():
    assert "negative step of pressure" in solve(PRELOADED).derivative("load_pressure").status
    critical = solve(unit_scene(0.5, (1.0, 0.5), (0.6, -1.0)))
    assert "base is at friction" in critical.derivative("friction").status
    assert critical.derivative("load_shear").status == "converged"
    stuck = solve(unit_scene(np.sqrt(2) * (1 + 1e-9), (1.0, 1.0), (1.0, 1.0)))
    assert "about to slip" in stuck.derivative("friction").status
    assert solve(SHOCK).derivative("friction").status == "converged"


def test_what_has_no_derivative_is_refused():
    with pytest.raises(SceneError, match="name must be one of friction"):
        solve(PRELOADED).derivative("density")
    with pytest.raises(SceneError, match="small positive friction"):
        solve(unit_scene(0.0)).derivative("friction")
    with pytest.raises(SceneError, match="needs ViscousFriction"):
        solve(PRELOADED).derivative("viscosity")
    opened = solve(unit_scene(0.5, (1.0, 0.0), (-2.0, 0.0)))
    assert opened.openings
    with pytest.raises(SceneError, match="parts of this contact are open"):
        opened.derivative("load_pressure")
    law = RateWeakening(0.5, 1.24)
    weakening = Scene(UNIT, 0.607, Tractions(1, 0), Tractions(0, -0.504), friction_law=law)
    for name in NAMES:
        with pytest.raises(SceneError, match="constant and viscous friction only"):
            solve(weakening).derivative(name)
    with pytest.raises(SceneError, match="positive positions"):
        solve(PRELOADED).derivative("friction").slip_rate(-1.0, 1.0)


@pytest.mark.parametrize("rtol", [1e-5, 1e-8])
@pytest.mark.parametrize("name", ["friction", "load_shear", "poisson_ratio"])
def test_error_estimates_bound_errors(name, rtol):
    for scene in (PRELOADED, SHOCK, unit_scene(0.2, (1.0, -0.19), (0.5, 0.6))):
        exact, solution = solve(scene, rtol=1e-11), solve(scene, rtol=rtol)
        right, derivative = exact.derivative(name), solution.derivative(name)
        x, bound = clear_positions(exact), derivative.error_estimate
        for field in ("slip_rate", "slip", "shear_traction"):
            expected = getattr(right, field)(x, 1.0)
            error = np.abs(getattr(derivative, field)(x, 1.0) - expected).max()
            least = np.abs(getattr(exact, field)(x, 1.0)).max() / abs(value(scene, name))
            assert error <= bound * max(np.abs(expected).max(), least)
        error = np.abs(edges_of(derivative) - edges_of(right)).max()
        assert error <= bound * max(np.abs(edges_of(right)).max(), 1.0)


def seconds(function):
    """The least of five, in turns with nothing."""
    best = np.inf
    for _ in range(5):
        start = perf_counter()
        function()
        best = min(best, perf_counter() - start)
    return best


def test_a_derivative_costs_about_a_solution():
    """Of tractions or friction, over scenes of several kinds; 0.8 on a quiet machine."""
    solving = deriving = 0.0
    for scene in (PRELOADED, SHOCK, unit_scene(0.1), unit_scene(0.2, (1.0, -0.19), (0.5, 0.6))):
        solving += seconds(lambda scene=scene: solve(scene))
        fresh = iter([solve(scene) for _ in range(5)])  # which share no Jacobian
        deriving += seconds(lambda fresh=fresh: next(fresh).derivative("friction"))
    assert deriving < 1.5 * solving
