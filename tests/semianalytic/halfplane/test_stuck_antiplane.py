"""Stuck antiplane shear: traction, its slope and primitive in closed form, histories, intensity."""

import mpmath as mp
import numpy as np
import pytest

from semianalytic import Harmonic, Material, Ramp, Tabulated, Tractions
from semianalytic.halfplane.primitives import stuck_primitive
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stress_intensity, stuck_traction
from semianalytic.halfplane.stuck_histories import near_field, stuck_shear
from semianalytic.scene.loads import Step

UNIT = Material(1.0, 1.0, 1 / 3)
PLACES = (1 + 1e-6, 1.03999, 1.04001, 1.5, 2.0, 30.0)


def slope(v):
    """Im M(-v + i0) / (pi v M_+(0) M_+(v)), M = sqrt(1 - k^2), M_+ = sqrt(1 + k)."""
    return mp.sqrt(v - 1) / (mp.pi * v)


@pytest.mark.parametrize("u", PLACES)
def test_traction_and_primitive_against_quadrature(u):
    traction, primitive = stuck_traction(0.2, "III"), stuck_primitive(0.2, "III")
    exact = mp.quad(lambda r: 2 * r * slope(1 + r * r), [0, mp.sqrt(mp.mpf(u) - 1)])
    assert float(traction(u)) == pytest.approx(float(exact), rel=1e-11)
    assert float(traction.derivative(u)) == pytest.approx(float(slope(mp.mpf(u))), rel=1e-11)
    once = mp.quad(
        lambda r: 2 * r * (mp.mpf(u) - 1 - r * r) * slope(1 + r * r),
        [0, mp.sqrt(mp.mpf(u) - 1)],
    )
    assert float(primitive(u)) == pytest.approx(float(once), rel=1e-11)


def test_nothing_arrives_before_the_shear_wave():
    ahead = np.array([-1.0, 0.0, 0.6, 0.99, 1.0])
    for field in (stuck_traction(0.2, "III"), stuck_primitive(0.2, "III")):
        assert np.all(field(ahead) == 0)
    assert np.all(stuck_traction(0.2, "III").derivative(ahead) == 0)


@pytest.mark.parametrize("history", [Step(), Ramp(0.5), Harmonic(2.0)])
def test_histories_superpose_steps(history):
    """Against a table of many samples, whose kinks are exact."""
    t = np.linspace(0, 2, 4001)
    table = history if history == Step() else Tabulated(tuple(t), tuple(history.value(t)))
    x = np.array([0.1, 0.7])
    found = stuck_shear(history, 2.0, UNIT, x, 1.9, "III").value
    np.testing.assert_allclose(found, stuck_shear(table, 2.0, UNIT, x, 1.9, "III").value, atol=1e-5)


def test_intensity_is_the_limit_at_the_edge():
    """K_III = 2 Q_0 sqrt(2 c_t t/pi), of every solid; K_II and K_III are as M_+(0) of the modes."""
    for nu in (-0.5, 0.0, 0.45):
        material = Material(4.0, 1.0, nu)
        _, sheared = stress_intensity(material, Tractions(0.0, 1.5), 3.0, "III")
        assert sheared == pytest.approx(2 * 1.5 * np.sqrt(2 * 2.0 * 3.0 / np.pi), rel=1e-14)
        _, in_plane = stress_intensity(material, Tractions(0.0, 1.5), 3.0)
        at_zero = rayleigh_factors(nu).m_plus_at_zero
        assert sheared / in_plane == pytest.approx(at_zero["II"] / at_zero["III"], rel=1e-11)
    traction = stuck_shear(Step(), 1.5, material, 1e-9, 3.0, "III").value
    assert traction == pytest.approx(near_field(sheared, 1e-9), rel=1e-4)
