"""The finite-element model against the exact solution, by element size: the tables of docs/fem.md.

``python -m docs.studies.accuracy.fem fem-accuracy --output docs`` computes the slip rate of two
scenes, `opening-meshes` contacts that open, and `fields-convergence` the fields in the bodies.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.figure import Figure

from compare.comparison.fields.errors import FieldErrors, field_errors, fronts_in, pair_errors
from compare.comparison.judgement import side_by_side
from compare.comparison.measures import relative_error
from compare.comparison.quantities.edge_rows import opening_rows
from compare.comparison.quantities.profile_rows import gap_rows
from compare.figures.snapshots import snapshot_figure
from docs.studies.runner import Point, Row, Study, main, number
from fem import Simulation, simulate
from semianalytic import Solution, find, solve
from semianalytic.scene.arrays import Array

DRAWN = "lift-off-shear"
MESHES = 50, 100, 200
AFAR = 0.1
"""Distance from all fronts [c_t T] that stays fixed when the mesh is refined."""
PROFILE = np.linspace(0.02, 1.9, 3761)
"""Velocities x / (c_t t) at which profiles are compared."""
AVERAGED = 0.6
"""Self-similar profiles are averaged over times from this fraction of T to T."""


def profile(simulation: Simulation, row: int = -1) -> Array:
    """Return the slip rate at the velocities `PROFILE`, interpolated, at the end or a time."""
    history = simulation.interface
    place = PROFILE * simulation.scene.material.shear_speed * history.t[row]
    return np.interp(place, history.x, history.slip_rate[row])


def profile_errors(solution: Solution, last: Array, averaged: Array) -> dict[str, float]:
    """Return the errors of two profiles at the velocities `PROFILE`: relative L1 errors, and those
    of the averaged one where the exact slip rate of the first and the second zone is largest.

    These are over the exact value there, the last one over the largest of all; nan if there is no
    such zone.
    """
    speed = solution.scene.material.shear_speed
    exact = solution.slip_rate(PROFILE * speed, 1.0)
    peaks = []
    for zone in solution.zones:
        inside = (PROFILE * speed > zone.inner) & (PROFILE * speed < zone.outer)
        peaks.append(int(np.argmax(np.where(inside, np.abs(exact), 0.0))))
    at_peak = [float(averaged[peak] - exact[peak]) for peak in peaks]
    relative = [error / exact[peak] for error, peak in zip(at_peak, peaks, strict=True)]
    return {
        "last": relative_error(last, exact, PROFILE, 1),
        "averaged": relative_error(averaged, exact, PROFILE, 1),
        "first_peak": relative[0] if peaks else math.nan,
        "second_peak": relative[1] if len(peaks) > 1 else math.nan,
        "second_over_largest": at_peak[1] / np.abs(exact).max() if len(peaks) > 1 else math.nan,
    }


def slip_rates(scene: str, resolutions: Sequence[int]) -> list[Row]:
    """Return the errors of the slip rate on meshes, each twice as fine as the last.

    The last row extrapolates from the two finest, 2 V(h/2) - V(h), which removes errors of first
    order in h.  Orders are those observed since the mesh before; `seconds` is the time of stepping.
    """
    solution, profiles, rows = solve(find(scene)), [], list[Row]()
    for resolution in resolutions:
        run = simulate(find(scene), resolution=resolution)
        t = run.interface.t
        latest = np.flatnonzero(t >= AVERAGED * t[-1]).tolist()
        averaged = np.mean([profile(run, row) for row in latest], axis=0)
        profiles.append((profile(run), averaged))
        before = rows[-1] if rows else {}
        row = _error_row(scene, f"1/{resolution}", profile_errors(solution, *profiles[-1]), before)
        rows.append({**row, "seconds": run.seconds["steps"]})
    last, averaged = (2 * fine - coarse for coarse, fine in zip(*profiles[-2:], strict=True))
    limit = _error_row(scene, "extrapolated", profile_errors(solution, last, averaged), {})
    return [*rows, {**limit, "seconds": math.nan}]


def _error_row(scene: str, h: str, errors: Row, before: Row) -> Row:
    row: Row = {"scene": scene, "h": h}
    for name, error in errors.items():
        row[name] = error
        if name in ("last", "averaged"):
            row[f"{name}_order"] = math.log2(before[name] / error) if before else math.nan
    return row


def openings(scene: str, resolutions: Sequence[int]) -> list[Row]:
    """Return the ends of the opening over c_t, by the rules of the judge, and errors of the gap.

    The gap at T is compared in L1, `largest` is the relative error of the largest gap, and ends
    are nan where there is none.
    """
    exact, rows = solve(find(scene)), list[Row]()
    for resolution in resolutions:
        case = side_by_side(exact, simulate(find(scene), resolution=resolution))
        found = {row.name: row for row in (*opening_rows(case), *gap_rows(case))}
        gap = found["gap, L1"].difference or 0.0
        order = math.log2(rows[-1]["gap"] / gap) if rows else math.nan
        ends: Row = {}
        for end in ("inner", "outer"):
            row = found.get(f"opening 1, {end} edge")
            ends[end] = number(row.simulated if row else None)
            ends[f"exact_{end}"] = number(row.exact if row else None)
        beyond = case.seen.x >= case.runs[-1].interface.x[0]
        seen, known = (values.gap[-1, beyond].max() for values in (case.seen, case.at_nodes))
        found_row = {"scene": scene, "h": f"1/{resolution}", **ends}
        rows.append({**found_row, "gap": gap, "order": order, "largest": seen / known - 1})
    return rows


def fields(scene: str, resolutions: Sequence[int]) -> list[Row]:
    """Return relative L1 errors of the components at T, and orders between the last two meshes.

    They are those over both bodies, outside a band of two elements around the fronts, and farther
    than `AFAR` from all fronts.
    """
    rows = list[Row]()
    for meshes in zip(*(_field_errors(scene, n) for n in resolutions), strict=True):
        row: Row = {"scene": scene, "component": meshes[0][0]}
        for place, part in enumerate(("", "_outside", "_afar")):
            errors = [errors[place] for _, errors in meshes]
            order = math.log2(errors[-2] / errors[-1])
            names = [f"{size}{part}" for size in ("coarse", "medium", "fine", "order")]
            row |= dict(zip(names, [*errors, order], strict=True))
        rows.append(row)
    return rows


def _field_errors(scene: str, resolution: int) -> list[tuple[str, tuple[float, float, float]]]:
    run, errors = last_frame(scene, resolution)
    width = AFAR * run.scene.material.shear_speed * run.end_time
    fronts = fronts_in(solve(run.scene), run.scene)
    afar = pair_errors(errors.last, fronts, run.end_time, width)
    return [
        (near.component, (near.whole, near.outside, far.outside))
        for near, far in zip(errors.frames[-1], afar, strict=True)
    ]


def last_frame(name: str, resolution: int) -> tuple[Simulation, FieldErrors]:
    """Simulate a scene with one snapshot at its end; return the simulation and the errors."""
    scene = find(name)
    with TemporaryDirectory() as folder:
        run = simulate(scene, resolution=resolution, snapshots=folder, frames=1)
        errors = field_errors(solve(scene), run, Path(folder))
    assert errors is not None  # a self-similar solution always has fields
    return run, errors


def field_figure(rows: list[Row]) -> Figure:
    """Draw the fields of a scene by both methods, and their difference."""
    run, errors = last_frame(DRAWN, MESHES[1])
    return snapshot_figure(errors, run)


def points(names: Sequence[str], resolutions: Sequence[int]) -> Callable[[bool], list[Point]]:
    """Return the function of the points of a study; a quick one has meshes half as fine."""
    return lambda quick: [(name, [n // (1 + quick) for n in resolutions]) for name in names]


STUDIES = [
    Study("fem-accuracy", points(("preloaded", "remote-shock"), (100, 200, 400)), slip_rates),
    Study("opening-meshes", points(("lift-off", "lift-off-shear", "tap"), MESHES), openings),
    Study(
        "fields-convergence",
        points(("preloaded", DRAWN), MESHES),
        fields,
        figures={f"fields_{DRAWN}": field_figure},
    ),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.accuracy.fem", STUDIES))
