"""Readers of measured records as gauges of a fit: gauges, image correlation, other codes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from compare.records.names import ALIASES, dimension_of
from compare.records.options import ReadingOptions
from compare.records.read import ARRAYS, HDF5, MESHES, read_records
from compare.records.record import Array
from compare.records.text import Table, read_table
from compare.records.units import EXAMPLES, names_no_unit, si_size
from semianalytic.inversion.gauges import FIELDS, INTERFACE, QUANTITIES, Gauge, checked_noise
from semianalytic.scene.checks import checked_size, shown
from semianalytic.scene.errors import DataFileError, SceneError

NOISE = "noise"
PARTS_OF_ONE: Mapping[str, float] = {
    **{"": 1.0, "1": 1.0, "-": 1.0, "%": 1e-2, "1e-3": 1e-3, "1e-6": 1e-6},
    **{"mstrain": 1e-3, "ustrain": 1e-6, "µstrain": 1e-6, "microstrain": 1e-6},
}
"""Factors of the units of strain."""

_LONG = {
    "v": ("v_", "velocity_"),
    "u": ("u_", "displacement_"),
    "s": ("s_", "sigma_", "stress_"),
    "e": ("e_", "eps_", "epsilon_", "strain_"),
}
_OF_FIELDS = {
    alias: name
    for name in FIELDS
    for alias in (name, *(stem + name[1:] for stem in _LONG[name[0]]))
}
_OF_INTERFACE = {alias: name for name, all_of in ALIASES.items() for alias in all_of.split()}
_Made = tuple[Callable[[str], Gauge], str]
"""A function that makes a gauge of a given name, and the gauge's quantity."""
_UNIT = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]$")


@dataclass(frozen=True)
class _Column:
    """Meaning of a column: "t", "x", "y" or a quantity, or the noise of one ("" for all).

    Numbers times `scale` are in the units of the scene; None for noise that has the unit of its
    quantity.
    """

    kind: str
    scale: float | None
    is_noise: bool = False


def read_gauges(
    paths: str | Path | Sequence[str | Path], noise: Mapping[str, float] | None = None
) -> tuple[Gauge, ...]:
    """Read gauges from files.

    A table has the columns t and x, y for points off the interface, and quantities by the names of
    `Gauge` (or sigma_xx, eps_xy, v_x, ...).  Units follow in brackets where they are not those of
    the scene.  A column `noise` or NAME_noise holds standard deviations in the same unit.  Rows of
    equal x and y form a gauge; rows without y belong to the interface.  All files that `slipfront
    validate` reads are accepted as well.

    Parameters
    ----------
    paths : path, or sequence of path
    noise : mapping from quantity to number, optional
        Standard deviation where no column gives it, in the unit of the quantity; the key "" stands
        for all other quantities.

    Returns
    -------
    tuple of Gauge
        In the order of the files, sorted by position, with names such as exy-1, exy-2, vx-1.

    Raises
    ------
    DataFileError
        If a file cannot be read, or lacks necessary columns; the message names it.
    SceneError
        If `noise` is no such mapping, or a number in it is out of range.
    """
    given = _checked_noise({} if noise is None else noise)
    paths = [paths] if isinstance(paths, str | PathLike) else paths
    if not isinstance(paths, Iterable) or not all(isinstance(p, str | PathLike) for p in paths):
        raise SceneError(f"read_gauges: paths must be a path or several, got {shown(paths)}.")
    parts: list[_Made] = []
    for path in map(Path, paths):
        table = _table(path)
        if table is None:
            parts += list(_of_records(path, given))
        else:
            parts += list(_of_table(table, given))
    if not parts:
        raise DataFileError("There is no file to read; name one at least.")
    counts: dict[str, int] = {}
    gauges = []
    for make, quantity in parts:
        counts[quantity] = counts.get(quantity, 0) + 1
        gauges.append(make(f"{quantity}-{counts[quantity]}"))
    return tuple(gauges)


def _checked_noise(noise: object) -> dict[str, float]:
    """Return standard deviations by quantity; raise SceneError if they are invalid."""
    if not isinstance(noise, Mapping):
        raise SceneError(
            "read_gauges: noise must be numbers by quantity, as "
            f'{{"slip": 1e-6}}, or {{"": ...}} for all, got {shown(noise)}.'
        )
    for name in noise:
        if name not in ("", *QUANTITIES):
            known = ", ".join(QUANTITIES)
            raise SceneError(f"read_gauges: noise knows {known}, got {shown(name)}.")
    return {name: checked_size(f"noise of {name or 'all'}", one) for name, one in noise.items()}


def _table(path: Path) -> Table | None:
    """Return a text table with times and positions; None for files that other readers know."""
    if path.is_dir() or path.suffix.lower() in (*MESHES, *ARRAYS, *HDF5, ".info"):
        return None
    if not path.exists():
        raise DataFileError(f"{path} does not exist; give a file that does.")
    table = read_table(path)
    kinds = {column.kind for column in _columns(table).values()}
    return table if {"t", "x"} <= kinds else None


def _columns(table: Table) -> dict[int, _Column]:
    """Return the meaning of the columns by index, leaving out columns of unknown names."""
    split = [_split(name) for name in table.names]
    names = {**_OF_INTERFACE, "y": "y"}
    if any(name == "y" for name, _ in split):  # then sigma_xy is a stress in a body, not a traction
        names |= _OF_FIELDS
    else:
        names = _OF_FIELDS | names
    result: dict[int, _Column] = {}
    for place, (name, unit) in enumerate(split):
        stem = name.removesuffix("_" + NOISE).removeprefix(NOISE + "_")
        kind = "" if name == NOISE else names.get(stem)
        if kind is None:
            continue
        is_noise = name == NOISE or stem != name
        scale = None if is_noise and not unit else _scale(table, kind, unit)
        column = _Column(kind, scale, is_noise)
        if any((one.kind, one.is_noise) == (kind, is_noise) for one in result.values()):
            raise DataFileError(
                f"{table.path}, line {table.line}: two columns are {table.names[place]}; "
                "rename one."
            )
        result[place] = column
    return result


