"""Find whole lines and growing loads by name, read them from TOML files, and write them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from semianalytic.scene.checks import checked_kind, made, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import toml_text
from semianalytic.scene.given.files import check_tables, read_document
from semianalytic.scene.scene import IN_PLANE, Material, Tractions
from semianalytic.whole_line.growing import GrowingSlot
from semianalytic.whole_line.line import LOADS, Patch, PointForce, WholeLine

Problem = WholeLine | GrowingSlot
WHOLE_LINE = "whole line"

_SOLID, _PRELOAD = Material(1.0, 1.0, 1 / 3), Tractions(1.0, 0.0)


@dataclass(frozen=True)
class NamedLine:
    """A problem that comes with the package, and a line that says what it shows."""

    problem: Problem
    summary: str


NAMED_LINES: Mapping[str, NamedLine] = {
    "whole-line-patch": NamedLine(
        WholeLine(_SOLID, 0.5, _PRELOAD, Patch(speed=0.3, shear=1.0)),
        "no slot: slip spreads to both sides of an over-stressed patch that grows",
    ),
    "point-load": NamedLine(
        WholeLine(_SOLID, 1.0, _PRELOAD, PointForce(shear=1.0)),
        "no slot: slip spreads from a point force that grows evenly in time",
    ),
    "growing-load": NamedLine(
        GrowingSlot(_SOLID, 0.5, Tractions(1.0, 1.0)),
        "pressure and shear on the slot grow evenly in time: one slip zone",
    ),
}


def find_line(source: str) -> Problem:
    """Return the problem of a name, or of a TOML file that describes one.

    A file holds ``contact = "whole line"``, ``friction``, ``[material]`` and ``[base]`` as a scene
    does, and ``[load]`` with ``kind`` patch, point-force or half-line, ``pressure``, ``shear``, and
    the ``speed`` of a patch.  With ``growth = 1`` (or 2) in place of ``contact`` it describes a
    `GrowingSlot`, with pressure and shear in ``[load]``.  ``mode`` and ``units`` may be given.

    Raises
    ------
    SceneError
        If the file describes none; the message names file and key.
    """
    if source in NAMED_LINES:
        return NAMED_LINES[source].problem
    return _read(source, read_document(source))


def _read(path: str, document: Mapping[str, Any]) -> Problem:
    """Make the problem of a file; messages name the file."""
    try:
        return line_from_document(document)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from error


def line_document(problem: Problem) -> dict[str, Any]:
    """Return a problem as plain dictionaries, strings and numbers, for TOML or JSON.

    It has the keys of a file, see `find_line`; mode and units are left out if they are the default.
    """
    document: dict[str, Any] = {}
    if isinstance(problem, WholeLine):
        document["contact"] = WHOLE_LINE
    else:
        document["growth"] = problem.power
    if problem.mode != IN_PLANE:
        document["mode"] = problem.mode
    if problem.units:
        document["units"] = problem.units
    document["friction"] = problem.friction
    document["material"] = asdict(problem.material)
    if isinstance(problem, WholeLine):
        document["base"] = asdict(problem.base)
        (kind,) = (name for name, load in LOADS.items() if isinstance(problem.load, load))
        document["load"] = {"kind": kind, **asdict(problem.load)}
    else:
        document["load"] = asdict(problem.load)
    return document


def line_text(problem: Problem) -> str:
    """Return a problem as a TOML file."""
    return toml_text(line_document(problem))


def line_from_document(document: Mapping[str, Any]) -> Problem:
    """Make the problem that a dictionary of `line_document`, or of a TOML file, describes.

    Raises
    ------
    SceneError
        If a key is unknown or missing, or a value is out of range.
    """
    whole = "contact" in document
    if whole and "growth" in document:
        raise SceneError("give contact, of a line without a slot, or growth, of a load; not both.")
    if whole and document["contact"] != WHOLE_LINE:
        raise SceneError(
            f'contact must be "{WHOLE_LINE}", or left out for a scene with a slot, got '
            f"{shown(document['contact'])}."
        )
    required = ("friction", "material", *(("base",) if whole else ()), "load")
    optional = ("contact" if whole else "growth", "mode", "units", *(() if whole else ("base",)))
    check_tables(document, required, optional)
    common = {
        "material": Material(**document["material"]),
        "friction": document["friction"],
        "mode": document.get("mode", IN_PLANE),
        "units": document.get("units", ""),
    }
    if not whole:
        return GrowingSlot(
            **common,
            load=Tractions(**document["load"]),
            power=document["growth"],
            # A base is accepted in a file so that `GrowingSlot` can say why it has to be zero.
            base=Tractions(**document.get("base", {"pressure": 0.0, "shear": 0.0})),
        )
    hint = " (tractions on the faces of a slot belong to a scene, without contact)"
    load = document["load"]
    kind = checked_kind("load", load, LOADS, "" if "kind" in load else hint)
    base = Tractions(**document["base"])
    return WholeLine(**common, base=base, load=made("load", LOADS[kind], load))
