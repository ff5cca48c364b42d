"""Slip under any load history: the interface alone, marched in time on a spectral grid.

On the whole line y = 0, slot included, the shear traction is (4.40), with the sign of section 6,

    tau = Q_b - (rho c_t / 2) [V + int h(q c_t (t - s)) q c_t V ds]   for each wavenumber q,

with V the relative slip rate and h from `exponentials`.  On the slot tau is prescribed, which
gives V; on the contact V is what Coulomb's law leaves of the traction that would stop the point.
V is linear in time over a step; the memory of its end value is small and iterated twice, which
converges while that of the shortest wave stays below the local term (`feedback` < 1).  Short waves
are damped by raising their feedback: by (q/q_max)^4, so that what is resolved is left alone.

Cosines about both ends of the grid mirror the scene: nothing that starts at x = 0 comes back from
the mirrors to the observed length before the latest time.  Jumps of the loads fall on time levels;
between them a level takes the load at its time, or the exact mean over a step that holds several
samples of a table.  What turns faster than the grid follows is refused (`resolution`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
from semianalytic.scene.checks import LARGEST, checked_count, checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene, checked_scene
from semianalytic.spacetime.advancing import advance
from semianalytic.spacetime.exponentials import Memory, fit_memory, impedance_of
from semianalytic.spacetime.grid_pressure import GridPressure
from semianalytic.spacetime.march_memory import check_size
from semianalytic.spacetime.marched import Extremes, Grid, Marched, MarchState, MarchStatistics
from semianalytic.spacetime.resolution import (
    check_loads,
    check_weakening_seen,
    nodes_for_weakening,
    nodes_for_zone,
)
from semianalytic.spacetime.stepping import check_levels, segments_between
from semianalytic.spacetime.tuning import (
    FIRST_NODES,
    GROWTH_MARGIN,
    LARGEST_FEEDBACK,
    LARGEST_GROWTH,
    LARGEST_STEP_RATIO,
    LEAST_GROWTH,
    LEAST_NODES,
    MARGIN_NODES,
    MOST_NODES,
    NODES,
    ORDERS,
    STEP_RATIO,
    TOLERANCES,
)


def causal_grid(scene: Scene, latest: float, length: float, nodes: int) -> Grid:
    """The smallest grid whose mirrors are out of reach of 0 < x < length until `latest`."""
    from scipy.fft import next_fast_len

    spacing = length / nodes
    reach = scene.fastest_speed * latest
    contact = math.ceil(max(length, (reach + length) / 2) / spacing) + MARGIN_NODES
    slot = math.ceil(reach / 2 / spacing) + MARGIN_NODES
    size = next_fast_len(contact + slot, real=True)
    return Grid(spacing, size - contact, nodes, size)


def march(
    scene: Scene,
    end_time: float | None = None,
    nodes: int | None = None,
    *,
    rtol: float | None = None,
    length: float | None = None,
    latest: float | None = None,
    companion: bool = True,
    step_ratio: float = STEP_RATIO,
    damping: float = 0.7,
    every: int = 1,
    tolerance: float = 1e-6,
    memory: float | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Marched:
    """March the interface of a scene in time, under any load history and friction law.

    Memory is 80 bytes per pole (about 25) and grid node (about 1.5 per contact node), and 32
    bytes per stored node and level (see `GridPressure` for pressure that oscillates), and half as
    much again for the companion; time grows like nodes^2.

    Parameters
    ----------
    scene : Scene
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    nodes : int, optional
        Contact nodes on 0 < x < length, at least 16.  1000 unless given, or up to 8000 where that
        lets the grid follow the loads, or resolve the slip zone at the edge or slip weakening.
    rtol : float, optional
        Largest `Marched.error_estimate`, in place of `nodes`: marches on more and more nodes until
        it is met, the last returned.  With 8000 the last in any case, "unresolved" then.
    length : float, optional
        Length of the contact that is observed [length]; what waves reach, c_l T (c_t T under
        antiplane shear alone), unless given.
    latest : float, optional
        Time to which `march_on` may be asked to go on [time]; end_time unless given.  The grid is
        made for it.
    companion : bool
        Whether a companion on half the nodes and in half the steps goes along, for the error
        estimate; it takes a quarter to a third more time from 1000 nodes on, half below.
    step_ratio : float
        Largest c_t dt / h; stable below about 0.57 (nu near 0.5) to 0.7 (nu = 1/3) and more.
    damping : float
        Least feedback of the shortest wave, 0 (none) ... 0.95.
    every : int
        Store every n-th time level; the last is always stored.  Raised if all that is stored does
        not fit into the memory: see `Marched.every`.
    tolerance : float
        Relative error of the memory's transform, above 1e-11 and up to 1e-2.
    memory : float, optional
        What the march may take [bytes]; 70 % of what the machine has available unless given.
    progress : callable, optional
        Called with (step, steps) after each step of a march, not of its companion; if it returns
        True the march ends there, and can go on with `march_on`.  With `rtol` each march counts
        its own steps.

    Raises
    ------
    SceneError
        If an option is out of range, both nodes and an rtol are given, the step is beyond the
        stable range, rate weakening is ill posed at a pressure that arises, the grid does not
        resolve the loads or sees nothing of slip weakening, or the march would take more memory
        than it may.
    TensionError
        If the pressure turns tensile at a node.
    ComputationError
        If the memory cannot be fitted or values are no longer finite.
    """
    material = checked_scene("march", scene).material
    end_time = 1 / material.shear_speed if end_time is None else end_time
    end_time = checked_size("march: end_time", end_time, "be above 0")
    length = scene.fastest_speed * end_time if length is None else length
    length = checked_size("march: length", length, "be above 0")
    latest = end_time if latest is None else latest
    latest = _check_range("latest", latest, math.nextafter(end_time, 0.0))
    step_ratio = _check_range("step_ratio", step_ratio, 0.0, LARGEST_STEP_RATIO)
    damping = checked_number(
        "march: damping",
        damping,
        "lie between 0 and 0.95",
        lambda given: 0 <= given <= LARGEST_FEEDBACK,
    )
    tolerance = _check_range("tolerance", tolerance, *TOLERANCES)
    if nodes is not None:
        nodes = _check_count("nodes", nodes, LEAST_NODES)
    every = _check_count("every", every, 1)
    if rtol is not None:
        rtol = _check_range("rtol", rtol, 0.0, 1.0)
        if nodes is not None:
            raise SceneError("march: `rtol` chooses the nodes; leave out `nodes`, or `rtol`.")
        if not companion:
            raise SceneError("march: `rtol` needs the companion; leave `companion` out.")
    plan = _Plan(
        scene, end_time, latest, length, step_ratio, damping, every, tolerance, rtol, companion
    )
    if rtol is None:
        return plan.run(plan.enough_nodes(nodes, NODES, memory), memory, progress)
    return plan.run_within(rtol, memory, progress)


def check_march(scene: Scene, end_time: float, nodes: int, length: float) -> None:
    """Raise what `march` would for the loads of a scene, before a step is taken.

    Parameters
    ----------
    scene : Scene
    end_time : float
        [time].
    nodes : int
    length : float
        [length].

    Raises
    ------
    SceneError
        If the grid sees nothing of slip weakening, or rate weakening is ill posed at a pressure
        that arises.
    TensionError
        If the pressure turns tensile at a node.
    """
    grid = causal_grid(scene, end_time, length, nodes)
    check_weakening_seen(scene, grid.spacing)
    segments = segments_between(scene, 0.0, end_time, STEP_RATIO, grid.spacing)
    finest = min(segment.time_step for segment in segments)
    pressure = GridPressure(scene, grid.size - grid.slot, grid.spacing, end_time, finest)
    check_levels(scene, segments, pressure)


@dataclass(frozen=True)
class _Plan:
    """A march but for its nodes: the options of `march`, checked."""

    scene: Scene
    end_time: float
    latest: float
    length: float
    step_ratio: float
    damping: float
    every: int
    tolerance: float
    rtol: float | None
    companion: bool

    def enough_nodes(self, nodes: int | None, least: int, memory: float | None) -> int:
        """The nodes asked for, or as many from `least` on as loads, edge and law call for.

        Raises
        ------
        SceneError
            If the loads need more.
        """
        check_size(self.scene, self.latest, self.length, nodes or least, memory, self.companion)
        most = nodes
        if nodes is None:
            zones = (
                nodes_for_zone(self.scene, self.end_time, self.length),
                nodes_for_weakening(self.scene, self.length),
            )
            nodes = max(least, *(needed for needed in zones if needed <= MOST_NODES), LEAST_NODES)
            most = MOST_NODES
        return check_loads(
            self.scene, self.latest, self.length, nodes, most or nodes, self.step_ratio
        )

    def run_within(
        self,
        rtol: float,
        memory: float | None,
        progress: Callable[[int, int], object] | None,
    ) -> Marched:
        """Marches on more and more nodes until the error estimate is `rtol`; the last of them."""
        nodes, order, coarser = self.enough_nodes(None, FIRST_NODES, memory), 1.0, None
        while True:
            marched = self.run(nodes, memory, progress)
            estimate = marched.error_estimate
            stopped = marched.end_time < self.end_time
            if stopped or nodes >= MOST_NODES or estimate <= rtol:
                return marched
            if coarser is not None and math.isfinite(coarser.error_estimate):
                ratio = math.log(nodes / coarser.grid.observed)
                order = math.log(coarser.error_estimate / estimate) / ratio
            growth = (GROWTH_MARGIN * estimate / rtol) ** (1 / np.clip(order, *ORDERS))
            growth = float(np.clip(growth, LEAST_GROWTH, LARGEST_GROWTH))
            nodes, coarser = min(MOST_NODES, math.ceil(growth * nodes)), marched

    def run(
        self,
        nodes: int,
        memory: float | None,
        progress: Callable[[int, int], object] | None,
    ) -> Marched:
        """The march on so many contact nodes."""
        started, material = time.perf_counter(), self.scene.material
        grid = causal_grid(self.scene, self.latest, self.length, nodes)
        check_size(self.scene, self.latest, self.length, nodes, memory, self.companion)
        check_weakening_seen(self.scene, grid.spacing)
        horizon = grid.wavenumbers[-1] * material.shear_speed * self.latest
        past = fit_memory(impedance_of(self.scene), horizon, self.tolerance)
        at_rest = self._at_rest(grid, past)
        if self.companion:
            coarse = math.ceil(nodes / 2)
            length = 2 * grid.spacing * coarse
            companion = self._at_rest(causal_grid(self.scene, self.latest, length, coarse), past)
            at_rest = replace(at_rest, companion=companion)
        at_rest = replace(at_rest, rtol=self.rtol)
        setup = time.perf_counter() - started
        return advance(at_rest, self.end_time, memory, setup, progress)

    def _at_rest(self, grid: Grid, past: Memory) -> Marched:
        """A march on a grid, before it begins."""
        no_times, no_levels = np.zeros(0), np.zeros((0, grid.observed))
        return Marched(
            scene=self.scene,
            interface=InterfaceHistory(grid.x, no_times, *[no_levels] * 5),
            totals=Totals(*[no_times] * 4),
            latest=self.latest,
            step_ratio=self.step_ratio,
            damping=self.damping,
            every=self.every,
            statistics=MarchStatistics(
                0, grid.size, len(past.poles), past.error, {"setup": 0.0, "steps": 0.0}
            ),
            grid=grid,
            memory=past,
            state=MarchState.at_rest(len(past.poles), grid),
            seen=Extremes.at_rest(grid.observed),
        )


def march_on(
    marched: Marched,
    end_time: float,
    progress: Callable[[int, int], object] | None = None,
    *,
    memory: float | None = None,
) -> Marched:
    """Continue a march to a later time, without recomputing anything; `memory` as in `march`.

    Raises
    ------
    SceneError
        If the end time is not later, or beyond the `latest` of the first run, or the march would
        take more memory than it may.
    TensionError, ComputationError
        As `march`.
    """
    end_time = _check_range("end_time", end_time, marched.end_time)
    if end_time > marched.latest:
        raise SceneError(
            f"march: this run can go on to {marched.latest:.6g}; for more, start again with a "
            "later `latest`."
        )
    return advance(marched, end_time, memory, 0.0, progress)


def _check_range(name: str, value: float, low: float, high: float = LARGEST) -> float:
    """A number low < value <= high as float; SceneError if it is not."""
    limit = f" and at most {high:g}" if high < LARGEST else ""
    return checked_number(
        f"march: {name}", value, f"be above {low:g}{limit}", lambda given: low < given <= high
    )


def _check_count(name: str, value: int, least: int) -> int:
    return checked_count(f"march: {name}", value, least, "a whole number from")
