"""Rules of the cut: the integral of their interpolant."""

import numpy as np
import pytest
from scipy.special import sici

from semianalytic.halfplane.rules import rule_for


def test_running_integral_of_sinc_is_that_of_si():
    """The row of a density in the middle, whose interpolant is one sinc, away from both ends."""
    rule = rule_for(1e-10)
    middle = len(rule.y) // 2
    density = np.zeros(len(rule.y))
    density[middle] = 1.0
    k = np.arange(len(rule.y)) - middle
    expected = rule.spacing * (0.5 + sici(np.pi * k)[0] / np.pi)
    assert np.abs(rule.running(density) - expected).max() < 4e-15


@pytest.mark.parametrize("tolerance", [1e-4, 1e-11])
def test_integrals_up_to_many_points_are_sums_of_si(tolerance):
    """They come from a table between nodes; points beyond the nodes, and at infinity, do not."""
    rule, rng = rule_for(tolerance), np.random.default_rng(4)
    density = rng.normal(size=(2, len(rule.y))) * np.exp(-np.abs(rule.y) / 2)
    y = np.concatenate([rng.uniform(-1.5, 1.5, 80) * rule.reach, rule.y[:3], [-np.inf, np.inf]])
    nodes, values = rule._continued(density)
    weights = np.full(len(nodes), rule.spacing)
    weights[[0, -1]] = rule.weights[[0, -1]]
    steps = 0.5 + sici(np.pi * (y[:, None] - nodes) / rule.spacing)[0] / np.pi
    found = rule.interpolate_running(y, density)
    np.testing.assert_allclose(found, steps @ (weights * values).T, rtol=0, atol=1e-14)


@pytest.mark.parametrize("halvings", [1, 4])
def test_points_beside_an_end_hold_what_is_smooth_there(halvings):
    """1 / (share + d) has its pole as far from the piece as the piece is long."""
    rule, d = rule_for(1e-11), 2.0**-halvings
    few = rule.beside_end(halvings)
    share = rule.share[: few.count]
    assert share[-1] < d <= rule.share[few.count]
    np.testing.assert_allclose(few.onto @ (1 / (few.share + d)), 1 / (share + d), rtol=5e-15)
    # The mirror image falls like the share that is left of it.
    falling, exact = few.onto_falling @ (few.share / (few.share + d)), share / (share + d)
    np.testing.assert_allclose(falling[::-1], exact, rtol=5e-15)
