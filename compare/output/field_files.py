"""Whole fields: how far pictures of them reach, VTU frames like those of `fem`, and records."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.output.places import write_text
from compare.output.tables import csv_text
from semianalytic.results.derived import strain
from semianalytic.scene.arrays import Array
from semianalytic.scene.units import unit

Fields = Any
"""Answers that hold the fields in both bodies, and those of the contact."""
SHOWN = 4.0
"""Pictures reach at most so many times the shear wave speed, or the speed of the outermost edge.

The P wave lies beyond at Poisson's ratios above 0.467.  At 0.4999 it is 71 times faster than the
shear wave: pictures as far as that show zones on 2 % of their width, ones of twice this on 12 %.
"""
AT_ONCE = 200_000
"""Number of points whose fields are computed together, with 0.4 kB of memory each."""
_AXES = ("xx", "yy", "xy", "xz", "yz")


@dataclass(frozen=True, eq=False)
class FieldRecord:
    """Record of strain gauges and vibrometers at one point."""

    # position [length]; y = 0.0 and -0.0 are the faces of the upper and the lower body
    x: float
    y: float
    t: Array  # (n,) array: times [time]
    # (2 or 3, n) arrays: particle velocity [length / time] and displacement since t = 0 [length]
    velocity: Array
    displacement: Array
    # (3 or 5, n) array: stress, tension positive, including the base state except in sigma_xx
    # [stress]
    stress: Array
    strain: Array  # (3 or 5, n) array: change of strain since t = 0

    def columns(self, units: str) -> Iterator[tuple[str, Array]]:
        """Yield the columns of a table: heading with unit, and values."""
        yield f"t [{unit('time', units)}]", self.t
        for name, place in (("x", self.x), ("y", self.y)):  # `slipfront fit` asks where it was
            yield f"{name} [{unit('length', units)}]", np.full(len(self.t), place)
        for name, rows, dimension, axes in (
            ("v", self.velocity, "length / time", "xyz"),
            ("u", self.displacement, "length", "xyz"),
            ("sigma", self.stress, "stress", _AXES),
            ("eps", self.strain, "1", _AXES),
        ):
            for row, axis in zip(rows, axes, strict=False):
                yield f"{name}_{axis} [{unit(dimension, units)}]", row


def in_parts(field: Callable[[Array, Array, float], Array], x: Array, y: Array, t: float) -> Array:
    """Compute a field at many points (n,) in portions that fit into the memory."""
    count = -(-len(x) // AT_ONCE)
    parts = zip(np.array_split(x, count), np.array_split(y, count), strict=True)
    return np.concatenate([field(*part, t) for part in parts], axis=-1)


def resolved(fields: Any, y: Array) -> Array:
    """Return heights (n,) at which stress is known, moved away from the interface if they must."""
    depth: float = getattr(fields, "nearest_depth", 0.0)
    return np.asarray(np.copysign(np.maximum(np.abs(y), depth), y))


def record_fields(fields: Fields, x: float, y: float, t: Array) -> FieldRecord:
    """Record all fields at a point (x, y) [length] at times t (n,) [time].

    Strain follows from the change of stress since t = 0 by Hooke's law in plane strain.  Where
    stress is infinite, it may be undetermined (nan).
    """
    stress = fields.stress(x, y, t)
    change = stress - fields.stress(x, y, np.zeros(1))
    strained = strain(change, fields.scene.bodies[bool(np.signbit(y))])
    moved = fields.velocity(x, y, t), fields.displacement(x, y, t)
    return FieldRecord(x, y, t, *moved, stress, strained)


def write_record(path: Path, record: FieldRecord, units: str, command: str) -> None:
    """Write a record as CSV in units, completely or not at all; infinite values are written as inf.

    The command that makes the file is a comment in its first line.
    """
    columns = dict(record.columns(units))
    rows = np.stack(list(columns.values()), axis=1).tolist()
    write_text(path, csv_text(columns, rows, command))


def write_frames(
    folder: Path,
    fields: Fields,
    times: Sequence[float],
    window: tuple[float, float, float, float],
    grid: tuple[int, int],
    progress: Callable[[int, int], object] | None = None,
) -> Path:
    """Write fields on a grid for ParaView, one VTU file per time and a PVD index; return its path.

    Data, names and signs are those of `fem.snapshots.Snapshots`: velocity and displacement at
    points, stresses at the centres of cells.  The bodies share no points, so points of the
    interface occur twice, with y = 0.0 and y = -0.0.  Frames of an earlier run are removed.  The
    window x0, x1, y0, y1 [length] has as many cells along x and y as the grid says; `progress` is
    called with (frame, frames) after each.
    """
    import meshio

    from fem.snapshots import INDEX, forget_other_frames, new_frame, write_index

    x, y, cells = grid_of(window, grid)
    middle_x, middle_y = x[cells].mean(axis=1), y[cells].mean(axis=1)
    points = np.stack([x, y, np.zeros_like(x)], axis=1)
    run, frames = secrets.token_hex(8), []
    forget_other_frames(folder, run)
    for number, time in enumerate(times, start=1):
        vectors = {name: np.zeros_like(points) for name in ("displacement", "velocity")}
        for name, vector in vectors.items():
            rows = in_parts(getattr(fields, name), x, y, time)
            vector[:, : len(rows)] = rows.T
        stress = in_parts(fields.stress, middle_x, resolved(fields, middle_y), time)
        tensor = {f"sigma_{axes}": [row] for axes, row in zip(_AXES, stress, strict=False)}
        name = f"fields-{number:04d}.vtu"
        mesh = meshio.Mesh(points, [("quad", cells)], point_data=vectors, cell_data=tensor)
        with new_frame(folder / name, mesh, run):
            frames.append((float(time), name))
        write_index(folder, frames, run)
        if progress is not None:
            progress(number, len(times))
    return folder / INDEX


def grid_of(
    window: tuple[float, float, float, float], grid: tuple[int, int]
) -> tuple[Array, Array, NDArray[np.int64]]:
    """Return points (n,) of all bodies within a window, and the corners (m, 4) of their cells."""
    x0, x1, y0, y1 = window
    along = np.linspace(x0, x1, grid[0] + 1)
    xs, ys, cells, before = [], [], [], 0
    for across in _heights(y0, y1, grid[1]):
        x, y = np.meshgrid(along, across)
        corner = np.arange(x.size).reshape(x.shape)[:-1, :-1].ravel() + before
        wide = len(along)
        cells.append(np.stack([corner, corner + 1, corner + 1 + wide, corner + wide], axis=1))
        xs.append(x.ravel())
        ys.append(y.ravel())
        before += x.size
    return np.concatenate(xs), np.concatenate(ys), np.concatenate(cells)


def _heights(y0: float, y1: float, count: int) -> list[Array]:
    """Return the heights of the rows of points in each body; faces have the sign of their body."""
    if not y0 < 0 < y1:
        return [np.linspace(y0 or 0.0, y1 or -0.0, count + 1)]
    below = min(max(round(count * y0 / (y0 - y1)), 1), count - 1)
    return [np.linspace(y0, -0.0, below + 1), np.linspace(0.0, y1, count - below + 1)]


def shown_speed(fields: Fields, time: float) -> float:
    """Return the distance to which pictures at a time [time] reach, over that time.

    It is the fastest wave, unless everything else stays close to the edge of the slot.
    """
    ends = [zone.end for zone in fields.zones_at(time)]
    ends += [opening.end for opening in fields.openings_at(time)]
    near = [material.shear_speed for material in fields.scene.bodies]
    near += [end / time for end in ends if np.isfinite(end)]
    return min(fields.scene.fastest_speed, SHOWN * max(near))
