"""Rows of a validation: each quantity at each station, arrivals, strength."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.measures import NOTHING, onset_time
from compare.comparison.rows import TELLING, Row
from compare.comparison.scales import stress_scale
from compare.records.record import QUANTITIES, Record, Records
from compare.validation.exact import Exact
from compare.validation.grids import FLOOR, Grids, changes, grid_bar, smear, spacing_bar
from compare.validation.norms import Norm, pooled, station_norm, weights

Array = NDArray[np.float64]

PLACES = (0.1, 0.25, 0.5, 0.75, 0.95)
"""Over c_t T; of more stations than these, those next to them have rows of their own."""
THRESHOLD = 0.01
"""Of the largest load over rho c_t, slip rate at which slip counts as begun."""
FEW = 4
"""Samples that a record has at least."""
TIMES = 2000
"""At which an exact onset is looked for."""
SMOOTHED = (2.0, 5.0)
"""Cells that slip has to last longer than to be seen when it begins."""
SLIDING = 0.05
"""Part of the largest slip rate of a station above which it slides for sure."""
STRENGTH_FLOOR = 0.005
NO_GRID = "nothing says how fine the grid is; give `spacing`"
ONE_FACE = (
    "one face moves by more than half of the slip where pressure acts on it; record both faces"
)


def rows(grids: Grids, exact: Exact, threshold: float | None, *, face: bool) -> Iterator[Row]:
    """All rows of a validation.

    Parameters
    ----------
    grids : Grids
    exact : Exact
    threshold : float, optional
        Slip rate at which slip counts as begun [length / time].
    face : bool
        Whether slip was made of the motion of one face.
    """
    yield from arrival_rows(grids, exact, threshold)
    for name in QUANTITIES:
        yield from quantity_rows(grids, exact, name, face=face)
    yield from strength_rows(grids, exact)


def quantity_norms(grids: Grids, exact: Exact, name: str) -> list[tuple[Record, Norm]]:
    """Records of one quantity with their norms."""
    norms = (
        (record, station_norm(record, name, exact, grids.mean)) for record in grids.finest.stations
    )
    return [(record, norm) for record, norm in norms if norm is not None]


def quantity_rows(grids: Grids, exact: Exact, name: str, *, face: bool) -> Iterator[Row]:
    """One quantity, at all stations together and at single ones."""
    known = quantity_norms(grids, exact, name)
    if not known:
        return
    whole = pooled([norm for _, norm in known])
    sizes = [norm.exact if norm.exact > NOTHING else 1.0 for _, norm in known]
    obstacle = ONE_FACE if face and name in ("slip", "slip_rate") else ""
    bars = [
        _bar(grids, exact, record, name, whole.exact / size)
        for (record, _), size in zip(known, sizes, strict=True)
    ]
    parts = [bar for bar, _ in bars]
    if len(known) > 1:
        bar = None
        if all(part is not None for part in parts):
            total = sum((part or 0.0) * size for part, size in zip(parts, sizes, strict=True))
            bar = total / (len(sizes) * (whole.exact if whole.exact > NOTHING else 1.0))
        orders = [order for _, order in bars if order is not None]
        order = float(np.median(orders)) if orders else None
        yield _row("all stations", name, exact, whole, bar, order, obstacle, grids)
    chosen = chosen_stations([record.x for record, _ in known], exact)
    for place in chosen:
        (record, norm), (bar, order) = known[place], bars[place]
        where = f"at {_over(record.x, exact):.3g} c_t T"
        few = f"fewer than {FEW} samples" if norm.samples < FEW else ""
        yield _row(where, name, exact, norm, bar, order, obstacle or few, grids)


def _bar(
    grids: Grids, exact: Exact, record: Record, name: str, everywhere: float
) -> tuple[float | None, float | None]:
    """Bar and observed order of one record."""
    doubt = 0.0
    if companion := exact.doubt(name, record.x, record.t):
        mean = float(np.abs(exact.record(name, record.x, record.t)).mean())
        doubt = companion / max(mean, 1e-6 * exact.unit(name))
    differences = changes(grids, record, name, exact) if len(grids.runs) > 1 else []
    if differences:
        bar, order = grid_bar(grids, differences)
        return max(bar, FLOOR * (smear(grids, record, name, exact) or 0.0)) + doubt, order
    alone = spacing_bar(grids, record, name, exact, everywhere)
    return (None if alone is None else alone + doubt), None


def _row(
    where: str,
    name: str,
    exact: Exact,
    norm: Norm,
    bar: float | None,
    order: float | None,
    obstacle: str,
    grids: Grids,
) -> Row:
    kind = name.replace("_", " ")
    units = {"slip_rate": "V₀", "slip": "V₀ T"}
    if bar is None:
        obstacle = obstacle or NO_GRID
    elif bar > TELLING:
        obstacle = obstacle or _too_coarse(bar, grids, exact)
    return Row(
        f"{kind} {where}",
        kind,
        norm.exact,
        norm.exact,
        norm.simulated,
        norm.L1,
        bar,
        unit=units.get(name, "τ₀"),
        relative=True,
        order=order,
        obstacle=obstacle,
        resolution=_cells(grids, exact, bar),
    )


def _too_coarse(bar: float, grids: Grids, exact: Exact) -> str:
    cells = _cells(grids, exact, bar)
    remedy = f"; {cells} cells over c_t T would tell" if cells else "; a finer grid would tell"
    return f"this grid leaves it open by {100 * bar:.2g} %{remedy}"


def _cells(grids: Grids, exact: Exact, bar: float | None) -> int | None:
    """Cells over c_t T with which a bar would be as narrow as it has to be."""
    if grids.spacing is None or bar is None or bar <= TELLING:
        return None
    length = exact.scene.material.shear_speed * exact.end_time
    return int(np.ceil(length / grids.spacing * bar / TELLING))


def chosen_stations(places: Sequence[float], exact: Exact) -> list[int]:
    """Stations that have rows of their own."""
    if len(places) <= len(PLACES):
        return list(range(len(places)))
    over = np.array([_over(place, exact) for place in places])
    return sorted({int(np.argmin(np.abs(over - place))) for place in PLACES})


def _over(x: float, exact: Exact) -> float:
    return x / (exact.scene.material.shear_speed * exact.end_time)


def arrival_rows(grids: Grids, exact: Exact, threshold: float | None) -> Iterator[Row]:
    """When slip begins, at stations and in a file of rupture times."""
    material = exact.scene.material
    least = threshold or THRESHOLD * stress_scale(exact.scene) / material.shear_impedance
    runs = [_arrivals(run, least) for run in grids.runs]
    places = [x for x in sorted(runs[0]) if 0 < x <= exact.end_time * material.longitudinal_speed]
    chosen = [places[place] for place in chosen_stations(places, exact)]
    for x in chosen:
        onset = Onset(exact, x, least)
        if onset.time is not None:
            yield _arrival_row(grids, exact, onset, [run.get(x) for run in runs])


def _arrival_row(grids: Grids, exact: Exact, onset: Onset, times: Sequence[float | None]) -> Row:
    """An onset at one station, by all runs, finest first."""
    expected, seen = onset.time or 0.0, times[0]
    bar, order = _arrival_bar(grids, exact, onset, times)
    obstacle = NO_GRID if grids.spacing is None else ""  # all grids may miss what is too narrow
    if bar is not None and bar > TELLING * expected:
        obstacle = "what begins to slip here is too weak, or too narrow, for this grid"
    end = exact.end_time
    return Row(
        f"arrival at {_over(onset.x, exact):.3g} c_t T",
        "arrival",
        expected / end,
        expected / end,
        None if seen is None else seen / end,
        None if seen is None else (seen - expected) / end,
        None if bar is None else bar / end,
        unit="T",
        order=order,
        obstacle=obstacle,
    )


class Onset:
    """When slip at a point becomes faster than a threshold, also as a grid might see it."""

    def __init__(self, exact: Exact, x: float, threshold: float) -> None:
        self.x, self.threshold, self.end_time = x, threshold, exact.end_time
        self.t = np.linspace(0.0, exact.end_time, TIMES + 1)[1:]
        self.rate = exact.record("slip_rate", x, self.t)
        self.time = onset_time(self.t, self.rate, threshold)

    def reach(self, width: float) -> float:
        """How far it may be off [time] for a grid that smears it over a time."""
        times = [
            onset_time(self.t, self._smoothed(cells * width), factor * self.threshold)
            for cells in (0.0, *SMOOTHED)
            for factor in (0.5, 1.0, 2.0)
        ]
        ends = [2 * self.end_time if time is None else time for time in times]
        return max(abs(time - (self.time or 0.0)) for time in ends)

    def _smoothed(self, width: float) -> Array:
        samples = round(width / float(self.t[1] - self.t[0]))
        return np.asarray(
            scipy.ndimage.uniform_filter1d(self.rate, max(samples, 1), mode="nearest")
        )


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
            onsets[record.x] = onset_time(record.t, rate, threshold)
    return onsets


def _arrival_bar(
    grids: Grids, exact: Exact, onset: Onset, times: Sequence[float | None]
) -> tuple[float | None, float | None]:
    """How far an onset may be off [time], and the order that other grids show.

    A threshold is crossed by whole steps and ripples: what changes from grid to grid is never
    believed to be less than what the finest spacing alone leaves open.
    """
    cell = None if grids.spacing is None else grids.spacing / exact.scene.material.shear_speed
    alone = None if cell is None else 2 * cell + onset.reach(cell)
    known = [time for time in times if time is not None]
    if not len(known) == len(times) > 1:
        return alone, None
    differences = [one - other for one, other in pairwise(known)]
    bar, order = grid_bar(grids, [change / exact.end_time for change in differences])
    return max(bar * exact.end_time, alone or 0.0), order


def strength_rows(grids: Grids, exact: Exact) -> Iterator[Row]:
    """Shear traction where the contact slides for sure, over the exact one: the friction law."""
    if grids.spacing is None:
        return
    ratios: list[Array] = []
    moved: list[Array] = []
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
        ratios.append(np.abs(values[sliding] / expected[sliding]))
        moved.append(np.abs(np.stack(smeared)[:, sliding] / expected[sliding] - 1).max(axis=0))
    if not ratios or sum(map(len, ratios)) < FEW:
        return
    seen = float(np.median(np.concatenate(ratios)))
    bar = STRENGTH_FLOOR + float(np.median(np.concatenate(moved)))
    yield Row(
        "strength where it slides",
        "shear traction",
        1.0,
        1.0,
        seen,
        seen - 1,
        bar,
        unit="exact",
        relative=True,
        obstacle="" if bar <= TELLING else _too_coarse(bar, grids, exact),
    )


def _slides(exact: Exact, record: Record, band: float) -> NDArray[np.bool_]:
    """Where a record slides, and would if a grid smeared it."""
    rate = np.abs(exact.record("slip_rate", record.x, record.t))
    traction = np.abs(exact.record("shear_traction", record.x, record.t))
    least = max(SLIDING * rate.max(initial=0.0), 1e-3 * exact.unit("slip_rate"))
    slides = (rate > least) & (traction > 1e-4 * exact.unit("shear_traction"))
    for other in exact.smeared("slip_rate", record.x, record.t, band):
        slides &= np.abs(other) > least
    return slides
