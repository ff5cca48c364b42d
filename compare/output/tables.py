"""Rows of studies as CSV, with checksums if they are read back, and tables in Markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, TypeVar

from compare.output.files import write_text
from semianalytic.results.files import row_checksum
from semianalytic.scene.errors import DataFileError

Row = TypeVar("Row")
Parser = Callable[[str], Any]

PARSERS: dict[str, Parser] = {"int": int, "float": float, "str": str, "bool": "True".__eq__}
"""Functions that parse cells, by the type of their field."""


def write_rows(path: Path, rows: Sequence[Any], checked: bool = False, command: str = "") -> None:
    """Write dataclass instances as CSV, completely or not at all; without rows, write no file.

    Parameters
    ----------
    path : Path
    rows : sequence of dataclass instances
    checked : bool
        Whether a last column contains the checksum of each row, for tables that are read back.
    command : str
        Command that makes the file, written as a comment in its first line.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    if not rows:
        return
    heading = _names(type(rows[0])) + ([_checksum_heading(len(rows))] if checked else [])
    cells = (_checked_cells(row) if checked else astuple(row) for row in rows)
    write_text(path, (f"# {command}\n" if command else "") + _csv_text([heading, *cells]))


def read_rows(path: Path, kind: type[Row], what: str, command: str) -> list[Row]:
    """Read the rows of a table written with checksums; return none if there is no file.

    Parameters
    ----------
    path : Path
    kind : dataclass
        Type of the rows.
    what : str
        Description of the table for error messages, such as "a chart".
    command : str
        Command that the first line of the file must name.

    Raises
    ------
    DataFileError
        If the file is damaged or contains another table.
    """
    if not path.exists():
        return []
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            if stream.readline().strip() != f"# {command}":
                raise ValueError("another first line")
            heading, *rows = csv.reader(stream, strict=True)
        if heading != [*_names(kind), _checksum_heading(len(rows))]:
            raise ValueError("unknown columns or lost rows")
        damaged = [number for number, cells in enumerate(rows, start=3) if not _sound(cells)]
        if damaged:
            raise ValueError(f"row {damaged[0]} does not fit its checksum")
        return [_parsed(kind, cells) for cells in rows]
    except (OSError, ValueError, csv.Error) as error:
        raise DataFileError(
            f"{path} cannot be read as {what} ({error}); move it away to measure again."
        ) from error


def markdown_table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of texts in Markdown, ending in a newline."""
    lines = (heading, ["---"] * len(heading), *rows)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _names(kind: Any) -> list[str]:
    return [field.name for field in fields(kind)]


def _checksum_heading(rows: int) -> str:
    return f"checksum of {rows} rows"


def _checked_cells(row: Any) -> list[str]:
    """Return the cells of a dataclass instance as CSV holds them, followed by their checksum."""
    cells = [str(value) for value in astuple(row)]
    return [*cells, row_checksum(cells)]


def _sound(cells: Sequence[str]) -> bool:
    """Return whether cells that were read back end in their checksum."""
    return len(cells) > 1 and row_checksum(list(cells[:-1])) == cells[-1]


def _parsed(kind: type[Row], cells: Sequence[str]) -> Row:
    """Return the row that cells with a checksum stand for."""
    kinds = fields(kind)  # type: ignore[arg-type]
    return kind(
        *(PARSERS[str(field.type)](cell) for field, cell in zip(kinds, cells[:-1], strict=True))
    )


def _csv_text(rows: Iterable[Sequence[Any]]) -> str:
    stream = io.StringIO(newline="")
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()
