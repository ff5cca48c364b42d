"""The scenes that tests share, each with tags that say which tests it is for.

A test takes what it can: ``@over("exact", without="slides")`` runs it on every self-similar scene
that has an exact answer but those that slip ahead of all waves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import pytest

from semianalytic import (
    Coulomb,
    Harmonic,
    Law,
    Marched,
    Material,
    Pulse,
    Ramp,
    RateWeakening,
    Scene,
    SlipWeakening,
    Solution,
    Tabulated,
    Tractions,
)
from semianalytic.engine.march import march as march_of
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.selfsimilar.solver import solve

UNIT = Material(1.0, 1.0, 1 / 3)
STEEL = Material(80e9, 7800.0, 1 / 3)

TAGS = {
    "exact": "self-similar, and pressed together throughout: `solve` answers",
    "stuck": "nothing slips",
    "reverse": "some of the interface slips against the load",
    "slides": "slip ahead of all waves",
    "thin": "a stick gap or a zone narrower than a hundredth of c_t",
    "remote": "a sudden remote load",
    "rated": "strength follows slip rate: `solve` answers by Newton's method, in seconds",
    "march": "loads that rise and fall, or strength that falls with slip: only `march` answers",
    "opens": "the contact opens: solved and simulated, not marched",
    "witness": "seen by a coarse finite-element model, and by a coarse march",
    "SI": "not in units in which c_t, density and load are 1",
}


@dataclass(frozen=True)
class Problem:
    """A scene to test with.

    Attributes
    ----------
    name : str
    scene : Scene
    tags : frozenset of str, keys of `TAGS`
    senses : tuple of int, or None
        Senses of the slip zones from the contact edge outward, where the scene is exact.
    """

    name: str
    scene: Scene
    tags: frozenset[str]
    senses: tuple[int, ...] | None = None


def unit_scene(
    friction: float = 0.3,
    base: tuple[float, float] = (1.0, 0.0),
    load: tuple[float, float] = (0.0, 1.0),
    *,
    nu: float = 1 / 3,
    law: Law | None = None,
    **parts: Any,
) -> Scene:
    """A scene of unit shear modulus and density; tractions are (pressure, shear).

    The law is taken with the friction for its coefficient.
    """
    given = friction if law is None else law.with_coefficient(friction)
    return Scene(Material(1.0, 1.0, nu), given, Tractions(*base), Tractions(*load), **parts)


def gone_on(march: Marched, end_time: float, **settings: Any) -> Marched:
    """A march that is continued to a later time."""
    return march_of(march.scene, go_on=march, end_time=end_time, **settings)


def under(scene: Scene, law: Law) -> Scene:
    """The scene under another law of the same coefficient."""
    return replace(scene, friction=law.with_coefficient(scene.coefficient))


REMOTE: dict[str, Any] = {"base": (0.0, 0.0), "load": (1.0, 1.0), "load_on": "remote"}
"""A sudden remote load, on nothing before."""


@cache
def solved(scene: Scene | str) -> Solution:
    """The solution of a scene, or of a named one: one for all tests that only look at it.

    Most of the time of a picture or of a sampled run is spent on tables that a solution keeps.
    """
    return solve(scene)


UNIT_FILE = """friction = 0.3
material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.3}
base = {pressure = 1.0, shear = 0.0}
load = {pressure = 0.0, shear = 1.0}
"""
"""A scene file of unit shear modulus and density, to which keys and tables may be added."""
PRELOADED = unit_scene()
SHOCK = unit_scene(1.25, **REMOTE)
"""The two scenes of the article's kind: a shear step under pressure, a sudden remote load."""


def _exact(name: str, senses: str, tags: str, scene: Scene) -> Problem:
    known = {"+": 1, "-": -1}
    return Problem(
        name, scene, frozenset(("exact", *tags.split())), tuple(known[s] for s in senses)
    )


def _other(name: str, tags: str, scene: Scene) -> Problem:
    return Problem(name, scene, frozenset(tags.split()))


_STEEL_SCENE = Scene(STEEL, 0.3, Tractions(5e6, 0.0), Tractions(0.0, 5e6))

