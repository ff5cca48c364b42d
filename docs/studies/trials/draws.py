"""Random scenes to try the methods and the judges on, each drawn from a seed of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.cut.load import contact_opens
from semianalytic.regimes import opening_threshold
from semianalytic.scene.arrays import Array
from semianalytic.scene.loading import REMOTE, SLOT
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


def _random_wave(random: np.random.Generator) -> sf.Scene:
    """A P, SV or SH wave at 0 to 80 degrees either way from one of the bodies; some have a base
    shear, and some rise in time."""
    kind = str(random.choice(["P", "SV", "SH"]))
    solid, friction = _random_solid(random)
    angle, side = float(random.uniform(-80, 80)), str(random.choice(["below", "above"]))
    stress = float(random.choice([-1, 1]) * random.uniform(0.1, 0.8))
    shear = float(random.choice([0.0, random.uniform(-0.9, 0.9)])) * friction
    mode = "antiplane" if kind == "SH" else "in-plane"
    load = sf.IncidentWave(kind, angle, stress=stress, from_=side)
    rise = sf.Ramp(float(random.uniform(0.1, 0.6))) if random.random() < 0.2 else sf.Step()
    return sf.Scene(solid, friction, sf.Tractions(1.0, shear), load, rise, rise, mode=mode)


def _random_moving(random: np.random.Generator) -> sf.Scene:
    """A load that moves over the slot faces, either way, at 0.3 to 8 c_t."""
    solid, friction = _random_solid(random)
    speed = float(random.choice([-1, 1]) * np.exp(random.uniform(np.log(0.3), np.log(8.0))))
    pressure = float(random.choice([0.0, random.uniform(-0.5, 1.0)]))
    load = sf.MovingLoad(speed, pressure, float(random.normal()))
    return sf.Scene(solid, friction, sf.Tractions(1.0, 0.0), load)


def _random_pair(random: np.random.Generator) -> sf.Scene:
    """Two different bodies; impedances differ by up to three times either way."""
    scene, contrast = random_steps(random), float(np.exp(random.uniform(-1.1, 1.1)))
    density = float(random.uniform(0.5, 2.0))
    lower = sf.Material(contrast**2 / density, density, float(random.uniform(0.0, 0.4)))
    return replace(scene, lower_material=lower)


def _random_rate_weakening(random: np.random.Generator) -> sf.Scene:
    scene = random_steps(random)
    reduction, rate = float(random.uniform(0.0, 0.6)), float(random.lognormal(1.0, 1.0))
    return replace(scene, friction=sf.RateWeakening(scene.coefficient, 1 - reduction, rate))


def _random_flanks(random: np.random.Generator) -> sf.Scene:
    """A pulse whose flanks take half of the time in which a wave crosses an element."""
    scene, flank = random_steps(random), 0.005
    begin, end = np.sort(random.uniform(0.0, 0.9, 2)).round(3).tolist()
    times = (begin, begin + flank, end + 2 * flank, end + 3 * flank)
    pulse = sf.Tabulated((0.0, *times) if begin else times, (0.0,) * bool(begin) + (0, 1, 1, 0))
    return replace(scene, pressure_history=pulse, shear_history=pulse, load_on=SLOT)


def _random_si(random: np.random.Generator) -> sf.Scene:
    scene, pascal = random_steps(random), float(10 ** random.uniform(5, 8))
    solid = sf.Material(
        float(10 ** random.uniform(6, 10.6)),
        float(random.uniform(900, 3000)),
        float(random.choice([0.25, 0.33, 0.45, 0.495])),
    )
    base, load = (
        sf.Tractions(pascal * traction.pressure, pascal * traction.shear)
        for traction in (scene.base, scene.superposition.taken_off)
    )
    return sf.Scene(solid, scene.coefficient, base, load, load_on=scene.load_on, units="SI")


STEPS, HISTORIES, OPENINGS = "steps", "histories", "openings"
KINDS: Mapping[str, Callable[[np.random.Generator], sf.Scene]] = {
    STEPS: random_steps,
    HISTORIES: _random_judged_history,
    OPENINGS: random_opening,
    "viscous": _random_film,
    "antiplane": _random_antiplane,
    "waves": _random_wave,
    "moving": _random_moving,
    "pairs": _random_pair,
    "rate weakening": _random_rate_weakening,
    "flanks": _random_flanks,
    "SI": _random_si,
}


def judged_scene(kind: str, random: np.random.Generator) -> sf.Scene:
    """The next admissible scene of a kind; only openings may open."""
    while True:
        with suppress(sf.SceneError):
            scene = KINDS[kind](random)
            asked = scene.is_self_similar and scene.lower_material is None and not scene.antiplane
            if kind == OPENINGS or not (asked and contact_opens(scene)):
                return scene


def _patch(size: float, width: float, x: Array) -> Array:
    return size * np.exp(-((x / width) ** 2))


def _spreading(size: float, rate: float, x: Array, t: float) -> Array:
    return size * np.clip((rate * t - np.abs(x)) / 0.4 + 0.5, 0.0, 1.0)


def _burst(size: float, x: Array, t: float) -> Array:
    return -size * np.exp(-4 * x**2) * min(2 * t, 1.0)


_SLOT = sf.Contact([(-6.0, -1.0), (1.0, 6.0)])


def judged_interface(kind: str, random: np.random.Generator) -> sf.Scene:
    """A random interface of a kind, 12 long, that pickles; raises SceneError where the draw is not
    admissible."""
    friction, shear = float(random.uniform(0.1, 0.7)), float(random.uniform(0.3, 0.9))
    sense = float(random.choice([-1.0, 1.0]))
    held, excess = sense * friction * shear, sense * friction * float(random.uniform(0.4, 1.0))
    patch = partial(_patch, excess, float(random.uniform(0.4, 1.0)))
    rise = sf.Ramp(float(random.uniform(0.2, 1.0)))
    loads = [sf.InterfaceLoad(patch, history=rise)]
    if kind in ("pair", "weakening") and random.random() < 0.5:
        spreading = partial(_spreading, excess, float(random.uniform(0.15, 0.5)))
        loads = [sf.InterfaceLoad(spreading, history=None)]
    law: sf.Law = sf.Coulomb(friction)
    given: dict[str, Any] = {"shear": held, "loads": loads}
    if kind == "weakening":
        drop, distance = float(random.uniform(0.3, 0.9)), float(random.uniform(0.3, 1.0))
        law = sf.SlipWeakening(friction, drop * friction, distance)
    if kind == "rate-and-state":
        a, b = float(random.uniform(0.01, 0.03)), float(random.uniform(0.01, 0.04))
        law = sf.RateAndState(a=a, b=b, f0=0.6, v0=1e-3, distance=float(random.uniform(0.2, 0.5)))
        given |= {"shear": 0.55, "rate": 1e-6}
    if kind == "slot" or (kind == "pair" and random.random() < 0.5):
        load = sf.InterfaceLoad(sense * float(random.uniform(0.5, 1.5)), on="slot")
        given = {"loads": [load], "contact": _SLOT, "even": kind == "slot"}
    if kind == "opening":
        burst = partial(_burst, float(random.uniform(1.2, 2.5)))
        given = {"shear": held, "loads": [sf.InterfaceLoad(pressure=burst, history=None)]}
    mode = "antiplane" if kind == "antiplane" else "in-plane"
    solid, lower = sf.Material(1.0, 1.0, float(random.uniform(0.15, 0.35))), None
    if kind == "pair" or (kind == "antiplane" and random.random() < 0.5):
        density, contrast = float(random.uniform(0.7, 1.4)), float(random.uniform(1.1, 3.0))
        lower = sf.Material(density * contrast**2, density, float(random.uniform(0.15, 0.35)))
    given |= {"mode": mode, "lower_material": lower}
    return scene_along(solid, law, 12.0, **given)
