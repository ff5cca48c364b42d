"""Incident waves and moving loads, solved: closed forms, limits, invariants, derivatives."""

import math
from dataclasses import replace

import numpy as np
import pytest
from catalogue import under
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from semianalytic import (
    Coulomb,
    IncidentWave,
    Material,
    MovingLoad,
    RateWeakening,
    Scene,
    SceneError,
    Tractions,
)
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.scene.given.finding import find_scene
from semianalytic.selfsimilar.solver import solve
from tests.semianalytic.selfsimilar.derivatives.test_derivative import errors

SOLID = Material(1.0, 1.0, 1 / 3)


def bare(p, jump, poisson_ratio=1 / 3, mode="in-plane"):
    """Shear that moves over the slot, with a jump (strength + S) / S of traction at the edge."""
    base = Tractions(jump - 1.0, 0.0)
    return Scene(Material(1, 1, poisson_ratio), 1.0, base, MovingLoad(-1 / p, 0.0, 1.0), mode=mode)


@pytest.mark.parametrize(
    ("p", "jump", "speed"), [(-0.25, 1.8, 0.35992421), (-0.9, 2.5, 0.109293), (0.25, 1.6, 0.810512)]
)
def test_one_zone_from_the_edge_in_closed_form(p, jump, speed):
    solution = solve(bare(p, jump), rtol=1e-11)
    (zone,) = solution.zones
    factors = rayleigh_factors(1 / 3)
    start = p + jump**2 * factors.m_plus_off_cut(-p) ** 2
    assert zone.outer == pytest.approx(1 / start, rel=1e-10)
    assert zone.outer == pytest.approx(speed, abs=6e-7)
    # dV/dv = J / (pi kappa (v - p) M_+(v) sqrt(v - u_s)); the slip rate is twice its integral
    angle, weight = np.polynomial.legendre.leggauss(60)
    angle, weight = (angle + 1) * np.pi / 4, weight * np.pi / 4
    for xi in (0.05, 0.6 * zone.outer):
        root = math.sqrt(1 / xi - start) * np.sin(angle)
        v = start + root**2
        density = 2 * math.sqrt(1 / xi - start) * np.cos(angle) / ((v - p) * factors.m_plus(v))
        rate = 2 * jump / (np.pi * factors.kappa) * float(density @ weight)
        assert float(solution.slip_rate(xi, 1.0)) == pytest.approx(rate, rel=1e-9)


def test_three_edges_of_the_notes():
    """Slip from the edge, and a daughter that begins at the shear front."""
    inner, outer = solve(bare(-0.25, 1.15), rtol=1e-10).zones
    expected = (1.24434447, 0.93634417, 0.92871127)
    assert (outer.outer, outer.inner, inner.outer) == pytest.approx(expected, abs=6e-9)


@pytest.mark.parametrize("p", [-3.0, -0.4, 0.6])
def test_antiplane_zone_in_closed_form(p):
    (zone,) = solve(bare(p, 1.7, 0.2, "antiplane"), rtol=1e-11).zones
    assert zone.outer == pytest.approx(1 / (p + (1 - p) * 1.7**2), rel=1e-11)


@pytest.mark.parametrize("p", [-1.5, -0.3, 0.3])
def test_opening_from_the_edge_in_closed_form(p):
    scene = Scene(SOLID, 0.3, Tractions(1.0, 0.0), MovingLoad(-1 / p, -0.8, 0.0))
    (opening,) = solve(scene).openings
    start = p + ((1.0 + 0.8) / 0.8 * rayleigh_factors(1 / 3, "I").m_plus_off_cut(-p)) ** 2
    assert opening.outer == pytest.approx(1 / start, rel=1e-11)


def compared(first, other, away):
    """Largest differences of all fields of two solutions, away from c_R."""
    speed = first.scene.material.rayleigh_speed
    x = np.linspace(0.013, 2.1, 80)
    x = x[np.abs(x - speed) > 0.02]
    assert len(first.zones) == len(other.zones)
    for name in ("slip_rate", "slip", "shear_traction", "pressure", "gap"):
        a, b = getattr(first, name)(x, 1.0), getattr(other, name)(x, 1.0)
        assert a == pytest.approx(b, abs=away), name
    assert first.stress_intensity(1.0) == pytest.approx(other.stress_intensity(1.0), abs=away)
    assert first.edge_speeds == pytest.approx(other.edge_speeds, abs=away)


