"""Studies of the finite-element model against the exact solution: accuracy, elements, cost.

``python -m compare.fem_study accuracy`` prints a table; `STUDIES` lists the others.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from compare.measures import norm
from compare.scenes import NAMED_SCENES
from semianalytic import Solution, solve

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

PROFILE = np.linspace(0.02, 1.9, 3761)
"""Velocities x / (c_t t) at which profiles are compared."""

AVERAGED = 0.6
"""Self-similar profiles are averaged over times from this fraction of T to T."""


@dataclass(frozen=True)
class Errors:
    """Errors of a simulated slip-rate profile V(x/t) of a self-similar scene.

    Attributes
    ----------
    last : float
        Relative L1 error at the final time.
    averaged : float
        The same of the profile averaged over x/t in the last 40 % of the time.
    first_peak, second_peak : float
        Error of the averaged profile where the exact slip rate of the first and the second zone
        is largest, over the exact value there; nan where there is no such zone.
    second_over_largest : float
        Error at the second peak over the largest exact slip rate of all.
    """

    last: float
    averaged: float
    first_peak: float
    second_peak: float
    second_over_largest: float


def last_profile(simulation: Simulation) -> Array:
    """Slip rate at the final time at the velocities `PROFILE`, between nodes by straight lines."""
    return _sampled(simulation, -1)


def averaged_profile(simulation: Simulation) -> Array:
    """Slip rate averaged over x/t in the last 40 % of the time, at the velocities `PROFILE`."""
    t = simulation.interface.t
    rows = np.flatnonzero(t >= AVERAGED * t[-1]).tolist()
    return np.mean([_sampled(simulation, row) for row in rows], axis=0)


def profile_errors(solution: Solution, last: Array, averaged: Array) -> Errors:
    """Errors of two profiles at the velocities `PROFILE`."""
    speed = solution.scene.material.shear_speed
    exact = solution.slip_rate(PROFILE * speed, 1.0)
    peaks = []
    for zone in solution.zones:
        inside = (PROFILE * speed > zone.inner) & (PROFILE * speed < zone.outer)
        peaks.append(int(np.argmax(np.where(inside, np.abs(exact), 0.0))))
    at_peak = [float(averaged[peak] - exact[peak]) for peak in peaks]
    relative = [error / exact[peak] for error, peak in zip(at_peak, peaks, strict=True)]
    return Errors(
        last=norm(last - exact, PROFILE, 1) / norm(exact, PROFILE, 1),
        averaged=norm(averaged - exact, PROFILE, 1) / norm(exact, PROFILE, 1),
        first_peak=relative[0] if peaks else math.nan,
        second_peak=relative[1] if len(peaks) > 1 else math.nan,
        second_over_largest=at_peak[1] / np.abs(exact).max() if len(peaks) > 1 else math.nan,
    )


def accuracy(scene: str, resolutions: tuple[int, ...], **options: Any) -> Table:
    """Errors and observed order on several meshes, and extrapolated from the two finest.

    The last row is 2 V(h/2) - V(h), which removes what is of first order in h.
    """
    table = Table(
        "h / c_t T", title=f"{scene}, relative errors of the slip rate", caption=str(options or "")
    )
    for heading in (
        "L1 at T",
        "order",
        "L1 averaged",
        "order",
        "first peak",
        "second peak",
        "second peak / largest V",
        "steps [s]",
    ):
        table.add_column(heading, justify="right")
    solution = solve(NAMED_SCENES[scene].scene)
    profiles, previous = [], None
    for resolution in resolutions:
        simulation = simulated(scene, resolution, **options)
        profiles.append((last_profile(simulation), averaged_profile(simulation)))
        errors = profile_errors(solution, *profiles[-1])
        _add_row(table, f"1/{resolution}", errors, previous, f"{simulation.seconds['steps']:.2f}")
        previous = errors
    coarse, fine = profiles[-2:]
    best = (2 * fine[0] - coarse[0], 2 * fine[1] - coarse[1])
    _add_row(table, "extrapolated", profile_errors(solution, *best), None, "")
    return table


def element_table(scene: str, resolutions: tuple[int, ...]) -> Table:
    """Accuracy and cost of every element family on every kind of mesh."""
    table = Table("element", "mesh", "h / c_t T", title=f"{scene}: element families")
    for heading in ("unknowns", "dt c_l / h", "L1 at T", "order", "steps [s]", "mesh [s]"):
        table.add_column(heading, justify="right")
    solution = solve(NAMED_SCENES[scene].scene)
    for element, mesh in ELEMENTS:
        errors: list[float] = []
        for resolution in resolutions:
            simulation = simulated(scene, resolution, element=element, mesh=mesh)
            profile = last_profile(simulation)
            errors.append(profile_errors(solution, profile, profile).last)
            step = simulation.critical_step / simulation.element_size
            table.add_row(
                element,
                mesh,
                f"1/{resolution}",
                f"{simulation.unknowns:,}",
                f"{step * simulation.scene.material.longitudinal_speed:.3f}",
                f"{errors[-1]:.2e}",
                "" if len(errors) < 2 else f"{_order(errors[-2], errors[-1]):.2f}",
                f"{simulation.seconds['steps']:.2f}",
                f"{simulation.seconds['mesh']:.2f}",
            )
    return table


ELEMENTS = (
    ("Q1", "squares"),
    ("P1", "squares"),
    ("P1", "triangles"),
    ("Q2", "squares"),
    ("Q1", "graded"),
)


def damping_table(scene: str, resolution: int) -> Table:
    """What damping does to the error, the energy it takes and the critical step."""
    table = Table("damping c_t / h", title=f"{scene}, h = c_t T / {resolution}")
    for heading in (
        "L1 at T",
        "L1 averaged",
        "second peak",
        "damping / external work",
        "critical step / undamped",
        "energy residual",
    ):
        table.add_column(heading, justify="right")
    solution = solve(NAMED_SCENES[scene].scene)
    undamped = math.nan
    for damping in (0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2):
        simulation = simulated(scene, resolution, damping=damping)
        if not damping:
            undamped = simulation.critical_step
        errors = profile_errors(solution, last_profile(simulation), averaged_profile(simulation))
        energy = simulation.energy
        table.add_row(
            f"{damping:g}",
            f"{errors.last:.2e}",
            f"{errors.averaged:.2e}",
            f"{errors.second_peak:+.1%}",
            f"{energy.damping[-1] / energy.external[-1]:.1e}",
            f"{simulation.critical_step / undamped:.3f}",
            f"{energy.residual:.0e}",
        )
    return table


def cost_table(scene: str, resolutions: tuple[int, ...]) -> Table:
    """A full step over one product of the active part, and what the window and the halves save.

    Step and product are timed in turns, in one run, as medians.
    """
    from fem.assembly import find_family, make_space
    from fem.model import build_model, choose_model
    from fem.run import peak_memory
    from meshes import cached_mesh, causal_blocks

    table = Table("h / c_t T", title=f"{scene}: cost of a step, ns per unknown")
    for heading in ("unknowns", "product", "step", "ratio", "window saves", "trimming saves"):
        table.add_column(heading, justify="right")
    described = NAMED_SCENES[scene].scene
    material = described.material
    for resolution in resolutions:
        size = 1 / resolution
        blocks, whole = (
            causal_blocks(material, 1 / material.shear_speed, size, full=full)
            for full in (False, True)
        )
        model = build_model(
            described,
            make_space(cached_mesh(blocks), find_family("Q1", "squares")),
            name=choose_model(described, "auto"),
            size=size,
            end_time=1 / material.shear_speed,
            damping_time=0.02 * size / material.shear_speed,
            step_ratio=0.95,
        )
        unknowns = len(model.root)
        noise = np.random.default_rng(0).standard_normal(unknowns)
        for body in model.bodies:
            body.activate(unknowns)
            body.increment[:] = 1e-9 * noise

        def step(model: Any = model) -> None:
            for body in model.bodies:
                body.kick(1.0)
            model.interface.act(1.0)
            for body in model.bodies:
                body.drift(1.0)

        def product(model: Any = model, noise: Array = noise) -> None:
            for body in model.bodies:
                _ = body.matrix @ noise

        product_time, step_time = _medians(product, step, 15)
        levels = np.arange(model.steps + 1) * model.time_step * material.longitudinal_speed
        active = np.mean([model.numbering.reached(front + 9 * size) for front in levels])
        table.add_row(
            f"1/{resolution}",
            f"{model.unknowns:,}",
            f"{1e9 * product_time / model.unknowns:.1f}",
            f"{1e9 * step_time / model.unknowns:.1f}",
            f"{step_time / product_time:.2f}",
            f"{unknowns / active:.2f}",
            f"{whole.elements / blocks.elements:.2f}",
        )
    table.caption = f"peak memory of this process {peak_memory() / 1e6:,.0f} MB"
    return table


def _medians(one: Callable[[], None], other: Callable[[], None], times: int) -> tuple[float, float]:
    """Median wall-clock times of two functions called in turns [s]."""
    seconds: tuple[list[float], list[float]] = ([], [])
    for _ in range(times):
        for function, taken in zip((one, other), seconds, strict=True):
            started = time.perf_counter()
            function()
            taken.append(time.perf_counter() - started)
    return float(np.median(seconds[0])), float(np.median(seconds[1]))


def simulated(scene: str, resolution: int, **options: Any) -> Simulation:
    """Simulate a named scene."""
    from fem import simulate

    return simulate(NAMED_SCENES[scene].scene, resolution=resolution, **options)


def _sampled(simulation: Simulation, row: int) -> Array:
    history = simulation.interface
    place = PROFILE * simulation.scene.material.shear_speed * history.t[row]
    return np.interp(place, history.x, history.slip_rate[row])


def _order(coarse: float, fine: float) -> float:
    """Observed order of convergence when h is halved."""
    return math.log2(coarse / fine)


def _add_row(
    table: Table, label: str, errors: Errors, previous: Errors | None, seconds: str
) -> None:
    table.add_row(
        label,
        f"{errors.last:.2e}",
        f"{_order(previous.last, errors.last):.2f}" if previous else "",
        f"{errors.averaged:.2e}",
        f"{_order(previous.averaged, errors.averaged):.2f}" if previous else "",
        f"{errors.first_peak:+.2%}",
        f"{errors.second_peak:+.2%}",
        f"{errors.second_over_largest:+.2%}",
        seconds,
    )


def _accuracy_tables() -> Iterator[Table]:
    yield accuracy("preloaded", (100, 200, 400))
    yield accuracy("remote-shock", (100, 200, 400))
    yield accuracy("preloaded", (100, 200, 400), damping=0.0)


STUDIES: dict[str, Callable[[], Iterator[Table]]] = {
    "accuracy": _accuracy_tables,
    "elements": lambda: iter([element_table("preloaded", (50, 100, 200))]),
    "damping": lambda: iter([damping_table("preloaded", 100), damping_table("preloaded", 200)]),
    "cost": lambda: iter([cost_table("preloaded", (200, 400))]),
}


def main(arguments: list[str]) -> int:
    """Print the tables of the studies named; 2 if there is none of a name."""
    console = Console(width=120)
    if not arguments or not set(arguments) <= set(STUDIES):
        console.print(f"usage: python -m compare.fem_study {'|'.join(STUDIES)} ...", markup=False)
        return 2
    for name in arguments:
        for table in STUDIES[name]():
            console.print(table)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
