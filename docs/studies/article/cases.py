"""The article's cases: its material, its loads on a base, and two answers to each.

The article takes f P_0 = 1 and Q_0 = 1/chi without a base load.  The friction bound f P_0 p*(u) is
then negative on 0.59 c_t t < x < c_l t, where Coulomb's law is not defined.  Two physical bases
replace it:

- remote: the loads arrive as sudden remote loads (P_0, Q_0), base = step;
- preloaded: constant pressure P_0, sudden shear Q_0.

Lengths and times are those of the article (c_t = 5, t = 0.01).  It gives no modulus; here mu = 1.
Slip rates are relative, over V_0 = 2 Q_0/(mu b), whereas the article's V is one-sided.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from docs.studies.article.kernels import SlipHistory, interface_traction
from docs.studies.article.prescribed import slipping_half_plane
from docs.studies.runner import Row
from fem import simulate
from semianalytic import Material, Scene, Solution, Tractions, solve
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.arrays import Array
from semianalytic.scene.loading import REMOTE

END_TIME, SHEAR_SPEED = 0.01, 5.0
LOW_FRICTION = 0.01
RATIOS = {"remote": 1 / 3, "preloaded": 1 / 3, "auxetic": -0.5}
"""Poisson ratios; in the last, preloaded case reverse slip covers a visible width."""
CASES = (
    *(("remote", chi) for chi in (LOW_FRICTION, 0.5, 0.9, 1.2, 2.0)),
    *(("preloaded", chi) for chi in (LOW_FRICTION, 0.5, 2.0)),
    ("auxetic", LOW_FRICTION),
)


def article_scene(kind: str, chi: float) -> Scene:
    """Return the scene with f P_0 = 1 and Q_0 = 1/chi of a kind, a key of `RATIOS`."""
    material = Material(1.0, 1 / SHEAR_SPEED**2, RATIOS[kind])
    if kind == "remote":
        nothing, loads = Tractions(0.0, 0.0), Tractions(1.0, 1 / chi)
        return Scene(material, 1.0, base=nothing, load=loads, load_on=REMOTE)
    return Scene(material, 1.0, base=Tractions(1.0, 0.0), load=Tractions(0.0, 1 / chi))


@dataclass(frozen=True)
class Case:
    """A scene with its exact solution, and its finite-element history on elements per c_t T."""

    kind: str
    chi: float
    solution: Solution
    history: InterfaceHistory
    resolution: int

    @property
    def scale(self) -> float:
        """V_0 = 2 Q_0/(mu b), the relative slip rate under a plane shear wave [length / time]."""
        return 2 / self.chi / self.solution.scene.material.shear_impedance

    def exact(self, velocity: Array) -> Array:
        """Return the exact slip rate over V_0 at velocities x/(c_t t)."""
        return self.solution.slip_rate(velocity * SHEAR_SPEED, 1.0) / self.scale

    def simulated(self) -> tuple[Array, Array]:
        """Return x/(c_t T) > 0 and the slip rate over V_0 at the end of the simulation."""
        x = self.history.x / (SHEAR_SPEED * self.history.t[-1])
        return x, self.history.slip_rate[-1] / self.scale

    def simulated_mean(self, low: float, high: float) -> float:
        """Return the mean of the simulated slip rate over low < x/(c_t T) < high."""
        velocity, rate = self.simulated()
        return float(rate[(velocity > low) & (velocity < high)].mean())

    def difference(self) -> float:
        """Return the mean difference of the two slip rates over x < c_l T, over V_0."""
        velocity, rate = self.simulated()
        inside = velocity < self.solution.scene.material.longitudinal_speed / SHEAR_SPEED
        return float(np.abs(rate[inside] - self.exact(velocity[inside])).mean())


Cases = Mapping[tuple[str, float], Case]


@cache
def run_case(kind: str, chi: float, resolution: int) -> Case:
    """Solve and simulate one case; the work grows with the third power of the resolution."""
    scene = article_scene(kind, chi)
    run = simulate(scene, END_TIME, resolution=resolution, every=max(1, resolution // 10))
    return Case(kind, chi, solve(scene), run.interface, resolution)


def run_cases(resolution: int) -> Cases:
    """Solve and simulate all cases."""
    return {case: run_case(*case, resolution) for case in CASES}


def smooth_slip() -> SlipHistory:
    """Return a Gaussian pulse of slip that reaches the edge, over by t = 1 where c_t = 1."""
    centre, width, moment, duration = 0.25, 0.18, 0.45, 0.12

    def rate(x: Array, t: Array) -> Array:
        return np.exp(-np.square((x - centre) / width) - np.square((t - moment) / duration))

    return SlipHistory(
        slip_rate=rate,
        gradient=lambda x, t: -2 * (x - centre) / width**2 * rate(x, t),
        acceleration=lambda x, t: -2 * (t - moment) / duration**2 * rate(x, t),
    )


def slot_rows(mode: Mode, element_size: float) -> list[Row]:
    """Prescribe a smooth slip, slot faces free; return tractions at t = 1, simulated and by
    kernels.
    """
    material, slip = Material(1.0, 1.0, RATIOS["remote"]), smooth_slip()
    motion = slipping_half_plane(
        material, slip, mode, end_time=1.0, element_size=element_size, half_width=1.8
    )
    inside = (motion.x > -1.0) & (motion.x < 1.2) & (np.abs(motion.x) > 0.05)
    x = motion.x[inside]
    free, held = (
        interface_traction(slip, mode, material, x, 1.0, slot=slot, rtol=1e-4)
        for slot in ("free", "held")
    )
    columns = {"x": x, "simulated": motion.traction[inside], "free": free, "held": held}
    lines = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [{"mode": mode} | dict(zip(columns, line, strict=True)) for line in lines]


def slot_errors(rows: list[Row]) -> list[Row]:
    """Return the largest difference of each kernel from the simulation, over its largest value."""
    table: list[Row] = []
    for mode in dict.fromkeys(row["mode"] for row in rows):
        own = [row for row in rows if row["mode"] == mode]
        largest = max(abs(row["simulated"]) for row in own)
        errors = {
            name: max(abs(row[name] - row["simulated"]) for row in own) / largest
            for name in ("free", "held")
        }
        table.append({"mode": mode} | errors)
    return table
