"""What `validate` says of right records and of wrong ones: ``python -m compare.validation.power``.

Our own finite elements take the part of another code, at 50, 100 and 200 cells over c_t T, with one
file of records at five stations and the spacing alone to go by.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.rows import DIFFERS, UNRESOLVED, Row
from compare.output.tables import write_rows
from compare.records.record import QUANTITIES
from compare.validation.rows import PLACES
from compare.validation.validation import Validation, validate
from semianalytic import InterfaceHistory, Scene, Solution, solve
from semianalytic.scene.named import find_scene
from semianalytic.scene.scene import Material

Array = NDArray[np.float64]
Arrays = dict[str, Any]

CELLS = (50, 100, 200)
SET_ON = ("stuck", "preloaded", "auxetic", "antiplane", "tap")
"""Scenes that the parts of a smear were set on; they are tried on the others."""
TRIED_ON = ("remote-shock", "viscous", "lift-off", "lift-off-shear", "pulse")
COMMAND = "python -m compare.validation.power --csv docs/data"


@dataclass(frozen=True)
class Alarms:
    """Verdicts on right records of one scene at one resolution.

    `most` is the largest difference over its bar, of rows that are resolved.
    """

    scene: str
    use: str
    cells: int
    rows: int
    differs: int
    unresolved: int
    most: float


@dataclass(frozen=True)
class Power:
    """How often a mistake is caught, and in which scenes it is not."""

    mistake: str
    cells: int
    scenes: int
    caught: int
    missed: str


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


def recorded(name: str, cells: int) -> Arrays:
    """Finite elements of a scene in units mu = rho = c_t = T = 1, at stations."""
    from fem import simulate

    return history_arrays(simulate(find_scene(name), 1.0, resolution=cells).interface, 1.0)


def _friction(factor: float) -> Spoil:
    def spoil(data: Arrays, scene: Scene) -> tuple[Arrays, Scene]:
        return data, replace(scene, friction=factor * scene.friction)

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


def _more_slip(data: Arrays, scene: Scene) -> tuple[Arrays, Scene]:
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


def excess(row: Row) -> float:
    """Difference of a row over its bar."""
    return abs(row.difference or 0.0) / row.bar if row.bar else 0.0


def alarms(name: str, cells: int, judged: Validation) -> Alarms:
    """What was said of right records."""
    resolved = [row for row in judged.rows if not row.obstacle]
    return Alarms(
        name,
        "set" if name in SET_ON else "tried",
        cells,
        len(judged.rows),
        judged.counts[DIFFERS],
        judged.counts[UNRESOLVED],
        max(map(excess, resolved), default=0.0),
    )


def spoilt(data: Arrays, scene: Scene, cells: int) -> Iterator[tuple[str, str]]:
    """Mistakes that change a scene, and the verdicts on them."""
    for mistake, spoil in SPOILS.items():
        changed = spoil(data, scene)
        if changed is not None:
            yield mistake, validate(*changed, spacing=1 / cells).verdict


def measure(cells: Sequence[int] = CELLS) -> tuple[list[Alarms], list[Power]]:
    """Both tables."""
    right: list[Alarms] = []
    power: list[Power] = []
    for number in cells:
        verdicts: dict[str, dict[str, str]] = {mistake: {} for mistake in SPOILS}
        for name in (*SET_ON, *TRIED_ON):
            data, scene = recorded(name, number), find_scene(name)
            right.append(alarms(name, number, validate(data, scene, spacing=1 / number)))
            for mistake, verdict in spoilt(data, scene, number):
                verdicts[mistake][name] = verdict
        for mistake, said in verdicts.items():
            missed = [name for name, verdict in said.items() if verdict != DIFFERS]
            caught = len(said) - len(missed)
            power.append(Power(mistake, number, len(said), caught, ", ".join(missed)))
    return right, power


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and write both tables into a folder."""
    parser = argparse.ArgumentParser(prog="python -m compare.validation.power")
    parser.add_argument("--csv", type=Path, default=Path("."), metavar="DIR")
    folder = parser.parse_args(arguments).csv
    right, power = measure()
    write_rows(folder / "validate-alarms.csv", right, command=COMMAND)
    write_rows(folder / "validate-power.csv", power, command=COMMAND)


if __name__ == "__main__":
    main()
