"""Writing of files, which appear under their names only when they are complete."""

from __future__ import annotations

from pathlib import Path

from semianalytic.results.files import refusal, write_bytes
from semianalytic.scene.errors import DataFileError


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8, completely or not at all.

    Raises
    ------
    DataFileError
        If the file or its folder cannot be written.
    """
    write_bytes(path, text.encode("utf-8"))


def append_text(path: Path, text: str) -> None:
    """Append to a text file, for tables that grow while they are computed.

    A writer that is killed may leave an incomplete line.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    data = text.encode("utf-8")
    try:
        with path.open("ab") as stream:
            stream.write(data)
    except OSError as error:
        raise DataFileError(refusal(path, error, len(data))) from error
