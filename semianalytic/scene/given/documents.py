"""Scenes as plain dictionaries, for TOML and JSON, and scenes made of such dictionaries."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from semianalytic.scene.checks import check_keys, checked_table, finite, made, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave, MovingLoad, load_document, load_from_document
from semianalytic.scene.laws.kinds import LAW_WORDS, law_from_table, law_table
from semianalytic.scene.laws.law import Law, coefficient_field
from semianalytic.scene.line.along import HALF_LINE
from semianalytic.scene.line.contact import Adhesion, Contact
from semianalytic.scene.line.fields import RESERVED, Expression, Scaled, Table
from semianalytic.scene.line.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.loading import SLOT, Tractions
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material
from semianalytic.scene.plugins import HISTORIES, known_class
from semianalytic.scene.scene import IN_PLANE, Scene
from semianalytic.scene.tables.columns import Tables
from semianalytic.scene.tabulated import HISTORY_FIELDS, HISTORY_KINDS, history_kind

WHOLE_LINE = "whole line"
"""Contact of bodies that touch everywhere, as files have it."""
MATERIAL = ("shear_modulus", "density", "poisson_ratio")
_LINE = {"period": math.inf, "rate": 0.0, "plate_rate": 0.0, "held": math.inf, "even": False}
"""Keys of a scene on a line besides tables, and what they are by default."""
_TAKEN = ("friction", "viscosity", "angle", *_LINE, *MATERIAL)
"""Names of parameters that named numbers cannot have."""
_POINTS, _TIMES = 257, 9
"""Positions and times at which functions are sampled to distinguish scenes."""


def scene_document(scene: Scene) -> dict[str, Any]:
    """Return a scene as plain dictionaries, lists, strings and numbers, for TOML or JSON.

    Histories and friction laws are named by `kind`; the coefficient at rest of a law stands outside
    its table.  Defaults are left out, so that files stay short.  Functions of Python, which no file
    can contain, are distinguished by their values at some positions and times.
    """
    write, law = _Writing(scene), scene.law
    own = coefficient_field(type(law))
    document: dict[str, Any] = {}
    if scene.contact.is_whole:
        document["contact"] = WHOLE_LINE
    elif scene.contact != HALF_LINE:
        ends = [[*map(write, interval)] for interval in scene.contact.intervals]
        document["contact"] = {"intervals": ends}
    if own is not None:
        document["friction"] = write(getattr(law, own))
    for name, usual in _LINE.items():
        if (value := getattr(scene, name)) != usual:
            document[name] = write(value)
    document["material"] = asdict(scene.material)
    document["base"] = write.all({"pressure": scene.base.pressure, "shear": scene.base.shear})
    loads = scene.load if isinstance(scene.load, tuple) else (scene.load,)
    tables = [write.load(load) for load in loads]
    document["load"] = tables if isinstance(scene.load, tuple) else tables[0]
    for name in HISTORY_FIELDS:
        if (history := getattr(scene, name)) != Step():
            document[name] = history_document(history)
    if isinstance(scene.friction, Law):
        document["friction_law"] = write.all(law_table(scene.friction))
    if scene.antiplane:
        document["mode"] = scene.mode
    if scene.load_on != SLOT:
        document["load_on"] = scene.load_on
    if scene.units:
        document["units"] = scene.units
    if scene.lower_material is not None:
        document["lower_material"] = asdict(scene.lower_material)
    if scene.adhesion is not None:
        parts = {"strength": scene.adhesion.strength, "length": scene.adhesion.length}
        document["adhesion"] = write.all(parts)
    if write.numbers:
        document["numbers"] = write.numbers
    if scene.run:
        document["run"] = dict(scene.run)
    return document


class _Writing:
    """The values of one scene as text and numbers, and the numbers that its expressions name."""

    def __init__(self, scene: Scene) -> None:
        self.numbers: dict[str, float] = {}
        self._half = scene.period / 2 if math.isfinite(scene.period) else 1.0
        self._end = finite(scene.run.get("end_time")) or 1.0

    def __call__(self, value: Any) -> Any:
        if isinstance(value, float) and not math.isfinite(value):
            return str(value)  # JSON has no infinity
        if isinstance(value, Expression):
            self.numbers |= value.numbers
            return value.text
        if isinstance(value, Scaled) and isinstance(value.field, Expression):
            return f"{value.factor!r} * ({self(value.field)})"
        if isinstance(value, Table):
            return {"x": value.x.tolist(), "values": value.values.tolist()}
        if isinstance(value, LoadHistory):
            return history_document(value)
        return {"function": self._digest(value)} if callable(value) else value

    def all(self, table: Mapping[str, Any]) -> dict[str, Any]:
        """Return a table of values."""
        return {name: self(value) for name, value in table.items()}

    def load(self, load: Any) -> dict[str, Any]:
        """Return a load."""
        if isinstance(load, FrontLoad):
            return {**load_document(load.front), "at": load.at, "history": self(load.history)}
        if isinstance(load, InterfaceLoad):
            parts = ((field.name, getattr(load, field.name)) for field in fields(load))
            return {key: self(value) for key, value in parts if not _is_usual(value)}
        return self.all(load_document(load))

    def _digest(self, function: Callable[..., Any]) -> str:
        """Return a digest of the values of a function of x, of x and t, or of t."""
        digest = hashlib.sha256()
        x, t = np.linspace(-self._half, self._half, _POINTS), np.linspace(0.0, self._end, _POINTS)
        # A function does not say what it takes: all three ways are tried, and failures count too.
        ways = ((x,), *((x, time) for time in t[:: _POINTS // _TIMES]), *((time,) for time in t))
        for arguments in ways:
            try:
                digest.update(np.asarray(function(*arguments), dtype=float).tobytes())
            except Exception:  # a function of other arguments fails in any way
                digest.update(b"-")
        return digest.hexdigest()


def _is_usual(value: Any) -> bool:
    """Return whether a part of a load may be left out: no traction, a step, no place."""
    return value is None or value == Step() or finite(value) == 0


def history_document(history: Any) -> dict[str, Any]:
    """Return a history as a dictionary of its kind and parameters."""
    return {"kind": history_kind(history), **asdict(history)}


def scene_from_document(document: Mapping[str, Any], folder: Path = Path()) -> Scene:
    """Make the scene that a dictionary of `scene_document`, or of a TOML file, describes.

    Tables of values are sought in the folder.  Raises SceneError if a kind or parameter of a
    history or friction law is unknown or missing, or a value is out of range.
    """
    read = _Reading(folder, document.get("numbers", {}))
    material = _solid("material", document["material"])
    base = checked_table("base", document["base"])
    check_keys("base.", base, ("pressure", "shear"))
    loads = document.get("load", {"pressure": 0.0, "shear": 0.0})
    if not isinstance(loads, list | dict):
        raise SceneError("load must be one table, [load], or several, [[load]].")
    contact = read.contact(document.get("contact"))
    given = [read.load(table, contact) for table in (loads if isinstance(loads, list) else [loads])]
    parts: dict[str, Any] = {
        name: history_from_table(name, document[name])
        for name in HISTORY_FIELDS
        if name in document
    }
    plain = ("mode", "load_on", "units", *_LINE)
    parts |= {name: document[name] for name in plain if name in document}
    if "rate" in parts:
        parts["rate"] = read.field("rate", parts["rate"])
    friction: Any = document.get("friction")
    if friction is not None:
        friction = read.field("friction", friction)
    if "friction_law" in document:
        table = checked_table("friction_law", document["friction_law"])
        values = {
            key: value if key in LAW_WORDS else read.field(f"friction_law.{key}", value)
            for key, value in table.items()
        }
        friction = law_from_table("friction_law", values, friction)
    if "adhesion" in document:
        table = checked_table("adhesion", document["adhesion"])
        check_keys("adhesion.", table, ("strength", "length"))
        parts["adhesion"] = Adhesion(
            **{key: read.field(f"adhesion.{key}", value) for key, value in table.items()}
        )
    if "run" in document:
        parts["run"] = checked_table("run", document["run"])
    if "lower_material" in document:
        parts["lower_material"] = _solid("lower_material", document["lower_material"])
    scene = Scene(
        material=material,
        friction=friction,
        base=Tractions(**{key: read.field(f"base.{key}", value) for key, value in base.items()}),
        load=tuple(given) if isinstance(loads, list) else given[0],
        contact=contact,
        **{"mode": IN_PLANE, **parts},
    )
    read.check_named()
    read.tables.warn_of_unread()
    return scene


def _solid(name: str, table: Any) -> Material:
    values = checked_table(name, table)
    check_keys(f"{name}.", values, MATERIAL)
    try:
        return Material(**values)
    except SceneError as error:
        # `Material` does not know which of the two bodies it is.
        raise SceneError(str(error).replace("material:", f"{name}:", 1)) from error


class _Reading:
    """The fields of one file: its folder, its named numbers, and those that stand somewhere."""

    def __init__(self, folder: Path, numbers: Any) -> None:
        self.folder, self.named, self.tables = folder, set[str](), Tables()
        self.numbers = checked_table("numbers", numbers)
        for name, value in self.numbers.items():
            if not name.isidentifier() or name in (*RESERVED, *_TAKEN):
                raise SceneError(f"numbers: {shown(name)} is a reserved name; choose another.")
            if finite(value) is None:
                raise SceneError(f"numbers: {name} must be a finite number, got {shown(value)}.")

    def check_named(self) -> None:
        """Raise SceneError for a number that stands nowhere, most likely a misspelt one."""
        for key in self.numbers.keys() - self.named:
            raise SceneError(f"numbers.{key} appears in no expression; use it, or leave it out.")

    def expression(self, text: str, *variables: str) -> Expression:
        """Return an expression that may name the numbers."""
        made = Expression(text, variables, self.numbers)
        self.named.update(made.numbers)
        return made

    def field(self, name: str, value: Any) -> Any:
        """Return the field that a number, an expression of x or a table describes."""
        if finite(value) is not None:
            return value
        if isinstance(value, str):
            return self.expression(value, "x")
        # The keys alone distinguish a table of numbers from one in a file.
        if isinstance(value, dict) and set(value) == {"x", "values"}:
            return Table(value["x"], value["values"])
        if isinstance(value, dict) and "file" in value and set(value) <= {"file", "column"}:
            path = self.folder / str(value["file"])
            return Table.of_columns(path, *self.tables.pair(path, str(value.get("column", ""))))
        raise SceneError(
            f"{name} must be a number, an expression of x, {{x = [...], values = [...]}} or "
            f'{{file = "...", column = "..."}}, got {shown(value)}.'
        )

    def contact(self, value: Any) -> Contact:
        """Return the contact of a file."""
        if value is None or value == WHOLE_LINE:
            return Contact() if value else HALF_LINE
        if not isinstance(value, Mapping):
            raise SceneError(
                f'contact must be "{WHOLE_LINE}", a table such as {{intervals = [[-1, 1]]}}, or '
                f"left out for x > 0 next to a slot, got {shown(value)}."
            )
        check_keys("contact.", value, ("intervals",))
        ends = {"-inf": -math.inf, "inf": math.inf}  # JSON has no infinity
        parts = value["intervals"] if isinstance(value["intervals"], list) else ()
        rows = (part if isinstance(part, list) else () for part in parts)
        places: Any = [[ends.get(str(end), end) for end in row] for row in rows]
        return Contact(places)

    def load(self, given: Any, contact: Contact) -> Any:
        """Return the load that a table describes."""
        table = checked_table("load", given)
        if "kind" in table:
            return self._front(table)
        if set(table) == {"pressure", "shear"} and not any(
            self._mentions_time(value) for value in table.values()
        ):
            return Tractions(**{key: self.field(f"load.{key}", of) for key, of in table.items()})
        check_keys("load.", table, (), ("shear", "pressure", "history", "on"))
        acting = [name for name in ("shear", "pressure") if name in table]
        if not acting:
            raise SceneError("load: shear or pressure is missing.")
        values, timed = dict(table), [self._mentions_time(table[name]) for name in acting]
        # An expression of t is a load that varies by itself: it must not be multiplied by a step.
        alone = "history" not in table and any(timed)
        for name in acting:
            if alone and isinstance(table[name], str):
                values[name] = self.expression(table[name], "x", "t")
            else:
                values[name] = self.field(f"load.{name}", table[name])
        history = table.get("history")
        if isinstance(history, str):
            values["history"] = self.expression(history, "t")
        elif history is not None:
            values["history"] = history_from_table("load.history", history)
        elif alone:
            values["history"] = None
        return InterfaceLoad(**values)

    def _front(self, table: dict[str, Any]) -> Any:
        """Return the wave, moving load or other load that a table with a `kind` describes."""
        own = {key: table.pop(key) for key in ("at", "history") if key in table}
        load = load_from_document(table)
        if not own:
            return load
        if not isinstance(load, IncidentWave | MovingLoad):
            raise SceneError(
                f"load: {', '.join(own)} is for the kinds incident-wave and moving, got "
                f"{shown(table['kind'])}; leave it out."
            )
        if "history" in own:
            own["history"] = history_from_table("load.history", own["history"])
        return FrontLoad(load, **own)

    def _mentions_time(self, text: Any) -> bool:
        """Return whether a value is an expression of more than x."""
        if not isinstance(text, str):
            return False
        try:
            self.expression(text, "x")
        except SceneError:
            return True
        return False


def history_from_table(name: str, table: Any) -> Any:
    """Return the history that a table with a kind and parameters describes."""
    kind = checked_table(name, table).get("kind")
    return made(name, known_class(name, HISTORIES, LoadHistory, HISTORY_KINDS, kind), table)


def toml_text(document: Mapping[str, Any]) -> str:
    """Return a document as a TOML file: numbers, words and lists first, then tables."""
    plain, tables = list[str](), list[str]()
    for name, value in document.items():
        several = isinstance(value, list) and value and isinstance(value[0], Mapping)
        if isinstance(value, Mapping) or several:
            for table in value if several else [value]:
                rows = [f"{key} = {_toml(part)}" for key, part in table.items()]
                tables.append("\n".join([f"[[{name}]]" if several else f"[{name}]", *rows]))
        elif value is not None:
            plain.append(f"{name} = {_toml(value)}")
    return "\n\n".join(["\n".join(plain), *tables]) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key} = {_toml(part)}' for key, part in value.items())}}}"
    return json.dumps(value)
