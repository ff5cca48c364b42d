"""Output paths: checks before anything is computed, whole files, locks against other runs."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from semianalytic.results.files import discard, make_folder, remove_empty, try_lock, write_bytes
from semianalytic.scene.errors import DataFileError, SceneError

LOCK = ".slipfront.lock"


def check_file(path: Path) -> None:
    """Check that a file can be written, and leave nothing behind; SceneError if the path exists and
    is no file, DataFileError if it cannot be written."""
    try:
        if path.exists() and not path.is_file():
            kind = "a folder" if path.is_dir() else "not an ordinary file"
            raise SceneError(f"{path} is {kind}; give the name of a file.")
        _probe(path.parent)
    except OSError as error:
        raise _refused(path, error) from error


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8, completely or not at all; raises as `write_bytes`."""
    write_bytes(path, text.encode("utf-8"))


@contextmanager
def working_folder(directory: Path) -> Iterator[list[Path]]:
    """Open an output folder, made if necessary, that no other run can write to meanwhile.

    The lock ends with the process, however that ends.  A folder made here is removed if it stays
    empty.  The list is empty at first; at the end it has the files and folders that are new or have
    changed.  DataFileError if it is not a folder, cannot be written, or is in use by another run.
    """
    made: list[Path] = []
    try:
        if directory.exists() and not directory.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, "it is not a folder")
        made, lock = _locked(directory)
    except OSError as error:
        raise _refused(directory, error) from error
    before, written = _marks(directory), list[Path]()
    try:
        yield written
        written += [path for path, mark in _marks(directory).items() if before.get(path) != mark]
    finally:
        still_there = False
        with suppress(OSError):
            still_there = _is_still_there(lock, directory)
        if still_there:
            discard(directory / LOCK, lock)
        else:
            os.close(lock)
        remove_empty(made)


def _marks(directory: Path) -> dict[Path, tuple[int, int, int]]:
    """Return identity, time and size of each visible entry of a folder, in order of paths."""
    marks = {}
    with suppress(OSError):  # some folders can be written but not listed
        for path in sorted(directory.glob("[!.]*")):
            seen = path.lstat()
            marks[path] = (seen.st_ino, seen.st_mtime_ns, seen.st_size)
    return marks


def _locked(directory: Path) -> tuple[list[Path], int]:
    """Lock a folder; return the folders made for it, innermost first, and the lock's descriptor."""
    made: list[Path] = []
    while True:
        made = made or make_folder(directory)
        try:
            lock = os.open(directory / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            if error.errno == errno.ENOENT and not directory.exists():
                made = []  # another run has just removed the folders that it had made
                continue
            remove_empty(made)
            raise
        if not try_lock(lock):
            os.close(lock)
            raise DataFileError(
                f"another run is writing to {directory}; wait for it or give another --output."
            )
        with suppress(OSError):
            if _is_still_there(lock, directory):
                return made, lock
        os.close(lock)  # an earlier run has just removed this lock file


def _is_still_there(lock: int, directory: Path) -> bool:
    """Return whether an open lock is the lock file that the folder contains now."""
    return os.path.samestat(os.fstat(lock), (directory / LOCK).stat())


def save_somewhere(save: Callable[[Path], object], place: Path, name: str = "") -> None:
    """Save a result by a function of a path; if it cannot, save it in a temporary folder.

    There it has the name given, and a DataFileError says where it is.
    """
    try:
        save(place)
    except DataFileError as error:
        spare = Path(tempfile.mkdtemp(prefix="slipfront-"))
        try:
            save(spare / name)
        except DataFileError:
            remove_empty([spare])
            raise error from None
        raise DataFileError(
            f"{str(error).rstrip('.')}; the result is kept in {spare / name} instead."
        ) from error


def _probe(folder: Path) -> None:
    """Make and remove a file in a folder, or in the parent that the folder would be made in."""
    for place in (folder, *folder.parents):
        if place.exists():
            if not place.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, f"{place} is not a folder")
            descriptor, probe = tempfile.mkstemp(prefix=".", suffix=".part", dir=place)
            os.close(descriptor)
            os.unlink(probe)
            return


def _refused(path: Path, error: OSError) -> DataFileError:
    return DataFileError(f"Cannot write {path}: {error.strerror or error}.")
