"""Rows of studies as tables on the terminal and as data files of the documentation.

A study is a function without arguments that returns rows, instances of one dataclass.  The printed
tables, the CSV files and the tables of the docs (`docs.studies.pages`) all show these rows.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from rich.console import Console

from compare.output.printed import Table
from compare.output.tables import write_rows

Study = Callable[[], Sequence[Any]]


def shown_rows(title: str, rows: Sequence[Any]) -> Table:
    """Return a table of rows for the terminal, with numbers to four digits."""
    table = Table(title=title)
    for field, value in zip(fields(rows[0]), astuple(rows[0]), strict=True):
        heading = field.name.replace("_", " ")
        table.add_column(heading, justify="left" if isinstance(value, str) else "right")
    for row in rows:
        table.add_row(*map(_shown, astuple(row)))
    return table


def _shown(value: object) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.4g}"
    return f"{value:,}" if isinstance(value, int) else str(value)


def run_studies(
    module: str, prefix: str, studies: Mapping[str, Study], arguments: Sequence[str] | None = None
) -> int:
    """Print the named studies, and write each as PREFIX-NAME.csv if a folder is given.

    Parameters
    ----------
    module : str
        Module whose command it is, for messages and the first lines of the files.
    prefix : str
    studies : mapping of names to studies
    arguments : sequence of str, optional
        Arguments of the command line.
    """
    parser = argparse.ArgumentParser(prog=f"python -m {module}")
    parser.add_argument(
        "names", nargs="+", choices=studies, metavar="STUDY", help=", ".join(studies)
    )
    parser.add_argument("--csv", type=Path, metavar="DIR", help="folder to write to; docs/data")
    options = parser.parse_args(arguments)
    for name in options.names:
        rows = studies[name]()
        Console(width=140).print(shown_rows(f"{prefix}: {name}", rows))
        if options.csv is not None:
            command = f"python -m {module} {name} --csv docs/data"
            write_rows(options.csv / f"{prefix}-{name}.csv", rows, command=command)
    return 0
