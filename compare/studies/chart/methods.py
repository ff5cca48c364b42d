"""Methods of the chart, and how their time, memory and slip rate are measured.

``python -m compare.studies.chart.methods SCENE METHOD SETTING`` measures one point in its own
process and prints it as JSON.  The memory is then that of one method, and no run warms up another.
Velocities x/t and edges are relative to c_t; times [s] are of the calls alone, after the imports.
"""

from __future__ import annotations

import json
import math
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import sampled_zones
from compare.studies.chart.benchmark import forget_tables
from compare.tasks.workers import LIFELINE, hang_on
from semianalytic import Scene, SlipZone, Solution, solve
from semianalytic.cut.load import scaled_load
from semianalytic.memory.exponentials import fit_memory
from semianalytic.reference import DEFAULT_READING, published_grid, published_slip
from semianalytic.reference.known_answers import published_obstacle, published_unit
from semianalytic.scene.errors import SlipfrontError
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.selfsimilar.zones.collocation import slip_grid, slip_on_grid

Array = NDArray[np.float64]

PLACES = np.linspace(0.02, 1.9, 400)
"""Velocities x / (c_t T) at which slip rates are compared."""

EDGE_THRESHOLD = 1e-6
"""Smallest slip rate that counts as slip in a profile, over the largest one."""

MEASURED = "measured"
_ONLY_LAST = 10**9
_MIDDLE = 0.5
_SHORT = 1.0
_RUNS, _SHORT_RUNS = 3, 5


@dataclass(frozen=True, eq=False)
class Answer:
    """Result of one run of a method.

    Attributes
    ----------
    setup, solving : float
        Time of what depends only on grid, material and mesh, and of the rest [s].
    slip_rate : (400,) array
        Slip rate at `PLACES` and the end time [length / time].
    zones : tuple of SlipZone
        Slip zones, edges over c_t.
    status : str
        `MEASURED`, or a sentence that says what to distrust.
    """

    setup: float
    solving: float
    slip_rate: Array
    zones: tuple[SlipZone, ...]
    status: str = MEASURED


@dataclass(frozen=True)
class Method:
    """A method of the chart.

    Attributes
    ----------
    family : str
        Row of the table of recommendations.
    label : str
        Name of the method in figures and tables.
    parameter : str
        Name of the setting, as in "rtol 1e-08".
    run : callable
        Function that returns the answer of a scene at a setting.
    full, quick : tuple of float
        Settings of the full and the quick chart, from coarse to fine.
    cost : (float, float, float)
        Rough cost of a run: seconds, the setting to which they belong, and the power of growth.
    obstacle : callable
        Function that says why a scene is out of reach of the method; empty if it is not.
    """

    family: str
    label: str
    parameter: str
    run: Callable[[Scene, float], Answer]
    full: tuple[float, ...]
    quick: tuple[float, ...]
    cost: tuple[float, float, float]
    obstacle: Callable[[Scene], str] = lambda scene: ""

    def seconds(self, setting: float) -> float:
        """Return the rough cost of one run [s]."""
        unit, at, power = self.cost
        return unit * (setting / at) ** power


def sampled(scene: Scene, velocity: Array, slip_rate: Array) -> tuple[Array, tuple[SlipZone, ...]]:
    """Return the slip rate at `PLACES`, interpolated linearly, and the zones of a profile.

    Zones are runs of at least two samples above `EDGE_THRESHOLD` of the largest slip rate.  Their
    edges follow from extrapolating the square of the slip rate to zero (`measures.sampled_zones`).

    Parameters
    ----------
    velocity : (n,) array
        Velocities of the samples over c_t, increasing.
    slip_rate : (n,) array
        Slip rates of the samples [length / time].
    """
    at_places = np.interp(PLACES, velocity, slip_rate, right=scene.far_slip_rate)
    inside = velocity > 0
    largest = float(np.abs(slip_rate[inside]).max())
    zones = sampled_zones(velocity[inside], slip_rate[inside], EDGE_THRESHOLD * largest or math.inf)
    return at_places, zones


def scaled_zones(solution: Solution) -> tuple[SlipZone, ...]:
    """Return the zones of a solution, edges over c_t."""
    speed = solution.scene.material.shear_speed
    return tuple(SlipZone(z.inner / speed, z.outer / speed, z.sense) for z in solution.zones)


