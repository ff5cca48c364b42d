"""Kernels of section 4: signs, primitives, both slot conditions, exact transforms and FEM."""

import mpmath as mp
import numpy as np
import pytest
from catalogue import unit_scene

from docs.studies.article.cases import slot_errors, slot_rows
from docs.studies.article.stuck import stuck_pressure, stuck_shear
from semianalytic import Material
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.halfplane.velocities import square_root_panels
from semianalytic.reference.kernels import (
    SlipHistory,
    impedance_terms,
    interface_traction,
    local_impedance,
    point_kernel,
    regularised_kernel,
    self_similar_transform,
)
from semianalytic.scene.errors import SceneError
from semianalytic.scene.tabulated import Tabulated
from semianalytic.selfsimilar.solver import solve

SOLID = Material(2.0, 0.5, 0.3)


@pytest.mark.parametrize("mode", ["I", "II", "III"])
def test_terms_are_the_impedance_on_the_cut(mode):
    """Im (mu/b^2) R / beta (alpha), or beta, at -u + i0, with mpmath's roots just above the cut."""
    a = rayleigh_factors(0.3).a
    for u in (0.6, 0.9, 1.01, 1.5, 7.0):
        k = mp.mpc(-u, 1e-18)
        alpha, beta = mp.sqrt(a**2 - k**2), mp.sqrt(1 - k**2)
        rayleigh = (1 - 2 * k**2) ** 2 + 4 * k**2 * alpha * beta
        impedance = {"I": rayleigh / alpha, "II": rayleigh / beta, "III": beta}[mode]
        expected = float(mp.im(impedance))
        assert impedance_terms(0.3, u, mode).right == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("mode", ["I", "II", "III"])
def test_point_kernel_is_the_derivative_of_the_regularised_one(mode):
    """(4.35), (4.38) against numerical differentiation: d^2/dx dt of (4.39), (4.40)."""
    for x, t in ((1.0, 0.45), (1.0, 0.8), (-0.7, 2.0)):

        def kernel(place, time):
            u = time * SOLID.shear_speed / abs(place)
            terms = _mp_terms(u, mode)
            impedance = SOLID.shear_impedance
            return -mp.sign(place) * impedance * (terms[1] - terms[0]) / (mp.pi * time)

        with mp.workdps(30):
            expected = mp.diff(kernel, (x, t), (1, 1))
        assert point_kernel(SOLID, mode, x, t) == pytest.approx(float(expected), rel=1e-9)
        regularised = regularised_kernel(SOLID, mode, x, t)
        assert regularised == pytest.approx(float(kernel(x, t)), rel=1e-12)


def _mp_terms(u, mode):
    if mode == "III":
        return mp.mpf(0), mp.sqrt(u * u - 1) if u > 1 else mp.mpf(0)
    a = mp.mpf(rayleigh_factors(0.3).a)
    first, second = (mp.mpf(1), a) if mode == "II" else (a, mp.mpf(1))
    square = (1 - 2 * u * u) ** 2 / mp.sqrt(u * u - first**2) if u > first else mp.mpf(0)
    four = 4 * u * u * mp.sqrt(u * u - second**2) if u > second else mp.mpf(0)
    return square, four


def test_point_kernel_as_printed_numerators():
    """The printed polynomials of (4.38) are right, the sign between the terms is not."""
    material = Material(1.0, 1.0, 1 / 3)
    a, b, x, t = 0.5, 1.0, 0.8, 1.3
    first = (-7 * b**6 * x**6 + 46 * b**4 * t**2 * x**4 - 60 * b**2 * t**4 * x**2 + 24 * t**6) / (
        t**2 - b**2 * x**2
    ) ** 2.5
    second = 4 * (2 * a**4 * x**4 - 9 * a**2 * t**2 * x**2 + 6 * t**4) / (t**2 - a**2 * x**2) ** 1.5
    printed, right = (first + second) / (np.pi * x**4), (second - first) / (np.pi * x**4)
    assert point_kernel(material, "II", x, t, as_printed=True) == pytest.approx(printed, rel=1e-12)
    assert point_kernel(material, "II", x, t) == pytest.approx(right, rel=1e-12)


@pytest.mark.parametrize("mode", ["I", "II"])
def test_static_limit_and_rayleigh_zero(mode):
    factors = rayleigh_factors(0.3)
    x = 1e-4
    static = -2 * SOLID.shear_modulus * (1 - factors.a**2) / (np.pi * x)
    assert regularised_kernel(SOLID, mode, x, 1.0) == pytest.approx(static, rel=1e-6)
    printed = regularised_kernel(SOLID, mode, x, 1.0, as_printed=True)
    assert abs(printed / static) > 1e6  # like 8 u^3 instead
    at_rayleigh = 1 / SOLID.rayleigh_speed
    assert regularised_kernel(SOLID, mode, 1.0, at_rayleigh) == pytest.approx(0, abs=1e-10)


def _power(exponent):
    """V = t^exponent on all of x > 0."""
    return SlipHistory(
        lambda x, t: t**exponent + 0 * x,
        lambda x, t: 0 * x * t,
        lambda x, t: exponent * t ** (exponent - 1) + 0 * x,
    )


