"""Reading of the field snapshots of a simulation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from semianalytic.results.files import check_seal
from semianalytic.scene.errors import DataFileError

if TYPE_CHECKING:
    import meshio

INDEX = "fields.pvd"


def listed_frames(folder: Path, run: str | None = None) -> list[tuple[float, Path]]:
    """Times [time] and files of the frames that the index of a folder of snapshots lists, in order.

    Index and last frame must belong to a run, any by default; else, or if the index is missing,
    damaged or empty, a DataFileError is raised.
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
            f"the snapshots in {folder} are not of its simulation but of another run; "
            "simulate again, or leave them out with --no-snapshots."
        )
    return entries


@contextmanager
def frame_mesh(path: Path) -> Iterator[meshio.Mesh]:
    """The mesh and fields of a frame; DataFileError if it is damaged or lacks what is read."""
    import meshio

    try:
        check_seal(path)
        yield meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio raises bare exceptions, and exits on some
        raise DataFileError(f"{path} cannot be read as a snapshot; simulate again.") from error
