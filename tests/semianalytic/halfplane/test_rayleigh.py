import mpmath
import numpy as np
import pytest

from semianalytic.halfplane.rayleigh import rayleigh_factors

POISSON_RATIOS = [-0.9, -0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499]


def phase_integral(a, k):
    """The integral of the phase of R over v + k, with 30 digits; its principal value at k < -1."""
    mpmath.mp.dps = 30

    def integrand(v):
        root = mpmath.sqrt(abs((v * v - a * a) * (1 - v * v)))
        return mpmath.atan2(4 * v * v * root, (1 - 2 * v * v) ** 2) / (v + k)

    return mpmath.quad(integrand, [a, (a + 1) / 2, 1])


@pytest.mark.thinned(4)
@pytest.mark.parametrize("nu", POISSON_RATIOS)
def test_s_plus_against_mpmath(nu):
    factors = rayleigh_factors(nu)
    for k in (0.0, 0.3, 1.0, 5.0, 1e3):
        known = mpmath.exp(-phase_integral(mpmath.mpf(factors.a), k) / mpmath.pi)  # (3.12)
        assert factors.s_plus(k) == pytest.approx(float(known), rel=1e-14)


@pytest.mark.parametrize("nu", POISSON_RATIOS)
def test_s_plus_at_zero_in_closed_form(nu):
    factors = rayleigh_factors(nu)
    exact = 1 / (2 * (1 - factors.a**2) * factors.c**2)
    assert float(factors.s_plus(0.0)) ** 2 == pytest.approx(exact, rel=4e-15)


@pytest.mark.parametrize("nu", POISSON_RATIOS)
def test_factors_multiply_to_the_rayleigh_function(nu):
    """R(k) = 2 (b^2 - a^2)(c^2 - k^2) S_+ S_-, continued to the cut by its own definition."""
    factors = rayleigh_factors(nu)
    a, c = factors.a, factors.c
    v = np.array([1.01, 1.3, 4.0, 50.0])
    direct = (1 - 2 * v**2) ** 2 - 4 * v**2 * np.sqrt((v**2 - a**2) * (v**2 - 1))
    # The direct form loses digits to cancellation as v^2.
    loss = 4e-16 * 16 * v**4 / np.abs(direct)
    reduced = factors.reduced_rayleigh(v) * (c**2 - v**2)
    assert np.all(np.abs(reduced / direct - 1) < 1e-13 + loss)


@pytest.mark.parametrize("mode", ["I", "II"])
@pytest.mark.parametrize("nu", [-0.5, 1 / 3])
def test_impedance_on_the_cut_is_the_limit_from_above(nu, mode):
    factors = rayleigh_factors(nu)
    a = factors.a
    for v in (a + 0.3 * (1 - a), 0.5 * (1 + factors.c), 2.5):
        k = mpmath.mpc(-v, 1e-12)
        alpha, beta = mpmath.sqrt(a * a - k * k), mpmath.sqrt(1 - k * k)
        rayleigh = (1 - 2 * k * k) ** 2 + 4 * k * k * alpha * beta
        limit = complex(rayleigh / (beta if mode == "II" else alpha))
        assert complex(factors.impedance_on_cut(factors.cut(v), mode)) == pytest.approx(
            limit, rel=1e-9
        )


@pytest.mark.parametrize("nu", POISSON_RATIOS)
def test_modulus_of_s_plus_on_the_cut_from_its_phase(nu):
    """|M_+(-v)| = |M| / (kappa M_+(v)) agrees with the principal value of (3.12)."""
    factors = rayleigh_factors(nu)
    a, v = factors.a, 1.7
    at = factors.cut(v)
    modulus = abs(factors.impedance_on_cut(at)) / (factors.kappa * factors.m_plus(v))
    s = mpmath.exp(-phase_integral(mpmath.mpf(a), -v) / mpmath.pi)
    expected = abs(factors.c - v) * float(s) / np.sqrt(v - 1)
    assert float(modulus) == pytest.approx(expected, rel=1e-12)


def test_hidden_root_is_complex_only_beyond_the_known_poisson_ratio():
    assert rayleigh_factors(0.26).hidden_root.imag == 0
    root = rayleigh_factors(1 / 3).hidden_root
    z, a2 = root**2, rayleigh_factors(1 / 3).a ** 2
    assert root.imag > 0
    assert abs((1 - 2 * z) ** 4 - 16 * z * z * (z - a2) * (z - 1)) < 1e-12


def test_distances_from_the_fronts_survive_where_subtraction_does_not():
    factors = rayleigh_factors(0.3)
    near = factors.beside("c", [-1e-40, 1e-40])
    assert near.minus(factors.front_c).tolist() == [-1e-40, 1e-40]
    assert near[[0]].first_below(near[[1]])
