"""Put the judge on trial: ``python -m docs.studies.judge [--quick] [--scheduler ADDRESS]``.

The trials, their tables and the figure are written to results/stability, or the folder of
``--output``.  An interrupted trial resumes when the command is given again.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from compare.output.progress import progress_bar
from compare.tasks.cluster import connected
from docs.studies.judge.study import FOLDER, write_judge


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what is missing of the trials and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.judge", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="run a few small trials only")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="work on this Dask cluster")
    parser.add_argument("--output", type=Path, default=FOLDER, metavar="DIR")
    given = parser.parse_args(arguments)
    given.output.mkdir(parents=True, exist_ok=True)
    bar = progress_bar(Console(stderr=True), False, "judging")
    with connected(given.scheduler) as client, bar as progress:
        write_judge(given.output, given.quick, progress, client=client)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