@pytest.mark.parametrize(
    ("kind", "stress", "base"),
    [("SV", 0.15, (1.0, 0.1)), ("P", 3.0, (1.0, 0.25)), ("P", -0.5, (1.0, 0.1))],
)
def test_normal_incidence_is_the_remote_step(kind, stress, base):
    wave = IncidentWave(kind, 0.0, stress=stress, from_="above")
    scene = Scene(SOLID, 0.3, Tractions(*base), wave)
    step = replace(scene, load=wave.tractions(SOLID), load_on="remote")
    first, other = solve(scene), solve(step)
    compared(first, other, 0.0)
    # and nearly normal incidence is nearly that, at no finer rules or more panels
    near = solve(replace(scene, load=replace(wave, angle=1e-4)))
    compared(near, other, 2e-5)
    if kind == "P":  # an SV wave that is not quite normal opens the edge by 1e-13
        assert near.statistics.nodes == other.statistics.nodes


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("base", [1.0, 0.03])
def test_a_fast_load_is_the_step_on_the_slot(sign, base):
    scene = Scene(SOLID, 0.3, Tractions(base, 0.0), MovingLoad(sign * 1e9, 1.0, 1.0))
    step = replace(scene, load=Tractions(1.0, 1.0))
    compared(solve(scene), solve(step), 3e-8)


angles = st.floats(-80.0, 80.0).filter(lambda angle: abs(angle) > 0.5)
LAWS = [Coulomb(1.0), Coulomb(1.0), Coulomb(1.0, viscosity=0.1), Coulomb(1.0, viscosity=0.5)]


@st.composite
def scenes(draw):
    """Incident waves and moving loads of all kinds, with openings and viscous films."""
    kind = draw(st.sampled_from(["P", "SV", "SH", "moving", "moving along z"]))
    solid = Material(1.0, 1.0, draw(st.sampled_from([-0.3, 0.1, 0.25, 1 / 3, 0.42])))
    friction, pressure = draw(st.floats(0.05, 1.2)), draw(st.floats(0.02, 2.0))
    shear = draw(st.sampled_from([0.0, 0.0, -0.7, 0.5])) * friction * pressure
    if kind in ("P", "SV", "SH"):
        size = draw(st.floats(0.1, 1.5)) * draw(st.sampled_from([-1, 1]))
        side = draw(st.sampled_from(["below", "above"]))
        load = IncidentWave(kind, draw(angles), stress=size, from_=side)
    else:
        speed = draw(st.floats(0.1, 2.0)) if draw(st.booleans()) else -draw(st.floats(4.0, 9.0))
        load = MovingLoad(speed, draw(st.sampled_from([0.0, -0.6, 0.4])), draw(st.floats(0.1, 1.0)))
    mode = "antiplane" if kind in ("SH", "moving along z") else "in-plane"
    law, base = draw(st.sampled_from(LAWS)), Tractions(pressure, shear)
    try:
        scene = Scene(solid, law.with_coefficient(friction), base, load, mode=mode)
        scene.check_self_similar()
    except SceneError:
        assume(False)
    return scene


few = settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))


@pytest.mark.slow
@settings(few, max_examples=60)
@given(scenes())
def test_physics_and_errors_of_many_random_scenes(scene):
    """Coulomb's law on a foreign grid, free slot faces, causality, and the error estimate."""
    solution = solve(scene, rtol=1e-7)
    assert solution.status == "converged"
    rng = np.random.default_rng(0)
    fastest = scene.material.longitudinal_speed
    xi = np.concatenate([rng.uniform(1e-3, 1.1 * fastest, 150), 10 ** rng.uniform(-3, 0, 30)])
    xi = xi[np.abs(xi - scene.material.rayleigh_speed) > 1e-3]
    rate, pressure = solution.slip_rate(xi, 1.0), solution.pressure(xi, 1.0)
    traction = solution.shear_traction(xi, 1.0)
    is_open = np.zeros(xi.shape, dtype=bool)
    for part in solution.openings:
        is_open |= (xi > part.inner) & (xi < part.outer)
    viscosity = getattr(scene.law, "viscosity", 0.0)
    strength = scene.coefficient * pressure + viscosity * np.abs(rate)
    assert np.all(pressure >= -1e-7)
    assert np.all(np.abs(traction[~is_open]) <= (strength + 1e-6 * (1 + strength))[~is_open])
    against = rate * traction
    assert np.all(against[~is_open] >= -1e-6)
    assert np.all(rate[xi > fastest] == 0)
    # the bodies: what is left of the load on the slot faces fixes amplitude and pole of T
    slot = -rng.uniform(0.02, 1.5 * fastest, 20)
    held, off = scene.superposition
    loaded = 1.0 - scene.front_slowness * slot >= 0
    fine = solve(scene, rtol=1e-12)
    for answer, face in ((answer, face) for answer in (solution, fine) for face in (0.0, -0.0)):
        sigma, bound = answer.stress(slot, face, 1.0), max(2e-6, answer.field_error)
        for row, sign, name in ((1, -1, "pressure"), (-1, 1, "shear")):
            left = getattr(held, name) - getattr(off, name)
            expected = np.where(loaded, left, getattr(scene.base, name))
            assert sign * sigma[row] == pytest.approx(expected, abs=bound)
    at = xi[np.abs(xi - 1) > 0.01]
    jump = solution.velocity(at, 0.0, 1.0) - solution.velocity(at, -0.0, 1.0)
    expected = solution.slip_rate(at, 1.0)
    assert jump[-1 if scene.antiplane else 0] == pytest.approx(expected, rel=1e-5, abs=1e-5)
    assert len(fine.zones) == len(solution.zones)
    both = np.array([solution.edge_speeds, fine.edge_speeds])
    assert np.abs(both[0] - both[1]).max(initial=0.0) <= solution.error_estimate
    if 0 < fine.frictional_power(1.0) < np.inf:
        power = solution.frictional_power(1.0) / fine.frictional_power(1.0)
        assert power == pytest.approx(1.0, abs=solution.error_estimate + 1e-12)


