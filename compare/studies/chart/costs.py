"""Costs of openings and viscous films: times of random scenes relative to plain ones.

Run as ``python -m compare.studies.chart.costs openings films --csv docs/data``.  The plain partner
of a scene that opens has a base under which it stays closed, or a step of pressure that does not
pull; the partner of a scene with a film has none.  Times are processor times on one thread, medians
of interleaved solves for a material whose tables are cached.  Only pairs count in which both scenes
slip and converge.  The error is the largest one of the slip rate, relative L1 over rtol.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from compare.studies.chart.benchmark import median_times, slip_rate_error
from compare.studies.tables import Study, run_studies
from semianalytic import Material, Scene, Tractions, ViscousFriction, solve
from semianalytic.regimes import opening_threshold
from semianalytic.separation.opening import detached_opening

TOLERANCES = (1e-6, 1e-8)
_SCENES = 40
_REPETITIONS = 5

Pairs = Iterator[tuple[Scene, Scene]]
Kind = Callable[[np.random.Generator], Pairs]


@dataclass(frozen=True)
class Cost:
    """Cost of one kind of scene at one rtol: times in milliseconds and relative to plain scenes."""

    kind: str
    rtol: float
    scenes: int
    median: float
    ninth_decile: float
    worst: float
    milliseconds: float
    error: float


def opening_ahead(random: np.random.Generator) -> Pairs:
    """Yield sudden pressures that open the contact around the Rayleigh front, and closed partners.

    The base is 0.01 to 0.95 of the threshold, that of the partner 1.1 to 3 times the threshold.
    """
    while True:
        nu, friction = random.uniform(0.0, 0.45), random.uniform(0.1, 1.2)
        threshold = opening_threshold(nu)
        base = threshold * 10 ** random.uniform(-2, -0.02)
        shear = random.uniform(-0.9, 0.9) * friction * base
        scene = Scene(
            Material(1.0, 1.0, nu),
            friction,
            Tractions(base, shear),
            Tractions(1.0, 0.7 * random.normal()),
        )
        closed = Tractions(threshold * random.uniform(1.1, 3.0), shear)
        yield scene, replace(scene, base=closed)


def opening_from_edge(random: np.random.Generator) -> Pairs:
    """Yield pressures on the slot faces, 0.1 to 5 times the base, and partners.

    The load of the partner presses the contact together.
    """
    while True:
        nu, friction = random.uniform(0.0, 0.45), random.uniform(0.1, 1.2)
        base = Tractions(1.0, random.uniform(-0.9, 0.9) * friction)
        load = Tractions(-(10 ** random.uniform(-1, 0.7)), random.normal())
        scene = Scene(Material(1.0, 1.0, nu), friction, base, load)
        yield scene, replace(scene, load=replace(load, pressure=0.3))


def film(random: np.random.Generator) -> Pairs:
    """Yield scenes with viscosities of 0.01 to 3, and partners with dry friction."""
    while True:
        nu, friction = random.uniform(0.0, 0.45), random.uniform(0.1, 1.2)
        pressure = random.uniform(0.0, 0.9) / max(opening_threshold(nu), 0.9)
        base = Tractions(1.0, random.uniform(-0.9, 0.9) * friction)
        dry = Scene(Material(1.0, 1.0, nu), friction, base, Tractions(pressure, random.normal()))
        viscosity = 10 ** random.uniform(-2, 0.5)
        yield replace(dry, friction_law=ViscousFriction(viscosity)), dry


OPENINGS = {"opening from the edge": opening_from_edge, "opening ahead of c_R": opening_ahead}
FILMS = {"film": film}


def _ratio(scene: Scene, plain: Scene, rtol: float) -> tuple[float, float] | None:
    """Return the time of a scene over that of a plain one, and in milliseconds.

    Return None if one of them does not slip or converge.
    """
    answers = [solve(one, rtol=rtol) for one in (scene, plain)]
    if not all(one.zones and one.status == "converged" for one in answers):
        return None

    def anew() -> None:
        detached_opening.cache_clear()
        solve(scene, rtol=rtol)

    time, plain_time = median_times([anew, lambda: solve(plain, rtol=rtol)], _REPETITIONS)
    return time / plain_time, 1e3 * time


def measure_costs(kinds: Mapping[str, Kind], scenes: int = _SCENES) -> list[Cost]:
    """Time kinds of scenes at all tolerances."""
    rows = []
    for kind, pairs in kinds.items():
        for rtol in TOLERANCES:
            taken: list[tuple[float, float]] = []
            errors, every = [], pairs(np.random.default_rng(5))
            for _, (scene, plain) in zip(range(scenes), every, strict=False):
                if one := _ratio(scene, plain, rtol):
                    taken.append(one)
                    errors.append(slip_rate_error(scene, rtol) / rtol)
            ratio, milliseconds = np.array(taken).T
            median, ninth, worst = np.quantile(ratio, (0.5, 0.9, 1.0)).tolist()
            middle = float(np.median(milliseconds))
            rows.append(Cost(kind, rtol, len(taken), median, ninth, worst, middle, max(errors)))
    return rows


STUDIES: dict[str, Study] = {
    "openings": lambda: measure_costs(OPENINGS),
    "films": lambda: measure_costs(FILMS),
}


if __name__ == "__main__":
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        print("note: set OPENBLAS_NUM_THREADS=1 to compare on one thread")
    raise SystemExit(run_studies("compare.studies.chart.costs", "costs", STUDIES))
