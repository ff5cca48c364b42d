"""Error estimates of marches against their true errors, over many scenes.

The reference is the self-similar solution if there is one, otherwise a march on six times as many
nodes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from docs.studies.campaign.scenes import drawn, random_history_scene, random_step_scene
from semianalytic import (
    Answer,
    Marched,
    Ramp,
    RateWeakening,
    Scene,
    SlipfrontError,
    SlipWeakening,
    Tractions,
    solve,
)
from semianalytic.scene.contact import process_zone
from semianalytic.scene.given.named import NAMED_SCENES

Array = NDArray[np.float64]

NODES = 256
FINER = 6
STEPS, HISTORIES = 30, 24
"""Number of random scenes with step loads and with other load histories."""
SEED = 14
NODES_IN_PROCESS_ZONE = (2, 3, 4, 6, 8, 12, 16, 24)
FINEST_IN_PROCESS_ZONE = 64
ROUNDING = 1e-12
LEVELS = 100
"""Largest number of levels at which slip rates are compared."""

_PRELOADED = NAMED_SCENES["preloaded"].scene
_QUARTER = replace(_PRELOADED.material, poisson_ratio=0.25)
WEAKENING: Mapping[str, tuple[Scene, float]] = {
    "step": (
        Scene(
            _QUARTER,
            0.6,
            Tractions(1.0, 0.4),
            Tractions(0.0, 0.4),
            friction_law=SlipWeakening(2 / 3, 0.05),
        ),
        2.0,
    ),
    "heavy": (
        Scene(
            _PRELOADED.material,
            0.6,
            Tractions(1.0, 0.1),
            Tractions(0.0, 0.5),
            friction_law=SlipWeakening(0.9, 0.05),
        ),
        1.0,
    ),
    "ramp": (
        Scene(
            _QUARTER,
            0.6,
            Tractions(1.0, 0.3),
            Tractions(0.0, 0.4),
            shear_history=Ramp(0.4),
            friction_law=SlipWeakening(0.5, 0.05),
        ),
        1.0,
    ),
}
"""Scenes that weaken with slip, and their end times."""


@dataclass(frozen=True)
class Judged:
    """True and estimated relative error of one result of a march."""

    scenes: str
    quantity: str
    true: float
    estimate: float


def judged(name: str, marched: Marched, truth: Answer) -> list[Judged]:
    """Compare the errors of a march with its estimates; return no rows if nothing happens.

    The errors are those of slip rate in L1 over space and time, of final fields in L1 over space,
    and of totals at the end.
    """
    x, end = marched.interface.x, marched.end_time
    rows = [Judged(name, "slip rate", rate_error(marched, truth), marched.error_estimate)]
    readings: Mapping[str, Callable[[Answer], Array]] = {
        "slip": lambda answer: answer.slip(x, end),
        "shear traction": lambda answer: answer.shear_traction(x, end),
        "largest slip": lambda answer: answer.max_slip(end),
        "accumulated slip": lambda answer: answer.accumulated_slip(end),
        "frictional work": lambda answer: answer.frictional_work(end),
    }
    for quantity, reading in readings.items():
        exact = reading(truth)
        scale = float(np.abs(exact).sum())
        if not 0 < scale < math.inf:
            continue
        true = float(np.abs(reading(marched) - exact).sum()) / scale
        estimate = float(marched.error_of(reading).sum()) / scale
        rows.append(Judged(name, quantity, true, estimate))
    return [row for row in rows if row.true > ROUNDING]


def rate_error(marched: Marched, truth: Answer) -> float:
    """Return the relative L1 error of the slip rate of a march over nodes and stored levels."""
    own = marched.interface
    seen = np.arange(len(own.t) - 1, 0, -max(1, len(own.t) // LEVELS))
    exact = truth.slip_rate(own.x, own.t[seen, None])
    size = float(np.abs(exact).sum())
    return float(np.abs(own.slip_rate[seen] - exact).sum()) / size if size else 0.0


def error_scenes() -> Iterator[tuple[str, Scene]]:
    """Yield named and random scenes, each with its kind."""
    named = [entry.scene for entry in NAMED_SCENES.values()]
    steps = [drawn(SEED, index, random_step_scene)[0] for index in range(STEPS)]
    histories = [drawn(SEED, index, random_history_scene)[0] for index in range(HISTORIES)]
    for scene in [*named, *steps, *histories]:
        if isinstance(scene.friction_law, RateWeakening):
            kind = "rate weakening"
        else:
            kind = "self-similar" if scene.is_self_similar else "histories and slip weakening"
        yield kind, scene


def all_judged(nodes: int = NODES) -> list[Judged]:
    """Judge the marches of all `error_scenes` that they resolve."""
    rows = []
    for kind, scene in error_scenes():
        end = 1 / scene.material.shear_speed
        try:
            marched = solve(scene, method="space-time", end_time=end, nodes=nodes)
            if marched.status != "resolved":
                continue
            if scene.is_self_similar:
                truth: Answer = solve(scene, method="self-similar")
            else:
                length = nodes * marched.grid.spacing
                truth = solve(
                    scene,
                    method="space-time",
                    end_time=end,
                    nodes=FINER * nodes,
                    length=length,
                    companion=False,
                )
        except SlipfrontError:
            continue
        rows += judged(kind, marched, truth)
    return rows


@dataclass(frozen=True)
class ErrorRow:
    """Ratios of estimated to true errors: share of those above 1, and their distribution."""

    scenes: str
    quantity: str
    cases: int
    covered: float
    least: float
    median: float
    largest: float


def error() -> list[ErrorRow]:
    """Measure how often and how far estimates exceed true errors, by kind of scene."""
    groups: dict[tuple[str, str], list[float]] = {}
    for row in all_judged():
        groups.setdefault((row.scenes, row.quantity), []).append(row.estimate / row.true)
    return [
        ErrorRow(
            *group,
            len(ratios),
            float(np.mean(np.array(ratios) >= 1)),
            min(ratios),
            float(np.median(ratios)),
            max(ratios),
        )
        for group, ratios in sorted(groups.items(), reverse=True)
    ]


@dataclass(frozen=True)
class WeakeningRow:
    """Relative errors under slip weakening, by the number of nodes in the process zone."""

    scene: str
    nodes: int
    slip_rate: float
    estimate: float
    slip: float
    work: float


def weakening() -> list[WeakeningRow]:
    """Measure errors relative to marches with 64 nodes in the process zone."""
    rows = []
    for name, (scene, end) in WEAKENING.items():
        length = scene.material.longitudinal_speed * end
        share = length / process_zone(scene)
        finest = round(FINEST_IN_PROCESS_ZONE * share)
        truth = solve(
            scene, method="space-time", end_time=end, nodes=finest, length=length, companion=False
        )
        for count in NODES_IN_PROCESS_ZONE:
            marched = solve(
                scene,
                method="space-time",
                end_time=end,
                nodes=math.ceil(count * share),
                length=length,
            )
            found = {row.quantity: row.true for row in judged(name, marched, truth)}
            rows.append(
                WeakeningRow(
                    name,
                    count,
                    found["slip rate"],
                    marched.error_estimate,
                    found["slip"],
                    found["frictional work"],
                )
            )
    return rows
