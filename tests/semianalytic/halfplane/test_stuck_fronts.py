"""Stuck tractions under a load whose front moves over the slot: tables, second evaluations."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction

TABLE = {  # p: M_+(-p) of II and I; q_p*, p_p* at u = 0.7, 1, 2, 10, nu = 1/3
    -2.0: (
        1.650307999637,
        1.807821836465,
        (0.00416302, 0.02613857, 0.05823778, 0.49265632),
        (-0.00431393, -0.00742553, 0.01667952, 0.38899258),
    ),
    -0.9: (
        1.268049960483,
        1.477233498889,
        (0.00932314, 0.05568173, 0.1150059, 0.78474499),
        (-0.00934231, -0.01544957, 0.02686865, 0.56539015),
    ),
    -0.25: (
        0.966788423071,
        1.248118487287,
        (0.02132173, 0.11749023, 0.22078779, 1.21205729),
        (-0.02029108, -0.03153569, 0.0359652, 0.75378202),
    ),
    0.0: (
        0.816496580928,
        1.154700538379,
        (0.03540245, 0.1822508, 0.32195311, 1.5588662),
        (-0.03233404, -0.04779902, 0.03649484, 0.85334755),
    ),
    0.25: (
        0.619913143262,
        1.07372106041,
        (0.07840059, 0.35139985, 0.5651749, 2.28949283),
        (-0.06637316, -0.08925443, 0.01816682, 0.94686328),
    ),
    0.4: (
        0.444329545937,
        1.088380665188,
        (0.18864292, 0.69662414, 1.02551031, 3.52080497),
        (-0.14675892, -0.17594967, -0.05665785, 0.89288675),
    ),
}
"""The table of the theory notes, made by the quadrature of another hand."""


@pytest.mark.parametrize("p", TABLE)
def test_the_table_of_the_notes(p):
    shear, normal, of_shear, of_pressure = TABLE[p]
    for mode, at_load, values in (("II", shear, of_shear), ("I", normal, of_pressure)):
        stuck = stuck_traction(1 / 3, mode, p)
        assert stuck.m_plus_at_load == pytest.approx(at_load, abs=2e-12)
        assert stuck(np.array([0.7, 1.0, 2.0, 10.0])) == pytest.approx(values, abs=1e-8)


def second(poisson_ratio, mode, p, u):
    """q_p* or p_p* by Gauss's rule from the definitions, with a Rayleigh slowness of its own."""
    a2 = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))
    a, (node, weight) = math.sqrt(a2), np.polynomial.legendre.leggauss(400)
    angle, weight = (node + 1) * np.pi / 4, weight * np.pi / 4

    def cubic(r):
        return ((r - 8) * r + 24 - 16 * a2) * r - 16 * (1 - a2)

    c = 1 / math.sqrt(brentq(cubic, 0.05, 1.0, xtol=1e-15))

    def nodes(low, high):  # square roots at both ends removed
        return low + (high - low) * np.sin(angle) ** 2, weight * (high - low) * np.sin(2 * angle)

    w, of_w = nodes(a, 1.0)
    root = np.sqrt((w * w - a2) * (1 - w * w))
    phase = np.arctan2(4 * w * w * root, (1 - 2 * w * w) ** 2)

    def m_plus(k):  # for k > -a
        s = np.exp(-(1 / (w + np.reshape(k, (-1, 1)))) @ (of_w * phase) / np.pi)
        return (c + k) * s / np.sqrt((1 if mode == "II" else a) + k)

    def part(low, high):
        v, of_v = nodes(low, high)
        plain, square = (1 - 2 * v * v) ** 2, 4 * v * v
        behind = np.sqrt(np.maximum(v * v - 1, 0))
        ahead = np.sqrt(v * v - a2)
        if mode == "II":
            imag = square * ahead - (plain / np.maximum(behind, 1e-300) if low >= 1 else 0)
        else:
            imag = -plain / ahead + square * behind
        return float(imag / ((v - p) * m_plus(v)) @ of_v)

    total = part(a, min(u, 1.0)) + (part(1.0, u) if u > 1 else 0.0)
    return total / (np.pi * 2 * (1 - a2) * float(m_plus(-p)[0]))


@pytest.mark.parametrize(
    ("poisson_ratio", "mode", "p", "u"),
    [(1 / 3, "II", 0.4, 0.7), (0.1, "I", -0.9, 2.0), (-0.4, "II", 0.5, 3.0)],
)
def test_a_second_evaluation_agrees(poisson_ratio, mode, p, u):
    expected = second(poisson_ratio, mode, p, u)
    assert float(stuck_traction(poisson_ratio, mode, p)(u)) == pytest.approx(expected, rel=1e-10)
    # another front is seen
    assert float(stuck_traction(poisson_ratio, mode, p + 1e-6)(u)) != pytest.approx(
        expected, rel=1e-8
    )


def test_the_closed_form_out_of_the_plane():
    u = np.array([0.9, 1.0, 1.2, 3.0, 40.0])
    for p in (-3.0, 0.6):
        r = np.sqrt(np.maximum(u - 1, 0) / (1 - p))
        expected = 2 / math.pi * (r - np.arctan(r))
        assert stuck_traction(0.2, "III", p)(u) == pytest.approx(expected, abs=1e-14)


def test_fronts_at_the_ends_of_the_range_have_all_digits():
    """At 0.99 a and at -1e4: the derivative of the table is the density that it integrates."""
    for poisson_ratio in (-0.5, 1 / 3, 0.45):
        a = rayleigh_factors(poisson_ratio).a
        for p in (0.99 * a, -1e4):
            for mode in ("II", "I"):
                stuck = stuck_traction(poisson_ratio, mode, p)
                for u in (a + 0.4 * (1 - a), 1.6, 30.0):
                    h = 1e-3 * min(u - a, abs(u - 1))
                    beside = stuck(u + h * np.array([-2.0, -1.0, 1.0, 2.0]))
                    slope = beside @ [1, -8, 8, -1] / (12 * h)
                    expected = float(stuck.derivative(u))
                    assert slope == pytest.approx(expected, rel=1e-7)


def test_a_front_that_comes_at_once_is_the_step():
    u = np.geomspace(0.6, 50, 40)
    for mode in ("I", "II"):
        step, fast = stuck_traction(0.3, mode)(u), stuck_traction(0.3, mode, 1e-12)(u)
        assert fast == pytest.approx(step, abs=2e-11)