@few
@given(scenes())
def test_signs_units_and_self_similarity(scene):
    solution = solve(scene, rtol=1e-8)
    x = np.array([0.07, 0.31, 0.55, 0.88, 1.21, 1.6])
    # the other direction of shear
    load = scene.load
    if isinstance(load, MovingLoad):
        turned = replace(load, shear=-load.shear)
    elif load.kind == "SH":
        turned = IncidentWave("SH", load.angle, stress=-load.stress, from_=load.from_)
    else:  # the wave mirrored at the interface
        turned = replace(load, from_="above" if load.from_ == "below" else "below")
    other = replace(scene, load=turned, base=replace(scene.base, shear=-scene.base.shear))
    mirrored = solve(other, rtol=1e-8)
    assert mirrored.edge_speeds == pytest.approx(solution.edge_speeds, abs=1e-7)
    assert mirrored.slip_rate(x, 1.0) == pytest.approx(-solution.slip_rate(x, 1.0), abs=1e-5)
    assert solution.slip_rate(7 * x, 7.0) == pytest.approx(solution.slip_rate(x, 1.0), abs=1e-9)
    # other units: stress 1e6, length 10, time 2
    solid = replace(scene.material, shear_modulus=1e6, density=1e6 * 4 / 100)
    speed, slip = solid.shear_speed, 1e6 / solid.shear_impedance
    if isinstance(load, MovingLoad):
        scaled = MovingLoad(speed * load.speed, 1e6 * load.pressure, 1e6 * load.shear)
    else:
        scaled = replace(load, stress=1e6 * load.stress)
    law = scene.law
    if isinstance(law, Coulomb):
        law = Coulomb(1.0, viscosity=law.viscosity * 1e6 / slip)
    base = Tractions(1e6 * scene.base.pressure, 1e6 * scene.base.shear)
    big = solve(under(replace(scene, material=solid, load=scaled, base=base), law), rtol=1e-8)
    assert big.edge_speeds / speed == pytest.approx(solution.edge_speeds, abs=1e-7)
    rates = big.slip_rate(speed * x, 1.0) / slip
    assert rates == pytest.approx(solution.slip_rate(x, 1.0), rel=1e-5, abs=1e-5)


def test_the_contact_before_and_behind_the_front():
    wave = IncidentWave("P", -30.0, stress=1.2)
    solution = solve(Scene(SOLID, 0.5, Tractions(1.0, 0.1), wave))
    p, load = solution.scene.front_slowness, wave.tractions(SOLID)
    x = 3.0
    for t, share in ((p * x - 1e-9, 0), (p * x + 1e-9, 1), (-0.1, 1)):  # p < 0
        assert float(solution.pressure(x, t)) == pytest.approx(1.0 + share * load.pressure)
        assert float(solution.shear_traction(x, t)) == pytest.approx(0.1 + share * load.shear)
    along = solve(replace(solution.scene, load=replace(wave, angle=30.0)))
    assert float(along.pressure(3.0, 0.74)) == pytest.approx(1.0)  # p = 1/4: the front is at 2.96
    assert float(along.pressure(2.9, 0.74)) == pytest.approx(1.0 + load.pressure)


