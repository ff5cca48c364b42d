"""Different bodies in numbers: the tables of docs/dissimilar.md.

``python -m compare.studies.dissimilar.tables named thresholds halflines slots honesty cost
witness judged drawn --csv docs/data``
"""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

from compare.studies.dissimilar.honesty import honesty_rows
from compare.studies.dissimilar.judged import drawn_rows, judged_rows
from compare.studies.dissimilar.pairs import NAMED, SCENES, of_contrast
from compare.studies.dissimilar.points import ThresholdPoint, threshold_point
from compare.studies.dissimilar.witness import witness_rows
from compare.studies.tables import Study, run_studies
from semianalytic import PairSolution, SceneError, sliding_stability, solve
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.whole_line import half_line_exponent, half_line_speed

FRICTIONS = (0.2, 0.5, 1.0)
CONTRASTS = (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0, 2.2, 2.5, 3.0, 5.0, 10.0)
HALF_LINES = ((1.4, 0.2), (1.5, 0.2), (1.5, 0.4), (1.8, 0.4), (1.2, 0.2))
_REPEATS = 3


@dataclass(frozen=True)
class NamedRow:
    """Named pair: thresholds, and growth per wavelength [%], velocity over c_t of the upper body,
    and G of a delay at some frictions; nan where nothing grows."""

    pair: str
    friction: float
    threshold_with: float
    threshold_against: float
    growth: float
    velocity: float
    delayed: float


@dataclass(frozen=True)
class HalfLineRow:
    """Speeds of the edge of slip ahead of an over-stressed half-line, over c_t of the slower body,
    with it and against it, and the exponents of slip rate there; nan where there is no answer."""

    contrast: float
    friction: float
    chi: float
    speed_with: float
    speed_against: float
    exponent_with: float
    exponent_against: float


@dataclass(frozen=True)
class SlotRow:
    """A scene of a slot: its zones, in x/t over c_t of the upper body, and how sure they are."""

    scene: str
    zones: str
    error_estimate: float


@dataclass(frozen=True)
class CostRow:
    """Processor seconds of a scene to rtol 1e-8, least of three, with its matrix and functions of
    the pair known and not."""

    scene: str
    edges: int
    nodes: int
    first: float
    seconds: float


def named_rows() -> list[NamedRow]:
    """Return a row for each named pair of solids."""
    rows = []
    for pair, (upper, lower) in NAMED.items():
        for friction in FRICTIONS:
            known = sliding_stability(upper, lower, friction)
            fastest = known.waves[0] if known.waves else None
            rows.append(
                NamedRow(
                    pair,
                    friction,
                    known.threshold_with,
                    known.threshold_against,
                    100 * (fastest.per_wavelength - 1) if fastest else np.nan,
                    fastest.velocity / upper.shear_speed if fastest else np.nan,
                    known.delayed_growth or np.nan,
                )
            )
    return rows


def threshold_rows() -> list[ThresholdPoint]:
    """Thresholds over contrast, equal densities and a Poisson ratio of 1/4."""
    return [threshold_point(contrast) for contrast in CONTRASTS]


def half_line_rows() -> list[HalfLineRow]:
    """Exact answers without a slot."""
    return [
        HalfLineRow(contrast, friction, chi, *_half_line(contrast, friction, chi))
        for contrast, friction in HALF_LINES
        for chi in (1.0, 2.0)
    ]


def _half_line(contrast: float, friction: float, chi: float) -> list[float]:
    """Speeds with and against the slower body, then exponents."""
    compliance, speeds, exponents = compliance_of(*of_contrast(contrast)), [], []
    for sense in (1, -1):
        try:
            speeds.append(half_line_speed(compliance, sense * friction, chi))
            exponents.append(half_line_exponent(compliance, sense * friction, speeds[-1]))
        except SceneError:
            speeds.append(np.nan)
            exponents.append(np.nan)
    return [*speeds, *exponents]


def slot_rows() -> list[SlotRow]:
    """Exact answers with a slot."""
    rows = []
    for name, pair in SCENES.items():
        answer = solve(pair, rtol=1e-9)
        rows.append(SlotRow(name, zones_text(answer), answer.error_estimate))
    return rows


def zones_text(answer: PairSolution) -> str:
    """Zones from the slot outward, as "open 0 to 0.1, slip + 0.1 to 0.5"."""
    parts = [(part.inner, part.outer, "open") for part in answer.openings]
    signs = {1: "slip +", -1: "slip −"}
    parts += [(zone.inner, zone.outer, signs[zone.sense]) for zone in answer.zones]
    return ", ".join(f"{what} {inner:.8g} to {outer:.8g}" for inner, outer, what in sorted(parts))


def cost_rows() -> list[CostRow]:
    """Measure the processor time that each scene takes."""
    rows = []
    for name, pair in SCENES.items():
        seconds = []
        for _ in range(_REPEATS + 1):
            start = process_time()
            answer = solve(pair)
            seconds.append(process_time() - start)
        statistics = answer.statistics
        first, *others = seconds
        rows.append(CostRow(name, statistics.unknowns, statistics.nodes, first, min(others)))
    return rows


STUDIES: dict[str, Study] = {
    "named": named_rows,
    "thresholds": threshold_rows,
    "halflines": half_line_rows,
    "slots": slot_rows,
    "honesty": honesty_rows,
    "cost": cost_rows,
    "witness": witness_rows,
    "judged": judged_rows,
    "drawn": drawn_rows,
}

if __name__ == "__main__":
    raise SystemExit(run_studies("compare.studies.dissimilar.tables", "dissimilar", STUDIES))