def _split(name: str) -> tuple[str, str]:
    """Split a column's name into its words, in lower case and joined by _, and its unit."""
    match = _UNIT.match(name.strip())
    pure, unit = match.groups() if match else (name, "")
    return re.sub(r"[\s\-.:]+", "_", pure.strip().lower()), unit


def gauge_unit(name: str, dimension: str) -> float | None:
    """Return the size of a unit of a gauge; None if it is not known.  Strain has its own names."""
    if dimension == "1":
        return PARTS_OF_ONE.get(name.lower())
    return si_size(name, dimension)


def _scale(table: Table, kind: str, unit: str) -> float:
    """Return the factor that converts numbers of a unit to SI units."""
    dimensions = _dimensions(kind)
    if any(names_no_unit(unit, dimension) for dimension in dimensions):
        return 1.0
    sizes = (gauge_unit(unit, dimension) for dimension in dimensions)
    size = next((one for one in sizes if one is not None), None)
    if dimensions == ("1",):
        examples = ", ".join(filter(None, PARTS_OF_ONE))
    else:
        examples = ", ".join(EXAMPLES[dimension] for dimension in dimensions)
    if size is None:
        raise DataFileError(
            f"{table.path}, line {table.line}: {unit!r} is no known unit of {kind or NOISE}; write "
            f"one, such as {examples}, or none for that of the scene."
        )
    return size


def _dimensions(kind: str) -> tuple[str, ...]:
    """Dimensions that a column may have; noise of all quantities may have any that has units."""
    if not kind:
        return tuple(EXAMPLES)
    places = {"t": "time", "x": "length", "y": "length"}
    return (places.get(kind) or QUANTITIES.get(kind) or dimension_of(kind),)


def _of_table(table: Table, noise: Mapping[str, float]) -> Iterator[_Made]:
    """Yield a maker and the quantity of each gauge of a table."""
    said = {(one.kind, one.is_noise): (place, one) for place, one in _columns(table).items()}
    columns = {
        key: (1.0 if one.scale is None else one.scale) * table.rows[:, place]
        for key, (place, one) in said.items()
    }
    t, x = columns["t", False], columns["x", False]
    y = columns.get(("y", False), np.full(len(t), np.nan))
    quantities = [kind for kind, is_noise in columns if kind in QUANTITIES and not is_noise]
    if not quantities:
        raise DataFileError(
            f"{table.path} has no column of {', '.join(INTERFACE)}, nor of vx, ux, sxx, exx and "
            f"their like; it has {', '.join(table.names)}."
        )
    places = sorted({pair for pair in zip(x.tolist(), _listed(y), strict=True)}, key=_order)
    for quantity in quantities:
        values = columns[quantity, False]
        of_noise = next((key for key in ((quantity, True), ("", True)) if key in columns), None)
        error = None
        if of_noise is not None:
            same_unit = said[of_noise][1].scale is None
            unit = said[quantity, False][1].scale if same_unit else 1.0
            error = (unit or 1.0) * columns[of_noise]
        for at_x, at_y in places:
            here = (x == at_x) & (np.isnan(y) if at_y is None else y == at_y)
            here &= np.isfinite(t) & np.isfinite(values)
            if not here.any() or (quantity in FIELDS) != (at_y is not None):
                continue
            known = None if error is None else error[here]
            sample = t[here], values[here], known
            yield _maker(table.path, quantity, (at_x, at_y), sample, noise), quantity


def _listed(y: Array) -> list[float | None]:
    return [None if np.isnan(one) else one for one in y.tolist()]


def _order(place: tuple[float, float | None]) -> tuple[float, float]:
    x, y = place
    return x, -np.inf if y is None else y


def _of_records(path: Path, noise: Mapping[str, float]) -> Iterator[_Made]:
    """Yield a maker and the quantity of each gauge in files that `slipfront validate` reads."""
    for records in read_records([path], ReadingOptions()):
        for record in records.stations:
            for quantity, values in record.values.items():
                here = np.isfinite(values)
                if here.any() and record.x > 0:
                    sample = record.t[here], values[here], None
                    yield _maker(path, quantity, (record.x, None), sample, noise), quantity


def _maker(
    path: Path,
    quantity: str,
    place: tuple[float, float | None],
    sample: tuple[Array, Array, Array | None],
    noise: Mapping[str, float],
) -> Callable[[str], Gauge]:
    """Return a function that makes a gauge of a given name.

    Samples are sorted by time; of samples at the same time the last one counts.
    """
    t, values, error = sample
    order = np.argsort(t, kind="stable")
    order = order[np.append(np.diff(t[order]) > 0, True)]
    known: Array | float | None = noise.get(quantity, noise.get("")) if error is None else error
    if known is None:
        raise DataFileError(
            f"{path} does not say how exact its {quantity} is; add a column {NOISE} of standard "
            f"deviations, or give --noise {quantity}=NUMBER, with a unit if the file names one."
        )
    if error is None:  # then the number that was given is to blame, not the file
        checked_noise(known, values[order])
    spread: float | Array = known if isinstance(known, float | int) else known[order]

    def make(name: str) -> Gauge:
        try:
            return Gauge(place[0], t[order], values[order], spread, quantity, place[1], name)
        except SceneError as refusal:
            where = f"x = {place[0]:g}" + ("" if place[1] is None else f", y = {place[1]:g}")
            raise DataFileError(f"{path}, {quantity} at {where}: {refusal}") from refusal

    return make
