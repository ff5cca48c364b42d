"""Random scenes to try the methods on: self-similar ones, and ones whose loads change in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from semianalytic import (
    CoulombFriction,
    Harmonic,
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
from semianalytic.scene.friction import FrictionLaw
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.loads import PULSE_SHAPES, LoadHistory

_SPECIAL_RATIOS = (1 / 3, 0.25, 0.0, 0.45, -0.5)


def random_step_scene(random: np.random.Generator) -> Scene:
    """A self-similar scene; raises SceneError where the draw is not admissible."""
    nu = float(random.choice([*_SPECIAL_RATIOS, *random.uniform(-0.95, 0.495, 10)]))
    least = 1e-9 if random.random() < 0.1 else 1e-3
    friction = float(np.exp(random.uniform(np.log(least), np.log(10))))
    pressure = float(random.choice([0, 1, random.lognormal(0, 1.5)], p=[0.4, 0.2, 0.4]))
    share = float(random.choice([0, random.uniform(-1, 1), 1, -1], p=[0.4, 0.4, 0.1, 0.1]))
    shear = float(random.choice([0, 1, random.normal() * random.lognormal()], p=[0.05, 0.25, 0.7]))
    solid = Material(1.0, 1.0, nu)
    if random.random() < 0.15:
        remote = Tractions(pressure or 1.0, shear)
        return Scene(solid, friction, Tractions(0.0, 0.0), remote, load_on=REMOTE)
    return Scene(solid, friction, Tractions(1.0, share * friction), Tractions(pressure, shear))


def random_history(random: np.random.Generator) -> LoadHistory:
    """A ramp, pulse, wave or table that lasts between a tenth and all of the time 1."""
    length = float(random.uniform(0.1, 1.0))
    kind = random.integers(4)
    if kind == 0:
        return Ramp(length)
    if kind == 1:
        return Pulse(length, str(random.choice(PULSE_SHAPES)))
    if kind == 2:
        return Harmonic(float(random.uniform(0.3, 4.0)))
    times = np.sort(random.uniform(0, 1, 6)).round(6)
    return Tabulated(tuple(np.unique(times).tolist()), tuple(random.normal(size=len(times))))


def random_history_scene(random: np.random.Generator) -> Scene:
    """A scene whose loads change in time; raises SceneError where it is not admissible."""
    nu = float(random.choice([*_SPECIAL_RATIOS, random.uniform(-0.9, 0.49)]))
    friction = float(np.exp(random.uniform(np.log(0.02), np.log(2))))
    pressure = float(random.choice([0.0, random.uniform(0, 1)], p=[0.6, 0.4]))
    laws: Sequence[FrictionLaw] = (
        CoulombFriction(),
        RateWeakening(float(random.uniform(0, 0.6)), float(random.lognormal(1.0, 1.0))),
        SlipWeakening(float(random.uniform(0, 0.8)), float(random.lognormal(-2.0, 0.7))),
    )
    return Scene(
        Material(1.0, 1.0, nu),
        friction,
        Tractions(1.0, float(random.choice([0.0, random.uniform(-1, 1)])) * friction),
        Tractions(pressure, float(random.normal())),
        pressure_history=random_history(random),
        shear_history=random_history(random),
        friction_law=laws[random.choice(3, p=[0.5, 0.25, 0.25])],
    )


def drawn(
    seed: int, index: int, draw: Callable[[np.random.Generator], Scene]
) -> tuple[Scene, np.random.Generator]:
    """The first admissible scene of a draw."""
    random = np.random.default_rng([seed, index])
    while True:
        try:
            return draw(random), random
        except SceneError:
            continue


def random_wide_scene(random: np.random.Generator) -> Scene:
    """A self-similar scene of any law and mode, opening or closed, whose base is 1e-6 to 1e6 times
    its step; raises SceneError where the draw is not admissible."""
    nu = float(random.choice([*_SPECIAL_RATIOS, *random.uniform(-0.95, 0.495, 10)]))
    friction = float(np.exp(random.uniform(np.log(1e-3), np.log(10))))
    friction = 0.0 if random.random() < 0.05 else friction
    widest = 6.0 if random.random() < 0.5 else 1.0
    base = float(10 ** random.uniform(-widest, widest))
    pressure = float(random.choice([0.0, 1.0, -1.0, *random.lognormal(0, 1.5, 2)]))
    share = float(
        random.choice([0.0, *random.uniform(-1, 1, 3), 1.0, 1 - 10 ** random.uniform(-12, -1)])
    )
    laws: Sequence[FrictionLaw] = (
        CoulombFriction(),
        ViscousFriction(float(10 ** random.uniform(-3, 3))),
        RateWeakening(float(random.uniform(0, 0.6)), float(random.lognormal(1.0, 1.0))),
    )
    return Scene(
        Material(1.0, 1.0, nu),
        friction,
        Tractions(base, share * friction * base),
        Tractions(pressure, float(random.choice([1.0, random.normal()]))),
        mode=str(random.choice(["in-plane", "antiplane"], p=[0.7, 0.3])),
        friction_law=laws[random.choice(3, p=[0.5, 0.3, 0.2])],
    )
