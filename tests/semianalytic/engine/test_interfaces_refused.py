"""Interfaces, loads and settings of runs that cannot be: each is refused in one sentence."""

import math

import numpy as np
import pytest

import semianalytic as sf
from compare.comparison.interfaces.comparing import line_of
from docs.studies.lines import scene_along
from semianalytic.scene.line.fields import Expression

UNIT = sf.Material(1.0, 1.0, 0.25)
CREEPING = {
    "material": sf.Material(30e9, 2700.0, 0.25),
    "law": sf.RateAndState(a=0.01, b=0.006, f0=0.6, v0=1e-6, distance=1e-4),
    "pressure": 5e6,
    "shear": 3e6,
}
PULL = sf.InterfaceLoad(pressure=-3.0)
LATE = sf.InterfaceLoad(lambda x, t: 0.1 * (x > 1) * (t > 0.3), history=None)


def face(**changes):
    """A sound interface of unit material but for what is changed."""
    return scene_along(**{"material": UNIT, "law": sf.Coulomb(0.3), "period": 16.0} | changes)


def under_history(text):
    return [sf.InterfaceLoad(1.0, history=Expression(text, ("t",)))]


def wave_beyond_a_critical_angle(history):
    load = sf.FrontLoad(sf.IncidentWave("SV", -50.0, stress=0.2), history, at=4.0)
    return {"material": sf.Material(4.0, 1.3, 0.25), "lower_material": UNIT, "loads": [load]}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"pressure": -1.0}, "not be negative"),
        ({"pressure": sf.Table([-1.0, 1.0], [1.0, 1.0])}, "must cover the contact"),
        ({"law": sf.RateAndState(0.01, 0.01, 0.6, 1e-6, 1.0)}, "give `theta`"),
        ({"mode": "III"}, "in-plane or antiplane"),
        ({"period": 0.0}, "period must be positive"),
        ({"contact": sf.Contact([(9, 12)])}, "9 to 12 leaves the period, -8 to 8; raise `period`"),
        ({"contact": sf.Contact([(0.01, 0.02)])}, "no node lies on .*; use 12800 nodes or more"),
        # friction opposes slip: it begins in the sense of the base shear
        (
            {**CREEPING, "rate": lambda x: 1e-9 * np.sign(x - 3)},
            "must have the sense of `shear`, .*, got -1e-09 at x = -8",
        ),
        # expressions and histories have a finite value everywhere and at all times
        *(
            ({"shear": Expression(text, ("x",))}, "shear has no finite value")
            for text in ("1/0", "10**400", "(-8)**(1/3)", "log(x)")
        ),
        *(
            ({"loads": under_history(text)}, "history must always be finite, got")
            for text in ("1/t", "log(t-1)")
        ),
        # loads of pressure
        ({"mode": "antiplane", "loads": [PULL]}, "antiplane line have no pressure"),
        (
            {"loads": [sf.InterfaceLoad(pressure=lambda x: x[:3])]},
            "load: pressure: the function of x must return 128 numbers",
        ),
        # two bodies
        ({"lower_material": 3}, "lower_material must be a Material"),
        ({"lower_material": sf.Material(1e6, 1.0, 0.25)}, "must not differ by more than a factor"),
        (
            {"lower_material": sf.Material(2.25, 1.0, 0.25), "mode": "antiplane"},
            "between different bodies mode must be",
        ),
        ({"lower_material": sf.Material(2.25, 1.0, 0.25), "even": True}, "set even = false"),
        (wave_beyond_a_critical_angle(sf.Step()), "beyond a critical angle"),
    ],
)
def test_bad_interfaces_are_refused(changes, said):
    with pytest.raises(sf.SceneError, match=said) as told:
        sf.solve(face(**changes), end_time=0.5, nodes=128)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"loads": [sf.InterfaceLoad(lambda x: 0.5 * (x > 1))]}, "shear of a load"),
        ({"loads": [LATE]}, "shear of a load"),
        ({"contact": sf.Contact([(1, 3)])}, "contact"),
        ({"shear": lambda x: 0.1 * x}, "shear"),
        ({"pressure": lambda x: 1 + (x > 1)}, "pressure"),
        ({**CREEPING, "rate": lambda x: 1e-9 * (1 + (x > 1))}, "rate"),
        ({"law": sf.Coulomb(lambda x: 0.8 - 0.3 * (x > 0))}, "friction: friction"),
        (
            {"loads": [PULL], "adhesion": sf.Adhesion(lambda x: 1 + (x > 0), 0.3)},
            "adhesion: strength",
        ),
    ],
)
def test_what_is_called_even_has_to_be(changes, what):
    with pytest.raises(sf.SceneError, match=f"the {what} is not even in x"):
        sf.solve(face(**changes, even=True), end_time=0.5, nodes=128)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sf.Contact([(0, 2), (1, 3)]), "overlap"),
        (lambda: sf.Contact([(1, 0)]), "empty"),
        (lambda: sf.Contact([]), "pairs of begin and end"),
        (lambda: sf.Table([0, 1], [1, math.nan]), "finite numbers"),
        (lambda: sf.Table([1, 0], [1, 1]), "must increase"),
        (lambda: sf.InterfaceLoad(1.0, on="contact"), "line"),
        (lambda: sf.InterfaceLoad(pressure=1.0, history=None), "`pressure` must be a function of"),
        (lambda: sf.InterfaceLoad(pressure="low"), "load: pressure must be a number"),
        (lambda: sf.ForcedFront(0.6, 0.2, arrival=1.0, fall=-1.0), "fall must be 0 or more"),
        (lambda: sf.solve(face(), end_time=-1.0), "end_time must be above 0"),
        (
            lambda: sf.solve(face(), end_time=1.0, nodes=64, times=[math.nan]),
            "times must lie between 0 and the end time",
        ),
        (
            lambda: sf.solve(face(), end_time=0.1, nodes=128, longest=0.001),
            "`longest` must be 0.05 or more on this grid, got 0.001",
        ),
        (
            lambda: sf.solve(face(), end_time=0.1, nodes=128, longest=0.0),
            "longest must be positive",
        ),
        (
            lambda: sf.solve(face(), end_time=0.1, nodes=128, sweeps=0),
            "sweeps must be a whole number of at least 1",
        ),
        (
            lambda: sf.solve(face(), end_time=0.1, nodes=128, foo=1),
            "foo is no setting of space-time for a scene on a line",
        ),
        (
            lambda: line_of(face(loads=[PULL], adhesion=sf.Adhesion(1.0, 0.5)), 16),
            "finite elements have no adhesion",
        ),
    ],
)
def test_bad_parts_and_settings_are_refused(make, said):
    with pytest.raises(sf.SceneError, match=said) as told:
        make()
    assert "\n" not in str(told.value)
