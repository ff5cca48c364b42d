"""Records of another code compared with the exact answer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from compare.comparison.measures import NOTHING
from compare.comparison.rows import AGREES, DIFFERS, MOTION, HasRows, overall
from compare.records.arrays import of_history, records_of_arrays
from compare.records.record import BEFORE, QUANTITIES, ReadingOptions, Records
from compare.validation.bars import JudgedRow
from compare.validation.conventions import Conventions
from compare.validation.detection import Detection, detect
from compare.validation.exact import Exact, compared, farthest
from compare.validation.grids import Grids, arranged, profile_spacing
from compare.validation.norms import Norm, pooled
from compare.validation.readings import faces_are_mirrored
from compare.validation.rows import quantity_norms, rows
from semianalytic import Scene
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.arguments import checking
from semianalytic.scene.checks import SMALLEST, checked_number
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import any_scene
from semianalytic.scene.units import InSI

CONVERTED = "agrees after conversion"
"""The verdict where conventions had to be inferred."""
MOST_STATIONS = 101
"""Most stations that are judged; of more, as many are chosen evenly.  Half and twice as many leave
every verdict of the trial as it is."""
MOST_SAMPLES = 4000
"""Most samples of a record that are judged; of more, every second, third or later one."""
ONE_FACE = (
    "slip: that of one face, doubled; right by antisymmetry where bodies are identical and only "
    "shear acts"
)


@dataclass(frozen=True, eq=False, repr=False)
class Validation(HasRows[JudgedRow]):
    """Records against the exact answer, quantity by quantity.

    Attributes
    ----------
    scene : Scene
    detection : Detection
        The answer, until T, and how the numbers of the file were read.
    grids : Grids
        Records in units and conventions of the scene.
    notes : tuple of str
        Conventions that were given, and corrections: read them first.
    rows : tuple of JudgedRow
        With their verdicts.
    norms : tuple of Norm
        Norms of all stations together, then of each.
    """

    scene: Scene
    detection: Detection
    grids: Grids
    notes: tuple[str, ...]
    rows: tuple[JudgedRow, ...]
    norms: tuple[Norm, ...]

    def __repr__(self) -> str:
        return f"<Validation: {self.verdict} (rows {self.shown_counts})>"

    @property
    def exact(self) -> Exact:
        """The answer, until T."""
        return self.detection.exact

    @property
    def inferred(self) -> tuple[str, ...]:
        """Conventions that neither the file nor the caller has stated, in words."""
        return self.detection.inferred

    @cached_property
    def verdict(self) -> str:
        """ "differs" if one row does; else "agrees" if one of slip or slip rate does (where
        something slips, if anything does) or, where neither was recorded, any row; else
        "unresolved".

        "agrees after conversion" if that requires conventions which neither the file nor the
        caller has stated.
        """
        motion = [row for row in self.rows if row.kind in MOTION]
        # That nothing slips where nothing should is no sign that slip is right where it is.
        slips = [row for row in motion if (row.exact or 0.0) > NOTHING]
        telling = [row.verdict for row in slips or motion or self.rows]
        verdict = overall([*telling, *(row.verdict for row in self.having(DIFFERS))])
        return CONVERTED if self.inferred and verdict == AGREES else verdict

    @property
    def unread(self) -> tuple[str, ...]:
        """Columns, arrays or fields of the files that are not known."""
        return tuple(dict.fromkeys(name for run in self.grids.runs for name in run.unread))

    @property
    def not_compared(self) -> tuple[str, ...]:
        """Quantities that no file contains and the verdict does not cover."""
        there = {name for run in self.grids.runs for place in run.stations for name in place.values}
        return tuple(name for name in QUANTITIES if name not in there)

    @property
    def source(self) -> str:
        """The file or files of the records that are judged."""
        return self.grids.finest.source


@checking
def validate(
    data: Data | Sequence[Data],
    scene: Scene | str | PathLike[str],
    *,
    spacing: float | Sequence[float] | None = None,
    conventions: Conventions | None = None,
) -> Validation:
    """Compare what another code recorded on the interface with the answer of `solve`.

    Parameters
    ----------
    data : Records, InterfaceHistory, mapping of arrays, or a sequence of them
        One run, or one for each resolution, coarse to fine unless spacings say otherwise.  A
        mapping has "t", "x" and some of "slip_rate", "slip", "shear_traction" and "pressure".
    scene : Scene, str or path
        Scene that was simulated; a name or file as for `find`.
    spacing : float or sequence of float, optional
        Distance of the grid points of each run on the interface, in the unit of x of its file; 0
        for a gauge without any extent, whose noise is known.
    conventions : Conventions, optional
        Units and conventions that are known; units are else those of the scene.

    Returns
    -------
    Validation

    Raises
    ------
    DataFileError
        If there is nothing in the data that can be compared.
    SceneError
        If spacings do not fit, or a march cannot follow the scene.
    """
    scene = any_scene("validate", scene)
    conventions = conventions or Conventions()
    runs = [_with_rates(run, conventions) for run in as_runs(data)]
    last = detect(runs[-1], scene, conventions)
    # runs of one code are alike, unless their headers say otherwise
    found = [
        last if run.stated == runs[-1].stated else detect(run, scene, conventions) for run in runs
    ]
    reached = [
        _in_reach(kind.reading.apply(run), last) for kind, run in zip(found, runs, strict=True)
    ]
    sizes = _spacings(spacing, found, runs, conventions)
    noise = _noise(conventions, last, runs[-1])
    read = [run for run, _ in reached]
    grids, guessed = arranged(read, sizes, last.reading.sampling, noise)
    notes = [*last.notes, *(note for run in runs for note in run.notes)]
    face = False
    if conventions.slip == "face" or (
        conventions.slip is None and any(run.stated.faces for run in runs)
    ):
        notes.append(ONE_FACE)
        face = not faces_are_mirrored(scene)
    if face:
        notes.append("faces do not move alike here: rows of slip are not resolved")
    notes += [*(note for _, left in reached for note in left), *guessed]
    exact = last.exact
    return Validation(
        scene,
        last,
        grids,
        tuple(dict.fromkeys(notes)),
        tuple(rows(grids, exact, conventions.threshold, face=face)),
        tuple(_norms(grids, exact)),
    )


def _norms(grids: Grids, exact: Exact) -> Iterator[Norm]:
    for name in QUANTITIES:
        known = [norm for _, norm in quantity_norms(grids, exact, name)]
        if known:
            yield pooled(known)
            yield from known


def _noise(conventions: Conventions, detection: Detection, run: Records) -> Mapping[str, float]:
    """Standard deviations of samples in units of the scene."""
    return {
        # one with a unit is in that of the scene, whatever the file is in
        name: noise
        if isinstance(noise, InSI)
        else noise * run.stated.size(name) * abs(detection.reading.factor(name))
        for name, noise in conventions.noise.items()
    }


def _spacings(
    spacing: float | Sequence[float] | None,
    found: Sequence[Detection],
    runs: Sequence[Records],
    conventions: Conventions,
) -> list[float | None]:
    """Spacings in units of the scene."""
    if spacing is None:
        return [None] * len(runs)
    given = list(spacing) if isinstance(spacing, Iterable) else [spacing]
    if len(given) != len(runs):
        raise SceneError(
            f"validate: there are {len(runs)} runs and {len(given)} spacings; give one for each."
        )
    least = 0.0 if conventions.noise else SMALLEST
    required = "be a number from 0" if least == 0 else "be positive, or 0 where noise is given"
    sizes = [
        checked_number("validate: spacing", size, required, lambda value: value >= least)
        for size in given
    ]
    return [
        size
        if isinstance(as_given, InSI)
        else size * run.stated.size("x") * detection.reading.factor("x")
        for as_given, size, detection, run in zip(given, sizes, found, runs, strict=True)
    ]


def _with_rates(run: Records, conventions: Conventions) -> Records:
    """Slip rates made of slip, where that is asked for."""
    lacks = any("slip" in r.values and "slip_rate" not in r.values for r in run.stations)
    if not (conventions.rate_from_slip and lacks):
        return run
    stations = list(run.stations)
    for place, record in enumerate(stations):
        if "slip" in record.values and "slip_rate" not in record.values and len(record.t) > 1:
            rate = np.append(np.nan, np.diff(record.values["slip"]) / np.diff(record.t))
            stations[place] = replace(record, values={**record.values, "slip_rate": rate})
    note = "slip rate: made of differences of slip, so that it is the mean over each step"
    stated = replace(run.stated, mean=BEFORE, step=None)
    return replace(run, stations=tuple(stations), notes=(*run.notes, note), stated=stated)


def _in_reach(run: Records, detection: Detection) -> tuple[Records, tuple[str, ...]]:
    """A run without stations off the contact, or that no wave has reached by the end."""
    exact = detection.exact
    far = farthest(exact.scene, exact.end_time)
    kept = tuple(
        r for r in run.stations if len(r.t) and compared(exact.scene, [r.x], exact.end_time)[0]
    )
    if not kept and run.arrivals is None:
        places = [record.x for record in run.stations]
        begin = max(exact.scene.contact.intervals[0][0], -far)
        raise DataFileError(
            f"{run.source or 'validate'}: no station lies on the contact where waves arrive until "
            f"t = {exact.end_time:.4g} (positions {min(places, default=0):.4g} to "
            f"{max(places, default=0):.4g}, of {begin:.4g} to {far:.4g}); give the "
            "unit of positions or of times (scale)."
        )
    dropped = len(run.stations) - len(kept)
    notes = []
    if dropped:
        notes.append(f"{dropped} stations off the contact or beyond all waves are left out")
    if len(kept) > MOST_STATIONS:
        evenly = np.linspace(0, len(kept) - 1, MOST_STATIONS).round().astype(int)
        notes.append(f"{MOST_STATIONS} of {len(kept)} stations are judged, evenly chosen")
        spacing = run.spacing if run.spacing is not None else profile_spacing(run)
        run, kept = replace(run, spacing=spacing), tuple(kept[place] for place in evenly)
    if run.points:
        notes.append(f"{len(run.points)} records of points inside the bodies are not compared")
    if any(len(record.t) > MOST_SAMPLES for record in kept):
        notes.append(f"of stations of more than {MOST_SAMPLES} times evenly chosen ones are judged")
    fewer = (record.taken(slice(None, None, -(-len(record.t) // MOST_SAMPLES))) for record in kept)
    return replace(run, stations=tuple(fewer)), tuple(notes)


Data = Records | InterfaceHistory | Mapping[str, Any]
"""One run."""
LEAST_TIMES = 2
"""Least number of times that a station needs to be compared."""


def as_runs(data: Data | Sequence[Data]) -> list[Records]:
    """Records of one or several runs, in the order given.

    A mapping holds arrays "t", "x" and some of `QUANTITIES`: all of one length, a row for each
    sample, or t (m,), x (n,) or a number, and values (m, n) or (m,).  A DataFileError
    refuses no records, records of fewer than two times, and arrays that do not fit each other.
    """
    runs = [_run(run) for run in (data if isinstance(data, Sequence) else [data])]
    if not runs:
        raise DataFileError("validate: there are no records; give at least one run.")
    for run in runs:
        if run.points and not run.stations:
            raise DataFileError(
                f"{run.source} holds points inside the bodies alone, which slipfront fit takes; "
                "give records of the interface."
            )
    for record in (place for run in runs for place in run.stations if len(place.t) < LEAST_TIMES):
        raise DataFileError(
            f"validate: the record at x = {record.x:g} has {len(record.t)} times; it takes "
            f"{LEAST_TIMES} at least."
        )
    return runs


def _run(data: object) -> Records:
    if isinstance(data, Records):
        return data
    if isinstance(data, InterfaceHistory):
        return of_history(Path("interface history"), data)
    if not isinstance(data, Mapping):
        raise DataFileError(
            "validate: records must be Records, an InterfaceHistory or a mapping of arrays, got "
            f"{type(data).__name__}."
        )
    arrays = {str(name): np.asarray(values) for name, values in data.items()}
    return records_of_arrays(Path("arrays"), arrays, ReadingOptions())
