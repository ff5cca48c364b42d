"""Fields in both bodies of a solved pair, and its derivatives: limits, laws, mirrors, scaling."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from docs.studies.dissimilar.pairs import SCENES, random_pair
from semianalytic import Material, Scene, SceneError, Tractions, solve
from semianalytic.dissimilar.pair import PARAMETERS
from semianalytic.dissimilar_slot.solver import coupled
from semianalytic.parameters.numbers import numbers_of, with_numbers
from tests.semianalytic.field.body_fields import (
    check_faces,
    departures_from_laws,
    edges_of,
    smooth_points,
)

SOLID = Material(1.0, 1.0, 0.25)
KINDS = list(SCENES)
FEW = ("slip and opening", "film")
INTERFACE_FIELDS = ("slip_rate", "gap_rate", "slip", "gap", "shear_traction", "pressure")
CASES = [
    ("slip from the slot", "lower_shear_modulus"),
    ("film", "viscosity"),
    ("slip from the slot", "friction"),
    ("slip and opening", "load_shear"),
    ("film", "base_shear"),
    ("slip and opening", "lower_density"),
]


@lru_cache
def answer_of(name, rtol=1e-8):
    return solve(SCENES[name], rtol=rtol)


def speeds(pair):
    """Speeds of all waves: P and S of the upper and of the lower body."""
    return [
        speed
        for body in (pair.material, pair.lower_material)
        for speed in (body.longitudinal_speed, body.shear_speed)
    ]


def places(answer, count=200):
    """Positions along the interface at t = 1, away from zone edges."""
    edges = edges_of(answer)
    x = np.random.default_rng(2).uniform(0.01, 1.2 * max(speeds(answer.scene)), 4 * count)
    apart = np.min(np.abs(np.subtract.outer([*edges, 0.0], x)), axis=0)
    return x[apart > 0.03 * min(speeds(answer.scene))][:count]


@pytest.mark.parametrize(
    "name", [pytest.param(kind, marks=[pytest.mark.slow] * (kind not in FEW)) for kind in KINDS]
)
def test_faces_move_and_carry_what_the_interface_does(name):
    answer = answer_of(name)
    check_faces(answer, places(answer), 1.0, 3 * answer.error_estimate)


@pytest.mark.parametrize("name", FEW)
def test_slot_faces_carry_the_load_alone(name):
    answer, x = answer_of(name), np.linspace(-5.0, -0.01, 101)
    held, load = answer.scene.base, answer.scene.load
    for face in (0.0, -0.0):
        stress = answer.stress(x, face, 1.0)
        np.testing.assert_allclose(stress[2], held.shear - load.shear, atol=1e-10)
        np.testing.assert_allclose(-stress[1], held.pressure - load.pressure, atol=1e-10)


@lru_cache
def of_identical_bodies(friction=0.5, base=(2.4, 0.0), load=(-0.2, 1.0)):
    """The answers of both solvers; to a scene that opens unless told otherwise."""
    base, load = Tractions(*base), Tractions(*load)
    answer = solve(Scene(SOLID, friction, base, load), rtol=1e-10)
    return answer, coupled(Scene(SOLID, friction, base, load, lower_material=SOLID), 1e-9)


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    "given",
    [
        (),
        (0.5, (1.6, 0.0), (0.0, 1.0)),
        (0.5, (1.0, 0.0), (-1.5, 0.3)),
        (9.0, (3.0, 0.1), (1.0, -0.4)),
    ],
)
def test_identical_bodies_have_the_fields_of_the_other_solver(given):
    first, two = of_identical_bodies(*given)
    at = *np.random.default_rng(1).uniform(-2, 2, (2, 300)), 1.0
    for field in ("velocity", "stress", "displacement"):
        known = getattr(first, field)(*at)
        np.testing.assert_allclose(getattr(two, field)(*at), known, rtol=1e-9, atol=1e-9)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["two zones", "slip and opening, reversed"])
def test_exchanged_bodies_have_mirrored_fields(name):
    answer = answer_of(name)
    pair, far = answer.scene, max(speeds(answer.scene))
    # seen from below y points the other way: sigma_xy changes its sign, sigma_yy does not
    base, load = (Tractions(entry.pressure, -entry.shear) for entry in (pair.base, pair.load))
    upper, lower = pair.bodies
    other = solve(replace(pair, material=lower, lower_material=upper, base=base, load=load))
    x, y = np.random.default_rng(3).uniform(-far, far, (2, 40))
    for field, signs in (("velocity", (1, -1)), ("stress", (1, 1, -1)), ("displacement", (1, -1))):
        mirrored = np.array(signs)[:, None] * getattr(other, field)(x, -y, 1.0)
        np.testing.assert_allclose(getattr(answer, field)(x, y, 1.0), mirrored, atol=1e-11)


def faults(answer, upper, lower):
    """Departures from six laws in the upper body, and in the lower one, of supposed materials."""
    worst = []
    for body, side in ((upper, 1), (lower, -1)):
        at = smooth_points(answer, body, speeds(answer.scene), side=side)
        worst.append(departures_from_laws(answer, at, body, 0.002 * body.shear_speed))
    return np.concatenate(worst)


@pytest.mark.parametrize("name", ["two zones", "slip and opening"])
def test_fields_obey_the_equation_of_motion_and_hookes_law(name):
    answer = answer_of(name)
    assert faults(answer, answer.scene.material, answer.scene.lower_material).max() < 2e-6


def test_laws_of_a_body_tell_that_its_material_is_three_percent_off():
    answer = answer_of("slip and opening")
    lower = answer.scene.lower_material
    stiffer = Material(1.03 * lower.shear_modulus, lower.density, lower.poisson_ratio)
    heavier = Material(lower.shear_modulus, 1.03 * lower.density, lower.poisson_ratio)
    for wrong in (stiffer, heavier):
        worst = faults(answer, answer.scene.material, wrong)
        assert worst[:6].max() < 2e-6
        assert worst[6:].max() > 1e-3


def test_waves_along_the_faster_body_send_head_waves_into_the_slower_one():
    # x = 2 lies ahead of all waves of the slower body, and of P waves of the faster one there.
    answer = answer_of("slip and opening")
    upper, lower = answer.scene.material, answer.scene.lower_material
    x, fast = 2.3, lower.longitudinal_speed
    assert upper.longitudinal_speed < x < fast
    rise = np.sqrt(1 / upper.longitudinal_speed**2 - 1 / fast**2)
    y = (1 - x / fast) / rise
    before, after = answer.velocity(x, [1.001 * y, 0.9 * y], 1.0).T
    np.testing.assert_array_equal(before, 0.0)
    assert np.abs(after).max() > 1e-4


def test_plane_waves_follow_behind_the_slot_at_the_speeds_of_each_body():
    pair = SCENES["slip and opening"]
    answer, x = answer_of("slip and opening"), -50.0
    for body, side in ((pair.material, 1), (pair.lower_material, -1)):
        y = side * 0.9 * body.shear_speed
        v_x, v_y = answer.velocity(x, y, 1.0)
        assert v_x == pytest.approx(side * pair.load.shear / body.shear_impedance, abs=1e-12)
        impedance = body.density * body.longitudinal_speed
        assert v_y == pytest.approx(-side * pair.load.pressure / impedance, abs=1e-12)
    ahead = answer.stress(50.0, [0.5, -0.5], 1.0)
    np.testing.assert_array_equal(ahead, [[0.0, 0.0], [-1.5, -1.5], [0.0, 0.0]])


@pytest.mark.parametrize(
    "name", ["slip and opening", pytest.param("detached opening", marks=pytest.mark.slow)]
)
def test_fields_depend_on_x_and_y_over_t_and_rest_before(name):
    answer = answer_of(name)
    x, y = np.random.default_rng(6).uniform(-1.5, 1.5, (2, 40))
    for field, power in (("velocity", 0), ("stress", 0), ("displacement", 1)):
        ask = getattr(answer, field)
        np.testing.assert_allclose(
            ask(3e4 * x, 3e4 * y, 3e4), 3e4**power * ask(x, y, 1.0), rtol=1e-8, atol=1e-9
        )
    np.testing.assert_array_equal(answer.velocity(x, y, 0.0), 0.0)
    np.testing.assert_array_equal(answer.displacement(x, y, -1.0), 0.0)
    np.testing.assert_array_equal(answer.stress(x, y, 0.0)[1], -answer.scene.base.pressure)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3, 5])
def test_error_of_fields_is_honest_on_random_pairs(seed):
    rng = np.random.default_rng(seed)
    while True:
        pair = random_pair(rng)
        try:
            fine = solve(pair, rtol=1e-9)
        except SceneError:
            continue
        break
    x, y = rng.uniform(-1.0, 1.0, (2, 100)) * max(speeds(pair))
    impedance = np.where(y > 0, pair.material.shear_impedance, pair.lower_material.shear_impedance)
    for rtol in (1e-4, 1e-6):
        answer = solve(pair, rtol=rtol)
        if len(answer.zones) != len(fine.zones):
            continue
        for field, unit in (("velocity", impedance), ("stress", 1.0)):
            first, other = (unit * getattr(a, field)(x, y, 1.0) for a in (answer, fine))
            error = np.abs(first - other) / (fine.stress_unit + np.abs(other))
            assert error.max() < answer.field_error < 10 * rtol


def test_what_is_infinite_says_so():
    answer = answer_of("slip from the slot")
    for body, face in ((answer.scene.material, 0.0), (answer.scene.lower_material, -0.0)):
        assert np.isinf(answer.velocity(-body.rayleigh_speed, face, 1.0)).all()
        assert np.isfinite(answer.velocity(-1.1 * body.rayleigh_speed, face, 1.0)).all()
    assert np.isfinite(answer.displacement(0.0, 0.0, 1.0)).all()
    with pytest.raises(SceneError, match="finite"):
        answer.stress(np.nan, 0.0, 1.0)


@lru_cache
def derivative_of(name, parameter):
    return answer_of(name, 1e-9).derivative(parameter)


def positions(answer, count=60):
    """Positions at t = 1 away from edges and fronts."""
    marks = [*edges_of(answer), *speeds(answer.scene)]
    x = np.linspace(0.01, 1.2 * max(marks), 4 * count)
    apart = np.min(np.abs(np.subtract.outer(marks, x)), axis=0)
    return x[apart > 0.05 * min(speeds(answer.scene))][::4]


@pytest.mark.thinned(6)
@pytest.mark.parametrize(("name", "parameter"), CASES)
def test_differences_of_solutions_agree(name, parameter):
    answer, derivative = answer_of(name, 1e-9), derivative_of(name, parameter)
    pair, x = answer.scene, positions(answer)
    value = numbers_of(pair)[parameter].value
    step = 2e-4 * max(abs(value), 1.0)
    points, weights = (-2, -1, 1, 2), np.array([1.0, -8.0, 8.0, -1.0]) / (12 * step)
    beside = [
        solve(with_numbers(pair, {parameter: value + step * point}), rtol=1e-10) for point in points
    ]
    assert derivative.status == "converged"
    for end in ("inner", "outer"):
        found = [getattr(zone, end) for zone in derivative.zones]
        edges = weights @ [[getattr(zone, end) for zone in station.zones] for station in beside]
        np.testing.assert_allclose(found, edges, rtol=1e-5, atol=1e-7)
    for field in INTERFACE_FIELDS:
        expected = weights @ np.array([getattr(station, field)(x, 1.0) for station in beside])
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
    answer = answer_of(name, 1e-9)
    x, pair = positions(answer), answer.scene
    parts = [(numbers_of(pair)[entry].value, derivative_of(name, entry)) for entry in parameters]
    for field, degree in zip(INTERFACE_FIELDS, degrees, strict=True):
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
def derivatives_of_identical_bodies(parameter):
    return [answer.derivative(parameter) for answer in of_identical_bodies()]


@pytest.mark.slow
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
    derivative = derivative_of("slip from the slot", "lower_shear_modulus")
    assert 1e-9 <= derivative.error_estimate < 1e-6
    assert "lower_shear_modulus" in repr(derivative)


def test_open_parts_carry_nothing_and_base_tractions_are_there_from_the_outset(monkeypatch):
    # a loose rule, since what is asked here holds on any
    monkeypatch.setattr("semianalytic.dissimilar_slot.derivative._TOLERANCE", 1e-7)
    by_base = of_identical_bodies()[1].derivative("base_pressure")
    (opening,) = of_identical_bodies()[1].openings
    inside, outside = opening.outer / 2, 1.2 * opening.outer
    assert by_base.pressure(inside, 1.0) == 0
    assert by_base.shear_traction(inside, 1.0) == 0
    assert by_base.gap(inside, 1.0) != 0
    assert by_base.gap(outside, 1.0) == 0
    assert by_base.pressure(0.5, -1.0) == 1
    assert by_base.slip_rate(0.5, -1.0) == 0
    assert by_base.pressure(9.0, 1.0) == pytest.approx(1.0, abs=1e-9)


def test_what_has_no_derivative_is_refused_in_one_sentence():
    answer = answer_of("slip from the slot", 1e-9)
    with pytest.raises(SceneError, match="name must be one of friction, viscosity, base_pressure"):
        answer.derivative("weight")
    with pytest.raises(SceneError, match="needs friction of a positive viscosity"):
        answer.derivative("viscosity")
    with pytest.raises(SceneError, match="positive positions"):
        derivative_of("slip from the slot", "lower_shear_modulus").slip_rate(-1.0, 1.0)
    assert len(PARAMETERS) == 12
