"""The evidence as one self-contained HTML page: tables, figures, profiles over time."""

from __future__ import annotations

import math
import shlex
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from html import escape
from importlib.resources import files
from pathlib import Path

from compare.comparison.case import NARROW
from compare.comparison.rows import AGREES, ALARM, DIFFERS, TELLING, UNRESOLVED, Row
from compare.output.files import filled_template, write_text
from compare.output.places import check_file
from compare.studies.article.claims import FAILS, HOLDS, METHODS, PARTLY
from compare.studies.article.study import figure_2, figure_5, figure_6
from compare.studies.evidence.film import field_section, films
from compare.studies.evidence.html import (
    Cell,
    code,
    drawn_figure,
    figures,
    image,
    number,
    paragraph,
    table,
    words,
)
from compare.studies.evidence.scene import DASH, counts_text, scene_section, verdict_cell
from compare.studies.evidence.study import FEM, Evidence, collect, excess, worst_row
from compare.tasks.workers import Progress

CHECKOUT = Path(__file__).parents[3]


@dataclass(frozen=True)
class Earlier:
    """Figures of a longer study, read from files if they exist.

    Attributes
    ----------
    title, command, about : str
        Heading, command that draws the figures, and description of the figures.
    patterns : tuple of str
        Names of the files within the folders `results/` and `docs/figures/`.
    """

    title: str
    command: str
    about: str
    patterns: tuple[str, ...]


STUDIES = {
    "chart": Earlier(
        "Error against time",
        "slipfront chart",
        "Every method on one machine: relative error of the slip rate against wall time.",
        ("chart/figures/chart_*.png", "chart_*.png"),
    ),
    "stability": Earlier(
        "Where methods fail",
        "slipfront stability --solver --fem --space-time",
        "Thresholds, limits of the Poisson ratio, grids, rules, step sizes and damping.",
        ("stability/*stability*.png", "*stability*.png"),
    ),
    "regimes": Earlier(
        "Regimes over Poisson ratio and friction",
        "slipfront regimes",
        "How the interface slips, with traced boundaries, and speeds of all zone edges.",
        ("regimes/*.png", "regimes*.png", "front_speeds.png"),
    ),
    "wear": Earlier(
        "Wear against friction",
        "slipfront wear",
        "Accumulated slip and frictional work for a step, a ramp and a pulse.",
        ("wear/*.png", "wear*.png"),
    ),
}


def write_evidence(
    path: Path,
    sources: Sequence[str] = (),
    *,
    quick: bool = False,
    progress: Progress | None = None,
) -> Evidence:
    """Write the page, completely or not at all; for the parameters see `collect`.

    Raises
    ------
    SceneError
        If there is no such scene, or the path is a folder; raised before anything is computed.
    ComputationError
        If a method fails.
    DataFileError
        If the file cannot be written.
    """
    check_file(path)
    evidence = collect(sources, quick=quick, progress=progress)
    write_text(path, page(evidence))
    return evidence


def page(evidence: Evidence) -> str:
    """Return the page as HTML."""
    anchors = [f"scene-{number}" for number in range(1, len(evidence.scenes) + 1)]
    chosen = films(evidence)
    sections = [
        ("summary", "Summary", _summary(evidence, anchors)),
        ("reading", "How to read this page", _reading()),
        *(
            (anchor, f"Scene: {scene.label}", scene_section(anchor, scene, evidence.quick))
            for anchor, scene in zip(anchors, evidence.scenes, strict=True)
        ),
        *((("field", "The whole field", field_section(chosen)),) if chosen else ()),
        ("closed", "Closed forms", _closed_forms(evidence)),
        ("article", "Claims of the article", _article(evidence)),
        *((key, study.title, _earlier(study)) for key, study in STUDIES.items()),
        ("versions", "Versions, machine and commands", _versions(evidence)),
    ]
    contents = "".join(
        f'<li><a href="#{anchor}">{escape(title)}</a></li>' for anchor, title, _ in sections
    )
    main = "\n".join(
        f'<section id="{anchor}" aria-labelledby="{anchor}-title">\n'
        f'<h2 id="{anchor}-title">{escape(title)}</h2>\n{body}\n</section>'
        for anchor, title, body in sections
    )
    body = (
        "<header><h1>slipfront: evidence</h1>\n"
        + paragraph(
            "Two identical elastic half-planes touch along x > 0; x < 0 is an open slot. Where, "
            "when, how fast and which way the interface slips is answered here by two "
            "semi-analytic methods and by finite elements, which share with them the description "
            "of a scene and nothing else."
        )
        + paragraph(f"Made on {evidence.stamp['date']} by slipfront {evidence.stamp['slipfront']}.")
        + f'</header>\n<nav aria-label="Contents"><h2>Contents</h2><ol>{contents}</ol></nav>\n'
        + f"<main>\n{main}\n</main>"
    )
    return filled_template(
        "compare.studies.evidence", "evidence.html", body=body, program=_program_digest()
    )


