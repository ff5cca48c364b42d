"""Meshes with fields as records: motion of the two faces of the interface, or fields on it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from compare.records.names import Columns, known_columns, named_unit
from compare.records.record import ReadingOptions, Records, Stated, Unit
from compare.records.stations import joined_faces, stations_of_grid
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.bounds import MOST_FILES, check_file_size, content_of, parsing

VECTORS = {"velocity": "velocity v vel velo", "displacement": "displacement u disp displ"}
"""Names of vectors at nodes, in lower case."""
ON_INTERFACE = 1e-9
"""Distance from y = 0, over the size of the mesh, within which a node is on the interface."""
_EMPTY = re.compile(rb"<!DOCTYPE[^\[<>]*(\[\s*\])?\s*>")
"""A document type that defines nothing, as most codes write it; that of a name is not fetched."""
HEAD = 2**16
"""Bytes of a file of XML in which a document type would stand."""
Frame = tuple[float, Any]
"""Time, and a mesh with fields."""


def read_bodies(path: Path, options: ReadingOptions) -> Records:
    """Records of frames: one PVD or XDMF file, with motion of faces at y = 0 or fields there."""
    frames = sorted(_frames(path), key=lambda frame: frame[0])
    if len(frames) < 2:
        raise DataFileError(f"{path} has {len(frames)} frames; a record needs at least two.")
    times, rows = [], []
    notes: list[str] = []
    stated = Stated()
    unread: tuple[str, ...] = ()
    x: Array | None = None
    for time, mesh in frames:
        here, values, stated, notes, unread = _interface(path, mesh, options)
        if x is not None and not np.array_equal(x, here):
            raise DataFileError(f"{path}: frames are on different meshes; give them on one.")
        x = here
        times.append(time)
        rows.append(values)
    assert x is not None
    names = set.intersection(*(set(row) for row in rows))
    values = {name: np.array([row[name] for row in rows]) for name in sorted(names)}
    x = x - options.origin
    stations, mended = stations_of_grid(path, x, np.array(times), values)
    spacing = float(np.median(np.diff(x))) if len(stations) > 1 else None
    notes = [*notes, *mended]
    return Records(stations, None, str(path), tuple(notes), spacing, stated, unread=unread)


def _frames(path: Path) -> Iterator[Frame]:
    suffix = path.suffix.lower()
    if suffix == ".pvd":
        for time, piece in _pieces(path):
            yield time, _mesh(piece)
    elif suffix in (".xdmf", ".xmf"):
        import meshio

        _check_entities(path, content_of(path))
        with meshio.xdmf.TimeSeriesReader(path) as reader:
            points, cells = reader.read_points_cells()
            for step in range(reader.num_steps):
                time, point_data, _ = reader.read_data(step)
                yield float(time), meshio.Mesh(points, cells, point_data=point_data)
    else:
        raise DataFileError(
            f"{path} is one frame and does not say its time; give the .pvd or .xdmf file of all."
        )


def _pieces(path: Path) -> Iterator[tuple[float, Path]]:
    """Times and files of a PVD file."""
    content = content_of(path)
    _check_entities(path, content)
    root = ElementTree.fromstring(content)
    for number, entry in enumerate(root.iter("DataSet")):
        if number == MOST_FILES:
            raise DataFileError(f"{path} has more than {MOST_FILES} frames; leave some out.")
        try:
            yield float(entry.attrib["timestep"]), path.parent / entry.attrib["file"]
        except (KeyError, ValueError):
            raise DataFileError(
                f"{path}: a DataSet lacks its timestep or file; write both for every frame."
            ) from None


def _check_entities(path: Path, content: bytes) -> None:
    """Refuse XML that defines entities, of which a few lines may unfold to gigabytes."""
    if re.search(rb"<!(DOCTYPE|ENTITY)", _EMPTY.sub(b"", content.replace(b"\0", b""))):
        raise DataFileError(f"{path} defines entities of XML; write it without a document type.")


def _mesh(path: Path) -> Any:
    import meshio

    check_file_size(path)
    with path.open("rb") as stream:
        _check_entities(path, stream.read(HEAD))
    with parsing(path):
        return meshio.read(path)


def _interface(
    path: Path, mesh: Any, options: ReadingOptions
) -> tuple[Array, dict[str, Array], Stated, list[str], tuple[str, ...]]:
    """Positions along the interface, quantities there, what they are, and fields not read."""
    points = np.asarray(mesh.points, dtype=float)
    scalars = {
        name: np.asarray(value, dtype=float)
        for name, value in mesh.point_data.items()
        if np.ndim(value) == 1
    }
    told = {name: column for name, column in options.columns.items() if name not in VECTORS}
    known = known_columns(path, list(scalars), told)
    columns = {
        name: scalars[list(scalars)[i]] * known.scale(name)
        for name, i in known.places.items()
        if name not in ("t", "x")
    }
    on = np.abs(points[:, 1]) <= ON_INTERFACE * np.ptp(points, axis=0).max()
    if on.all() and columns:
        values, stated, more = joined_faces(columns, known)
        order = np.argsort(points[:, 0], kind="stable")
        ordered = {name: value[order] for name, value in values.items()}
        unread = tuple(name for name in mesh.point_data if name not in scalars) + known.unread
        return points[order, 0], ordered, stated, [*known.notes, *more], unread
    upper, lower = _faces(path, mesh, points, on)
    motion: dict[str, Array] = {}
    units: dict[str, Unit] = {}
    guesses: dict[str, str] = {}
    fields = ", ".join(mesh.point_data) or "none"
    for kind, aliases in VECTORS.items():
        name = options.columns.get(kind) or _called(aliases, mesh.point_data)
        if name is None:
            continue
        if name not in mesh.point_data:
            raise DataFileError(f"{path} has no field {name!r} at nodes; choose among {fields}.")
        field = np.asarray(mesh.point_data[name], dtype=float)
        along = field[:, 0] if field.ndim == 2 else field
        unit = named_unit(path, name, f"{kind}_upper")
        for side, face in (("upper", upper), ("lower", lower)):
            if len(face):
                motion[f"{kind}_{side}"] = along[face] * (unit.size if unit else 1.0)
                units |= {f"{kind}_{side}": unit} if unit else {}
        guesses[name] = f"{kind} is the field {name!r}"
    if not motion:
        raise DataFileError(
            f"{path} has no field of velocity or displacement among {fields}; say velocity=NAME."
        )
    values, stated, more = joined_faces(motion, Columns({}, units))
    unread = tuple(name for name in mesh.point_data if name not in guesses)
    notes = [*guesses.values(), *more]
    return points[upper if len(upper) else lower, 0], values, stated, notes, unread


def _called(aliases: str, fields: Mapping[str, Any]) -> str | None:
    """The field whose name, in lower case and without units, is one of the aliases."""
    for name in fields:
        if name.lower().split("[")[0].split("(")[0].strip() in aliases.split():
            return name
    return None


def _faces(path: Path, mesh: Any, points: Array, on: Array) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of the upper and of the lower face, by position; one of them may be empty."""
    above, below = np.zeros(len(points), dtype=bool), np.zeros(len(points), dtype=bool)
    for block in mesh.cells:
        if block.dim < 2:
            continue
        middle = points[block.data, 1].mean(axis=1)
        above[block.data[middle > 0].ravel()] = True
        below[block.data[middle < 0].ravel()] = True
    upper, lower = np.flatnonzero(on & above & ~below), np.flatnonzero(on & below & ~above)
    upper, lower = (face[np.argsort(points[face, 0], kind="stable")] for face in (upper, lower))
    if not len(upper) and not len(lower):
        raise DataFileError(
            f"{path} has no two faces at y = 0: nodes there belong to both bodies, or there are "
            "none; split them along the interface, or put it at y = 0."
        )
    if len(upper) and len(lower):
        both = np.intersect1d(points[upper, 0], points[lower, 0])
        upper, lower = (face[np.isin(points[face, 0], both)] for face in (upper, lower))
        if len(upper) != len(lower) or not len(upper):
            raise DataFileError(f"{path}: nodes of the two faces do not coincide.")
    return upper, lower
