"""The compliance of two half-planes against impedances written down on their own."""

import numpy as np
import pytest
from dissimilar_pairs import PAIRS

from semianalytic import Material
from semianalytic.dissimilar.compliance import compliance_of

K = np.array([0.31 + 0.4j, -3 + 2j, 1.7j, -0.9 + 1e-3j])


def impedance(body, k):
    """Tractions (tau, sigma) of the upper face per velocity (v_x, v_y) of one half-plane."""
    alpha, beta = np.sqrt(body.a**2 - k**2 + 0j), np.sqrt(body.b**2 - k**2 + 0j)
    alpha, beta = (np.where(one.real < 0, -one, one) for one in (alpha, beta))
    bulk, q = alpha * beta + k**2, body.b**2 - 2 * k**2
    z11, z22 = (body.modulus * one * body.b**2 / bulk for one in (alpha, beta))
    z12 = -body.modulus * k * (2 * alpha * beta - q) / bulk
    return np.array([[-z11, -z12], [z12, -z22]])


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_rates_are_what_both_bodies_do_under_one_traction(pair):
    bodies = compliance_of(*pair)
    upper, lower = (impedance(body, K) for body in bodies.bodies)
    lower = lower * np.array([[-1, 1], [1, -1]])[..., None]  # y and sigma_xy change sign
    for i, k in enumerate(K):
        rates = np.linalg.inv(upper[:, :, i]) - np.linalg.inv(lower[:, :, i])
        entries = bodies.at(np.array([k]))
        compliance = (entries.matrix / entries.rayleigh[:, None, None])[0]
        np.testing.assert_allclose(-compliance, rates, rtol=1e-11)
        np.testing.assert_allclose(entries.inverse[0] @ compliance, np.eye(2), atol=1e-12)


def test_on_the_cut_it_is_the_limit_from_above():
    bodies, v = compliance_of(*PAIRS["0"]), np.array([0.3, 0.5, 0.62, 0.9, 1.4, 30.0])
    above = bodies.at(-v + 1e-13j)
    for name in ("normal", "tangential", "coupling", "determinant"):
        np.testing.assert_allclose(
            getattr(bodies.on_cut(v), name), getattr(above, name), rtol=1e-11
        )


def test_far_out_digits_are_kept():
    """What is formed without care loses all of them."""
    bodies = compliance_of(*PAIRS["A"])
    entries = bodies.at(np.array([1e7j]))
    ratio = (entries.coupling / entries.normal)[0]
    assert ratio == pytest.approx(1j * bodies.dundurs, rel=1e-13)


def test_exchange_of_the_bodies_changes_the_sign_of_the_coupling_alone():
    bodies = compliance_of(*PAIRS["0"])
    one, other = bodies.at(K), bodies.mirrored.at(K)
    np.testing.assert_allclose(one.coupling, -other.coupling, rtol=1e-13)
    np.testing.assert_allclose(one.determinant, other.determinant, rtol=1e-13)
    assert bodies.mirrored.dundurs == pytest.approx(-bodies.dundurs, rel=1e-13)


def test_units_do_not_matter():
    one = compliance_of(Material(3e9, 1200.0, 0.3), Material(7e10, 2700.0, 0.33))
    other = compliance_of(Material(3.0, 1.2, 0.3), Material(70.0, 2.7, 0.33))
    np.testing.assert_allclose(one.fronts, other.fronts, rtol=1e-14)
    assert one.lower.modulus == pytest.approx(other.lower.modulus, rel=1e-14)
