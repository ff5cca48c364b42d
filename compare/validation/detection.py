"""The reading of a file: one for all of its numbers.

Numbers are in the units that the file or conventions name, else in those of the scene.  Conventions
that neither says are taken as given where that leaves less than `LITTLE` of every quantity
unexplained.  Elsewhere all of them are tried on all quantities together; one is inferred, and said,
where it alone leaves less than `LITTLE`, and the records make sense by themselves
(`checks.nonsense`).  No quantity is mended by itself.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from compare.records.record import AFTER, BEFORE, QUANTITIES, Record, Records
from compare.validation.checks import nonsense
from compare.validation.conventions import Conventions
from compare.validation.exact import POINT, Array, Exact, Sampling, exact_answer
from compare.validation.norms import quantity_norm, weights
from compare.validation.readings import (
    MOTION,
    TRACTIONS,
    Choice,
    Reading,
    base_of,
    chosen_reading,
    given_reading,
)
from semianalytic import Scene
from semianalytic.scene.errors import DataFileError

LITTLE = 0.25
"""Relative error of a quantity above which a reading does not explain it.

Right runs of UGUCA and SEM2DPACK on 40 to 200 cells leave up to 0.16, and one half, another sense
or a base that is left out leaves 0.47 at least."""
CLOSE = 5.0
"""Ratio of what two readings leave, below which either may be meant: the next one leaves 20 times
as much in the trial (docs/validate.md)."""
TELLING = 1e-5
"""Mean of a quantity over its unit below which it says nothing of conventions."""
SHARP = 0.02
"""Error of slip rates above which means over steps are not told from values at their times."""
CLEARLY = 5.0
"""Factor by which they have to be nearer to a mean: the exact record on 41 steps is 9 times, and
noise of 1 % makes no difference between them."""
LOOKED_AT = 6
"""Number of stations on which readings are tried."""
SAMPLES = 300
"""Samples of a record that are enough to tell readings apart."""
SHIFTS = 41
FEW = 60
"""Samples of a record, enough for the time origin."""
FITS = 1e-5
"""Relative error of slip rates that have no better time origin: one that is 1e-5 T off, to which
the search is exact, leaves 2e-5 on the scene `preloaded`.  No run on a grid comes near it."""
LARGEST_SHIFT = 0.2
"""Largest shift of the time origin that is tried, over T."""


@dataclass(frozen=True, eq=False)
class Detection:
    """The exact answer, how a run is to be read, and what has to be said of that.

    Attributes
    ----------
    exact : Exact
    reading : Reading
    inferred : tuple of str
        What neither the file nor conventions say, in words; none if all is as given.
    stating : Conventions
        What would state it.
    left, as_given : float
        Largest relative error of a quantity that the reading leaves, and the one as given; nan
        where nothing was compared.
    notes : tuple of str
    """

    exact: Exact
    reading: Reading
    inferred: tuple[str, ...] = ()
    stating: Conventions = field(default_factory=Conventions)
    left: float = np.nan
    as_given: float = np.nan
    notes: tuple[str, ...] = ()


def detect(run: Records, scene: Scene, conventions: Conventions) -> Detection:
    """How a run is to be read; what is stated is obeyed, whatever is inferred is said.

    Raises
    ------
    DataFileError
        If no station lies where anything happens.
    SceneError
        If a scale is given for a column whose unit the file names.
    """
    given = given_reading(conventions, run.stated, scene)
    read = given.apply(run)
    end = last_time(read)
    exact = exact_answer(scene, end, _reach(read, scene, end))
    sample = replace(run, stations=tuple(map(_thinned, _some(run.stations))))
    found = _explained(sample, exact, given, conventions)
    found = replace(found, notes=(*_given_notes(conventions), *found.notes))
    if conventions.rate is None and not run.stated.mean:
        found = _with_means(found, replace(run, stations=_some(run.stations)))
    return replace(found, notes=(*found.notes, *_shift(found.reading.apply(sample), exact)))


class _Residuals:
    """Errors that readings leave of each quantity at the places and times of one of them."""

    def __init__(self, sample: Records, exact: Exact, reading: Reading) -> None:
        self.exact = exact
        self._columns: dict[str, tuple[Array, Array, Array]] = {}
        for name in QUANTITIES:
            parts = list(self._parts(sample, name, reading))
            if parts:
                values, weight, expected = map(np.concatenate, zip(*parts, strict=True))
                self._columns[name] = values, weight, expected

    def _parts(
        self, sample: Records, name: str, reading: Reading
    ) -> Iterator[tuple[Array, Array, Array]]:
        """Numbers of the file, weights and exact values at each station that waves may reach."""
        for record in sample.stations:
            values = record.values.get(name)
            x, t = reading.place(record), reading.times(record)
            if values is None or x > self.exact.scene.material.longitudinal_speed * t[-1]:
                continue
            weight = weights(t, values)
            if weight.any():
                expected = self.exact.record(name, x, t)
                yield np.where(weight > 0, values, 0.0), weight, expected

    def tells(self, name: str, base: float = 0.0) -> bool:
        """Whether the answer has something to say of a quantity, besides its base."""
        if name not in self._columns:
            return False
        _, weight, expected = self._columns[name]
        size = float(weight @ np.abs(expected - base))
        return size > TELLING * self.exact.unit(name) * float(weight.sum())

    def left(self, name: str, factor: float, base: float = 0.0) -> float:
        """Relative error of a quantity, of what the file would hold of it without a base.

        Where that is nothing, over the quantity with its base, or over its unit.
        """
        values, weight, expected = self._columns[name]
        wrong = float(weight @ np.abs(factor * values + base - expected))
        size = float(weight @ np.abs(expected - base))
        if not self.tells(name, base):
            unit = self.exact.unit(name) * float(weight.sum())
            size = max(float(weight @ np.abs(expected)), unit)
        return wrong / size

    def largest(self, reading: Reading) -> float:
        """Largest error that a reading leaves of a quantity."""
        parts = [self.left(name, *_read_by(reading, name)) for name in self._columns]
        return max(parts, default=np.inf)

    def admits(self, choice: Choice, reading: Reading) -> bool:
        """Whether the records may speak for a choice at all.

        Slip is whole where the answer does not slip.  Tractions are changes only if one that has a
        base changes, and does not begin with its base.
        """
        if choice.half and not any(self.tells(name) for name in MOTION):
            return False
        return not choice.changes or any(self._is_change(name, reading) for name in TRACTIONS)

    def _is_change(self, name: str, reading: Reading) -> bool:
        base, factor = base_of(self.exact.scene, name), reading.factor(name)
        if name not in self._columns or not base or not self.tells(name, base):
            return False
        return self.left(name, factor, base) < LITTLE < self.left(name, factor)

    def alike(self, one: Reading, other: Reading) -> bool:
        """Whether two readings are the same of all that the answer has something to say of."""
        told = [name for name in self._columns if self.tells(name, one.offset(name))]
        return all(_read_by(one, name) == _read_by(other, name) for name in told)

    def scale(self, name: str, reading: Reading) -> float | None:
        """Return the factor that would explain a quantity which a reading does not."""
        values, weight, expected = self._columns[name]
        factor, base = _read_by(reading, name)
        square = float(weight @ np.square(values))
        if not square or self.left(name, factor, base) < LITTLE:
            return None
        size = float(weight @ (values * (expected - base))) / square
        return size if self.left(name, size, base) < LITTLE else None

    def hints(self, reading: Reading, settled: Sequence[str]) -> Iterator[str]:
        """Yield by what each quantity is off, with the option that would state it as its unit."""
        for name in self._columns:
            size = self.scale(name, reading)
            if size is not None and name not in settled:
                times = reading.factor(name) / size
                yield (
                    f"{name.replace('_', ' ')} is {times:.3g} times the exact one; if it is in "
                    f"another unit, give scale {name}={size:.6g}"
                )


def _read_by(reading: Reading, name: str) -> tuple[float, float]:
    return reading.factor(name), reading.offset(name)


def _explained(
    sample: Records, exact: Exact, given: Reading, conventions: Conventions
) -> Detection:
    """The reading as given if it explains all quantities, else the only one that does."""
    residuals = _Residuals(sample, exact, given)
    as_given = residuals.largest(given)
    found = Detection(exact, given, left=as_given, as_given=as_given)
    if as_given < LITTLE or np.isinf(as_given):
        return found
    fitting: list[tuple[float, Choice, Reading]] = []
    for choice in _choices(sample, conventions):
        reading = chosen_reading(choice, given, sample.stated, exact.scene)
        left = residuals.largest(reading)
        fits = left < LITTLE and residuals.admits(choice, reading)
        if fits and not any(residuals.alike(reading, other) for _, _, other in fitting):
            fitting.append((left, choice, reading))
    if not fitting:
        return replace(found, notes=tuple(residuals.hints(given, tuple(sample.stated.units))))
    fitting.sort(key=lambda one: one[0])
    (left, choice, reading), *others = fitting
    names = tuple(name for name in QUANTITIES if any(name in r.values for r in sample.stations))
    words = choice.words(names)
    if others and others[0][0] < CLOSE * max(left, np.finfo(float).eps):
        both = f"{words}, or {others[0][1].words(names)}"
        return replace(
            found, notes=(f"conventions: as given; two readings fit, {both}: give one of them",)
        )
    if wrong := nonsense(reading.apply(sample), exact.scene):
        return replace(found, notes=(f"conventions: as given; with {words} {wrong[0]}",))
    return Detection(exact, reading, (words,), choice.stating, left, as_given)


def _choices(sample: Records, said: Conventions) -> Iterator[Choice]:
    """All choices among what neither the file nor conventions settle, the plainest first."""
    stated, names = sample.stated, {name for one in sample.stations for name in one.values}
    free = (
        said.slip is None and not stated.faces and bool(names & set(MOTION)),
        said.sign is None,
        said.pressure is None and "pressure" in names,
        said.tractions is None and not stated.changes and bool(names & set(TRACTIONS)),
    )
    flags = itertools.product(*((False, True) if one else (False,) for one in free))
    yield from (Choice(*one) for one in sorted(flags, key=sum) if any(one))


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


def _thinned(record: Record, most: int = SAMPLES) -> Record:
    every = max(len(record.t) // most, 1)
    values = {name: column[::every] for name, column in record.values.items()}
    return Record(record.x, record.t[::every], values)


def _with_means(found: Detection, run: Records) -> Detection:
    """Whether slip rates are means over steps, where nothing says so."""
    read, exact = found.reading.apply(run), found.exact
    kinds = {kind: Sampling(kind) for kind in (POINT, BEFORE, AFTER)}
    norms = {kind: quantity_norm(read, "slip_rate", exact, one) for kind, one in kinds.items()}
    errors = {kind: norm.L1 for kind, norm in norms.items() if norm is not None and norm.exact > 0}
    if not errors:
        return found
    best = min(errors, key=errors.__getitem__)
    if best == POINT or errors[best] > min(SHARP, errors[POINT] / CLEARLY):
        return found
    words = f"slip rate: the mean over the step {best} its time"
    return replace(
        found,
        reading=replace(found.reading, sampling=kinds[best]),
        inferred=(*found.inferred, words),
        stating=replace(found.stating, rate=best),
    )


def _shift(run: Records, exact: Exact) -> tuple[str, ...]:
    """Report a time origin that is not that of the load, without correcting it."""
    name = next(
        (name for name in MOTION if any(name in record.values for record in run.stations)), None
    )
    if name is None or (norm := quantity_norm(run, name, exact)) is None:
        return ()
    if norm.exact == 0 or norm.L1 < FITS:
        return ()
    few = replace(run, stations=tuple(_thinned(record, FEW) for record in run.stations))
    end = exact.end_time

    def error(part: float) -> float:
        return _shifted_error(few, exact, name, part * end)

    parts = np.linspace(-LARGEST_SHIFT, LARGEST_SHIFT, SHIFTS)
    for record in few.stations:
        if name in record.values:
            exact.know(name, record.x, record.t + parts[:, None] * end)
    nearest = float(parts[np.argmin([error(float(part)) for part in parts])])
    room = 2 * LARGEST_SHIFT / (SHIFTS - 1)
    # Over parts of T, as the tolerance of the search is a number without a unit.
    best = scipy.optimize.minimize_scalar(
        error, bounds=(nearest - room, nearest + room), method="bounded"
    )
    if best.fun > min(LITTLE, norm.L1 / CLEARLY):
        return ()
    shift = f"{best.x * end:.3g}"
    return (
        f"times: the records fit best if {shift} is added to them; they are left as they are "
        f"(time_shift {shift} would move them)",
    )


def _shifted_error(run: Records, exact: Exact, name: str, shift: float) -> float:
    moved = replace(
        run, stations=tuple(replace(record, t=record.t + shift) for record in run.stations)
    )
    norm = quantity_norm(moved, name, exact)
    return np.inf if norm is None else norm.L1


def _given_notes(conventions: Conventions) -> Iterator[str]:
    """Yield notes on the conventions that the user gave, which come first in the report."""
    if conventions.scale:
        sizes = ", ".join(f"{name} times {size:.6g}" for name, size in conventions.scale.items())
        yield f"units, as given: {sizes}"
    for name in ("sign", "slip", "pressure", "tractions", "rate"):
        if getattr(conventions, name) is not None:
            yield f"{name}, as given: {getattr(conventions, name)}"
    if conventions.time_shift:
        yield f"times, as given: {conventions.time_shift:.6g} added"
