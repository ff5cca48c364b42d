"""Rows of a validation: each quantity at each station, arrivals, strength."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy

from compare.comparison.judging import BY_LITTLE
from compare.comparison.measures import NOTHING, first_above, nearest
from compare.comparison.rows import TELLING, UNRESOLVED
from compare.comparison.scales import stress_scale
from compare.records.record import QUANTITIES, Record, Records
from compare.validation.bars import ALARM, SCATTER, Bar, JudgedRow, pooled_bar, station_bar
from compare.validation.exact import Exact, compared
from compare.validation.grids import Grids, grid_bar
from compare.validation.norms import Norm, pooled, station_norm, weights
from semianalytic.scene.arrays import Array, Mask

PLACES = (0.1, 0.25, 0.5, 0.75, 0.95)
"""Positions over c_t T.  If a run has more stations, only those nearest to these have own rows."""
THRESHOLD = 0.01
"""Slip rate at which slip counts as begun, over the largest load / (rho c_t)."""
FEW = 4
"""Least number of samples that a record must have to be judged."""
COVERED = 0.5
"""Part of the time of a record that has to be free of gaps for a row to be judged."""
NOISY = 5.0
"""Least threshold of slip rate in standard deviations of the noise.  By chance one sample in three
million exceeds it; at half of it one in a hundred does."""
TIMES = 2000
"""Number of times at which an exact onset is sought."""
SMOOTHED = (2.0, 5.0)
"""Widths, in cells, over which slip rate is averaged to see how far a grid may shift an onset."""
SLIDING = 0.05
"""Part of the largest slip rate of a station above which it slides for sure."""
STRENGTH_FLOOR = 0.005
MEDIAN_NOISE = math.sqrt(math.pi / 2)
"""Standard deviation of a median of normally distributed samples, over that of their mean."""
BETWEEN = f"{BY_LITTLE.format(ALARM)}; a finer grid or the true noise would decide it"
NO_GRID = "nothing says how fine the grid is; give `spacing`"
ONE_FACE = (
    "one face moves by more than half of the slip where pressure acts on it; record both faces"
)
CREEP = "the contact creeps, so slowly compared with V₀ that slip is not judged"


def rows(grids: Grids, exact: Exact, threshold: float | None, *, face: bool) -> Iterator[JudgedRow]:
    """All rows of a validation.

    Slip counts as begun at the threshold [length / time]; `face` says that it was made of the
    motion of one face.
    """
    found = itertools.chain(
        arrival_rows(grids, exact, threshold),
        *(quantity_rows(grids, exact, name, face=face) for name in QUANTITIES),
        strength_rows(grids, exact),
    )
    for row in found:
        between = row.verdict == UNRESOLVED and not row.obstacle
        yield replace(row, obstacle=BETWEEN) if between else row


def quantity_norms(grids: Grids, exact: Exact, name: str) -> list[tuple[Record, Norm]]:
    """Records of one quantity with their norms."""
    norms = (
        (record, station_norm(record, name, exact, grids.sampling))
        for record in grids.finest.stations
    )
    return [(record, norm) for record, norm in norms if norm is not None]


def quantity_rows(grids: Grids, exact: Exact, name: str, *, face: bool) -> Iterator[JudgedRow]:
    """One quantity, at all stations together and at single ones."""
    known = quantity_norms(grids, exact, name)
    if not known:
        return
    whole = pooled([norm for _, norm in known])
    sizes = [norm.exact if norm.exact > NOTHING else 1.0 for _, norm in known]
    obstacle = ""
    if name in ("slip", "slip_rate"):
        slow = 0.0 < whole.exact <= NOTHING and exact.scene.on_line
        obstacle = ONE_FACE if face else CREEP if slow else ""
    bars = [
        station_bar(grids, record, name, exact, whole.exact / size)
        for (record, _), size in zip(known, sizes, strict=True)
    ]
    if len(known) > 1:
        bar = pooled_bar(bars, sizes, whole.exact if whole.exact > NOTHING else 1.0)
        yield _row("all stations", name, exact, whole, bar, obstacle, grids)
    chosen = chosen_stations([record.x for record, _ in known], exact)
    for place in chosen:
        (record, norm), bar = known[place], bars[place]
        where = f"at {_over(record.x, exact):.3g} c_t T"
        few = _too_few(record, name, norm)
        yield _row(where, name, exact, norm, bar, obstacle or few, grids)


def _too_few(record: Record, name: str, norm: Norm) -> str:
    """Reason why a record with gaps is not judged; "" if it is."""
    if norm.samples < FEW:
        return f"fewer than {FEW} samples"
    whole = float(record.t[-1] - record.t[0])
    share = float(weights(record.t, record.values[name]).sum()) / whole if whole else 0.0
    if share < COVERED:
        return f"{100 * (1 - share):.0f} % of the time is gaps"
    return ""


def _row(
    where: str,
    name: str,
    exact: Exact,
    norm: Norm,
    bar: Bar,
    obstacle: str,
    grids: Grids,
) -> JudgedRow:
    kind = name.replace("_", " ")
    units = {"slip_rate": "V₀", "slip": "V₀ T"}
    whole = bar.whole
    if whole is None:
        obstacle = obstacle or NO_GRID
    elif whole > TELLING:
        obstacle = obstacle or _too_wide(bar, grids, exact)
    return bar.row(
        f"{kind} {where}",
        kind,
        norm.exact,
        norm.simulated,
        norm.L1,
        unit=units.get(name, "τ₀"),
        relative=True,
        obstacle=obstacle,
        resolution=_cells(grids, exact, bar),
    )


def _too_wide(bar: Bar, grids: Grids, exact: Exact) -> str:
    """Why a bar is too wide, and what would narrow it."""
    grid = bar.grid or 0.0
    if bar.data >= max(grid, bar.answer):
        return f"the noise of the data makes its bar {100 * (bar.whole or 0.0):.2g} % long"
    if bar.answer >= grid:
        return f"the error of the answer makes its bar {100 * (bar.whole or 0.0):.2g} % long"
    cells = _cells(grids, exact, bar)
    remedy = f"; {cells} cells over c_t T suffice" if cells else "; a finer grid is needed"
    return f"this grid makes its bar {100 * (bar.whole or 0.0):.2g} % long{remedy}"


def _cells(grids: Grids, exact: Exact, bar: Bar) -> int | None:
    """Cells over c_t T with which a bar would be as narrow as it has to be."""
    if not grids.spacing or bar.whole is None or bar.grid is None or bar.whole <= TELLING:
        return None
    room = TELLING - bar.data - bar.answer
    if room <= 0 or math.isinf(bar.grid):
        return None
    length = exact.scene.material.shear_speed * exact.end_time
    return int(np.ceil(length / grids.spacing * bar.grid / room))


def chosen_stations(places: Sequence[float], exact: Exact) -> list[int]:
    """Stations that have rows of their own."""
    if len(places) <= len(PLACES):
        return list(range(len(places)))
    over = np.abs([_over(place, exact) for place in places])
    return sorted({nearest(over, place) for place in PLACES})


def _over(x: float, exact: Exact) -> float:
    return x / (exact.scene.material.shear_speed * exact.end_time)


def arrival_rows(grids: Grids, exact: Exact, threshold: float | None) -> Iterator[JudgedRow]:
    """When slip begins, at stations and in a file of rupture times."""
    material = exact.scene.material
    least = threshold or THRESHOLD * stress_scale(exact.scene) / material.shear_impedance
    least = max(least, NOISY * grids.noise.get("slip_rate", 0.0))
    runs = [_arrivals(run, least) for run in grids.runs]
    places = [x for x in sorted(runs[0]) if compared(exact.scene, [x], exact.end_time)[0]]
    chosen = [places[place] for place in chosen_stations(places, exact)]
    for x in chosen:
        onset = Onset(exact, x, least)
        if onset.time is not None:
            yield _arrival_row(grids, exact, onset, [run.get(x) for run in runs])


def _arrival_row(
    grids: Grids, exact: Exact, onset: Onset, times: Sequence[float | None]
) -> JudgedRow:
    """An onset at one station, by all runs, finest first."""
    expected, seen, end = onset.time or 0.0, times[0], exact.end_time
    bar = _arrival_bar(grids, exact, onset, times)
    whole = bar.whole
    obstacle = NO_GRID if grids.spacing is None else ""  # all grids may miss what is too narrow
    if whole is not None and whole * end > TELLING * expected:
        obstacle = "what begins to slip here is too weak, or too narrow, for this grid"
    name = f"arrival at {_over(onset.x, exact):.3g} c_t T"
    off = (None, None) if seen is None else (seen / end, (seen - expected) / end)
    return bar.row(name, "arrival", expected / end, *off, unit="T", obstacle=obstacle)


class Onset:
    """When slip at a point becomes faster than a threshold, also as a grid might see it."""

    def __init__(self, exact: Exact, x: float, threshold: float) -> None:
        self.x, self.threshold, self.end_time = x, threshold, exact.end_time
        self.t = np.linspace(0.0, exact.end_time, TIMES + 1)[1:]
        self.rate = exact.record("slip_rate", x, self.t)
        self.time = first_above(self.t, np.abs(self.rate), threshold)

    def reach(self, width: float) -> float:
        """How far it may be off [time] for a grid that smears it over a time."""
        return self._farthest(
            first_above(self.t, self._smoothed(cells * width), factor * self.threshold)
            for cells in (0.0, *SMOOTHED)
            for factor in (0.5, 1.0, 2.0)
        )

    def jitter(self, noise: float) -> float:
        """How far noise of a standard deviation [length / time] may move it [time]."""
        levels = (self.threshold - SCATTER * noise, self.threshold + SCATTER * noise)
        size = np.abs(self.rate)
        return self._farthest(first_above(self.t, size, level) for level in levels if noise)

    def _farthest(self, times: Iterable[float | None]) -> float:
        ends = (2 * self.end_time if time is None else time for time in times)
        return max((abs(time - (self.time or 0.0)) for time in ends), default=0.0)

    def _smoothed(self, width: float) -> Array:
        samples = round(width / float(self.t[1] - self.t[0]))
        mean = scipy.ndimage.uniform_filter1d(self.rate, max(samples, 1), mode="nearest")
        return np.abs(mean)


def _arrivals(run: Records, threshold: float) -> dict[float, float | None]:
    """Onsets by position of one run; records with gaps, or that begin too late, are left out."""
    onsets: dict[float, float | None] = {}
    if run.arrivals is not None:
        pairs = zip(*run.arrivals, strict=True)
        onsets = {float(x): float(t) if np.isfinite(t) else None for x, t in pairs}
    for record in run.stations:
        rate = record.values.get("slip_rate")
        if rate is None or len(rate) < FEW or not np.isfinite(rate).all():
            continue
        if abs(rate[0]) <= threshold:
            onsets[record.x] = first_above(record.t, np.abs(rate), threshold)
    return onsets


def _between_samples(run: Records, exact: Exact, onset: Onset, time: float) -> float:
    """Return how far the samples of a station leave its onset open [time]; 0 of a list of arrivals.

    The onset lies anywhere between two samples, for the slip rate jumps at fronts; and slip that
    passes between two samples is missed, as it is if the exact answer is sampled at the same times.
    """
    for record in run.stations:
        if record.x == onset.x and "slip_rate" in record.values:
            after = int(np.clip(np.searchsorted(record.t, time), 1, len(record.t) - 1))
            rate = np.abs(exact.record("slip_rate", record.x, record.t))
            sampled = first_above(record.t, rate, onset.threshold)
            late = exact.end_time if sampled is None else abs(sampled - (onset.time or 0.0))
            interval = float(record.t[after] - record.t[after - 1])
            # later than one interval: slip passed between two samples; else the interval is all
            return interval if late <= interval else late + interval
    return 0.0


def _arrival_bar(grids: Grids, exact: Exact, onset: Onset, times: Sequence[float | None]) -> Bar:
    """How far an onset may be off, over T, and the order that other grids show.

    A threshold is crossed by whole steps and ripples: what changes from grid to grid is never
    believed to be less than what the finest spacing alone leaves open.
    """
    end = exact.end_time
    cell = None if grids.spacing is None else grids.spacing / exact.scene.material.shear_speed
    alone = None if cell is None else (2 * cell + onset.reach(cell)) / end
    seen = end if times[0] is None else times[0]
    between = _between_samples(grids.finest, exact, onset, seen)
    data = (onset.jitter(grids.noise.get("slip_rate", 0.0)) + between) / end
    known = [time for time in times if time is not None]
    if not len(known) == len(times) > 1:
        return Bar(alone, data)
    differences = [value - other for value, other in pairwise(known)]
    bar, order = grid_bar(grids, [change / end for change in differences])
    return Bar(max(bar, alone or 0.0), data, order=order)


def strength_rows(grids: Grids, exact: Exact) -> Iterator[JudgedRow]:
    """Shear traction where the contact slides for sure, over the exact one: the friction law."""
    if grids.spacing is None:
        return
    ratios: list[Array] = []
    moved: list[Array] = []
    sizes: list[Array] = []
    for record in grids.finest.stations:
        values = record.values.get("shear_traction")
        if values is None:
            continue
        sliding = _slides(exact, record, 2 * grids.spacing) & (weights(record.t, values) > 0)
        if "slip_rate" in record.values:
            peak = np.nanmax(np.abs(record.values["slip_rate"]), initial=0.0)
            sliding &= np.abs(record.values["slip_rate"]) > SLIDING * peak
        if not sliding.any():
            continue
        expected = exact.record("shear_traction", record.x, record.t)
        smeared = exact.smeared("shear_traction", record.x, record.t, grids.spacing)
        ratios.append(values[sliding] / expected[sliding])
        sizes.append(np.abs(expected[sliding]))
        moved.append(np.abs(np.stack(smeared)[:, sliding] / expected[sliding] - 1).max(axis=0))
    count = sum(map(len, ratios))
    if count < FEW:
        return
    seen = float(np.median(np.concatenate(ratios)))
    noise = grids.noise.get("shear_traction", 0.0) / float(np.median(np.concatenate(sizes)))
    bar = Bar(
        STRENGTH_FLOOR + float(np.median(np.concatenate(moved))),
        SCATTER * MEDIAN_NOISE * noise / math.sqrt(count),
    )
    whole = bar.whole or 0.0
    obstacle = "" if whole <= TELLING else _too_wide(bar, grids, exact)
    name, kind = "strength where it slides", "shear traction"
    yield bar.row(name, kind, 1.0, seen, seen - 1, unit="exact", relative=True, obstacle=obstacle)


def _slides(exact: Exact, record: Record, band: float) -> Mask:
    """Return where the exact contact slides at a record, even if a grid smeared the slip rate."""
    rate = np.abs(exact.record("slip_rate", record.x, record.t))
    traction = np.abs(exact.record("shear_traction", record.x, record.t))
    least = max(SLIDING * rate.max(initial=0.0), 1e-3 * exact.unit("slip_rate"))
    slides = (rate > least) & (traction > 1e-4 * exact.unit("shear_traction"))
    for other in exact.smeared("slip_rate", record.x, record.t, band):
        slides &= np.abs(other) > least
    return slides
