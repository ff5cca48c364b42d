"""Files appear under their names only when they are complete."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

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


def write_rows(path: Path, rows: Sequence[Any]) -> None:
    """Write dataclass instances as CSV, whole or not at all; no rows, no file.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    if not rows:
        return

    def write(part: Path) -> None:
        with part.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(field.name for field in fields(rows[0]))
            writer.writerows(astuple(row) for row in rows)

    write_whole(path, write)
