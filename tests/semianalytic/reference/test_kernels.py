"""Kernels of section 4: signs, primitives, both slot conditions, exact transforms and FEM."""

import mpmath as mp
import numpy as np
import pytest
from catalogue import unit_scene

from docs.studies.article.cases import slot_errors, slot_rows
from docs.studies.article.kernels import (
    SlipHistory,
    interface_traction,
    local_impedance,
    square_root_panels,
)
from docs.studies.article.stuck import stuck_pressure, stuck_shear
from semianalytic import Material
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.errors import SceneError
from semianalytic.scene.tabulated import Tabulated
from semianalytic.selfsimilar.solver import solve

SOLID = Material(2.0, 0.5, 0.3)


def terms(u, mode, poisson_ratio=0.3):
    """The terms of Im M(-u + i0), b = mu = 1, with (1 - 2 u^2)^2 and with 4 u^2: -u K_b, -u K_a.

    The second less the first is right; the article prints a sum in (4.39), (4.40), (4.42), (4.43).
    """
    if mode == "III":
        return mp.mpf(0), mp.sqrt(u * u - 1) if u > 1 else mp.mpf(0)
    a = mp.mpf(rayleigh_factors(poisson_ratio).a)
    first, second = (mp.mpf(1), a) if mode == "II" else (a, mp.mpf(1))
    square = (1 - 2 * u * u) ** 2 / mp.sqrt(u * u - first**2) if u > first else mp.mpf(0)
    four = 4 * u * u * mp.sqrt(u * u - second**2) if u > second else mp.mpf(0)
    return square, four


@pytest.mark.parametrize("mode", ["I", "II", "III"])
def test_terms_are_the_impedance_on_the_cut(mode):
    """Im (mu/b^2) R / beta (alpha), or beta, at -u + i0, with mpmath's roots just above the cut."""
    a = rayleigh_factors(0.3).a
    for u in (0.6, 0.9, 1.01, 1.5, 7.0):
        k = mp.mpc(-u, 1e-18)
        alpha, beta = mp.sqrt(a**2 - k**2), mp.sqrt(1 - k**2)
        rayleigh = (1 - 2 * k**2) ** 2 + 4 * k**2 * alpha * beta
        impedance = {"I": rayleigh / alpha, "II": rayleigh / beta, "III": beta}[mode]
        square, four = terms(u, mode)
        assert float(four - square) == pytest.approx(float(mp.im(impedance)), rel=1e-12, abs=1e-12)


def test_printed_numerators_of_the_point_kernel():
    """The printed polynomials of (4.38) are right, the sign between the terms is not."""
    a, x, t = 0.5, 0.8, 1.3
    first = (-7 * x**6 + 46 * t**2 * x**4 - 60 * t**4 * x**2 + 24 * t**6) / (t**2 - x**2) ** 2.5
    second = 4 * (2 * a**4 * x**4 - 9 * a**2 * t**2 * x**2 + 6 * t**4) / (t**2 - a**2 * x**2) ** 1.5
    for number, printed in enumerate((first, second)):
        with mp.workdps(30):  # d^2/dx dt of (4.40), whose kernel is -term / t
            found = mp.diff(
                lambda x, t, n=number: -terms(t / x, "II", 1 / 3)[n] / t, (x, t), (1, 1)
            )
        assert float(found) == pytest.approx(printed / x**4, rel=1e-9)


@pytest.mark.parametrize("mode", ["I", "II"])
def test_static_limit_and_rayleigh_zero(mode):
    """The terms are 8 u^3 each where their difference, as printed their sum, is 2 (1 - a^2) u."""
    square, four = terms(mp.mpf(1e4), mode)
    static = 2 * (1 - rayleigh_factors(0.3).a ** 2) * 1e4
    assert float(four - square) == pytest.approx(static, rel=1e-6)
    assert float(four + square) > 1e6 * static
    square, four = terms(1 / mp.mpf(SOLID.rayleigh_speed / SOLID.shear_speed), mode)
    assert float(four - square) == pytest.approx(0, abs=1e-10)


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
    np.testing.assert_allclose(found, expected, rtol=2e-6)  # the table's interpolation
    held = interface_traction(_power(3), mode, SOLID, x, t, slot="held", rtol=1e-6)
    assert np.abs(held - expected).max() > 0.05 * np.abs(expected).max()


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
    tau = interface_traction(slip, "II", material, xi * t, t, rtol=1e-5)
    density = tau * t * np.exp(node - s * (1 + k * xi) * t) * weight / rate
    assert float(np.sum(xi_weight * density)) == pytest.approx(expected, rel=1e-4)


def transform(velocity, rise, k, far=0.0):
    """T_+ = kappa M_+(k) [k sum m(u_0) V' d xi_0 / (u_0 + k) - M_-(0) V(inf)], b = mu = 1.

    V' d xi_0 are rises of slip rate at velocities xi_0 [c_t], far is V(inf), at nu = 1/3.
    """
    factors, u = rayleigh_factors(1 / 3), 1 / np.asarray(velocity)
    cauchy = (factors.m_plus(u) * rise / (u + np.asarray(k)[..., None])).sum(axis=-1)
    return factors.kappa * factors.m_plus(k) * (k * cauchy - factors.m_plus(0.0) * far)


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
        expected = transform(middle, rise, k)
        assert found == pytest.approx(float(expected), rel=2e-5)


def test_constant_slip_cancels_the_stuck_transform():
    """T_+ for V(inf) = V(0+): kappa M_+(k) M_-(0) V, the transform of -(1 + q*) mu b V."""
    factors = rayleigh_factors(1 / 3)
    k = np.array([0.3, 1.0, 4.0])
    found = transform([1.0], [0.0], k, far=1.0)
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


def test_slip_that_jumps_is_refused():
    jump = SlipHistory(
        lambda x, t: np.where(x < 0.3, t, 0.0),
        lambda x, t: np.where(np.abs(x - 0.3) < 0.01, -50.0 * t, 0.0),
        lambda x, t: np.where(x < 0.3, 1.0, 0.0) + 0 * t,
    )
    with pytest.raises(SceneError, match="smoother slip"):
        interface_traction(jump, "II", SOLID, 0.4, 1.0, rtol=1e-10)
