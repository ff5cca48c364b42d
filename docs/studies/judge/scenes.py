"""Random scenes that the judge is tried on, each drawn from a seed of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from docs.studies.trials.draws import random_history_scene
from semianalytic import (
    CoulombFriction,
    Harmonic,
    LoadHistory,
    Material,
    Pulse,
    Ramp,
    RateWeakening,
    Scene,
    SceneError,
    SlipWeakening,
    Tabulated,
    Tractions,
    ViscousFriction,
)
from semianalytic.cut.load import contact_opens
from semianalytic.regimes import opening_threshold
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.given.overriding import override_scene
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.scene import ANTIPLANE
from semianalytic.scene.units import SI

STEPS, HISTORIES, OPENINGS, NEAR = "steps", "histories", "openings", "near-openings"
VISCOUS, OUT_OF_PLANE, METRES = "viscous", "antiplane", "SI"
MAPS: Mapping[str, tuple[float, float]] = {"preloaded": (0.15, 0.42), "remote-shock": (1.0, 1.36)}
"""Named scenes with the least and the largest friction of the map around each: gaps between slip
zones of any width lie between."""
MAP_SIZE, MAP_RATIOS = 10, (0.2, 0.38)
"""Points along each axis of a map, and its least and largest Poisson ratio."""

_NAMED = (
    "remote-shock",
    "preloaded",
    "auxetic",
    "pressure-drop",
    "lift-off",
    "lift-off-shear",
    "tap",
    "ramp",
    "unload",
    "pulse",
    "harmonic",
)
_POWER_SEED, _DRAWN = 15, (0, 1, 3, 5, 9, 10)

_SPECIAL_RATIOS = (1 / 3, 0.25, 0.0, 0.29)
_SHARES = (0.0, 1.0, -1.0)


def random_steps(random: np.random.Generator) -> Scene:
    """A self-similar scene; raises SceneError where the draw is not admissible.

    Half of a draw's Poisson ratios are those of real solids; one in ten has no friction, one in
    five is a sudden remote load; shear acts either way, pressure on the slot or off it.
    """
    solid, friction = _random_solid(random)
    shear = float(random.choice([-1, 1]) * random.lognormal(0.0, 0.5))
    share = random.random()
    if share < 0.2:
        remote = Tractions(1.0, shear)
        return Scene(solid, friction, Tractions(0.0, 0.0), remote, load_on=REMOTE)
    pressure = 0.0 if share < 0.6 else float(random.choice([-1, 1]) * random.lognormal(-0.5, 0.7))
    rest = float(random.choice([*_SHARES, random.uniform(-1, 1)], p=[0.4, 0.05, 0.05, 0.5]))
    if pressure and random.random() < 0.3:
        shear = 0.0
    base = Tractions(1.0, rest * friction)
    return Scene(solid, friction, base, Tractions(pressure, shear))


def _random_shear(random: np.random.Generator) -> float:
    """Draw the shear of a step of either sign; it is zero in three scenes of ten."""
    shear = float(random.choice([-1, 1]) * random.lognormal(0.0, 0.5))
    return 0.0 if random.random() < 0.3 else shear


def random_opening(random: np.random.Generator) -> Scene:
    """A self-similar scene whose contact opens; raises SceneError where the draw is not admissible.

    Half of them from the edge, half of them ahead of a sudden pressure on a small base; solids and
    friction as in `random_steps`, three in ten without shear.
    """
    solid, friction = _random_solid(random)
    shear = _random_shear(random)
    base, step = 1.0, -float(random.lognormal(-0.5, 0.7))
    if random.random() < 0.5:
        base, step = opening_threshold(solid.poisson_ratio) * float(random.uniform(0.05, 0.95)), 1.0
    rest = float(random.choice([0.0, random.uniform(-1, 1)]))
    return Scene(solid, friction, Tractions(base, rest * friction * base), Tractions(step, shear))


def random_near_opening(random: np.random.Generator) -> Scene:
    """A self-similar scene whose contact opens a little, or only just does not.

    Half of them ahead of a sudden pressure on a base within 20 % of the threshold, on either side
    of it, half of them from the edge, whose step takes off a tenth of the base or so.
    """
    solid, friction = _random_solid(random)
    shear = _random_shear(random)
    base, step = 1.0, -float(random.lognormal(-2.5, 0.7))
    if random.random() < 0.5:
        beside = float(random.choice([-1, 1]) * np.exp(random.uniform(np.log(1e-3), np.log(0.2))))
        base, step = opening_threshold(solid.poisson_ratio) * (1 + beside), 1.0
    rest = float(random.choice([0.0, random.uniform(-1, 1)]))
    return Scene(solid, friction, Tractions(base, rest * friction * base), Tractions(step, shear))


def random_viscous(random: np.random.Generator) -> Scene:
    """A step with a film that takes between a hundredth and three times what a shear wave does."""
    scene = random_steps(random)
    share = float(np.exp(random.uniform(np.log(0.01), np.log(3.0))))
    return replace(scene, friction_law=ViscousFriction(share * scene.material.shear_impedance / 2))


def random_antiplane(random: np.random.Generator) -> Scene:
    """A step, or three times in ten a load that rises and falls, with shear along z."""
    kind = random_history if random.random() < 0.3 else random_steps
    return replace(kind(random), mode=ANTIPLANE)


def random_metres(random: np.random.Generator) -> Scene:
    """A step, or three times in ten a load that rises and falls, of a real solid in SI units."""
    kind = random_history if random.random() < 0.3 else random_steps
    modulus = float(np.exp(random.uniform(np.log(1e9), np.log(1e11))))
    stress = float(np.exp(random.uniform(np.log(1e4), np.log(1e8))))
    return in_metres(kind(random), modulus, float(random.uniform(1000.0, 8000.0)), stress)


def in_metres(scene: Scene, modulus: float, density: float, stress: float) -> Scene:
    """A scene of Coulomb friction in units of 1 as one in SI units, for the same lengths.

    Parameters
    ----------
    scene : Scene
    modulus, density : float
        Of the solid [Pa], [kg/m^3].
    stress : float
        What stands for a traction of 1 [Pa].
    """
    solid = Material(modulus, density, scene.material.poisson_ratio)
    base, load = (
        Tractions(stress * one.pressure, stress * one.shear)
        for one in (scene.base, scene.superposition.taken_off)
    )
    return replace(
        scene,
        material=solid,
        base=base,
        load=load,
        pressure_history=_faster(scene.pressure_history, solid.shear_speed),
        shear_history=_faster(scene.shear_history, solid.shear_speed),
        friction_law=CoulombFriction(),
        units=SI,
    )


def _faster(history: LoadHistory, times: float) -> LoadHistory:
    """A history that does the same so many times faster."""
    if isinstance(history, Ramp):
        return Ramp(history.rise_time / times)
    if isinstance(history, Pulse):
        return Pulse(history.duration / times, history.shape)
    if isinstance(history, Harmonic):
        return Harmonic(history.frequency * times)
    if isinstance(history, Tabulated):
        return Tabulated(tuple(time / times for time in history.t), history.value_at_t)
    return history


def _random_solid(random: np.random.Generator) -> tuple[Material, float]:
    """A material and a friction coefficient."""
    nu = float(random.choice([random.uniform(-0.9, 0.49), random.choice(_SPECIAL_RATIOS)]))
    friction = 0.0 if random.random() < 0.1 else float(random.uniform(0.01, 2.0))
    return Material(1.0, 1.0, nu), friction


def random_history(random: np.random.Generator) -> Scene:
    """A scene of the campaign whose loads change in time, of a friction law that has an answer.

    Under rate weakening short waves grow on any grid: there is nothing to converge to.
    """
    while True:
        scene = random_history_scene(random)
        if not isinstance(scene.friction_law, RateWeakening):
            return scene


@dataclass(frozen=True)
class Draw:
    """A scene, and how many were drawn and refused before it."""

    scene: Scene
    refusals: int


def draw(kind: str, random: np.random.Generator) -> Draw:
    """The next admissible scene of a kind; only openings and what is near them may open."""
    refusals = 0
    while True:
        try:
            scene = _KINDS[kind](random)
        except SceneError:
            refusals += 1
            continue
        opens = scene.is_self_similar and contact_opens(scene)
        if kind in (OPENINGS, NEAR) or not opens:
            return Draw(scene, refusals)
        refusals += 1


_KINDS: dict[str, Callable[[np.random.Generator], Scene]] = {
    STEPS: random_steps,
    HISTORIES: random_history,
    OPENINGS: random_opening,
    NEAR: random_near_opening,
    VISCOUS: random_viscous,
    OUT_OF_PLANE: random_antiplane,
    METRES: random_metres,
}


def map_scene(name: str, index: int) -> Scene:
    """A point of the map of friction and Poisson ratio around a named scene, row by row."""
    row, column = divmod(index, MAP_SIZE)
    friction = np.linspace(*MAPS[name], MAP_SIZE)[column]
    ratio = np.linspace(*MAP_RATIOS, MAP_SIZE)[row]
    return override_scene(find_scene(name), friction=float(friction), poisson_ratio=float(ratio))


def power_scenes() -> dict[str, Scene]:
    """Scenes for spoilt answers, by name: those of the package that slip, and drawn ones."""
    named = {name: NAMED_SCENES[name].scene for name in _NAMED}
    steel = replace(named["preloaded"], material=Material(1.0, 1.0, 0.29), friction=0.15)
    weakening = Scene(
        Material(1.0, 1.0, 0.25),
        0.6,
        Tractions(1.0, 0.4),
        Tractions(0.0, 0.4),
        friction_law=SlipWeakening(2 / 3, 0.05),
    )
    drawn = {
        f"drawn {index}": draw(STEPS, np.random.default_rng([_POWER_SEED, index])).scene
        for index in _DRAWN
    }
    return {**named, "steel": steel, "slip weakening": weakening, **drawn}
