"""Lamb's functions against mpmath, elasticity in Fourier-Laplace space, and finite elements."""

import mpmath as mp
import numpy as np
import pytest

from docs.studies.article.prescribed import half_plane, march
from semianalytic import Material
from semianalytic.scene.errors import SceneError
from tests.semianalytic.reference.lamb import (
    lamb_functions,
    lamb_u1,
    lamb_u2,
    lamb_v1,
    lamb_v2,
    rayleigh_pulse,
    surface_displacement,
)

SOLID = Material(shear_modulus=2.0, density=0.5, poisson_ratio=0.3)


def loaded_half_plane(material, pressure, shear, size):
    """The surface at t = 1 under tractions on all of it; the side walls are at 1.8."""
    plane = half_plane(material, size, 1.8, 1.0)

    def force(time):
        now, load = np.full(len(plane.x), time), np.zeros(len(plane.root))
        load[plane.surface[0]] = -shear(plane.x, now) * plane.length
        load[plane.surface[1]] = pressure(plane.x, now) * plane.length
        return load

    return march(plane, force, None, None)


def surface_response(material: Material, k: complex) -> mp.matrix:
    """Displacement times s per unit force on the surface of y > 0, straight from (4.2), (4.15)."""
    a, b = 1 / mp.mpf(material.longitudinal_speed), 1 / mp.mpf(material.shear_speed)
    mu = mp.mpf(material.shear_modulus)
    lam = mu * ((b / a) ** 2 - 2)
    alpha, beta = mp.sqrt(a**2 - k**2), mp.sqrt(b**2 - k**2)
    # potentials e^{-alpha y}, e^{-beta y}: u_x = phi_x - psi_y, u_y = phi_y + psi_x
    motion = mp.matrix([[k, beta], [-alpha, k]])
    sigma_xy = [-2 * mu * k * alpha, mu * (k**2 - beta**2)]
    sigma_yy = [(lam + 2 * mu) * alpha**2 + lam * k**2, -2 * mu * k * beta]
    force = mp.matrix([[-sigma_xy[0], -sigma_xy[1]], [-sigma_yy[0], -sigma_yy[1]]])
    return motion * mp.inverse(force)


@pytest.mark.slow
@pytest.mark.parametrize("component", [(0, 0), (0, 1), (1, 0), (1, 1)])
@pytest.mark.parametrize("nu", [1 / 3, 0.1])
def test_transform_of_each_function(component, nu):
    """Laplace transform of G_ij at x > 0 by the closed form and by the inversion integral (4.33).

    The path k = eta (i - 1) decays like exp(-s eta x) and meets no singularity.
    """
    material = Material(2.0, 0.5, nu)
    a, b = 1 / material.longitudinal_speed, 1 / material.shear_speed
    c, x, s = 1 / material.rayleigh_speed, 0.7, 3.0
    i, j = component

    def path(eta):
        k = eta * mp.mpc(-1, 1)
        return mp.im(surface_response(material, k)[i, j] * mp.exp(s * k * x) * mp.mpc(-1, 1))

    with mp.workdps(20):
        inverted = mp.quad(path, [0, 0.5, 1, 2, 4, 16, 40]) / mp.pi

    name = f"{i + 1}{j + 1}"

    def function(time):
        return float(lamb_functions(material, x, float(time))[name].regular)

    ends = [a * x, b * x, 2 * c * x - b * x]
    # symmetric around the pole: pairs of nodes cancel
    pieces = [
        mp.quad(lambda th: _sine_share(function, ends[0], ends[1], th, s), [0, mp.pi / 2]),
        mp.quad(
            lambda d: (
                function(c * x - d) * mp.exp(-s * (c * x - d))
                + function(c * x + d) * mp.exp(-s * (c * x + d))
            ),
            [(c - b) * x * 1e-5, (c - b) * x / 8, (c - b) * x],
        ),
        mp.quad(lambda t: function(t) * mp.exp(-s * t), [ends[2], 2, 5, 12]),
    ]
    pulse = float(lamb_functions(material, x, 1.0)[name].pulse) * np.exp(-s * c * x)
    total = float(sum(pieces)) + pulse
    # the neighbourhood left out around the pole, and the mirror-image square root at 2c - b
    assert total == pytest.approx(float(inverted), rel=2e-4, abs=2e-6)


def _sine_share(function, left, right, theta, s):
    time = left + (right - left) * mp.sin(theta) ** 2
    return function(time) * mp.exp(-s * time) * (right - left) * mp.sin(2 * theta)


def test_symmetries():
    u = np.linspace(0.2, 1.5, 40)
    np.testing.assert_array_equal(lamb_v1(SOLID, u), -lamb_u2(SOLID, u))
    here, there = (lamb_functions(SOLID, x, 1.3) for x in (0.8, -0.8))
    assert here["11"].regular == there["11"].regular
    assert here["12"].regular == -there["12"].regular
    assert here["12"].pulse == -there["12"].pulse == rayleigh_pulse(SOLID)
    assert here["21"].pulse == -here["12"].pulse
    for function in (lamb_u1, lamb_v2):
        assert np.all(function(SOLID, 1 / SOLID.longitudinal_speed - np.array([0.1, 0.01])) == 0)


