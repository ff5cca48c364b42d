"""Measured records as gauges of a fit, whatever the files of `slipfront validate` hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from compare.records.names import NOISE
from compare.records.read import read_records
from compare.records.record import AFTER, Placed, ReadingOptions, Record, Records
from compare.validation.readings import base_of, faces_are_mirrored
from semianalytic.inversion.gauges import FIELDS, QUANTITIES, Gauge, checked_noise
from semianalytic.scene.arguments import checking
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number, checked_size, shown
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.scene import Scene

_BASES = ("base_shear", "base_pressure", "shear", "pressure")


@checking
def read_gauges(
    paths: str | Path | Sequence[str | Path],
    noise: Mapping[str, float] | None = None,
    scene: Scene | None = None,
    gauges: Mapping[str, tuple[Any, ...]] | None = None,
) -> tuple[Gauge, ...]:
    """Read gauges from files.

    A table has the columns t and x, y for points off the interface, and quantities by the names of
    `Gauge` (or sigma_xx, eps_xy, v_x, ...).  Units follow in brackets where they are not those of
    the scene.  A column `noise` or NAME_noise holds standard deviations in the same unit.  Rows of
    equal x and y form a gauge; rows without y, or with y = 0, belong to the interface.  All files
    that `slipfront validate` reads are accepted as well, and the conventions that their headers
    state apply: motion of one face is doubled, and the base of the scene is added to changes of
    tractions.

    Parameters
    ----------
    paths : path, or sequence of path
    noise : mapping from quantity to number, optional
        Standard deviation where no column gives it, in the unit of the quantity; the key "" stands
        for all other quantities.
    scene : Scene, optional
        Scene of the records.  Without it changes of tractions are refused.
    gauges : mapping from name to tuple, optional
        Quantity and place of each column, in tables with one column for each gauge, as
        ``{"SG1": ("exx", 0.02, 0.0035)}``, or without y on the interface. No other column is read.

    Returns
    -------
    tuple of Gauge
        In the order of the files, sorted by position, with names such as exy-1, exy-2, vx-1.

    Raises
    ------
    DataFileError
        If a file cannot be read, or holds nothing that can be fitted; the message names it.
    SceneError
        If `noise` is not such a mapping, or a number in it is out of range.
    """
    return gauges_and_notes(paths, noise, scene, gauges=gauges)[0]


def gauges_and_notes(
    paths: str | Path | Sequence[str | Path],
    noise: Mapping[str, float] | None = None,
    scene: Scene | None = None,
    fitted: Collection[str] = (),
    gauges: Mapping[str, tuple[Any, ...]] | None = None,
) -> tuple[tuple[Gauge, ...], tuple[str, ...], tuple[str, ...]]:
    """Gauges as of `read_gauges`, what was made of the files, and names of columns not read.

    `fitted` holds the parameters to be fitted: changes of tractions do not say their base.
    """
    given: dict[str, float] = {}
    for name, size in (noise or {}).items():
        if name not in ("", *QUANTITIES):
            known = ", ".join(QUANTITIES)
            raise SceneError(f"read_gauges: noise takes {known}, got {shown(name)}.")
        given[name] = checked_size(f"noise of {name or 'all'}", size)
    paths = [paths] if isinstance(paths, str | PathLike) else paths
    if not (np.iterable(paths) and all(isinstance(p, str | PathLike) for p in paths)):
        raise SceneError(f"read_gauges: paths must be a path or several, got {shown(paths)}.")
    made: list[Gauge] = []
    counts: Counter[str] = Counter()
    notes: dict[str, None] = {}
    unread: dict[str, None] = {}
    options = ReadingOptions(
        gauges={name: _placed(name, gauge) for name, gauge in (gauges or {}).items()}
    )
    runs = read_records(list(paths), options)
    for run in runs:
        made += _of_run(run, given, scene, fitted, notes, counts)
        unread |= dict.fromkeys(run.unread)
    if not made:
        sources = ", ".join(run.source for run in runs)
        raise DataFileError(f"{sources}: there is no station on the contact, x > 0; shift x.")
    return tuple(made), tuple(notes), tuple(unread)


def _placed(name: str, given: object) -> Placed:
    """Return what a column records, and where; raise SceneError if that is not said."""
    if not isinstance(given, tuple) or len(given) not in (2, 3) or given[0] not in QUANTITIES:
        raise SceneError(
            f"read_gauges: gauge {name} must be a quantity, x and for points in the bodies y, with "
            f"a quantity among {', '.join(QUANTITIES)}, got {shown(given)}."
        )
    quantity, *place = given
    x, *y = (checked_number(f"read_gauges: place of {name}", coordinate) for coordinate in place)
    return Placed(quantity, x, y[0] if y and (y[0] or quantity in FIELDS) else None)


def _of_run(
    run: Records,
    noise: Mapping[str, float],
    scene: Scene | None,
    fitted: Collection[str],
    notes: dict[str, None],
    counts: Counter[str],
) -> Iterator[Gauge]:
    """Yield the gauges of a run, by quantity, counted by it; add notes on them."""
    notes |= dict.fromkeys(run.notes)
    if run.arrivals is not None:
        raise DataFileError(
            f"{run.source} holds times of rupture, which slipfront validate takes; give records of "
            f"{', '.join(QUANTITIES)}."
        )
    _check_faces(run, scene)
    records = (*run.stations, *run.points)
    if scene is not None and not scene.on_line:
        records = tuple(station for station in records if station.y is not None or station.x > 0)
        dropped = len(run.stations) + len(run.points) - len(records)
        if dropped:
            notes[f"{dropped} stations at x <= 0, off the contact of the scene, are left out"] = (
                None
            )
    for quantity in dict.fromkeys(name for station in records for name in station.values):
        factor = 2.0 if quantity in run.stated.faces else 1.0
        if factor != 1:
            notes[f"{quantity}: that of one face, doubled"] = None
        shift = 0.0
        if quantity == "slip_rate" and run.stated.mean == AFTER and run.stated.step:
            shift = run.stated.step / 2
            notes["slip_rate is a mean over a step and stands for its middle"] = None
        there = [station for station in records if quantity in station.values]
        if quantity == "pressure" and all(np.nanmax(place.values[quantity]) < 0 for place in there):
            factor = -1.0
            notes["pressure: tension is positive, turned"] = None
        changes = quantity in run.stated.changes
        if changes:
            _check_changes(run, scene, fitted)
            notes[f"{quantity}: changes since t = 0, the base of the scene is added"] = None
        for record in there:
            base = base_of(scene, quantity, record.x) if changes and scene else 0.0
            here = np.isfinite(record.values[quantity])
            t, values = record.t[here] + shift, factor * record.values[quantity][here] + base
            known = record.noise.get(quantity)
            spread: float | Array | None = noise.get(quantity, noise.get(""))
            if known is not None:
                spread = known[here]
            counts[quantity] += 1
            named = replace(record, name=record.name or f"{quantity}-{counts[quantity]}")
            yield _gauge(run.source, quantity, named, (t, values), spread, abs(factor))


def _check_faces(run: Records, scene: Scene | None) -> None:
    """Refuse motion of one face where slip is not twice that."""
    if run.stated.faces and scene is not None and not faces_are_mirrored(scene):
        raise DataFileError(
            f"{run.source} holds the motion of one face alone, and slip is twice that only where "
            "both bodies are alike and shear acts alone; give both faces."
        )


def _check_changes(run: Records, scene: Scene | None, fitted: Collection[str]) -> None:
    """Refuse changes of tractions where nothing says what they are changes of."""
    if scene is None:
        raise DataFileError(
            f"{run.source} holds changes of tractions; name the scene whose base is to be added."
        )
    unknown = [name for name in fitted if name in _BASES or name.partition(":")[0] == "gain"]
    if not scene.on_line and scene.superposition.in_place != scene.base:
        unknown += [name for name in fitted if name in ("load_shear", "load_pressure")]
    if unknown:
        raise DataFileError(
            f"{run.source} holds changes of tractions since t = 0, which do not say "
            f"{', '.join(unknown)}; leave that out of --parameters, or give the tractions."
        )


def _gauge(
    source: str,
    quantity: str,
    record: Record,
    sample: tuple[Array, Array],
    spread: float | Array | None,
    factor: float,
) -> Gauge:
    """Return the gauge of a record; its noise takes the factor of the samples."""
    t, values = sample
    if spread is None:
        raise DataFileError(
            f"{source} does not say how exact its {quantity} is; add a column {NOISE} of standard "
            f"deviations, or give --noise {quantity}=NUMBER, with a unit if the file names one."
        )
    if isinstance(spread, float | int):  # then the number that was given is to blame, not the file
        checked_noise(factor * spread, values)
    try:
        return Gauge(record.x, t, values, factor * spread, quantity, record.y, record.name)
    except SceneError as refusal:
        where = f"x = {record.x:g}" + ("" if record.y is None else f", y = {record.y:g}")
        raise DataFileError(f"{source}, {quantity} at {where}: {refusal}") from refusal
