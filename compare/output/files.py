"""Files appear under their names only when they are complete."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from semianalytic.results.files import refusal, row_checksum, write_bytes
from semianalytic.scene.errors import DataFileError


def checksum_heading(rows: int) -> str:
    """Heading of the column of checksums in a table of so many rows."""
    return f"checksum of {rows} rows"


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8, whole or not at all.

    Raises
    ------
    DataFileError
        If the file or its folder cannot be written.
    """
    write_bytes(path, text.encode("utf-8"))


def append_text(path: Path, text: str) -> None:
    """Add to a text file, for tables that grow while they are computed.

    A writer that is killed may leave a part of what it added.

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


def write_rows(path: Path, rows: Sequence[Any], checked: bool = False, command: str = "") -> None:
    """Write dataclass instances as CSV, whole or not at all; no rows, no file.

    Parameters
    ----------
    path : Path
    rows : sequence of dataclass instances
    checked : bool
        Whether a last column holds the checksum of each row, for tables that are read back.
    command : str
        What makes the file, for a comment in its first line, as the data of docs have it.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    if not rows:
        return
    stream = io.StringIO(newline="")
    if command:
        stream.write(f"# {command}\n")
    writer = csv.writer(stream, lineterminator="\n")
    heading = [field.name for field in fields(rows[0])]
    writer.writerow([*heading, checksum_heading(len(rows))] if checked else heading)
    writer.writerows(checked_cells(row) if checked else astuple(row) for row in rows)
    write_text(path, stream.getvalue())


def checked_cells(row: Any) -> list[str]:
    """Cells of a dataclass instance as CSV holds them, and their checksum."""
    cells = [str(value) for value in astuple(row)]
    return [*cells, row_checksum(cells)]


def are_sound(cells: Sequence[str]) -> bool:
    """Whether cells that were read back end in their checksum."""
    return len(cells) > 1 and row_checksum(list(cells[:-1])) == cells[-1]
