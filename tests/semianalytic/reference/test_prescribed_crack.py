"""Cracks of a prescribed speed: Kostrov's, Burridge's and Broberg's."""

import mpmath
import numpy as np
import pytest
import scipy

from semianalytic import Material, SceneError
from semianalytic.reference import prescribed_crack
from tests.line_march import march

SOLID = Material(1.0, 1.0, 1 / 3)
AMPLITUDES = {"II": 0.5882685, "I": 0.5135005, "III": 0.8257256}
"""A at half the speed of shear waves, nu = 1/3 (notes)."""
MODES = tuple(AMPLITUDES)


@pytest.mark.parametrize("mode", MODES)
def test_amplitudes_are_those_of_the_notes_and_of_mpmath(mode):
    crack = prescribed_crack(SOLID, 0.5, 1.0, mode)
    assert crack.amplitude == pytest.approx(AMPLITUDES[mode], abs=5e-8)
    with mpmath.workdps(40):

        def density(angle):
            eta = 2 * mpmath.tan(angle)
            alpha, beta = mpmath.sqrt(mpmath.mpf(1) / 4 + eta**2), mpmath.sqrt(1 + eta**2)
            rayleigh = (1 + 2 * eta**2) ** 2 - 4 * eta**2 * alpha * beta
            impedance = {"I": rayleigh / alpha, "II": rayleigh / beta, "III": beta}[mode]
            return impedance * mpmath.cos(angle) / 4

        panels = [0, 0.4, 0.8, 1.2, mpmath.pi / 2]
        integral = mpmath.quad(density, panels, method="gauss-legendre", maxdegree=4)
        assert crack.amplitude == pytest.approx(float(1 / (2 * integral)), rel=1e-12)


def test_the_antiplane_amplitude_is_an_elliptic_integral():
    """int sqrt(1 + eta^2) / (e^2 + eta^2)^(3/2) d eta = E(1 - 1/e^2) / e^2 (Kostrov)."""
    for speed in (0.1, 0.5, 0.9):
        known = 1 / scipy.special.ellipe(1 - speed**2)
        crack = prescribed_crack(SOLID, speed, 1.0, "III")
        assert crack.amplitude == pytest.approx(known, rel=1e-13)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.49])
def test_a_slow_crack_is_static(mode, nu):
    solid, speed = Material(2.0, 3.0, nu), 1e-5
    crack = prescribed_crack(solid, speed, 7.0, mode)
    assert crack.stress_intensity(4.0) == pytest.approx(7 * np.sqrt(np.pi * speed * 4), rel=1e-6)
    compliance = 1.0 if mode == "III" else 1 - nu
    slip = 2 * compliance * 7.0 / 2.0 * np.sqrt((4 * speed) ** 2 - (2 * speed) ** 2)
    assert crack.slip(2 * speed, 4.0) == pytest.approx(slip, rel=1e-6)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("nu", "speed"), [(1 / 3, 0.5), (0.0, 0.7), (0.45, 0.2), (-0.4, 0.72)])
def test_the_tip_is_that_of_fracture_mechanics(mode, nu, speed):
    """K is that of the traction ahead, and G = K^2 A(v) / 2 mu with Freund's functions of speed."""
    solid = Material(1.0, 1.0, nu)
    crack = prescribed_crack(solid, speed, 1.0, mode)
    intensity = float(crack.stress_intensity(1.0))
    near = np.array([1e-8, 1e-9]) * speed
    seen = crack.traction(speed + near, 1.0) * np.sqrt(2 * np.pi * near)
    assert seen == pytest.approx(intensity, rel=3e-3)
    assert abs(seen[1] / intensity - 1) < 0.5 * abs(seen[0] / intensity - 1)
    a, b = (np.sqrt(1 - (speed / c) ** 2) for c in (solid.longitudinal_speed, 1.0))
    rayleigh = 4 * a * b - (1 + b**2) ** 2
    freund = {"I": speed**2 * a / rayleigh, "II": speed**2 * b / rayleigh, "III": 1 / b}[mode]
    assert crack.energy_release_rate(1.0) == pytest.approx(intensity**2 * freund / 2, rel=1e-12)


def test_tips_at_the_limiting_speed_take_no_energy():
    for mode, limit in (("I", SOLID.rayleigh_speed), ("II", SOLID.rayleigh_speed), ("III", 1.0)):
        rates = [
            float(prescribed_crack(SOLID, limit * (1 - off), 1.0, mode).energy_release_rate(1.0))
            for off in (1e-2, 1e-4, 1e-6)
        ]
        assert rates[0] > rates[1] > rates[2] > 0
        assert rates[2] < 2e-3
        with pytest.raises(SceneError, match="speed must be below that of the"):
            prescribed_crack(SOLID, limit, 1.0, mode)


@pytest.mark.parametrize("mode", MODES)
def test_fields_are_causal_even_and_self_similar(mode):
    crack = prescribed_crack(SOLID, 0.5, 2.0, mode)
    x = np.linspace(0.01, 3, 50)
    for name, power in (("slip", 1), ("slip_rate", 0), ("traction", 0)):
        field = getattr(crack, name)
        assert field(x, 1.0) == pytest.approx(field(-x, 1.0))
        assert field(3 * x, 3.0) == pytest.approx(3**power * field(x, 1.0), rel=1e-9, abs=1e-12)
        assert np.all(field(x, -1.0) == 0)
    assert np.all(crack.traction(x[x < 0.5], 1.0) == -2.0)
    first = 1.0 if mode == "III" else 2.0
    assert np.all(crack.traction(x[x > first], 1.0) == 0)
    rate = (crack.slip(0.2, 1 + 1e-6) - crack.slip(0.2, 1 - 1e-6)) / 2e-6
    assert crack.slip_rate(0.2, 1.0) == pytest.approx(rate, rel=1e-8)


@pytest.mark.thinned(3)
@pytest.mark.skipif(not hasattr(scipy.interpolate, "AAA"), reason="scipy before 1.15")
@pytest.mark.parametrize("mode", MODES)
def test_an_independent_march_agrees(mode):
    nodes, length = 512, 2.4 if mode == "III" else 4.4
    h, nothing = length / nodes, 1e9
    seen = march(
        mode,
        1 / 3,
        nodes,
        length,
        1.0,
        lambda x, t: np.clip((0.5 * t - abs(x)) / h + 0.5, 0, 1),
        lambda x, t: np.where(abs(x) < 0.5 * t, -1.0, nothing),
    )
    slip = prescribed_crack(SOLID, 0.5, 1.0, mode).slip(seen.x, 1.0) / 2
    assert np.abs(seen.slip - slip).sum() / slip.sum() < 0.03


def test_what_is_no_crack_is_refused():
    for given, said in (
        ((0.0, 1.0, "II"), "speed must be positive"),
        ((0.5, np.nan, "II"), "drop must be a finite number"),
        ((0.5, 1.0, "IV"), "mode must be I, II or III"),
    ):
        with pytest.raises(SceneError, match=said):
            prescribed_crack(SOLID, *given)
