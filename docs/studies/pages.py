"""Fill the tables of the documentation from docs/data; nothing is computed here.

``python -m docs.studies.pages --write`` fills them, and ``--check`` lists pages that differ from
their data.  A table in a page is marked like this::

    <!-- table: NAME where COLUMN=VALUE; COLUMN=VALUE spread COLUMN by COLUMN
    | heading | heading |
    | {COLUMN} | {COLUMN:.2e} |
    -->
    (the filled table)
    <!-- end -->

NAME refers to the file docs/data/NAME.csv, whose first line is a comment with the command that
makes it.  The second line is repeated for every row with the given values, or for all rows; a
format of `Cell` may follow the colon.  Files with one value per row can be spread: rows with the
same value in the second column then form one row of the table, in which each value (of the column
"value") has the name found in the first column.
"""

from __future__ import annotations

import argparse
import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from compare.output.places import write_text
from semianalytic.scene.errors import DataFileError

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "docs" / "data"

_BLOCK = re.compile(
    r"(?P<mark><!-- table: (?P<name>[\w.-]+)(?: where (?P<chosen>[^\n]*?))?"
    r"(?: spread (?P<names>\w+) by (?P<key>\w+))?\n"
    r"(?P<heading>\|[^\n]*)\n(?P<row>\|[^\n]*)\n-->\n)(?P<filled>.*?)(?P<end><!-- end -->)",
    re.DOTALL,
)
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Cell:
    """A cell of a data file, with its own formats.

    Formats besides those of Python are "r" (1/3 for 0.3333…), ".2p" (a power of ten, such as
    1.30·10⁻³), ".3s" (significant digits, including trailing zeros), and ".2s%" (the same in
    percent).  Cells without a value, and nan, are empty.
    """

    text: str

    def __format__(self, form: str) -> str:
        if self.text in ("", "nan"):
            return ""
        if not form:
            return self.text.replace("|", r"\|")
        return _typeset(_formatted(float(self.text), form))


def _formatted(value: float, form: str) -> str:
    if form == "r":
        ratio = Fraction(value).limit_denominator(3)
        third = ratio.denominator == 3 and abs(float(ratio) - value) < 1e-9
        return str(ratio) if third else f"{value:g}"
    if form.endswith("%"):
        form = form[:-1] if form.endswith("s%") else f"{form[:-1]}f"
        return f"{_formatted(100 * value, form)} %"
    if form.endswith("s"):
        return f"{value:#{form[:-1]}g}".rstrip(".")
    if form.endswith("p"):
        mantissa, _, exponent = f"{value:{form[:-1]}e}".partition("e")
        return f"{mantissa}·10{str(int(exponent)).translate(_RAISED)}"
    return f"{value:{form}}"


def _typeset(number: str) -> str:
    """Return a number with a typographic minus sign and without leading zeros in its exponent."""
    sign = "−" if number.startswith("-") else number[:1]
    return sign + re.sub(r"e([+-])0*(?=\d)", lambda m: "e" + m[1].strip("+"), number[1:])


def read_data(name: str, folder: Path = DATA) -> tuple[str, list[dict[str, str]]]:
    """Read a data file; return the command that makes it, and its rows.

    Raises
    ------
    DataFileError
        If there is no such file, or its first line names no command.
    """
    path = folder / f"{name}.csv"
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            first = stream.readline()
            rows = list(csv.DictReader(stream, strict=True))
    except (OSError, csv.Error) as error:
        raise DataFileError(f"{path} cannot be read ({error}).") from error
    if not first.startswith("# "):
        raise DataFileError(f"{path}: its first line has to be '# ' and the command that makes it.")
    return first[2:].strip(), rows


def _table(block: re.Match[str], folder: Path) -> str:
    """Return the lines of a marked table."""
    _, rows = read_data(block["name"], folder)
    chosen = [term.strip().split("=", 1) for term in (block["chosen"] or "").split(";") if term]
    try:
        shown = [row for row in rows if all(row[column] == value for column, value in chosen)]
        if block["key"]:
            shown = _spread(shown, block["names"], block["key"])
        lines = [
            block["row"].format_map({column: Cell(text) for column, text in row.items()})
            for row in shown
        ]
    except (KeyError, ValueError) as error:
        raise DataFileError(f"{block['name']}.csv does not fit its table ({error!r}).") from error
    if not lines:
        raise DataFileError(f"{block['name']}.csv has no row with {block['chosen']}.")
    rule = "|" + "---|" * (block["heading"].count("|") - 1)
    return "\n".join([block["heading"], rule, *lines]) + "\n"


def _spread(rows: list[dict[str, str]], names: str, key: str) -> list[dict[str, str]]:
    """Combine rows with one value each into rows with several values."""
    empty = dict.fromkeys((row[names] for row in rows), "")
    merged: dict[str, dict[str, str]] = {}
    for row in rows:
        merged.setdefault(row[key], {**row, **empty})[row[names]] = row["value"]
    return list(merged.values())


def filled(text: str, folder: Path = DATA) -> str:
    """Return a page with all its tables filled from the data.

    Raises
    ------
    DataFileError
        If a data file cannot be read, or lacks a column or all rows that a table shows.
    """
    return _BLOCK.sub(lambda block: block["mark"] + _table(block, folder) + block["end"], text)


def pages() -> list[Path]:
    """Return the paths of README and of all pages of docs."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def stale_pages(write: bool = False) -> list[Path]:
    """Return the pages that differ from their data, and rewrite them if `write` is true."""
    stale = []
    for page in pages():
        text = page.read_text(encoding="utf-8")
        new = filled(text)
        if new != text:
            stale.append(page)
            if write:
                write_text(page, new)
    return stale


def main(arguments: Sequence[str] | None = None) -> int:
    """Check or fill the tables of README and docs; return 1 if one is outdated, 3 without data."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.pages", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--check", action="store_true", help="name pages that are not up to date")
    what.add_argument("--write", action="store_true", help="fill the tables of all pages")
    options = parser.parse_args(arguments)
    try:
        stale = stale_pages(options.write)
    except DataFileError as error:
        parser.exit(3, f"{error}\n")
    for page in stale:
        print(f"{page.relative_to(ROOT)}: {'written' if options.write else 'not up to date'}")
    return 1 if stale and options.check else 0


if __name__ == "__main__":
    raise SystemExit(main())
