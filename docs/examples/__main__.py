"""Draw the figures of docs/gallery.md: ``python -m docs.examples [FOLDER]``.

Runs every example in a temporary folder and copies its figure to FOLDER, by default
docs/figures/examples.
"""

from __future__ import annotations

import shutil
import sys
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

EXAMPLES = (
    "first_answer",
    "fringes",
    "antiplane",
    "openings",
    "fit_friction",
    "sensitivity",
    "fit_gauges",
    "posterior",
    "sweep_friction",
    "survey_map",
    "custom_history",
    "friction_law",
    "paraview_snapshots",
)
"""Names of the examples, in the order of the gallery."""
FIGURES = Path(__file__).resolve().parents[2] / "docs" / "figures" / "examples"


def main(folder: Path = FIGURES) -> None:
    """Run all examples and copy their figures into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in EXAMPLES:
        with TemporaryDirectory() as elsewhere:
            import_module(f"docs.examples.{name}").main(Path(elsewhere))
            shutil.copy(Path(elsewhere, f"{name}.png"), folder)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
