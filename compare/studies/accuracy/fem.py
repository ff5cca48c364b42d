"""Studies of the finite-element model against the exact solution: accuracy, elements, cost.

``python -m compare.studies.accuracy.fem accuracy`` prints a table; `STUDIES` lists the others.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from compare.comparison.measures import norm
from semianalytic import Solution, solve
from semianalytic.halfplane.stuck_histories import stuck_pressure, stuck_shear
from semianalytic.scene.friction import RateWeakening, SlipWeakening
from semianalytic.scene.loads import Harmonic, LoadHistory, Pulse, Ramp, Step
from semianalytic.scene.named import NAMED_SCENES
from semianalytic.scene.scene import Material, Scene, Tractions

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


def errors_of(simulation: Simulation, solution: Solution) -> Errors:
    """Errors of the profiles of a simulation."""
    return profile_errors(solution, last_profile(simulation), averaged_profile(simulation))


def _table(title: str, words: Sequence[str], numbers: Sequence[str]) -> Table:
    """A table with columns of words, and of numbers."""
    table = Table(*words, title=title)
    for heading in numbers:
        table.add_column(heading, justify="right")
    return table


def accuracy(scene: str, resolutions: tuple[int, ...], **options: Any) -> Table:
    """Errors and observed order on several meshes, and extrapolated from the two finest.

    The last row is (r V(h/r) - V(h))/(r - 1), which removes what is of first order in h.
    """
    title = f"{scene}, relative errors of the slip rate"
    columns = ("L1 at T", "order", "L1 averaged", "order", "first peak", "second peak")
    table = _table(title, ["h / c_t T"], [*columns, "second peak / largest V", "steps [s]"])
    table.caption = str(options or "")
    solution = solve(NAMED_SCENES[scene].scene)
    profiles, previous = [], None
    coarser = dict(zip(resolutions[1:], resolutions, strict=False))

    def refinement(resolution: int) -> float:
        return resolution / coarser.get(resolution, resolution / 2)

    for resolution in resolutions:
        simulation = simulated(scene, resolution, **options)
        profiles.append((last_profile(simulation), averaged_profile(simulation)))
        errors = profile_errors(solution, *profiles[-1])
        seconds = f"{simulation.seconds['steps']:.2f}"
        _add_row(table, f"1/{resolution}", errors, previous, seconds, refinement(resolution))
        previous = errors
    r = refinement(resolutions[-1])
    last, averaged = (
        (r * fine - coarse) / (r - 1) for coarse, fine in zip(*profiles[-2:], strict=True)
    )
    _add_row(table, "extrapolated", profile_errors(solution, last, averaged), None, "", r)
    return table


def element_table(scene: str, resolutions: tuple[int, ...]) -> Table:
    """Accuracy and cost of every element family on every kind of mesh."""
    columns = ("unknowns", "dt c_l / h", "L1 at T", "order", "steps [s]", "mesh [s]")
    table = _table(f"{scene}: element families", ["element", "mesh", "h / c_t T"], columns)
    solution = solve(NAMED_SCENES[scene].scene)
    for element, mesh in ELEMENTS:
        errors: list[float] = []
        for resolution in resolutions:
            simulation = simulated(scene, resolution, element=element, mesh=mesh)
            errors.append(errors_of(simulation, solution).last)
            step = simulation.critical_step / simulation.element_size
            table.add_row(
                element,
                mesh,
                f"1/{resolution}",
                f"{simulation.unknowns:,}",
                f"{step * simulation.scene.material.longitudinal_speed:.3f}",
                f"{errors[-1]:.2e}",
                "" if len(errors) < 2 else f"{observed_order(errors[-2], errors[-1]):.2f}",
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
    columns = ("L1 at T", "L1 averaged", "second peak", "damping / external work")
    table = _table(
        f"{scene}, h = c_t T / {resolution}",
        ["damping c_t / h"],
        [*columns, "critical step / undamped", "energy residual"],
    )
    solution = solve(NAMED_SCENES[scene].scene)
    undamped = math.nan
    for damping in (0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2):
        simulation = simulated(scene, resolution, damping=damping)
        if not damping:
            undamped = simulation.critical_step
        errors = errors_of(simulation, solution)
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


PEAK_TRIALS: tuple[tuple[int, str, float], ...] = (
    (100, "Q1", 0.02),
    (100, "Q1", 0.01),
    (100, "Q1", 0.0),
    (100, "Q2", 0.02),
    (100, "Q2", 0.01),
    (100, "Q2", 0.005),
    (141, "Q1", 0.02),
    (141, "Q2", 0.01),
    (200, "Q1", 0.02),
    (200, "Q2", 0.01),
)
"""Resolution, element and damping of runs that might see a narrow second zone better."""


def peak_table(scene: str) -> Table:
    """How well several settings see the peak of the second zone, and what else they do."""
    columns = ("L1 at T", "L1 averaged", "second peak", "second peak / largest V", "steps [s]")
    words = ("h / c_t T", "element", "damping c_t / h")
    table = _table(f"{scene}: the second zone", words, columns)
    solution = solve(NAMED_SCENES[scene].scene)
    for resolution, element, damping in PEAK_TRIALS:
        simulation = simulated(scene, resolution, element=element, damping=damping)
        errors = errors_of(simulation, solution)
        table.add_row(
            f"1/{resolution}",
            element,
            f"{damping:g}",
            f"{errors.last:.2e}",
            f"{errors.averaged:.2e}",
            f"{errors.second_peak:+.1%}",
            f"{errors.second_over_largest:+.2%}",
            f"{simulation.seconds['steps']:.2f}",
        )
    return table


UNIT = Material(1.0, 1.0, 1 / 3)
LOADS: Mapping[str, LoadHistory] = {
    "step": Step(),
    "ramp over 0.3 T": Ramp(0.3),
    "haversine over T/2": Pulse(0.5, "haversine"),
    "harmonic, 2 per T": Harmonic(2.0),
}
VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "step": {},
    **{f"ramp over {rise:g} T": {"shear_history": Ramp(rise)} for rise in (0.1, 0.3, 1.0)},
    "triangle over 0.4 T": {"shear_history": Pulse(0.4, "triangle")},
    "rate weakening, 0.4 at 1": {"friction_law": RateWeakening(0.4, 1.0)},
    "slip weakening, 0.6 over 0.05": {"friction_law": SlipWeakening(0.6, 0.05)},
    "slip weakening, 0.6 over 0.005": {"friction_law": SlipWeakening(0.6, 0.005)},
}
"""What is changed about a shear step on constant pressure, in units of c_t, T and the loads."""

HELD = np.linspace(0.1003, 1.9, 91)
"""Positions x / (c_t T) at which stuck tractions are compared."""

EDGE_OFFSET = {"pressure": 0.27, "shear": 0.45}
"""How far the effective edge of a stuck interface lies from x = 0, over h."""


def stuck_errors(history: LoadHistory, resolution: int) -> dict[str, tuple[float, float]]:
    """Relative L1 errors of stuck pressure and shear at T under a load history, c_t = T = 1.

    Returns
    -------
    dict
        For "pressure" and "shear", the error at the nodes' own places and with the edge offset
        taken into account.
    """
    from fem import simulate

    base, load = Tractions(20.0, 0.0), Tractions(0.5, 0.8)
    scene = Scene(UNIT, 50.0, base, load, pressure_history=history, shear_history=history)
    simulation = simulate(scene, resolution=resolution, every=10**6)
    seen = simulation.interface
    errors = {}
    for name, exact, amplitude, change in (
        ("pressure", stuck_pressure, load.pressure, seen.pressure[-1] - base.pressure),
        ("shear", stuck_shear, load.shear, seen.shear_traction[-1] - base.shear),
    ):
        simulated_change = np.interp(HELD, seen.x, change)
        both = []
        for offset in (0.0, EDGE_OFFSET[name] * simulation.element_size):
            expected = exact(history, amplitude, UNIT, HELD + offset, 1.0).value
            both.append(norm(simulated_change - expected, HELD, 1) / norm(expected, HELD, 1))
        errors[name] = (both[0], both[1])
    return errors


def slip_changes(scene: Scene, resolutions: tuple[int, ...]) -> list[float]:
    """Relative L1 change of slip at T from each mesh to the next, c_t = T = 1."""
    from fem import simulate

    profiles = []
    for resolution in resolutions:
        seen = simulate(scene, resolution=resolution, every=10**6).interface
        profiles.append(np.interp(PROFILE, seen.x, seen.slip[-1]))
    return [
        norm(coarse - fine, PROFILE, 1) / norm(fine, PROFILE, 1)
        for coarse, fine in pairwise(profiles)
    ]


def history_tables(resolutions: tuple[int, ...]) -> Iterator[Table]:
    """Accuracy under loads that rise and fall: stuck tractions, and slip from mesh to mesh."""
    title = "stuck tractions at T, L1; in brackets: edge offset"
    table = _table(title, ["load", "h / c_t T"], ["pressure", "shear"])
    for name, history in LOADS.items():
        for resolution in resolutions:
            errors = stuck_errors(history, resolution)
            cells = (f"{plain:.1e} ({offset:.1e})" for plain, offset in errors.values())
            table.add_row(name, f"1/{resolution}", *cells)
    yield table
    title = "change of slip at T from mesh to mesh, L1"
    steps = [f"1/{coarse} to 1/{fine}" for coarse, fine in pairwise(resolutions)]
    table = _table(title, ["preloaded, but with"], steps)
    for name, parts in VARIANTS.items():
        scene = Scene(UNIT, 0.3, Tractions(1.0, 0.0), Tractions(0.0, 1.0), **parts)
        changes = slip_changes(scene, resolutions)
        table.add_row(name, *(f"{change:.1e}" for change in changes))
    yield table


def cost_table(scene: str, resolutions: tuple[int, ...]) -> Table:
    """A full step over one product of the active part, and what the window and the halves save.

    Step and product are timed in turns, in one run, as medians.
    """
    from fem import prepare
    from fem.run import peak_memory

    columns = ("unknowns", "product", "step", "ratio", "window saves", "trimming saves")
    table = _table(f"{scene}: cost of a step, ns per unknown", ["h / c_t T"], columns)
    for resolution in resolutions:
        model = prepare(NAMED_SCENES[scene].scene, resolution=resolution)
        plan = model.plan
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
        times = model.time_step * np.arange(1.0, model.steps + 2)
        reach = plan.fastest.longitudinal_speed * times + plan.forerun
        active = np.mean([model.numbering.reached(distance) for distance in reach])
        table.add_row(
            f"1/{resolution}",
            f"{model.unknowns:,}",
            f"{1e9 * product_time / model.unknowns:.1f}",
            f"{1e9 * step_time / model.unknowns:.1f}",
            f"{step_time / product_time:.2f}",
            f"{unknowns / active:.2f}",
            f"{replace(plan, full=True).blocks.elements / plan.blocks.elements:.2f}",
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


def observed_order(coarse: float, fine: float, refinement: float = 2.0) -> float:
    """Observed order of convergence when h is divided by the refinement."""
    return math.log(coarse / fine) / math.log(refinement)


def _add_row(
    table: Table,
    label: str,
    errors: Errors,
    previous: Errors | None,
    seconds: str,
    refinement: float,
) -> None:
    table.add_row(
        label,
        f"{errors.last:.2e}",
        f"{observed_order(previous.last, errors.last, refinement):.2f}" if previous else "",
        f"{errors.averaged:.2e}",
        f"{observed_order(previous.averaged, errors.averaged, refinement):.2f}" if previous else "",
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
    "finest": lambda: iter([accuracy("remote-shock", (400, 560))]),
    "elements": lambda: iter([element_table("preloaded", (50, 100, 200))]),
    "damping": lambda: iter([damping_table("preloaded", 100), damping_table("preloaded", 200)]),
    "peak": lambda: (peak_table(scene) for scene in ("preloaded", "remote-shock")),
    "histories": lambda: history_tables((50, 100, 200)),
    "cost": lambda: iter([cost_table("preloaded", (200, 400))]),
}


def main(arguments: list[str]) -> int:
    """Print the tables of the studies named; 2 if there is none of a name."""
    console = Console(width=120)
    if not arguments or not set(arguments) <= set(STUDIES):
        console.print(
            f"usage: python -m compare.studies.accuracy.fem {'|'.join(STUDIES)} ...", markup=False
        )
        return 2
    for name in arguments:
        for table in STUDIES[name]():
            console.print(table)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
