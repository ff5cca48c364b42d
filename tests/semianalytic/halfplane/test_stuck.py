import numpy as np
import pytest
from scipy.integrate import quad

from semianalytic import Material, Tractions
from semianalytic.halfplane.stuck import stress_intensity, stuck_traction

# theory.md section 3: nu = 1/3, b = 1, eleven digits.
SLOWNESS = np.array([0.7, 0.9, 1.0, 1.05, 2.0, 10.0])
PRESSURE = [-0.03233403875, -0.03734705151, -0.04779901602]
PRESSURE += [-0.05051788325, 0.03649483924, 0.85334755328]
SHEAR = [0.03540244618, 0.12028263144, 0.18225079615, 0.14854006368, 0.32195310512, 1.55886620083]


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


def test_nothing_ahead_of_the_longitudinal_front():
    for mode in ("I", "II"):
        traction = stuck_traction(0.3, mode)
        ahead = np.array([-1.0, 0.0, 0.5 * traction.factors.a])
        assert np.all(traction(ahead) == 0)
        assert np.all(traction.derivative(ahead) == 0)


def test_stress_intensity_is_the_limit_at_the_edge():
    material = Material(2.0, 3.0, 0.3)
    mode_one, mode_two = stress_intensity(material, Tractions(1.5, -0.5), 4.0)
    x = 1e-12
    u = 4.0 / x * material.shear_speed
    near = np.sqrt(2 * np.pi * x)
    assert 1.5 * float(stuck_traction(0.3, "I")(u)) * near == pytest.approx(mode_one, rel=1e-5)
    assert -0.5 * float(stuck_traction(0.3, "II")(u)) * near == pytest.approx(mode_two, rel=1e-5)
    assert stress_intensity(material, Tractions(1.0, 1.0), -1.0) == (0.0, 0.0)


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