def test_static_limit_is_flamants():
    """Far behind the waves a force that lasts moves the surface like (1 - nu)/(pi mu) ln t."""
    t = 1e5
    functions = lamb_functions(SOLID, 1.0, t)
    expected = (1 - SOLID.poisson_ratio) / (np.pi * SOLID.shear_modulus)
    for name in ("11", "22"):
        assert float(functions[name].regular) * t == pytest.approx(expected, rel=1e-8)


def test_displacement_against_fourier_laplace_inversion():
    """(3.4), (3.5) against the equations of motion solved mode by mode.

    The trapezoidal sums converge geometrically for Gaussian pulses; 1e-8 of them is left out.
    """

    def in_time(t):
        return np.exp(-np.square((t - 1.0) / 0.2))

    def pressure(x, t):
        return np.exp(-np.square(x / 0.3)) * in_time(t)

    def shear(x, t):
        return 0.7 * np.exp(-np.square((x - 0.2) / 0.3)) * in_time(t)

    x, time = np.array([0.0, 0.6, -1.1, 2.0]), 1.9
    found = surface_displacement(SOLID, pressure, shear, x, time, rtol=1e-8)

    omega, wave = np.linspace(-45, 45, 901), np.linspace(-24, 24, 321)
    s, q = (1.5 + 1j * omega)[:, None], wave[None, :]
    tt, xx = np.linspace(-0.5, 2.5, 601), np.linspace(-2.5, 2.9, 541)
    laplace = np.exp(-np.outer(s[:, 0], tt)) @ in_time(tt) * (tt[1] - tt[0])
    fourier = np.exp(-1j * np.outer(wave, xx)) * (xx[1] - xx[0])
    normal = -laplace[:, None] * (fourier @ pressure(xx, 1.0))[None, :]
    tangential = laplace[:, None] * (fourier @ shear(xx, 1.0))[None, :]
    alpha = np.sqrt(q**2 + (s / SOLID.longitudinal_speed) ** 2)
    beta = np.sqrt(q**2 + (s / SOLID.shear_speed) ** 2)
    mu = SOLID.shear_modulus
    lam = SOLID.density * SOLID.longitudinal_speed**2 - 2 * mu
    yy = ((lam + 2 * mu) * alpha**2 - lam * q**2, -2j * mu * q * beta)
    xy = (-2j * mu * q * alpha, -mu * (beta**2 + q**2))
    determinant = yy[0] * xy[1] - yy[1] * xy[0]
    phi = (normal * xy[1] - yy[1] * tangential) / determinant
    psi = (yy[0] * tangential - xy[0] * normal) / determinant
    scale = (omega[1] - omega[0]) * (wave[1] - wave[0]) / (2 * np.pi) ** 2
    motion = (1j * q * phi + beta * psi, 1j * q * psi - alpha * phi)
    for axis, transform in zip((found.x, found.y), motion, strict=True):
        expected = [
            float((transform * np.exp(s * time + 1j * q * place)).sum().real) * scale for place in x
        ]
        np.testing.assert_allclose(axis, expected, atol=1e-7 * np.abs(found.y).max())


def test_displacement_against_finite_elements():
    """A short pulse on a free half-plane: second order in the element size."""
    solid = Material(1.0, 1.0, 1 / 3)

    def pressure(x, t):
        return np.exp(-np.square(x / 0.12) - np.square((t - 0.35) / 0.1))

    def shear(x, t):
        return 0.7 * np.exp(-np.square((x - 0.1) / 0.12) - np.square((t - 0.35) / 0.1))

    errors = []
    for size in (0.04, 0.02):
        motion = loaded_half_plane(solid, pressure, shear, size)
        inside = np.abs(motion.x) < 1.0
        exact = surface_displacement(solid, pressure, shear, motion.x[inside], 1.0, rtol=1e-5)
        errors.append(
            max(
                float(np.abs(seen[inside] - value).max() / np.abs(value).max())
                for seen, value in zip(motion.displacement, (exact.x, exact.y), strict=True)
            )
        )
    assert errors[1] < 0.012
    assert errors[1] < 0.4 * errors[0]


def test_bad_input():
    with pytest.raises(SceneError, match="other than the loaded point"):
        lamb_functions(SOLID, 0.0, 1.0)
    with pytest.raises(SceneError, match="smoother"):
        surface_displacement(
            SOLID,
            lambda x, t: np.where(np.abs(x) < 0.1, 1.0, 0.0) + 0 * t,
            lambda x, t: 0 * x * t,
            0.5,
            1.0,
            rtol=1e-12,
        )
