"""How numbers of a file are to be read: units, signs, halves; detected, and always said.

A reading other than the one given is taken only where it is better by `CLEAR` at least and leaves
less than `SMALL` of a quantity unexplained.  Every reading is one of a few fixed ones, powers of
ten, signs, two faces for one, so that no answer that is off by some per cent is mended.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from compare.records.record import Record, Records
from compare.validation.conventions import Conventions
from compare.validation.exact import AFTER, BEFORE, POINT, Exact, exact_answer
from compare.validation.norms import quantity_norm
from semianalytic import Scene
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.units import unit

CLEAR = 5.0
"""Times that another reading has to be better than the one given."""
SMALL = 0.1
"""Relative error above which no reading explains anything."""
SHARP = 0.02
"""The same for readings that differ by half a step only."""
LOOKED_AT = 6
"""Stations that readings are tried on."""
NEAREST, FARTHEST = 0.02, 1.0
"""Over c_l T, between which the outermost station has to be for units to be inferred."""
SHIFTS = 41
SAMPLES = 60
"""Of a record, enough for the time origin."""
LARGEST_SHIFT = 0.2
"""Of the time origin, over T."""
MOTION = ("slip_rate", "slip")
TRACTIONS = ("shear_traction", "pressure")
WORDS = {name: name.replace("_", " ") for name in (*MOTION, *TRACTIONS)}


@dataclass(frozen=True)
class Reading:
    """What numbers of a file are multiplied by, what is added then, and when slip rate is meant.

    Attributes
    ----------
    factors, offsets : mapping from str to float
        By quantity, "x" and "t"; 1 and 0 unless given.
    mean : str
        `POINT`, `BEFORE` or `AFTER`.
    """

    factors: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)
    mean: str = POINT

    def apply(self, run: Records) -> Records:
        """A run in units and conventions of the scene."""
        arrivals = run.arrivals
        if arrivals is not None:
            arrivals = self._read("x", arrivals[0]), self._read("t", arrivals[1])
        factor = self.factors.get("x", 1.0)
        return replace(
            run,
            stations=tuple(self._record(record) for record in run.stations),
            arrivals=arrivals,
            spacing=None if run.spacing is None else run.spacing * factor,
        )

    def multiplied(self, name: str, factor: float, offset: float = 0.0) -> Reading:
        """The same with one quantity read otherwise."""
        given = self.factors.get(name, 1.0)
        return replace(
            self,
            factors={**self.factors, name: given * factor},
            offsets={**self.offsets, name: self.offsets.get(name, 0.0) + offset},
        )

    def _read(self, name: str, values: np.ndarray) -> np.ndarray:
        return values * self.factors.get(name, 1.0) + self.offsets.get(name, 0.0)

    def _record(self, record: Record) -> Record:
        return Record(
            record.x * self.factors.get("x", 1.0),
            self._read("t", record.t),
            {name: self._read(name, values) for name, values in record.values.items()},
        )


Choice = tuple[float, float, str]
"""Factor, offset, and what it would mean."""


@dataclass(frozen=True, eq=False)
class Detection:
    """The exact answer, how a run is to be read, and what has to be said of that."""

    exact: Exact
    reading: Reading
    notes: tuple[str, ...]


def detect(run: Records, scene: Scene, conventions: Conventions) -> Detection:
    """How a run is to be read; what is told are obeyed, whatever else is detected is said.

    Raises
    ------
    DataFileError
        If no station lies where anything happens.
    """
    given = given_reading(conventions)
    sample = replace(run, stations=_some(run.stations))
    end = last_time(given.apply(run))
    exact = exact_answer(scene, end, _reach(given.apply(run), scene, end))
    reading, notes = _units_and_signs(sample, exact, given, conventions)
    exact = replace(exact, end_time=last_time(reading.apply(run)))
    reading, said = _means(sample, exact, reading)
    notes += said + _shift(reading.apply(sample), exact)
    return Detection(exact, reading, (*_given_notes(conventions), *notes))


def given_reading(conventions: Conventions) -> Reading:
    """The reading that conventions ask for."""
    factors = conventions.factors()
    sign = -1.0 if conventions.sign == "reversed" else 1.0
    twice = 2.0 if conventions.slip in ("half", "face") else 1.0
    for name in MOTION:
        factors[name] *= sign * twice
    factors["shear_traction"] *= sign
    factors["pressure"] *= -1.0 if conventions.pressure == "tension" else 1.0
    return Reading(factors, {"t": conventions.time_shift})


def last_time(run: Records) -> float:
    """When the last record ends [time].

    Raises
    ------
    DataFileError
        If nothing was recorded after t = 0.
    """
    ends = [float(record.t[-1]) for record in run.stations if len(record.t)]
    if run.arrivals is not None:
        ends += [float(time) for time in run.arrivals[1] if np.isfinite(time)]
    end = max(ends, default=0.0)
    if end <= 0:
        raise DataFileError(
            f"{run.source or 'validate'}: nothing was recorded after t = 0, when the load comes; "
            "shift the times (time_shift)."
        )
    return end


def _reach(run: Records, scene: Scene, end: float) -> float:
    """The farthest position that is compared [length]."""
    farthest = scene.material.longitudinal_speed * end
    places = [record.x for record in run.stations]
    if run.arrivals is not None:
        places += [float(place) for place in run.arrivals[0]]
    return max((place for place in places if 0 < place <= farthest), default=0.1 * farthest)


def _some(stations: Sequence[Record]) -> tuple[Record, ...]:
    right = [record for record in stations if record.x > 0]
    chosen = np.unique(np.linspace(0, len(right) - 1, LOOKED_AT).round().astype(int))
    return tuple(right[place] for place in chosen) if right else ()


def _units_and_signs(
    run: Records, exact: Exact, given: Reading, conventions: Conventions
) -> tuple[Reading, tuple[str, ...]]:
    """The plainest reading that explains all that was recorded."""
    reading, notes, error = _amplitudes(run, exact, given, conventions)
    if error < SMALL or conventions.scale:
        return reading, notes
    least = min(SMALL, error / CLEAR)
    for (x, t), words in _places_and_times(exact):
        other = given.multiplied("x", x).multiplied("t", t)
        placed = replace(exact, end_time=exact.end_time * t)
        if not _are_passed(other.apply(run), placed):
            continue
        tried, said, left = _amplitudes(run, placed, other, conventions)
        if left < least:
            return tried, (words, *said)
    return reading, notes


def _are_passed(run: Records, exact: Exact) -> bool:
    """Whether waves pass stations while they record: elsewhere anything fits a base state."""
    farthest = exact.scene.material.longitudinal_speed * exact.end_time
    places = [record.x / farthest for record in run.stations]
    return bool(places) and max(places) <= FARTHEST and max(places) >= NEAREST


def _amplitudes(
    run: Records, exact: Exact, given: Reading, conventions: Conventions
) -> tuple[Reading, tuple[str, ...], float]:
    """Signs, halves and units of every quantity by itself, and the largest error that is left."""
    reading, left = given, 0.0
    said: dict[str, list[str]] = {}
    for name in (*MOTION, *TRACTIONS):
        errors = _errors(run, exact, given, name)
        if (error := errors(1.0, 0.0)) is None:
            continue
        if _is_stuck(exact, run, given, name):
            continue
        for family in (_signs(name, exact.scene, conventions), _units(name, exact, conventions)):
            best = _clearly_best(errors, error, family)
            if best is not None:
                factor, offset, words = best
                reading = reading.multiplied(name, factor, offset)
                error = errors(factor, offset) or 0.0
                said.setdefault(words, []).append(WORDS[name])
                break
        left = max(left, error)
    return reading, tuple(f"{' and '.join(names)}: {words}" for words, names in said.items()), left


def _errors(
    run: Records, exact: Exact, given: Reading, name: str
) -> Callable[[float, float], float | None]:
    def error(factor: float, offset: float) -> float | None:
        only = Records(
            tuple(
                Record(record.x, record.t, {name: record.values[name]})
                for record in run.stations
                if name in record.values
            )
        )
        norm = quantity_norm(given.multiplied(name, factor, offset).apply(only), name, exact)
        return None if norm is None else norm.L1

    return error


def _is_stuck(exact: Exact, run: Records, given: Reading, name: str) -> bool:
    """Whether the answer is nothing, which every reading would fit."""
    norm = quantity_norm(given.apply(run), name, exact)
    return norm is None or norm.exact <= 1e-6


def _clearly_best(
    errors: Callable[[float, float], float | None], error: float, family: Iterable[Choice]
) -> Choice | None:
    best, least = None, min(SMALL, error / CLEAR)
    for choice in family:
        left = errors(choice[0], choice[1])
        if left is not None and left < least:
            best, least = choice, left
    return best


def _signs(name: str, scene: Scene, conventions: Conventions) -> Iterator[Choice]:
    """Other signs, half of the slip, tractions without the base."""
    flip = "the sign is the other way; read with it changed"
    if name in MOTION:
        signs = [(1.0, "")] + ([(-1.0, f", and {flip}")] if conventions.sign is None else [])
        if conventions.slip is None:
            half = "half of the relative one (one face, or a half-space): doubled"
            note = "" if scene.load.pressure == 0 else ", which pressure on the faces would not be"
            yield from ((2 * sign, 0.0, f"{half}{words}{note}") for sign, words in signs)
        yield from ((sign, 0.0, flip) for sign, words in signs if words)
        return
    held = scene.superposition.in_place
    base = held.shear if name == "shear_traction" else held.pressure
    fixed = conventions.sign if name == "shear_traction" else conventions.pressure
    if fixed is None:
        word = flip if name == "shear_traction" else "tension is positive; read with it changed"
        yield -1.0, 0.0, word
    if base:
        change = "the change since t = 0; the base is added"
        yield 1.0, base, change
        if fixed is None:
            yield -1.0, base, f"{change}, and {flip}"


def _units(name: str, exact: Exact, conventions: Conventions) -> Iterator[Choice]:
    """Units of a quantity that are not those of the scene, with signs and halves."""
    if conventions.scale:
        return
    scene = exact.scene
    for factor, words in _scales(name, scene):
        yield factor, 0.0, words
        for sign, offset, also in _signs(name, scene, conventions):
            yield sign * factor, offset, f"{words}; {also}"


def _scales(name: str, scene: Scene) -> Iterator[tuple[float, str]]:
    for factor, words in _traction_units(scene):
        if name in MOTION:
            modulus = scene.material.shear_modulus
            factor *= scene.material.shear_speed / modulus
        if abs(factor - 1) > 1e-9:
            yield factor, f"without dimension, {words}; times {factor:.6g}"
    powers = (-6, -3, -2, 3) if name in MOTION else (3, 6, 9)
    dimension = {"slip": "length", "slip_rate": "length / time"}.get(name, "stress")
    for power in powers:
        yield 10.0**power, f"in other units than [{unit(dimension, scene.units)}]; times 1e{power}"


def _traction_units(scene: Scene) -> Iterator[tuple[float, str]]:
    """Tractions that numbers without dimension may be over."""
    seen = set()
    for part, words in ((scene.load, "load"), (scene.base, "base")):
        for name in ("shear", "pressure"):
            size = abs(getattr(part, name))
            if size and size not in seen:
                seen.add(size)
                yield size, f"over the {name} of the {words}"


def _places_and_times(exact: Exact) -> Iterator[tuple[tuple[float, float], str]]:
    """Units of positions and times that are not those of the scene."""
    speed = exact.scene.material.shear_speed
    if abs(speed - 1) > 1e-9:
        yield (speed, 1.0), f"positions are over c_t times the unit of time: times {speed:.6g}"
    if not exact.scene.is_self_similar:
        return
    for x, t in itertools.product((0, -3, 3), (0, -3, -6)):
        if x != t:
            yield (10.0**x, 10.0**t), f"positions are taken times 1e{x}, times times 1e{t}"


def _means(run: Records, exact: Exact, reading: Reading) -> tuple[Reading, tuple[str, ...]]:
    """Whether a slip rate is the mean over a step."""
    read = reading.apply(run)
    norms = {mean: quantity_norm(read, "slip_rate", exact, mean) for mean in (POINT, BEFORE, AFTER)}
    errors = {mean: norm.L1 for mean, norm in norms.items() if norm is not None and norm.exact > 0}
    if not errors:
        return reading, ()
    best = min(errors, key=errors.__getitem__)
    if best == POINT or errors[best] > min(SHARP, errors[POINT] / CLEAR):
        return reading, ()
    note = f"slip rate: the mean over the step {best} its time; held against the exact mean"
    return replace(reading, mean=best), (note,)


def _shift(run: Records, exact: Exact) -> tuple[str, ...]:
    """What is said, and not mended, of a time origin that is not that of the load."""
    name = next(
        (name for name in MOTION if any(name in record.values for record in run.stations)), None
    )
    if name is None or (norm := quantity_norm(run, name, exact)) is None or norm.exact == 0:
        return ()
    few, most = _thinned(run), LARGEST_SHIFT * exact.end_time

    def error(shift: float) -> float:
        return _shifted_error(few, exact, name, shift)

    shifts = np.linspace(-most, most, SHIFTS)
    nearest = float(shifts[np.argmin([error(float(shift)) for shift in shifts])])
    room = 2 * most / (SHIFTS - 1)
    best = scipy.optimize.minimize_scalar(
        error, bounds=(nearest - room, nearest + room), method="bounded"
    )
    if best.fun > min(SMALL, norm.L1 / CLEAR):
        return ()
    return (
        f"times: the records fit best if {best.x:.3g} is added to them; they are left as they are "
        f"(time_shift {best.x:.3g} would move them)",
    )


def _thinned(run: Records) -> Records:
    stations = tuple(
        Record(
            record.x,
            record.t[:: max(len(record.t) // SAMPLES, 1)],
            {
                name: values[:: max(len(values) // SAMPLES, 1)]
                for name, values in record.values.items()
            },
        )
        for record in run.stations
    )
    return replace(run, stations=stations)


def _shifted_error(run: Records, exact: Exact, name: str, shift: float) -> float:
    moved = replace(
        run, stations=tuple(replace(record, t=record.t + shift) for record in run.stations)
    )
    norm = quantity_norm(moved, name, exact)
    return np.inf if norm is None else norm.L1


def _given_notes(conventions: Conventions) -> Iterator[str]:
    """What was asked for, to be said first."""
    if conventions.scale:
        sizes = ", ".join(f"{name} times {size:.6g}" for name, size in conventions.scale.items())
        yield f"units, as given: {sizes}"
    for name in ("sign", "slip", "pressure"):
        if getattr(conventions, name) is not None:
            yield f"{name}, as given: {getattr(conventions, name)}"
    if conventions.time_shift:
        yield f"times, as given: {conventions.time_shift:.6g} added"
