"""Numbers that docs/fields.md states."""

import numpy as np
import pytest
from docs_pages import quoted_numbers

from semianalytic import find, solve


def test_error_of_the_default_scene_is_that_of_the_page():
    ((error, _),) = quoted_numbers("docs/fields.md", "The estimate is {} for the default scene")
    assert solve(find("preloaded")).field_error == pytest.approx(error, rel=0.3)
    ((error, _),) = quoted_numbers("docs/fields.md", "and {} for that scene at `rtol=1e-11`")
    assert solve(find("preloaded"), rtol=1e-11).field_error == pytest.approx(error, rel=0.3)


def test_stress_at_the_edge_grows_as_the_page_says():
    r = np.array([1e-8, 1e-6, 1e-4])
    held = solve(find("stuck")).stress(-0.6 * r, 0.8 * r, 1.0)[0]
    assert held[:-1] / held[1:] == pytest.approx(10, rel=0.01)
    slipping = solve(find("preloaded")).stress(-0.6 * r, 0.8 * r, 1.0)
    assert np.ptp(np.diff(slipping[0])) < 1e-3 * abs(slipping[0, 0])
    assert np.abs(np.diff(slipping[1:])).max() < 1e-3


def test_velocity_changes_like_a_root_behind_the_circles():
    solution, depth = solve(find("preloaded")), np.array([1e-8, 1e-6])
    for angle in (1.2, 2.0):
        for radius in (1.0, 2.0):
            r = radius * (1 - np.append(-1e-12, depth))
            v_x = solution.velocity(r * np.cos(angle), r * np.sin(angle), 1.0)[0]
            assert (v_x[2] - v_x[0]) / (v_x[1] - v_x[0]) == pytest.approx(10, rel=0.01)
