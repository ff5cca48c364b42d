"""Tables of text: any separator, decimal commas, comments, and what each line is called by."""

from __future__ import annotations

import io
import re
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.bounds import (
    LARGEST_TEXT,
    LONGEST_LINE,
    MOST_SECONDS,
    check_file_size,
    check_numbers,
    content_of,
)

COMMENTS = ("#", "%", "!", "//")
MISSING = {"", "nan", "nan(ind)", "na", "n/a", "none", "null", "?"}
"""Entries that mark a missing number, behind any signs."""
LONGEST_SHOWN = 24
"""Characters of a damaged entry that are quoted."""
MOST_COMMENTS = 10_000
"""Most comments of a file that are kept."""
ROWS_AT_ONCE = 20_000
"""Rows that are parsed together: half as many and twice as many take as long."""

_NUMBER = re.compile(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))(?:[eEdD]([+-]?\d+))?\Z")
_LOST = re.compile(r"([+-]?\d*[.,]\d+)([+-]\d{3})\Z")
"""Fortran leaves out the E where the exponent has three digits."""
_COMMENT = re.compile(rb"^[ \t]*[#%!][^\n]*", re.MULTILINE)
"""Lines of which some codes write all characters, NULs included."""
_TECPLOT = re.compile(r"(TITLE|VARIABLES|ZONE)(?:\s+\w+)?\s*=", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class NamedColumns:
    """Numbers under names."""

    path: Path
    names: tuple[str, ...]  # names of the columns; empty where the file has none
    rows: Array  # NaN where there is no number, (n, k)
    comments: tuple[str, ...]  # without the characters that mark them
    line: int  # that of the names, 0 where there are none


def text_of(path: Path, most: int = LARGEST_TEXT) -> str:
    """All of a text file of so many bytes at most, unpacked if it is gzipped.

    Raises DataFileError if it is not there, not text, a damaged archive, or too large.
    """
    check_file_size(path, most)
    return "\n".join(lines_of(path))


def lines_of(path: Path) -> Iterator[str]:
    """Lines of a text file, unpacked if it is gzipped; raises as `text_of`."""
    yield from _lines(path, *_decodable(path))


def _decodable(path: Path) -> tuple[bytes, str]:
    """All of a text file with LF behind each line, and its encoding."""
    content = content_of(path)
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        try:
            content, encoding = content.decode("utf-16").encode(), "utf-8"
        except UnicodeDecodeError as error:
            reason = f"{path}: a character is not in UTF-16; save it in UTF-8."
            raise DataFileError(reason) from error
    elif b"\0" in (content := _COMMENT.sub(lambda found: found[0].replace(b"\0", b""), content)):
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise DataFileError(
            f"{path}, line {line}: there are bytes that are no text; give a text file, or one "
            "whose name ends as its format does (.npz, .h5, .vtu, .pvd, .xdmf)."
        )
    else:
        encoding = _encoding(path, content)
        content = content.removeprefix(b"\xef\xbb\xbf")
    if b"\n" not in content:
        content = content.replace(b"\r", b"\n")
    return content, encoding


def _lines(path: Path, content: bytes, encoding: str) -> Iterator[str]:
    for number, raw in enumerate(io.BytesIO(content), 1):
        if len(raw) > LONGEST_LINE:
            raise DataFileError(
                f"{path}, line {number} has {len(raw) / 2**20:.0f} MB; write a row of numbers a "
                "line."
            )
        yield raw.decode(encoding).rstrip("\r\n")


def _encoding(path: Path, content: bytes) -> str:
    """UTF-8, or Latin-1 where that is what the characters beyond ASCII look like."""
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        if content[error.start] >= 0xA0:
            return "latin-1"
        line = content[: error.start].count(b"\n") + 1
        raise DataFileError(
            f"{path}, line {line}: a character is not in UTF-8; save the file in UTF-8."
        ) from error
    return "utf-8"


def read_table(path: Path, least: int = 2) -> NamedColumns:
    """The table of a text file, of so many columns at least.

    Raises DataFileError if there are no numbers, or a line does not have as many as the first; the
    message names it.
    """
    content, encoding = _decodable(path)
    reader = _Reader(path, content.count(b"\n"), least)
    for number, raw in enumerate(_lines(path, content, encoding), 1):
        reader.take(number, raw)
    return reader.table()


class _Reader:
    """Reader of line after line: rows are parsed together, and one by one where that fails."""

    def __init__(self, path: Path, lines: int, least: int) -> None:
        self.path, self.lines, self.least = path, lines, least
        self.comments: list[str] = []
        self.names: tuple[str, ...] = ()
        self.line, self.width = 0, 0
        self.separator: str | None = None
        self.parts: list[Array] = []
        self.waiting: list[tuple[int, str]] = []
        self.end = time.monotonic() + MOST_SECONDS

    def take(self, number: int, raw: str) -> None:
        """A line: a comment, names, or a row."""
        line = raw.strip()
        if not line:
            return
        if line.startswith(COMMENTS):
            if len(self.comments) < MOST_COMMENTS:
                self.comments.append(line.lstrip("#%!/ "))
            return
        if not self.width:
            if self._take_names(number, raw):
                return
            self._begin(number, raw)
        self.waiting.append((number, raw))
        if len(self.waiting) == ROWS_AT_ONCE:
            self._parse()

    def _take_names(self, number: int, raw: str) -> bool:
        """Whether a line before all rows names columns or, below, their units, or is Tecplot's."""
        tecplot = _TECPLOT.match(raw.strip())
        if tecplot is None:
            separator = _separator(raw)
            entries = _split(raw, separator)
        elif tecplot[1].upper() == "VARIABLES":
            separator = None
            entries = re.findall(r'"([^"]*)"', raw)
        else:
            return True
        if any(_is_number(entry) and (entry != "1" or not self.names) for entry in entries):
            return False
        if self.names:
            return self._take_units([entry.strip("[]()\"' ") for entry in entries])
        self.separator = separator
        self.names, self.line = tuple(entry.strip("\"' ") for entry in entries), number
        return True

    def _take_units(self, units: list[str]) -> bool:
        """Whether the line below the names holds units, which then follow the names."""
        pairs = list(zip(self.names, units, strict=False))
        if len(units) != len(self.names) or all(unit.lower() in MISSING for unit in units):
            return False
        self.names = tuple(
            name if unit in ("", "-", "1") or name[-1:] in ("]", ")") else f"{name} [{unit}]"
            for name, unit in pairs
        )
        return True

    def _begin(self, number: int, raw: str) -> None:
        """The first row, which says what separates entries and how many there are."""
        if self.separator is None:
            self.separator = _separator(raw)
        self.width = len(self.names) or len(_split(raw, self.separator))
        if self.width < self.least:
            raise DataFileError(
                f"{self.path}, line {number}: there is one column, and two at least are needed; "
                "put commas, semicolons, tabs or blanks between columns."
            )
        check_numbers(self.path, (self.lines - number) * self.width)

    def _parse(self) -> None:
        """Parse the rows that wait."""
        if time.monotonic() > self.end:
            raise DataFileError(
                f"{self.path} takes longer than {MOST_SECONDS:g} s to read; leave out times or "
                "positions."
            )
        rows = self._together()
        if rows is None:
            rows = np.array([self._row(number, raw) for number, raw in self.waiting])
        self.parts.append(rows)
        self.waiting = []

    def _together(self) -> Array | None:
        """Rows that are numbers and nothing else; None if there is anything else in them."""
        if self.separator not in (None, ",", "\t", ";"):
            return None
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                rows = np.loadtxt(
                    [raw for _, raw in self.waiting],
                    delimiter=self.separator,
                    comments=None,
                    ndmin=2,
                )
        except (ValueError, UserWarning):
            return None
        return rows if rows.shape == (len(self.waiting), self.width) else None

    def _row(self, number: int, raw: str) -> list[float]:
        entries = _split(raw, self.separator)
        if len(entries) == self.width + 1 and not entries[-1]:
            entries.pop()  # a separator behind the last entry
        row = [_value(self.path, number, entry, self.separator) for entry in entries]
        if len(row) != self.width:
            raise DataFileError(
                f"{self.path}, line {number}: there are {len(row)} entries where {self.width} are "
                "expected; write every row in full."
            )
        return row

    def table(self) -> NamedColumns:
        """The table of all lines that were taken."""
        if self.waiting:
            self._parse()
        if not self.parts:
            raise DataFileError(
                f"{self.path} has no row of numbers; give names of columns and rows below them."
            )
        names = self.names or _names_of_comments(self.comments, self.width)
        return NamedColumns(
            self.path, names, np.concatenate(self.parts), tuple(self.comments), self.line
        )


def _names_of_comments(comments: list[str], width: int) -> tuple[str, ...]:
    """Names of the columns, if a comment holds as many words as there are columns."""
    for comment in reversed(comments):
        words = _split(comment, _separator(comment))
        if len(words) == width and not any(map(_is_number, words)):
            return tuple(words)
    return ()


def _separator(line: str) -> str | None:
    for separator in (";", "\t"):
        if separator in line:
            return separator
    if "," in line and not all(map(_is_number, line.split())):
        return ","
    return "," if re.search(r",\s", line) else None


def _split(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return re.split(r"\s+(?![\[(])", line.strip())
    entries = [entry.strip() for entry in line.strip("\r\n ").split(separator)]
    return entries[:-1] if entries[-1] == "" and separator == ";" else entries


def _is_number(text: str) -> bool:
    return bool(_NUMBER.match(text.strip()) or _LOST.match(text.strip()))


def _value(path: Path, line: int, text: str, separator: str | None) -> float:
    text = text.strip().strip("\"'")
    word = text.lower().lstrip("+-")
    if word in MISSING:
        return np.nan
    if word in ("inf", "infinity"):
        return float(text)
    number = _NUMBER.match(text) or _LOST.match(text)
    if not number or ("," in text and separator == ","):
        shown = text if len(text) <= LONGEST_SHOWN else text[:LONGEST_SHOWN] + "..."
        raise DataFileError(f"{path}, line {line}: {shown!r} is not a number; correct that line.")
    return float(f"{number[1].replace(',', '.')}e{number[2] or 0}")
