"""Studies of the finite-element model against the exact solution: accuracy, elements, cost.

``python -m compare.studies.accuracy.fem accuracy`` prints a table; `STUDIES` lists the others, and
``--csv docs/data`` writes what docs/fem.md shows.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import norm
from compare.studies.tables import Study, run_studies
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


@dataclass(frozen=True)
class MeshRow:
    """Errors of a scene on one mesh, or extrapolated from two; errors as in `Errors`.

    `last_order` and `averaged_order` are the observed orders since the mesh before, nan without
    one; `seconds` those of stepping.
    """

    scene: str
    h: str
    last: float
    last_order: float
    averaged: float
    averaged_order: float
    first_peak: float
    second_peak: float
    second_over_largest: float
    seconds: float


def accuracy(scene: str, resolutions: Sequence[int], **options: Any) -> list[MeshRow]:
    """Errors and observed order on several meshes, and extrapolated from the two finest.

    The last row is (r V(h/r) - V(h))/(r - 1), which removes what is of first order in h.
    """
    solution = solve(NAMED_SCENES[scene].scene)
    rows: list[MeshRow] = []
    profiles: list[tuple[Array, Array]] = []
    for index, resolution in enumerate(resolutions):
        simulation = simulated(scene, resolution, **options)
        profiles.append((last_profile(simulation), averaged_profile(simulation)))
        errors = profile_errors(solution, *profiles[-1])
        orders = (math.nan, math.nan)
        if rows:
            r = resolution / resolutions[index - 1]
            orders = (
                observed_order(rows[-1].last, errors.last, r),
                observed_order(rows[-1].averaged, errors.averaged, r),
            )
        seconds = simulation.seconds["steps"]
        rows.append(_mesh_row(scene, f"1/{resolution}", errors, orders, seconds))
    r = resolutions[-1] / resolutions[-2]
    last, averaged = (
        (r * fine - coarse) / (r - 1) for coarse, fine in zip(*profiles[-2:], strict=True)
    )
    errors = profile_errors(solution, last, averaged)
    return [*rows, _mesh_row(scene, "extrapolated", errors, (math.nan, math.nan), math.nan)]


def _mesh_row(
    scene: str, h: str, errors: Errors, orders: tuple[float, float], seconds: float
) -> MeshRow:
    return MeshRow(
        scene,
        h,
        errors.last,
        orders[0],
        errors.averaged,
        orders[1],
        errors.first_peak,
        errors.second_peak,
        errors.second_over_largest,
        seconds,
    )


@dataclass(frozen=True)
class ElementRow:
    """Accuracy and cost of an element family on one mesh.

    `step` is the critical time step times c_l/h, `error` the L1 error at T, `order` that since the
    mesh before; `steps` and `meshing` are seconds.
    """

    element: str
    mesh: str
    h: str
    unknowns: int
    step: float
    error: float
    order: float
    steps: float
    meshing: float


def element_rows(scene: str, resolutions: Sequence[int]) -> list[ElementRow]:
    """Accuracy and cost of every element family on every kind of mesh."""
    solution, rows = solve(NAMED_SCENES[scene].scene), []
    for element, mesh in ELEMENTS:
        before = math.nan
        for resolution in resolutions:
            simulation = simulated(scene, resolution, element=element, mesh=mesh)
            error = errors_of(simulation, solution).last
            step = simulation.critical_step / simulation.element_size
            rows.append(
                ElementRow(
                    element,
                    mesh,
                    f"1/{resolution}",
                    simulation.unknowns,
                    step * simulation.scene.material.longitudinal_speed,
                    error,
                    observed_order(before, error),
                    simulation.seconds["steps"],
                    simulation.seconds["mesh"],
                )
            )
            before = error
    return rows


ELEMENTS = (
    ("Q1", "squares"),
    ("P1", "squares"),
    ("P1", "triangles"),
    ("Q2", "squares"),
    ("Q1", "graded"),
)


@dataclass(frozen=True)
class DampingRow:
    """What damping does: errors as in `Errors`, energy and residual over the external work,
    critical step over the undamped one."""

    damping: float
    last: float
    averaged: float
    second_peak: float
    energy: float
    critical_step: float
    residual: float


def damping_rows(scene: str, resolution: int) -> list[DampingRow]:
    """What damping does to the error, the energy it takes and the critical step."""
    solution, rows, undamped = solve(NAMED_SCENES[scene].scene), [], math.nan
    for damping in (0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2):
        simulation = simulated(scene, resolution, damping=damping)
        if not damping:
            undamped = simulation.critical_step
        errors, energy = errors_of(simulation, solution), simulation.energy
        rows.append(
            DampingRow(
                damping,
                errors.last,
                errors.averaged,
                errors.second_peak,
                float(energy.damping[-1] / energy.external[-1]),
                simulation.critical_step / undamped,
                energy.residual,
            )
        )
    return rows


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


@dataclass(frozen=True)
class PeakRow:
    """One of the `PEAK_TRIALS`: errors as in `Errors`, seconds of stepping."""

    scene: str
    h: str
    element: str
    damping: float
    last: float
    averaged: float
    second_peak: float
    second_over_largest: float
    seconds: float


def peak_rows(scene: str) -> list[PeakRow]:
    """How well several settings see the peak of the second zone, and what else they do."""
    solution, rows = solve(NAMED_SCENES[scene].scene), []
    for resolution, element, damping in PEAK_TRIALS:
        simulation = simulated(scene, resolution, element=element, damping=damping)
        errors = errors_of(simulation, solution)
        rows.append(
            PeakRow(
                scene,
                f"1/{resolution}",
                element,
                damping,
                errors.last,
                errors.averaged,
                errors.second_peak,
                errors.second_over_largest,
                simulation.seconds["steps"],
            )
        )
    return rows


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


@dataclass(frozen=True)
class StuckRow:
    """`stuck_errors` of a load on one mesh: as they are, and with the edge offset."""

    load: str
    h: str
    pressure: float
    pressure_offset: float
    shear: float
    shear_offset: float


def stuck_rows(resolutions: Sequence[int]) -> list[StuckRow]:
    """Accuracy of stuck tractions under loads that rise and fall."""
    rows = []
    for name, history in LOADS.items():
        for resolution in resolutions:
            errors = stuck_errors(history, resolution)
            rows.append(StuckRow(name, f"1/{resolution}", *errors["pressure"], *errors["shear"]))
    return rows


@dataclass(frozen=True)
class ChangeRow:
    """`slip_changes` of `preloaded` with another load or friction law, on three meshes."""

    variant: str
    coarse: float
    fine: float


def change_rows(resolutions: tuple[int, int, int]) -> list[ChangeRow]:
    """How slip changes from mesh to mesh under each of the `VARIANTS`."""
    base, load = Tractions(1.0, 0.0), Tractions(0.0, 1.0)
    return [
        ChangeRow(name, *slip_changes(Scene(UNIT, 0.3, base, load, **parts), resolutions))
        for name, parts in VARIANTS.items()
    ]


@dataclass(frozen=True)
class CostRow:
    """Product of the stiffness and a full step [ns per unknown], their ratio, and by what factor
    the window and the trimmed domain save unknowns."""

    h: str
    unknowns: int
    product: float
    step: float
    ratio: float
    window: float
    trimming: float


def cost_rows(scene: str, resolutions: Sequence[int]) -> list[CostRow]:
    """A full step over one product of the active part, and what the window and the halves save.

    Step and product are timed in turns, in one run, as medians.
    """
    from fem import prepare

    rows = []
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
        rows.append(
            CostRow(
                f"1/{resolution}",
                model.unknowns,
                1e9 * product_time / model.unknowns,
                1e9 * step_time / model.unknowns,
                step_time / product_time,
                float(unknowns / active),
                replace(plan, full=True).blocks.elements / plan.blocks.elements,
            )
        )
    return rows


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


ACCURACY_MESHES = (100, 200, 400)

STUDIES: Mapping[str, Study] = {
    "accuracy": lambda: [
        *accuracy("preloaded", ACCURACY_MESHES),
        *accuracy("remote-shock", ACCURACY_MESHES),
    ],
    "undamped": lambda: accuracy("preloaded", ACCURACY_MESHES, damping=0.0),
    "finest": lambda: accuracy("remote-shock", (400, 560)),
    "elements": lambda: element_rows("preloaded", (50, 100, 200)),
    "damping": lambda: damping_rows("preloaded", 200),
    "peak": lambda: [*peak_rows("preloaded"), *peak_rows("remote-shock")],
    "stuck": lambda: stuck_rows((50, 100, 200)),
    "changes": lambda: change_rows((50, 100, 200)),
    "cost": lambda: cost_rows("preloaded", (200, 400)),
}


if __name__ == "__main__":
    raise SystemExit(run_studies("compare.studies.accuracy.fem", "fem", STUDIES))
