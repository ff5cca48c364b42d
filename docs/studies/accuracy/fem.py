"""Studies of the finite-element model against the exact solution: accuracy, elements, smoothing.

``python -m docs.studies.accuracy.fem accuracy`` prints a table; `STUDIES` lists the others.  With
``--csv docs/data``, the data of docs/fem.md are written.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import norm
from compare.studies.tables import Study, run_studies
from docs.studies.profiles import (
    PROFILE,
    Errors,
    averaged_profile,
    errors_of,
    last_profile,
    profile_errors,
)
from semianalytic import solve
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.scene import Material, Scene, Tractions

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeshRow:
    """Errors of a scene on one mesh, or extrapolated from two; for the errors see `Errors`.

    `last_order` and `averaged_order` are the observed orders since the mesh before, nan for the
    first mesh; `seconds` is the time of stepping.
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
    """Compute errors and observed orders on several meshes, and extrapolate from the two finest.

    The extrapolation (r V(h/r) - V(h))/(r - 1) in the last row removes errors of first order in h.
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

    `step` is the critical time step times c_l/h, `error` the L1 error at T, and `order` its
    observed order since the mesh before; `steps` and `meshing` are times [s].
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
    """Measure accuracy and cost of every element family on every kind of mesh."""
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
    """Effect of damping.

    It holds errors as in `Errors`, dissipated energy and residual over the external work, and the
    critical step over the undamped one.
    """

    damping: float
    last: float
    averaged: float
    second_peak: float
    energy: float
    critical_step: float
    residual: float


def damping_rows(scene: str, resolution: int) -> list[DampingRow]:
    """Measure how damping affects the error, the dissipated energy and the critical step."""
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


class Smoothing(NamedTuple):
    """Options of a run, which are fields of `fem.Settings`."""

    resolution: int = 100
    element: str = "Q1"
    damping: float = 0.02
    step_ratio: float = 0.95


SMOOTHING_TRIALS = (
    Smoothing(),
    Smoothing(damping=0.005),
    Smoothing(damping=0.01),
    Smoothing(damping=0.03),
    Smoothing(102, step_ratio=1.0),
    Smoothing(90, "P1"),
    Smoothing(78, "Q2", damping=0.01),
    Smoothing(142),
)
"""Settings that might resolve a narrow second zone better.

The first is the default.  All others but the last cost as much as the first."""

SMOOTHING_SCENES: Mapping[str, Scene] = {
    **{name: NAMED_SCENES[name].scene for name in ("preloaded", "remote-shock")},
    "auxetic": Scene(Material(1.0, 1.0, -0.5), 0.05, Tractions(1.0, 0.0), Tractions(0.0, 1.0)),
    "shock, less base": Scene(
        Material(1.0, 1.0, 0.25), 1.0, Tractions(1.0, 0.8), Tractions(1.0, 1.0)
    ),
}
"""Self-similar scenes with two slip zones, the second ahead of the shear wave."""


@dataclass(frozen=True)
class SmoothingRow:
    """Result of one of the `SMOOTHING_TRIALS`: errors as in `Errors`, and those of the second zone.

    `second_zone` is the relative L1 error at T over that zone, `slip` that of slip at T, `bar` the
    relative L1 change at T from a mesh of twice the element size, `work` unknowns times steps.
    """

    scene: str
    h: str
    element: str
    damping: float
    step_ratio: float
    work: float
    last: float
    bar: float
    averaged: float
    second_peak: float
    second_zone: float
    slip: float


def smoothing_rows() -> list[SmoothingRow]:
    """Measure errors and error bars of settings that smooth more or less, and of second zones."""
    return [
        _smoothing_row(name, scene, trial)
        for name, scene in SMOOTHING_SCENES.items()
        for trial in SMOOTHING_TRIALS
    ]


def _smoothing_row(name: str, scene: Scene, trial: Smoothing) -> SmoothingRow:
    from fem import Settings, simulate

    solution, place = solve(scene), PROFILE * scene.material.shear_speed
    settings = Settings(**trial._asdict())
    run = simulate(scene, 1.0, settings)
    coarse = simulate(scene, 1.0, settings, resolution=trial.resolution // 2, every=10**6)
    last, exact, exact_slip = (
        last_profile(run),
        solution.slip_rate(place, 1.0),
        solution.slip(place, 1.0),
    )
    slip = np.interp(place, run.interface.x, run.interface.slip[-1])
    errors = profile_errors(solution, last, averaged_profile(run))
    second = solution.zones[1]
    inside = (place > second.inner) & (place < second.outer)
    return SmoothingRow(
        name,
        f"1/{trial.resolution}",
        trial.element,
        trial.damping,
        trial.step_ratio,
        work=float(run.unknowns) * run.steps,
        last=errors.last,
        bar=_relative(last - last_profile(coarse), exact),
        averaged=errors.averaged,
        second_peak=errors.second_peak,
        second_zone=_relative((last - exact) * inside, exact * inside),
        slip=_relative(slip - exact_slip, exact_slip),
    )


def _relative(difference: Array, exact: Array) -> float:
    return norm(difference, PROFILE, 1) / norm(exact, PROFILE, 1)


def simulated(scene: str, resolution: int, **options: Any) -> Simulation:
    """Simulate a named scene."""
    from fem import simulate

    return simulate(NAMED_SCENES[scene].scene, resolution=resolution, **options)


def observed_order(coarse: float, fine: float, refinement: float = 2.0) -> float:
    """Return the observed order of convergence when h is divided by the refinement."""
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
    "smoothing": smoothing_rows,
}


if __name__ == "__main__":
    raise SystemExit(run_studies("docs.studies.accuracy.fem", "fem", STUDIES))
