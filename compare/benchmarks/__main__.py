"""The answers to the problem sheets: ``python -m compare.benchmarks --write`` or ``--check``.

Without either the sheets are listed.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from compare.benchmarks.answers import DATA, changes, write_answers
from compare.benchmarks.sheet import STATIONS
from compare.benchmarks.sheets import ALL_SHEETS
from semianalytic.scene.errors import DataFileError


def main(arguments: Sequence[str] | None = None) -> int:
    """List the sheets, write or check their answers; 1 if one has changed, 3 if spoilt."""
    parser = argparse.ArgumentParser(prog="python -m compare.benchmarks", description=__doc__)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="say which answers have changed")
    what.add_argument(
        "--write", nargs="*", choices=ALL_SHEETS, metavar="NAME", help="compute and write answers"
    )
    options = parser.parse_args(arguments)
    if options.write is not None:
        write_answers(names=options.write)
        print(f"Written to {DATA}/")
        return 0
    if options.check:
        try:
            found = [change for sheet in ALL_SHEETS.values() for change in changes(sheet)]
        except DataFileError as error:
            parser.exit(DataFileError.exit_code, f"{error}\n")
        print(*found, sep="\n")
        return 1 if found else 0
    print("stations x/(c_t T):", *STATIONS)
    for sheet in ALL_SHEETS.values():
        print(f"{sheet.name:16} {sheet.title}: {', '.join(sheet.report)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
