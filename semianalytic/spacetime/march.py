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

import numpy as np

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
from semianalytic.scene.checks import LARGEST, checked_count, checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.exponentials import fit_memory
from semianalytic.spacetime.march_memory import check_size
from semianalytic.spacetime.marched import Extremes, Grid, Marched, MarchState, MarchStatistics
from semianalytic.spacetime.resolution import check_loads, nodes_for_zone
from semianalytic.spacetime.stepping import advance
from semianalytic.spacetime.tuning import (
    LARGEST_FEEDBACK,
    LARGEST_STEP_RATIO,
    LEAST_NODES,
    MARGIN_NODES,
    MOST_NODES,
    NODES,
    TOLERANCES,
    WEAKENING_NODES,
)


def causal_grid(scene: Scene, latest: float, length: float, nodes: int) -> Grid:
    """The smallest grid whose mirrors are out of reach of 0 < x < length until `latest`."""
    from scipy.fft import next_fast_len

    spacing = length / nodes
    reach = scene.material.longitudinal_speed * latest
    contact = math.ceil(max(length, (reach + length) / 2) / spacing) + MARGIN_NODES
    slot = math.ceil(reach / 2 / spacing) + MARGIN_NODES
    size = next_fast_len(contact + slot, real=True)
    return Grid(spacing, size - contact, nodes, size)


def march(
    scene: Scene,
    end_time: float | None = None,
    nodes: int | None = None,
    *,
    length: float | None = None,
    latest: float | None = None,
    step_ratio: float = 0.5,
    damping: float = 0.7,
    every: int = 1,
    tolerance: float = 1e-6,
    memory: float | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Marched:
    """March the interface of a scene in time, under any load history and friction law.

    Memory is 80 bytes per pole (about 25) and grid node (about 1.5 per contact node), and 32
    bytes per stored node and level (see `GridPressure` for pressure that oscillates); time grows
    like nodes^2.

    Parameters
    ----------
    scene : Scene
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    nodes : int, optional
        Contact nodes on 0 < x < length, at least 16.  1000 unless given, or up to 8000 where that
        lets the grid follow the loads, or resolve the slip zone at the edge.
    length : float, optional
        Length of the contact that is observed [length]; c_l T unless given.
    latest : float, optional
        Time to which `march_on` may be asked to go on [time]; end_time unless given.  The grid is
        made for it.
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
        Called with (step, steps) after each step; if it returns True the march ends there, and
        can go on with `march_on`.

    Raises
    ------
    SceneError
        If an option is out of range, the step is beyond the stable range, rate weakening is ill
        posed at a pressure that arises, the grid does not resolve the loads or slip weakening, or
        the march would take more memory than it may.
    TensionError
        If the pressure turns tensile at a node.
    ComputationError
        If the memory cannot be fitted or values are no longer finite.
    """
    material = scene.material
    end_time = 1 / material.shear_speed if end_time is None else end_time
    end_time = checked_size("march: end_time", end_time, "be above 0")
    length = material.longitudinal_speed * end_time if length is None else length
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
    started = time.perf_counter()
    check_size(scene, latest, length, nodes or NODES, memory)
    nodes = _enough_nodes(scene, end_time, latest, length, nodes, step_ratio)
    grid = causal_grid(scene, latest, length, nodes)
    check_size(scene, latest, length, nodes, memory)
    _check_resolved(scene, grid.spacing)
    horizon = grid.wavenumbers[-1] * material.shear_speed * latest
    past = fit_memory(material.shear_speed / material.longitudinal_speed, horizon, tolerance)
    no_times, no_levels = np.zeros(0), np.zeros((0, grid.observed))
    at_rest = Marched(
        scene=scene,
        interface=InterfaceHistory(grid.x, no_times, *[no_levels] * 4),
        totals=Totals(*[no_times] * 4),
        latest=latest,
        step_ratio=step_ratio,
        damping=damping,
        every=every,
        statistics=MarchStatistics(
            0, grid.size, len(past.poles), past.error, {"setup": 0.0, "steps": 0.0}
        ),
        grid=grid,
        memory=past,
        state=MarchState.at_rest(len(past.poles), grid),
        seen=Extremes.at_rest(grid.observed),
    )
    return advance(at_rest, end_time, memory, time.perf_counter() - started, progress)


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


def _enough_nodes(
    scene: Scene,
    end_time: float,
    latest: float,
    length: float,
    nodes: int | None,
    step_ratio: float,
) -> int:
    """The nodes asked for, or as many as loads and edge call for.

    Raises
    ------
    SceneError
        If the loads need more.
    """
    if nodes is not None:
        return check_loads(scene, latest, length, nodes, nodes, step_ratio)
    zone = nodes_for_zone(scene, end_time, length)
    least = max(NODES, zone if zone <= MOST_NODES else 0)
    return check_loads(scene, latest, length, least, MOST_NODES, step_ratio)


def _check_resolved(scene: Scene, spacing: float) -> None:
    """Raise if slip weakening is so sharp that the grid, not the law, would set its length."""
    material = scene.material
    fall = scene.friction * scene.base.pressure * scene.friction_law.fall_with_slip
    if not fall:
        return
    zone = material.shear_modulus / ((1 - material.poisson_ratio) * fall)
    if zone < WEAKENING_NODES * spacing:
        raise SceneError(
            f"march: friction weakens within about {zone:.3g} of length, which nodes {spacing:.3g} "
            f"apart do not resolve; raise `nodes` {WEAKENING_NODES * spacing / zone:.2g} times "
            "(docs/limits.md)."
        )


def _check_range(name: str, value: float, low: float, high: float = LARGEST) -> float:
    """A number low < value <= high as float; SceneError if it is not."""
    limit = f" and at most {high:g}" if high < LARGEST else ""
    return checked_number(
        f"march: {name}", value, f"be above {low:g}{limit}", lambda given: low < given <= high
    )


def _check_count(name: str, value: int, least: int) -> int:
    return checked_count(f"march: {name}", value, least, "a whole number from")
