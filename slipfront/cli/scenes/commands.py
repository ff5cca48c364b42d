"""``slipfront scenes`` lists scenes; ``slipfront init`` writes a scene file to start from."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.markup import escape

from compare.comparison.documents import SCENE_DIMENSIONS, units_document
from compare.output.places import check_file, write_text
from compare.output.printed import PrintedTable
from semianalytic import Scene, find
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import PluginError, SceneError
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.files import read_document
from semianalytic.scene.given.finding import brought_scene, brought_summary, find_scene
from semianalytic.scene.given.named import DEFAULT_SCENE, NAMED_LINES, NAMED_SCENES, NAMED_SPECIMENS
from semianalytic.scene.given.solids import find_solid, solids
from semianalytic.scene.given.template import in_si_units, scene_text
from semianalytic.scene.laws.kinds import LAW_KINDS
from semianalytic.scene.plugins import (
    FIGURES,
    HISTORIES,
    LAWS,
    METHODS,
    SCENES,
    Plugin,
    find_plugin,
    plugins,
)
from semianalytic.scene.tables.text import text_of
from semianalytic.scene.tabulated import HISTORY_KINDS
from semianalytic.scene.units import SI
from slipfront.cli.options import AsJson, option, with_options
from slipfront.cli.scenes.completion import FIGURES as OWN_FIGURES
from slipfront.cli.scenes.completion import METHODS as OWN_METHODS
from slipfront.cli.scenes.completion import one_of, scene_names
from slipfront.cli.terminal import print_json

STDOUT = Path("-")


_OWN: Mapping[str, Collection[str]] = {
    SCENES: (*NAMED_SCENES, *NAMED_LINES, *NAMED_SPECIMENS),
    LAWS: LAW_KINDS,
    HISTORIES: HISTORY_KINDS,
    FIGURES: OWN_FIGURES,
    METHODS: OWN_METHODS,
}


def scenes(as_json: AsJson = False) -> None:
    """List all scenes, and the laws, histories, figures and methods of other packages."""
    rows = [*_own_rows(), *map(_brought_row, plugins(SCENES))]
    groups = (LAWS, HISTORIES, FIGURES, METHODS)
    others = [_row(plugin) for group in groups for plugin in plugins(group)]
    if as_json:
        units = {"scenes": _units(find_scene(DEFAULT_SCENE))}
        print_json("scenes", {"scenes": rows, "brought": others, "units": units})
        return
    table = PrintedTable("scene", "what it shows", title="Scenes")
    for row in rows:
        table.add_row(*map(escape, (row["name"], row["problem"] or row["summary"])))
    Console().print(table)
    if brought := [row for row in (*rows, *others) if row["package"]]:
        table = PrintedTable("package", "brings", "called", title="From other packages")
        for row in brought:
            table.add_row(*map(escape, (row["package"], row["what"], row["name"])))
        Console().print(table)


def _own_rows() -> Iterator[dict[str, Any]]:
    own = [(name, named.scene, named.summary) for name, named in NAMED_SCENES.items()]
    lines = NAMED_LINES.items()
    own += [(name, find(name), read_document(path)["summary"]) for name, path in lines]
    for name, scene, summary in own:
        row = {"name": name, "what": _what(scene), "package": None, "problem": ""}
        yield {**row, "summary": summary, "scene": scene_document(scene)}
    for name, path in NAMED_SPECIMENS.items():
        row = {"name": name, "what": "specimen", "package": None, "problem": ""}
        given = read_document(path)
        yield {**row, "summary": given.pop("summary"), "scene": given}


def _what(scene: Scene) -> str:
    """Return in a word or two what a scene is."""
    if scene.on_line:
        return "on a line"
    if scene.grows:
        return "growing load"
    if not scene.has_slot:
        return "whole line"
    return "scene" if scene.lower_material is None else "two bodies"


def _row(plugin: Plugin) -> dict[str, Any]:
    """Return a plugin as a row of the list, with the problem that prevents its use, if any."""
    row = {"name": plugin.name, "what": plugin.noun, "package": plugin.package, "problem": ""}
    if plugin.name in _OWN[plugin.group]:
        return {**row, "problem": "not used: slipfront has one of the same name"}
    try:
        find_plugin(plugin.group, plugin.name)
    except PluginError as error:
        row["problem"] = str(error)
    return row


def _brought_row(plugin: Plugin) -> dict[str, Any]:
    """Return the scene of a plugin as a row; if it cannot be loaded, the row says why."""
    row = {**_row(plugin), "summary": "", "scene": None}
    if not row["problem"]:
        try:
            row["scene"] = scene_document(brought_scene(plugin))
            row["summary"] = brought_summary(plugin)
        except PluginError as error:
            row["problem"] = str(error)
    return row


def _units(scene: Scene) -> dict[str, Any]:
    return {"scene": units_document(scene_document(scene), SCENE_DIMENSIONS, scene)}


_OPTIONS: Mapping[str, Any] = {
    "file": typer.Argument(metavar="[FILE]", help="File to write, or - for standard output."),
    "from_": option("Scene to write.", flag="--from", complete=scene_names, metavar="SCENE"),
    "units": option(
        "SI converts the scene to m, s, kg and Pa, for a polymer-like solid under 1 MPa.",
        complete=one_of(SI),
    ),
    "material": option(
        f"Real solid to begin with, in SI units: {', '.join(solids())}.",
        complete=one_of(*solids()),
        metavar="SOLID",
    ),
    "with_all": option(
        "Show all loads, load histories and friction laws as comments.", flag="--all"
    ),
    "force": option("Replace an existing file.", flag="--force"),
}


@with_options(_OPTIONS)
def init(
    file: Path = Path("scene.toml"),
    from_: str = DEFAULT_SCENE,
    units: str | None = None,
    material: str | None = None,
    with_all: bool = False,
    force: bool = False,
    as_json: AsJson = False,
) -> None:
    """Write a scene as a TOML file to edit, in which every number has its unit and a comment."""
    if units not in (None, SI):
        raise SceneError(f"--units must be SI or left out, got {shown(units)}.")
    finite = NAMED_SPECIMENS.get(from_)
    scene = find(DEFAULT_SCENE if finite else from_)
    if finite or scene.on_line:
        if units or material:
            raise SceneError(
                f"--{'units' if units else 'material'} is for scenes with a slot; leave it out for "
                f"{from_}, and change its file."
            )
        text = text_of(finite or NAMED_LINES.get(from_, Path(from_)))
    else:
        solid = None if material is None else find_solid(material)
        if units or solid:
            scene = in_si_units(scene, None if solid is None else solid.material)
        remark = f"{material}: {solid.source}." if solid else ""
        text = scene_text(scene, from_, remark, with_all=with_all)
    document = {"scene": scene_document(scene), "units": _units(scene), "text": text}
    if finite:
        document = {"scene": read_document(finite), "units": {}, "text": text}
    if file != STDOUT:
        check_file(file)
        if (file.exists() or file.is_symlink()) and not force:  # a link to nothing, too
            raise SceneError(f"{file} exists already; give another name, or --force.")
        write_text(file, text)
    if as_json:
        print_json("init", document, files=[] if file == STDOUT else [file])
    elif file == STDOUT:
        sys.stdout.write(text)
    else:
        verb = "simulate" if finite else "solve"
        Console().print(f"Written to {file}; try slipfront {verb} {file}", highlight=False)
