"""Stuck tractions in plane and out of it, under steps and under loads whose front moves."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from docs.studies.article.stuck import primitive_of
from semianalytic import Material, Tractions
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stress_intensity, stuck_traction

# theory.md section 3: nu = 1/3, b = 1, eleven digits.
SLOWNESS = np.array([0.7, 0.9, 1.0, 1.05, 2.0, 10.0])
PRESSURE = [-0.03233403875, -0.03734705151, -0.04779901602]
PRESSURE += [-0.05051788325, 0.03649483924, 0.85334755328]
SHEAR = [0.03540244618, 0.12028263144, 0.18225079615, 0.14854006368, 0.32195310512, 1.55886620083]
UNIT = Material(1.0, 1.0, 1 / 3)
TABLE = [  # p, mode, M_+(-p), q_p* or p_p* at u = 0.7, 1, 2, 10, nu = 1/3
    (-2.0, "II", 1.650307999637, (0.00416302, 0.02613857, 0.05823778, 0.49265632)),
    (-2.0, "I", 1.807821836465, (-0.00431393, -0.00742553, 0.01667952, 0.38899258)),
    (-0.9, "II", 1.268049960483, (0.00932314, 0.05568173, 0.1150059, 0.78474499)),
    (-0.9, "I", 1.477233498889, (-0.00934231, -0.01544957, 0.02686865, 0.56539015)),
    (-0.25, "II", 0.966788423071, (0.02132173, 0.11749023, 0.22078779, 1.21205729)),
    (-0.25, "I", 1.248118487287, (-0.02029108, -0.03153569, 0.0359652, 0.75378202)),
    (0.0, "II", 0.816496580928, (0.03540245, 0.1822508, 0.32195311, 1.5588662)),
    (0.0, "I", 1.154700538379, (-0.03233404, -0.04779902, 0.03649484, 0.85334755)),
    (0.25, "II", 0.619913143262, (0.07840059, 0.35139985, 0.5651749, 2.28949283)),
    (0.25, "I", 1.07372106041, (-0.06637316, -0.08925443, 0.01816682, 0.94686328)),
    (0.4, "II", 0.444329545937, (0.18864292, 0.69662414, 1.02551031, 3.52080497)),
    (0.4, "I", 1.088380665188, (-0.14675892, -0.17594967, -0.05665785, 0.89288675)),
]
"""The table of the theory notes, made by the quadrature of another hand."""


def test_reference_values():
    np.testing.assert_allclose(
        stuck_traction(1 / 3, "I")(SLOWNESS), PRESSURE, rtol=1e-9, atol=1e-11
    )
    np.testing.assert_allclose(stuck_traction(1 / 3, "II")(SLOWNESS), SHEAR, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("mode", ["I", "II"])
@pytest.mark.parametrize("nu", [-0.9, 0.0, 0.3, 0.499])
def test_tables_against_adaptive_quadrature(nu, mode):
    traction = stuck_traction(nu, mode)
    a = traction.factors.a

    def ahead(theta):
        return traction.derivative(a + (1 - a) * np.sin(theta) ** 2) * (1 - a) * np.sin(2 * theta)

    def behind(s):
        return traction.derivative(1 + s * s) * 2 * s

    # The cuts stay off u = a and u = b, where the slope itself is singular.
    for u in (a + 0.05 * (1 - a), a + 0.6 * (1 - a)):
        stop = np.arcsin(np.sqrt((u - a) / (1 - a)))
        expected = quad(ahead, 1e-9, stop, epsabs=1e-15, epsrel=1e-13)[0]
        assert float(traction(u)) == pytest.approx(expected, rel=3e-7)
    for u, v in ((1.001, 1.4), (1.4, 30.0), (30.0, 1e4)):
        expected = quad(behind, np.sqrt(u - 1), np.sqrt(v - 1), epsabs=1e-14, epsrel=1e-13)[0]
        assert float(traction(v) - traction(u)) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("mode", ["I", "II"])
def test_relative_accuracy_at_the_onset(mode):
    """Near the longitudinal front p* ~ (u - a)^(1/2) and q* ~ (u - a)^(3/2) without loss."""
    traction = stuck_traction(0.2, mode)
    a, power = traction.factors.a, 0.5 if mode == "I" else 1.5
    step = 2.0**-40
    ratio = float(traction(a + step) / traction(a + step / 4))
    assert ratio == pytest.approx(4**power, rel=1e-3)  # rounding of a + step: 2^-52 / 2^-42


@pytest.mark.parametrize("mode", ["I", "II", "III"])
def test_nothing_comes_ahead_of_the_first_wave(mode):
    traction = stuck_traction(0.3, mode)
    ahead = np.array([-1.0, 0.0, 0.5, 0.99]) * (1.0 if mode == "III" else traction.factors.a)
    assert np.all(traction(ahead) == 0)
    assert np.all(traction.derivative(ahead) == 0)
    assert np.all(primitive_of(0.3, mode)(ahead) == 0)


def test_stress_intensity_is_the_limit_at_the_edge():
    material = Material(2.0, 3.0, 0.3)
    mode_one, mode_two = stress_intensity(material, Tractions(1.5, -0.5), 4.0)
    x = 1e-12
    u = 4.0 / x * material.shear_speed
    near = np.sqrt(2 * np.pi * x)
    assert 1.5 * float(stuck_traction(0.3, "I")(u)) * near == pytest.approx(mode_one, rel=1e-5)
    assert -0.5 * float(stuck_traction(0.3, "II")(u)) * near == pytest.approx(mode_two, rel=1e-5)
    assert stress_intensity(material, Tractions(1.0, 1.0), -1.0) == (0.0, 0.0)
    _, sheared = stress_intensity(material, Tractions(0.0, 1.5), 4.0, "III")
    assert 1.5 * float(stuck_traction(0.3, "III")(u)) * near == pytest.approx(sheared, rel=1e-5)


def test_edge_sticks_from_the_ratio_of_wave_speeds_on():
    """K_II / K_I = (Q_0 / P_0) sqrt(b / a), theory.md section 3."""
    material = Material(1.0, 1.0, 1 / 3)
    mode_one, mode_two = stress_intensity(material, Tractions(1.0, 1.0), 1.0)
    ratio = np.sqrt(material.longitudinal_speed / material.shear_speed)
    assert mode_two / mode_one == pytest.approx(ratio, rel=1e-14)


def test_least_pressure_is_at_the_rayleigh_front():
    traction = stuck_traction(0.25, "I")
    u = np.linspace(traction.factors.a, 3, 4001)
    assert u[np.argmin(traction(u))] == pytest.approx(traction.factors.c, abs=u[1] - u[0])


def test_intensity_out_of_the_plane_in_closed_form():
    """K_III = 2 Q_0 sqrt(2 c_t t/pi), of every solid; K_II and K_III are as M_+(0) of the modes."""
    for nu in (-0.5, 0.0, 0.45):
        material = Material(4.0, 1.0, nu)
        _, sheared = stress_intensity(material, Tractions(0.0, 1.5), 3.0, "III")
        assert sheared == pytest.approx(2 * 1.5 * np.sqrt(2 * 2.0 * 3.0 / np.pi), rel=1e-14)
        _, in_plane = stress_intensity(material, Tractions(0.0, 1.5), 3.0)
        at_zero = rayleigh_factors(nu).m_plus_at_zero
        assert sheared / in_plane == pytest.approx(at_zero["II"] / at_zero["III"], rel=1e-11)


@pytest.mark.parametrize(("p", "mode", "at_load", "values"), TABLE)
def test_the_table_of_the_notes(p, mode, at_load, values):
    stuck = stuck_traction(1 / 3, mode, p)
    assert stuck.m_plus_at_load == pytest.approx(at_load, abs=2e-12)
    assert stuck(np.array([0.7, 1.0, 2.0, 10.0])) == pytest.approx(values, abs=1e-8)


def test_the_closed_form_out_of_the_plane():
    u = np.array([0.9, 1.0, 1 + 1e-6, 1.03999, 1.04001, 1.2, 3.0, 40.0])
    for p in (-3.0, 0.0, 0.6):
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
