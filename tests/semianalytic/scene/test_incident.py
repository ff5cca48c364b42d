"""Incident waves and moving loads as parts of a scene: tractions, documents, refusals."""

import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from catalogue import unit_scene
from hypothesis import given, settings
from hypothesis import strategies as st

import semianalytic as sf
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.given.template import in_si_units, scene_text

SOLID = sf.Material(2.0, 3.0, 0.29)
PLAIN = unit_scene(friction=1.0)
kinds = st.sampled_from(["P", "SV", "SH"])
sides = st.sampled_from(["below", "above"])


def _stress(solid, direction, motion):
    """Stress of u = motion f(t - n.r / c) from Hooke's law, per velocity, as a matrix."""
    n, d = np.array([*direction, 0.0]), np.array(motion)
    speed = solid.longitudinal_speed if abs(n @ d) > 0.5 else solid.shear_speed
    gradient = -np.outer(d, n) / speed
    lame = solid.density * (solid.longitudinal_speed**2 - 2 * solid.shear_speed**2)
    strain = (gradient + gradient.T) / 2
    return lame * np.trace(strain) * np.eye(3) + 2 * solid.shear_modulus * strain


@settings(max_examples=30, deadline=None)
@given(kinds, sides, st.floats(-89.0, 89.0))
def test_tractions_are_those_of_the_plane_wave(kind, side, angle):
    wave = sf.IncidentWave(kind, angle, velocity=0.7, from_=side)
    sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    up = 1 if side == "below" else -1
    direction = (sine, up * cosine)
    motion = {
        "P": (sine, up * cosine, 0.0),
        "SV": (cosine, -up * sine, 0.0),
        "SH": (0.0, 0.0, 1.0),
    }[kind]
    assert wave.direction() == pytest.approx(direction, abs=1e-15)
    assert wave.polarisation() == pytest.approx(motion, abs=1e-15)
    sigma = 0.7 * _stress(SOLID, direction, motion)
    components = wave.stresses(SOLID)
    for name in ("xx", "yy", "xy", "xz", "yz"):
        i, j = ("xyz".index(axis) for axis in name)
        assert components[name] == pytest.approx(sigma[i, j], abs=1e-13)
    shear = sigma[1, 2] if kind == "SH" else sigma[0, 1]
    tractions = wave.tractions(SOLID)
    assert (tractions.pressure, tractions.shear) == pytest.approx((-sigma[1, 1], shear), abs=1e-13)
    # the closed forms of the notes
    c_l, c_t, v = SOLID.longitudinal_speed, SOLID.shear_speed, 0.7
    forms = {
        "P": (
            3.0 * c_l * v * (1 - 2 * (c_t / c_l) ** 2 * sine**2),
            -up * 3.0 * v * c_t**2 / c_l * math.sin(2 * math.radians(angle)),
        ),
        "SV": (
            -3.0 * c_t * v * math.sin(2 * math.radians(angle)),
            -up * 3.0 * c_t * v * math.cos(2 * math.radians(angle)),
        ),
        "SH": (0.0, -up * 3.0 * c_t * v * cosine),
    }
    assert (tractions.pressure, tractions.shear) == pytest.approx(forms[kind], abs=1e-13)


@settings(max_examples=30, deadline=None)
@given(kinds, sides, st.floats(-85.0, 85.0))
def test_derivatives_by_the_angle(kind, side, angle):
    def at(shift):
        wave = sf.IncidentWave(kind, angle + shift, stress=1.3, from_=side)
        both = wave.tractions(SOLID)
        return np.array([both.pressure, both.shear, wave.slowness(SOLID)])

    wave = sf.IncidentWave(kind, angle, stress=1.3, from_=side)
    slope, slowness = wave.derivatives(SOLID, "angle")
    expected = (at(1e-3) - at(-1e-3)) / 2e-3
    assert [slope.pressure, slope.shear, slowness] == pytest.approx(expected, abs=1e-10)


@settings(max_examples=30, deadline=None)
@given(kinds, sides, st.floats(-85.0, 85.0), st.sampled_from(["stress", "velocity"]))
def test_derivatives_by_poisson_ratio_and_amplitude(kind, side, angle, amplitude):
    def at(poisson_ratio, size):
        solid = replace(SOLID, poisson_ratio=poisson_ratio)
        wave = sf.IncidentWave(kind, angle, from_=side, **{amplitude: size})
        both = wave.tractions(solid)
        return np.array([both.pressure, both.shear, wave.slowness(solid)])

    wave = sf.IncidentWave(kind, angle, from_=side, **{amplitude: 1.3})
    by_ratio = (at(0.29 + 1e-5, 1.3) - at(0.29 - 1e-5, 1.3)) / 2e-5
    by_size = at(0.29, 2.3) - at(0.29, 1.3)
    for by, expected in (("poisson_ratio", by_ratio), (f"wave_{amplitude}", by_size)):
        slope, slowness = wave.derivatives(SOLID, by)
        assert [slope.pressure, slope.shear, slowness] == pytest.approx(
            expected, rel=1e-7, abs=1e-8
        )


@pytest.mark.parametrize("name", ["incident-p", "incident-sv", "incident-pulse", "moving-load"])
def test_documents_and_files_hold_the_load(name, tmp_path):
    scene = NAMED_SCENES[name].scene
    assert eval(repr(scene), vars(sf)) == scene
    for problem in (scene, in_si_units(scene)):
        path = tmp_path / "scene.toml"
        path.write_text(scene_text(problem), encoding="utf-8")
        assert sf.find(path) == problem
    assert "kind" in tomllib.loads(scene_text(scene))["load"]


