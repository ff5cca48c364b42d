"""Load histories: exact primitives, Duhamel's integral, stress intensity and near field."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from catalogue import UNIT
from scipy.integrate import quad

from docs.studies.article.stuck import near_field, primitive_of, stuck_pressure, stuck_shear
from semianalytic import Tractions
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stress_intensity, stuck_traction
from semianalytic.halfplane.stuck_histories import intensity_history
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import PULSE_SHAPES, Harmonic, Pulse, Ramp, Step
from semianalytic.scene.tabulated import Tabulated

HISTORIES = [
    Step(),
    Ramp(0.4),
    Harmonic(2.0),
    Tabulated((0.2, 0.2, 0.5, 0.7, 0.7), (0.3, 0.6, -0.2, 0.1, 0.4)),
    *(Pulse(0.7, shape) for shape in PULSE_SHAPES),
]
STUCK = {"I": stuck_pressure, "II": stuck_shear, "III": partial(stuck_shear, shear_mode="III")}


@pytest.mark.parametrize("mode", ["I", "II", "III"])
@pytest.mark.parametrize("nu", [-0.4, 1 / 3, 0.45])
def test_primitive(nu, mode):
    primitive, stuck = primitive_of(nu, mode), stuck_traction(nu, mode)
    a = rayleigh_factors(nu).a

    def integral(left, right):
        def density(y):
            return stuck(left + (right - left) * np.sin(y) ** 2) * (right - left) * np.sin(2 * y)

        return quad(density, 0, np.pi / 2, epsabs=1e-15, epsrel=1e-12)[0]

    assert primitive(a) == 0
    assert primitive(1.0) == pytest.approx(integral(a, 1.0), rel=1e-11)
    assert primitive(1.03) - primitive(1.0) == pytest.approx(integral(1.0, 1.03), rel=1e-10)
    assert primitive(1.6) - primitive(1.0) == pytest.approx(integral(1.0, 1.6), rel=1e-10)
    assert primitive(30.0) - primitive(1.6) == pytest.approx(integral(1.6, 30.0), rel=1e-10)


@pytest.mark.parametrize("mode", ["I", "II"])
def test_transform_of_the_step(mode):
    """int e^{-s t} dp* = F_+(0)/F_+(k) - 1 of (3.11), (3.15), k = 1/s; 1/F_+ is M_+.

    Its part S_+ is held against mpmath in test_rayleigh.py.
    """
    factors, k = rayleigh_factors(1 / 3), 0.8
    expected = factors.m_plus(k, mode) / factors.m_plus_at_zero[mode] - 1
    # int du (dp*/du) k / (k + u): p* is 0 ahead of u = a
    slope = stuck_traction(1 / 3, mode)
    t, w = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for left, right in ((0.5, 1.0), (1.0, 2.0)):
        y = (t + 1) * np.pi / 4
        u = left + (right - left) * np.sin(y) ** 2
        du = (right - left) * np.sin(2 * y) * np.pi / 4 * w
        total += float(np.sum(slope.derivative(u) * du * k / (k + u)))
    r = (t + 1) / 2  # u = 2 / r^2 removes the root at infinity
    u = 2 / r**2
    total += float(np.sum(slope.derivative(u) * 4 / r**3 * w / 2 * k / (k + u)))
    assert total == pytest.approx(expected, rel=1e-9)


@pytest.mark.thinned(3)
@pytest.mark.parametrize("mode", ["I", "II", "III"])
@pytest.mark.parametrize(
    "history",
    [
        Ramp(0.8),
        Harmonic(1.5),
        Tabulated((0.1, 0.5, 0.5, 1.0), (0.3, 1.0, -0.5, 0.2)),
        *(Pulse(0.5, shape) for shape in PULSE_SHAPES),
    ],
)
def test_duhamel_integral(history, mode):
    """(3.20) by adaptive quadrature over f(t - s) dp*/ds, for each wave arrival apart."""
    stuck = stuck_traction(1 / 3, mode)
    x, t = 0.6, 1.7
    last = t / x
    kinks = [(t - s) / x for s in (0.1, 0.5, 0.8, 1.0)]
    ends = sorted({0.5, 1.0, last, *(v for v in kinks if 0.5 < v < last)})

    def density(y, left, right):
        v = left + (right - left) * np.sin(y) ** 2
        slope = float(stuck.derivative(v)) * (right - left) * np.sin(2 * y)
        return slope * float(history.value(t - v * x))

    expected = sum(
        quad(density, 1e-12, np.pi / 2 - 1e-12, (left, right), epsabs=1e-12, epsrel=1e-11)[0]
        for left, right in pairwise(ends)
    )
    found = STUCK[mode](history, 2.5, UNIT, x, t)
    assert found.error < 1e-12
    assert found.value == pytest.approx(2.5 * expected, rel=1e-9)


def test_harmonic_error_estimate_and_many_periods():
    history = Harmonic(20.0)
    found = stuck_shear(history, 1.0, UNIT, np.array([0.02, 0.4]), 3.0)
    t = np.linspace(0, 3.0, 60001)
    table = Tabulated(tuple(t), tuple(history.value(t)))
    interpolated = stuck_shear(table, 1.0, UNIT, np.array([0.02, 0.4]), 3.0)
    # linear interpolation errs by (omega dt)^2 / 8 of the amplitude, times the response
    np.testing.assert_allclose(found.value, interpolated.value, atol=1e-4)
    assert found.error < 1e-9


def test_step_and_short_ramp():
    x, t = np.array([0.3, 0.9, 1.5, 2.5]), 1.0
    for mode in ("I", "II"):
        step = STUCK[mode](Step(), 3.0, UNIT, x, t).value
        np.testing.assert_array_equal(step, 3 * stuck_traction(1 / 3, mode)(t / x))
        ramp = STUCK[mode](Ramp(1e-3), 3.0, UNIT, x, t).value
        np.testing.assert_allclose(ramp, step, atol=6e-3)


def test_values():
    table = Tabulated((0.5, 1.0, 1.0, 2.0), (1.0, 3.0, 0.0, -1.0))
    np.testing.assert_allclose(
        table.value([0.4, 0.5, 0.75, 1.0, 1.5, 9.0]), [0.0, 0.0, 2.0, 3.0, -0.5, -1.0]
    )
    assert Tabulated([0.0], [2.0]).value(1.0) == 2.0
    np.testing.assert_allclose(Ramp(2.0).value([-1, 1, 3]), [0, 0.5, 1])
    np.testing.assert_allclose(Harmonic(0.25).value([-1, 1.0]), [0, 1])
    np.testing.assert_allclose(Step().value([-1, 1.0]), [0, 1])
    assert Ramp(0.0).pieces == Step().pieces
    for shape in PULSE_SHAPES:
        pulse = Pulse(2.0, shape)
        np.testing.assert_allclose(pulse.value([-1, 1.0, 2.5]), [0, 1, 0], atol=1e-12)
    ramp = Ramp(1e-13)  # which keeps its digits
    assert ramp.value(0.7) == 1.0
    assert ramp.mean(0.5, 0.50001) == pytest.approx(1.0, rel=1e-10)
    assert ramp.value(5e-14) == pytest.approx(0.5)


@pytest.mark.parametrize("history", [Harmonic(2.0), Pulse(0.7, "half-sine")])
@pytest.mark.parametrize("mode", ["I", "II"])
def test_at_the_very_shear_front(history, mode):
    """t = x/c_t exactly, where dq*/dv has a root: the mean of what is beside it."""
    at, before, after = (
        float(STUCK[mode](history, 0.8, UNIT, 1.0, t).value) for t in (1.0, 1 - 1e-7, 1 + 1e-7)
    )
    assert at == pytest.approx((before + after) / 2, abs=1e-3)


@pytest.mark.parametrize("history", HISTORIES)
def test_means(history):
    """Means over intervals, against quadrature between the breaks."""
    for start, end in ((-0.3, 0.2), (0.2, 0.9), (0.0, 3.0)):
        inside = [b for b in history.pieces.breaks if start < b < end]
        expected = quad(history.value, start, end, points=inside or None, epsabs=1e-12)[0]
        assert history.mean(start, end) == pytest.approx(expected / (end - start), abs=1e-9)


def test_stress_intensity_of_histories():
    """K of a history is int f'(s) K_step(t - s) ds."""
    loads, t = Tractions(1.3, -0.4), 1.1
    unit = stress_intensity(UNIT, loads, 1.0)
    history, angular = Harmonic(0.7), 2 * np.pi * 0.7
    response = quad(lambda r: 2 * r**2 * angular * np.cos(angular * (t - r * r)), 0, np.sqrt(t))[0]
    np.testing.assert_allclose(
        intensity_history(history, loads, UNIT, t), np.array(unit) * response, rtol=1e-10
    )
    np.testing.assert_allclose(
        intensity_history(Step(), loads, UNIT, t), stress_intensity(UNIT, loads, t), rtol=1e-14
    )
    table = Tabulated((0.0, 0.5), (0.0, 1.0))
    np.testing.assert_allclose(
        intensity_history(Ramp(0.5), loads, UNIT, t), intensity_history(table, loads, UNIT, t)
    )
    assert intensity_history(Step(), loads, UNIT, -1.0) == (0, 0)


