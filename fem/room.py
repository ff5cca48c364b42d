"""Whether there is a place to write to, and room in it, found out before a run."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from semianalytic.results.files import make_folder, refusal, remove_empty
from semianalytic.scene.errors import DataFileError


def free_space(folder: Path) -> int:
    """Free space on the disk of a folder, which need not be there yet [bytes]."""
    place = folder.absolute()
    while not place.exists():
        place = place.parent
    return shutil.disk_usage(place).free


def check_room(path: Path, needed: int, parts: str, freed: int = 0) -> None:
    """Refuse to start what cannot be written, or will find no room.

    Parameters
    ----------
    path : Path
        A file that is going to be written.
    needed : int
        What that file and others beside it are going to take [bytes].
    parts : str
        What they are: the subject of the sentence.
    freed : int
        What will be removed from the disk first [bytes].

    Raises
    ------
    DataFileError
        If the folder cannot be written to, or has too little room.
    """
    folder = path.absolute().parent
    made: list[Path] = []
    try:
        made = make_folder(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise DataFileError(refusal(path, error, needed)) from error
    finally:
        remove_empty(made)
    free = free_space(folder) + freed
    if needed > free:
        raise DataFileError(
            f"{parts} need about {needed / 1e6:,.1f} MB in {folder}, and {free / 1e6:,.1f} MB are "
            "free; make room, choose another folder, or write fewer snapshots or steps."
        )