@pytest.mark.parametrize("mode", ["I", "II", "III"])
def test_uniform_slip_with_a_free_slot_is_the_stuck_problem(mode):
    """V(t) on all of x > 0 takes the traction -M(0) [V + int V' q*]: theory and another code."""
    x, t = np.array([0.2, 0.7, 1.5, 3.0]), 1.1
    found = interface_traction(_power(3), mode, SOLID, x, t, rtol=1e-7)
    times = np.linspace(0, t, 4001)
    table = Tabulated(tuple(times), tuple(times**3))
    if mode == "I":
        stuck = stuck_pressure(table, 1.0, SOLID, x, t).value
    else:
        stuck = stuck_shear(table, 1.0, SOLID, x, t, mode).value
    sign = 1 if mode == "I" else -1
    expected = sign * local_impedance(SOLID, mode) * (t**3 + stuck)
    np.testing.assert_allclose(found.value, expected, rtol=2e-6)  # the table's interpolation
    held = interface_traction(_power(3), mode, SOLID, x, t, slot="held", rtol=1e-6)
    assert np.abs(held.value - expected).max() > 0.05 * np.abs(expected).max()


@pytest.mark.slow
def test_exact_transform_of_decaying_slip():
    """V = t^2 e^{-lambda x}: T_+ is a product of factors, [M_-/(k + l)]_+ = M_+(l)/(k + l)."""
    material, decay, s, k = Material(1.0, 1.0, 1 / 3), 1.5, 2.0, 0.7
    factors = rayleigh_factors(1 / 3)
    slip = SlipHistory(
        lambda x, t: t**2 * np.exp(-decay * x),
        lambda x, t: -decay * t**2 * np.exp(-decay * x),
        lambda x, t: 2 * t * np.exp(-decay * x),
    )
    wave = decay / s
    # transform over x e^{-s k x} dx and t e^{-s t} dt; the double transform of t^2 e^{-decay x}
    laplace_time = 2 / s**3
    expected = -float(factors.kappa * factors.m_plus(k) * factors.m_plus(wave))
    expected *= laplace_time / (s * (k + wave))
    node, weight = (part[:9] for part in np.polynomial.laguerre.laggauss(12))  # the rest: < 1e-7
    xi, xi_weight = (
        part[:, None] for part in square_root_panels([0.0, 1.0, 2.0, 4.0, 12.0, 50.0, 250.0], 10)
    )
    # each ray has its own rate of decay; beyond c_l = 2 slip itself decays like e^{-decay x}
    rate = s * (1 + k * xi) + np.where(xi > 2, decay * xi, 0.0)
    t = node / rate
    tau = interface_traction(slip, "II", material, xi * t, t, rtol=1e-5).value
    density = tau * t * np.exp(node - s * (1 + k * xi) * t) * weight / rate
    assert float(np.sum(xi_weight * density)) == pytest.approx(expected, rel=1e-4)


def test_self_similar_transform_of_a_solved_scene():
    """Slip rate and traction of the solver, transformed, satisfy the exact Wiener-Hopf relation."""
    scene = unit_scene(1.0)
    solution = solve(scene)
    edge = solution.zones[0].outer
    # rises of V between close nodes that crowd at its square-root end
    nodes = edge * np.sin(np.linspace(0, np.pi / 2, 4001)[1:]) ** 2
    rise = np.diff(solution.slip_rate(nodes, 1.0)) / 2
    middle = (nodes[1:] + nodes[:-1]) / 2
    stuck = stuck_traction(1 / 3, "II")
    places, weights = square_root_panels([0.0, 0.01 * edge, 0.2 * edge, edge, 1.0, 2.0], 60)
    correction = solution.shear_traction(places, 1.0) - stuck(1 / places)
    for k in (0.5, 2.0):
        # int d tau / (1 + k xi) over the whole line, tau being 0 on the slot, by parts
        found = float(np.sum(weights * correction * k / np.square(1 + k * places)))
        expected = self_similar_transform(1 / 3, middle, rise, k)
        assert found == pytest.approx(float(expected), rel=2e-5)


def test_constant_slip_cancels_the_stuck_transform():
    """T_+ for V(inf) = V(0+): kappa M_+(k) M_-(0) V, the transform of -(1 + q*) mu b V."""
    factors = rayleigh_factors(1 / 3)
    k = np.array([0.3, 1.0, 4.0])
    found = self_similar_transform(1 / 3, [1.0], [0.0], k, far=1.0)
    expected = -factors.m_plus(k) / factors.m_plus(0.0)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["I", "II"])
def test_finite_elements_take_the_free_slot(mode):
    """The kernel with the slot free meets the simulation to first order; the article's does not."""
    rows = slot_rows(mode, 0.01)
    (coarse,), (fine,) = slot_errors(slot_rows(mode, 0.02)), slot_errors(rows)
    assert fine["free"] < 0.015
    assert fine["free"] < 0.75 * coarse["free"]
    assert fine["held"] > 0.25
    slot = [row for row in rows if row["x"] < 0]
    assert all(row["simulated"] == 0 for row in slot)
    largest = max(abs(row["simulated"]) for row in rows)
    assert max(abs(row["held"]) for row in slot) > 0.25 * largest


def test_bad_input():
    with pytest.raises(SceneError, match="slot must be"):
        interface_traction(_power(2), "II", SOLID, 1.0, 1.0, slot="open")
    with pytest.raises(SceneError, match="x = 0"):
        interface_traction(_power(2), "II", SOLID, 0.0, 1.0)
    jump = SlipHistory(
        lambda x, t: np.where(x < 0.3, t, 0.0),
        lambda x, t: np.where(np.abs(x - 0.3) < 0.01, -50.0 * t, 0.0),
        lambda x, t: np.where(x < 0.3, 1.0, 0.0) + 0 * t,
    )
    with pytest.raises(SceneError, match="smoother slip"):
        interface_traction(jump, "II", SOLID, 0.4, 1.0, rtol=1e-10)
