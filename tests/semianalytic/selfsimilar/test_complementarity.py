import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from semianalytic import ComputationError
from semianalytic.selfsimilar.zones.collocation import lemke


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_positive_definite_problems_are_solved(n, seed):
    random = np.random.default_rng(seed)
    factor = random.standard_normal((n, n))
    matrix = factor @ factor.T + 0.1 * np.eye(n)
    q = random.standard_normal(n)
    solved = lemke(matrix, q)
    w = q + matrix @ solved.z
    scale = 1 + np.abs(matrix).max() * np.abs(solved.z).max()
    assert np.all(solved.z >= 0)
    assert np.all(w >= -1e-9 * scale)
    assert abs(w @ solved.z) < 1e-9 * scale**2


def test_nothing_to_do():
    assert lemke(np.eye(3), np.ones(3)).pivots == 0


def test_a_problem_without_solution_ends_on_a_ray():
    with pytest.raises(ComputationError, match="ray"):
        lemke(np.array([[-1.0]]), np.array([-1.0]))


def test_a_limit_on_pivots_is_reported():
    with pytest.raises(ComputationError, match="over 1 pivots"):
        lemke(np.eye(4), -np.arange(1.0, 5.0), most_pivots=1)
