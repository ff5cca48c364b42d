"""Rows of a study as CSV, with checksums where they are read back, and texts as Markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, TypeVar

from compare.output.files import append_text, write_text
from semianalytic.results.files import row_checksum
from semianalytic.scene.errors import DataFileError

Row = TypeVar("Row")
Parser = Callable[[str], Any]

PARSERS: dict[str, Parser] = {"int": int, "float": float, "str": str, "bool": "True".__eq__}
"""How cells are read back, by the type of their field."""


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
    heading = _names(type(rows[0])) + ([_checksum_heading(len(rows))] if checked else [])
    cells = (_checked_cells(row) if checked else astuple(row) for row in rows)
    write_text(path, (f"# {command}\n" if command else "") + _csv_text([heading, *cells]))


def read_rows(path: Path, kind: type[Row], what: str, command: str) -> list[Row]:
    """Rows of a table written with checksums; none if there is no file.

    Parameters
    ----------
    path : Path
    kind : dataclass
    what : str
        What the table is, for the error: "a chart".
    command : str
        What its first line says has made it.

    Raises
    ------
    DataFileError
        If the file is damaged or another table.
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


def append_rows(path: Path, rows: Sequence[Any]) -> None:
    """Add rows with their checksums to a table that grows while it is computed.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    append_text(path, _csv_text(map(_checked_cells, rows)))


def sound_rows(path: Path, kind: type[Row]) -> list[Row]:
    """Whole rows of a growing table, which a killed run may have left damaged; none if none."""
    if not path.exists():
        return []
    lines = path.read_bytes().decode("utf-8", "replace").splitlines()
    rows = (next(csv.reader([line]), []) for line in lines)
    return [
        _parsed(kind, cells)
        for cells in rows
        if len(cells) == len(_names(kind)) + 1 and _sound(cells)
    ]


def started_rows(path: Path, kind: type[Row]) -> list[Row]:
    """Whole rows of a table that grows; its heading is written if there is no table."""
    if not path.exists():
        write_text(path, ",".join([*_names(kind), "checksum"]) + "\n")
    return sound_rows(path, kind)


def markdown_table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of texts in Markdown, with a line end."""
    lines = (heading, ["---"] * len(heading), *rows)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _names(kind: Any) -> list[str]:
    return [field.name for field in fields(kind)]


def _checksum_heading(rows: int) -> str:
    return f"checksum of {rows} rows"


def _checked_cells(row: Any) -> list[str]:
    """Cells of a dataclass instance as CSV holds them, and their checksum."""
    cells = [str(value) for value in astuple(row)]
    return [*cells, row_checksum(cells)]


def _sound(cells: Sequence[str]) -> bool:
    """Whether cells that were read back end in their checksum."""
    return len(cells) > 1 and row_checksum(list(cells[:-1])) == cells[-1]


def _parsed(kind: type[Row], cells: Sequence[str]) -> Row:
    """A row from its cells and their checksum."""
    kinds = fields(kind)  # type: ignore[arg-type]
    return kind(
        *(PARSERS[str(field.type)](cell) for field, cell in zip(kinds, cells[:-1], strict=True))
    )


def _csv_text(rows: Iterable[Sequence[Any]]) -> str:
    stream = io.StringIO(newline="")
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()
