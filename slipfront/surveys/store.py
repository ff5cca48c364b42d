"""Storage of the chunks of a survey until it is complete, and the checksums of a Zarr store."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from compare.output.files import write_text
from compare.output.places import working_folder
from semianalytic.results.files import Seal, check_seal, write_bytes
from semianalytic.scene.errors import DataFileError
from slipfront.surveys.plan import Plan

_PLAN = "survey.json"
_SUMS = "sha256.txt"
"""File of checksums in a Zarr store; readers of Zarr ignore it, ``sha256sum -c`` checks it."""


class Store:
    """A folder of finished chunks of one survey, each a file with a checksum."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def _path(self, index: int) -> Path:
        return self._folder / f"{index:08d}.npz"

    def keep(self, index: int, data: bytes) -> None:
        """Write a chunk to the disk.

        Raises
        ------
        DataFileError
            If it cannot be written.
        """
        write_bytes(self._path(index), data, Seal.TRAILING)

    def read(self, index: int) -> bytes | None:
        """Return a chunk, or None if it is missing or damaged."""
        path = self._path(index)
        try:
            check_seal(path)
            return path.read_bytes()
        except (OSError, ValueError):
            return None

    def clear(self) -> None:
        """Remove everything that was kept."""
        for path in (*self._folder.glob("*.npz"), self._folder / _PLAN):
            with suppress(OSError):
                path.unlink(missing_ok=True)


def store_folder(path: Path) -> Path:
    """Return the folder beside the file of a survey that keeps its chunks until it is complete."""
    return path.with_name(f".{path.name}.survey")


def seal_folder(folder: Path) -> None:
    """Write the checksums of all files of a folder into one more file.

    Raises
    ------
    DataFileError
        If it cannot be written.
    """
    write_text(folder / _SUMS, "".join(f"{sum_}  {name}\n" for name, sum_ in _sums(folder)))


def check_folder(folder: Path) -> None:
    """Check that a folder holds exactly the files that were sealed, unchanged.

    Raises
    ------
    OSError
        If a file cannot be read.
    ValueError
        If a file or the checksums are damaged or missing.
    """
    lines = (folder / _SUMS).read_text(encoding="utf-8").splitlines()
    known = {line[_DIGITS + 2 :]: line[:_DIGITS] for line in lines}
    wrong = [name for name, sum_ in _sums(folder) if known.pop(name, sum_) != sum_]
    for name in (*wrong, *known):
        raise ValueError(f"the checksum of {name} does not fit what it holds: it is damaged")


_DIGITS = 64


def _sums(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield name and SHA-256 of each file of a folder, in the order of names."""
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != _SUMS:
            with path.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256")
            yield path.relative_to(folder).as_posix(), digest.hexdigest()


@contextmanager
def opened_store(path: Path, plan: Plan) -> Iterator[Store]:
    """Open the store of a survey that will become a file, for one run at a time.

    Raises
    ------
    DataFileError
        If it cannot be written, another run uses it, or it holds another survey.
    """
    folder = store_folder(path)
    with working_folder(folder):
        _check(folder, plan)
        yield Store(folder)
    with suppress(OSError):
        folder.rmdir()


def _check(folder: Path, plan: Plan) -> None:
    """Check that a folder belongs to this survey; record the survey in a new folder."""
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