@pytest.mark.slow
def test_fields_obey_the_equation_of_motion_around_all_fronts():
    solid = Material(2.0, 3.0, 0.3)
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-1.5, 1.5, (2, 30))
    h = 1e-4
    weights = np.array([1, -8, 8, -1]) / (12 * h)
    for load in (
        IncidentWave("P", 25.0, velocity=-0.08),
        IncidentWave("SV", -20.0, stress=0.3),
        MovingLoad(0.4, 0.2, 1.0),
    ):
        solution = solve(Scene(solid, 0.5, Tractions(1.0, 0.2), load))
        for t in (1.0, -0.4):

            def slope(field):
                return sum(w * field(k * h) for w, k in zip(weights, (-2, -1, 1, 2), strict=True))

            moved = slope(lambda d, t=t, s=solution: s.displacement(x, y, t + d))
            rate = solution.velocity(x, y, t)
            assert np.quantile(np.abs(moved - rate), 0.9) < 1e-9
            force = slope(lambda d, t=t, s=solution: s.stress(x + d, y, t)[[0, 2]])
            force = force + slope(lambda d, t=t, s=solution: s.stress(x, y + d, t)[[2, 1]])
            pushed = 3.0 * slope(lambda d, t=t, s=solution: s.velocity(x, y, t + d))
            assert np.quantile(np.abs(pushed - force), 0.9) < 1e-7  # the rest cross a front
        assert solution.field_error < 1e-7
    reflected = solve(Scene(solid, 0.5, Tractions(1.0, 0.2), IncidentWave("P", 25.0, 0.08)))
    # before t = 0 the lower face moves with incident and reflected wave; the upper one is shaded
    lower, upper = (reflected.velocity(-1.0, y, -0.05) for y in (-0.0, 0.0))
    assert np.abs(lower).max() > 0.1
    assert upper == pytest.approx(np.zeros(2), abs=1e-15)
    assert reflected.slot_velocity(-1.0, -0.05) == pytest.approx(upper)


FILM = Coulomb(0.4, viscosity=0.1)


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    ("friction", "shear", "load", "parts", "names"),
    [
        (0.5, 0.0, IncidentWave("SH", -40.0, 0.4), {"mode": "antiplane"}, "angle wave_velocity"),
        (0.3, 0.05, IncidentWave("SV", -20.0, stress=0.3), {}, "angle wave_stress poisson_ratio"),
        (0.5, 0.2, IncidentWave("P", 20.0, -0.2), {}, "angle wave_velocity poisson_ratio"),
        (0.5, 0.2, IncidentWave("P", 20.0, -0.2), {}, "base_pressure"),
        (FILM, 0.0, MovingLoad(0.6, 0.3, 1.0), {}, "load_speed viscosity load_pressure"),
        (0.4, 0.0, MovingLoad(-5.0, -0.3, 1.0), {}, "load_speed friction"),
    ],
)
def test_derivatives(friction, shear, load, parts, names):
    solution = solve(Scene(SOLID, friction, Tractions(1.0, shear), load, **parts), rtol=1e-11)
    for name in names.split():
        off = errors(solution, name)
        assert off is not None
        assert max(off.values()) < 1e-8, (name, off)
        assert solution.derivative(name).error_estimate < 1e-6


def test_what_has_no_self_similar_answer_or_no_derivative_is_refused():
    scene = find_scene("incident-sv")
    with pytest.raises(SceneError, match="wave alone exceeds friction"):
        solve(replace(scene, load=IncidentWave("SV", -10.0, stress=1.0)))
    with pytest.raises(SceneError, match="not 1 % faster than the first wave"):
        solve(replace(scene, load=MovingLoad(-1.9, 0.0, 1.0)))
    with pytest.raises(SceneError, match=r"slower than 0\.0001"):
        solve(replace(scene, load=MovingLoad(1e-5, 0.0, 1.0)))
    waved = solve(scene)
    for name in ("load_shear", "wave_velocity", "load_speed"):
        with pytest.raises(SceneError, match="angle and wave_stress"):
            waved.derivative(name)
    with pytest.raises(SceneError, match="has no angle"):
        solve(find_scene("moving-load")).derivative("angle")


def test_friction_that_falls_with_rate():
    scene = under(find_scene("moving-load"), RateWeakening(1.0, 0.7, 2.0))
    solution = solve(scene, rtol=1e-6)
    assert solution.status == "converged"
    (zone,) = solution.zones
    assert zone.outer > solve(find_scene("moving-load")).zones[0].outer  # weaker, so longer
    xi = np.linspace(0.02, 0.98, 25) * zone.outer
    rate, traction = solution.slip_rate(xi, 1.0), solution.shear_traction(xi, 1.0)
    strength = scene.strength(solution.pressure(xi, 1.0), rate)
    assert traction == pytest.approx(strength, abs=1e-5)
