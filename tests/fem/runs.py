"""Runs, loads, laws and comparisons that tests of finite elements share."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from catalogue import PRELOADED, SHOCK, unit_scene

import semianalytic as sf
from fem import simulate
from fem.model import build
from fem.plan import make_plan

FIELDS = ("slip", "slip_rate", "shear_traction", "pressure")
MIXED = unit_scene(0.5, (1.0, 0.2), (0.5, 0.5))
OPENING = unit_scene(0.5, (1.0, 0.2), (-1.0, 0.5))
UNLOADED = unit_scene(0.5, load=(-1.0, 0.5))
"""It opens from its edge at a constant speed, nothing sheared beforehand."""
SHEARED_ALONG_Z = unit_scene(0.5, (1.0, 0.2), (0.0, 0.5), mode="antiplane")
SCENES = {
    "preloaded": PRELOADED,
    "remote": SHOCK,
    "sliding": dataclasses.replace(SHOCK, friction=0.5),
    "pressed": unit_scene(load=(1.0, 0.0)),
    "opening": OPENING,
    "reclosing": unit_scene(0.5, (0.02, 0.0), (1.0, 0.5)),
}
RISING = {
    "ramp": sf.Ramp(0.3),
    "rectangle": sf.Pulse(0.37),
    "triangle": sf.Pulse(0.5, "triangle"),
    "harmonic": sf.Harmonic(2.0),
    "jumps": sf.Tabulated((0.05, 0.25, 0.25, 0.6), (0.0, 1.0, -1.0, 0.5)),
}
LAWS = {
    "coulomb": sf.Coulomb(1.0),
    "rate": sf.RateWeakening(1.0, 0.6, 1.0),
    "viscous": sf.Coulomb(1.0, viscosity=0.3),
    "slip": sf.SlipWeakening(1.0, 0.4, 0.05),
}


def sheared(history=sf.Step(), law=LAWS["coulomb"]):  # noqa: B008
    """Shear alone, under constant pressure."""
    return unit_scene(shear_history=history, law=law)


def mixed(history, law=LAWS["coulomb"]):
    """Shear and pressure, the pressure in waves, on an interface sheared beforehand."""
    histories = {"pressure_history": sf.Harmonic(1.0), "shear_history": history}
    return unit_scene(0.5, (1.0, 0.2), (0.5, 0.8), law=law, **histories)


def prepare(scene, end_time=None, *, full=False, **options):
    """The model of a scene before its first step."""
    return build(make_plan(scene, end_time, None, options, full=full))


@cache
def run(scene, resolution=32, **options):
    """A simulation, which is run once for all tests of a module."""
    return simulate(scene, resolution=resolution, **options)


def l1(found, wanted):
    """The relative L1 error."""
    return np.abs(found - wanted).sum() / np.abs(wanted).sum()


def stop_at(last):
    """Progress that interrupts a run after so many steps."""

    def stop(step, _):
        if step >= last:
            raise KeyboardInterrupt

    return stop


def interrupted(scene, last, **options):
    """Run a simulation until it is interrupted after so many steps."""
    with pytest.raises(KeyboardInterrupt):
        simulate(scene, progress=stop_at(last), **options)


OF_CLOCK = ("seconds",)
"""Fields in which two equal simulations may differ: those of the clock."""


def assert_same(first, other, but=OF_CLOCK):
    """Fail unless two simulations are equal to the last bit, but for some fields."""
    for field in dataclasses.fields(first):
        left, right = getattr(first, field.name), getattr(other, field.name)
        if field.name in ("interface", "slot", "energy", "totals"):
            for part in dataclasses.fields(left):
                np.testing.assert_array_equal(getattr(left, part.name), getattr(right, part.name))
        elif isinstance(left, np.ndarray):
            np.testing.assert_array_equal(left, right)
        elif field.name not in but:
            assert left == right, field.name