def _self_similar(scene: Scene, rtol: float, *, cold: bool) -> Answer:
    """Solve a scene and evaluate its slip rate at `PLACES`.

    Set-up depends only on the Poisson ratio; its time is the difference between a first and a
    second run.  Without `cold`, its tables are cached already.
    """
    speed, setup = scene.material.shear_speed, 0.0
    started = time.perf_counter()
    if cold:
        forget_tables()
        solve(scene, rtol=rtol).slip_rate(PLACES * speed, 1.0)
        setup = time.perf_counter() - started
        started = time.perf_counter()
    solution = solve(scene, rtol=rtol)
    slip_rate = solution.slip_rate(PLACES * speed, 1.0)
    solving = time.perf_counter() - started
    status = MEASURED if solution.status == "converged" else solution.status
    return Answer(max(setup - solving, 0.0), solving, slip_rate, scaled_zones(solution), status)


def _first_stage(scene: Scene, size: float) -> Answer:
    forget_tables()
    started = time.perf_counter()
    slip_grid(scene.material.poisson_ratio, int(size))
    ready = time.perf_counter()
    load, stress = scaled_load(scene)
    grid = slip_on_grid(scene.material.poisson_ratio, load, int(size))
    solved = time.perf_counter()
    unit = 2 * stress / scene.material.shear_impedance
    return Answer(ready - started, solved - ready, *sampled(scene, grid.xi, unit * grid.slip_rate))


def _published(scene: Scene, size: float) -> Answer:
    """Return the slip rate down to x = c_t t / 5, where the algorithm ends, constant from there."""
    forget_tables()
    published_grid.cache_clear()
    load = scene.superposition.taken_off
    nu, strength = scene.material.poisson_ratio, scene.friction * load.pressure
    started = time.perf_counter()
    published_grid(DEFAULT_READING, int(size), nu, _MIDDLE)
    ready = time.perf_counter()
    ratio = strength / load.shear
    answer = published_slip(ratio, DEFAULT_READING, int(size), poisson_ratio=nu, place=_MIDDLE)
    solved = time.perf_counter()
    unit = published_unit(scene)
    velocity, slip_rate = 1 / answer.u[::-1], unit * answer.slip_rate[::-1]
    ahead = np.nextafter(velocity[-1], np.inf)
    profile = np.append(velocity, ahead), np.append(slip_rate, 0.0)
    status = MEASURED if answer.settled else "the signs of friction do not settle"
    return Answer(ready - started, solved - ready, *sampled(scene, *profile), status)


def _space_time(scene: Scene, nodes: float) -> Answer:
    fit_memory.cache_clear()
    marched = solve(scene, method="space-time", nodes=int(nodes), every=_ONLY_LAST, companion=False)
    seconds, seen = marched.statistics.seconds, marched.interface
    velocity = seen.x / (scene.material.shear_speed * seen.t[-1])
    return Answer(seconds["setup"], seconds["steps"], *sampled(scene, velocity, seen.slip_rate[-1]))


def _finite_elements(
    scene: Scene, resolution: float, *, whole: bool = False, **options: Any
) -> Answer:
    """Simulate with a cached mesh; `whole` is the domain that field snapshots need."""
    from fem import simulate

    with TemporaryDirectory() as folder:
        simulation = simulate(
            scene,
            resolution=int(resolution),
            every=_ONLY_LAST,
            snapshots=Path(folder) if whole else None,
            frames=1,
            **options,
        )
    seen, seconds = simulation.interface, simulation.seconds
    velocity = seen.x / (scene.material.shear_speed * seen.t[-1])
    steps = seconds["steps"] - seconds.get("snapshots", 0.0)
    return Answer(
        seconds["mesh"] + seconds["assembly"], steps, *sampled(scene, velocity, seen.slip_rate[-1])
    )


def _not_self_similar(scene: Scene) -> str:
    return "" if scene.is_self_similar else "its loads are not steps"


def _elements(
    label: str, full: tuple[float, ...], quick: tuple[float, ...], seconds: float, **options: Any
) -> Method:
    """Return a finite-element method; a run with 100 elements per c_t T takes `seconds`."""
    run = partial(_finite_elements, **options)
    cost = (seconds, 100.0, 2.6)
    return Method("finite elements", f"FEM {label}", "resolution", run, full, quick, cost)


