"""Rules of the cut: the integral of their interpolant."""

import numpy as np
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
