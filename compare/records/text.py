"""Tables of text: any separator, decimal commas, comments, and what each line is called by."""

from __future__ import annotations

import gzip
import re
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compare.records.record import Array
from semianalytic.scene.errors import DataFileError

COMMENTS = ("#", "%", "!", "//")
MISSING = {"", "nan", "na", "n/a", "none", "null", "-", "--", "?"}
"""What stands for no number."""
LONGEST_SHOWN = 24
"""Characters of a damaged entry that are quoted."""

_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eEdD][+-]?\d+)?\Z")


@dataclass(frozen=True, eq=False)
class Table:
    """Numbers under names.

    Attributes
    ----------
    path : Path
    names : tuple of str
        Of the columns; empty where the file has none.
    rows : (n, k) array
        NaN where there is no number.
    comments : tuple of str
        Without the characters that mark them.
    line : int
        That of the names, 0 where there are none.
    """

    path: Path
    names: tuple[str, ...]
    rows: Array
    comments: tuple[str, ...]
    line: int


def text_of(path: Path) -> str:
    """All of a text file, unpacked if it is gzipped.

    Raises
    ------
    DataFileError
        If it is not there, not text or a damaged archive.
    """
    try:
        content = path.read_bytes()
        if content[:2] == b"\x1f\x8b":
            content = gzip.decompress(content)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise DataFileError(f"{path} cannot be unpacked ({error}); pack it anew.") from error
    except OSError as error:
        reason = error.strerror or error
        raise DataFileError(f"{path} cannot be read ({reason}); give a file that can.") from error
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encoding = "utf-16"
    elif b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise DataFileError(
            f"{path}, line {line}: there are bytes that are no text; give a text file, or one "
            "whose name ends as its format does (.npz, .h5, .vtu, .pvd, .xdmf)."
        )
    else:
        encoding = "utf-8-sig"
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding == "utf-8-sig" and error.object[error.start] >= 0xA0:
            return content.decode("latin-1")
        line = content[: error.start].count(b"\n") + 1
        raise DataFileError(
            f"{path}, line {line}: a character is not in UTF-8; save the file in UTF-8."
        ) from error


def read_table(path: Path) -> Table:
    """The table of a text file.

    Raises
    ------
    DataFileError
        If there are no numbers, or a line does not have as many as the first; the message names it.
    """
    comments: list[str] = []
    rows: list[list[float]] = []
    names: tuple[str, ...] = ()
    start, separator = 0, None
    for number, raw in enumerate(text_of(path).splitlines(), 1):
        line = raw.strip()
        if not line:
            continue
        if line.startswith(COMMENTS):
            comments.append(line.lstrip("#%!/ "))
            continue
        if separator is None:
            separator = _separator(raw)
        entries = _split(raw, separator)
        if not rows and not names and not any(map(_is_number, entries)):
            names, start = tuple(entry.strip("\"'") for entry in entries), number
            continue
        width = len(names or (rows[0] if rows else entries))
        rows.append([_value(path, number, entry, separator) for entry in entries])
        if len(entries) != width:
            raise DataFileError(
                f"{path}, line {number}: there are {len(entries)} entries where {width} are "
                "expected; write every row in full."
            )
    if not rows:
        raise DataFileError(f"{path} has no row of numbers; give a table of t, x and slip_rate.")
    if not names:
        names = _names_of_comments(comments, len(rows[0]))
    return Table(path, names, np.array(rows), tuple(comments), start)


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
    return bool(_NUMBER.match(text.strip()))


def _value(path: Path, line: int, text: str, separator: str | None) -> float:
    text = text.strip().strip("\"'")
    if text.lower() in MISSING:
        return np.nan
    if text.lower().lstrip("+-") in ("inf", "infinity"):
        return float(text)
    if not _NUMBER.match(text) or ("," in text and separator == ","):
        shown = text if len(text) <= LONGEST_SHOWN else text[:LONGEST_SHOWN] + "..."
        raise DataFileError(f"{path}, line {line}: {shown!r} is not a number; mend that line.")
    return float(text.replace(",", ".").replace("D", "e").replace("d", "e"))
