"""Answers and simulations that are wrong on purpose, each with one mistake of a known size."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import semianalytic as sf
from fem import Simulation
from fem.lines import LineSimulation
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.answer import Answer, OpenInterval, SlipInterval, sampled_history
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.arrays import Array
from semianalytic.scene.loading import SLOT


@dataclass(frozen=True, eq=False)
class Distorted:
    """An exact answer that is late by `lag` [time], reaches `stretch` times as far, and whose slip
    rate in one of its zones, slip rate and slip, and gap are multiplied by factors.

    It is a solution of nothing.
    """

    right: sf.Solution
    lag: float = 0.0
    stretch: float = 1.0
    motion: float = 1.0
    apart: float = 1.0
    in_zone: tuple[int, float] = (0, 1.0)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.right, name)

    def _at(self, name: str, x: ArrayLike, t: ArrayLike) -> Array:
        time = np.asarray(t, dtype=float) - self.lag
        return np.asarray(getattr(self.right, name)(np.asarray(x) / self.stretch, time))

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        number, factor = self.in_zone
        rate = self.motion * self._at("slip_rate", x, t)
        if factor == 1:
            return rate
        zone, place = self.right.zones[number], np.asarray(x, dtype=float)
        inside = (place > zone.inner * np.asarray(t)) & (place < zone.outer * np.asarray(t))
        return np.where(inside, factor * rate, rate)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self.motion * self._at("slip", x, t)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self.apart * self._at("gap", x, t)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self._at("shear_traction", x, t)

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        return self._at("pressure", x, t)

    def history(self, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        return sampled_history(self, x, t)

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        senses = [int(np.sign(self.motion))] * len(self.right.zones)
        if senses:
            senses[self.in_zone[0]] *= int(np.sign(self.in_zone[1]))
        zones = zip(self.right.zones_at(t - self.lag), senses, strict=False)
        return tuple(
            replace(self._moved(zone), sense=sense * zone.sense) for zone, sense in zones if sense
        )

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        parts = self.right.openings_at(t - self.lag) if self.apart else ()
        return tuple(self._moved(part) for part in parts)

    def _moved(self, part: Any) -> Any:
        return replace(part, start=self.stretch * part.start, end=self.stretch * part.end)


def _of_another_scene(other: sf.Scene, right: Answer) -> Answer | None:
    """Return the right answer to another scene."""
    if other == right.scene:
        return None
    if not isinstance(right, sf.Marched):
        return sf.solve(other)
    given = {"nodes": right.nodes, "length": right.nodes * right.spacing}
    return sf.solve(other, method="space-time", end_time=right.end_time, **given)


def _friction(size: float, scene: sf.Scene) -> sf.Scene:
    return replace(scene, friction=scene.law.with_coefficient((1 + size) * scene.coefficient))


def _ratio(size: float, scene: sf.Scene) -> sf.Scene:
    return override_scene(scene, poisson_ratio=scene.material.poisson_ratio + size)


MISTAKEN_SCENES: Mapping[str, Callable[[sf.Scene], sf.Scene]] = {
    "friction +3 %": partial(_friction, 0.03),
    "friction -3 %": partial(_friction, -0.03),
    "ν +0.01": partial(_ratio, 0.01),
    "ν -0.004": partial(_ratio, -0.004),
    "base shear forgotten": lambda scene: replace(
        scene, base=sf.Tractions(scene.superposition.in_place.pressure, 0.0), load_on=SLOT
    ),
}
_DISTORTED: Mapping[str, Mapping[str, Any]] = {
    "speeds +0.5 %": {"stretch": 1.005},
    "speeds -0.5 %": {"stretch": 0.995},
    "motion +1 %": {"motion": 1.01},
    "motion reversed": {"motion": -1.0},
    "gap +3 %": {"apart": 1.03},
    "no opening": {"apart": 0.0},
    "no second zone": {"in_zone": (1, 0.0)},
    "second zone reversed": {"in_zone": (1, -1.0)},
    "a step late": {"lag": 1.0},
}
MISTAKES = (*MISTAKEN_SCENES, *_DISTORTED)


def spoilt(mistake: str, right: Answer, step: float) -> Any:
    """Return an answer with a mistake; None where it makes no sense.

    `step` is the time step of the simulation [time].
    """
    if mistake in MISTAKEN_SCENES:
        with suppress(sf.SceneError, sf.TensionError):  # no such base or load, or it opens
            return _of_another_scene(MISTAKEN_SCENES[mistake](right.scene), right)
    if not isinstance(right, sf.Solution) or mistake in MISTAKEN_SCENES:
        return None
    given = dict(_DISTORTED[mistake])
    if ("apart" in given and not right.openings) or ("in_zone" in given and len(right.zones) < 2):
        return None
    return Distorted(right, **{**given, "lag": step * given.get("lag", 0.0)})


PLACE = 0.3
"""Position on the contact, over c_t T, of a single node that is at fault."""
LOADED = 0.05
"""How much larger than the load of a scene is that whose simulation is mixed with its own."""
_FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
_SLOT = ("velocity_x", "velocity_y")
_WORN = ("slip_after", "final_path", "final_work_density")


def _field(name: str, factor: float, node: bool, run: Simulation) -> Simulation | None:
    """Multiply a field, or its values at one node."""
    seen = run.interface
    values = getattr(seen, name).copy()
    place = PLACE * run.scene.material.shear_speed * run.end_time
    values[:, np.argmin(np.abs(seen.x - place)) if node else slice(None)] *= factor
    if np.array_equal(values, getattr(seen, name)):
        return None
    return replace(run, interface=replace(seen, **{name: values}))


def _not_a_number(run: Simulation) -> Simulation:
    values = run.interface.pressure.copy()
    values[-1, len(values[-1]) // 3] = np.nan
    return replace(run, interface=replace(run.interface, pressure=values))


FAULTS: Mapping[str, Callable[[Simulation], Simulation | None]] = {
    "shear reversed": partial(_field, "shear_traction", -1.0, False),
    "slip × 1.05": partial(_field, "slip", 1.05, False),
    "slip rate × 1.02": partial(_field, "slip_rate", 1.02, False),
    "pressure × 1.02": partial(_field, "pressure", 1.02, False),
    "node × 10, slip rate": partial(_field, "slip_rate", 10.0, True),
    "node × 10, slip": partial(_field, "slip", 10.0, True),
    "node × 10, shear": partial(_field, "shear_traction", 10.0, True),
    "node × 10, pressure": partial(_field, "pressure", 10.0, True),
    "not a number": _not_a_number,
}


def _times(factor: float, part: Any, *names: str) -> dict[str, Any]:
    return {name: factor * getattr(part, name) for name in names}


def _scaled(run: Simulation, size: float) -> Simulation:
    """Multiply slip, gap, slip rate and what follows from them by 1 + size."""
    seen = replace(run.interface, **_times(1 + size, run.interface, "slip", "slip_rate", "gap"))
    return replace(run, interface=seen, **_times(1 + size, run, *_WORN))


def _later(lag: float, part: Any, *names: str) -> dict[str, Any]:
    """Fields of a part that are late by a lag [time], to first order."""
    fields = {name: getattr(part, name) for name in names}
    return _apart({n: item - lag * np.gradient(item, part.t, axis=0) for n, item in fields.items()})


def _apart(fields: dict[str, Any]) -> dict[str, Any]:
    return {n: np.maximum(field, 0.0) if n == "gap" else field for n, field in fields.items()}


def _late(run: Simulation, size: float) -> Simulation:
    """Let everything happen later by a part of the end time, to first order."""
    seen, lag = run.interface, size * run.end_time
    after = run.time_step * np.arange(1, len(run.slip_after) + 1)
    slip = np.concatenate([seen.slip, run.slip_after])
    slip = slip - lag * np.gradient(slip, np.concatenate([seen.t, seen.t[-1] + after]), axis=0)
    rate, traction = np.abs(seen.slip_rate[-1]), np.abs(seen.shear_traction[-1])
    return replace(
        run,
        interface=replace(seen, slip=slip[: len(seen.t)], **_later(lag, seen, *_FIELDS[1:])),
        slip_after=slip[len(seen.t) :],
        final_path=run.final_path - lag * rate,
        final_work_density=run.final_work_density - lag * rate * traction,
        slot=replace(run.slot, **_later(lag, run.slot, *_SLOT)),
    )


def mixed(usual: Simulation, more: Simulation, run: Any, size: float) -> Any:
    """Add to a run what a load larger by a size changes; `more` has one larger by `LOADED`."""

    def added(part: Any, of: Any, other: Any, names: tuple[str, ...]) -> Any:
        changed = {name: getattr(other, name) - getattr(of, name) for name in names}
        return _apart({n: getattr(part, n) + size / LOADED * changed[n] for n in names})

    seen = replace(run.interface, **added(run.interface, usual.interface, more.interface, _FIELDS))
    slot = replace(run.slot, **added(run.slot, usual.slot, more.slot, _SLOT))
    return replace(run, interface=seen, slot=slot, **added(run, usual, more, _WORN))


def loaded(scene: sf.Scene) -> sf.Scene | None:
    """Return a scene whose load is larger by `LOADED`; None if there is none."""
    given = {name: getattr(scene.load, name, None) for name in ("pressure", "shear", "stress")}
    larger = {name: (1 + LOADED) * value for name, value in given.items() if value}
    with suppress(sf.SceneError):
        return replace(scene, load=replace(scene.load, **larger)) if larger else None
    return None


def _line_scaled(run: LineSimulation, size: float) -> LineSimulation:
    return replace(run, **_times(1 + size, run, "slip", "slip_rate", "gap", "window_slip"))


def _line_late(run: LineSimulation, size: float) -> LineSimulation:
    lag = size * float(run.t[-1])
    past = np.gradient(run.slip_rate, run.t, axis=0)[:, None]
    half = np.diff(run.window)[:, None] / 2 * np.array([-1.0, 1.0])[:, None]
    return replace(
        run,
        **_later(lag, run, "slip_rate", "shear_traction", "pressure", "strength", "gap"),
        slip=run.slip - lag * run.slip_rate,
        window_slip=run.window_slip - lag * (run.slip_rate[:, None] + half * past),
    )


def _line_field(name: str, factor: float, run: LineSimulation) -> LineSimulation | None:
    """Multiply a field at one node and time of the contact, where it is at least a twentieth of its
    largest value; None where it is nothing."""
    values = getattr(run, name).copy()
    size = np.where(run.touching, np.abs(values), 0.0)
    if not size.any():
        return None
    places = np.argwhere(size > size.max() / 20)
    level, node = places[np.random.default_rng(run.steps).integers(len(places))]
    values[level, node] *= factor
    return replace(run, **{name: values})


LINE_FAULTS: Mapping[str, Callable[[LineSimulation], LineSimulation | None]] = {
    f"node × {factor:g}, {name.replace('_', ' ')}": partial(_line_field, name, factor)
    for name in ("slip_rate", "slip", "shear_traction", "pressure")
    for factor in (10.0, 0.5)
}
RUNS: Mapping[bool, Mapping[str, Callable[[Any, float], Any]]] = {
    True: {"scaled": _scaled, "late": _late},
    False: {"scaled": _line_scaled, "late": _line_late},
}
"""What makes one run of a scene (True) or of an interface wrong by a size."""
