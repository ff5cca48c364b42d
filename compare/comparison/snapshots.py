"""Field snapshots of a simulation, and the slip rate, read back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.files import check_seal
from semianalytic.scene.errors import DataFileError

if TYPE_CHECKING:
    import meshio

INDEX = "fields.pvd"

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SlipRateProfile:
    """Relative slip rate along the contact at one time.

    Attributes
    ----------
    time : float
        [time].
    x : (n,) array
        Positions on the contact [length], increasing.
    slip_rate : (n,) array
        [length / time].
    """

    time: float
    x: Array
    slip_rate: Array


def last_snapshot(folder: Path, run: str | None = None) -> SlipRateProfile:
    """Slip rate from the velocities of both faces in the last frame of a folder of snapshots.

    Parameters
    ----------
    folder : Path
        Holds ``fields.pvd`` and the frames it lists.
    run : str, optional
        Identity of the simulation the frame must be of; any unless given.

    Raises
    ------
    DataFileError
        If the index or its last frame is missing, damaged, of another run, or not of two blocks
        in contact.
    """
    time, path = listed_frames(folder, run)[-1]
    with frame_mesh(path) as frame:
        (cells,) = frame.cells
        along = 2 if "sigma_yz" in frame.cell_data else 0  # z in antiplane shear
        velocity = frame.point_data["velocity"][:, along]
        above = frame.points[cells.data, 1].mean(axis=1) > 0
        upper, lower = (_contact(frame.points, cells.data[side]) for side in (above, ~above))
        slip_rate = velocity[upper] - velocity[lower]
    if not np.isfinite(slip_rate).all():
        raise DataFileError(f"{path} holds values that are not finite; simulate again.")
    return SlipRateProfile(time, frame.points[upper, 0], slip_rate)


def listed_frames(folder: Path, run: str | None = None) -> list[tuple[float, Path]]:
    """Times [time] and files of the frames that the index of a folder of snapshots lists, in order.

    Parameters
    ----------
    folder : Path
    run : str, optional
        Identity of the simulation that index and last frame must be of; any unless given.

    Raises
    ------
    DataFileError
        If the index is missing, damaged or of another run, or lists nothing.
    """
    from fem.snapshots import frame_run, index_run

    index = folder / INDEX
    try:
        check_seal(index)
        entries = [
            (float(entry.attrib["timestep"]), folder / entry.attrib["file"])
            for entry in ElementTree.parse(index).getroot().iter("DataSet")
        ]
        if not all(math.isfinite(time) for time, _ in entries):
            raise ValueError("times that are not finite")
        _, last = entries[-1]
    except (OSError, ElementTree.ParseError, IndexError, KeyError, ValueError) as error:
        raise DataFileError(
            f"{index} lists no snapshot that can be read; simulate again."
        ) from error
    if run is not None and not index_run(folder) == run == frame_run(last):
        raise DataFileError(
            f"the snapshots in {folder} are not of the simulation beside them but of another run; "
            "simulate again, or leave them out with --no-snapshots."
        )
    return entries


@contextmanager
def frame_mesh(path: Path) -> Iterator[meshio.Mesh]:
    """The mesh and fields of a frame.

    Raises
    ------
    DataFileError
        If the file is missing or damaged, or what is taken from it here is not there.
    """
    import meshio

    try:
        check_seal(path)
        yield meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio raises bare exceptions, and exits on some
        raise DataFileError(f"{path} cannot be read as a snapshot; simulate again.") from error


def _contact(points: Array, cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Nodes of one block on y = 0, x > 0, by increasing x."""
    nodes = np.unique(cells)
    x, y = points[nodes, 0], points[nodes, 1]
    size = np.ptp(points[cells[0], 0])
    chosen = nodes[(np.abs(y) < 1e-6 * size) & (x > 1e-6 * size)]
    return chosen[np.argsort(points[chosen, 0])]
