"""Derivatives of solved pairs: differences of solutions, scaling laws, identical bodies, limits."""

from functools import lru_cache

import numpy as np
import pytest

from compare.studies.dissimilar.pairs import SCENES
from semianalytic import Material, Pair, Scene, SceneError, Tractions, solve, solve_pair
from semianalytic.dissimilar.pair import PARAMETERS, changed, parameter_of

FIELDS = ("slip_rate", "gap_rate", "slip", "gap", "shear_traction", "pressure")
SOLID = Material(1.0, 1.0, 0.25)


@lru_cache
def answer_of(name):
    return solve_pair(SCENES[name], rtol=1e-9)


@lru_cache
def derivative_of(name, parameter):
    return answer_of(name).derivative(parameter)


def places(answer, count=60):
    """Positions at t = 1 away from edges and fronts."""
    pair = answer.pair
    marks = [v for zone in (*answer.zones, *answer.openings) for v in (zone.inner, zone.outer)]
    for body in (pair.upper, pair.lower):
        marks += [body.longitudinal_speed, body.shear_speed]
    x = np.linspace(0.01, 1.2 * max(marks), 4 * count)
    apart = np.min(np.abs(np.subtract.outer(marks, x)), axis=0)
    return x[apart > 0.05 * min(pair.upper.shear_speed, pair.lower.shear_speed)][::4]


CASES = [
    ("film", "viscosity"),
    ("slip from the slot", "friction"),
    ("slip and opening", "load_shear"),
    ("slip from the slot", "lower_shear_modulus"),
    ("film", "base_shear"),
    ("slip and opening", "lower_density"),
]


@pytest.mark.thinned(6)
@pytest.mark.parametrize(("name", "parameter"), CASES)
def test_differences_of_solutions_agree(name, parameter):
    answer, derivative = answer_of(name), derivative_of(name, parameter)
    pair, x = answer.pair, places(answer)
    value = parameter_of(pair, parameter)
    step = 2e-4 * max(abs(value), 1.0)
    points, weights = (-2, -1, 1, 2), np.array([1.0, -8.0, 8.0, -1.0]) / (12 * step)
    beside = [
        solve_pair(changed(pair, parameter, value + step * point), rtol=1e-10) for point in points
    ]
    assert derivative.status == "converged"
    for end in ("inner", "outer"):
        found = [getattr(zone, end) for zone in derivative.zones]
        edges = weights @ [[getattr(zone, end) for zone in one.zones] for one in beside]
        np.testing.assert_allclose(found, edges, rtol=1e-5, atol=1e-7)
    for field in FIELDS:
        expected = weights @ np.array([getattr(one, field)(x, 1.0) for one in beside])
        size = np.abs(expected).max()
        np.testing.assert_allclose(
            getattr(derivative, field)(x, 1.0), expected, atol=2e-6 * (size or 1.0)
        )


@pytest.mark.thinned(4)
@pytest.mark.parametrize("name", ["slip from the slot", "slip and opening"])
@pytest.mark.parametrize(
    ("parameters", "degrees"),
    [
        # twice all moduli and densities halve slip, and leave edges and tractions
        (
            ("shear_modulus", "density", "lower_shear_modulus", "lower_density"),
            (-1, -1, -1, -1, 0, 0),
        ),
        # twice all tractions double all fields, and leave edges
        (("base_pressure", "base_shear", "load_pressure", "load_shear"), (1,) * 6),
    ],
    ids=["bodies", "tractions"],
)
def test_answers_are_homogeneous(name, parameters, degrees):
    """Euler: the sum of parameters times derivatives is the field times its degree."""
    answer = answer_of(name)
    x, pair = places(answer), answer.pair
    parts = [(parameter_of(pair, one), derivative_of(name, one)) for one in parameters]
    for field, degree in zip(FIELDS, degrees, strict=True):
        total = sum(value * getattr(derivative, field)(x, 1.0) for value, derivative in parts)
        values = getattr(answer, field)(x, 1.0)
        within = 1e-7 if degree == 1 else 1e-6
        np.testing.assert_allclose(
            total, degree * values, atol=within * (np.abs(values).max() or 1)
        )
    for index, zone in enumerate(answer.zones):
        moved = sum(value * derivative.zones[index].outer for value, derivative in parts)
        assert abs(moved) < 1e-7 * zone.outer
    edge = sum(value * derivative.edge_slip_rate for value, derivative in parts)
    assert edge == pytest.approx(degrees[0] * answer.edge_slip_rate, rel=1e-6)


@lru_cache
def of_identical_bodies():
    """The answers of both solvers to a scene that opens."""
    base, load = Tractions(2.4, 0.0), Tractions(-0.2, 1.0)
    one = solve(Scene(SOLID, 0.5, base, load), rtol=1e-10)
    return one, solve_pair(Pair(SOLID, SOLID, 0.5, base, load), rtol=1e-9)


@lru_cache
def derivatives_of_identical_bodies(parameter):
    return [answer.derivative(parameter) for answer in of_identical_bodies()]


@pytest.mark.thinned(3)
@pytest.mark.parametrize("parameter", ["base_pressure", "friction", "load_shear"])
def test_identical_bodies_have_the_derivatives_of_the_other_solver(parameter):
    theirs, ours = derivatives_of_identical_bodies(parameter)
    assert ours.zones[0].outer == pytest.approx(theirs.zones[0].outer, rel=1e-7)
    assert ours.openings[0].outer == pytest.approx(theirs.openings[0].outer, rel=1e-5, abs=1e-9)
    x = np.array([0.05, 0.1, 0.2, 0.45, 0.6, 1.3, 1.6])
    for field in ("slip_rate", "slip", "shear_traction", "pressure"):
        expected = getattr(theirs, field)(x, 1.0)
        size = np.abs(expected).max() or 1.0
        np.testing.assert_allclose(getattr(ours, field)(x, 1.0), expected, atol=1e-6 * size)


def test_an_estimate_bounds_the_error_and_is_small():
    derivative = derivative_of("slip from the slot", "friction")
    assert 1e-9 <= derivative.error_estimate < 1e-6
    assert "friction" in repr(derivative)


def test_open_parts_carry_nothing_and_base_tractions_are_there_from_the_outset():
    _, derivative = derivatives_of_identical_bodies("base_pressure")
    (opening,) = of_identical_bodies()[1].openings
    inside, outside = opening.outer / 2, 1.2 * opening.outer
    assert derivative.pressure(inside, 1.0) == 0
    assert derivative.shear_traction(inside, 1.0) == 0
    assert derivative.gap(inside, 1.0) != 0
    assert derivative.gap(outside, 1.0) == 0
    assert derivative.pressure(0.5, -1.0) == 1
    assert derivative.slip_rate(0.5, -1.0) == 0
    assert derivative.pressure(9.0, 1.0) == pytest.approx(1.0, abs=1e-9)


def test_what_has_no_derivative_is_refused_in_one_sentence():
    answer = answer_of("slip from the slot")
    with pytest.raises(SceneError, match="name must be one of friction, viscosity, base_pressure"):
        answer.derivative("weight")
    with pytest.raises(SceneError, match="needs ViscousFriction of a positive viscosity"):
        answer.derivative("viscosity")
    with pytest.raises(SceneError, match="positive positions"):
        derivative_of("slip from the slot", "friction").slip_rate(-1.0, 1.0)
    assert len(PARAMETERS) == 12
