"""Readings of a file: factors and offsets of its columns, and the conventions behind them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace

from compare.records.record import Array, Record, Records, Stated
from compare.validation.conventions import Conventions
from compare.validation.exact import AT_TIME, Sampling
from semianalytic import Scene

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
    """Numbers of a file in units and conventions of the scene: times a factor, plus an offset.

    Attributes
    ----------
    factors, offsets : mapping from str to float
        By quantity, "x" and "t"; 1 and 0 unless given.
    sampling : Sampling
        Meaning of a slip rate.
    """

    factors: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)
    sampling: Sampling = AT_TIME

    def factor(self, name: str) -> float:
        """The factor that a column is multiplied by."""
        return self.factors.get(name, 1.0)

    def offset(self, name: str) -> float:
        """The offset that is added to it then."""
        return self.offsets.get(name, 0.0)

    def place(self, record: Record) -> float:
        """Return the position of a record of the file in units of the scene [length]."""
        return record.x * self.factor("x")

    def times(self, record: Record) -> Array:
        """Return the times of a record of the file in units of the scene [time]."""
        return self.read("t", record.t)

    def apply(self, run: Records) -> Records:
        """A run in units and conventions of the scene."""
        arrivals = run.arrivals
        if arrivals is not None:
            arrivals = self.read("x", arrivals[0]), self.read("t", arrivals[1])
        return replace(
            run,
            stations=tuple(self._record(record) for record in run.stations),
            arrivals=arrivals,
            spacing=None if run.spacing is None else run.spacing * self.factor("x"),
        )

    def read(self, name: str, values: Array) -> Array:
        """Return numbers of a column in units and conventions of the scene."""
        return values * self.factor(name) + self.offset(name)

    def _record(self, record: Record) -> Record:
        return Record(
            self.place(record),
            self.times(record),
            {name: self.read(name, values) for name, values in record.values.items()},
        )


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
    offsets = {"t": conventions.time_shift}
    for name in TRACTIONS:
        if conventions.tractions == "changes" or (
            name in stated.changes and conventions.tractions is None
        ):
            offsets[name] = base_of(scene, name)
    sampling = AT_TIME if conventions.rate is None else Sampling(conventions.rate)
    if conventions.rate is None and stated.mean:
        step = None if stated.step is None else stated.step * factors["t"]
        sampling = Sampling(stated.mean, step)
    return Conversion(factors, offsets, sampling)


def base_of(scene: Scene, name: str) -> float:
    """A quantity where no wave from the slot has come yet: a traction [stress], or nothing.

    A load from afar is on the contact from t = 0 on, so that it counts as base.
    """
    held = scene.superposition.in_place
    return {"shear_traction": held.shear, "pressure": held.pressure}.get(name, 0.0)
