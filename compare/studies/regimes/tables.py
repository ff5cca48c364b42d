"""Thresholds of slip over the Poisson ratio: the tables of docs/regimes.md.

Run as ``python -m compare.studies.regimes.tables thresholds reverse opening viscosity --csv
docs/data``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from compare.studies.regimes.openings import AHEAD, opening_point
from compare.studies.regimes.viscosity import viscosity_rows
from compare.studies.tables import Study, run_studies
from semianalytic import Material
from semianalytic.reference import edge_speed_of_opening
from semianalytic.regimes.reverse_slip import log_frictionless_half_width, reverse_threshold
from semianalytic.regimes.thresholds import (
    edge_threshold_alone,
    front_threshold_stuck,
    gap_threshold,
    nucleation,
    opening_threshold,
)

POISSON_RATIOS = (-0.9, -0.5, -0.2, 0.0, 0.2, 1 / 3, 0.4, 0.45)
REVERSE_POISSON_RATIOS = (-0.9, -0.5, -0.2, 0.0, 0.2, 0.25, 0.3, 1 / 3, 0.4, 0.45)


@dataclass(frozen=True)
class ThresholdRow:
    """Frictions chi at which the regime changes; `gap` is nan if there is no such friction."""

    poisson_ratio: float
    preload_nucleation: float
    edge: float
    stuck_front: float
    remote_nucleation: float
    gap: float


@dataclass(frozen=True)
class ReverseRow:
    """Limit of reverse slip of a preloaded interface.

    It holds the friction below which slip reverses, and the half-width over c_R of the reversed
    strip without friction.
    """

    poisson_ratio: float
    threshold: float
    half_width: float


@dataclass(frozen=True)
class OpeningRow:
    """Openings under a step of pressure.

    It holds the base over the step below which the contact opens ahead; the speeds over c_t at
    which it closes and opens for half that base; and the speed up to which it opens from the edge
    under a step of -1 base.
    """

    poisson_ratio: float
    threshold: float
    inner: float
    outer: float
    from_edge: float


def threshold_rows() -> list[ThresholdRow]:
    """Compute the thresholds of both loadings."""
    rows = []
    for nu in POISSON_RATIOS:
        gap = gap_threshold("remote", nu)
        rows.append(
            ThresholdRow(
                nu,
                nucleation("preload", nu),
                edge_threshold_alone(nu),
                front_threshold_stuck(nu),
                nucleation("remote", nu),
                math.nan if gap is None else gap,
            )
        )
    return rows


def reverse_rows() -> list[ReverseRow]:
    """Compute the limits of reverse slip under a preload."""
    return [
        ReverseRow(nu, reverse_threshold(nu), math.exp(log_frictionless_half_width(nu)))
        for nu in REVERSE_POISSON_RATIOS
    ]


def opening_rows() -> list[OpeningRow]:
    """Compute the openings under a step of pressure."""
    rows = []
    for nu in POISSON_RATIOS:
        threshold = opening_threshold(nu)
        half = opening_point(nu, AHEAD, threshold / 2)
        edge = edge_speed_of_opening(Material(1.0, 1.0, nu), 1.0)
        rows.append(OpeningRow(nu, threshold, half.inner, half.outer, edge))
    return rows


STUDIES: dict[str, Study] = {
    "thresholds": threshold_rows,
    "reverse": reverse_rows,
    "opening": opening_rows,
    "viscosity": viscosity_rows,
}

if __name__ == "__main__":
    raise SystemExit(run_studies("compare.studies.regimes.tables", "regimes", STUDIES))
