"""Points of regime maps and of their boundaries over (nu, chi), and their tables.

For loadings and units see `semianalytic.regimes`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from compare.output.files import write_text
from compare.output.tables import append_rows, sound_rows
from semianalytic import Solution, regimes, solve
from semianalytic.regimes import Loading, regime, scene_of, stuck_threshold
from semianalytic.scene.errors import ComputationError
from semianalytic.sweeps.sweep import sweep

REGIMES = {
    "stuck": "fully stuck",
    "slow": "slip slower than the Rayleigh wave",
    "front": "slip at the shear wave, edge stuck",
    "two": "second zone ahead, stick gap at $c_R$",
    "one": "one zone past $c_R$ (gap < 1e-14)",
    "everywhere": "slip everywhere",
    "reverse": "reverse slip present",
    "failed": "not solved",
}
POISSON_RATIOS = (-0.9, 0.49)
MAP_RTOL = 1e-8
_PRELOAD_DECADES = (-3.0, 0.0)
_REMOTE_SHARES = (-0.1, 1.1)


@dataclass(frozen=True)
class MapPoint:
    """One solved scene of a map, a row of its CSV file.

    Attributes
    ----------
    loading, poisson_ratio, chi : str, float, float
        Arguments of `semianalytic.regimes.scene_of`.
    regime : str
        A key of `REGIMES`.
    zones : str
        "inner:outer:sense" of each zone from the edge outward, speeds in c_t.
    status, error_estimate : str, float
        Status and error estimate of the solution.
    """

    loading: str
    poisson_ratio: float
    chi: float
    regime: str
    zones: str
    status: str
    error_estimate: float


@dataclass(frozen=True)
class BoundaryPoint:
    """One point of a traced curve; for the curve "reverse-width", chi is a half-width."""

    loading: str
    curve: str
    poisson_ratio: float
    log10_chi: float


def poisson_ratios(count: int, corners: bool = False) -> NDArray[np.float64]:
    """Return the Poisson ratios of a map: centres of equal cells, or their corners."""
    return (_corners if corners else _middles)(*POISSON_RATIOS, count)


def frictions(
    loading: Loading, poisson_ratio: float, count: int, corners: bool = False
) -> NDArray[np.float64]:
    """Return the frictions chi of a map's column, ascending: centres of cells, or their corners.

    For a preload they have equal steps of log chi from 1e-3 to 1.  For a remote load they have
    equal steps from slightly below 1, where the whole contact slips, to slightly above the friction
    at which nothing slips.
    """
    levels = _corners if corners else _middles
    if loading == "preload":
        return 10.0 ** levels(*_PRELOAD_DECADES, count)
    return 1 + levels(*_REMOTE_SHARES, count) * (stuck_threshold(poisson_ratio) - 1)


def _middles(low: float, high: float, count: int) -> NDArray[np.float64]:
    return low + (high - low) * (np.arange(count) + 0.5) / count


def _corners(low: float, high: float, count: int) -> NDArray[np.float64]:
    return np.linspace(low, high, count + 1)


def map_point(loading: Loading, poisson_ratio: float, chi: float) -> MapPoint:
    """Solve one scene of a map; a scene that cannot be solved has the regime "failed"."""
    try:
        solution = solve(scene_of(loading, poisson_ratio, chi), rtol=MAP_RTOL)
    except ComputationError as error:
        return MapPoint(loading, poisson_ratio, chi, "failed", "", str(error), math.inf)
    return _point(loading, poisson_ratio, solution)


def _point(loading: Loading, poisson_ratio: float, solution: Solution) -> MapPoint:
    speed = solution.scene.material.shear_speed
    zones = " ".join(
        f"{zone.inner / speed:.12g}:{zone.outer / speed:.12g}:{zone.sense:+d}"
        for zone in solution.zones
    )
    chi, name = solution.scene.friction, regime(solution)
    status, estimate = solution.status, solution.error_estimate
    return MapPoint(loading, poisson_ratio, chi, name, zones, status, estimate)


def map_column(loading: Loading, poisson_ratio: float, count: int) -> list[MapPoint]:
    """Solve all points of one Poisson ratio of a map."""
    return map_points(loading, poisson_ratio, frictions(loading, poisson_ratio, count).tolist())


def map_points(loading: Loading, poisson_ratio: float, chi: Sequence[float]) -> list[MapPoint]:
    """Solve points of given frictions in one sweep, or one by one if the sweep fails."""
    try:
        swept = sweep(scene_of(loading, poisson_ratio, chi[0]), chi, MAP_RTOL)
    except ComputationError:
        return [map_point(loading, poisson_ratio, value) for value in chi]
    return [_point(loading, poisson_ratio, solution) for solution in swept.solutions]


def trace(loading: Loading, poisson_ratio: float) -> list[BoundaryPoint]:
    """Trace all boundary curves at one Poisson ratio.

    Both loadings have the curves "nucleation" and "gap"; the latter is absent if the gap at c_R
    never gets that narrow.  A remote load adds "edge" and "everywhere".  A preload adds "reverse"
    and "reverse-width", the half-width of the reversed strip over c_R as friction vanishes.
    """
    levels: dict[str, float | None] = {
        "nucleation": math.log10(regimes.nucleation(loading, poisson_ratio)),
    }
    gap = regimes.gap_threshold(loading, poisson_ratio)
    levels["gap"] = None if gap is None else math.log10(gap)
    if loading == "remote":
        levels["edge"] = math.log10(regimes.edge_threshold(poisson_ratio))
        levels["everywhere"] = 0.0
    else:
        levels["reverse"] = math.log10(regimes.reverse_threshold(poisson_ratio))
        width = regimes.log_frictionless_half_width(poisson_ratio)
        levels["reverse-width"] = width / math.log(10)
    return [
        BoundaryPoint(loading, curve, poisson_ratio, value)
        for curve, value in levels.items()
        if value is not None
    ]


def zone_speeds(point: MapPoint) -> list[tuple[float, float, int]]:
    """Return (inner, outer, sense) of the zones of a point, speeds in c_t."""
    parts = (zone.split(":") for zone in point.zones.split())
    return [(float(inner), float(outer), int(sense)) for inner, outer, sense in parts]


def sorted_points(points: Iterable[MapPoint]) -> list[MapPoint]:
    """Sort points by loading, Poisson ratio and friction."""
    return sorted(points, key=lambda point: (point.loading, point.poisson_ratio, point.chi))


def kept_columns(path: Path, loading: Loading, count: int) -> dict[float, list[MapPoint]]:
    """Return the complete columns of a map in an unfinished table, by Poisson ratio.

    Incomplete or damaged columns are removed from the table.
    """
    if not path.exists():
        return {}
    columns: dict[float, list[MapPoint]] = {nu: [] for nu in poisson_ratios(count).tolist()}
    for point in sound_rows(path, MapPoint):
        if point.loading == loading and point.poisson_ratio in columns:
            columns[point.poisson_ratio].append(point)
    whole = {nu: points for nu, points in columns.items() if len(points) == count}
    write_text(path, "")
    append_rows(path, [point for points in whole.values() for point in points])
    return whole
