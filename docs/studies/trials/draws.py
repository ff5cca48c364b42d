"""Random scenes to try the methods and the judges on, each drawn from a seed of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

import semianalytic as sf
from semianalytic.cut.load import contact_opens
from semianalytic.regimes import opening_threshold
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.loads import PULSE_SHAPES, LoadHistory

_SPECIAL_RATIOS = (1 / 3, 0.25, 0.0, 0.45, -0.5)


def random_step_scene(random: np.random.Generator) -> sf.Scene:
    """A self-similar scene; raises SceneError where the draw is not admissible."""
    nu = float(random.choice([*_SPECIAL_RATIOS, *random.uniform(-0.95, 0.495, 10)]))
    least = 1e-9 if random.random() < 0.1 else 1e-3
    friction = float(np.exp(random.uniform(np.log(least), np.log(10))))
    pressure = float(random.choice([0, 1, random.lognormal(0, 1.5)], p=[0.4, 0.2, 0.4]))
    share = float(random.choice([0, random.uniform(-1, 1), 1, -1], p=[0.4, 0.4, 0.1, 0.1]))
    shear = float(random.choice([0, 1, random.normal() * random.lognormal()], p=[0.05, 0.25, 0.7]))
    solid = sf.Material(1.0, 1.0, nu)
    if random.random() < 0.15:
        remote = sf.Tractions(pressure or 1.0, shear)
        return sf.Scene(solid, friction, sf.Tractions(0.0, 0.0), remote, load_on=REMOTE)
    return sf.Scene(
        solid, friction, sf.Tractions(1.0, share * friction), sf.Tractions(pressure, shear)
    )


def random_history(random: np.random.Generator) -> LoadHistory:
    """A ramp, pulse, wave or table that lasts between a tenth and all of the time 1."""
    length = float(random.uniform(0.1, 1.0))
    kind = random.integers(4)
    if kind == 0:
        return sf.Ramp(length)
    if kind == 1:
        return sf.Pulse(length, str(random.choice(PULSE_SHAPES)))
    if kind == 2:
        return sf.Harmonic(float(random.uniform(0.3, 4.0)))
    times = np.sort(random.uniform(0, 1, 6)).round(6)
    return sf.Tabulated(tuple(np.unique(times).tolist()), tuple(random.normal(size=len(times))))


def random_history_scene(random: np.random.Generator) -> sf.Scene:
    """A scene whose loads change in time; raises SceneError where it is not admissible."""
    nu = float(random.choice([*_SPECIAL_RATIOS, random.uniform(-0.9, 0.49)]))
    friction = float(np.exp(random.uniform(np.log(0.02), np.log(2))))
    pressure = float(random.choice([0.0, random.uniform(0, 1)], p=[0.6, 0.4]))
    laws: Sequence[sf.Law] = (
        sf.Coulomb(1.0),
        sf.RateWeakening(1.0, 1 - random.uniform(0, 0.6), random.lognormal(1.0, 1.0)),
        sf.SlipWeakening(1.0, 1 - random.uniform(0, 0.8), random.lognormal(-2.0, 0.7)),
    )
    base = sf.Tractions(1.0, float(random.choice([0.0, random.uniform(-1, 1)])) * friction)
    load, histories = (
        sf.Tractions(pressure, float(random.normal())),
        (random_history(random), random_history(random)),
    )
    law = laws[random.choice(3, p=[0.5, 0.25, 0.25])].with_coefficient(friction)
    return sf.Scene(sf.Material(1.0, 1.0, nu), law, base, load, *histories)


def drawn(
    seed: int, index: int, draw: Callable[[np.random.Generator], sf.Scene]
) -> tuple[sf.Scene, np.random.Generator]:
    """The first admissible scene of a draw."""
    random = np.random.default_rng([seed, index])
    while True:
        with suppress(sf.SceneError):
            return draw(random), random


def random_wide_scene(random: np.random.Generator) -> sf.Scene:
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
    laws: Sequence[sf.Law] = (
        sf.Coulomb(1.0),
        sf.Coulomb(1.0, viscosity=10 ** random.uniform(-3, 3)),
        sf.RateWeakening(1.0, 1 - random.uniform(0, 0.6), random.lognormal(1.0, 1.0)),
    )
    held = sf.Tractions(base, share * friction * base)
    load = sf.Tractions(pressure, float(random.choice([1.0, random.normal()])))
    mode = str(random.choice(["in-plane", "antiplane"], p=[0.7, 0.3]))
    law = laws[random.choice(3, p=[0.5, 0.3, 0.2])].with_coefficient(friction)
    return sf.Scene(sf.Material(1.0, 1.0, nu), law, held, load, mode=mode)


def random_steps(random: np.random.Generator) -> sf.Scene:
    """A self-similar scene for judges; raises SceneError where the draw is not admissible.

    Half of a draw's Poisson ratios are those of real solids; one in ten has no friction, one in
    five is a sudden remote load; shear acts either way, pressure on the slot or off it.
    """
    solid, friction = _random_solid(random)
    shear = float(random.choice([-1, 1]) * random.lognormal(0.0, 0.5))
    share = random.random()
    if share < 0.2:
        remote = sf.Tractions(1.0, shear)
        return sf.Scene(solid, friction, sf.Tractions(0.0, 0.0), remote, load_on=REMOTE)
    pressure = 0.0 if share < 0.6 else float(random.choice([-1, 1]) * random.lognormal(-0.5, 0.7))
    shares = [0.0, 1.0, -1.0, random.uniform(-1, 1)]
    rest = float(random.choice(shares, p=[0.4, 0.05, 0.05, 0.5]))
    if pressure and random.random() < 0.3:
        shear = 0.0
    base = sf.Tractions(1.0, rest * friction)
    return sf.Scene(solid, friction, base, sf.Tractions(pressure, shear))


def random_opening(random: np.random.Generator) -> sf.Scene:
    """A self-similar scene whose contact opens; raises SceneError where the draw is not admissible.

    Half of them from the edge, half of them ahead of a sudden pressure on a small base; solids and
    friction as in `random_steps`, three in ten without shear.
    """
    solid, friction = _random_solid(random)
    shear = float(random.choice([-1, 1]) * random.lognormal(0.0, 0.5))
    shear = 0.0 if random.random() < 0.3 else shear
    base, step = 1.0, -float(random.lognormal(-0.5, 0.7))
    if random.random() < 0.5:
        base, step = opening_threshold(solid.poisson_ratio) * float(random.uniform(0.05, 0.95)), 1.0
    rest = float(random.choice([0.0, random.uniform(-1, 1)]))
    return sf.Scene(
        solid, friction, sf.Tractions(base, rest * friction * base), sf.Tractions(step, shear)
    )


def _random_solid(random: np.random.Generator) -> tuple[sf.Material, float]:
    nu = float(random.choice([random.uniform(-0.9, 0.49), random.choice([1 / 3, 0.25, 0.0, 0.29])]))
    friction = 0.0 if random.random() < 0.1 else float(random.uniform(0.01, 2.0))
    return sf.Material(1.0, 1.0, nu), friction


def _random_judged_history(random: np.random.Generator) -> sf.Scene:
    scene = random_history_scene(random)
    if isinstance(scene.law, sf.RateWeakening):
        # short waves grow on any grid: there is nothing to converge to
        raise sf.SceneError("Rate weakening has no answer under histories.")
    return scene


def _random_film(random: np.random.Generator) -> sf.Scene:
    scene, share = random_steps(random), float(np.exp(random.uniform(np.log(0.01), np.log(3.0))))
    film = share * scene.material.shear_impedance / 2
    return replace(scene, friction=sf.Coulomb(scene.coefficient, viscosity=film))


def _random_antiplane(random: np.random.Generator) -> sf.Scene:
    kind = _random_judged_history if random.random() < 0.3 else random_steps
    return replace(kind(random), mode="antiplane")


STEPS, HISTORIES, OPENINGS = "steps", "histories", "openings"
KINDS: Mapping[str, Callable[[np.random.Generator], sf.Scene]] = {
    STEPS: random_steps,
    HISTORIES: _random_judged_history,
    OPENINGS: random_opening,
    "viscous": _random_film,
    "antiplane": _random_antiplane,
}


def judged_scene(kind: str, random: np.random.Generator) -> sf.Scene:
    """The next admissible scene of a kind; only openings may open."""
    while True:
        with suppress(sf.SceneError):
            scene = KINDS[kind](random)
            if kind == OPENINGS or not (scene.is_self_similar and contact_opens(scene)):
                return scene
