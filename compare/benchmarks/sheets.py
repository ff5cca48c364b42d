"""Problem sheets for codes of dynamic contact: what is asked, at which stations, in which units.

A sheet is a named scene or whole line in units mu = rho = c_t = T = 1, or an interface in
units of its own.  data/sheets.toml states those with classes; every other named scene is one too.
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from compare.records.record import QUANTITIES
from semianalytic import Scene, find
from semianalytic.methods import chosen
from semianalytic.scene.checks import meant
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.documents import scene_document, toml_text
from semianalytic.scene.given.files import scene_of_file
from semianalytic.scene.given.named import NAMED_LINES, NAMED_SCENES, NAMED_SPECIMENS
from semianalytic.scene.tables.text import text_of

STATIONS = (0.1, 0.25, 0.5, 0.75, 0.95)
"""Distances of the stations from the contact edge, over c_t T."""
TIMES = (*(step / 64 for step in range(1, 64, 2)), 1.0)
"""Times of the exact records, over T; no front of any sheet passes a station at one of them."""
OPENING = "opening"
"""`Sheet.arrival` where contacts open."""
PLAIN, SI = "mu = rho = c_t = T = 1", "SI"
"""Units of scenes, and of the problems of SCEC."""
STATEMENT = "{bodies} {slot} {coulomb} {loaded} {along} {faces} {letters}"
DATA = Path(str(files("compare.benchmarks").joinpath("data")))
SUMS = "SHA256SUMS"
_BY_FILE = "The file below states all of {}, with the keys of docs/scenes.md and docs/engine.md."


@dataclass(frozen=True)
class Sheet:
    """A problem."""

    name: str  # that of the scene or whole line, unless there is an interface
    title: str
    tests: str  # abilities of a code that passes
    # quantities to record at the stations, among `compare.records.record.QUANTITIES`
    report: tuple[str, ...]
    # event timed at the stations: "slip", the first slip rate above a level; "opening", the first
    # pressure below it; "" if nothing is
    arrival: str = "slip"
    note: str = ""  # further information
    statement: str = STATEMENT  # the problem in words
    interface: str = ""  # the interface as a file that `run` reads; "" of all else
    units: str = PLAIN  # the system of units
    stations: tuple[float, ...] = STATIONS  # positions [length]
    step: float = 0.0  # distance of the times of an interface's answer [time]
    extent: float = 1.0  # length over which cells are counted [length]
    extent_words: str = "c_t T"  # the same in words
    # nodes of the finest grid of an interface whose answer is stored, and the order at which its
    # runs converge; 0 of one that is marched when it is asked for
    nodes: int = 0
    order: int = 0
    level: float = 0.0  # slip rate whose first time is the arrival at an interface [length / time]
    # largest errors of the classes A, B and C by quantity, relative, or over T for "arrival": those
    # of our finite elements on 200, 100 and 50 cells, rounded up to two digits
    classes: Mapping[str, tuple[float, ...]] = field(default_factory=dict, hash=False)

    @property
    def is_interface(self) -> bool:
        """Whether the problem is an interface."""
        return bool(self.interface)

    @property
    def is_marched(self) -> bool:
        """Whether the answer is that of grids, with stated errors, and not exact."""
        return chosen(self.problem).name == "space-time"

    @cached_property
    def problem(self) -> Scene:
        """The scene; all but those on a line in `PLAIN` units."""
        if self.is_interface:
            return scene_of_file(tomllib.loads(self.interface), self.name)
        return find(self.name)

    @property
    def end_time(self) -> float:
        """T [time]."""
        return float(self.problem.run.get("end_time", 1.0))

    @property
    def times(self) -> tuple[float, ...]:
        """Times of the answer [time]."""
        if not self.is_interface:
            return TIMES
        count = round(self.end_time / self.step)
        return tuple((self.end_time * (np.arange(1, count + 1) / count)).tolist())

    @property
    def document(self) -> dict[str, Any]:
        """The problem as plain dictionaries, strings and numbers."""
        return scene_document(self.problem)

    @property
    def file(self) -> str:
        """The problem as a TOML file that slipfront reads."""
        return self.interface.lstrip() if self.is_interface else toml_text(self.document)


def stored_text(name: str, folder: Path = DATA) -> str:
    """Return the text of a file of the package; DataFileError if it does not fit its checksum."""
    path = folder / name
    try:
        data = path.read_bytes()
        sums = dict(line.split()[::-1] for line in (folder / SUMS).read_text().splitlines())
    except (OSError, ValueError) as error:
        raise DataFileError(f"{path} cannot be read ({error}).") from error
    if sums.get(name) != hashlib.sha256(data).hexdigest():
        raise DataFileError(f"{path} does not fit its checksum in {SUMS}; take a new copy.")
    return data.decode()


@cache
def sheets() -> Mapping[str, Sheet]:
    """All sheets by name; raises as `stored_text`."""
    described = tomllib.loads(stored_text("sheets.toml"))
    phrases, classes = described.pop("phrases"), json.loads(stored_text("classes.json"))
    found = {}
    for name, given in described.items():
        values: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in given.items()
        }
        bounds = classes.get(name, {}).items()
        values["classes"] = {quantity: tuple(row) for quantity, row in bounds}
        values["statement"] = given.get("statement", STATEMENT).format(**phrases)
        interface = given.get("interface", "")
        named = NAMED_LINES.get(interface)
        values["interface"] = text_of(named) if named else interface
        found[name] = Sheet(name, **values)
    return found


def sheet_names() -> tuple[str, ...]:
    """Names of all sheets, those of `sheets` first."""
    return tuple(dict.fromkeys((*sheets(), *NAMED_SCENES, *NAMED_LINES)))


def find_sheet(name: str) -> Sheet:
    """Sheet of a name; SceneError if there is none."""
    if name in sheets():
        return sheets()[name]
    if name in NAMED_SCENES or name in NAMED_LINES:
        return _plain_sheet(name)
    if name in NAMED_SPECIMENS:
        find(name)  # refuses it
    known = sheet_names()
    hint = meant(name, known, f"choose {', '.join(known)}.", 0.5)
    raise SceneError(f"There is no benchmark called {name!r}; {hint}")


def _plain_sheet(name: str) -> Sheet:
    """The sheet of a named scene that data/sheets.toml does not state: its file says all of it."""
    scene, file = find(name), text_of(NAMED_LINES[name]) + "\n" if name in NAMED_LINES else ""
    title = tomllib.loads(file)["summary"] if file else NAMED_SCENES[name].summary
    sheet = Sheet(name, title, "", QUANTITIES, statement=_BY_FILE.format(name), interface=file)
    if not scene.on_line:
        return sheet
    end, widest = float(scene.run["end_time"]), max(b - a for a, b in scene.contact.intervals) / 2
    reach = min(widest, scene.fastest_speed * end, scene.period / 4)
    places = (*(() if scene.even else (-0.75, -0.25)), *STATIONS)
    return replace(
        sheet,
        report=QUANTITIES if scene.may_open else QUANTITIES[:3],
        arrival="",
        units=scene.units or "of the file",
        stations=tuple(float(f"{reach * x:.6g}") for x in places),
        step=end / len(TIMES),
        extent=reach,
        extent_words=f"{reach:g}",
    )
