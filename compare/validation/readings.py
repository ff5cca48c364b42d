"""Readings of a file: factors and offsets of its columns, and the conventions behind them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from compare.records.record import Record, Records, Stated
from compare.validation.conventions import Conventions
from compare.validation.exact import AT_TIME, Sampling
from semianalytic import Scene
from semianalytic.scene.arrays import Array
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.line.loads import InterfaceLoad
from semianalytic.scene.loading import Tractions

MOTION = ("slip_rate", "slip")
TRACTIONS = ("shear_traction", "pressure")
TURNS: Mapping[str, tuple[tuple[str, ...], str]] = {
    "sign": (("slip", "slip_rate", "shear_traction"), "the sign is the other way"),
    "slip": (("slip", "slip_rate"), "half of the relative one, doubled"),
    "pressure": (("pressure",), "tension is positive"),
    "tractions": (TRACTIONS, "changes since t = 0, the base is added"),
}
"""Quantities that each convention turns, and what the second of its `WORDS` means."""


@dataclass(frozen=True)
class Conversion:
    """Numbers of a file in units and conventions of the scene: times a factor, plus an offset."""

    # by quantity, "x" and "t"; 1 unless given
    factors: Mapping[str, float] = field(default_factory=dict)
    # what is added to changes of tractions, as a function of x, by quantity
    bases: Mapping[str, Callable[[float], float]] = field(default_factory=dict)
    shift: float = 0.0  # what is added to times
    sampling: Sampling = AT_TIME  # meaning of a slip rate

    def factor(self, name: str) -> float:
        """The factor that a column is multiplied by."""
        return self.factors.get(name, 1.0)

    def place(self, record: Record) -> float:
        """Return the position of a record of the file in units of the scene [length]."""
        return record.x * self.factor("x")

    def times(self, record: Record) -> Array:
        """Return the times of a record of the file in units of the scene [time]."""
        return record.t * self.factor("t") + self.shift

    def apply(self, run: Records) -> Records:
        """A run in units and conventions of the scene."""
        arrivals = run.arrivals
        if arrivals is not None:
            x, t = arrivals
            arrivals = x * self.factor("x"), t * self.factor("t") + self.shift
        return replace(
            run,
            stations=tuple(self._record(record) for record in run.stations),
            arrivals=arrivals,
            spacing=None if run.spacing is None else run.spacing * self.factor("x"),
        )

    def _record(self, record: Record) -> Record:
        x = self.place(record)
        values = {
            name: value * self.factor(name) + (self.bases[name](x) if name in self.bases else 0.0)
            for name, value in record.values.items()
        }
        return Record(x, self.times(record), values)


def turn_words(conventions: Mapping[str, str], recorded: Collection[str]) -> Iterator[str]:
    """Describe conventions that are not as given, for the quantities that were recorded."""
    for name in conventions:
        quantities, words = TURNS[name]
        there = (quantity.replace("_", " ") for quantity in quantities if quantity in recorded)
        yield f"{' and '.join(there)}: {words}"


def given_reading(conventions: Conventions, stated: Stated, scene: Scene) -> Conversion:
    """The reading that conventions and the file itself ask for."""
    factors = conventions.scales(stated)
    sign = -1.0 if conventions.sign == "reversed" else 1.0
    for name in MOTION:
        alone = name in stated.faces and conventions.slip is None
        factors[name] *= sign * (2.0 if conventions.slip in ("half", "face") or alone else 1.0)
    factors["shear_traction"] *= sign
    factors["pressure"] *= -1.0 if conventions.pressure == "tension" else 1.0
    bases = {
        name: partial(base_of, scene, name)
        for name in TRACTIONS
        if conventions.tractions == "changes"
        or (name in stated.changes and conventions.tractions is None)
    }
    sampling = AT_TIME if conventions.rate is None else Sampling(conventions.rate)
    if conventions.rate is None and stated.mean:
        step = None if stated.step is None else stated.step * factors["t"]
        sampling = Sampling(stated.mean, step)
    return Conversion(factors, bases, conventions.time_shift, sampling)


def base_of(scene: Scene, name: str, x: float) -> float:
    """A traction at x where no wave has come yet [stress]; 0 of all else.

    A load from afar is on the contact from t = 0 on, so that it counts as base.
    """
    if name not in TRACTIONS:
        return 0.0
    sudden = scene.has_slot and not scene.on_line and not scene.grows
    held = scene.superposition.in_place if sudden else scene.base
    traction = getattr(held, "shear" if name == "shear_traction" else name)
    return float(sampled(name, traction, np.array([x]))[0]) if scene.on_line else traction


def faces_are_mirrored(scene: Scene) -> bool:
    """Whether slip is twice the motion of one face: bodies are alike, and shear acts alone."""
    loads = scene.load if isinstance(scene.load, tuple) else (scene.load,)
    return scene.lower_material is None and all(
        isinstance(load, Tractions | InterfaceLoad) and not load.pressure for load in loads
    )
