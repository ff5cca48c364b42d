"""Scenes that the trial records are made from, and what a code without any error would record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from compare.records.record import QUANTITIES, Array
from docs.studies.judge.scenes import random_opening, random_steps
from docs.studies.trials.draws import drawn
from semianalytic import Material, Pulse, Scene, Tractions, march, solve
from semianalytic.cut.load import contact_opens
from semianalytic.results.answer import Answer
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.units import SI

STATIONS = (0.1, 0.25, 0.5, 0.75, 0.95)
"""Positions of the trial records over c_t T."""
LEVELS = 241
"""Times of a record, from 0 to T."""
MARCH_NODES = 400
SEED = 25

Values = dict[str, Array]
"""t (m,), x (n,) and each quantity (m, n), in units of the scene."""


@dataclass(frozen=True)
class Setting:
    """A scene and the time T until which it is recorded [time]."""

    name: str
    scene: Scene
    end_time: float

    @property
    def length(self) -> float:
        """c_t T [length]."""
        return self.scene.material.shear_speed * self.end_time


def _in_units(scene: Scene, solid: Material, stress: float) -> Scene:
    """A scene of unit tractions on a solid in SI units, with tractions in units of `stress`."""
    base, load = (
        Tractions(stress * one.pressure, stress * one.shear)
        for one in (scene.base, scene.superposition.taken_off)
    )
    return replace(scene, material=solid, base=base, load=load, units=SI)


def _slipping(
    draw: Callable[[np.random.Generator], Scene] = random_steps, *, remote: bool = False
) -> Scene:
    """A random scene in which the contact slips and both tractions change."""
    for number in range(1000):
        scene, _ = drawn(SEED, number, draw)
        load = scene.superposition.taken_off
        if not (load.pressure and load.shear and scene.friction > 0.05):
            continue
        if remote != (scene.load_on == REMOTE) or contact_opens(scene) != (draw == random_opening):
            continue
        if len(solve(scene).zones):
            return scene
    raise AssertionError("no scene was drawn")


def _pmma(nu: float) -> Material:
    return Material(2.3e9, 1190.0, nu)


@cache
def settings() -> dict[str, Setting]:
    """Scenes by name: of plain units, of rocks over kilometres, of blocks in a laboratory."""
    rock, steel = Material(1e10, 2500.0, 1 / 3), Material(8e10, 7800.0, 0.29)
    shear = Scene(Material(1.0, 1.0, 1 / 3), 0.3, Tractions(1.0, 0.0), Tractions(0.0, 1.0))
    first, second, opening = _slipping(remote=True), _slipping(), _slipping(random_opening)
    pulse = replace(shear, friction=0.15, shear_history=Pulse(20e-6))
    both = (
        Setting("plain", first, 1.0),
        Setting("plain shear", shear, 1.0),
        Setting("rock", _in_units(shear, rock, 1e7), 1.0),
        Setting("rock under pressure", _in_units(second, rock, 2e7), 3.0),
        Setting("PMMA", _in_units(first, _pmma(first.material.poisson_ratio), 5e6), 50e-6),
        Setting("steel, antiplane", _in_units(replace(shear, mode="antiplane"), steel, 3e7), 20e-6),
        Setting("PMMA that opens", _in_units(opening, _pmma(0.35), 5e6), 50e-6),
        Setting("PMMA, a pulse", _in_units(pulse, _pmma(0.35), 5e6), 50e-6),
    )
    return {one.name: one for one in both}


@cache
def _answer(name: str) -> Answer:
    setting = settings()[name]
    if setting.scene.is_self_similar:
        return solve(setting.scene)
    length = setting.length * 1.25
    return march(setting.scene, setting.end_time, MARCH_NODES, length=length, companion=False)


def recorded(setting: Setting, answer: Answer | None = None, levels: int = LEVELS) -> Values:
    """Exact records of a setting, or those of another answer at the same stations."""
    answer = answer or _answer(setting.name)
    t = np.linspace(0.0, setting.end_time, levels)
    x = np.array(STATIONS) * setting.length
    values = {name: np.asarray(getattr(answer, name)(x, t[:, None])) for name in QUANTITIES}
    return {"t": t, "x": x, **values}


def mean_rates(setting: Setting, t: Array, x: Array, which: str) -> Array:
    """Slip rates as means over the step "before" or "after" each time, (m, n)."""
    slip = np.asarray(_answer(setting.name).slip(x, t[:, None]))
    steps = np.diff(slip, axis=0) / np.diff(t)[:, None]
    edge = steps[:1] if which == "before" else steps[-1:]
    return np.concatenate(
        [edge * (which != "before"), steps] if which == "before" else [steps, edge]
    )
