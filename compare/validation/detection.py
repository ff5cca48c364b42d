"""The reading of a file: one for all of its numbers, weighed against others.

Numbers are read as the file and the conventions say; what neither says is taken as given where that
leaves less than `LITTLE` of every quantity unexplained.  Elsewhere all systems of units and
conventions are tried on all quantities together: the one that leaves least is inferred, if that is
less than `LITTLE`, if no other one does nearly as well, and if the records make sense by
themselves (`checks.nonsense`).  Factors of readings are at least `systems.APART` from one another,
so that no answer that is off by some per cent is mended.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import scipy

from compare.records.record import AFTER, BEFORE, QUANTITIES, Record, Records
from compare.validation.checks import nonsense
from compare.validation.conventions import Conventions
from compare.validation.exact import POINT, Exact, Sampling, exact_answer
from compare.validation.norms import quantity_norm
from compare.validation.readings import MOTION, Reading, given_reading, stated_by
from compare.validation.weighing import LITTLE, Left, Ranking, Residuals, Weighed, differ
from semianalytic import Scene
from semianalytic.scene.errors import DataFileError, SceneError, TensionError

CLOSE = 2.0
"""Ratio of what two readings leave, below which the better one is doubtful: 1.1 and 4
leave the trial (docs/validate.md) as it is, in which the next one leaves 20 times as much."""
SHARP = 0.02
"""Error of slip rates above which means over steps are not told from values at their times."""
CLEARLY = 5.0
"""Factor by which they have to be nearer to a mean: the exact record on 41 steps is 9 times, and
noise of 1 % makes no difference between them."""
MOST_UNEXPLAINED = 0.5
"""Part of the quantities that may stay unexplained for units to be inferred from the others."""
NOTHING_LEFT = Left(np.inf, len(QUANTITIES) + 1, np.inf)
"""Stands for what is left of records that cannot be compared at all as they are given."""
ANY_SCALE = (
    "units: this scene has no length or time of its own, so that positions, times and slip all "
    "multiplied by one number fit as well"
)
LOOKED_AT = 6
"""Number of stations on which readings are tried."""
SAMPLES = 300
"""Samples of a record that are enough to tell readings apart."""
SHIFTS = 41
FEW = 60
"""Samples of a record, enough for the time origin."""
FITS = 1e-5
"""Relative error of slip rates that have no better time origin: one that is 1e-5 T off, to which
the search is exact, leaves 2e-5 on the scene `preloaded`.  No run on a grid comes near it, so that
half and twice of it change nothing."""
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
        where nothing was weighed.
    runner_up : str
        The next best reading and what it leaves, in words; "" where none was weighed.
    notes : tuple of str
    """

    exact: Exact
    reading: Reading
    inferred: tuple[str, ...] = ()
    stating: Conventions = field(default_factory=Conventions)
    left: float = np.nan
    as_given: float = np.nan
    runner_up: str = ""
    notes: tuple[str, ...] = ()


def detect(run: Records, scene: Scene, conventions: Conventions) -> Detection:
    """How a run is to be read; what is told is obeyed, whatever else is inferred is said.

    Raises
    ------
    DataFileError
        If no station lies where anything happens.
    SceneError
        If a scale is given for a column whose unit the file names.
    """
    given = given_reading(conventions, run.stated, scene)
    sample = replace(run, stations=tuple(map(_thinned, _some(run.stations))))
    found = _weighed(sample, run, scene, given, conventions)
    exact, end = found.exact, last_time(found.reading.apply(run))
    if end != exact.end_time:  # else the records that it has computed stay known
        exact = replace(exact, end_time=end)
    found = replace(found, exact=exact, notes=(*_given_notes(conventions), *found.notes))
    if conventions.rate is None and not run.stated.mean:
        found = _with_means(found, replace(run, stations=_some(run.stations)))
    return replace(found, notes=(*found.notes, *_shift(found.reading.apply(sample), exact)))


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


def _answer(scene: Scene, read: Records) -> Exact:
    """The answer for a run in units of the scene."""
    end = last_time(read)
    return exact_answer(scene, end, _reach(read, scene, end))


def _weighed(
    sample: Records, run: Records, scene: Scene, given: Reading, conventions: Conventions
) -> Detection:
    """The reading that explains all quantities together, if the one as given does not."""
    names = tuple(name for name in QUANTITIES if any(name in r.values for r in sample.stations))
    ranking = Ranking(run, sample, scene, given, conventions, partial(_answer, scene))
    try:
        exact = _answer(scene, given.apply(run))
    except TensionError:
        raise
    except SceneError as refusal:  # a march in the units as given that does not follow the loads
        found = _inferred(ranking, names, NOTHING_LEFT) if names else ""
        if isinstance(found, str):
            raise SceneError(f"{refusal} {found}".strip()) from refusal
        return found
    if not names:
        return Detection(exact, given)
    left = Residuals(sample, exact, given).of(given)
    found = "" if left.largest < LITTLE else _inferred(ranking, names, left)
    if isinstance(found, str):
        notes = (found,) if found else ()
        return Detection(exact, given, left=left.largest, as_given=left.largest, notes=notes)
    return found


def _inferred(ranking: Ranking, names: tuple[str, ...], as_given: Left) -> Detection | str:
    """The reading that is inferred, or why none is; "" if none explains more than as given.

    Where none explains all quantities the units that explain most of them are taken, and the
    verdict is that they differ: which sense or half is meant cannot be told of what is wrong.
    """
    ranked = ranking.ranked()
    best = ranked[0] if ranked else None
    if best is not None and best.left.unexplained:
        ranked = [one for one in ranked if not one.choice.turns]
        best = ranked[0] if ranked else None
        if best is None or best.left.unexplained > MOST_UNEXPLAINED * len(names):
            return ""
    if best is None or best.left.unexplained >= max(as_given.unexplained, 1):
        return ""
    residuals = ranking.residuals(best.reading)
    assert residuals is not None
    words = best.choice.words(names)
    others = (one for one in ranked if differ(best.reading, one.reading, names, residuals))
    second = next(others, None)
    if second is not None and _is_close(second.left, best.left):
        both = f"{words}, or {second.choice.words(names) or 'as given'}"
        return f"units and conventions: as given; two readings fit, {both}: give one of them"
    wrong = (
        () if best.left.unexplained else nonsense(best.reading.apply(ranking.sample), ranking.scene)
    )
    if wrong:
        return f"units and conventions: as given; with {words} {wrong[0]}"
    system = best.choice.system
    scaled = system.words and {system.length, system.time, system.motion} != {1.0}
    return Detection(
        residuals.exact,
        best.reading,
        (words,),
        stated_by(best.choice, ranking.conventions, ranking.run.stated),
        best.left.largest,
        as_given.largest,
        "" if second is None else _left(second, names),
        (ANY_SCALE,) if scaled and ranking.scene.is_self_similar else (),
    )


def _is_close(second: Left, best: Left) -> bool:
    """Whether a reading explains as many quantities as the best, and about as well."""
    alike = second.unexplained == best.unexplained
    missed = LITTLE * best.unexplained
    return alike and second.together - missed < CLOSE * (best.together - missed)


def _left(weighed: Weighed, names: tuple[str, ...]) -> str:
    """A reading and what it leaves, in words."""
    words = weighed.choice.words(names) or "as given"
    return f"{words} (leaves {100 * weighed.left.largest:.2g} %)"


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
