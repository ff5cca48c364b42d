"""Slip from the edge of a slot under a load and a strength that grow as a power of time."""

import mpmath
import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import semianalytic as sf
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.reference import antiplane_slip_rate, slip_rate_under_shear_step
from semianalytic.reference.antiplane import antiplane_traction
from semianalytic.whole_line.growing_zone import GrowingZone, finite_part, growing_zone
from tests.line_march import march as line_march

SOLID, NOTHING = sf.Material(1.0, 1.0, 1 / 3), sf.Tractions(0.0, 0.0)
RAMPS = [
    ("in-plane", 1, 0.5, 0.357143),
    ("in-plane", 1, 1.0, 0.183007),
    ("antiplane", 1, 0.5, 0.232037),
    ("antiplane", 1, 1.0, 0.120615),
]
"""Mode, n, strength over load, and speed of the edge (notes)."""


def slot(mode, power, ratio, solid=SOLID):
    return sf.Scene(solid, ratio, NOTHING, sf.GrowingLoad(1.0, 1.0, power), mode=mode)


# --- numbers --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("mode", "power", "ratio", "edge"), RAMPS)
def test_the_edge_of_a_ramp_is_that_of_the_notes(mode, power, ratio, edge):
    found = sf.solve(slot(mode, power, ratio))
    assert found.edge_speed == pytest.approx(edge, abs=5e-7)
    assert found.status == "converged"


@pytest.mark.parametrize("ratio", [0.5, 1.0])
def test_the_edge_of_a_ramp_is_that_of_mpmath(ratio):
    """(c + k) S_+(k) / sqrt(b + k), and its first coefficient at large k, at a = 1/2."""
    with mpmath.workdps(30):
        a = mpmath.mpf(1) / 2

        def rayleigh(v):
            root = mpmath.sqrt(v**2 - a**2) * mpmath.sqrt(v**2 - 1)
            return (1 - 2 * v**2) ** 2 - 4 * v**2 * root

        def phase(v):
            root = mpmath.sqrt((v**2 - a**2) * (1 - v**2))
            return mpmath.atan2(4 * v**2 * root, (1 - 2 * v**2) ** 2)

        c, ends = mpmath.findroot(rayleigh, 1.0724), [a, 1 / mpmath.sqrt(2), 1]
        first = c - a - mpmath.quad(phase, ends) / mpmath.pi
        assert float(first) == pytest.approx(0.3744733, abs=5e-8)
        at_zero = c * mpmath.exp(-mpmath.quad(lambda v: phase(v) / v, ends) / mpmath.pi)

        def excess(u):
            return (1.5 - first / u) / mpmath.sqrt(u) - 1 / ((1 + mpmath.mpf(ratio)) * at_zero)

        slowness = 1 / mpmath.mpf(sf.solve(slot("in-plane", 1, ratio)).edge_speed)
        assert excess(slowness * (1 + 1e-10)) < 0 < excess(slowness * (1 - 1e-10))


def test_the_antiplane_ramp_is_the_root_of_a_cubic():
    for ratio in (0.2, 0.5, 1.0, 30.0):
        y2 = 1 / sf.solve(slot("antiplane", 1, ratio)).edge_speed
        assert (3 * y2 - 1) / (2 * y2**1.5) == pytest.approx(1 / (1 + ratio), rel=1e-12)


@pytest.mark.parametrize("ratio", [0.7, 2.0])
def test_the_step_is_the_closed_form_of_the_reference(ratio):
    """n = 0 runs through the same code, which finite parts and polynomials then leave alone."""
    xi = np.array([0.01, 0.05, 0.1])
    plane, across = (
        growing_zone(rayleigh_factors(1 / 3, mode), 0, ratio) for mode in ("II", "III")
    )
    known = slip_rate_under_shear_step(SOLID, 1.0, ratio, xi) / 2
    assert plane.slip_rate(xi) == pytest.approx(known, rel=1e-12)
    known = antiplane_slip_rate(SOLID, 1.0, ratio, xi) / 2
    assert across.slip_rate(xi) == pytest.approx(known, rel=1e-12)
    xi = np.array([0.4, 0.6, 0.99])
    known = antiplane_traction(SOLID, 1.0, ratio, xi)
    assert across.traction(xi) == pytest.approx(known, rel=1e-10)


def test_finite_parts_of_powers_are_beta_functions():
    for power in (0, 1, 2):
        for lag in (0, 1, 2, 3):
            y, weight = finite_part(power, lag)
            for j in range(6):
                known = float(mpmath.beta(j + mpmath.mpf(1) / 2 - power, lag + 1))
                assert weight @ y**j == pytest.approx(known, rel=1e-11, abs=1e-11)


