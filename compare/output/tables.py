"""Rows of studies as CSV, with checksums if they are read back, and tables in Markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, TypeVar

from compare.output.places import write_text
from semianalytic.results.files import row_checksum
from semianalytic.scene.errors import DataFileError

Row = TypeVar("Row")
Parser = Callable[[str], Any]

PARSERS: dict[str, Parser] = {"int": int, "float": float, "str": str, "bool": "True".__eq__}
"""Functions that parse cells, by the type of their field."""


def write_rows(path: Path, rows: Sequence[Any], checked: bool = False, command: str = "") -> None:
    """Write dataclass instances as CSV, completely or not at all; without rows, write no file.

    A last column holds the checksum of each row if they are `checked`, for tables that are read
    back; the command that makes the file is a comment in its first line.
    """
    if not rows:
        return
    heading = _headings(type(rows[0]), len(rows) if checked else None)
    cells = (_checked_cells(row) if checked else astuple(row) for row in rows)
    write_text(path, csv_text(heading, cells, *([command] if command else [])))


def csv_text(heading: Iterable[str], rows: Iterable[Iterable[Any]], *comments: str) -> str:
    """Return a table as CSV, after lines of comments."""
    stream = io.StringIO(newline="")
    stream.writelines(f"# {comment}\n" for comment in comments)
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(heading)
    table.writerows(rows)
    return stream.getvalue()


def read_rows(path: Path, kind: type[Row], what: str, command: str) -> list[Row]:
    """Read the rows of a table written with checksums; return none if there is no file.

    The first line must name the command.  A file that is damaged or another table is refused by a
    DataFileError, as what it should be, such as "a chart".
    """
    if not path.exists():
        return []
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            if stream.readline().strip() != f"# {command}":
                raise ValueError("another first line")
            heading, *rows = csv.reader(stream, strict=True)
        if heading != _headings(kind, len(rows)):
            raise ValueError("unknown columns or lost rows")
        for number, cells in enumerate(rows, start=3):
            if len(cells) < 2 or row_checksum(cells[:-1]) != cells[-1]:
                raise ValueError(f"row {number} does not fit its checksum")
        parsers = [PARSERS[str(field.type)] for field in fields(kind)]  # type: ignore[arg-type]
        return [
            kind(*(parse(cell) for parse, cell in zip(parsers, cells[:-1], strict=True)))
            for cells in rows
        ]
    except (OSError, ValueError, csv.Error) as error:
        raise DataFileError(
            f"{path} cannot be read as {what} ({error}); move it away to measure again."
        ) from error


def markdown_table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of texts in Markdown, ending in a newline."""
    lines = (heading, ["---"] * len(heading), *rows)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _headings(kind: Any, checked: int | None) -> list[str]:
    """Return the names of fields, and of the checksums if so many rows have any."""
    sums = [] if checked is None else [f"checksum of {checked} rows"]
    return [field.name for field in fields(kind)] + sums


def _checked_cells(row: Any) -> list[str]:
    """Return the cells of a dataclass instance as CSV holds them, followed by their checksum."""
    cells = [str(value) for value in astuple(row)]
    return [*cells, row_checksum(cells)]