def _program_digest() -> str:
    """Return the digest of the page's script, the only one that browsers may run."""
    text = files("compare.studies.evidence").joinpath("evidence.html").read_text(encoding="utf-8")
    program = text.rpartition("<script>")[2].partition("</script>")[0]
    return f"sha256-{b64encode(sha256(program.encode()).digest()).decode()}"


def _summary(evidence: Evidence, anchors: Iterable[str]) -> str:
    rows = []
    for anchor, scene in zip(anchors, evidence.scenes, strict=True):
        worst = worst_row(scene)
        counts = [str(scene.counts[verdict]) for verdict in (AGREES, UNRESOLVED, DIFFERS)]
        rows.append(
            (
                Cell(scene.label, link=f"#{anchor}"),
                verdict_cell(scene.verdict) if scene.judgements else "not judged",
                *map(number, counts if scene.judgements else [DASH] * 3),
                words(DASH if worst is None else _closeness(*worst)),
                words(", ".join(scene.methods)),
                words(scene.summary),
            )
        )
    head = (
        *("scene", "verdict", "agree", "unresolved", "differ"),
        *("closest to its error bar", "methods", "shows"),
    )
    claims = [claim.verdicts["exact"].verdict for claim in evidence.claims]
    title = "Every scene, and of its resolved rows the one that is nearest to its error bar"
    return (
        paragraph(f"Over all scenes {counts_text(evidence.counts)}.")
        + table(head, rows, title)
        + paragraph(
            f"By the exact solution, {claims.count(HOLDS)} of the {len(claims)} claims of the "
            f"article hold, {claims.count(PARTLY)} hold in part and {claims.count(FAILS)} fail."
        )
    )


def _closeness(method: str, row: Row) -> str:
    ratio = excess(row)
    share = "in one answer only" if math.isinf(ratio) else f"{ratio:.2f} of its error bar"
    return f"{row.name}: {share} ({method} against {FEM})"


def _reading() -> str:
    return "".join(
        paragraph(text)
        for text in (
            "Lengths are over c_t T and times over T, the end of the simulation; stresses are over "
            "τ₀, the larger load step, and slip rates over V₀ = 2 τ₀ / (ρ c_t). Slip and slip rate "
            "are relative, upper side less lower side. Numbers hold at the contact nodes of the "
            "finite-element mesh.",
            "Self-similar: closed forms up to quadrature, the zone edges being the only unknowns; "
            "for step loads. Space-time: the interface alone, marched in time on a spectral grid; "
            "for any load history. Both rest on the theory of two half-planes. Finite elements: "
            "the blocks themselves, explicit steps, Coulomb's law node by node; they know nothing "
            "of that theory. Published algorithm: the article's own, for its only load, a sudden "
            "remote one; drawn, but not judged row by row.",
            "A row is one quantity with three values: exact, by a semi-analytic method; at nodes, "
            "what this mesh would show of it, read off the same answer at the nodes and times of "
            "the finite elements; and as it was simulated, read in the same way and left as it is. "
            "The difference is that of the last two. Its error bar is how far both may be off: for "
            "the finite elements by what changed from the same run at 2h and 4h, taken to be of "
            "first order whatever order they show (Roache's grid convergence index); for the "
            "semi-analytic method by its own estimate. No bar is set by hand.",
            f"A row {AGREES} within its bar and {DIFFERS} beyond {ALARM:g} bars; what is in one "
            f"answer only {DIFFERS} too. It is {UNRESOLVED} in between, and where this mesh cannot "
            f"tell: a zone narrower than {NARROW} elements, or a bar above {TELLING:g} of what is "
            "compared. The last column then says why, and where it is known which mesh would tell "
            f"at what cost. A judgement {DIFFERS} if one row does; else it {AGREES} if one of slip "
            "or slip rate does.",
        )
    )


