"""Files appear under their names only when they are complete."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from semianalytic.errors import DataFileError


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file beside `path`, then rename it to `path`.

    Missing folders are created; what `path` held before stays until the new file is complete.

    Raises
    ------
    DataFileError
        If the file or its folder cannot be written.
    """
    part = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write(part)
        os.replace(part, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise DataFileError(f"Cannot write {path}: {reason}.") from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8, whole or not at all.

    Raises
    ------
    DataFileError
        If the file or its folder cannot be written.
    """
    write_whole(path, lambda part: part.write_text(text, encoding="utf-8"))