PROBLEMS = (
    _exact("stuck under a shock", "", "stuck remote witness", unit_scene(2.0, **REMOTE)),
    _exact("pressed further", "", "stuck witness", unit_scene(load=(1.0, 0.0))),
    _exact("one zone", "+", "witness", unit_scene(1.2)),
    _exact("one zone, strong", "+", "", unit_scene(2.5)),
    _exact("two zones", "++", "witness", PRELOADED),
    _exact("backward", "--", "", unit_scene(load=(0.0, -1.0))),
    _exact("two zones under a shock", "++", "remote witness", SHOCK),
    _exact("slip everywhere", "+", "remote slides witness", unit_scene(0.5, **REMOTE)),
    _exact(
        "a shock on a base",
        "++",
        "remote thin",
        unit_scene(0.6, (1.0, -0.5), (1.0, 1.6), load_on="remote"),
    ),
    _exact("narrow gap around c_R", "++", "thin", unit_scene(0.1)),
    _exact("gap of 1e-6 around c_R", "++", "thin remote", unit_scene(1.1, **REMOTE, nu=0.2)),
    _exact("gap of 1e-9 around c_R", "++", "thin", unit_scene(0.3, (0.25, 0.075), (1.2, 1.3))),
    _exact("auxetic", "+-+", "reverse thin", NAMED_SCENES["auxetic"].scene),
    _exact("auxetic, more friction", "++", "", unit_scene(0.05, nu=-0.5)),
    _exact("frictionless", "+-+", "reverse thin", unit_scene(0.0, nu=-0.5)),
    _exact("weak friction", "+-+", "reverse thin", unit_scene(1e-9, nu=0.0)),
    _exact("base released by pressure", "+", "", unit_scene(0.5, (2.0, 0.99), (1.5, 0.0))),
    _exact("base against the load", "+", "", unit_scene(0.2, (1.0, -0.19), (0.5, 0.6))),
    _exact("both senses", "--+", "thin", unit_scene(0.05, (1.0, 0.05), (0.6, -1.3), nu=0.25)),
    _exact("viscous", "++", "witness", unit_scene(law=Coulomb(1.0, viscosity=0.1))),
    _exact("viscous across c_R", "+", "", unit_scene(0.1, law=Coulomb(1.0, viscosity=0.05))),
    _exact(
        "viscous slip everywhere",
        "+",
        "remote slides",
        unit_scene(0.5, **REMOTE, law=Coulomb(1.0, viscosity=0.25)),
    ),
    _exact(
        "viscous, both senses",
        "+-+",
        "reverse",
        unit_scene(0.02, nu=-0.5, law=Coulomb(1.0, viscosity=0.2)),
    ),
    _exact(
        "a film alone",
        "+",
        "",
        unit_scene(0.0, (1.0, 0.0), (0.5, 1.0), law=Coulomb(1.0, viscosity=0.5)),
    ),
    _exact("antiplane", "+", "witness", NAMED_SCENES["antiplane"].scene),
    _exact(
        "antiplane backward", "-", "", unit_scene(1.5, (1.0, 0.3), (0.0, -2.0), mode="antiplane")
    ),
    _exact("antiplane shock", "+", "remote witness", unit_scene(1.0, **REMOTE, mode="antiplane")),
    _exact(
        "antiplane slip everywhere",
        "+",
        "remote slides",
        unit_scene(0.5, **REMOTE, mode="antiplane"),
    ),
    _exact(
        "antiplane, viscous",
        "+",
        "witness",
        unit_scene(0.5, mode="antiplane", law=Coulomb(1.0, viscosity=0.25)),
    ),
    _exact(
        "antiplane slip from the longitudinal front",
        "+",
        "",
        unit_scene(0.3, (1.0, 0.3), (1.0, 0.6), mode="antiplane"),
    ),
    _exact("nearly incompressible", "++", "", unit_scene(nu=0.499)),
    _exact("steel", "++", "SI", _STEEL_SCENE),
    _other("pressure on the slot", "opens", unit_scene(0.5, (1.0, 0.2), (-1.0, 0.5))),
    _other("opens and closes again", "opens", unit_scene(0.5, (0.02, 0.0), (1.0, 0.5))),
    _other(
        "antiplane pulse", "march", unit_scene(0.15, mode="antiplane", shear_history=Pulse(0.4))
    ),
    _other("ramp", "march", unit_scene(shear_history=Ramp(0.5))),
    _other("pulse", "march", unit_scene(0.15, shear_history=Pulse(0.4))),
    _other("waves", "march", unit_scene(0.1, shear_history=Harmonic(3.0))),
    _other(
        "jumps",
        "march",
        unit_scene(shear_history=Tabulated((0.05, 0.25, 0.25, 0.6), (0.0, 1.0, -1.0, 0.5))),
    ),
    _other("slip weakening", "march", unit_scene(law=SlipWeakening(1.0, 0.4, 0.1))),
    _other("rate weakening", "rated", unit_scene(law=RateWeakening(1.0, 0.6, 1.0))),
)


def problems(*tags: str, without: str = "") -> list[Problem]:
    """All problems that have every tag, and none of those named in `without`."""
    unknown = {*tags, *without.split()} - TAGS.keys()
    assert not unknown, f"no such tag: {unknown}"
    return [
        problem
        for problem in PROBLEMS
        if problem.tags.issuperset(tags) and problem.tags.isdisjoint(without.split())
    ]


def over(*tags: str, without: str = "") -> Callable[..., Any]:
    """Run a test, which takes `problem`, on all problems with these tags."""
    chosen = problems(*tags, without=without)
    assert chosen, f"no problem is {tags} without {without}"
    return pytest.mark.parametrize("problem", chosen, ids=[scene.name for scene in chosen])
