"""Derivatives of solutions: closed forms, differences of solutions, homogeneity, and refusals."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, SHOCK, STEEL, UNIT, over, unit_scene
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


def step_of(solution, name, derivative, x):
    """A fiftieth of the change of a parameter that would bring an edge, or the longitudinal front,
    to one of the positions: differences of eighth order are then off by about 576 / 50^8."""
    scene, material = solution.scene, solution.scene.material
    places, speeds = solution.edge_speeds.ravel(), np.abs(edges_of(derivative)).ravel()
    moving = np.isfinite(places) & (speeds > 0)
    places, speeds = places[moving], speeds[moving]
    size = max(abs(value(scene, name)), 0.05 if name == "poisson_ratio" else 1e-2)
    if name == "poisson_ratio":
        front = material.longitudinal_speed
        by_ratio = material.shear_speed**2 / front / (1 - 2 * value(scene, name)) ** 2
        places, speeds = np.append(places, front), np.append(speeds, by_ratio)
    away = np.abs(places[:, None] - x).min(axis=1, initial=np.inf)
    return min((away / speeds).min(initial=np.inf) / 50, 5e-3 * size)


def differences(solution, name, derivative, x):
    """Derivatives of fields and edges from eight solutions; None where zones or the scene end."""
    scene, step = solution.scene, step_of(solution, name, derivative, x)
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


@pytest.mark.thinned(4)
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


@pytest.mark.thinned(27)
@over("exact", without="stuck slides")
def test_differences_of_solutions_agree(problem):
    solution = solve(problem.scene, rtol=1e-11)
    name = NAMES[len(problem.name) % len(NAMES)]
    if problem.scene.friction == 0:
        name = "poisson_ratio"
    found = errors(solution, name)
    assert found is None or max(found.values()) < 1e-8, (name, found)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
@pytest.mark.parametrize("name", TRACTIONS)
def test_a_remote_load_moves_what_is_in_place_and_what_is_taken_off(name, mode):
    """Where friction holds both, the same tractions may have been in place before."""
    remote = solve(unit_scene(1.2, (0.6, 0.5), (0.5, 0.6), load_on="remote", mode=mode))
    before = remote.scene.superposition.in_place
    slot = solve(replace(remote.scene, base=before, load_on="slot"))
    part, _, kind = name.partition("_")
    whole = [f"base_{kind}", name] if part == "load" else [name]
    found, parts = remote.derivative(name), [slot.derivative(one) for one in whole]
    assert found.status == "converged"
    x, t = clear_positions(remote), np.array([[0.8], [1.0]])
    for field in FIELDS:
        expected = sum(getattr(one, field)(x, t) for one in parts)
        size = np.abs(expected).max()
        np.testing.assert_allclose(getattr(found, field)(x, t), expected, atol=1e-8 * size)
    np.testing.assert_allclose(edges_of(found), sum(map(edges_of, parts)), atol=1e-8)
    early = getattr(found, {"shear": "shear_traction"}.get(kind, kind))(x, -1.0)
    np.testing.assert_array_equal(early, float(part == "base"))


def unpressed(scene, name):
    """Whether nothing presses the interface, which has no derivative with respect to pressures."""
    return name in ("base_pressure", "load_pressure") and not scene.superposition.in_place.pressure


def check_random_scenes(count, names_of):
    """Derivatives in random scenes against differences, and how many of them there were."""
    compared = 0
    for index, exact in enumerate(random_scenes(count, rtol=1e-11)):
        if exact.openings:  # where there is none
            continue
        for name in names_of(index):
            if unpressed(exact.scene, name):
                continue
            found = errors(exact, name)
            if found is not None:
                compared += 1
                assert max(found.values()) < 1e-8, (name, found, exact.scene)
    return compared


@pytest.mark.slow
def test_differences_of_solutions_agree_in_random_scenes():
    """With respect to two of the parameters in each, in turn."""
    count = len(NAMES)
    pairs = [(NAMES[i], NAMES[(i + count // 2) % count]) for i in range(count)]
    assert check_random_scenes(25, lambda index: pairs[index % count]) >= 20


@pytest.mark.thinned(9)
@over("exact", without="stuck")
def test_shear_is_homogeneous_in_tractions(problem):
    """Shear is of degree 1 in all tractions, and a function of friction times pressure."""
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


@pytest.mark.thinned(4)
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


@pytest.mark.thinned(2)
@pytest.mark.parametrize("viscosity", [1e-6, 1e-4, 1e-2])
def test_small_viscosity_where_slip_covers_the_shear_front(viscosity):
    """Next to that front, over distances as small, V turns from a square root to finite."""
    load = Tractions(1.0, -0.4059)
    law = ViscousFriction(viscosity)
    rock = Material(1.0, 1.0, 0.1542)
    nothing, rest = Tractions(0.0, 0.0), {"mode": "antiplane", "load_on": "remote"}
    remote = Scene(rock, 0.3095, nothing, load, friction_law=law, **rest)
    found = errors(solve(remote, rtol=1e-11), "poisson_ratio")
    assert found is not None
    assert max(found.values()) < 1e-8, found


@pytest.mark.slow
def test_stick_behind_a_longitudinal_zone():
    """Its slope bends slowly all the way from the edge."""
    base, load = Tractions(1.7499937632324243, 0.2801462320297712), Tractions(1.0, -1.5025)
    found = errors(solve(Scene(UNIT, 0.16008413167845315, base, load), rtol=1e-11), "poisson_ratio")
    assert found is not None
    assert max(found.values()) < 1e-8, found


def test_a_zone_at_the_edge_far_slower_than_all_waves():
    """Stick from the shear front to the zone is wide: 23,000 times the slowness of the front."""
    scene = unit_scene(1.9945514157984439, (0.52558377691034, 0.0), (0.0, 0.009061643), nu=-0.69)
    solution = solve(scene, rtol=1e-11)
    assert solution.zones[0].outer < 1e-4
    found = errors(solution, "poisson_ratio")
    assert found is not None
    assert max(found.values()) < 1e-8, found


@pytest.mark.thinned(20)
@pytest.mark.parametrize(
    "scene",
    [
        unit_scene(0.5, (1.0, 0.5), (0.6, -1.0)),
        unit_scene(0.5, (1.0, 0.5), (0.0, 1.0)),
        unit_scene(0.3, (1.0, -0.3), (0.5, -0.7), nu=0.1),
        unit_scene(0.5, (1.0, 0.5), (1.0, 0.5)),
        unit_scene(0.4, (1.0, 0.4), (0.5, 1.0), friction_law=ViscousFriction(0.2)),
        unit_scene(0.4, (1.0, 0.4), (0.5, 1.0), mode="antiplane"),
    ],
)
@pytest.mark.parametrize("name", ["friction", "base_pressure", "base_shear"])
def test_a_base_at_friction_lets_go_of_its_first_front(scene, name):
    """One-sided differences, towards where it sticks, come as near as the width of the strip behind
    the front: at least as the 2/3 power of the step."""
    solution = solve(scene, rtol=1e-12)
    assert solution.profile.fields.zones[0].left is None
    derivative, x = solution.derivative(name), clear_positions(solution)
    assert "base is at friction, and this holds as long as it sticks" in derivative.status
    sign = -np.sign(scene.base.shear) if name == "base_shear" else 1.0
    for field in ("slip_rate", "slip", "shear_traction"):
        away, found, before = [], getattr(derivative, field)(x, 1.0), getattr(solution, field)
        for step in (1e-4, 1e-6):
            beside = solve(changed(scene, name, value(scene, name) + sign * step), rtol=1e-12)
            expected = (getattr(beside, field)(x, 1.0) - before(x, 1.0)) / (sign * step)
            away.append(np.abs(found - expected).max() / np.abs(expected).max())
        assert away[1] < 2e-3
        assert away[1] < max(away[0] / 15, 1e-7)  # 100 ** (2 / 3) is 21


def test_the_first_front_of_a_base_at_friction_leaves_at_once():
    """It moves like the 2/3 power of what the base lacks; like its square if pressure steps."""
    plain = solve(unit_scene(0.5, (1.0, 0.5), (0.0, 1.0)))
    assert plain.derivative("friction").zones[-1].outer == -np.inf
    assert plain.derivative("base_shear").zones[-1].outer == np.inf
    assert plain.derivative("load_shear").zones[-1].outer == 0
    pressed = solve(unit_scene(0.5, (1.0, 0.5), (0.6, 1.0)))
    assert pressed.derivative("friction").zones[-1].outer == 0
    antiplane = solve(unit_scene(0.5, (1.0, 0.5), (0.0, 1.0), mode="antiplane"))
    with pytest.raises(SceneError, match="the base is at friction, and out of the plane"):
        antiplane.derivative("friction")


@pytest.mark.slow
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
    stuck = solve(unit_scene(np.sqrt(2) * (1 + 1e-9), **REMOTE))
    assert "about to slip" in stuck.derivative("friction").status
    assert solve(SHOCK).derivative("friction").status == "converged"


@pytest.mark.slow
def test_what_has_no_derivative_is_refused():
    with pytest.raises(SceneError, match="name must be one of friction"):
        solve(PRELOADED).derivative("density")
    with pytest.raises(SceneError, match="small positive friction"):
        solve(unit_scene(0.0)).derivative("friction")
    with pytest.raises(SceneError, match="small positive base pressure"):
        solve(unit_scene(0.2, (0.0, 0.0), (0.0, 0.5))).derivative("base_pressure")
    with pytest.raises(SceneError, match="needs ViscousFriction"):
        solve(PRELOADED).derivative("viscosity")
    law = RateWeakening(0.5, 1.24)
    weakening = Scene(UNIT, 0.607, Tractions(1, 0), Tractions(0, -0.504), friction_law=law)
    for name in NAMES:
        with pytest.raises(SceneError, match="constant and viscous friction only"):
            solve(weakening).derivative(name)
    tapped = solve(unit_scene(0.3, (0.02, 0.004), (1.0, 0.5), mode="antiplane"))
    with pytest.raises(SceneError, match="the gap is that of the same scene in the plane"):
        tapped.derivative("base_pressure").gap(1.0, 1.0)
    with pytest.raises(SceneError, match="positive positions"):
        solve(PRELOADED).derivative("friction").slip_rate(-1.0, 1.0)
