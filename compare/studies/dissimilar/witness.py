"""Exact fields in two different bodies against finite elements, and what a wrong material does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from compare.comparison.bars import LARGEST_ORDER, LEAST_ORDER, error_bar
from compare.comparison.fields.changes import PARTS
from compare.comparison.fields.errors import FieldErrors, field_errors
from compare.studies.dissimilar.pairs import SCENES
from fem import Simulation, simulate, with_companions
from semianalytic import Pair, solve

WITNESSED = ("two zones", "slip and opening", "film")
RESOLUTION = 64
"""Elements over the way of a shear wave of the upper body; its companions have 32 and 16."""
WRONG = 1.03
"""Shear modulus of the lower body in a spoilt answer, over its own."""


@dataclass(frozen=True)
class WitnessRow:
    """One component of the fields in both bodies: relative L1 differences between finite elements
    and exact fields, everywhere and away from fronts, with error bars of the finite elements, and
    the difference away from fronts of an answer whose lower body is 3 % stiffer."""

    scene: str
    component: str
    whole: float
    whole_bar: float
    away: float
    away_bar: float
    spoilt: float


def witness_rows(resolution: int = RESOLUTION) -> list[WitnessRow]:
    """Simulate some scenes and compare the last frame of each with exact fields."""
    return [row for name in WITNESSED for row in _rows_of(name, SCENES[name], resolution)]


def witnessed(pair: Pair, resolution: int, folder: Path) -> tuple[Simulation, FieldErrors]:
    """Return the simulation of a pair until a shear wave of the upper body has come a length of 1,
    and how its fields differ from the exact ones."""
    time = 1 / pair.upper.shear_speed
    run = simulate(
        pair.alike,
        time,
        snapshots=folder,
        lower_material=pair.lower,
        resolution=resolution,
        frames=1,
    )
    run = with_companions(run, snapshots=folder)
    return run, _errors(pair, run, folder)


def _errors(pair: Pair, run: Simulation, folder: Path) -> FieldErrors:
    errors = field_errors(solve(pair), run, folder)
    assert errors is not None  # a solved pair has fields in its bodies
    return errors


def _rows_of(name: str, pair: Pair, resolution: int) -> list[WitnessRow]:
    """Return the rows of one scene, one for each component."""
    with TemporaryDirectory() as place:
        run, errors = witnessed(pair, resolution, Path(place))
        lower = replace(pair.lower, shear_modulus=WRONG * pair.lower.shear_modulus)
        wrong = _errors(replace(pair, lower=lower), run, Path(place))
    found = {(change.component, change.part): change for change in errors.changes}
    spoilt = {(change.component, change.part): change for change in wrong.changes}
    rows = []
    for component in errors.last:
        whole, away = (found[component, part] for part in PARTS)
        rows.append(
            WitnessRow(
                name,
                component,
                whole.difference,
                error_bar(whole.changes, most=LEAST_ORDER).size,
                away.difference,
                error_bar(away.changes, most=LARGEST_ORDER).size,
                spoilt[component, PARTS[1]].difference,
            )
        )
    return rows
