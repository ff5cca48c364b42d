"""Derivatives of solutions: closed forms, differences of solutions, homogeneity, and refusals."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, SHOCK, STEEL, over, under, unit_scene
from laws import random_scenes

from semianalytic import Coulomb, Material, RateWeakening, Scene, SceneError, Tractions
from semianalytic.parameters.overriding import override_scene
from semianalytic.reference import edge_speed_under_shear_step
from semianalytic.selfsimilar.derivatives.parameters import parameter
from semianalytic.selfsimilar.solver import solve

TRACTIONS = ("base_pressure", "base_shear", "load_pressure", "load_shear")
NAMES = ("friction", "poisson_ratio", *TRACTIONS)
FIELDS = ("slip_rate", "slip", "shear_traction", "pressure")
OPENED = (*FIELDS, "gap", "gap_rate")
CLEAR = 0.05
"""Distance from edges and fronts [c_t] from which differences of solutions are any good."""
EIGHTH_ORDER = ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))


def edges_of(first):
    """Inner and outer ends of zones, then of openings, of a solution or of its derivative."""
    parts = (*first.zones, *first.openings)
    return np.array([(part.inner, part.outer) for part in parts]).reshape(-1, 2)


def clear_positions(solution, clear=CLEAR):
    """x at t = 1 away from edges of zones and openings, and from wave fronts."""
    material, edges = solution.scene.material, edges_of(solution)
    fronts = [material.longitudinal_speed, material.shear_speed, material.rayleigh_speed]
    marks = np.concatenate([edges[np.isfinite(edges)], fronts]) / material.shear_speed
    xi = np.concatenate([np.geomspace(0.02, 0.2, 6), np.linspace(0.25, 2.3, 60)])
    far = np.abs(xi[:, None] - marks).min(axis=1) > np.minimum(clear, 0.3 * xi)
    return xi[far] * material.shear_speed


def step_of(solution, name, derivative, x):
    """A fiftieth of the change of a parameter that would bring an edge, or the longitudinal front,
    to one of the positions: differences of eighth order are then off by about 576 / 50^8."""
    scene, material = solution.scene, solution.scene.material
    places, speeds = edges_of(solution).ravel(), np.abs(edges_of(derivative)).ravel()
    moving = np.isfinite(places) & (speeds > 0)
    places, speeds = places[moving], speeds[moving]
    size = max(abs(parameter(scene, name)), 0.05 if name == "poisson_ratio" else 1e-2)
    if name == "poisson_ratio":
        front = material.longitudinal_speed
        by_ratio = material.shear_speed**2 / front / (1 - 2 * parameter(scene, name)) ** 2
        places, speeds = np.append(places, front), np.append(speeds, by_ratio)
    away = np.abs(places[:, None] - x).min(axis=1, initial=np.inf)
    return min((away / speeds).min(initial=np.inf) / 50, 5e-3 * size)


def differences(solution, name, derivative, x):
    """Derivatives of fields and edges from eight solutions; None where zones or the scene end."""
    scene, step = solution.scene, step_of(solution, name, derivative, x)
    senses = [zone.sense for zone in solution.zones]
    fields = OPENED if scene.mode == "in-plane" else FIELDS
    result = dict.fromkeys((*fields, "edges"), 0.0)
    for steps, weight in EIGHTH_ORDER:
        for sign in (1, -1):
            try:
                beside = override_scene(
                    scene, **{name: parameter(scene, name) + sign * steps * step}
                )
                answer = solve(beside, rtol=1e-12)
            except SceneError:
                return None
            if [zone.sense for zone in answer.zones] != senses:
                return None
            share, edges = sign * weight / step, edges_of(answer)
            for field in fields:
                result[field] = result[field] + share * getattr(answer, field)(x, 1.0)
            result["edges"] = result["edges"] + share * np.where(np.isfinite(edges), edges, 0.0)
    return result


def errors(solution, name):
    """Errors of a derivative relative to its largest values; None where nothing compares."""
    derivative, x = solution.derivative(name), clear_positions(solution)
    if "one-sided" in derivative.status:
        return None
    expected = differences(solution, name, derivative, x)
    if expected is None:
        return None
    scale = dict.fromkeys(expected, solution._rate_unit)
    scale |= dict.fromkeys(("shear_traction", "pressure"), solution.stress_unit)
    scale["edges"] = solution.scene.material.shear_speed
    unit = 1.0 if name in ("friction", "poisson_ratio") else solution.stress_unit
    result = {}
    for field, wanted in expected.items():
        found = edges_of(derivative) if field == "edges" else getattr(derivative, field)(x, 1.0)
        size = max(np.abs(wanted).max(initial=0.0), 0.01 * scale[field] / unit)
        result[field] = np.abs(found - wanted).max(initial=0.0) / size
    return result


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
    derivative = solution.derivative("friction")
    at_edge = float(derivative.slip_rate(1e-8, 1.0))
    assert derivative.edge_slip_rate == pytest.approx(at_edge, rel=1e-6)


@pytest.mark.thinned(27)
@over("exact", without="stuck slides")
def test_differences_of_solutions_agree(problem):
    solution = solve(problem.scene, rtol=1e-11)
    name = NAMES[len(problem.name) % len(NAMES)]
    if problem.scene.coefficient == 0:
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
    found, parts = remote.derivative(name), [slot.derivative(point) for point in whole]
    assert found.status == "converged"
    x, t = clear_positions(remote), np.array([[0.8], [1.0]])
    for field in FIELDS:
        expected = sum(getattr(part, field)(x, t) for part in parts)
        size = np.abs(expected).max()
        np.testing.assert_allclose(getattr(found, field)(x, t), expected, atol=1e-8 * size)
    np.testing.assert_allclose(edges_of(found), sum(map(edges_of, parts)), atol=1e-8)
    early = getattr(found, {"shear": "shear_traction"}.get(kind, kind))(x, -1.0)
    np.testing.assert_array_equal(early, float(part == "base"))


def unpressed(scene, name):
    """Whether nothing presses the interface, which has no derivative with respect to pressures."""
    return name in ("base_pressure", "load_pressure") and not scene.superposition.in_place.pressure


@pytest.mark.slow
def test_differences_of_solutions_agree_in_random_scenes():
    """With respect to two of the parameters in each, in turn."""
    count, compared = len(NAMES), 0
    for index, exact in enumerate(random_scenes(25, rtol=1e-11)):
        for name in (NAMES[index % count], NAMES[(index + count // 2) % count]):
            found = None if unpressed(exact.scene, name) else errors(exact, name)
            if found is not None:
                compared += 1
                assert max(found.values()) < 1e-8, (name, found, exact.scene)
    assert compared >= 20


def check_homogeneity(solution, x):
    """Slip and shear are of degree 1 in all tractions, and functions of friction times pressure,
    within what the error estimates of the derivatives allow."""
    scene, names = solution.scene, [n for n in TRACTIONS if parameter(solution.scene, n)]
    parts = {name: solution.derivative(name) for name in names}
    if scene.coefficient and solution.zones:
        parts["friction"] = solution.derivative("friction")
    assert max(part.error_estimate for part in parts.values()) < 1e-5
    for field in ("slip_rate", "slip", "shear_traction"):
        own = getattr(solution, field)(x, 1.0)
        each = {n: parameter(scene, n) * getattr(part, field)(x, 1.0) for n, part in parts.items()}
        size = np.abs(own).max(initial=0.0)
        allowed = {
            n: part.error_estimate * max(np.abs(each[n]).max(initial=0.0), size)
            for n, part in parts.items()
        }
        rest = sum(each[name] for name in names) - own
        assert np.abs(rest).max() <= sum(allowed[name] for name in names), (field, scene)
        if "friction" in parts:
            pressed = [name for name in names if name.endswith("pressure")]
            rest = each["friction"] - sum(each[name] for name in pressed)
            bound = allowed["friction"] + sum(allowed[name] for name in pressed)
            assert np.abs(rest).max() <= bound, (field, scene)


@pytest.mark.thinned(9)
@over("exact", without="stuck")
def test_shear_is_homogeneous_in_tractions(problem):
    solution, scene = solve(problem.scene), problem.scene
    check_homogeneity(solution, clear_positions(solution))
    moves = [parameter(scene, name) * edges_of(solution.derivative(name)) for name in TRACTIONS]
    np.testing.assert_allclose(sum(moves), 0, atol=1e-7 * scene.material.shear_speed)


FILM = unit_scene(0.5, law=Coulomb(1.0, viscosity=0.2))
ALONG_Z = unit_scene(0.5, mode="antiplane")
SLIDING_FILM = unit_scene(
    0.3095, (0, 0), (1.0, -0.4059), nu=0.1542, mode="antiplane", load_on="remote"
)
BEHIND_A_FRONT = unit_scene(
    0.6437263231181864, (1.0, 0.6437263231181864), (1.0, 0.7377745962954552)
)
"""Slips right behind the longitudinal front."""
EDGE_OPENS = unit_scene(0.5, (1.0, 0.1), (-1.0, 1.0))
TAPPED = unit_scene(0.3, (0.02, 0.002), (1.0, 0.5))
FILM_OPENS = unit_scene(0.3, load=(-1.0, 1.0), law=Coulomb(1.0, viscosity=0.25))
FILM_TAPPED = replace(FILM_OPENS, base=Tractions(0.02, 0.0), load=Tractions(1.0, 0.5))


def check_differences(scene, name, most=1e-8):
    found = errors(solve(scene, rtol=1e-11), name)
    assert found is not None
    assert max(found.values()) < most, found


@pytest.mark.thinned(5)
@pytest.mark.parametrize(
    ("scene", "name"),
    [
        # stick from the shear front to the zone is wide: 23,000 times the slowness of the front
        (
            unit_scene(1.9945514157984439, (0.52558377691034, 0.0), (0.0, 0.009061643), nu=-0.69),
            "poisson_ratio",
        ),
        (ALONG_Z, "friction"),
        (replace(ALONG_Z, base=Tractions(1.0, 0.1), load=Tractions(0.4, 1.0)), "load_pressure"),
        (FILM, "poisson_ratio"),
        (replace(FILM, friction=Coulomb(0.4, viscosity=0.2), mode="antiplane"), "viscosity"),
        (FILM, "viscosity"),
        # stick behind a longitudinal zone, whose slope bends slowly all the way from the edge
        (
            unit_scene(
                0.16008413167845315, (1.7499937632324243, 0.2801462320297712), (1.0, -1.5025)
            ),
            "poisson_ratio",
        ),
        (BEHIND_A_FRONT, "poisson_ratio"),
        # next to the shear front, over distances as small, V turns from a square root to finite
        *(
            (under(SLIDING_FILM, Coulomb(1.0, viscosity=viscosity)), "poisson_ratio")
            for viscosity in (1e-2, 1e-4, 1e-6)
        ),
    ],
)
def test_differences_of_solutions_agree_in_scenes_that_are_hard_to_difference(scene, name):
    check_differences(scene, name, 1e-9 if scene is BEHIND_A_FRONT else 1e-8)


@pytest.mark.thinned(16)
@pytest.mark.parametrize(
    ("scene", "name"),
    [
        *((EDGE_OPENS, name) for name in NAMES),
        (TAPPED, "friction"),
        (TAPPED, "base_pressure"),
        (TAPPED, "poisson_ratio"),
        (unit_scene(0.3, (0.02, 0.004), (1.0, 0.5), mode="antiplane"), "base_pressure"),
        (replace(TAPPED, mode="antiplane"), "friction"),  # an edge 1.5e-6 behind an end of a panel
        (replace(TAPPED, friction=3.0), "load_pressure"),  # sticks behind the closing edge
        # exponents change with viscosity
        *((FILM_OPENS, name) for name in ("viscosity", "friction", "base_pressure")),
        (FILM_TAPPED, "viscosity"),
    ],
)
def test_differences_of_solutions_agree_where_the_contact_opens(scene, name):
    check_differences(scene, name)


def test_an_opening_from_the_edge_moves_as_its_closed_form():
    """c_t sqrt((1 - 2 nu) / (2 (1 - nu))) / ((1 - nu) (1 + P_b / |P_0|)^2)."""
    solution = solve(unit_scene(0.5, load=(-1.0, 0.0)))
    for name, expected in (("base_pressure", -0.1875), ("load_pressure", -0.1875), ("friction", 0)):
        (moved,) = solution.derivative(name).openings
        assert moved.inner == 0
        assert moved.outer == pytest.approx(expected, rel=1e-9)
    by_ratio = solution.derivative("poisson_ratio").openings[0].outer
    assert by_ratio == pytest.approx(0.1875 * (1.5 - 3 + 0.75), rel=1e-8)
    assert "one-sided: with any shear" in solution.derivative("load_shear").status


@pytest.mark.thinned(20)
@pytest.mark.parametrize(
    "scene",
    [
        unit_scene(0.5, (1.0, 0.5), (0.6, -1.0)),
        unit_scene(0.5, (1.0, 0.5), (0.0, 1.0)),
        unit_scene(0.3, (1.0, -0.3), (0.5, -0.7), nu=0.1),
        unit_scene(0.5, (1.0, 0.5), (1.0, 0.5)),
        unit_scene(0.4, (1.0, 0.4), (0.5, 1.0), law=Coulomb(1.0, viscosity=0.2)),
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
            beside = solve(
                override_scene(scene, **{name: parameter(scene, name) + sign * step}), rtol=1e-12
            )
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
    with pytest.raises(SceneError, match="the base is at friction, and in antiplane"):
        antiplane.derivative("friction")


def test_slip_rate_changes_infinitely_fast_at_its_edges():
    solution = solve(PRELOADED)
    inner, outer = solution.zones
    just_behind = np.array([inner.outer, outer.outer]) * (1 - 1e-13)
    slow, fast = solution.derivative("friction").slip_rate(just_behind, 1.0)
    assert slow < -1e4
    assert fast < -10


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
        first, other = steel.derivative(name), unit.derivative(name)
        rate = stress / STEEL.shear_impedance / per
        for found, expected in (
            (first.slip_rate(x * speed * t, t), rate * other.slip_rate(x, 1.0)),
            (first.slip(x * speed * t, t), rate * t * other.slip(x, 1.0)),
            (first.shear_traction(x * speed * t, t), stress / per * other.shear_traction(x, 1.0)),
            (edges_of(first), speed / per * edges_of(other)),
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
    with pytest.raises(SceneError, match="needs friction with"):
        solve(PRELOADED).derivative("viscosity")
    law = RateWeakening(1.0, 0.5, 1.24)
    weakening = unit_scene(0.607, (1, 0), (0, -0.504), law=law)
    for name in NAMES:
        with pytest.raises(SceneError, match="constant and viscous friction only"):
            solve(weakening).derivative(name)
    tapped = solve(unit_scene(0.3, (0.02, 0.004), (1.0, 0.5), mode="antiplane"))
    with pytest.raises(SceneError, match="the gap is that of the same scene in plane strain"):
        tapped.derivative("base_pressure").gap(1.0, 1.0)
    with pytest.raises(SceneError, match="positive positions"):
        solve(PRELOADED).derivative("friction").slip_rate(-1.0, 1.0)
