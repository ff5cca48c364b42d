"""Derivatives by what scaling alone says of them, where a film opens above all; and those of bases
at friction, and of ones that lack so little that differences do not see.

Slip and shear of a scene double with all of its tractions, and stay as they are when friction is
halved while pressures double.
"""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import under, unit_scene
from laws import opening_scene

from semianalytic import Coulomb, solve
from tests.semianalytic.selfsimilar.derivatives.test_derivative import (
    check_homogeneity,
    clear_positions,
)

CLEAR = 0.03
"""Distance from edges and fronts, over c_t, from which the estimates of derivatives hold."""


NARROW = unit_scene(
    0.5637930049379278,
    (0.014514166711870372, 0.0003704862626682042),
    (-1.0, 0.0),
    nu=0.21895406400607864,
    mode="antiplane",
)
"""Slips ahead of its opening on a strip 0.0015 c_t wide."""


@pytest.mark.thinned(2)
@pytest.mark.parametrize("viscosity", [0.0, 0.0015668623422475361])
def test_derivatives_scale_on_a_narrow_strip_ahead_of_an_opening(viscosity):
    """A step of its edge is to be short against the strip, not against the way to a front."""
    solution = solve(under(NARROW, Coulomb(1.0, viscosity=viscosity)), rtol=1e-9)
    assert solution.zones[-1].outer - solution.openings[0].outer < 2e-3
    assert solution.derivative("base_shear").error_estimate < 1e-6
    check_homogeneity(solution, clear_positions(solution, CLEAR))


def random_film(seed):
    """A film that opens, in plane or out of it."""
    random = np.random.default_rng(seed)
    scene, viscosity = opening_scene(random), 10 ** random.uniform(-3, 1)
    mode = ("in-plane", "antiplane")[seed % 2]
    return under(replace(scene, mode=mode), Coulomb(1.0, viscosity=float(viscosity)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_derivatives_of_random_films_that_open_scale(seed):
    solution = solve(random_film(seed), rtol=1e-9)
    assert solution.openings
    check_homogeneity(solution, clear_positions(solution, CLEAR))


X = np.array([0.05, 0.3, 0.9, 1.2])
STEP = 1e-4
FILM, OUT = {"law": Coulomb(1.0, viscosity=0.4)}, {"mode": "antiplane"}


def off_one_side(scene_of, name, size, sign):
    """How far rates of slip change from what a difference to one side says, and the estimate.

    A difference of second order in steps of 1e-4, towards where the base sticks; `scene_of(change)`
    is the scene whose base is changed by so much.
    """
    rates = [solve(scene_of(n * STEP * size), rtol=1e-11).slip_rate(X, 1.0) for n in (0, 1, 2)]
    derivative = solve(scene_of(0.0), rtol=1e-9).derivative(name)
    difference = sign * (3 * rates[0] - 4 * rates[1] + rates[2]) / (2 * STEP * size)
    off = np.abs(derivative.slip_rate(X, 1.0) - difference).max()
    return off / np.abs(difference).max(), derivative.error_estimate


@pytest.mark.thinned(18)
@pytest.mark.parametrize(
    ("friction", "load", "parts"),  # the first and the last two open beside slip
    [
        (1.3186, (24.54, 1.2), {"nu": 0.45}),
        (0.3, (0.5, 1.0), {}),
        (0.6, (0.5, 0.4), OUT),
        (0.3, (0.5, 1.0), {"law": Coulomb(1.0, viscosity=0.2)}),
        (0.4, (1.2, -1.0), {"nu": 0.0}),
        (0.3, (50.0, 25.0), FILM),
    ],
)
@pytest.mark.parametrize("lacking", [0.0, 3e-9, 1e-7])
def test_derivative_is_the_difference_to_one_side(friction, load, parts, lacking):
    """By base shear, towards stick; differences of second order are off by 1e-5 or less."""

    def scene_of(step):
        return unit_scene(friction, (1.0, friction * (1 - lacking) - step), load, **parts)

    off, estimate = off_one_side(scene_of, "base_shear", 1.0, 1)
    assert off < 3e-5
    assert estimate < 1e-7


OPENINGS = [
    (6.4187, 0.056, (1.0, -0.0206), {"nu": -0.37966}),
    (0.5, 0.1, (-1.0, 0.3), {}),
    (0.3, 0.02, (1.0, 0.5), {}),
    (0.3, 0.02, (1.0, 0.5), FILM),
    (0.3, 0.02, (1.0, 0.5), FILM | OUT),
]
"""Friction, base pressure, load, what else: all open, and slip starts at the longitudinal front."""


@pytest.mark.thinned(6)
@pytest.mark.parametrize(("friction", "pressure", "load", "parts"), OPENINGS)
def test_derivative_by_a_base_pressure_at_friction_knows_that_the_opening_moves(
    friction, pressure, load, parts
):
    """A larger base pressure makes the base stick; a difference to that side is of second order."""

    def scene_of(more):
        return unit_scene(friction, (pressure + more, friction * pressure), load, **parts)

    assert solve(scene_of(0.0)).openings
    off, estimate = off_one_side(scene_of, "base_pressure", pressure, -1)
    assert off < 1e-4
    assert estimate < 1e-6


@pytest.mark.thinned(8)
@pytest.mark.parametrize(("friction", "pressure", "load", "parts"), OPENINGS)
def test_derivatives_scale_where_a_base_at_friction_opens(friction, pressure, load, parts):
    """The base stays at friction where all tractions double, whichever side each derivative is
    of."""
    scene = unit_scene(friction, (pressure, friction * pressure), load, **parts)
    solution = solve(scene, rtol=1e-8)
    check_homogeneity(solution, clear_positions(solution, CLEAR))