# --- limits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_much_strength_makes_it_static(mode, power):
    """Slow zones: binom(n + 1/2, n) / ((1 + chi) M_+(0)) is the root of the edge's speed."""
    ratio = 1e4
    found = sf.solve(slot(mode, power, ratio))
    stiff = 1.0 if mode == "antiplane" else 1 - SOLID.poisson_ratio
    limit = {1: 1.5, 2: 1.875}[power] ** -2 / (stiff * (1 + ratio) ** 2)
    assert found.edge_speed == pytest.approx(limit, rel=1e-5)


# --- invariants -----------------------------------------------------------------------------------


@settings(max_examples=12, deadline=None)
@given(
    st.sampled_from(["in-plane", "antiplane"]),
    st.sampled_from([1, 2]),
    st.floats(-0.8, 0.49),
    st.floats(0.05, 50.0),
)
def test_what_a_growing_load_obeys(mode, power, nu, ratio):
    solid = sf.Material(1.0, 1.0, nu)
    try:
        found = sf.solve(slot(mode, power, ratio, solid))
    except sf.SceneError as refusal:
        if "raise pressure or friction" not in str(refusal):
            raise
        return
    assert found.status == "converged"
    edge, t = found.edge_speed, 1.3
    inside, outside = np.linspace(1e-4, 0.999, 41) * edge * t, np.linspace(1, 9, 60) * edge * t
    assert np.all(found.slip_rate(inside, t) > 0)
    assert found.shear_traction(inside, t) == pytest.approx(ratio * t**power)
    held = found.shear_traction(outside, t)
    assert np.all(np.abs(held) <= ratio * t**power * (1 + 1e-9))
    assert held[0] == pytest.approx(ratio * t**power, rel=1e-6)
    # all over t^n depends on x/t alone
    x = np.concatenate([inside, outside[1:]])
    for name, degree in (("slip_rate", power), ("slip", power + 1), ("shear_traction", power)):
        field = getattr(found, name)
        assert field(x, t) == pytest.approx(t**degree * field(x / t, 1.0), rel=1e-7, abs=1e-11)
    first = solid.shear_speed if mode == "antiplane" else solid.longitudinal_speed
    assert found.shear_traction(1.0001 * first * t, t) == pytest.approx(0, abs=1e-13)
    assert found.frictional_work(t) > 0
    assert np.abs(found.zone.conditions[0]) < 1e-8 * ratio


@pytest.mark.parametrize(("mode", "power", "ratio"), [("in-plane", 1, 0.5), ("antiplane", 2, 1.0)])
def test_slip_and_totals_are_integrals_of_the_rate(mode, power, ratio):
    found = sf.solve(slot(mode, power, ratio))
    edge = found.edge_speed
    for x in (0.2 * edge, 0.9 * edge):
        slip = quad(lambda t, x=x: found.slip_rate(x, t), x / edge, 1)[0]
        assert found.slip(x, 1.0) == pytest.approx(slip, rel=1e-8)
    area = quad(lambda x: found.slip(x, 1.0), 1e-15, edge)[0]
    assert found.accumulated_slip(1.0) == pytest.approx(area, rel=1e-8)
    power_at = quad(lambda x: found.slip_rate(x, 1.0) * ratio, 1e-15, edge)[0]
    assert found.frictional_work(1.0) == pytest.approx(power_at / (2 * power + 2), rel=1e-8)
    assert found.max_slip(1.0) == pytest.approx(float(found.slip(1e-12, 1.0)), rel=1e-8)
    assert found.edge_slip_rate(1.0) == pytest.approx(float(found.slip_rate(1e-13, 1.0)), rel=1e-8)
    near = found.slip_rate(edge * (1 - 1e-8), 1.0) / 1e-4
    assert found.edge_amplitude == pytest.approx(near, rel=1e-6)


def test_the_other_sense_is_the_mirror_image():
    there = sf.solve(sf.Scene(SOLID, 0.5, NOTHING, sf.GrowingLoad(1.0, 1.0)))
    back = sf.solve(sf.Scene(SOLID, 0.5, NOTHING, sf.GrowingLoad(1.0, -1.0)))
    x = np.linspace(0.01, 2.5, 30)
    for name in ("slip", "slip_rate", "shear_traction"):
        assert np.all(getattr(there, name)(x, 1.0) == -getattr(back, name)(x, 1.0))
    assert back.max_slip(1.0) == there.max_slip(1.0) > 0
    assert np.all(there.pressure(x, 2.0) == 2.0)
    assert there.slip(0.1, [-1.0, 0.0]).tolist() == [0.0, 0.0]


