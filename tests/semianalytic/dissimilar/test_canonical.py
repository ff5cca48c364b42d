"""Compliance of two bodies against impedances, the glued interface and its stuck tractions."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dissimilar_pairs import PAIRS

from semianalytic import Material, Ramp, Scene, SceneError, SlipWeakening, Tractions, solve
from semianalytic.dissimilar.canonical import glued
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.pair import check_bodies
from semianalytic.dissimilar_slot.densities.density import density_of
from semianalytic.dissimilar_slot.densities.interface import LoadedBodies
from semianalytic.dissimilar_slot.densities.panels import rule_for
from semianalytic.dissimilar_slot.densities.profile import NORMAL, SHEAR, PairProfile
from semianalytic.halfplane.stuck import stuck_traction

U = np.array([1.2, 2.0, 5.0])
STUCK = [
    ("0", (1, 0), "tau", (0.168679909716, 0.351847826061, 0.935652311922)),
    ("0", (1, 0), "sigma", (-0.055212904680, -0.049222763730, -0.012456083909)),
    ("0", (0, 1), "tau", (0.034802510129, 0.029863075714, 0.002552130594)),
    ("0", (0, 1), "sigma", (-0.007233598863, 0.098819820196, 0.501717392310)),
    ("A", (1, 0), "tau", (0.1452007430, 0.3112926453, 0.8631334959)),
    ("A", (1, 0), "sigma", (-0.0477395925, -0.0502682601, -0.0599980711)),
    ("A", (0, 1), "tau", (0.0337338626, 0.0360671167, 0.0438645833)),
    ("A", (0, 1), "sigma", (-0.0222496148, 0.0743440337, 0.4566574514)),
    ("A", (1, -0.5), "tau", (0.1283338117, 0.2932590870, 0.8412012042)),
    ("A", (1, -0.5), "sigma", (-0.0366147851, -0.0874402770, -0.2883267967)),
    ("PMMA on aluminium", (1, 0), "tau", (0.1888154696, 0.3912026783, 1.0116185781)),
    ("PMMA on aluminium", (1, 0), "sigma", (-0.1115655992, -0.1060088249, -0.0647595484)),
    ("PMMA on aluminium", (0, 1), "tau", (0.0640480416, 0.0600873340, 0.0324481489)),
    ("PMMA on aluminium", (0, 1), "sigma", (-0.0264051328, 0.0750141636, 0.4635445791)),
    ("PMMA on aluminium", (1, -0.5), "tau", (0.1567914488, 0.3611590113, 0.9953945037)),
    ("PMMA on aluminium", (1, -0.5), "sigma", (-0.0983630328, -0.1435159067, -0.2965318380)),
    ("C", (1, 0), "tau", (0.1331223901, 0.2871439443, 0.8176789074)),
    ("C", (1, 0), "sigma", (-0.0161300883, -0.0155086946, -0.0106095728)),
    ("C", (0, 1), "tau", (0.0107889442, 0.0102926333, 0.0066546672)),
    ("C", (0, 1), "sigma", (-0.0263808396, 0.0635714660, 0.4337815698)),
    ("C", (1, -0.5), "tau", (0.1277279180, 0.2819976277, 0.8143515739)),
    ("C", (1, -0.5), "sigma", (-0.0029396685, -0.0472944276, -0.2275003577)),
]
"""Pair, (Q_0, -P_0), and a traction at u = 1.2, 2, 5 b of the upper body: by Gauss-Legendre
quadrature of the same matrix on 160 nodes."""
K = np.array([0.31 + 0.4j, -3 + 2j, 1.7j, -0.9 + 1e-3j])


def stuck(bodies, load, tolerance=1e-13):
    interface = LoadedBodies(bodies, 0.3, 0.0, 1.0, 0.0, -load[1], load[0])
    density = density_of(interface, glued(bodies, tolerance), (), rule_for(1e-9))
    return PairProfile(density).at(U)[[SHEAR, NORMAL]]


@cache
def stuck_pair(name, load):
    return stuck(compliance_of(*PAIRS[name]), load)


@pytest.mark.parametrize(("name", "load", "traction", "known"), STUCK)
def test_stuck_tractions(name, load, traction, known):
    found = stuck_pair(name, load)[("tau", "sigma").index(traction)]
    np.testing.assert_allclose(found, known, rtol=0, atol=2e-11 if name == "0" else 7e-11)


def test_like_bodies_have_the_tractions_of_one():
    solid = Material(2.0, 3.0, 0.2)
    found = stuck(compliance_of(solid, solid), (1.0, 0.0))
    np.testing.assert_allclose(found, [stuck_traction(0.2, "II")(U), 0 * U], atol=1e-11)
    found = stuck(compliance_of(solid, solid), (0.0, -1.0))
    np.testing.assert_allclose(found, [0 * U, -stuck_traction(0.2, "I")(U)], atol=1e-11)


def test_the_identity_tells_the_error():
    rng = np.random.default_rng(3)
    for _ in range(6):
        bodies = compliance_of(
            Material(1.0, 1.0, rng.uniform(-0.3, 0.45)),
            Material(*np.exp(rng.uniform(-1.5, 1.5, 2)), rng.uniform(-0.3, 0.45)),
        )
        load = rng.normal(size=2)
        exact = stuck(bodies, load)
        for tolerance in (1e-4, 1e-7, 1e-10):
            matrix = glued(bodies, tolerance)
            told = matrix.error(np.append(0.0, U))
            error = np.abs(stuck(bodies, load, tolerance) - exact).max() / np.abs(load).max()
            assert error < 3 * told < 30 * tolerance


def test_both_sides_of_the_equation_meet_off_the_cuts():
    bodies = compliance_of(*PAIRS["0"])
    matrix, k = glued(bodies, 1e-12), np.array([0.2j, 0.01 - 0.7j])
    entries = bodies.at(k)
    compliance = entries.matrix / entries.rayleigh[:, None, None]
    np.testing.assert_allclose(compliance @ matrix.psi(k), matrix.rates(-k), rtol=1e-10)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"friction": 0.0}, "friction must be positive"),
        ({"base": Tractions(0.0, 0.0)}, "base pressure must be positive"),
        ({"base": Tractions(1.0, 0.3)}, "slide as a whole"),
        ({"lower_material": Material(1e6, 1.0, 0.3)}, "factor of 100000"),
        ({"friction": SlipWeakening(0.3, 0.15, 0.1)}, "friction is SlipWeakening"),
        ({"mode": "antiplane"}, "plane strain, a step of tractions on the slot"),
        ({"load_on": "remote"}, "simulate the scene"),
        ({"shear_history": Ramp(1.0)}, "shear_history: between different bodies"),
    ],
)
def test_what_is_not_solved_between_two_bodies_is_refused(change, complaint):
    bodies = {"material": Material(1.0, 1.0, 0.3), "lower_material": Material(2.0, 1.0, 0.3)}
    sound = Scene(**bodies, friction=0.3, base=Tractions(1.0, 0.0), load=Tractions(0.0, 1.0))
    check_bodies(sound)
    with pytest.raises(SceneError, match=complaint):
        solve(replace(sound, **change))


def impedance(body, k):
    """Tractions (tau, sigma) of the upper face per velocity (v_x, v_y) of one half-plane."""
    alpha, beta = np.sqrt(body.a**2 - k**2 + 0j), np.sqrt(body.b**2 - k**2 + 0j)
    alpha, beta = (np.where(factor.real < 0, -factor, factor) for factor in (alpha, beta))
    bulk, q = alpha * beta + k**2, body.b**2 - 2 * k**2
    z11, z22 = (body.modulus * factor * body.b**2 / bulk for factor in (alpha, beta))
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
    first, other = bodies.at(K), bodies.mirrored.at(K)
    np.testing.assert_allclose(first.coupling, -other.coupling, rtol=1e-13)
    np.testing.assert_allclose(first.determinant, other.determinant, rtol=1e-13)
    assert bodies.mirrored.dundurs == pytest.approx(-bodies.dundurs, rel=1e-13)


def test_units_do_not_matter():
    entries = compliance_of(Material(3e9, 1200.0, 0.3), Material(7e10, 2700.0, 0.33))
    other = compliance_of(Material(3.0, 1.2, 0.3), Material(70.0, 2.7, 0.33))
    np.testing.assert_allclose(entries.fronts, other.fronts, rtol=1e-14)
    assert entries.lower.modulus == pytest.approx(other.lower.modulus, rel=1e-14)