def _closed_forms(evidence: Evidence) -> str:
    forms = evidence.closed_forms
    methods = tuple(forms[0].errors)
    rows: list[tuple[str | Cell, ...]] = []
    for form in forms:
        edges = (DASH if edge is None else f"{edge:.12f}" for edge in (form.edge, form.solved_edge))
        errors = (f"{form.errors[method]:.1e}" for method in methods)
        rows.append((words(form.words), *map(number, (*errors, *edges))))
    head = ("scene", *methods, "edge / c_t, closed form", "edge / c_t, self-similar")
    return (
        paragraph(
            "Some scenes have slip rates in closed form, as plain quadratures in "
            "semianalytic/reference/closed_forms.py. Neither solver nor finite elements use them."
        )
        + table(head, rows, "Relative L1 error of slip rate at T on 0.02 < x/(c_t T) < 1.9")
        + code(["pytest tests/semianalytic/selfsimilar/test_solver.py"])
    )


def _article(evidence: Evidence) -> str:
    rows: list[tuple[str | Cell, ...]] = []
    for claim in evidence.claims:
        verdicts = (claim.verdicts[method] for method in METHODS)
        judged = (words(f"{one.verdict}: {one.evidence}") for one in verdicts)
        rows.append((claim.section, words(claim.text), claim.base, *judged))
    cases = evidence.cases.everyone()
    drawn = ""
    if not evidence.quick:
        drawn = figures(
            drawn_figure(draw(evidence.cases), f"Figure {name} of the article, redrawn", wide=True)
            for name, draw in (("2", figure_2), ("5", figure_5), ("6", figure_6))
        )
    return (
        paragraph(
            f"Every verdict is computed from {len(cases)} scenes, solved and simulated with h = "
            f"c_t T / {cases[0].resolution}. Exact and simulated slip rates differ by at most "
            f"{evidence.cases.disagreement():.2g} V₀ in the mean, V₀ = 2 Q_0/(μb)."
        )
        + table(("section", "claim", "load base", *METHODS), rows, "Claims and verdicts")
        + drawn
        + code(["slipfront article --quick", "slipfront article"])
    )


def _earlier(study: Earlier) -> str:
    """Show the figures of a longer study with their dates, or the command that draws them."""
    paths = list(_earlier_files(study.patterns))
    if not paths:
        return paragraph(f"{study.about} Not drawn on this machine yet:") + code([study.command])
    drawn = figures(
        image(
            path.read_bytes(),
            f"{study.title}: {path.stem.replace('_', ' ')}",
            f"{path.name}, a file of {file_date(path)}",
            wide=True,
        )
        for path in paths
    )
    return (
        paragraph(f"{study.about} Drawn earlier, not together with this page, by")
        + code([study.command])
        + drawn
    )


def file_date(path: Path) -> str:
    """Return the day on which a file was last written."""
    try:
        return f"{datetime.fromtimestamp(path.stat().st_mtime, UTC):%Y-%m-%d}"
    except (ValueError, OverflowError):  # the date may be thousands of years in the future
        return "unknown date"


def _earlier_files(patterns: Iterable[str]) -> Iterator[Path]:
    """Yield files by name; of equal names in both folders, the file in `results/`."""
    paths: dict[str, Path] = {}
    for folder in (Path("results"), Path("docs", "figures"), CHECKOUT / "docs" / "figures"):
        for path in sorted({path for pattern in patterns for path in folder.glob(pattern)}):
            paths.setdefault(path.name.replace("_", "-"), path)
    yield from paths.values()


def _versions(evidence: Evidence) -> str:
    names = " ".join(shlex.quote(scene.source) for scene in evidence.scenes)
    command = f"slipfront evidence {names}" + (" --quick" if evidence.quick else "")
    rows = [
        *evidence.stamp.items(),
        ("time to compute", f"{evidence.seconds:.1f} s, without figures"),
    ]
    return (
        table(("what", "value"), rows, "What made this page")
        + paragraph("This page, the tests behind it, and the parts that take longer:")
        + code([command, "pytest", *(study.command for study in STUDIES.values())])
    )
