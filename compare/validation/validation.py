"""Records of another code held against the exact answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from compare.comparison.judgement import MOTION
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED, Row, overall
from compare.records.record import QUANTITIES, Record, Records
from compare.validation.conventions import Conventions
from compare.validation.data import Data, as_runs
from compare.validation.detection import Detection, detect
from compare.validation.exact import BEFORE, Exact
from compare.validation.grids import Grids, arranged
from compare.validation.norms import Norm, pooled
from compare.validation.rows import quantity_norms, rows
from semianalytic import Scene
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.scene import checked_scene


@dataclass(frozen=True, eq=False)
class Validation:
    """Records against the exact answer, quantity by quantity.

    Attributes
    ----------
    scene : Scene
    exact : Exact
        The answer, until T.
    grids : Grids
        What was recorded, read in units and conventions of the scene.
    notes : tuple of str
        Units and conventions, given or detected, and what was mended: read them first.
    rows : tuple of Row
        With their verdicts.
    norms : tuple of Norm
        Of all stations together, then of each.
    """

    scene: Scene
    exact: Exact
    grids: Grids
    notes: tuple[str, ...]
    rows: tuple[Row, ...]
    norms: tuple[Norm, ...]

    @cached_property
    def verdict(self) -> str:
        """ "differs" if one row does; else "agrees" if one does of slip or slip rate, of anything
        where neither was recorded; else "unresolved"."""
        moves = any(row.kind in MOTION for row in self.rows)
        telling = (
            row for row in self.rows if row.kind in MOTION or row.verdict == DIFFERS or not moves
        )
        return overall(row.verdict for row in telling)

    @property
    def counts(self) -> dict[str, int]:
        """How many rows have each verdict."""
        return {verdict: len(self.having(verdict)) for verdict in (AGREES, DIFFERS, UNRESOLVED)}

    def having(self, verdict: str) -> tuple[Row, ...]:
        """The rows with a verdict."""
        return tuple(row for row in self.rows if row.verdict == verdict)

    def remedy(self, row: Row) -> str:
        """Nothing: what would resolve a row is said with what stands in its way."""
        return ""

    @property
    def source(self) -> str:
        """Where the records that are judged come from."""
        return self.grids.finest.source


def validate(
    data: Data | Sequence[Data],
    scene: Scene,
    *,
    spacing: float | Sequence[float] | None = None,
    conventions: Conventions | None = None,
) -> Validation:
    """Hold what another code recorded on the interface against the exact answer.

    Parameters
    ----------
    data : Records, InterfaceHistory, mapping of arrays, or a sequence of them
        One run, or one for each resolution, coarse to fine unless spacings say otherwise.  A
        mapping has "t", "x" and some of "slip_rate", "slip", "shear_traction" and "pressure".
    scene : Scene
        What was simulated.
    spacing : float or sequence of float, optional
        Distance of the grid points of each run on the interface, in units of its file.
    conventions : Conventions, optional
        Units and conventions that are known; the others are detected, and said.

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
    checked_scene("validate", scene)
    conventions = conventions or Conventions()
    runs = [_with_rates(run, conventions) for run in as_runs(data)]
    detection = detect(runs[-1], scene, conventions)
    notes = [note for run in runs for note in run.notes]
    read, left_out = zip(
        *(_in_reach(detection.reading.apply(run), detection) for run in runs), strict=True
    )
    sizes = _spacings(spacing, len(runs), detection.reading.factors.get("x", 1.0))
    grids, guessed = arranged(read, sizes, _mean(detection, runs))
    exact = detection.exact
    face = conventions.slip == "face" and bool(scene.load.pressure)
    said = (*detection.notes, *_face_notes(conventions, face), *notes, *left_out[-1], *guessed)
    return Validation(
        scene,
        exact,
        grids,
        tuple(dict.fromkeys(said)),
        tuple(rows(grids, exact, conventions.threshold, face=face)),
        tuple(_norms(grids, exact)),
    )


def _norms(grids: Grids, exact: Exact) -> Iterator[Norm]:
    for name in QUANTITIES:
        known = [norm for _, norm in quantity_norms(grids, exact, name)]
        if known:
            yield pooled(known)
            yield from known


def _mean(detection: Detection, runs: Sequence[Records]) -> str:
    made = any("made of differences of slip" in note for run in runs for note in run.notes)
    return BEFORE if made else detection.reading.mean


def _spacings(
    spacing: float | Sequence[float] | None, runs: int, scale: float
) -> list[float | None]:
    if spacing is None:
        return [None] * runs
    given = [spacing] if isinstance(spacing, int | float) else list(spacing)
    if len(given) != runs:
        raise SceneError(
            f"validate: there are {runs} runs and {len(given)} spacings; give one for each."
        )
    return [scale * checked_size("validate: spacing", size) for size in given]


def _with_rates(run: Records, conventions: Conventions) -> Records:
    """Slip rates made of slip, where that is asked for."""
    lacks = any("slip" in r.values and "slip_rate" not in r.values for r in run.stations)
    if not (conventions.rate_from_slip and lacks):
        return run
    stations = tuple(_with_rate(record) for record in run.stations)
    note = "slip rate: made of differences of slip, so that it is the mean over each step"
    return replace(run, stations=stations, notes=(*run.notes, note))


def _with_rate(record: Record) -> Record:
    if "slip_rate" in record.values or len(record.t) < 2 or "slip" not in record.values:
        return record
    rate = np.append(np.nan, np.diff(record.values["slip"]) / np.diff(record.t))
    return replace(record, values={**record.values, "slip_rate": rate})


def _in_reach(run: Records, detection: Detection) -> tuple[Records, tuple[str, ...]]:
    """A run without stations off the contact, or that no wave has reached by the end."""
    exact = detection.exact
    farthest = exact.scene.material.longitudinal_speed * exact.end_time
    kept = tuple(r for r in run.stations if 0 < r.x <= farthest and len(r.t))
    if not kept and run.arrivals is None:
        places = [record.x for record in run.stations]
        raise DataFileError(
            f"{run.source or 'validate'}: no station lies on the contact where waves come until "
            f"t = {exact.end_time:.4g} (positions {min(places, default=0):.4g} to "
            f"{max(places, default=0):.4g}, of 0 to {farthest:.4g}); give the units of the file "
            "(scale)."
        )
    dropped = len(run.stations) - len(kept)
    notes = (f"{dropped} stations off the contact or beyond all waves are left out",)
    return replace(run, stations=kept), notes if dropped else ()


def _face_notes(conventions: Conventions, face: bool) -> Iterator[str]:
    if conventions.slip != "face":
        return
    yield (
        "slip: that of one face, doubled; right by antisymmetry where bodies are identical and "
        "only shear acts"
    )
    if face:
        yield "pressure acts here and moves both faces alike: rows of slip are not resolved"
