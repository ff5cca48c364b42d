"""Readings of a file: factors and offsets of its columns, and the conventions behind them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from compare.records.record import Array, Record, Records, Stated
from compare.validation.conventions import Conventions
from compare.validation.exact import AT_TIME, Sampling
from semianalytic import Scene

MOTION = ("slip_rate", "slip")
TRACTIONS = ("shear_traction", "pressure")


@dataclass(frozen=True)
class Reading:
    """Numbers of a file in units and conventions of the scene: times a factor, plus an offset.

    Attributes
    ----------
    factors, offsets : mapping from str to float
        By quantity, "x" and "t"; 1 and 0 unless given.
    sampling : Sampling
        What a slip rate is.
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
        return self._read("t", record.t)

    def apply(self, run: Records) -> Records:
        """A run in units and conventions of the scene."""
        arrivals = run.arrivals
        if arrivals is not None:
            arrivals = self._read("x", arrivals[0]), self._read("t", arrivals[1])
        return replace(
            run,
            stations=tuple(self._record(record) for record in run.stations),
            arrivals=arrivals,
            spacing=None if run.spacing is None else run.spacing * self.factor("x"),
        )

    def _read(self, name: str, values: Array) -> Array:
        return values * self.factor(name) + self.offset(name)

    def _record(self, record: Record) -> Record:
        return Record(
            self.place(record),
            self.times(record),
            {name: self._read(name, values) for name, values in record.values.items()},
        )


@dataclass(frozen=True)
class Choice:
    """Conventions of a whole file that nobody has stated.

    Attributes
    ----------
    half, turned, tension, changes : bool
        Slip and slip rate are half of the relative ones; they and shear traction point the other
        way; tension is positive; tractions are changes since t = 0.
    """

    half: bool = False
    turned: bool = False
    tension: bool = False
    changes: bool = False

    def words(self, names: tuple[str, ...]) -> str:
        """Description of all that is not as given, for the report.

        Parameters
        ----------
        names : tuple of str
            Quantities that were recorded.
        """
        motion = _listed(name for name in ("slip", "slip_rate") if name in names)
        turned = _listed(n for n in ("slip", "slip_rate", "shear_traction") if n in names)
        tractions = _listed(name for name in TRACTIONS if name in names)
        parts = []
        if self.half:
            parts.append(f"{motion}: half of the relative one, doubled")
        if self.turned:
            parts.append(f"{turned}: the sign is the other way")
        if self.tension:
            parts.append("pressure: tension is positive")
        if self.changes:
            parts.append(f"{tractions}: changes since t = 0, the base is added")
        return "; ".join(parts)

    @property
    def stating(self) -> Conventions:
        """Conventions that state the choice, so that nothing has to be inferred."""
        return Conventions(
            sign="reversed" if self.turned else None,
            slip="half" if self.half else None,
            pressure="tension" if self.tension else None,
            tractions="changes" if self.changes else None,
        )


def given_reading(conventions: Conventions, stated: Stated, scene: Scene) -> Reading:
    """The reading that conventions and the file itself ask for.

    Raises
    ------
    SceneError
        If a scale is given for a column whose unit the file names.
    """
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
    return Reading(factors, offsets, _sampling(conventions, stated, factors["t"]))


def base_of(scene: Scene, name: str) -> float:
    """A quantity where no wave from the slot has come yet: a traction [stress], or nothing.

    A load from afar is on the contact from t = 0 on, so that it counts as base.
    """
    held = scene.superposition.in_place
    return {"shear_traction": held.shear, "pressure": held.pressure}.get(name, 0.0)


def _sampling(conventions: Conventions, stated: Stated, scale: float) -> Sampling:
    if conventions.rate is not None:
        return Sampling(conventions.rate)
    if stated.mean:
        return Sampling(stated.mean, None if stated.step is None else stated.step * scale)
    return AT_TIME


def chosen_reading(choice: Choice, given: Reading, stated: Stated, scene: Scene) -> Reading:
    """The reading of a choice; slip and slip rate of one face alone are doubled already."""
    factors, offsets = dict(given.factors), dict(given.offsets)
    sign = -1.0 if choice.turned else 1.0
    for name in MOTION:
        factors[name] *= sign * (2.0 if choice.half and name not in stated.faces else 1.0)
    factors["shear_traction"] *= sign
    factors["pressure"] *= -1.0 if choice.tension else 1.0
    if choice.changes:
        offsets |= {name: base_of(scene, name) for name in TRACTIONS}
    return replace(given, factors=factors, offsets=offsets)


def settings_of(conventions: Conventions) -> Iterator[tuple[str, str]]:
    """Names and values of what conventions settle, as options have them."""
    for name, size in conventions.scale.items():
        yield "scale", f"{name}={size:.12g}"
    for name in ("sign", "slip", "pressure", "tractions", "rate"):
        value = getattr(conventions, name)
        if value is not None:
            yield name, value


def _listed(names: Iterator[str]) -> str:
    return " and ".join(name.replace("_", " ") for name in names)
