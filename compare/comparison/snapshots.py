"""Slip rate read back from the field snapshots of a simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.files import check_seal
from semianalytic.scene.errors import DataFileError

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
    import meshio

    from fem.snapshots import frame_run, index_run

    index = folder / INDEX
    try:
        check_seal(index)
        entry = list(ElementTree.parse(index).getroot().iter("DataSet"))[-1]
        time, path = float(entry.attrib["timestep"]), folder / entry.attrib["file"]
    except (OSError, ElementTree.ParseError, IndexError, KeyError, ValueError) as error:
        raise DataFileError(
            f"{index} lists no snapshot that can be read; simulate again."
        ) from error
    if run is not None and not index_run(folder) == run == frame_run(path):
        raise DataFileError(
            f"the snapshots in {folder} are not of the simulation beside them but of another run; "
            "simulate again, or leave them out with --no-snapshots."
        )
    try:
        check_seal(path)
        frame = meshio.read(path)
        quads = frame.cells_dict["quad"]
        along = 2 if "sigma_yz" in frame.cell_data else 0  # z in antiplane shear
        velocity = frame.point_data["velocity"][:, along]
        above = frame.points[quads, 1].mean(axis=1) > 0
        upper, lower = (_contact(frame.points, quads[side]) for side in (above, ~above))
        slip_rate = velocity[upper] - velocity[lower]
    except (Exception, SystemExit) as error:  # meshio raises bare exceptions, and exits on some
        raise DataFileError(f"{path} cannot be read as a snapshot; simulate again.") from error
    if not math.isfinite(time) or not np.isfinite(slip_rate).all():
        raise DataFileError(f"{path} holds values that are not finite; simulate again.")
    return SlipRateProfile(time, frame.points[upper, 0], slip_rate)


def _contact(points: Array, quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """Nodes of one block on y = 0, x > 0, by increasing x."""
    nodes = np.unique(quads)
    x, y = points[nodes, 0], points[nodes, 1]
    size = np.ptp(points[quads[0], 0])
    chosen = nodes[(np.abs(y) < 1e-6 * size) & (x > 1e-6 * size)]
    return chosen[np.argsort(points[chosen, 0])]