_SOLVER = "self-similar solver"
_TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(2, 13))
_COARSE, _FINE, _FINEST = (25.0,), (50.0, 100.0, 200.0), (50.0, 100.0, 200.0, 400.0)

METHODS: Mapping[str, Method] = {
    "self-similar": Method(
        _SOLVER,
        "self-similar solver",
        "rtol",
        partial(_self_similar, cold=False),
        _TOLERANCES,
        (1e-2, 1e-4, 1e-8),
        (0.02, 1e-8, 0.0),
        _not_self_similar,
    ),
    "self-similar-cold": Method(
        _SOLVER,
        "self-similar solver, new ν",
        "rtol",
        partial(_self_similar, cold=True),
        _TOLERANCES,
        (1e-2, 1e-8),
        (0.05, 1e-8, 0.0),
        _not_self_similar,
    ),
    "first-stage": Method(
        "first stage, piecewise linear",
        "first stage, piecewise linear",
        "grid",
        _first_stage,
        (20, 40, 80, 160, 320, 640),
        (20, 80),
        (0.15, 320, 2.5),
        _not_self_similar,
    ),
    "published": Method(
        "published algorithm",
        "published algorithm",
        "n_u",
        _published,
        (50, 100, 200, 400, 800),
        (50, 200),
        (0.05, 400, 2.0),
        published_obstacle,
    ),
    "space-time": Method(
        "space–time solver",
        "space–time solver",
        "nodes",
        _space_time,
        (128, 256, 512, 1024, 2048, 4096, 8192),
        (128, 512, 1024),
        (0.35, 1024, 2.0),
    ),
    "fem": _elements("Q1 squares", _FINEST, (25, 50, 100), 0.75),
    "fem-p1": _elements("P1 squares", _FINE, (25, 50), 1.0, element="P1"),
    "fem-triangles": _elements(
        "P1 triangles", _FINE, (25, 50), 2.0, element="P1", mesh="triangles"
    ),
    "fem-q2": _elements("Q2 squares", _FINEST, (25, 50), 1.0, element="Q2"),
    "fem-graded": _elements("Q1 graded", _FINEST, (25, 50), 0.3, mesh="graded"),
    "fem-two-blocks": _elements("Q1 squares, two blocks", _FINE, _COARSE, 1.5, model="two-blocks"),
    "fem-undamped": _elements("Q1 squares, undamped", _FINE, (25, 50), 0.75, damping=0.0),
    "fem-whole": _elements("Q1 squares, whole fields", _FINE, _COARSE, 1.6, whole=True),
}
"""All methods by their name in the table, cheapest kind first."""


def answer(scene_name: str, method: str, setting: float) -> Answer:
    """Run a method once on a named scene; if it fails, the answer holds the message."""
    try:
        return METHODS[method].run(NAMED_SCENES[scene_name].scene, setting)
    except SlipfrontError as error:
        return Answer(math.nan, math.nan, np.full(len(PLACES), math.nan), (), str(error))


def measured(scene_name: str, method: str, setting: float, runs: int = 0) -> dict[str, Any]:
    """Run a method several times in this process.

    Parameters
    ----------
    scene_name, method, setting
        Keys of `NAMED_SCENES` and `METHODS`, and a setting of the method.
    runs : int
        Number of runs that count; 0 for 5 if a run is shorter than a second, otherwise 3.  A first
        run of less than a second is discarded.

    Returns
    -------
    dict
        Keys are setup and solving, medians [s]; runs; memory, peak of the process [MB]; slip_rate
        (400,) [length / time]; zones, each (inner, outer, sense), over c_t; status.
    """
    from fem.run import peak_memory

    first = answer(scene_name, method, setting)
    short = first.setup + first.solving < _SHORT
    more = (runs or _SHORT_RUNS) if short else (runs or _RUNS) - 1
    repeated = [answer(scene_name, method, setting) for _ in range(more)]
    counted = repeated if short else [first, *repeated]
    return {
        "setup": statistics.median(one.setup for one in counted),
        "solving": statistics.median(one.solving for one in counted),
        "runs": len(counted),
        "memory": peak_memory() / 1e6,
        "slip_rate": first.slip_rate.tolist(),
        "zones": [(zone.inner, zone.outer, zone.sense) for zone in first.zones],
        "status": first.status,
    }


if __name__ == "__main__":
    if sys.argv[5:] == [LIFELINE]:
        hang_on()
    print(json.dumps(measured(sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4]))))
