"""Derivatives of solutions: closed forms, differences of solutions, homogeneity, and refusals."""

from dataclasses import replace
from time import perf_counter

import numpy as np
import pytest
from catalogue import PRELOADED, SHOCK, STEEL, UNIT, over, unit_scene
from laws import random_scenes

from semianalytic import (
    Material,
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
    scale |= {field: solution.stress for field in ("shear_traction", "pressure")}
    unit = 1.0 if name in ("friction", "poisson_ratio") else solution.stress
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
        for name in names_of(index):
            found = errors(exact, name)
            if found is not None:
                compared += 1
                assert max(found.values()) < 1e-8, (name, found, exact.scene)
    return compared


def test_differences_of_solutions_agree_in_random_scenes():
    assert check_random_scenes(25, lambda index: [NAMES[index % len(NAMES)]]) >= 12


@pytest.mark.slow
def test_differences_of_solutions_agree_in_two_hundred_scenes():
    assert check_random_scenes(200, lambda index: NAMES) >= 600
