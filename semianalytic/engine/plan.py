"""How a march beside a slot is laid out: its nodes, and its memory."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from semianalytic.engine.nodes import ContactGrid, Layout, causal_grid
from semianalytic.engine.resolution import (
    WEAKENING_NODES,
    ZONE_NODES,
    check_weakening_seen,
    nodes_for_loads,
    rounded_up,
    zone_at_edge,
)
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import impedance_of
from semianalytic.scene.checks import checked_size
from semianalytic.scene.contact import process_zone
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

LEAST_NODES = 16
MOST_NODES = 8000
"""Largest number of nodes that a march chooses by itself, some 20 seconds of work."""


def checked_entry(scene: Scene, latest: float, length: float, entry: float | None) -> float:
    """Return where a load that comes along the slot begins [length]; 0 for any other load.

    Raises
    ------
    SceneError
        If it is given for another load, or is not a positive number.
    """
    slowness = scene.front_slowness
    if slowness <= 0:
        if entry is not None:
            raise SceneError(
                "march: `entry` is for a load that comes along the slot, a wave at a positive "
                "angle or a moving load of negative speed; leave it out."
            )
        return 0.0
    if entry is not None:
        return checked_size("march: entry", entry, "be above 0")
    if scene.front_too_slow:
        return length
    # the first wave of the beginning reaches the tip at `latest`
    return latest / (1 / scene.fastest_speed - slowness)


def enough_nodes(
    scene: Scene,
    end_time: float,
    length: float,
    given: int | None,
    least: int,
    options: dict[str, Any],
) -> int:
    """Return the given nodes, or from `least` on as many as loads, edge and friction law need.

    The options are those of `laid_out`.

    Raises
    ------
    SceneError
        If the loads need more than are given, or more than `MOST_NODES`.
    """
    nodes, most = given, given or MOST_NODES
    if nodes is None:
        zone, weakening = zone_at_edge(scene, end_time), process_zone(scene)
        resolving = [math.ceil(WEAKENING_NODES * length / weakening)]
        resolving += [math.ceil(ZONE_NODES * length / zone)] if zone else []
        # A zone that even MOST_NODES do not resolve is marched on the usual number of nodes
        # and reported as "unresolved" (`Marched.caution`).
        nodes = max(least, LEAST_NODES, *(count for count in resolving if count <= MOST_NODES))
    # Nodes that were given are not raised silently.
    latest, ratio = options["latest"], options["step_ratio"]
    needed, name = nodes_for_loads(scene, latest, length, nodes, ratio)
    if needed > most:
        raise SceneError(
            f"march: the {name} history turns faster than {most} nodes on a length of "
            f"{length:.4g} follow; raise `nodes` to {rounded_up(needed)}, or shorten "
            f"`length` {needed / most:.2g} times (docs/limits.md)."
        )
    return needed


def laid_out(
    scene: Scene, nodes: int, length: float, tolerance: float, companion: bool, **options: Any
) -> list[tuple[ContactGrid, Layout]]:
    """Return nodes and layout of a march on a number of contact nodes, and of its companion.

    The options are latest, step_ratio, damping and entry.
    """
    check_weakening_seen(scene, length / nodes)
    latest, entry = options["latest"], options["entry"]
    grid = causal_grid(scene, latest, length, nodes, entry)
    # The largest argument q c_t t of h.  The companion has half the largest wavenumber, so the
    # same sum of exponentials serves both.
    passing = latest + max(scene.front_slowness, 0.0) * entry
    horizon = grid.line.wavenumbers[-1] * scene.material.shear_speed * passing
    kernel = fit_memory(impedance_of(scene), horizon, tolerance)
    begins = 0.0 - max(scene.front_slowness, 0.0) * entry
    layout = Layout(kernel, begins=begins, **options)
    # twice the spacing exactly, so that its nodes lie half-way between pairs of nodes
    coarse = math.ceil(nodes / 2)
    coarser = causal_grid(scene, latest, 2 * grid.spacing * coarse, coarse, entry)
    return [(grid, layout), (coarser, replace(layout, stride=2))][: 1 + companion]
