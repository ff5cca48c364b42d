"""Fields in the bodies: whatever else is asked with a point, and whatever law the friction has."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, unit_scene

from semianalytic import RateWeakening, solve

WEAKENED = unit_scene(1.0, load=(0.0, 1.2), friction_law=RateWeakening(0.4, 1.0))


def on_fronts(solution):
    """Positions at t = 1 exactly on the wave fronts, and on the edges of slip."""
    material = solution.scene.material
    speeds = [material.longitudinal_speed, material.shear_speed, material.rayleigh_speed]
    speeds += [speed for zone in solution.zones for speed in (zone.inner, zone.outer)]
    return [speed for speed in speeds if 0 < speed < np.inf]


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


@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_faces_under_friction_that_falls_with_slip_rate(mode):
    """They move and carry what the interface does, also at the wave fronts."""
    solution = solve(replace(WEAKENED, mode=mode), rtol=1e-5)
    x = np.append(np.linspace(0.0137, 2.1, 20), solution.scene.material.shear_speed)
    edges = np.array([zone.outer for zone in solution.zones])
    x = x[np.abs(x[:, None] - edges).min(axis=1) > 0.03]
    slip, shear = (2, 4) if mode == "antiplane" else (0, 2)
    bound = solution.field_error
    assert bound < 1e-5
    moved = [solution.velocity(x, face, 1.0)[slip] for face in (0.0, -0.0)]
    np.testing.assert_allclose(moved[0] - moved[1], solution.slip_rate(x, 1.0), atol=3 * bound)
    shifted = [solution.displacement(x, face, 1.0)[slip] for face in (0.0, -0.0)]
    np.testing.assert_allclose(shifted[0] - shifted[1], solution.slip(x, 1.0), atol=3 * bound)
    carried = solution.stress(x, 0.0, 1.0)[shear]
    np.testing.assert_allclose(carried, solution.shear_traction(x, 1.0), atol=3 * bound)