def test_a_spoilt_edge_breaks_the_conditions():
    good = sf.solve(slot("in-plane", 1, 0.5)).zone
    off = GrowingZone(good.factors, 1, 0.5, good.edge * (1 + 1e-6))
    assert np.abs(off.conditions).max() > 1e-7 > 1e3 * np.abs(good.conditions).max()


# --- marches --------------------------------------------------------------------------------------


def marched_slot(mode, power, ratio, nodes):
    return line_march(
        {"in-plane": "II", "antiplane": "III"}[mode],
        SOLID.poisson_ratio,
        nodes,
        8.0,
        1.0,
        lambda x, t: np.where(x < 0, t**power, 0.0),
        lambda x, t: np.where(x < 0, -1.0, ratio * t**power),
    )


@pytest.mark.thinned(3)
@pytest.mark.skipif(not hasattr(scipy.interpolate, "AAA"), reason="scipy before 1.15")
@pytest.mark.parametrize(("mode", "power"), [("in-plane", 1), ("antiplane", 1), ("in-plane", 2)])
def test_an_independent_march_agrees(mode, power):
    found, seen = sf.solve(slot(mode, power, 0.5)), marched_slot(mode, power, 0.5, 1024)
    contact = (seen.x > 0) & (seen.x < 1.9)
    x = seen.x[contact]
    slip, rate = found.slip(x, 1.0) / 2, found.slip_rate(x, 1.0) / 2
    assert np.abs(seen.slip[contact] - slip).sum() / slip.sum() < 1e-3
    assert np.abs(seen.slip_rate[contact] - rate).sum() / rate.sum() < 1e-2
    held = found.shear_traction(x, 1.0)
    assert np.abs(seen.traction[contact] - held).max() < 1e-2


@pytest.mark.slow
def test_under_a_base_the_edge_accelerates_as_the_refusal_says():
    """x_s = (4/9) c_t t / ((1 - nu) (1 + f P_b / Q_0 t)^2), t^3 at first, in a march."""
    rate = 0.5
    scene = sf.Scene(
        SOLID, 1.0, sf.Tractions(1.0, 0.0), sf.Tractions(0.0, rate), shear_history=sf.Ramp(1.0)
    )
    marched = sf.solve(scene, method="space-time", end_time=1.0, nodes=2000, estimate=False)
    for t in (0.6, 0.8, 1.0):
        (zone,) = marched.zones_at(t)
        chi = 1 / (rate * t)
        slow = 4 / 9 * t / ((1 - SOLID.poisson_ratio) * (1 + chi) ** 2)
        assert zone.end == pytest.approx(slow, rel=0.05)


# --- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"base": sf.Tractions(1.0, 0.0)}, "with a base the edge of slip accelerates"),
        ({"friction": 0.0}, "friction must be positive"),
        ({"friction": sf.Coulomb(0.3, viscosity=0.1)}, "constant friction"),
        ({"shear_history": sf.Ramp(1.0)}, "leave out histories"),
        ({"friction": 0.01}, "faster than the Rayleigh wave"),
    ],
)
def test_a_growing_load_that_cannot_be_is_refused_in_a_sentence(change, said):
    load = sf.GrowingLoad(1.0, 1.0)
    parts = {"material": SOLID, "friction": 0.5, "base": NOTHING, "load": load}
    with pytest.raises(sf.SceneError, match=said) as refusal:
        sf.solve(sf.Scene(**{**parts, **change}))
    assert str(refusal.value).endswith(".")
    assert "\n" not in str(refusal.value)


def test_positions_are_on_the_contact():
    found = sf.solve(slot("in-plane", 1, 0.5))
    with pytest.raises(sf.SceneError, match="positive positions"):
        found.slip(0.0, 1.0)
    with pytest.raises(sf.SceneError, match="finite"):
        found.slip(1.0, np.nan)


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ((1.0, 1.0, 3), "power must be 1 or 2"),
        ((0.0, 1.0), "pressure must be positive"),
        ((1.0, 0.0), "without shear nothing slips"),
    ],
)
def test_a_load_that_does_not_grow_is_refused(numbers, said):
    with pytest.raises(sf.SceneError, match=said):
        sf.GrowingLoad(*numbers)
