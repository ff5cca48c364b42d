"""Writing of files, which appear under their names only when they are complete."""

from __future__ import annotations

from pathlib import Path

from semianalytic.results.files import write_bytes


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8, completely or not at all.

    Raises
    ------
    DataFileError
        If the file or its folder cannot be written.
    """
    write_bytes(path, text.encode("utf-8"))
