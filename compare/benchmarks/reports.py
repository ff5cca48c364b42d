"""Scores as files: a table, JSON and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from compare.benchmarks.figures import score_figure
from compare.benchmarks.scores import Score
from compare.comparison.documents import json_text
from compare.figures.saving import save_figure
from compare.output.files import write_text
from compare.output.tables import write_rows

COMMAND = "slipfront benchmark score"


def write_scores(folder: Path, scores: Sequence[Score], form: str = "png") -> None:
    """Write scores.csv, scores.json and scores.png, or a figure of another format.

    Raises
    ------
    DataFileError
        If one cannot be written.
    """
    write_rows(folder / "scores.csv", scores, command=COMMAND)
    write_text(folder / "scores.json", json_text({"scores": [asdict(one) for one in scores]}))
    save_figure(score_figure(scores), folder / f"scores.{form}")
