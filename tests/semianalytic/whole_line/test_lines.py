"""Slip and opening around a patch or a point force on a line without a slot, and refusals."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import semianalytic as sf
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.whole_line.spreading import Spreading, least_missing
from tests.line_march import march as line_march

SOLID = sf.Material(1.0, 1.0, 1 / 3)
BASE = sf.Tractions(1.0, 0.0)

PATCHES = [
    ("II", 0.3, 0.5, 0.395154),
    ("II", 0.6, 0.6, 0.665193),
    ("III", 0.3, 0.5, 0.384265),
    ("III", 0.6, 0.6, 0.648852),
    ("I", 0.3, 0.5, 0.372636),
    ("I", 0.6, 0.6, 0.631335),
]
"""Mode, speed of the patch, what is missing over the excess, and speed of the edge (notes)."""


def patch_line(mode, speed, missing, solid=SOLID):
    """A line whose patch adds 1 to what drives motion, of which `missing` are missing."""
    if mode == "I":
        return sf.Scene(solid, 0.5, sf.Tractions(missing, 0.0), sf.Patch(speed, pressure=-1.0))
    shear = "antiplane" if mode == "III" else "in-plane"
    return sf.Scene(solid, missing, BASE, sf.Patch(speed, shear=1.0), mode=shear)


def plain(mode, eta):
    """M(i eta) at nu = 1/3 as it is written, with mpmath."""
    alpha, beta = mpmath.sqrt(mpmath.mpf(1) / 4 + eta**2), mpmath.sqrt(1 + eta**2)
    rayleigh = (1 + 2 * eta**2) ** 2 - 4 * eta**2 * alpha * beta
    return {"I": rayleigh / alpha, "II": rayleigh / beta, "III": beta}[mode]


def gauss(density):
    """The integral from 0 to pi/2; Gauss points stay off its end, where M loses digits."""
    panels = [0, 0.4, 0.8, 1.2, mpmath.pi / 2]
    return mpmath.quad(density, panels, method="gauss-legendre", maxdegree=4)


def rates(answer, x, t):
    return answer.gap_rate(x, t) if answer.drive.opens else answer.slip_rate(x, t)


def driving(answer, x, t):
    """The traction that drives motion, above that of the base."""
    line = answer.drive
    if line.opens:
        return line.base.pressure - answer.pressure(x, t)
    return line.sense * (answer.shear_traction(x, t) - line.base.shear)


# --- numbers --------------------------------------------------------------------------------------


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("mode", "speed", "missing", "edge"), PATCHES)
def test_the_edge_of_a_patch_is_that_of_the_notes_and_of_mpmath(mode, speed, missing, edge):
    found = sf.solve(patch_line(mode, speed, missing))
    assert found.edge_speed == pytest.approx(edge, abs=5e-7)
    assert found.status == "converged"
    with mpmath.workdps(40):
        end = 1 / mpmath.mpf(speed)

        def excess(edge):
            """What is left of the condition at the edge, over the angle of eta = edge tan."""
            constant = 2 * end * mpmath.sqrt(end**2 - edge**2) / abs(plain(mode, 1j * end).imag)

            def density(angle):
                eta = edge * mpmath.tan(angle)
                return plain(mode, eta) / (end**2 + eta**2) / mpmath.cos(angle)

            integral = gauss(density)
            return constant / mpmath.pi * integral - (1 - mpmath.mpf(missing))

        slowness = 1 / mpmath.mpf(found.edge_speed)
        assert excess(slowness * (1 + 1e-9)) < 0 < excess(slowness * (1 - 1e-9))


def test_the_edge_of_a_point_force_is_that_of_the_notes_and_of_mpmath():
    found = sf.solve(sf.Scene(SOLID, 1.0, BASE, sf.PointForce(shear=1.0)))
    assert found.edge_speed == pytest.approx(0.290552362, abs=5e-10)
    with mpmath.workdps(45):

        def missing(edge):
            def density(angle):
                eta = edge * mpmath.tan(angle)
                rest = mpmath.mpf(3) / 2 - plain("II", eta) * mpmath.cos(angle) / edge
                return rest * edge / mpmath.cos(angle) ** 2

            whole = gauss(density)
            return whole / (mpmath.mpf(3) / 2 * mpmath.pi) - 1

        slowness = 1 / mpmath.mpf(found.edge_speed)
        assert missing(slowness * (1 - 1e-9)) < 0 < missing(slowness * (1 + 1e-9))


@pytest.mark.parametrize("mode", ["I", "II", "III"])
def test_a_small_patch_is_a_point_force(mode):
    speed, sheared = 1e-4, mode != "I"
    force = {"shear" if sheared else "pressure": 1.0 if sheared else -1.0}
    stress = {name: value / (2 * speed) for name, value in force.items()}
    shear = "antiplane" if mode == "III" else "in-plane"
    point, patch = (
        sf.solve(sf.Scene(SOLID, 0.8, sf.Tractions(1.0, 0.0), load, mode=shear))
        for load in (sf.PointForce(**force), sf.Patch(speed, **stress))
    )
    assert patch.edge_speed == pytest.approx(point.edge_speed, rel=1e-6)
    x = np.array([0.05, 0.2])
    assert rates(patch, x, 1.0) == pytest.approx(rates(point, x, 1.0), rel=1e-5)


# --- limits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["I", "II", "III"])
@pytest.mark.parametrize("missing", [0.2, 0.5, 0.9])
def test_a_slow_patch_is_static(mode, missing):
    """Without waves the zone ends where int (excess - missing) / sqrt(l^2 - x^2) dx vanishes."""
    speed = 1e-5
    found = sf.solve(patch_line(mode, speed, missing))
    assert speed / found.edge_speed == pytest.approx(np.sin(np.pi * missing / 2), rel=1e-8)
    # and its slip is that of a static crack under the stresses of patch and strength
    stiffness = 1.0 if mode == "III" else 1 / (1 - SOLID.poisson_ratio)
    reach, x = found.edge_speed, np.array([0.3, 0.9]) * found.edge_speed

    def kernel(x, s):
        root = np.sqrt((reach**2 - x**2) * (reach**2 - s**2))
        return np.log(abs((reach**2 - x * s + root) / (reach * (x - s)))) / np.pi

    ends = [-reach, -speed, speed, reach]
    for place in x:
        slip = 0.0
        stops = sorted([*ends, place])  # the kernel is infinite at s = x
        for left, right in pairwise(stops):
            stress = 1 - missing if abs(left + right) < 2 * speed else -missing
            part = quad(lambda s, x=place: kernel(x, s), left, right, epsabs=1e-16, limit=400)[0]
            slip += stress * part
        moved = found.gap(place, 1.0) if mode == "I" else found.slip(place, 1.0)
        assert moved == pytest.approx(2 * slip / stiffness, rel=1e-5)


def test_an_edge_that_is_held_more_keeps_to_the_patch():
    near = sf.solve(patch_line("II", 0.4, 0.999999))
    assert 0 < near.edge_speed / 0.4 - 1 < 1e-9


# --- invariants -----------------------------------------------------------------------------------

LINES = st.builds(
    lambda mode, nu, share, d: patch_line(
        mode, share * (1.0 if mode == "III" else _rayleigh(nu)), d, sf.Material(1.0, 1.0, nu)
    ),
    st.sampled_from(["I", "II", "III"]),
    st.floats(-0.8, 0.49),
    st.floats(0.01, 0.95),
    st.floats(0.02, 0.98),
)


def _rayleigh(nu):
    return sf.Material(1.0, 1.0, nu).rayleigh_speed


@settings(max_examples=15, deadline=None)
@given(LINES)
def test_what_a_line_obeys(line):
    try:
        found = sf.solve(line)
    except sf.SceneError as refusal:
        if "more than" not in str(refusal):
            raise
        return
    assert found.status == "converged"
    assert found.error_estimate < 1e-9
    edge, t = found.edge_speed, 1.7
    assert line.load.speed < edge < line.material.shear_speed
    inside = np.linspace(-0.999, 0.999, 41) * edge * t
    outside = np.linspace(1 + 1e-9, 6, 60) * edge * t
    assert np.all(rates(found, inside, t) > 0)  # it moves in the sense of its load
    assert np.all(rates(found, outside, t) == 0)
    drive = found.drive
    driven, missing = driving(found, outside, t), drive.missing
    assert np.all(driven <= missing * (1 + 1e-12))  # Coulomb, or no tension
    if not drive.opens:
        assert np.all(np.abs(found.shear_traction(outside, t)) <= drive.strength * (1 + 1e-12))
        assert found.shear_traction(inside, t) == pytest.approx(drive.strength)
        assert found.frictional_work(t) == pytest.approx(
            drive.strength * found.accumulated_slip(t), rel=1e-12
        )
    else:
        assert np.all(found.pressure(inside, t) == 0)
        assert found.frictional_work(t) == 0
    # rounding of x/t is a root of the distance from the edge
    assert driving(found, edge * t, t) == pytest.approx(missing, rel=1e-6)
    for name in ("slip", "gap", "slip_rate", "shear_traction", "pressure"):  # symmetry, and scaling
        field = getattr(found, name)
        power = t if name in ("slip", "gap") else 1.0
        both = np.concatenate([inside, outside])
        assert field(both, t) == pytest.approx(field(-both, t), rel=1e-12, abs=1e-15)
        assert field(both, t) == pytest.approx(power * field(both / t, 1.0), rel=1e-9, abs=1e-12)
    # nothing is felt ahead of the first wave
    first = line.material.shear_speed if line.antiplane else line.material.longitudinal_speed
    assert driving(found, 1.0001 * first * t, t) == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize(("mode", "speed", "missing", "_"), PATCHES[::2])
def test_the_energy_of_the_waves_is_positive_and_less_than_what_is_set_free(
    mode, speed, missing, _
):
    """The faces do work on the bodies against what their motion adds to the traction."""
    found = sf.solve(patch_line(mode, speed, missing))
    sent = freed = 0.0
    t, weight = np.polynomial.legendre.leggauss(60)
    angle = (t + 1) * np.pi / 4
    for left, right, excess in ((0.0, speed, 1.0), (speed, found.edge_speed, 0.0)):
        x = left + (right - left) * np.sin(angle) ** 2
        moved = weight * np.pi / 4 * (right - left) * np.sin(2 * angle) @ rates(found, x, 1.0)
        sent += (excess - missing) * moved
        freed += excess * moved
    assert 0 < sent < freed


def test_slip_is_the_integral_of_its_rate_and_the_area_that_of_slip():
    found = sf.solve(sf.Scene(SOLID, 0.5, sf.Tractions(1, 0.1), sf.Patch(0.3, -0.4, 0.5)))
    edge = found.edge_speed
    for x in (0.0, 0.1, 0.299, 0.35):
        begins = x / edge
        stops = [x / 0.3] if begins < x / 0.3 < 1 else None
        slip = quad(lambda t, x=x: found.slip_rate(x, t), begins, 1, points=stops, limit=200)[0]
        assert found.slip(x, 1.0) == pytest.approx(slip, rel=1e-8)
    area = 2 * quad(lambda x: found.slip(x, 1.0), 0, edge, points=[0.3])[0]
    assert found.accumulated_slip(1.0) == pytest.approx(area, rel=1e-8)

    def power(x):
        return found.slip_rate(x, 1.0) * found.shear_traction(x, 1.0)

    work = quad(power, 0, edge, points=[0.3], limit=300)[0]
    assert found.frictional_work(1.0) == pytest.approx(work, rel=1e-8)
    assert found.pressure(0.2, 1.0) == 0.6
    near = found.slip_rate(edge * (1 - 1e-8), 1.0) / 1e-4
    assert found.edge_amplitude == pytest.approx(near, rel=1e-6)


def test_the_other_sense_is_the_mirror_image():
    there, back = (
        sf.solve(sf.Scene(SOLID, 0.5, sf.Tractions(1, s * 0.1), sf.Patch(0.3, 0.1, s * 0.8)))
        for s in (1, -1)
    )
    x = np.linspace(-1, 1, 21)
    for name in ("slip", "slip_rate", "shear_traction"):
        assert np.all(getattr(there, name)(x, 1.0) == -getattr(back, name)(x, 1.0))
    assert back.zones[0].sense == -1
    assert back.frictional_work(1.0) == there.frictional_work(1.0) > 0


def test_units_scale():
    solid = sf.Material(30e9, 2700.0, 1 / 3)
    line = sf.Scene(
        solid, 0.5, sf.Tractions(4e6, 0.0), sf.Patch(0.3 * solid.shear_speed, shear=4e6)
    )
    found, plain = sf.solve(line), sf.solve(patch_line("II", 0.3, 0.5))
    c = solid.shear_speed
    assert found.edge_speed == pytest.approx(plain.edge_speed * c, rel=1e-12)
    assert found.slip_rate(0.2 * c, 1.0) == pytest.approx(
        plain.slip_rate(0.2, 1.0) * 4e6 / solid.shear_impedance, rel=1e-12
    )
    work = plain.frictional_work(1.0) * 4e6**2 / solid.shear_impedance * c
    assert found.frictional_work(1.0) == pytest.approx(work, rel=1e-12)
    force = sf.Scene(solid, 1.0, sf.Tractions(4e6, 0.0), sf.PointForce(shear=4e6 * c))
    assert sf.solve(force).edge_speed == pytest.approx(0.29055236202 * c, rel=1e-10)


# --- a half-line is a slot ------------------------------------------------------------------------


def test_a_half_line_moves_like_a_slot_that_sheds_its_excess():
    line = sf.Scene(SOLID, 1.0, sf.Tractions(1.0, 0.25), sf.HalfLine(shear=1.5))
    found = sf.solve(line)
    assert isinstance(found, sf.Solution)
    assert found.scene.load == sf.Tractions(0.0, 0.75)
    chi = 0.75 / 0.75
    assert found.zones[0].outer == pytest.approx(1 / ((1 - 1 / 3) * (1 + chi) ** 2), rel=1e-9)
    # x < 0 slips everywhere in the sense of the load, as the half-line is taken to
    x = -np.linspace(0.01, 1.99, 60)
    faces = found.velocity(x, np.full(60, 0.0), 1.0) - found.velocity(x, np.full(60, -0.0), 1.0)
    assert np.all(faces[0] > 0)


def test_a_half_line_that_opens_is_a_slot_under_pressure():
    found = sf.solve(sf.Scene(SOLID, 0.3, BASE, sf.HalfLine(pressure=-2.0)))
    assert found.scene.load == sf.Tractions(-1.0, 0.0)
    assert found.openings[0].outer == pytest.approx(0.1875, rel=1e-9)


# --- an independent march -------------------------------------------------------------------------


def marched_patch(mode, speed, missing, nodes):
    length = 2.4 if mode == "III" else 4.4
    h = length / nodes
    return line_march(
        mode,
        SOLID.poisson_ratio,
        nodes,
        length,
        1.0,
        lambda x, t: np.clip((speed * t - abs(x)) / h + 0.5, 0, 1),
        lambda x, t: np.full(x.shape, missing),
    )


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(scipy.interpolate, "AAA"), reason="scipy before 1.15")
@pytest.mark.parametrize(("mode", "speed", "missing", "_"), PATCHES)
def test_a_march_converges_to_the_answer(mode, speed, missing, _):
    found = sf.solve(patch_line(mode, speed, missing))
    for nodes, edge, moved in ((512, 0.02, 2e-3), (2048, 7e-3, 3e-4)):
        seen = marched_patch(mode, speed, missing, nodes)
        assert seen.edge == pytest.approx(found.edge_speed, rel=edge)
        slip = (found.gap if mode == "I" else found.slip)(seen.x, 1.0) / 2
        assert np.abs(seen.slip - slip).sum() / slip.sum() < moved
        ahead = np.abs(seen.x) > found.edge_speed + 0.02
        held = driving(found, seen.x[ahead], 1.0)
        assert np.abs(seen.traction[ahead] - held).max() < 0.04


# --- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"load": sf.Patch(0.3, shear=0.5)}, "nothing slips"),
        ({"load": sf.Patch(0.95, shear=1.0)}, "slower than the Rayleigh wave, 0.932526"),
        ({"friction": -0.1}, "friction must not be negative"),
        ({"base": sf.Tractions(-1.0, 0.0)}, "base pressure must not be negative"),
        ({"base": sf.Tractions(1.0, 0.5)}, "would slide as a whole"),
        ({"load": sf.Patch(0.3, -2.0, 1.0)}, "opens the interface"),
        ({"load": sf.PointForce(1.0, 1.0)}, "set its pressure or its shear to 0"),
        ({"load": sf.PointForce(1.0, 0.0)}, "moves nothing"),
        ({"mode": "mode II"}, "mode must be"),
        ({"units": "cgs"}, "units must be"),
        ({"material": 1.0}, "material must be a Material"),
        ({"friction": 0.1}, "a second zone of slip starts at the shear wave"),
        ({"friction": 1e-4}, "no edge slower than the Rayleigh wave"),
    ],
)
def test_a_line_that_cannot_be_is_refused_in_a_sentence(change, said):
    parts = {"material": SOLID, "friction": 0.5, "base": BASE, "load": sf.Patch(0.3, shear=1.0)}
    with pytest.raises(sf.SceneError, match=said) as refusal:
        sf.solve(sf.Scene(**{**parts, **change}))
    assert refusal.value.exit_code == 2
    assert str(refusal.value).endswith(".")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("speed", [0.0, np.inf])
def test_a_speed_beyond_all_sense_is_refused(speed):
    with pytest.raises(sf.SceneError, match=r"patch: (speed must|its ends must move)"):
        sf.Patch(speed, shear=1.0)


def test_the_threshold_that_a_refusal_names_is_right():
    least = least_missing(rayleigh_factors(1 / 3), 0.3)
    sf.solve(patch_line("II", 0.3, least * 1.001))
    with pytest.raises(sf.SceneError, match=f"more than {least:.4g}"):
        sf.solve(patch_line("II", 0.3, least * 0.999))
    # at it, shear at the shear wave is strength
    found = sf.solve(patch_line("II", 0.3, least * (1 + 1e-9)))
    speed, base = found.scene.material.shear_speed, found.scene.base.shear
    assert found.shear_traction(speed, 1.0) - base == pytest.approx(least, rel=1e-6)


def test_x_and_t_must_be_finite():
    found = sf.solve(patch_line("II", 0.3, 0.5))
    for ask, at in ((found.slip, (np.nan, 1.0)), (found.pressure, (1.0, np.inf))):
        with pytest.raises(sf.SceneError, match="finite"):
            ask(*at)
    with pytest.raises(sf.SceneError, match="zones_at: t"):
        found.zones_at(np.nan)


def test_solve_and_march_name_what_takes_a_line():
    line = patch_line("II", 0.3, 0.5)
    for function in (
        lambda argument: sf.solve(argument, method="space-time"),
        lambda argument: sf.sweep(argument, [0.3]),
    ):
        with pytest.raises(sf.SceneError, match=r"without a slot|only scenes with a slot"):
            function(line)


def test_a_spoilt_edge_shows_in_the_second_evaluation():
    """The error estimate is worth its name: it sees an edge that is 1e-6 off."""
    good = sf.solve(patch_line("II", 0.3, 0.5)).spreading
    off = Spreading(good.factors, 0.3, good.edge * (1 + 1e-6), good.lead - good.edge * 1e-6)
    assert abs(off.missing_again - 0.5) > 1e-8
