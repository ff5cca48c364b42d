"""Integrals by polynomials on cells are those along a path, and few cells are formed for them."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, unit_scene

from semianalytic import Coulomb, MovingLoad, find, solve

SCENES = {
    "default": PRELOADED,
    "remote": unit_scene(1.25, **REMOTE),
    "antiplane": unit_scene(0.3, (1.0, 0.1), (0.4, 1.0), mode="antiplane"),
    "film": unit_scene(0.5, (1.0, 0.2), (-1.0, 1.0), law=Coulomb(1.0, viscosity=0.1)),
    "far slower zone": unit_scene(98.0),
    "moving load": find("moving-load"),
    "load faster than waves": replace(unit_scene(0.3, (1.0, 0.1)), load=MovingLoad(2.2, 0.3, 0.6)),
    "load little faster than waves": replace(
        unit_scene(0.6, (1.0, 0.1), mode="antiplane"), load=MovingLoad(1.0946, 0.0, 0.9)
    ),
    "pair": find("pair-slip"),
}
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


def primitives_of(solution):
    """Integrals of the shear problem, or of the upper body of a pair."""
    bodies = solution._bodies
    return bodies._shear if hasattr(bodies, "_shear") else bodies._sent[0].primitives


def along_a_path(source, k):
    """All integrals at one k, from where no wave has come over k far above the axis."""
    place = source.places[source.parting]
    start, end = np.log(-0.5 * source.still[0]) + 1j * np.pi, np.log(k - place)
    middle, total = complex(end.real, np.pi / 2), np.copy(source.ahead)
    shorter = np.concatenate([np.linspace(0, 0.5, 6), 1 - 0.5 ** np.arange(2, 22), [1.0]])
    for (first, last), ends in (
        ((start, middle), np.linspace(0, 1, 12)),
        ((middle, end), shorter),
    ):
        half = np.diff(ends)[:, None] / 2
        log = first + (last - first) * (ends[:-1, None] + half * (1 + NODES))
        offset = np.exp(log).ravel()
        values = source.densities(np.full(len(offset), source.parting), offset[:, None])[..., 0]
        total += values @ (offset * ((last - first) * half * WEIGHTS).ravel())
    return total


@pytest.mark.parametrize(("rtol", "within"), [(1e-9, 2e-11), (1e-4, 2e-6)])
@pytest.mark.parametrize("name", SCENES)
def test_integrals_by_cells_are_those_along_a_path(name, rtol, within):
    primitives = primitives_of(solve(SCENES[name], rtol=rtol))
    source, rng = primitives.source, np.random.default_rng(3)
    k = rng.uniform(-2, 2, 24) + 1j * 10 ** rng.uniform(-2.5, 0.5, 24)
    found = primitives(k, 1e-18, np.eye(len(source.ahead)))
    expected = np.array([along_a_path(source, at).imag for at in k]).T
    rows = np.arange(len(found)) != (-1 if source.kept is None else source.kept)
    error = np.abs(found - expected) / (1 + np.abs(expected))
    assert error[rows].max() < within


@pytest.mark.parametrize("speed", [1e12, -1e12])
def test_a_load_that_moves_at_any_speed_is_in_the_end_that_on_the_whole_slot(speed):
    """Then the point that parts what is ahead comes to 0."""
    x, y = np.random.default_rng(5).uniform(-1, 1, (2, 100))
    whole = solve(PRELOADED, rtol=1e-9)
    load = MovingLoad(speed, PRELOADED.load.pressure, PRELOADED.load.shear)
    moving = solve(replace(PRELOADED, load=load), rtol=1e-9)
    np.testing.assert_allclose(moving.stress(x, y, 1.0), whole.stress(x, y, 1.0), atol=1e-11)
    np.testing.assert_allclose(moving.velocity(x, y, 1.0), whole.velocity(x, y, 1.0), atol=1e-11)


def test_a_picture_needs_few_cells_and_is_the_same_in_parts():
    x, y = np.random.default_rng(4).uniform(-1, 1, (2, 400))
    whole, part = (solve(PRELOADED, rtol=1e-4) for _ in range(2))
    fields = whole.velocity(x, y, 1.0)
    assert len(primitives_of(whole)._cells) < 200
    for piece in np.split(np.arange(400), 8)[::-1]:
        np.testing.assert_allclose(
            part.velocity(x[piece], y[piece], 1.0), fields[:, piece], rtol=1e-12, atol=1e-12
        )


def test_slot_faces_beside_a_stuck_edge_carry_the_load_in_coarse_cells_too():
    """Integrals far out are large: what they add up on another path is not known so well."""
    solution = solve(unit_scene(2.0, **REMOTE), rtol=1e-4)
    _, normal, shear = solution.stress(-np.geomspace(1e-3, 0.5, 30), -0.0, 1.0)
    assert max(np.abs(normal).max(), np.abs(shear).max()) < 1.5 * solution.field_error
