"""Error bars of records of another code, from its other grids or from its grid spacing alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from compare.comparison.bars import observed_order
from compare.records.record import Record, Records
from compare.validation.exact import AT_TIME, Exact, Sampling
from compare.validation.norms import station_size, weights
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

SMEAR: dict[str, float] = {
    "slip_rate": 1.0,
    "slip": 0.25,
    "shear_traction": 0.8,
    "pressure": 0.4,
}
"""Error of a scheme that is of first order at fronts, as a part of the error that a shift of the
record by one cell, in space or in time, would cause.

These four, and what follows, were set on random scenes computed by our finite elements and our
marcher, and tried on others and on other codes; docs/data/validate-constants.csv has the effect of
half and twice of each.
"""
BRIEF = 2.0
"""Relative error of slip that lasts for one cell only; it may be too small or too large."""
LONG = 10.0
"""If slip lasts for more than this many cells, its missing part falls with the square of their
number and not with the number itself: friction then rounds off only the ends of slip."""
CARRIED = 0.2
"""Error at a quiet station over the mean quantity at all stations and over spacing / (c_t T)."""
LEAST = 1e-3
"""Least relative error bar that any record is given."""
SLOW = 1e-3
"""Slip rate over V_0 below which the contact counts as stuck; what a march leaves there is less."""
UNSEEN = 2.0
"""All grids may miss alike slip that lasts for at most this many cells of the finest grid."""
FLOOR = 0.05
"""Least error from differences of grids, as a part of the smear by one cell."""
GCI, FEW_GRIDS = 1.25, 3.0
"""Factors of safety of the grid convergence index: of three grids or more, and of two."""
ORDERS = (0.4, 4.0)
"""Limits between which an observed order of convergence is accepted."""
PROFILE = 20
"""Evenly spaced stations, if there are this many, are taken for the points of a grid."""
EVEN = 0.01
USUAL_RATIO = 2.0
SAME_PLACE = 1e-6


@dataclass(frozen=True, eq=False)
class Grids:
    """Runs of one code, finest first, read in units of the scene."""

    runs: tuple[Records, ...]
    spacing: float | None  # spacing of the finest run [length]
    ratio: float  # ratio of the spacings of two successive runs
    sampling: Sampling = AT_TIME  # meaning of a slip rate
    # standard deviation of the errors of samples, in units of the scene
    noise: Mapping[str, float] = field(default_factory=dict)

    @property
    def finest(self) -> Records:
        """The run that is judged."""
        return self.runs[0]


def arranged(
    runs: Sequence[Records],
    spacings: Sequence[float | None],
    sampling: Sampling,
    noise: Mapping[str, float],
) -> tuple[Grids, tuple[str, ...]]:
    """Runs in order, finest first, and what had to be guessed of their grids.

    They come at rising resolution, unless spacings [length] say otherwise; sampling and noise are
    those of `Grids`.  Two runs of one spacing are refused by a SceneError.
    """
    notes: list[str] = []
    sizes = []
    for run, given in zip(runs, spacings, strict=True):
        size = given if given is not None else run.spacing
        if size is None and (size := profile_spacing(run)) is not None:
            notes.append(f"spacing {size:.4g}: the distance of the stations of a whole profile")
        sizes.append(size)
    pairs = list(zip(runs, sizes, strict=True))
    if all(size is not None for size in sizes):
        pairs.sort(key=lambda pair: pair[1] or 0.0)
    else:
        pairs.reverse()
    ratio, size = USUAL_RATIO, pairs[0][1]
    if len(pairs) > 1:
        second = pairs[1][1]
        if size is not None and second is not None:
            ratio = second / size
            if ratio < 1.05:
                raise SceneError(
                    f"validate: two runs have the same spacing, {size:.4g}; give runs of different "
                    "resolution, or the spacing of each."
                )
        else:
            notes.append(
                "resolutions: files are taken to be given from coarse to fine, each with "
                "half the spacing of the one before"
            )
    return Grids(tuple(run for run, _ in pairs), size, ratio, sampling, noise), tuple(notes)


def profile_spacing(run: Records) -> float | None:
    """Distance of the stations of a run [length] if they are all points of a grid."""
    places = np.array([record.x for record in run.stations])
    if len(places) < PROFILE:
        return None
    steps = np.diff(places)
    middle = float(np.median(steps))
    even = np.abs(steps - middle) <= EVEN * middle
    return middle if middle > 0 and even.mean() > 0.9 else None


def smear(grids: Grids, band: float, record: Record, name: str, exact: Exact) -> float:
    """Return the relative L1 error that a shift by one cell, a band [length], may cause."""
    if name == "slip_rate" and len(record.t) > 1:
        step = float(np.median(np.diff(record.t)))
        band = max(band, 0.5 * step * exact.scene.material.shear_speed)
    expected = exact.record(name, record.x, record.t, grids.sampling)
    weight = weights(record.t, record.values[name])
    size = station_size(expected, weight, exact.unit(name))
    moved = exact.smeared(name, record.x, record.t, band)
    return max(float(weight @ np.abs(other - expected)) for other in moved) / size


def spacing_bar(
    grids: Grids, record: Record, name: str, exact: Exact, everywhere: float
) -> float | None:
    """Error bar of a record from the spacing of its grid alone, relative as its L1 error.

    `everywhere` is the mean |quantity| of the exact answer at all stations over that at this one.
    """
    if grids.spacing is None:
        return None
    part = SMEAR[name] * smear(grids, grids.spacing, record, name, exact)
    if name == "slip":
        part += BRIEF * brief_part(grids.spacing, record, name, exact)
    cells = grids.spacing / (exact.scene.material.shear_speed * exact.end_time)
    return part + CARRIED * cells * everywhere + LEAST


def brief_part(
    spacing: float, record: Record, name: str, exact: Exact, longest: float = np.inf
) -> float:
    """Part of slip or slip rate at a station that grids may miss because it lasts for few cells.

    Where a slip zone is narrow its slip is not displaced but smaller or larger, and stays so: each
    stretch of slip counts with one over the number of cells, of a spacing [length], it lasts for.
    Stretches that last longer than so many cells do not count.
    """
    t = record.t
    rate, slip = (exact.record(name, record.x, t) for name in ("slip_rate", "slip"))
    slips = np.abs(rate) > SLOW * exact.unit("slip_rate")
    edges = np.diff(slips.astype(int), prepend=0, append=0)
    grown = np.abs(np.diff(slip, prepend=slip[:1]))
    missed = np.zeros(len(t))
    starts, stops = (np.flatnonzero(sign * edges > 0).tolist() for sign in (1, -1))
    for start, stop in zip(starts, stops, strict=True):
        first, last = max(start - 1, 0), min(stop, len(t) - 1)
        lasts = exact.scene.material.shear_speed * float(t[last] - t[first])
        if lasts > longest * spacing:
            continue
        share = min(spacing / lasts, 1.0) if lasts > 0 else 1.0
        missed[start : last + 1] += grown[start : last + 1] * share * min(LONG * share, 1.0)
    if name == "slip_rate":
        return float(missed.sum() / grown.sum()) if grown.any() else 0.0
    weight = weights(t, record.values["slip"])
    size = station_size(slip, weight, exact.unit("slip"))
    return float(weight @ np.cumsum(missed)) / size


def unseen_part(grids: Grids, record: Record, name: str, exact: Exact) -> float:
    """Part of a record that all grids may miss alike, so that they do not differ by it.

    0 where nothing is said of their spacing.
    """
    if grids.spacing is None:
        return 0.0
    part = FLOOR * smear(grids, grids.spacing, record, name, exact)
    if name in ("slip", "slip_rate"):
        part = max(part, BRIEF * brief_part(grids.spacing, record, name, exact, UNSEEN))
    return part


def changes(grids: Grids, record: Record, name: str, exact: Exact) -> list[float]:
    """Relative L1 differences of runs that follow each other, finest first, at one station."""
    values = [_seen(run, record, name) for run in grids.runs]
    expected = exact.record(name, record.x, record.t, grids.sampling)
    found: list[float] = []
    for fine, other in pairwise(values):
        if fine is None or other is None:
            break
        weight = weights(record.t, fine - other)
        if not weight.any():
            break
        size = station_size(expected, weight, exact.unit(name))
        found.append(float(weight @ np.nan_to_num(np.abs(fine - other))) / size)
    return found


def grid_bar(grids: Grids, differences: Sequence[float]) -> tuple[float, float | None]:
    """Error bar from differences of runs that follow each other, and the order that they show.

    Roache's grid convergence index: what changed last over ratio^order - 1, times `GCI` where three
    grids show an order, and times `FEW_GRIDS`, at first order, where they show none to be believed
    or there are two.  No order is believed to be above the first.
    """
    order = observed_order(differences, grids.ratio)
    largest = max(abs(change) / grids.ratio**step for step, change in enumerate(differences))
    if order is None or not ORDERS[0] <= order <= ORDERS[1]:
        return max(FEW_GRIDS * largest / (grids.ratio - 1), LEAST), order
    power = min(order, 1.0)
    return max(GCI * largest / (grids.ratio**power - 1), LEAST), order


def _seen(run: Records, record: Record, name: str) -> Array | None:
    """Interpolate a run at the station and times of a record of another run; None without it."""
    size = SAME_PLACE * max(abs(record.x), 1e-300)
    same = [station for station in run.stations if abs(station.x - record.x) <= size]
    if not same or name not in same[0].values:
        return None
    same_place = same[0]
    return np.interp(record.t, same_place.t, same_place.values[name], left=np.nan, right=np.nan)