@pytest.mark.parametrize("history", [Step(), Ramp(0.4), Harmonic(2.0)])
def test_near_field(history):
    """Traction with the load's own constant over K / sqrt(2 pi x) tends to 1 like x."""
    intensities = intensity_history(history, Tractions(1.0, 1.0), UNIT, 1.1)
    for function, intensity in zip((stuck_pressure, stuck_shear), intensities, strict=True):
        gaps = []
        for x in (1e-4, 1e-6):
            total = function(history, 1.0, UNIT, x, 1.1).value + history.value(1.1)
            gaps.append(abs(float(total / near_field(intensity, x)) - 1))
        assert gaps[0] < 5e-3
        assert gaps[1] < 0.02 * gaps[0] + 1e-9


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ramp(-0.1), "rise_time must be a number, 0 or more"),
        (lambda: Pulse(0.0), "duration must be a positive"),
        (lambda: Pulse(1.0, "round"), "shape must be one of"),
        (lambda: Tabulated((0.0, 1.0), (1.0,)), "as many values"),
        (lambda: Tabulated((), ()), "at least one"),
        (lambda: Tabulated((0.0, float("nan")), (0.0, 1.0)), "finite"),
        (lambda: Tabulated((1.0, 0.5), (0.0, 1.0)), "not decrease"),
        (lambda: Tabulated((-1.0, 0.5), (0.0, 1.0)), "start at 0"),
        (lambda: Tabulated((1.0, 1.0, 1.0), (0.0, 1.0, 2.0)), "more often"),
        (lambda: stuck_shear(Step(), 1.0, UNIT, 0.0, 1.0), "x > 0"),
        (lambda: stuck_shear(Step(), 1.0, UNIT, 1.0, float("nan")), "finite"),
    ],
)
def test_bad_input(make, message):
    with pytest.raises(SceneError, match=message):
        make()
