"""The length that slip weakening gives a front."""

import math
from dataclasses import replace

import pytest

from semianalytic.scene.contact import process_zone
from semianalytic.scene.friction import RateWeakening, SlipWeakening
from semianalytic.scene.scene import Material, Scene, Tractions


def weakening(friction_law, pressure=1.0, units=1.0):
    material = Material(2.0 * units, 1.0, 0.25)
    base = Tractions(pressure * units, 0.2 * units)
    return Scene(material, 0.6, base, Tractions(0.0, 0.4 * units), friction_law=friction_law)


def test_process_zone_is_the_stiffness_over_the_fall_of_strength_per_slip():
    law = SlipWeakening(2 / 3, 0.05)  # friction .6 to .2: a fall of .4 within .05
    assert process_zone(weakening(law)) == pytest.approx(2.0 / (0.75 * 0.4 / 0.05))
    assert process_zone(weakening(law, pressure=2.0)) == pytest.approx(1.0 / (0.75 * 0.4 / 0.05))
    assert process_zone(weakening(law, units=1e6)) == pytest.approx(2.0 / (0.75 * 0.4 / 0.05))


def test_process_zone_is_that_under_the_pressure_of_a_remote_load():
    law, load = SlipWeakening(2 / 3, 0.05), Tractions(1.0, 0.4)
    remote = replace(weakening(law), base=Tractions(0.0, 0.0), load=load, load_on="remote")
    assert process_zone(remote) == process_zone(weakening(law))


def test_process_zone_is_infinite_where_slip_does_not_weaken():
    assert process_zone(weakening(RateWeakening(0.1, 1.0))) == math.inf
    assert process_zone(weakening(SlipWeakening(0.0, 0.05))) == math.inf
    assert process_zone(weakening(SlipWeakening(0.5, 0.05), pressure=0.5)) < math.inf
