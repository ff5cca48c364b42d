"""Derivatives by what scaling alone says of them: where a film opens, above all.

Slip and shear of a scene double with all of its tractions, and stay as they are when friction is
halved while pressures double.
"""

from dataclasses import replace

import numpy as np
import pytest
from laws import opening_scene

from semianalytic import Material, Scene, Tractions, ViscousFriction, solve

TRACTIONS = ("base_pressure", "base_shear", "load_pressure", "load_shear")
PRESSURES = ("base_pressure", "load_pressure")
FIELDS = ("slip_rate", "slip", "shear_traction")
CLEAR = 0.03
"""Distance from edges and fronts, over c_t, from which the estimates of derivatives hold."""


def value(scene, name):
    if name == "friction":
        return scene.friction
    if name == "viscosity":
        return scene.friction_law.viscosity
    part, kind = name.split("_")
    return getattr(getattr(scene, part), kind)


def clear_positions(solution):
    """x at t = 1 away from edges of zones and openings, and from wave fronts."""
    material = solution.scene.material
    edges = [*solution.zones, *solution.openings]
    marks = [speed for one in edges for speed in (one.inner, one.outer) if np.isfinite(speed)]
    marks += [material.longitudinal_speed, material.shear_speed, material.rayleigh_speed]
    x = np.linspace(0.02, 1.05, 60) * material.longitudinal_speed
    return x[np.abs(x[:, None] - np.array(marks)).min(axis=1) > CLEAR * material.shear_speed]


def left(solution, names, degree, x):
    """What of each field is left of sum(parameter * derivative) - degree * field, largest over x,
    over what the error estimates of the derivatives allow for it."""
    scene, result = solution.scene, {}
    names = [name for name in names if value(scene, name)]
    derivatives = [solution.derivative(name) for name in names]
    for field in FIELDS:
        own = getattr(solution, field)(x, 1.0)
        parts = [
            value(scene, name) * getattr(one, field)(x, 1.0)
            for name, one in zip(names, derivatives, strict=True)
        ]
        size = np.abs(own).max(initial=0.0)
        allowed = sum(
            one.error_estimate * max(np.abs(part).max(initial=0.0), size)
            for one, part in zip(derivatives, parts, strict=True)
        )
        rest = np.abs(sum(parts) - degree * own).max(initial=0.0)
        result[field] = rest / allowed if allowed else 0.0
    return result


def check_scaling(solution):
    x = clear_positions(solution)
    assert max(left(solution, TRACTIONS, 1, x).values()) < 1, solution.scene
    if not solution.zones:
        return
    pressed = [name for name in PRESSURES if value(solution.scene, name)]
    both = {name: solution.derivative(name) for name in ("friction", *pressed)}
    for field in FIELDS:
        by_friction, *rest = (
            value(solution.scene, name) * getattr(one, field)(x, 1.0) for name, one in both.items()
        )
        size = np.abs(getattr(solution, field)(x, 1.0)).max()
        size = max(size, *(np.abs(part).max() for part in rest))
        allowed = sum(one.error_estimate for one in both.values()) * size
        assert np.abs(by_friction - sum(rest)).max() <= allowed, (field, solution.scene)


def film(viscosity, base, load, friction=0.3, **rest):
    law, steel = ViscousFriction(viscosity), Material(1.0, 1.0, 1 / 3)
    return Scene(steel, friction, Tractions(*base), Tractions(*load), friction_law=law, **rest)


FILMS = [
    film(0.25, (1.0, 0.0), (-1.0, 1.0)),
    film(0.25, (0.02, 0.0), (1.0, 0.5)),
    film(2.0, (0.1, 0.0), (-1.0, 1.0)),
    film(0.5, (0.04, 0.01), (1.0, -0.5), 2.0),
]


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
@pytest.mark.parametrize("scene", FILMS)
def test_derivatives_of_films_that_open_scale(scene, mode):
    solution = solve(replace(scene, mode=mode), rtol=1e-9)
    assert max(solution.derivative(name).error_estimate for name in TRACTIONS) < 1e-6
    check_scaling(solution)


NARROW = Scene(
    Material(1.0, 1.0, 0.21895406400607864),
    0.5637930049379278,
    Tractions(0.014514166711870372, 0.0003704862626682042),
    Tractions(-1.0, 0.0),
    mode="antiplane",
)
"""Slips ahead of its opening on a strip 0.0015 c_t wide."""


@pytest.mark.thinned(2)
@pytest.mark.parametrize("viscosity", [0.0, 0.0015668623422475361])
def test_derivatives_scale_on_a_narrow_strip_ahead_of_an_opening(viscosity):
    """A step of its edge is to be short against the strip, not against the way to a front."""
    solution = solve(replace(NARROW, friction_law=ViscousFriction(viscosity)), rtol=1e-9)
    assert solution.zones[-1].outer - solution.openings[0].outer < 2e-3
    assert solution.derivative("base_shear").error_estimate < 1e-6
    check_scaling(solution)


def random_film(seed):
    """A film that opens, in plane or out of it."""
    random = np.random.default_rng(seed)
    scene, viscosity = opening_scene(random), 10 ** random.uniform(-3, 1)
    mode = ("in-plane", "antiplane")[seed % 2]
    return replace(scene, friction_law=ViscousFriction(float(viscosity)), mode=mode)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_derivatives_of_random_films_that_open_scale(seed):
    solution = solve(random_film(seed), rtol=1e-9)
    assert solution.openings
    check_scaling(solution)


@pytest.mark.thinned(6)
@pytest.mark.parametrize("name", ["viscosity", "friction", "base_pressure"])
@pytest.mark.parametrize("scene", FILMS[:2])
def test_derivatives_of_films_that_open_agree_with_differences(scene, name):
    """With those of fourth order, of solutions to 1e-11; exponents change with viscosity."""
    solution = solve(scene, rtol=1e-9)
    derivative, x = solution.derivative(name), clear_positions(solution)
    number = value(scene, name)
    step = 1e-3 * number
    expected = dict.fromkeys(FIELDS, 0.0)
    for steps, weight in ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12)):
        beside = number + steps * step
        if name == "viscosity":
            other = replace(scene, friction_law=ViscousFriction(beside))
        elif name == "friction":
            other = replace(scene, friction=beside)
        else:
            other = replace(scene, base=replace(scene.base, pressure=beside))
        one = solve(other, rtol=1e-11)
        for field in FIELDS:
            expected[field] = expected[field] + weight / step * getattr(one, field)(x, 1.0)
    for field, wanted in expected.items():
        error = np.abs(getattr(derivative, field)(x, 1.0) - wanted).max()
        size = max(np.abs(wanted).max(), np.abs(getattr(solution, field)(x, 1.0)).max() / number)
        assert error < max(derivative.error_estimate, 1e-8) * size, field
