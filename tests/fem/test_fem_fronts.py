"""Loads whose front moves, in the finite-element model: moving loads and incident waves."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import UNIT

import semianalytic as sf
from fem import simulate
from fem.loading import arrived_wave, front_delays
from semianalytic.halfplane.rayleigh import rayleigh_factors
from tests.fem.runs import FIELDS, l1


def histories(history):
    return {"pressure_history": history, "shear_history": history}


PRESSED = sf.Tractions(1.0, 0.0)


def rising(friction, wave, history, **given):
    return sf.Scene(UNIT, friction, PRESSED, wave, **histories(history), **given)


def edge_of_moving_shear(speed, friction):
    """Velocity of the zone's edge in closed form, u_s = p + (1 + chi)^2 M_+(-p)^2."""
    slowness = 1 / speed
    factor = rayleigh_factors(1 / 3).m_plus(np.array([slowness]), "II")[0]
    return 1 / ((1 + friction) ** 2 * factor**2 - slowness)


@pytest.mark.parametrize(("speed", "friction"), [(4.0, 1.0), (0.9, 0.6)])
def test_edge_of_slip_under_a_moving_load_is_that_of_the_closed_form(speed, friction):
    scene = sf.Scene(UNIT, friction, PRESSED, sf.MovingLoad(speed, 0.0, 1.0))
    run = simulate(scene, resolution=40)
    rate = np.abs(run.interface.slip_rate[-1])
    slips = run.interface.x[rate > 0.03 * rate.max()]
    assert abs(slips.max() - edge_of_moving_shear(speed, friction)) < 1.5 * run.element_size


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("friction", "shear", "wave"),
    [
        (0.4, 0.0, sf.IncidentWave("SV", angle=-75.0, stress=0.5)),
        (0.7, 0.0, sf.IncidentWave("SV", angle=-20.0, stress=1.2, from_="above")),
        (0.3, 0.0, sf.IncidentWave("P", angle=-40.0, stress=-0.5, from_="above")),
        (0.2, 0.1, sf.IncidentWave("P", angle=-40.0, stress=0.5)),
    ],
)
def test_slip_under_an_incident_wave_is_that_of_the_exact_solution(friction, shear, wave):
    scene = sf.Scene(UNIT, friction, sf.Tractions(1.0, shear), wave)
    answer = sf.solve(scene)
    assert answer.zones[0].outer > 0.3
    run = simulate(scene, resolution=40)
    for name, most in zip(FIELDS, (0.02, 0.03, 0.02, 0.01), strict=True):
        exact = getattr(answer, name)(run.interface.x, run.end_time)
        assert l1(getattr(run.interface, name)[-1], exact) < most, name


def test_a_wave_of_normal_incidence_is_a_remote_step():
    wave = sf.Scene(UNIT, 1.2, PRESSED, sf.IncidentWave("P", angle=0.0, stress=1.0))
    remote = replace(wave, load=sf.Tractions(1.0, 0.0), load_on="remote")
    first, other = (simulate(scene, resolution=12) for scene in (wave, remote))
    np.testing.assert_array_equal(first.interface.pressure, other.interface.pressure)
    # what moves on the slot is the wave besides
    np.testing.assert_allclose(first.slot.velocity_y[1:], other.slot.velocity_y[1:] + 0.5)


