"""Chunks of a survey on the disk, until all of them are there; and the seal of a Zarr store."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from compare.output.files import write_text
from compare.output.places import working_folder
from compare.surveys.plan import Plan
from semianalytic.results.files import Seal, check_seal, write_bytes
from semianalytic.scene.errors import DataFileError

_PLAN = "survey.json"
_SUMS = "sha256.txt"
"""Of a Zarr store, whose readers do not look at it; ``sha256sum -c`` does."""


class Store:
    """A folder of finished chunks of one survey, each a sealed file written whole."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def _path(self, index: int) -> Path:
        return self._folder / f"{index:08d}.npz"

    def keep(self, index: int, data: bytes) -> None:
        """Put a chunk on the disk.

        Raises
        ------
        DataFileError
            If it cannot be written.
        """
        write_bytes(self._path(index), data, Seal.TRAILING)

    def read(self, index: int) -> bytes | None:
        """A chunk; None if it is not there, or damaged."""
        path = self._path(index)
        try:
            check_seal(path)
            return path.read_bytes()
        except (OSError, ValueError):
            return None

    def clear(self) -> None:
        """Remove all that was kept."""
        for path in (*self._folder.glob("*.npz"), self._folder / _PLAN):
            with suppress(OSError):
                path.unlink(missing_ok=True)


def store_folder(path: Path) -> Path:
    """Where the chunks of a survey are kept until it is whole: beside its file."""
    return path.with_name(f".{path.name}.survey")


def seal_folder(folder: Path) -> None:
    """Put the checksums of all files of a folder into one more.

    Raises
    ------
    DataFileError
        If it cannot be written.
    """
    write_text(folder / _SUMS, "".join(f"{sum_}  {name}\n" for name, sum_ in _sums(folder)))


def check_folder(folder: Path) -> None:
    """Raise unless a folder holds the files that it was sealed with, as they were.

    Raises
    ------
    OSError
        If one cannot be read.
    ValueError
        If one is damaged or missing, or the seal is.
    """
    lines = (folder / _SUMS).read_text(encoding="utf-8").splitlines()
    known = {line[_DIGITS + 2 :]: line[:_DIGITS] for line in lines}
    wrong = [name for name, sum_ in _sums(folder) if known.pop(name, sum_) != sum_]
    for name in (*wrong, *known):
        raise ValueError(f"the checksum of {name} does not fit what it holds: it is damaged")


_DIGITS = 64


def _sums(folder: Path) -> Iterator[tuple[str, str]]:
    """Names and SHA-256 of the files of a folder, in the order of names."""
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != _SUMS:
            with path.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256")
            yield path.relative_to(folder).as_posix(), digest.hexdigest()


@contextmanager
def opened_store(path: Path, plan: Plan) -> Iterator[Store]:
    """The store of a survey that is to become a file, for one run at a time.

    Raises
    ------
    DataFileError
        If it cannot be written, another run is at it, or it holds another survey.
    """
    folder = store_folder(path)
    with working_folder(folder):
        _check(folder, plan)
        yield Store(folder)
    with suppress(OSError):
        folder.rmdir()


def _check(folder: Path, plan: Plan) -> None:
    """Make sure that a folder is of this survey; say so in a new one."""
    text = json.dumps(plan.identity, indent=2, sort_keys=True) + "\n"
    try:
        known = (folder / _PLAN).read_text(encoding="utf-8")
    except FileNotFoundError:
        write_text(folder / _PLAN, text)
        return
    except (OSError, ValueError):
        known = ""
    if known != text:
        raise DataFileError(
            f"{folder} holds part of another survey; ask for that one again to go on with it, give "
            "another path, or remove that folder."
        )
