"""How the numbers of a file are read.

Units are those that the file or the conventions state, else those of the scene.  Conventions that
neither states are as given where that leaves less than `LITTLE` of every quantity unexplained.
Elsewhere another sense, half of the slip and changes of tractions are weighed on all quantities
together, and are taken if exactly one combination explains them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from compare.records.record import AFTER, BEFORE, QUANTITIES, Records
from compare.validation.conventions import WORDS, Conventions
from compare.validation.exact import (
    POINT,
    Exact,
    Sampling,
    compared,
    exact_answer,
    farthest,
)
from compare.validation.norms import pooled, station_norm, weights
from compare.validation.readings import (
    TRACTIONS,
    TURNS,
    Conversion,
    base_of,
    given_reading,
    turn_words,
)
from semianalytic import Scene
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError

LITTLE = 0.25
"""Relative error of a quantity above which a reading does not explain it.

Right runs of UGUCA and SEM2DPACK on 40 to 200 cells leave up to 0.16, and readings differ by a
sense or a factor of two, so that a wrong one leaves 0.47 at least.  With half of it coarse runs are
not read; with twice of it a factor of two passes."""
TELLING = 1e-5
"""Mean of a quantity over its unit below which the answer says nothing of its sense or size."""
SHARP, CLEARLY = 0.02, 5.0
"""Error of slip rates above which means over steps are not distinguished from values, and the
factor by which they have to be nearer to a mean: the exact record on 41 steps is 9 times, and noise
of 1 % makes no difference between them."""
FAR_OFF = 1.9
"""Factor by which a quantity has to be off for another unit to be mentioned as a cause."""
NEAREST = 0.01
"""Least position of the outermost station, over c_l T, at which no unit is mentioned."""
LOOKED_AT, SAMPLES = 6, 300
"""Stations, and samples of each, on which conventions are weighed."""


@dataclass(frozen=True, eq=False)
class Detection:
    """The exact answer, how a run is to be read, and what has to be said of that."""

    exact: Exact
    reading: Conversion
    # conventions that neither the file nor the caller states, as `Conventions` takes them; none if
    # all is as given
    stating: Mapping[str, str] = field(default_factory=dict)
    inferred: tuple[str, ...] = ()  # the same in words
    # largest relative error of a quantity that the reading leaves, and the one as given; nan where
    # nothing was weighed
    left: float = np.nan
    as_given: float = np.nan
    notes: tuple[str, ...] = ()


def detect(run: Records, scene: Scene, conventions: Conventions) -> Detection:
    """How a run is to be read; what is stated holds, and what is inferred is said."""
    given = given_reading(conventions, run.stated, scene)
    read = given.apply(run)
    right = [record for record in run.stations if scene.contact.touches([given.place(record)])[0]]
    some = np.unique(np.linspace(0, len(right) - 1, LOOKED_AT).round().astype(int))
    looked_at = replace(run, stations=tuple(right[place] for place in some if right))
    end = last_time(read)
    exact = exact_answer(scene, end, _reach(read, scene, end))
    found = _weighed(looked_at, Detection(exact, given), conventions)
    found = replace(found, notes=(*_given_notes(conventions), *found.notes))
    if conventions.rate is None and not run.stated.mean:
        found = _with_means(found, looked_at)
    return found


def last_time(run: Records) -> float:
    """When the last record ends [time]; DataFileError if that is not after t = 0."""
    ends = [float(record.t[-1]) for record in run.stations if len(record.t)]
    if run.arrivals is not None:
        ends += [float(time) for time in run.arrivals[1] if np.isfinite(time)]
    end = max(ends, default=0.0)
    if end <= 0:
        raise DataFileError(
            f"{run.source or 'validate'}: nothing was recorded after t = 0, when the load acts; "
            "shift the times (time_shift)."
        )
    return end


def _reach(run: Records, scene: Scene, end: float) -> float:
    """The farthest position that is compared [length]."""
    places = np.array([record.x for record in run.stations])
    if run.arrivals is not None:
        places = np.append(places, run.arrivals[0])
    there = np.abs(places[compared(scene, places, end)])
    return float(there.max() if len(there) else 0.1 * farthest(scene, end))


@dataclass(frozen=True, eq=False)
class WeighedColumn:
    """One quantity at all stations that waves reach, in order."""

    # (n,) arrays: numbers of the file, zero in gaps; weights of samples, zero in gaps; exact
    # values, and what they are before any wave
    values: Array
    weight: Array
    expected: Array
    base: Array
    unit: float  # that of the quantity, as in `Exact.unit`

    def tells(self, based: bool = False) -> bool:
        """Whether the answer has something to say of the quantity, or besides its base."""
        return self.size(based) > TELLING * self.unit * float(self.weight.sum())

    def read(self, reading: Conversion, name: str) -> Array:
        """The numbers in units and conventions of the scene."""
        base = self.base if name in reading.bases else 0.0
        return reading.factor(name) * self.values + base

    def left(self, reading: Conversion, name: str) -> float:
        """Relative error of the numbers as they are read, of what changes from the base.

        Where nothing does, over the quantity with its base, or over its unit.
        """
        based = name in reading.bases
        size = self.size(based)
        if not self.tells(based):
            size = max(self.size(), self.unit * float(self.weight.sum()))
        return float(self.weight @ np.abs(self.read(reading, name) - self.expected)) / size

    def size(self, based: bool = False) -> float:
        """Integral of the exact |quantity|, or of that less its base."""
        return float(self.weight @ np.abs(self.expected - (self.base if based else 0.0)))


Columns = Mapping[str, WeighedColumn]


def _columns_of(run: Records, exact: Exact, reading: Conversion) -> Columns:
    """The quantities of a file, whose positions and times are read by a reading."""
    scene, columns = exact.scene, {}
    records = [row.taken(slice(None, None, max(len(row.t) // SAMPLES, 1))) for row in run.stations]
    for name in QUANTITIES:
        parts = []
        for record in (candidate for candidate in records if name in candidate.values):
            x, t, values = reading.place(record), reading.times(record), record.values[name]
            weight = weights(t, values)
            if compared(scene, [x], t[-1])[0] and weight.any():
                known = np.where(weight > 0, values, 0.0)
                base = np.full(len(t), base_of(scene, name, x))
                parts.append((known, weight, exact.record(name, x, t), base))
        if parts:
            values, weight, expected, base = map(np.concatenate, zip(*parts, strict=True))
            columns[name] = WeighedColumn(values, weight, expected, base, exact.unit(name))
    return columns


def _left_by(reading: Conversion, columns: Columns) -> dict[str, float]:
    return {name: column.left(reading, name) for name, column in columns.items()}


def _weighed(run: Records, given: Detection, conventions: Conventions) -> Detection:
    """The conventions that alone explain all quantities, if those as given do not."""
    scene, columns = given.exact.scene, _columns_of(run, given.exact, given.reading)
    as_given = _left_by(given.reading, columns)
    if not columns:
        return given
    largest = max(as_given.values())
    found = replace(given, left=largest, as_given=largest)
    if largest < LITTLE:
        return found
    fitting: list[tuple[dict[str, Any], Conversion]] = []
    for words in _combinations(run, conventions):
        reading = given_reading(replace(conventions, **words), run.stated, scene)
        known = any(_alike(reading, other, columns) for _, other in fitting)
        if not known and _explains(reading, words, columns):
            fitting.append((words, reading))
    if not fitting:
        return replace(found, notes=tuple(_hint(given, as_given, columns, run)))
    said = [tuple(turn_words(words, columns)) for words, _ in fitting]
    if len(fitting) > 1:
        both = ", or ".join(map("; ".join, said))
        note = f"conventions: as given; several fit, {both}: state one of them"
        return replace(found, notes=(note,))
    ((words, reading),) = fitting
    left = max(_left_by(reading, columns).values())
    return replace(found, reading=reading, stating=words, inferred=said[0], left=left)


def _combinations(run: Records, conventions: Conventions) -> Iterator[dict[str, Any]]:
    """Conventions that neither the file nor the caller rules out; those with fewest turns first."""
    stated = run.stated
    by_file = {"slip": bool(stated.faces), "tractions": bool(stated.changes)}
    free = [n for n in TURNS if getattr(conventions, n) is None and not by_file.get(n, False)]
    for count in range(1, len(free) + 1):
        for names in itertools.combinations(free, count):
            yield {name: WORDS[name][1] for name in names}


def _explains(reading: Conversion, words: Mapping[str, str], columns: Columns) -> bool:
    """Whether a reading leaves little of every quantity.

    Tractions are changes only if one with a base changes, and its numbers alone do not explain it.
    """
    if max(_left_by(reading, columns).values()) >= LITTLE:
        return False
    bare = replace(reading, bases={})
    return "tractions" not in words or any(
        columns[name].tells(based=True) and columns[name].left(bare, name) > LITTLE
        for name in TRACTIONS
        if name in columns and columns[name].base.any()
    )


def _alike(reading: Conversion, other: Conversion, columns: Columns) -> bool:
    """Whether two readings are the same in all that the answer has something to say of."""
    return all(
        (
            reading.factor(name) == other.factor(name)
            and ((name in reading.bases) == (name in other.bases) or not column.base.any())
        )
        or not column.tells(name in other.bases)
        for name, column in columns.items()
    )


def _hint(
    given: Detection, as_given: Mapping[str, float], columns: Columns, run: Records
) -> Iterator[str]:
    """One sentence on positions, times or quantities that are off by a factor, if any are."""
    reading, exact = given.reading, given.exact
    places = (abs(reading.place(station)) for station in run.stations)
    nearness = max(places, default=0.0) / farthest(exact.scene, exact.end_time)
    if 0 < nearness < NEAREST:
        yield (
            f"the outermost station lies at {nearness:.2g} of the distance that waves travel until "
            "the last time; if positions or times are in another unit, state it (scale x=, t=)"
        )
        return
    ratios = {
        name: float(column.weight @ np.abs(column.read(reading, name))) / column.size()
        for name, column in columns.items()
        if as_given[name] >= LITTLE and column.tells()
    }
    off = {n: r for n, r in ratios.items() if r > FAR_OFF or 0 < r < 1 / FAR_OFF}
    if off:
        sizes = ", ".join(f"{name.replace('_', ' ')} {ratio:.3g}" for name, ratio in off.items())
        scales = ", ".join(f"{name}={1 / ratio:.3g}" for name, ratio in off.items())
        yield (
            f"size over that of the exact answer: {sizes}; if another unit is the cause, state it "
            f"(scale {scales})"
        )


def _with_means(found: Detection, run: Records) -> Detection:
    """Whether slip rates are means over steps, where nothing says so."""
    read, exact = found.reading.apply(run), found.exact
    kinds = {kind: Sampling(kind) for kind in (POINT, BEFORE, AFTER)}
    errors = {}
    for kind, conversion in kinds.items():
        norms = [station_norm(record, "slip_rate", exact, conversion) for record in read.stations]
        known = [norm for norm in norms if norm is not None]
        if known and (norm := pooled(known)).exact > 0:
            errors[kind] = norm.L1
    if not errors:
        return found
    best = min(errors, key=errors.__getitem__)
    if best == POINT or errors[best] > min(SHARP, errors[POINT] / CLEARLY):
        return found
    return replace(
        found,
        reading=replace(found.reading, sampling=kinds[best]),
        stating={**found.stating, "rate": best},
        inferred=(*found.inferred, f"slip rate: the mean over the step {best} its time"),
    )


def _given_notes(conventions: Conventions) -> Iterator[str]:
    """Yield notes on the conventions that the user gave, which come first in the report."""
    if conventions.scale:
        sizes = ", ".join(f"{name} times {size:.6g}" for name, size in conventions.scale.items())
        yield f"units, as given: {sizes}"
    for name in WORDS:
        if getattr(conventions, name) is not None:
            yield f"{name}, as given: {getattr(conventions, name)}"
    if conventions.time_shift:
        yield f"times, as given: {conventions.time_shift:.6g} added"
