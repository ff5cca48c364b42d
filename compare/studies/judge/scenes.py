"""Random scenes that the judge is tried on, each drawn from a seed of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from compare.studies.campaign.scenes import random_history_scene
from semianalytic import Material, RateWeakening, Scene, SceneError, SlipWeakening, Tractions
from semianalytic.cut.load import contact_opens
from semianalytic.regimes import opening_threshold
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.named import NAMED_SCENES

STEPS, HISTORIES, OPENINGS = "steps", "histories", "openings"

RESOLUTIONS = (40, 44, 48, 52, 56, 60, 64)
"""Modest meshes, whose companions at 2h and 4h share nodes with them."""

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
_POWER_SEED, _DRAWN = 15, (0, 1, 5, 9, 10, 13)

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


def random_opening(random: np.random.Generator) -> Scene:
    """A self-similar scene whose contact opens; raises SceneError where the draw is not admissible.

    Half of them from the edge, half of them ahead of a sudden pressure on a small base; solids and
    friction as in `random_steps`, three in ten without shear.
    """
    solid, friction = _random_solid(random)
    shear = float(random.choice([-1, 1]) * random.lognormal(0.0, 0.5))
    if random.random() < 0.3:
        shear = 0.0
    base, step = 1.0, -float(random.lognormal(-0.5, 0.7))
    if random.random() < 0.5:
        base, step = opening_threshold(solid.poisson_ratio) * float(random.uniform(0.05, 0.95)), 1.0
    rest = float(random.choice([0.0, random.uniform(-1, 1)]))
    return Scene(solid, friction, Tractions(base, rest * friction * base), Tractions(step, shear))


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
    """A scene, the resolution of a mesh for it, and how many were drawn and refused before it."""

    scene: Scene
    resolution: int
    refusals: int


def draw(kind: str, random: np.random.Generator) -> Draw:
    """The next admissible scene, of "steps" that leave the contact shut, "histories" or
    "openings"."""
    refusals = 0
    while True:
        resolution = int(random.choice(RESOLUTIONS))
        try:
            scene = _KINDS[kind](random)
        except SceneError:
            refusals += 1
            continue
        if kind != STEPS or not contact_opens(scene):
            return Draw(scene, resolution, refusals)
        refusals += 1


_KINDS: dict[str, Callable[[np.random.Generator], Scene]] = {
    STEPS: random_steps,
    HISTORIES: random_history,
    OPENINGS: random_opening,
}


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
