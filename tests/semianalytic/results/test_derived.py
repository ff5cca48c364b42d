"""What instruments see: strain is the gradient of displacement, fringes follow the optic law."""

import numpy as np
import pytest

from semianalytic import SceneError, find, fringe_order, fringes, solve, strain
from semianalytic.results.derived import principal_difference

X, Y, T = np.array([0.4, -0.7, 0.3]), np.array([0.2, 0.5, -0.6]), 1.0
STEP = 1e-3


def gradient(field):
    """d_x and d_y of a field of positions, by differences of fourth order."""

    def along(dx, dy):
        ahead, behind = (
            field(X + n * dx, Y + n * dy) - field(X - n * dx, Y - n * dy) for n in (1, 2)
        )
        return (8 * ahead - behind) / (12 * STEP)

    return along(STEP, 0.0), along(0.0, STEP)


@pytest.mark.parametrize("name", ["preloaded", "tap", "antiplane"])
def test_strain_is_the_gradient_of_displacement(name):
    scene = find(name)
    solution = solve(scene)
    change = solution.stress(X, Y, T) - solution.stress(X, Y, 0.0)
    seen = strain(change, scene.material)
    by_x, by_y = gradient(lambda x, y: solution.displacement(x, y, T))
    expected = [by_x[0], by_y[1], (by_y[0] + by_x[1]) / 2]
    if scene.antiplane:
        expected += [by_x[2] / 2, by_y[2] / 2]
    assert np.abs(seen).max() > 0.05
    assert seen == pytest.approx(np.array(expected), abs=1e-6)


def test_principal_stresses_are_eigenvalues():
    stress = np.random.default_rng(1).normal(size=(3, 20))
    xx, yy, xy = stress
    low, high = np.linalg.eigvalsh(np.array([[xx, xy], [xy, yy]]).T).T
    assert principal_difference(stress) == pytest.approx(high - low)


def test_fringes_are_dark_where_the_order_is_whole():
    stress = np.array([[0.0, 1.0, 0.5, 2.0], [0.0, -1.0, 0.0, 2.0], [0.0, 0.0, 0.0, 1.0]])
    assert fringe_order(stress, 3.0, 2.0) == pytest.approx([0, 3, 0.75, 3])
    assert fringes(stress, 3.0, 2.0) == pytest.approx([0, 0, 0.5, 0], abs=1e-15)
    infinite = np.array([np.inf, 0.0, 0.0])  # which has no intensity
    assert fringe_order(infinite, 1.0, 1.0) == np.inf
    assert np.isnan(fringes(infinite, 1.0, 1.0))


def test_what_acts_along_z_does_not_turn_light():
    stress = np.random.default_rng(2).normal(size=(5, 4))
    assert np.array_equal(fringes(stress, 1.0, 1.0), fringes(stress[:3], 1.0, 1.0))


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: fringes(np.zeros(3), 0.0, 1.0), "thickness must be positive"),
        (lambda: fringes(np.zeros(3), 1.0, -1.0), "fringe_constant must be positive"),
        (lambda: fringes(np.zeros((2, 3)), 1.0, 1.0), "must have 3 rows"),
        (lambda: strain(1.0, find("stuck").material), "must have 3 rows"),
    ],
)
def test_what_is_no_stress_or_body_is_refused(ask, message):
    with pytest.raises(SceneError, match=message):
        ask()
