"""Studies of the finite-element model under loads that rise and fall, and of the cost of a step.

``python -m docs.studies.accuracy.fem_loads stuck`` prints a table; `STUDIES` lists the others.
With ``--csv docs/data``, the data of docs/fem.md are written.
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
from docs.studies.accuracy.fem import PROFILE
from semianalytic.halfplane.stuck_histories import stuck_pressure, stuck_shear
from semianalytic.scene.friction import RateWeakening, SlipWeakening
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.loads import Harmonic, LoadHistory, Pulse, Ramp, Step
from semianalytic.scene.scene import Material, Scene, Tractions
from semianalytic.selfsimilar.solver import solve

if TYPE_CHECKING:
    from fem.plan import Plan

Array = NDArray[np.float64]

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
"""Changes to a shear step on constant pressure, in units of c_t, T and the loads."""

HELD = np.linspace(0.1003, 1.9, 91)
"""Positions x / (c_t T) at which stuck tractions are compared."""


def stuck_errors(history: LoadHistory, resolution: int) -> tuple[float, float, float]:
    """Return relative L1 errors of stuck tractions at T under a load history, c_t = T = 1.

    The mesh places the edge of the closed contact at x = 0.  The effective edge for shear on a
    stuck contact lies beside it, see `fem.elements.edge`.

    Returns
    -------
    pressure, shear, shear_beside : float
        Relative errors; for the last, the exact traction has its edge at the effective edge.
    """
    from fem import simulate
    from fem.elements.edge import edge_offset
    from fem.elements.families import FAMILIES

    base, load = Tractions(20.0, 0.0), Tractions(0.5, 0.8)
    scene = Scene(UNIT, 50.0, base, load, pressure_history=history, shear_history=history)
    simulation = simulate(scene, resolution=resolution, every=10**6)
    closed, stuck = (edge_offset([UNIT], FAMILIES["Q1"], held) for held in (1, 0))
    beside = (stuck - closed) * simulation.element_size
    pressure = simulation.pressure(HELD, 1.0) - base.pressure
    shear = simulation.shear_traction(HELD, 1.0) - base.shear
    return (
        _error(pressure, stuck_pressure(history, load.pressure, UNIT, HELD, 1.0).value),
        _error(shear, stuck_shear(history, load.shear, UNIT, HELD, 1.0).value),
        _error(shear, stuck_shear(history, load.shear, UNIT, HELD + beside, 1.0).value),
    )


def _error(simulated: Array, exact: Array) -> float:
    return norm(simulated - exact, HELD, 1) / norm(exact, HELD, 1)


@dataclass(frozen=True)
class EdgeRow:
    """Relative L1 errors at T over 0.05 < x/(c_t T) < 1.9 with the first node at x = `edge` h.

    Errors of tractions are relative to their change.  Slip rates are those of single steps; their
    error is nan if nothing slips.
    """

    scene: str
    h: str
    edge: float
    slip_rate: float
    slip: float
    shear: float
    pressure: float


def edge_rows(scenes: Sequence[str], resolutions: Sequence[int]) -> list[EdgeRow]:
    """Measure the benefit of a mesh with the edge of a closed contact at x = 0."""
    from fem import Settings
    from fem.plan import Plan

    rows = []
    for name in scenes:
        scene = NAMED_SCENES[name].scene
        for resolution in resolutions:
            plan = Plan(scene, 1.0, Settings(resolution=resolution))
            for edge in (0.0, plan.edge):
                errors = _field_errors(plan, edge)
                rows.append(EdgeRow(name, f"1/{resolution}", edge / plan.size, *errors))
    return rows


def _field_errors(plan: Plan, edge: float) -> list[float]:
    """Return the errors of an `EdgeRow` with the first node at a position [length]."""
    from fem.elements.assembly import make_space
    from fem.model import build_model
    from fem.run import drift, levels
    from meshes import cached_mesh

    space = make_space(cached_mesh(plan.blocks).translated((edge, 0.0)), plan.family)
    model = build_model(plan, space)
    for step in levels(model):
        if step < model.steps:
            drift(model, step)
    interface, solution = model.interface, solve(plan.scene)
    sliding = interface.sliding
    assert sliding is not None, "symmetry forbids this scene to slip"
    place = PROFILE[PROFILE > 0.05] * plan.scene.material.shear_speed
    held, errors = plan.scene.superposition.in_place, []
    for values, exact, before in (
        (sliding.mean_increment() / model.time_step, solution.slip_rate, 0.0),
        (sliding.offset(), solution.slip, 0.0),
        (interface.shear, solution.shear_traction, held.shear),
        (interface.pressure, solution.pressure, held.pressure),
    ):
        expected, seen = exact(place, 1.0), np.interp(place, model.contact_x, values)
        size = norm(expected - before, place, 1)
        errors.append(norm(seen - expected, place, 1) / size if size else math.nan)
    return errors


def slip_changes(scene: Scene, resolutions: tuple[int, ...]) -> list[float]:
    """Return the relative L1 change of slip at T from each mesh to the next, c_t = T = 1."""
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
    """Result of `stuck_errors` for a load on one mesh."""

    load: str
    h: str
    pressure: float
    shear: float
    shear_beside: float


def stuck_rows(resolutions: Sequence[int]) -> list[StuckRow]:
    """Measure the accuracy of stuck tractions under loads that rise and fall."""
    return [
        StuckRow(name, f"1/{resolution}", *stuck_errors(history, resolution))
        for name, history in LOADS.items()
        for resolution in resolutions
    ]


@dataclass(frozen=True)
class ChangeRow:
    """Result of `slip_changes` for `preloaded` with another load or friction law."""

    variant: str
    coarse: float
    fine: float


def change_rows(resolutions: tuple[int, int, int]) -> list[ChangeRow]:
    """Measure how slip changes from mesh to mesh for each of the `VARIANTS`."""
    base, load = Tractions(1.0, 0.0), Tractions(0.0, 1.0)
    return [
        ChangeRow(name, *slip_changes(Scene(UNIT, 0.3, base, load, **parts), resolutions))
        for name, parts in VARIANTS.items()
    ]


@dataclass(frozen=True)
class CostRow:
    """Cost of a time step.

    It holds times of a product with the stiffness and of a full step [ns per unknown], their ratio,
    and the factors by which the window and the trimmed domain reduce the unknowns.
    """

    h: str
    unknowns: int
    product: float
    step: float
    ratio: float
    window: float
    trimming: float


def cost_rows(scene: str, resolutions: Sequence[int]) -> list[CostRow]:
    """Measure a full step over a product of the active part, and the savings of window and halves.

    Step and product run in turns within one run; the results are medians.
    """
    from fem import prepare

    rows = []
    for resolution in resolutions:
        model = prepare(NAMED_SCENES[scene].scene, resolution=resolution)
        plan = model.plan
        unknowns = model.unknowns // len(model.bodies)
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
        reach = plan.fastest_speed * times + plan.forerun
        active = np.mean([2 * model.numbering.reached(distance) for distance in reach])
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
    """Return the median wall-clock times of two functions called in turns [s]."""
    seconds: tuple[list[float], list[float]] = ([], [])
    for _ in range(times):
        for function, taken in zip((one, other), seconds, strict=True):
            started = time.perf_counter()
            function()
            taken.append(time.perf_counter() - started)
    return float(np.median(seconds[0])), float(np.median(seconds[1]))


STUDIES: Mapping[str, Study] = {
    "edge": lambda: edge_rows(("remote-shock", "stuck", "pressure-drop"), (50, 100, 200)),
    "stuck": lambda: stuck_rows((50, 100, 200)),
    "changes": lambda: change_rows((50, 100, 200)),
    "cost": lambda: cost_rows("preloaded", (200, 400)),
}


if __name__ == "__main__":
    raise SystemExit(run_studies("docs.studies.accuracy.fem_loads", "fem", STUDIES))
