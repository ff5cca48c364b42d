"""Fields in the bodies at points close to an edge, on fronts, far away, and many at once."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, UNIT, unit_scene

from semianalytic import (
    Coulomb,
    Material,
    MovingLoad,
    RateWeakening,
    Scene,
    SceneError,
    Tractions,
    find,
)
from semianalytic.field import body, tuning
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.selfsimilar.solver import solve
from tests.semianalytic.field.body_fields import check_faces, edges_of

WEAKENED = unit_scene(1.0, load=(0.0, 1.2), law=RateWeakening(1.0, 0.6, 1.0))


def test_what_is_infinite_says_so_with_its_sign():
    solution, speed = solve(unit_scene(2.0, **REMOTE)), UNIT.rayleigh_speed
    assert solution.velocity(-speed, 0.0, 1.0)[0] == np.inf
    assert solution.velocity(-speed, -0.0, 1.0)[0] == -np.inf
    assert solution.stress(0.0, 0.0, 1.0)[1] == -np.inf
    assert solution.stress(0.0, 0.0, 1.0)[2] == np.inf
    assert np.isfinite(solution.displacement(0.0, 0.0, 1.0)).all()
    assert np.isfinite(solution.velocity([0.5, -1.0, 0.3], [0.0, 0.0, 0.95], 1.0)).all()
    slips = solve(unit_scene(0.5, **REMOTE))  # across c_R, but uniformly: nothing is infinite there
    assert np.isfinite(slips.velocity(speed, 0.0, 1.0)).all()
    reverse = solve(NAMED_SCENES["auxetic"].scene)
    front = reverse.scene.material.rayleigh_speed
    assert reverse.velocity(front, 0.0, 1.0)[0] == -np.inf
    with pytest.raises(SceneError, match="finite"):
        reverse.velocity(np.nan, 0.0, 1.0)


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("lacking", [1e-7, 1e-12])
@pytest.mark.parametrize("parts", [{}, {"mode": "antiplane"}, {"law": Coulomb(1.0, viscosity=0.2)}])
def test_an_edge_closer_to_a_front_than_rounding_is_right_of_it(parts, lacking):
    """A base just below friction sticks on a strip as wide as the square of what it lacks."""
    base = (1.0, 0.3 * (1 - lacking))
    scene = unit_scene(0.3, base, (0.5, 1.0), **parts)
    solution, better = solve(scene, rtol=1e-7), solve(scene, rtol=1e-10)
    x, y = np.array([-0.5, 0.3, 0.9, 1.5]), np.array([0.4, -0.2, 0.3, 0.2])
    bound = solution.field_error + better.field_error
    for name in ("velocity", "stress", "displacement"):
        first, other = (getattr(answer, name)(x, y, 1.0) for answer in (solution, better))
        assert np.abs(first - other).max() < bound * (1 + np.abs(other).max()), name


@pytest.mark.thinned(3)
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e160, 1e300])
@pytest.mark.filterwarnings("error")
def test_no_position_is_too_small_or_too_large_to_square(mode, size):
    solution = solve(unit_scene(2.0, **REMOTE, mode=mode))
    x, y = np.array([0.3, -0.4, 0.5, -0.2, 0.0]), np.array([0.2, -0.1, 0.0, -0.0, 0.6])
    for field, power in (("velocity", 0), ("stress", 0), ("displacement", 1)):
        ask = getattr(solution, field)
        np.testing.assert_allclose(
            ask(size * x, size * y, size), size**power * ask(x, y, 1.0), rtol=1e-9, atol=1e-300
        )


@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
@pytest.mark.filterwarnings("error")
def test_far_points_have_the_fields_at_infinity_and_those_at_the_edge_its_own(mode):
    solution = solve(unit_scene(2.0, **REMOTE, mode=mode))
    behind, ahead = (solution.stress(x, [0.5, 1e300], 1.0) for x in (-1e300, 1e300))
    np.testing.assert_allclose(behind, solution.stress(-1e12, [0.5, 1e12], 1.0), atol=1e-8)
    np.testing.assert_array_equal(ahead, solution.stress([0.5, 1e12], 9.0, 1.0))
    edge = solution.stress(0.0, 0.0, 1.0)
    np.testing.assert_array_equal(solution.stress(1e-300, 1e-300, 1.0), edge)
    np.testing.assert_array_equal(solution.stress(0.3, 0.2, 1e300), edge)


def test_fields_are_formed_in_parts(monkeypatch):
    solution, rng = solve(unit_scene(2.0, **REMOTE)), np.random.default_rng(9)
    x, y, t = *rng.uniform(-2, 2, (2, 3, 7)), rng.uniform(-0.2, 1, (3, 7))
    whole = solution.displacement(x, y, t)
    sizes, near = [], body._near
    monkeypatch.setattr(tuning, "POINTS_AT_ONCE", 4)
    monkeypatch.setattr(body, "_near", lambda *at: sizes.append(len(at[2][0])) or near(*at))
    np.testing.assert_allclose(solution.displacement(x, y, t), whole, rtol=1e-12, atol=1e-14)
    assert max(sizes) == 4
    assert sum(sizes) == np.count_nonzero(t > 0)


def test_far_nodes_are_summed_up_to_what_they_are_one_by_one(monkeypatch):
    """Stresses beside a stuck edge lose no digits either way."""
    scene, rng = unit_scene(2.0, **REMOTE), np.random.default_rng(5)
    r, angle = 10.0 ** rng.uniform(-11, 0, 60), rng.uniform(0, np.pi, 60)
    at = r * np.cos(angle), r * np.sin(angle), 1.0
    few = solve(scene, rtol=1e-10).stress(*at)
    monkeypatch.setattr(tuning, "MANY_SEEN", 10**6)
    monkeypatch.setattr(tuning, "NEGLIGIBLE", 1e-9)
    every = solve(scene, rtol=1e-10).stress(*at)
    assert np.any(few != every)
    assert (np.abs(few - every).max(axis=0) / np.abs(every).max(axis=0)).max() < 2e-11


def on_fronts(solution):
    """Positions at t = 1 exactly on the wave fronts, and on the edges of slip."""
    material = solution.scene.material
    speeds = [material.longitudinal_speed, material.shear_speed, material.rayleigh_speed]
    return [speed for speed in (*speeds, *edges_of(solution)) if 0 < speed < np.inf]


@pytest.mark.thinned(5)
@pytest.mark.parametrize(
    "scene",
    [
        PRELOADED,
        unit_scene(1.0, load=(0.0, 1.2)),
        unit_scene(1.25, **REMOTE),
        unit_scene(0.3, (0.02, 0.0), (1.0, 0.5)),
        unit_scene(0.3, (1.0, 0.1), (0.4, 1.0), mode="antiplane"),
    ],
)
def test_a_point_on_a_front_changes_nothing_elsewhere(scene):
    """Beside the shear front T is infinite: what counts there alone may not be all that counts."""
    x = np.linspace(0.07, 1.9, 12)
    alone, together = solve(scene), solve(scene)
    with_fronts = np.append(x, on_fronts(together))
    for name in ("velocity", "stress", "displacement"):
        expected = getattr(alone, name)(x, 0.1, 1.0)
        for height in (0.0, 0.1):
            found = getattr(together, name)(with_fronts, height, 1.0)
        np.testing.assert_allclose(found[:, : len(x)], expected, rtol=3e-9, atol=3e-9)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_faces_under_friction_that_falls_with_slip_rate(mode):
    """They move and carry what the interface does, also at the wave fronts."""
    solution = solve(replace(WEAKENED, mode=mode), rtol=1e-5)
    x = np.append(np.linspace(0.0137, 2.1, 20), solution.scene.material.shear_speed)
    edges = np.array([zone.outer for zone in solution.zones])
    x = x[np.abs(x[:, None] - edges).min(axis=1) > 0.03]
    bound = solution.field_error
    assert bound < 1e-5
    check_faces(solution, x, 1.0, 3 * bound, rtol=1e-7)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_the_open_face_beside_the_end_of_an_opening_in_a_film(rtol):
    """Its traction is zero, and that of the film jumps at the end: the worst place of a field."""
    load = MovingLoad(0.003, -0.031, 9.264)
    film = Scene(
        Material(1.0, 1.0, 0.257), Coulomb(0.0713, viscosity=0.664), Tractions(0.0524, 0.00189),
        load, mode="antiplane",
    )  # fmt: skip
    lifted = find("lift-off-shear")
    for scene in (film, replace(lifted, friction=Coulomb(lifted.coefficient, viscosity=0.3))):
        solution = solve(scene, rtol=rtol)
        (opening,) = solution.openings
        x = opening.outer * (1 - 10.0 ** -np.arange(1, 7))
        stress = np.abs(solution.stress(x, 0.0, 1.0)[[1, -1]])
        largest = max(abs(scene.load.pressure), abs(scene.load.shear))
        assert (stress <= solution.field_error * (stress + largest)).all()
        assert solution.field_error < 1e3 * rtol