def test_pulses_arrive_at_an_angle():
    """A rectangular pulse is one step minus another that comes later."""
    wave = sf.IncidentWave("SV", angle=-20.0, stress=0.2)
    step = sf.Scene(UNIT, 5.0, PRESSED, wave)
    pulsed = replace(step, pressure_history=sf.Pulse(0.25), shear_history=sf.Pulse(0.25))
    run, whole = simulate(pulsed, resolution=32), simulate(step, resolution=32)
    steps = round(0.25 / run.time_step)
    # the later wave takes away again what the first one brought, on the contact itself as well
    late = whole.interface.shear_traction[-1 - steps] - step.base.shear
    expected = whole.interface.shear_traction[-1] - late
    # the steps do not divide the pulse, and traction beside the edge is singular
    assert np.abs(run.interface.shear_traction[-1] - expected)[4:].max() < 0.02


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    "scene",
    [
        sf.find("incident-pulse"),
        rising(0.4, sf.IncidentWave("SV", 0.0, stress=0.3), sf.Ramp(0.5)),
        rising(0.18, sf.IncidentWave("SH", -50.0, stress=0.2), sf.Pulse(0.6), mode="antiplane"),
    ],
)
def test_slip_under_a_wave_that_rises_and_falls_is_that_of_the_march(scene):
    run, answer = simulate(scene, resolution=40), sf.solve(scene, method="space-time", nodes=200)
    x, t = np.linspace(0.05, 0.95, 37), np.linspace(0.2, 1.0, 5)
    for name, bar in (("slip", 0.05), ("pressure", 0.005), ("shear_traction", 0.04)):
        seen = np.array([getattr(run, name)(x, time) for time in t])
        assert l1(seen, getattr(answer, name)(x, t[:, None])) < bar, name
    assert np.abs(answer.slip(x, 1.0)).max() > 0.01


def test_a_wave_that_makes_the_contact_slip_later_is_refused():
    """The step alone does not: the wave swings to the other side."""
    scene = replace(
        sf.Scene(UNIT, 0.3, sf.Tractions(1.0, 0.1), sf.IncidentWave("SV", -20.0, stress=0.3)),
        **histories(sf.Harmonic(2.0)),
    )
    simulate(replace(scene, **histories(sf.Ramp(0.3))), resolution=24)
    with pytest.raises(sf.SceneError, match="slips behind the front"):
        simulate(scene, resolution=24)


def test_fronts_reach_nodes_in_turn_and_shed_the_same_load():
    x = np.array([-3.0, -2.0, -1.0, 0.0])
    delay = front_delays(x, -0.5)
    assert delay.shape[0] == len(x)
    np.testing.assert_allclose(delay.mean(axis=1), [1.375, 1.0, 0.5, 0.125])
    assert np.all(delay >= 0)


def test_an_incident_wave_solves_the_equation_of_motion():
    """Behind the front strain and velocity go with each other: sigma = - rho c v d along n."""
    scene = sf.find("incident-sv")
    wave, solid = scene.load, scene.material
    x, y = np.array([0.3, -0.2, 0.1]), np.array([-0.5, -0.1, 3.0])
    fields = arrived_wave(scene, x, y, 0.4)
    n = np.array(wave.direction())
    impedance = solid.density * wave.speed(solid)
    sxx, sxy, syy = (fields.stress[name] for name in ("xx", "xy", "yy"))
    force = np.array([sxx * n[0] + sxy * n[1], sxy * n[0] + syy * n[1]])
    np.testing.assert_allclose(force, -impedance * fields.velocity[:2], atol=1e-14)
    assert fields.velocity[0, 2] == 0 != fields.velocity[0, 0]
    assert arrived_wave(sf.find("preloaded"), x, y, 0.4) is None


@pytest.mark.parametrize(
    ("load", "options", "words"),
    [
        (sf.IncidentWave("P", angle=20.0, stress=0.5), {}, "comes along the slot"),
        (sf.MovingLoad(-3.0, 0.0, 0.5), {}, "comes along the slot"),
        (sf.IncidentWave("SV", angle=-10.0, stress=2.0), {}, "slips behind the front"),
        (
            sf.IncidentWave("SV", angle=-10.0, stress=0.1),
            {"lower_material": sf.Material(2.0, 1.0, 0.3)},
            "reflect an incident wave",
        ),
    ],
)
def test_what_begins_before_the_simulation_is_refused(load, options, words):
    with pytest.raises(sf.SceneError, match=words):
        simulate(sf.Scene(UNIT, 0.5, PRESSED, load, **options), resolution=12)
