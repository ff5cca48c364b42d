"""The article reproduced: its figures, its claims, and the readings of its algorithm.

Slip and slip rates are relative, twice those of the article, in units of V_0 = 2 Q_0/(mu b).
``slipfront article`` writes everything.  ``python -m compare.studies.article.study claims cases
slots --csv docs/data`` writes the data of docs/article.md.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from compare.comparison.scales import wave_speeds
from compare.figures.saving import save_figure
from compare.figures.style import (
    BROWN,
    PREDICTION,
    RATE_LABEL,
    SIMULATION,
    cycle,
    describe,
    ink,
    mark_waves,
    new_figure,
    styled,
)
from compare.output.files import write_text
from compare.output.tables import markdown_table
from compare.studies.article.cases import (
    END_TIME,
    SHEAR_SPEED,
    Case,
    Cases,
    Progress,
    SlotCheck,
    check_slot,
    run_cases,
)
from compare.studies.article.claims import CLAIMS, METHODS, Claim
from compare.studies.tables import Study, run_studies
from semianalytic.halfplane.stuck_histories import stuck_pressure, stuck_shear
from semianalytic.reference import (
    DEFAULT_READING,
    ReadingResult,
    examine_all,
    published_slip,
)
from semianalytic.scene.loads import Step

Array = NDArray[np.float64]
Curves = Callable[[Case, str], tuple[Array, Array]]

RESOLUTION, QUICK_RESOLUTION = 200, 60
_ELEMENT_SIZE, _QUICK_ELEMENT_SIZE = 0.005, 0.01
_GRID, _QUICK_GRID = 100, 60

_ABOVE = (1.2, 2.0)
_BELOW = (0.01, 0.5, 0.9)
_VELOCITY = np.linspace(0.004, 2.05, 1200)  # x/(c_t t)
UNITS = (
    r"$\nu$ = 1/3, $c_t$ = 5, $t$ = 0.01, $f P_0$ = 1, $\chi = f P_0/Q_0$;  "
    r"$V_0 = 2 Q_0/(\mu b)$ = $2 Q_0/(\rho c_t)$"
)
"""Parameters that hold in all figures of the article."""


@dataclass(frozen=True)
class Article:
    """Results of `write_article`: disagreement is that of `Cases`, files are those written."""

    claims: tuple[Claim, ...]
    readings: tuple[ReadingResult, ...]
    disagreement: float
    files: tuple[Path, ...]


def judge_claims(cases: Cases) -> tuple[Claim, ...]:
    """Return all claims with the verdicts of the three methods."""
    return tuple(judge(cases) for judge in CLAIMS)


def claims_table(claims: Sequence[Claim]) -> str:
    """Return the claims as a Markdown table: one row per claim, one column per method."""
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
    return markdown_table(head, rows)


def readings_table(results: Sequence[ReadingResult]) -> str:
    """Return the readings of the published algorithm as a Markdown table."""
    rows = [_reading_row(result) for result in results]
    return markdown_table(list(rows[0]), [list(row.values()) for row in rows])


def _reading_row(result: ReadingResult) -> dict[str, str]:
    """Return the description and the results of a reading, by heading."""
    reading, limit = result.reading, result.reverse_limit
    fares = {
        "condition": f"{result.condition:.1e}",
        "change on doubling n_u": f"{result.change:.1e}",
        "signs settle": "yes" if result.settled else "no",
        "end of first slip, chi = 2": f"{result.slip_end:.3f}",
        "maximum, chi = 0.5": f"{result.maximum:.3f}",
        "reverse slip below chi": {0.0: "never", np.inf: "always"}.get(limit, f"{limit:.4f}"),
        "change off the middle": f"{result.off_middle:.1e}",
    }
    if np.isinf(result.condition):
        fares = {heading: "–" for heading in fares} | {"condition": "singular"}
    return {
        "unknowns u' >": reading.start + (" (default)" if reading == DEFAULT_READING else ""),
        "delay": reading.delay,
        "kernel signs": reading.signs,
        "basis": reading.basis,
        "constant in p, q": "yes" if reading.remote_load else "no",
        "arctan (7.10)": "as printed" if reading.printed_arctan else "b^3 arctan",
        **fares,
    }


def slot_table(checks: Sequence[SlotCheck]) -> str:
    """Return the largest differences from finite elements with a free slot as a Markdown table."""
    rows = [[f"mode {c.mode}", f"{c.error('free'):.2%}", f"{c.error('held'):.1%}"] for c in checks]
    return markdown_table(["", "slot face free", "slot face held, (4.31), (4.37)"], rows)


def write_article(
    output: Path,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
) -> Article:
    """Draw figures 2, 5 and 6 of the article, and judge its claims; meshes are coarser if `quick`.

    Writes figure2, figure5, figure6 and slot (in a format `form`) and article.md into a folder.
    `progress` is called with one line before each piece of work.

    Raises
    ------
    DataFileError
        If a file cannot be written.
    """

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
    disagreement = cases.disagreement()
    figures = {
        "figure2": figure_2(cases),
        "figure5": figure_5(cases),
        "figure6": figure_6(cases),
        "slot": slot_figure(checks),
    }
    for name, figure in figures.items():
        save_figure(figure, output / f"{name}.{form}")
    text = "\n".join(
        [
            "# The article's claims\n",
            claims_table(claims),
            "Published: the default reading. Exact and finite elements differ by at most "
            f"{disagreement:.2g} V_0 in the mean. V is the relative slip rate, twice the "
            "article's, and V_0 = 2 Q_0/(mu b).\n",
            "# Prescribed slip, slot faces free: largest difference from finite elements\n",
            slot_table(checks),
            "# Readings of the published algorithm\n",
            readings_table(readings),
        ]
    )
    write_text(output / "article.md", text)
    files = tuple(output / name for name in (*(f"{one}.{form}" for one in figures), "article.md"))
    return Article(claims, readings, disagreement, files)


def _panels(
    columns: int, width: float, rows: int = 1, title: str = UNITS
) -> tuple[Figure, list[list[Axes]]]:
    figure = describe(new_figure(width, 3.6 * rows + 0.2), title)
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, [list(row) for row in axes]


@styled
def figure_2(cases: Cases) -> Figure:
    """Draw stuck pressure p* and shear q* at three times: (3.10), (3.14) and finite elements.

    The simulation has the remote load with chi = 2, under which the whole contact sticks.
    """
    case = cases.remote[2.0]
    material, history = case.solution.scene.material, case.history
    figure, [panels] = _panels(2, 9)
    rows = [np.searchsorted(history.t, part * END_TIME * 0.999) for part in (0.4, 0.7, 1.0)]
    x = np.linspace(2e-4, 0.11, 1200)
    held = case.solution.scene.superposition.in_place
    fields = (
        (stuck_pressure, history.pressure - held.pressure, 1.0, "$p^*/P_0$"),
        (stuck_shear, (history.shear_traction - held.shear) * case.chi, 1.0, "$q^*/Q_0$"),
    )
    for panel, (predict, seen, amplitude, label) in zip(panels, fields, strict=True):
        for row, colour in zip(rows, cycle(), strict=False):
            time = history.t[row]
            value = predict(Step(), amplitude, material, x, time).value
            panel.plot(x, value, color=colour, label=f"t = {time:.4f}")
            panel.plot(history.x, seen[row], ".", color=colour, markersize=2.5)
        panel.set(xlabel="x", ylabel=label, ylim=(-0.12, 0.6), xlim=(0, 0.11))
        panel.legend(title="lines exact, dots FEM")
    return figure


def _rate_curves(case: Case, method: str) -> tuple[Array, Array]:
    """Return x/(c_t T) and the slip rate of a method; the published method has no base."""
    if method == "exact":
        return _VELOCITY, case.exact(_VELOCITY)
    if method == "finite elements":
        return case.simulated()
    slip = published_slip(case.chi)
    return 1 / slip.u[::-1], case.chi * slip.slip_rate[::-1]


def _slip_curves(case: Case, method: str) -> tuple[Array, Array]:
    """Return x/(c_t T) and the relative slip over V_0 T of a method."""
    if method == "exact":
        total = case.solution.slip(_VELOCITY * SHEAR_SPEED * END_TIME, END_TIME)
        return _VELOCITY, total / (case.scale * END_TIME)
    if method == "finite elements":
        velocity, _ = case.simulated()
        return velocity, case.history.slip[-1] / (case.scale * case.history.t[-1])
    slip = published_slip(case.chi)
    steps = np.diff(slip.u, prepend=1.0)
    total = np.cumsum(slip.slip_rate * steps) / slip.u
    return 1 / slip.u[::-1], case.chi * total[::-1]


def _draw(panel: Axes, cases: Sequence[Case], method: str, curves: Curves) -> None:
    for case, colour in zip(cases, cycle(), strict=False):
        velocity, value = curves(case, method)
        label = rf"$\chi$ = {case.chi:g}" + (", preloaded" if case.base == "preloaded" else "")
        panel.plot(
            velocity * SHEAR_SPEED * END_TIME,
            value,
            "." if method == "finite elements" else "-",
            color=colour,
            markersize=2,
            linewidth=1.2,
            label=label,
        )
    panel.set(xlabel="x", xlim=(0, 0.105))
    panel.set_title(_title(method), pad=14)
    mark_waves(panel, wave_speeds(cases[0].solution.scene.material), 1 / END_TIME)
    panel.legend()


@styled
def figure_5(cases: Cases) -> Figure:
    """Draw the slip rate for chi > 1 at t = 0.01: published algorithm, exact, finite elements."""
    chosen = [*(cases.remote[chi] for chi in _ABOVE), cases.preloaded[2.0]]
    figure, [panels] = _panels(3, 12)
    for panel, method in zip(panels, METHODS, strict=True):
        shown = chosen[:2] if method == "published" else chosen
        _draw(panel, shown, method, _rate_curves)
    panels[0].set(ylabel=RATE_LABEL, ylim=(-1.0, 0.6))
    return figure


@styled
def figure_6(cases: Cases) -> Figure:
    """Draw slip rate (above) and slip (below) for chi < 1 at t = 0.01, by the three methods."""
    remote = [cases.remote[chi] for chi in _BELOW]
    preloaded = [cases.preloaded[chi] for chi in _BELOW if chi in cases.preloaded]
    figure, rows = _panels(3, 12, rows=2)
    for panels, curves, label in zip(
        rows, (_rate_curves, _slip_curves), (RATE_LABEL, r"slip $/\ (V_0 t)$"), strict=True
    ):
        for panel, method in zip(panels, METHODS, strict=True):
            shown = remote if method == "published" else [*remote, *preloaded]
            _draw(panel, shown, method, curves)
        panels[0].set(ylabel=label)
    rows[0][0].set_ylim(-1.5, 0.4)
    return figure


def _title(method: str) -> str:
    return f"published, {DEFAULT_READING.signs}" if method == "published" else method


@styled
def slot_figure(checks: Sequence[SlotCheck]) -> Figure:
    """Draw the traction under a prescribed pulse of slip: simulation and kernels, both modes."""
    title = r"smooth pulse of slip, $\nu$ = 1/3, $f$ without effect, units $c_t$ = $\mu$ = $t$ = 1"
    figure, [panels] = _panels(len(checks), 4.8 * len(checks), title=title)
    for panel, check in zip(panels, checks, strict=True):
        edge = int(np.searchsorted(check.x, 0.0))
        x, free, held = (np.insert(v, edge, np.nan) for v in (check.x, check.free, check.held))
        panel.plot(x, free, color=PREDICTION, label="kernel, slot face free")
        panel.plot(x, held, color=BROWN, label="kernel, slot face held, (4.31), (4.37)")
        panel.plot(check.x, check.simulated, ".", color=SIMULATION, markersize=3, label="FEM")
        panel.axvline(0, color=ink(0.5), linewidth=0.8)
        panel.set(xlabel="x", ylabel="traction", title=f"mode {check.mode}")
    # Below the panels, for the curves fill them.
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


@dataclass(frozen=True)
class ClaimRow:
    """A claim and the verdict of each method, as in `claims_table`."""

    section: str
    claim: str
    base: str
    published: str
    exact: str
    finite_elements: str


@dataclass(frozen=True)
class CaseRow:
    """Mean difference of exact and simulated slip rates of a case, over V_0 = 2 Q_0/(mu b)."""

    base: str
    chi: float
    poisson_ratio: float
    difference: float


@dataclass(frozen=True)
class SlotRow:
    """Largest difference of each kernel from finite elements with free slot faces."""

    mode: str
    free: float
    held: float


_cases = cache(run_cases)


def claim_rows() -> list[ClaimRow]:
    """Judge all claims on the mesh of the full study."""
    return [
        ClaimRow(
            claim.section,
            claim.text,
            claim.base,
            *(f"{v.verdict}: {v.evidence}" for v in (claim.verdicts[m] for m in METHODS)),
        )
        for claim in judge_claims(_cases(RESOLUTION))
    ]


def case_rows() -> list[CaseRow]:
    """Compare both slip rates of all cases on the mesh of the full study."""
    return [
        CaseRow(
            case.base,
            case.chi,
            case.solution.scene.material.poisson_ratio,
            case.disagreement(),
        )
        for case in _cases(RESOLUTION).everyone()
    ]


def slot_rows() -> list[SlotRow]:
    """Compare the kernels with finite elements in both modes."""
    checks = (check_slot("II", _ELEMENT_SIZE), check_slot("I", _ELEMENT_SIZE))
    return [SlotRow(check.mode, check.error("free"), check.error("held")) for check in checks]


STUDIES: dict[str, Study] = {"claims": claim_rows, "cases": case_rows, "slots": slot_rows}

if __name__ == "__main__":
    raise SystemExit(run_studies("compare.studies.article.study", "article", STUDIES))