def test_si_units_keep_the_front_and_its_shape():
    for name in ("incident-p", "incident-sv", "moving-load"):
        scene = NAMED_SCENES[name].scene
        other = in_si_units(scene)
        ours = scene.front_slowness * scene.material.shear_speed
        theirs = other.front_slowness * other.material.shear_speed
        assert theirs == pytest.approx(ours, rel=1e-11)
        held, load = scene.superposition
        assert other.superposition.in_place.pressure == pytest.approx(1e6 * held.pressure)
        assert other.superposition.taken_off.shear == pytest.approx(1e6 * load.shear)


def test_a_wave_acts_on_slot_and_contact_and_a_moving_load_on_the_slot_alone():
    wave = replace(PLAIN, load=sf.IncidentWave("P", 0.0, stress=0.5))
    assert wave.superposition == (sf.Tractions(1.5, 0.0), sf.Tractions(0.5, 0.0))
    assert (wave.front_slowness, wave.arrives) == (0.0, True)
    moving = replace(PLAIN, load=sf.MovingLoad(-4.0, 0.2, 0.3))
    assert moving.superposition == (sf.Tractions(1.0, 0.0), sf.Tractions(0.2, 0.3))
    assert (moving.front_slowness, moving.arrives) == (0.25, False)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sf.IncidentWave("S", 0.0, 1.0), "kind must be one of P, SV, SH"),
        (lambda: sf.IncidentWave("P", 90.0, 1.0), "between -89.9 and 89.9 degrees"),
        (lambda: sf.IncidentWave("P", 0.0), "either its velocity or its stress"),
        (lambda: sf.IncidentWave("P", 0.0, 1.0, from_="left"), "from must be below or above"),
        (lambda: sf.MovingLoad(0.0, 0.0, 1.0), "other than 0"),
    ],
)
def test_a_load_refuses_in_one_sentence(make, said):
    with pytest.raises(sf.SceneError, match=said):
        make()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"load": sf.IncidentWave("SH", 0.0, 0.1)}, "is P or SV"),
        ({"load": sf.IncidentWave("P", 0.0, 0.1), "mode": "antiplane"}, "is SH"),
        ({"load": sf.IncidentWave("P", -30.0, -2.0)}, "leave the contact pressed together"),
        ({"load": sf.IncidentWave("P", 0.0, 0.1), "load_on": "remote"}, "leave out load_on"),
        (
            {"load": sf.MovingLoad(1.0, 0.0, 1.0), "shear_history": sf.Ramp(1.0)},
            "leave out histories",
        ),
        (
            {"load": sf.IncidentWave("SV", 20.0, 0.1), "shear_history": sf.Pulse(1.0)},
            "one history",
        ),
    ],
)
def test_a_scene_refuses_a_load_that_does_not_go_with_it(change, said):
    with pytest.raises(sf.SceneError, match=said):
        replace(PLAIN, **change)


def test_a_slow_front_along_the_slot_and_a_pulse_have_no_self_similar_answer():
    # a / b = 1/2 at nu = 1/3: sin(angle) = 1/2 is critical for an SV wave along the slot
    beyond = replace(PLAIN, load=sf.IncidentWave("SV", 31.0, 0.1))
    assert not beyond.is_self_similar
    assert replace(PLAIN, load=sf.IncidentWave("SV", -31.0, 0.1)).is_self_similar
    assert replace(PLAIN, load=sf.IncidentWave("SV", 29.0, 0.1)).is_self_similar
    assert replace(PLAIN, mode="antiplane", load=sf.IncidentWave("SH", 80.0, 0.1)).is_self_similar
    with pytest.raises(sf.SceneError, match=r"comes along the slot at 1.942.*march it"):
        sf.solve(beyond)
    pulse = replace(PLAIN, load=sf.IncidentWave("P", 0.0, 0.1), pressure_history=sf.Pulse(1.0))
    assert not pulse.is_self_similar


def test_overriding_a_load():
    waved = override_scene(PLAIN, wave="SV", angle=-20.0, wave_stress=0.2)
    assert waved.load == sf.IncidentWave("SV", -20.0, stress=0.2)
    assert override_scene(waved, angle=-15.0) != waved
    again = override_scene(waved, wave_velocity=0.1, wave_from="above")
    assert again.load == sf.IncidentWave("SV", -20.0, velocity=0.1, from_="above")
    moving = override_scene(PLAIN, load_speed=0.5, load_pressure=0.1)
    assert moving.load == sf.MovingLoad(0.5, 0.1, PLAIN.load.shear)
    for change, said in (
        ({"angle": 3.0}, "needs its kind"),
        ({"wave": "P", "load_speed": 1.0}, "either a wave or"),
    ):
        with pytest.raises(sf.SceneError, match=said):
            override_scene(PLAIN, **change)
    with pytest.raises(sf.SceneError, match="not its shear"):
        override_scene(waved, load_shear=1.0)


def test_files_name_what_is_wrong(tmp_path):
    text = scene_text(NAMED_SCENES["incident-sv"].scene)
    path = tmp_path / "scene.toml"
    for before, after, said in (
        ('kind = "incident-wave"', 'kind = "incoming"', "incident-wave, moving"),
        ("\nangle = -20.0", "\nangel = -20.0", "unknown key load.angel; did you mean angle"),
        ("\nangle = -20.0", "\n", "load.angle is missing"),
        ("\nangle = -20.0", '\nangle = "steep"', "between -89.9 and 89.9"),
    ):
        assert before in text
        path.write_text(text.replace(before, after), encoding="utf-8")
        with pytest.raises(sf.SceneError, match=said):
            sf.find(path)
