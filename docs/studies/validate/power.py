"""How often `validate` errs: ``python -m docs.studies.validate.power --csv docs/data``.

Our own finite elements and our marcher take the part of another code, on 50 and 100 cells over
c_t T, with one file of records at five stations, or two, and the spacing alone to go by.  Scenes
are random ones: the bars were set on those of one seed, and are tried on those of another.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from compare.comparison.rows import DIFFERS, UNRESOLVED
from compare.output.tables import write_rows
from compare.records.record import QUANTITIES
from compare.validation import bars, grids
from compare.validation import rows as judged_rows
from compare.validation.bars import JudgedRow
from compare.validation.rows import PLACES, rows
from compare.validation.validation import Validation, validate
from docs.studies.judge.scenes import HISTORIES, OPENINGS, STEPS, draw
from semianalytic import InterfaceHistory, Material, Scene, Solution, solve
from semianalytic.scene.errors import ComputationError, SceneError

Arrays = dict[str, Any]

CELLS = (50, 100)
USES: Mapping[str, int] = {"set": 101, "tried": 303}
"""Seeds of the scenes that bars were set on, and of those that they are tried on."""
COUNTS: Mapping[str, int] = {STEPS: 16, OPENINGS: 8, HISTORIES: 4}
"""Scenes of each kind."""
COMMAND = "python -m docs.studies.validate.power --csv docs/data"


@dataclass(frozen=True, eq=False)
class Recorded:
    """Records of a scene that one of our codes made.

    `data` has a run for each of `cells`.
    """

    use: str
    kind: str
    code: str
    scene: Scene
    cells: tuple[int, ...]
    data: tuple[Arrays, ...]

    def judged(self, scene: Scene | None = None, data: Sequence[Arrays] = ()) -> Validation:
        """Validation of the records with their scene, or of spoilt ones."""
        spacing = [1 / cells for cells in self.cells]
        return validate(list(data or self.data), scene or self.scene, spacing=spacing)


@dataclass(frozen=True)
class Alarms:
    """Verdicts on right records.

    `most` is the largest difference over its bar, of rows that are resolved; `rate_bar` and
    `slip_bar` are medians of the bars of slip rate and of slip at all stations.
    """

    use: str
    kind: str
    code: str
    cells: str
    runs: int
    rows: int
    differs: int
    unresolved: int
    most: float
    rate_bar: float
    slip_bar: float


@dataclass(frozen=True)
class Power:
    """How often a mistake is caught on 100 cells, in scenes that bars were not set on."""

    mistake: str
    scenes: int
    caught: int
    unresolved: int


@dataclass(frozen=True)
class Changed:
    """Counts of false alarms and of mistakes caught with another value of a constant.

    Of all right runs, and of mistakes on 100 cells; the first row has the constants as they are.
    """

    constant: str
    value: float
    runs: int
    alarms: int
    mistakes: int
    caught: int
    slip_bar: float


Spoil = Callable[[Arrays, Scene], tuple[Arrays, Scene] | None]
"""Records and the scene they are held against, spoilt; None where the mistake changes nothing."""


def history_arrays(history: InterfaceHistory, end_time: float) -> Arrays:
    """A history at `PLACES` until an end time [time], as a file of another code would hold it."""
    kept = history.t <= end_time * (1 + 1e-9)
    x = np.array(PLACES) * end_time
    values = {
        name: np.stack([np.interp(x, history.x, row) for row in getattr(history, name)[kept]])
        for name in QUANTITIES
    }
    return {"t": history.t[kept], "x": x, **values}


def _simulated(scene: Scene, cells: int) -> Arrays:
    from fem import simulate

    return history_arrays(simulate(scene, 1.0, resolution=cells).interface, 1.0)


def _marched(scene: Scene, cells: int) -> Arrays:
    marched = solve(
        scene,
        method="space-time",
        end_time=1.0,
        nodes=math.ceil(cells * scene.fastest_speed),
        companion=False,
    )
    t, x = marched.interface.t, np.array(PLACES)
    values = {name: getattr(marched, name)(x, t[:, None]) for name in QUANTITIES}
    return {"t": t, "x": x, **values}


CODES: Mapping[str, Callable[[Scene, int], Arrays]] = {"fem": _simulated, "march": _marched}


def records(use: str, share: float = 1.0) -> Iterator[Recorded]:
    """Records of a share of the scenes of a seed; those that a code refuses are left out."""
    for kind, count in COUNTS.items():
        for index in range(math.ceil(share * count)):
            scene = draw(kind, np.random.default_rng([USES[use], index])).scene
            for code, run in CODES.items():
                try:
                    data = tuple(run(scene, cells) for cells in CELLS)
                except (SceneError, ComputationError):
                    continue
                yield Recorded(use, kind, code, scene, CELLS, data)


def _friction(factor: float) -> Spoil:
    def spoil(data: Arrays, scene: Scene) -> tuple[Arrays, Scene] | None:
        return (data, replace(scene, friction=factor * scene.friction)) if scene.friction else None

    return spoil


def _poisson(change: float) -> Spoil:
    def spoil(data: Arrays, scene: Scene) -> tuple[Arrays, Scene]:
        solid = scene.material
        ratio = solid.poisson_ratio + change
        return data, replace(scene, material=Material(solid.shear_modulus, solid.density, ratio))

    return spoil


def _more_traction(data: Arrays, scene: Scene) -> tuple[Arrays, Scene]:
    return {**data, **{name: 1.1 * data[name] for name in ("shear_traction", "pressure")}}, scene


def _late(data: Arrays, scene: Scene) -> tuple[Arrays, Scene]:
    return {**data, "t": 1.02 * data["t"]}, scene


def _more_slip(data: Arrays, scene: Scene) -> tuple[Arrays, Scene] | None:
    if not np.any(data["slip"]):
        return None
    return {**data, **{name: 1.1 * data[name] for name in ("slip_rate", "slip")}}, scene


def _no_second_zone(data: Arrays, scene: Scene) -> tuple[Arrays, Scene] | None:
    """Slip ahead of the gap between two zones left out."""
    answer: Solution | None = solve(scene) if scene.is_self_similar else None
    if answer is None or len(answer.zones) < 2 or answer.zones[0].inner > 0:
        return None
    ahead = data["x"] > 0.5 * (answer.zones[0].outer + answer.zones[1].inner) * data["t"][:, None]
    return {**data, **{n: np.where(ahead, 0.0, data[n]) for n in ("slip_rate", "slip")}}, scene


SPOILS: Mapping[str, Spoil] = {
    "friction +3 %": _friction(1.03),
    "friction −3 %": _friction(0.97),
    "ν +0.01": _poisson(0.01),
    "ν −0.01": _poisson(-0.01),
    "tractions times 1.1": _more_traction,
    "slip times 1.1": _more_slip,
    "times times 1.02": _late,
    "no second zone": _no_second_zone,
}


def spoilt(one: Recorded) -> Iterator[tuple[str, Validation]]:
    """Validations of records of one resolution that are spoilt, with the names of the mistakes."""
    for mistake, spoil in SPOILS.items():
        try:
            changed = spoil(one.data[0], one.scene)
            if changed is not None:
                yield mistake, one.judged(changed[1], [changed[0]])
        except SceneError:  # the scene that it is held against is none
            continue


def _only(one: Recorded, place: int) -> Recorded:
    """Records of one resolution."""
    return replace(one, cells=one.cells[place : place + 1], data=one.data[place : place + 1])


def _ways(one: Recorded) -> Iterator[Recorded]:
    """A file for each resolution, and both files together."""
    yield from (_only(one, place) for place in range(len(one.cells)))
    yield one


@dataclass(frozen=True)
class Tried:
    """The verdict on one set of records; `mistake` is "" where they are right.

    `changed` has, for each of `VARIANTS`, whether a row differs and the bar of slip.
    """

    use: str
    kind: str
    code: str
    cells: str
    mistake: str
    verdict: str
    rows: tuple[JudgedRow, ...]
    changed: tuple[tuple[bool, float | None], ...]


def tried(one: Recorded, found: Validation, mistake: str = "") -> Tried:
    """A validation without its answer, which for a march takes much memory."""
    cells = " and ".join(map(str, one.cells))
    changed = tuple(_judged_anew(found, name, factor) for name, factor in VARIANTS)
    return Tried(one.use, one.kind, one.code, cells, mistake, found.verdict, found.rows, changed)


def all_tried(share: float) -> Iterator[Tried]:
    """Verdicts on the records of a share of all scenes, right and spoilt."""
    for use in USES:
        for one in records(use, share):
            try:
                right = [(way, way.judged()) for way in _ways(one)]
            except SceneError:  # there is no exact answer
                continue
            yield from (tried(way, found) for way, found in right)
            if one.code == "fem":
                fine = _only(one, len(one.cells) - 1)
                yield from (tried(fine, found, mistake) for mistake, found in spoilt(fine))


def alarms(trial: Sequence[Tried]) -> list[Alarms]:
    """False alarms by seed, kind, code and cells."""
    groups: dict[tuple[str, str, str, str], list[Tried]] = {}
    for one in trial:
        if not one.mistake:
            groups.setdefault((one.use, one.kind, one.code, one.cells), []).append(one)
    return [_alarms(key, found) for key, found in sorted(groups.items())]


def power(trial: Sequence[Tried]) -> list[Power]:
    """Mistakes that are caught in scenes that bars were not set on."""
    result = []
    for mistake in SPOILS:
        verdicts = [one.verdict for one in trial if (one.mistake, one.use) == (mistake, "tried")]
        caught, left = (verdicts.count(verdict) for verdict in (DIFFERS, UNRESOLVED))
        result.append(Power(mistake, len(verdicts), caught, left))
    return result


def changed(trial: Sequence[Tried]) -> list[Changed]:
    """Alarms and catches with half and twice of every constant of the bars."""
    result = []
    for place, (name, factor) in enumerate(VARIANTS):
        right = [one.changed[place] for one in trial if not one.mistake]
        wrong = [one.changed[place] for one in trial if one.mistake]
        slips = [bar for _, bar in right if bar is not None]
        result.append(
            Changed(
                name or "as they are",
                factor * _value(name) if name else factor,
                len(right),
                sum(differs for differs, _ in right),
                len(wrong),
                sum(differs for differs, _ in wrong),
                median(slips or [math.nan]),
            )
        )
    return result


def _judged_anew(found: Validation, name: str, factor: float) -> tuple[bool, float | None]:
    """Whether a row differs with a constant multiplied by a factor; the bar of slip then."""
    with _multiplied(name, factor):
        anew = list(rows(found.grids, found.exact, None, face=False))
        return any(row.verdict == DIFFERS for row in anew), _bar_of(anew, "slip all stations")


CONSTANTS: Mapping[str, tuple[Any, str]] = {
    **{f"SMEAR of {name.replace('_', ' ')}": (grids.SMEAR, name) for name in QUANTITIES},
    "BRIEF": (grids, "BRIEF"),
    "LONG": (grids, "LONG"),
    "CARRIED": (grids, "CARRIED"),
    "LEAST": (grids, "LEAST"),
    "GCI": (grids, "GCI"),
    "FEW_GRIDS": (grids, "FEW_GRIDS"),
    "UNSEEN": (grids, "UNSEEN"),
    "FLOOR": (grids, "FLOOR"),
    "TELLING": (judged_rows, "TELLING"),
    "ALARM": (bars, "ALARM"),
    "THRESHOLD": (judged_rows, "THRESHOLD"),
    "SLIDING": (judged_rows, "SLIDING"),
    "STRENGTH_FLOOR": (judged_rows, "STRENGTH_FLOOR"),
}
"""Constants of the bars by name: the module or mapping that holds each, and its name there."""


VARIANTS = (("", 1.0), *((name, factor) for name in CONSTANTS for factor in (0.5, 2.0)))
"""Constants by name and what each is multiplied by; first all as they are."""


def _value(name: str) -> float:
    holder, key = CONSTANTS[name]
    return float(holder[key] if isinstance(holder, dict) else getattr(holder, key))


@contextmanager
def _multiplied(name: str, factor: float) -> Iterator[None]:
    """A constant for a while another one."""
    if not name:
        yield
        return
    (holder, key), before = CONSTANTS[name], _value(name)
    put = holder.__setitem__ if isinstance(holder, dict) else partial(setattr, holder)
    put(key, before * factor)
    try:
        yield
    finally:
        put(key, before)


def _alarms(key: tuple[str, str, str, str], found: Sequence[Tried]) -> Alarms:
    whole = [row for one in found for row in one.rows]
    resolved = [row for row in whole if not row.obstacle]
    return Alarms(
        *key,
        len(found),
        len(whole),
        sum(row.verdict == DIFFERS for row in whole),
        sum(row.verdict == UNRESOLVED for row in whole),
        max((row.over_bar for row in resolved), default=0.0),
        _median_bar(found, "slip rate all stations"),
        _median_bar(found, "slip all stations"),
    )


def _median_bar(found: Iterable[Tried], name: str) -> float:
    bars_of_name = (_bar_of(one.rows, name) for one in found)
    return median([bar for bar in bars_of_name if bar is not None] or [math.nan])


def _bar_of(found: Iterable[JudgedRow], name: str) -> float | None:
    """The bar of the row of a name; None if there is no such row."""
    return next((row.bar for row in found if row.name == name), None)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and write the tables into a folder."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.validate.power")
    parser.add_argument("--csv", type=Path, default=Path("."), metavar="DIR")
    parser.add_argument("--share", type=float, default=1.0, help="of the scenes")
    options = parser.parse_args(arguments)
    trial = list(all_tried(options.share))
    tables: dict[str, Sequence[Any]] = {
        "alarms": alarms(trial),
        "power": power(trial),
        "constants": changed(trial),
    }
    for name, table in tables.items():
        write_rows(options.csv / f"validate-{name}.csv", table, command=COMMAND)


if __name__ == "__main__":
    main()
