"""What a friction law has to say, that it agrees with itself, and that none is ignored; and the
length that slip weakening gives a front."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import semianalytic as sf
from semianalytic.scene import kinds
from semianalytic.scene.contact import process_zone
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.scene import Material, Scene, Tractions

SCENE = NAMED_SCENES["preloaded"].scene
LAWS = (
    sf.CoulombFriction(),
    sf.ViscousFriction(0.7),
    sf.RateWeakening(0.4, 1.0),
    sf.SlipWeakening(0.6, 0.05),
)
ANSWERS = sorted(sf.FrictionLaw.__abstractmethods__)
any_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
sizes = st.floats(0.0, 10.0).map(lambda value: round(value, 4))


@pytest.mark.thinned(3)
@any_law
@settings(max_examples=60, deadline=None)
@given(stopping=sizes, frictional=sizes, path=sizes, excess=st.floats(0.01, 3.0))
def test_slip_speed_balances_friction_and_radiation(law, stopping, frictional, path, excess):
    """impedance V = stopping - strength(V, path), or V = 0 below the strength at rest."""
    impedance = frictional * law.fall_with_rate + excess
    one = np.array([stopping]), np.array([frictional])
    (speed,) = law.slip_speed(*one, impedance, np.array([path]))
    at_rest = float(law.strength(frictional, 0.0, path))
    if stopping <= at_rest:
        assert speed == 0
    else:
        carried = float(law.strength(frictional, speed, path))
        assert speed >= 0
        assert impedance * speed == pytest.approx(stopping - carried, abs=1e-10)


@any_law
def test_falls_are_the_steepest_of_the_strength(law):
    fine = np.linspace(0, 2, 200_001)
    for told, strength in (
        (law.fall_with_rate, law.strength(3.0, fine, 0.0)),
        (law.fall_with_slip, law.strength(3.0, 0.0, fine)),
    ):
        steepest = max(-np.diff(strength).min() / fine[1] / 3.0, 0.0)
        assert told == pytest.approx(steepest, rel=1e-4, abs=1e-12)


def complete(**parts):
    """A law like slip weakening made from scratch, with some of its answers changed or left out."""
    inner = sf.SlipWeakening(0.3, 0.5)
    said = {
        "strength": lambda self, *given: inner.strength(*given),
        "slip_speed": lambda self, *given: inner.slip_speed(*given),
        "fall_with_rate": 0.0,
        "fall_with_slip": inner.fall_with_slip,
    }
    said = {name: value for name, value in {**said, **parts}.items() if value is not None}
    return dataclass(frozen=True)(type("Named", (sf.FrictionLaw,), said))


def test_the_answers_are_those_solvers_ask_for():
    assert ANSWERS == ["fall_with_rate", "fall_with_slip", "slip_speed", "strength"]


@pytest.mark.parametrize("missing", ANSWERS)
def test_a_law_that_leaves_an_answer_out_cannot_be_made(missing):
    with pytest.raises(TypeError, match=missing):
        complete(**{missing: None})()


def test_a_scene_refuses_a_law_that_is_not_known_by_name():
    with pytest.raises(sf.SceneError, match="friction_law must be one of"):
        replace(SCENE, friction_law=complete()())


def test_a_new_law_is_refused_where_it_is_ill_posed_or_too_sharp(monkeypatch):
    steep, sharp = complete(fall_with_rate=1e3), complete(fall_with_slip=1e6)
    monkeypatch.setitem(kinds.FRICTION_LAWS, "steep", steep)
    monkeypatch.setitem(kinds.FRICTION_LAWS, "sharp", sharp)
    with pytest.raises(sf.SceneError, match="faster than radiation can balance"):
        replace(SCENE, friction_law=steep())
    with pytest.raises(sf.SceneError, match="weakens within about"):
        sf.solve(replace(SCENE, friction_law=sharp()), method="space-time", nodes=64)


# --- the length that slip weakening gives a front -------------------------------------------------


def weakening(friction_law, pressure=1.0, units=1.0):
    material = Material(2.0 * units, 1.0, 0.25)
    base = Tractions(pressure * units, 0.2 * units)
    return Scene(material, 0.6, base, Tractions(0.0, 0.4 * units), friction_law=friction_law)


def test_process_zone_is_the_stiffness_over_the_fall_of_strength_per_slip():
    law = sf.SlipWeakening(2 / 3, 0.05)  # friction .6 to .2: a fall of .4 within .05
    assert process_zone(weakening(law)) == pytest.approx(2.0 / (0.75 * 0.4 / 0.05))
    assert process_zone(weakening(law, pressure=2.0)) == pytest.approx(1.0 / (0.75 * 0.4 / 0.05))
    assert process_zone(weakening(law, units=1e6)) == pytest.approx(2.0 / (0.75 * 0.4 / 0.05))


def test_process_zone_is_that_under_the_pressure_of_a_remote_load():
    law, load = sf.SlipWeakening(2 / 3, 0.05), Tractions(1.0, 0.4)
    remote = replace(weakening(law), base=Tractions(0.0, 0.0), load=load, load_on="remote")
    assert process_zone(remote) == process_zone(weakening(law))


def test_process_zone_is_infinite_where_slip_does_not_weaken():
    assert process_zone(weakening(sf.RateWeakening(0.1, 1.0))) == math.inf
    assert process_zone(weakening(sf.SlipWeakening(0.0, 0.05))) == math.inf
    assert process_zone(weakening(sf.SlipWeakening(0.5, 0.05), pressure=0.5)) < math.inf
