"""The article reproduced: its cases, its claims, and the kernels of its section 4.

Slip and slip rates are relative, twice those of the article, in units of V_0 = 2 Q_0/(mu b).
``python -m docs.studies.article --output docs`` makes the tables of article.md.
"""

from __future__ import annotations

from docs.studies.article.cases import CASES, run_case, run_cases, slot_errors, slot_rows
from docs.studies.article.claims import CLAIMS
from docs.studies.runner import Row, Study, main


def _resolution(quick: bool) -> int:
    """Elements per c_t T."""
    return 60 if quick else 200


def case_row(kind: str, chi: float, resolution: int) -> Row:
    """Return the mean difference of exact and simulated slip rates of a case, over V_0."""
    case = run_case(kind, chi, resolution)
    return {
        "base": "remote" if kind == "remote" else "preloaded",
        "chi": chi,
        "poisson_ratio": case.solution.scene.material.poisson_ratio,
        "difference": case.difference(),
    }


def claim_rows(resolution: int) -> list[Row]:
    """Judge all claims by the three methods."""
    cases = run_cases(resolution)
    return [judge(cases) for judge in CLAIMS]


STUDIES = [
    Study("article-cases", lambda quick: [(*case, _resolution(quick)) for case in CASES], case_row),
    Study("article-claims", lambda quick: [(_resolution(quick),)], claim_rows),
    Study(
        "article-slots",
        lambda quick: [(mode, 0.01 if quick else 0.005) for mode in ("II", "I")],
        slot_rows,
        slot_errors,
    ),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.article", STUDIES))
