"""The article reproduced: its figures, its claims and the readings of its algorithm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from compare.article_cases import Cases, Progress, SlotCheck, check_slot, run_cases
from compare.article_claims import CLAIMS, METHODS, Claim
from compare.article_figures import figure_2, figure_5, figure_6, slot_figure
from compare.figures import save_figure
from compare.files import write_text
from semianalytic.published import DEFAULT_READING, ReadingResult, examine_all

RESOLUTION, QUICK_RESOLUTION = 200, 60
_ELEMENT_SIZE, _QUICK_ELEMENT_SIZE = 0.005, 0.01
_GRID, _QUICK_GRID = 100, 60


@dataclass(frozen=True)
class Article:
    """What `write_article` found.

    Attributes
    ----------
    claims : the claims table
    readings : how every reading of the published algorithm fares, the best settled first
    slot_checks : the two versions of `interface_traction` against finite elements, by mode
    disagreement : largest mean difference of exact and simulated slip rate over all cases,
        relative to Q_0/(mu b)
    files : what was written
    seconds : how long it took
    """

    claims: tuple[Claim, ...]
    readings: tuple[ReadingResult, ...]
    slot_checks: tuple[SlotCheck, ...]
    disagreement: float
    files: tuple[Path, ...]
    seconds: float


def judge_claims(cases: Cases) -> tuple[Claim, ...]:
    """All claims with the verdicts of the three methods."""
    return tuple(judge(cases) for judge in CLAIMS)


def claims_table(claims: Sequence[Claim]) -> str:
    """The claims as a Markdown table: one row per claim, one column per method."""
    head = ["section", "claim", "load base", *METHODS]
    rows = [
        [
            claim.section,
            claim.text,
            claim.base,
            *(f"**{v.verdict}**: {v.evidence}" for v in (claim.verdicts[m] for m in METHODS)),
        ]
        for claim in claims
    ]
    return _markdown(head, rows)


def readings_table(results: Sequence[ReadingResult]) -> str:
    """The readings of the published algorithm as a Markdown table."""
    head = [
        "unknowns u' >",
        "delay",
        "kernel signs",
        "basis",
        "constant in p, q",
        "arctan (7.10)",
        "condition",
        "change on doubling n_u",
        "signs settle",
        "end of first slip, chi = 2",
        "maximum, chi = 0.5",
        "reverse slip below chi",
        "change off the middle",
    ]
    rows = []
    for result in results:
        reading = result.reading
        name = reading.start + (" (default)" if reading == DEFAULT_READING else "")
        row = [name, reading.delay, reading.signs, reading.basis]
        row.append("yes" if reading.remote_load else "no")
        row.append("as printed" if reading.printed_arctan else "b^3 arctan")
        if np.isinf(result.condition):
            rows.append([*row, "singular", *["–"] * 6])
            continue
        limit = result.reverse_limit
        rows.append(
            [
                *row,
                f"{result.condition:.1e}",
                f"{result.change:.1e}",
                "yes" if result.settled else "no",
                f"{result.slip_end:.3f}",
                f"{result.maximum:.3f}",
                "always" if np.isinf(limit) else "never" if limit == 0 else f"{limit:.4f}",
                f"{result.off_middle:.1e}",
            ]
        )
    return _markdown(head, rows)


def slot_table(checks: Sequence[SlotCheck]) -> str:
    """Largest differences from finite elements with a free slot, as a Markdown table."""
    rows = [[f"mode {c.mode}", f"{c.error('free'):.2%}", f"{c.error('held'):.1%}"] for c in checks]
    return _markdown(["", "slot face free", "slot face held, (4.31), (4.37)"], rows)


def _markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def write_article(output: Path, quick: bool = False, progress: Progress | None = None) -> Article:
    """Redraw figures 2, 5 and 6 by three methods and write the claims table.

    Parameters
    ----------
    output : folder for figure2.png, figure5.png, figure6.png, slot.png and article.md.
    quick : coarser meshes.
    progress : called with one line before each piece of work.

    Returns
    -------
    Article

    Raises
    ------
    DataFileError
        If a file cannot be written.
    """
    started = perf_counter()

    def tell(line: str) -> None:
        if progress is not None:
            progress(line)

    cases = run_cases(QUICK_RESOLUTION if quick else RESOLUTION, progress)
    tell("prescribed slip, both modes")
    size = _QUICK_ELEMENT_SIZE if quick else _ELEMENT_SIZE
    checks = (check_slot("II", size), check_slot("I", size))
    tell("readings of the published algorithm")
    readings = tuple(examine_all(_QUICK_GRID if quick else _GRID))
    tell("claims and figures")
    claims = judge_claims(cases)
    disagreement = max(case.disagreement() for case in cases.everyone())
    figures = {
        "figure2.png": figure_2(cases),
        "figure5.png": figure_5(cases),
        "figure6.png": figure_6(cases),
        "slot.png": slot_figure(checks),
    }
    for name, figure in figures.items():
        save_figure(figure, output / name)
    text = "\n".join(
        [
            "# The article's claims\n",
            claims_table(claims),
            "Published: the default reading. Exact and finite elements differ by at most "
            f"{disagreement:.2g} of Q_0/(mu b) in the mean.\n",
            "# Prescribed slip, slot faces free: largest difference from finite elements\n",
            slot_table(checks),
            "# Readings of the published algorithm\n",
            readings_table(readings),
        ]
    )
    write_text(output / "article.md", text)
    files = tuple(output / name for name in (*figures, "article.md"))
    return Article(claims, readings, checks, disagreement, files, perf_counter() - started)
