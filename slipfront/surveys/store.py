"""Storage of the chunks of a survey until it is complete."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from compare.output.places import working_folder, write_text
from semianalytic.results.files import Seal, check_seal, write_bytes
from semianalytic.scene.errors import DataFileError
from slipfront.surveys.plan import SurveyPlan

_PLAN = "survey.json"


class Store:
    """A folder of finished chunks of one survey, each a file with a checksum."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def _path(self, index: int) -> Path:
        return self._folder / f"{index:08d}.npz"

    def keep(self, index: int, data: bytes) -> None:
        """Write a chunk to the disk; raises as `write_bytes`."""
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
    """Return the folder next to the file of a survey that keeps its chunks until it is complete."""
    return path.with_name(f".{path.name}.survey")


@contextmanager
def opened_store(path: Path, plan: SurveyPlan) -> Iterator[Store]:
    """Open the store of a survey that will become a file, for one run at a time; DataFileError if
    it cannot be written, another run uses it, or it holds another survey."""
    folder = store_folder(path)
    with working_folder(folder):
        _check(folder, plan)
        yield Store(folder)
    with suppress(OSError):
        folder.rmdir()


def _check(folder: Path, plan: SurveyPlan) -> None:
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
            f"{folder} holds part of another survey; repeat that one to continue it, give "
            "another path, or remove that folder."
        )
