"""Sheets, runs and scores as plain dictionaries, each number with its unit, for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

from compare.benchmarks.answers import described_problem, written_document
from compare.benchmarks.classes import tolerances
from compare.benchmarks.entries import Run
from compare.benchmarks.interfaces.sheets import SI, InterfaceSheet
from compare.benchmarks.scores import Score
from compare.benchmarks.sheet import Sheet
from compare.benchmarks.sheets import ALL_SHEETS, SHEETS
from compare.comparison.documents import SCENE_DIMENSIONS, Dimensions, units_document
from semianalytic import Scene
from semianalytic.scene.units import unit

_RATES = dict.fromkeys(("edge_slip_rate", "edge_amplitude", "slip_rate"), "length / time")
_STRESSES = dict.fromkeys(("shear_traction", "pressure"), "stress")
ANSWER_DIMENSIONS: Dimensions = {
    "zones": "length / time",
    "openings": "length / time",
    **dict.fromkeys(("K_I", "K_II", "K_III"), "stress sqrt(length)"),
    "arrivals": "time",
    **dict.fromkeys(("slip", "max_slip"), "length"),
    "accumulated_slip": "length^2",
    "frictional_work": "stress length^2",
    **_RATES,
    **_STRESSES,
}
SHEET_DIMENSIONS: Dimensions = {
    "scene": SCENE_DIMENSIONS,
    "stations": "length",
    "times": "time",
    "answers": ANSWER_DIMENSIONS,
    "errors": ANSWER_DIMENSIONS,
}


DIMENSIONLESS = SHEETS["preloaded"].scene
"""A scene in the units of all sheets, for names of units."""


def sheets_document() -> dict[str, Any]:
    """List what each sheet asks a code to report."""
    sheets = [
        {
            **{one.name: getattr(sheet, one.name) for one in fields(Sheet)},
            "marched": sheet.is_marched,
            "scene": described_problem(sheet),
        }
        for sheet in ALL_SHEETS.values()
    ]
    units = units_document(sheets, {"scene": SCENE_DIMENSIONS}, DIMENSIONLESS)
    return {"sheets": sheets, "units": {"sheets": units}}


def sheet_document(sheet: Sheet) -> dict[str, Any]:
    """A sheet with its answer and tolerance classes, in units mu = rho = c_t = T = 1."""
    written = written_document(sheet)
    document = {
        **written,
        "system": written["units"],
        "tolerances": [asdict(one) for one in tolerances().values() if one.sheet == sheet.name],
    }
    if not isinstance(sheet, InterfaceSheet):
        return {**document, "units": units_document(document, SHEET_DIMENSIONS, DIMENSIONLESS)}
    dimensions = {**SHEET_DIMENSIONS, "scene": {}, "errors": _RELATIVE}
    return {**document, "units": units_document(document, dimensions, _scene_of(sheet))}


_RELATIVE: Dimensions = {
    **dict.fromkeys(("slip_rate", "slip", "shear_traction"), "1"),
    "arrivals": "time",
}
"""Dimensions of the stated errors of interfaces."""


def _scene_of(sheet: InterfaceSheet) -> Scene:
    """Return a scene in the units of an interface, for names of units."""
    return SHEETS["preloaded"].si_scene if sheet.units == SI else DIMENSIONLESS


def run_document(run: Run) -> dict[str, Any]:
    """Describe a run: its sheet, its code and its cost."""
    return {
        "sheet": run.sheet.name,
        "code": run.code,
        "cells": run.cells,
        "stations": [station.x for station in run.records.stations],
        "seconds": run.seconds,
        "units": {"stations": _station_unit(run.sheet), "seconds": "s"},
    }


def _station_unit(sheet: Sheet) -> str:
    if not isinstance(sheet, InterfaceSheet):
        return "c_t T"
    return unit("length", _scene_of(sheet).units)


def scores_document(scores: Sequence[Score]) -> dict[str, Any]:
    """Scores: `error` of arrivals over T and `second` in cells; of all else both are relative."""
    units = {"seconds": "s", "error": "1", "second": "1"}
    return {"scores": [asdict(one) for one in scores], "units": {"scores": units}}
