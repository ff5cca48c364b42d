"""Interfaces in TOML files: the description of an interface and the options of its run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from semianalytic.interface.contact import Adhesion, Contact
from semianalytic.interface.documents import interface_document
from semianalytic.interface.fields import RESERVED, Expression, Table
from semianalytic.interface.interface import Interface
from semianalytic.interface.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.checks import check_keys, checked_table, finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import history_from_table
from semianalytic.scene.given.files import INTERFACE_KEY, read_document
from semianalytic.scene.incident import IncidentWave, MovingLoad, load_from_document
from semianalytic.scene.laws.alike import Alike
from semianalytic.scene.laws.kinds import LAW_WORDS, law_from_table
from semianalytic.scene.laws.law import Law
from semianalytic.scene.material import Material

_INTERFACE = ("length", "pressure", "shear", "mode", "rate", "plate_rate", "held", "even")
_TAKEN = (*_INTERFACE, *(one.name for one in fields(Material)))
"""Names of parameters that named numbers cannot have."""
_ADHESION = ("strength", "length")
_PARTS = (
    *("summary", "material", "lower_material", "law", "contact"),
    *("adhesion", "load", "run", "numbers"),
)
_TRACTIONS = ("shear", "pressure")


@dataclass(frozen=True, eq=False)
class InterfaceFile(Alike):
    """An interface, and how it is to be run.

    Attributes
    ----------
    interface : Interface
        The description.
    end_time : float
        Last time [time].
    options : mapping
        Further arguments of `run`, such as nodes.
    summary : str
        One line that says what the run shows.

    Examples
    --------
    >>> from semianalytic import find
    >>> found = find("cattaneo")
    >>> found.interface.contact.intervals, found.interface.even
    (((-1.0, 1.0),), True)
    """

    interface: Interface
    end_time: float
    options: Mapping[str, Any]
    summary: str = ""

    def document(self) -> dict[str, Any]:
        """Return everything that tells it from others as text and numbers, for JSON."""
        return interface_document(self.interface, self.end_time, self.options)

    @property
    def units(self) -> str:
        """System of units of the numbers, which interfaces do not name."""
        return ""

    @property
    def material(self) -> Material:
        """The solid on y > 0."""
        return self.interface.material


def read_interface(path: str | PathLike[str]) -> InterfaceFile:
    """Read the interface that a TOML file describes (docs/engine.md, "Files").

    Raises
    ------
    SceneError
        If the file cannot be read, or a key is missing, unknown or out of range; the message names
        file and key.
    """
    return described(read_document(path), str(path), Path(path).parent)


def described(document: dict[str, Any], name: str, folder: Path = Path()) -> InterfaceFile:
    """Return the interface of a document; tables of values are sought in a folder."""
    try:
        return _interface(document, folder)
    except SceneError as error:
        raise SceneError(f"{name}: {error}") from error


class _Around(NamedTuple):
    """The folder of a file, the numbers for its expressions, and those that stand in one."""

    folder: Path
    numbers: Mapping[str, float]
    named: set[str]

    def expression(self, text: str, *variables: str) -> Expression:
        """Return an expression that may name the numbers."""
        made = Expression(text, variables, self.numbers)
        self.named.update(made.numbers)
        return made


def _interface(document: dict[str, Any], folder: Path) -> InterfaceFile:
    """Make the interface of a document."""
    if INTERFACE_KEY not in document and "friction" in document:
        raise SceneError(
            "this file describes a scene, not an interface, which has a table [law]: slipfront "
            "solve or march (docs/scenes.md)."
        )
    check_keys("", document, ("length", "material", "law", "run"), (*_INTERFACE, *_PARTS))
    around = _Around(folder, _numbers(document.get("numbers", {})), set())
    given: dict[str, Any] = {
        name: _solid(name, document[name])
        for name in ("material", "lower_material")
        if name in document
    }
    plan = checked_table("run", document["run"])
    options = ("nodes", "step_ratio", "every", "frames", "rtol")
    check_keys("run.", plan, ("end_time",), options)
    given |= {key: document[key] for key in _INTERFACE if key in document}
    for key in ("pressure", "shear", "rate"):
        if key in given:
            given[key] = _field(key, given[key], around)
    if "adhesion" in document:
        table = checked_table("adhesion", document["adhesion"])
        check_keys("adhesion.", table, _ADHESION)
        bonds = {key: _field(f"adhesion.{key}", one, around) for key, one in table.items()}
        given["adhesion"] = Adhesion(**bonds)
    loads = document.get("load", [])
    # [load] and [[load]] are both natural for a single load.
    loads = [loads] if isinstance(loads, dict) else loads
    if not isinstance(loads, list):
        raise SceneError("load must be one table, [load], or several, [[load]].")
    interface = Interface(
        law=_law(checked_table("law", document["law"]), around),
        loads=[_load(checked_table("load", one), around) for one in loads],
        contact=_contact(document.get("contact")),
        **given,
    )
    for key in around.numbers:
        # A number that stands nowhere is most likely a misspelt one of an expression.
        if key not in around.named:
            raise SceneError(f"numbers.{key} stands in no expression; use it, or leave it out.")
    # The end time is an argument of `run` by itself; a fit or a survey may replace the others.
    others = {key: value for key, value in plan.items() if key != "end_time"}
    return InterfaceFile(interface, plan["end_time"], others, str(document.get("summary", "")))


def _numbers(table: Any) -> dict[str, float]:
    """Return the numbers that expressions may name."""
    for name, value in checked_table("numbers", table).items():
        if not name.isidentifier() or name in (*RESERVED, *_TAKEN):
            raise SceneError(f"numbers: {shown(name)} has a meaning of its own; take another name.")
        if finite(value) is None:
            raise SceneError(f"numbers: {name} must be a finite number, got {shown(value)}.")
    return dict(table)


def _solid(name: str, value: Any) -> Material:
    material = checked_table(name, value)
    check_keys(f"{name}.", material, [one.name for one in fields(Material)])
    try:
        return Material(**material)
    except SceneError as error:
        # `Material` does not know which of the two bodies it is.
        raise SceneError(str(error).replace("material:", f"{name}:", 1)) from error


def _law(table: dict[str, Any], around: _Around) -> Law:
    values = {
        key: value if key in LAW_WORDS else _field(f"law.{key}", value, around)
        for key, value in table.items()
    }
    return law_from_table("law", values)


def _front_load(table: dict[str, Any]) -> FrontLoad:
    """Return the wave or moving load that a table with a `kind` describes."""
    given = {name: table[name] for name in ("at",) if name in table}
    if "history" in table:
        given["history"] = history_from_table("load.history", table["history"])
    # Waves and moving loads are those of scenes; where they meet the line, and their history, are
    # of the engine.
    front = load_from_document(
        {key: value for key, value in table.items() if key not in ("at", "history")}
    )
    if not isinstance(front, IncidentWave | MovingLoad):
        raise SceneError(
            f"load: kind must be incident-wave or moving in the file of an interface, got "
            f"{shown(table['kind'])}; give a patch as a function of x and t."
        )
    return FrontLoad(front, **given)


def _load(table: dict[str, Any], around: _Around) -> InterfaceLoad | FrontLoad:
    if "kind" in table:
        return _front_load(table)
    check_keys("load.", table, (), (*_TRACTIONS, "history", "on"))
    values = dict(table)
    given = [name for name in _TRACTIONS if name in table]
    if not given:
        raise SceneError("load: shear or pressure is missing.")
    # An expression of t is a load that varies by itself: it must not be multiplied by a step.
    timed = [_mentions_time(table[name], around) for name in given]
    if "history" not in table and any(timed):
        values["history"] = None
    for name in given:
        # None was set above, for loads of x and t; without a history at all the default is any
        # other object.
        if values.get("history", table) is None and isinstance(table[name], str):
            values[name] = around.expression(table[name], "x", "t")
        else:
            values[name] = _field(f"load.{name}", table[name], around)
    history = table.get("history")
    if isinstance(history, str):
        values["history"] = around.expression(history, "t")
    elif history is not None:
        values["history"] = history_from_table("load.history", history)
    return InterfaceLoad(**values)


def _mentions_time(text: Any, around: _Around) -> bool:
    """Return whether a value is an expression of more than x."""
    if not isinstance(text, str):
        return False
    try:
        around.expression(text, "x")
    except SceneError:
        return True
    return False


def _contact(table: Any) -> Contact:
    if table is None:
        return Contact()
    table = checked_table("contact", table)
    check_keys("contact.", table, ("intervals",))
    return Contact(table["intervals"])


def _field(name: str, value: Any, around: _Around) -> Any:
    """Return the field that a number, an expression of x or a table describes."""
    if finite(value) is not None:
        return value
    if isinstance(value, str):
        return around.expression(value, "x")
    # The keys alone tell a table of numbers from one in a file.
    if isinstance(value, dict) and set(value) == {"x", "values"}:
        return Table(value["x"], value["values"])
    if isinstance(value, dict) and "file" in value and set(value) <= {"file", "column"}:
        return Table.read(around.folder / str(value["file"]), str(value.get("column", "")))
    raise SceneError(
        f"{name} must be a number, an expression of x, {{x = [...], values = [...]}} or "
        f'{{file = "...", column = "..."}}, got {shown(value)}.'
    )
