"""JSON report of a judgement, with the prediction and the simulation that it compares."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from compare.comparison.case import Case
from compare.comparison.documents import (
    SCENE_DIMENSIONS,
    Dimensions,
    json_text,
    row_units,
    solution_document,
    units_document,
)
from compare.comparison.fields.errors import BAND
from compare.comparison.judgement import Judgement, own_bars, side_by_side
from compare.comparison.rows import AGREES
from compare.output.places import write_text
from semianalytic.results.answer import method_of
from semianalytic.scene.given.documents import scene_document

if TYPE_CHECKING:
    from fem import Simulation

_RUN_DIMENSIONS: Dimensions = {
    "end_time": "time",
    "element_size": "length",
    "damping": "element_size / c_t",
    "time_step": "time",
    "critical_step": "time",
    "opened": {"time": "time", "x": "length", "gap": "length", "length": "length"},
    "seconds": "s",
}
REPORT_DIMENSIONS: Dimensions = {
    "parameters": SCENE_DIMENSIONS,
    "fields": {"band": "element_size", "frames": {"time": "time"}},
    "finite_elements": _RUN_DIMENSIONS,
}
SIMULATION_DIMENSIONS: Dimensions = {
    "scene": SCENE_DIMENSIONS,
    "finite_elements": _RUN_DIMENSIONS,
}


def judged_document(judgement: Judgement) -> dict[str, Any]:
    """The verdict and all rows of a judgement, of a scene or of an interface."""
    return {
        "verdict": judgement.verdict,
        "counts": judgement.counts,
        "quoted": judgement.quoted,
        "caution": judgement.case.caution,
        "rows": [
            {**asdict(row), "verdict": row.verdict, "remedy": judgement.remedy(row)}
            for row in judgement.rows
        ],
    }


def report_document(judgement: Judgement, label: str) -> dict[str, Any]:
    """A judgement as plain dictionaries, lists, strings and finite numbers, for JSON.

    `label` names the scene.  "units" mirrors the document.  The unit of a row is a symbol that is
    explained in units/rows, or a unit by itself.
    """
    simulation, prediction = judgement.simulation, judgement.prediction
    method = method_of(prediction)
    document: dict[str, Any] = {
        "scene": label,
        **judged_document(judgement),
        "parameters": scene_document(simulation.scene),
        "method": method,
        "semianalytic": solution_document(prediction) if method == "self-similar" else None,
        "finite_elements": _run(judgement.case),
        "fields": judgement.fields
        and {"band": BAND, "frames": [asdict(error) for error in judgement.fields.rows]},
    }
    document["units"] = units_document(document, REPORT_DIMENSIONS, simulation.scene)
    document["units"]["rows"] = row_units(simulation.scene, simulation.end_time)
    return document


def simulation_document(simulation: Simulation) -> dict[str, Any]:
    """A simulation as plain dictionaries, lists, strings and finite numbers, for JSON.

    "own_bars" are its error bars from its coarser meshes, relative or in "unit".
    """
    bars = () if simulation.companion is None else own_bars(simulation)
    document: dict[str, Any] = {
        "scene": scene_document(simulation.scene),
        "finite_elements": _run(side_by_side(simulation, simulation)),
        "own_bars": [
            {"name": row.name, "bar": row.bar, "unit": "relative" if row.relative else row.unit}
            for row in bars
        ],
    }
    document["units"] = units_document(document, SIMULATION_DIMENSIONS, simulation.scene)
    document["units"]["own_bars"] = row_units(simulation.scene, simulation.end_time)
    return document


def _run(case: Case) -> dict[str, Any]:
    """Settings of a simulation and the time that it took."""
    simulation = case.simulation
    return {
        "run": simulation.run,
        "end_time": simulation.end_time,
        "resolution": simulation.resolution,
        "companions": [run.resolution for run in case.coarser],
        "element_size": simulation.element_size,
        "model": simulation.model,
        "damping": simulation.damping,
        "time_step": simulation.time_step,
        "critical_step": simulation.critical_step,
        "steps": simulation.steps,
        "unknowns": simulation.unknowns,
        "caution": simulation.caution,
        "opened": simulation.opened and asdict(simulation.opened),
        "seconds": dict(simulation.seconds),
    }


_STYLE = (
    "body{font:16px/1.5 sans-serif;max-width:70em;margin:2em auto;padding:0 1em}"
    "img{max-width:100%}table{font-size:14px;border-collapse:collapse;overflow-x:auto;"
    "display:block}td,th{padding:.1em .6em;text-align:left}caption{text-align:left}"
)
_IMAGES = {"png": "png", "svg": "svg+xml"}
"""Formats of figures that a page contains, as types of media; it links to others."""


def write_page(judgement: Judgement, label: str, path: Path, figures: Sequence[Path] = ()) -> None:
    """Write a judgement as one HTML page: the verdict, what is quoted of it, rows that do not agree
    with reasons, figures, and all rows; raises as `write_text`."""
    reasons = [
        f"<li>{escape(row.name)}{escape(f' at {row.place}' if row.place else '')}: "
        f"{escape(row.verdict)}{escape(f', {row.obstacle}' if row.obstacle else '')}</li>"
        for row in judgement.rows
        if row.verdict != AGREES
    ]
    parts = [
        f"<h1>{escape(label)}: {escape(judgement.said)}</h1>",
        f"<p>Rows: {escape(judgement.shown_counts)}. "
        f"Differences and error bars: {escape(judgement.quoted)}.</p>",
        *(["<ul>", *reasons, "</ul>"] if reasons else []),
        *(_picture(figure) for figure in figures),
        judgement._repr_html_(),
    ]
    head = f'<meta charset="utf-8"><title>{escape(label)}</title><style>{_STYLE}</style>'
    body = "\n".join(parts)
    write_text(
        path, f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>{body}</body></html>\n'
    )


def _picture(figure: Path) -> str:
    """Return a figure for a page, which contains all of it unless its format is for paper."""
    name, kind = escape(figure.name), _IMAGES.get(figure.suffix.removeprefix("."))
    if kind is None:
        return f'<p><a href="{name}">{name}</a></p>'
    content = b64encode(figure.read_bytes()).decode()
    return f'<p><img alt="{name}" src="data:image/{kind};base64,{content}"></p>'


def write_report(judgement: Judgement, label: str, path: Path) -> None:
    """Write a judgement as JSON; raises as `write_text`."""
    write_text(path, json_text(report_document(judgement, label)))
