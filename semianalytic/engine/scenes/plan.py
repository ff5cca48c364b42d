"""How a march is set up: its nodes, those that an error asks for, and its state at rest."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.engine.convergence import Tried, more_nodes, order_seen
from semianalytic.engine.resolution import (
    WEAKENING_NODES,
    ZONE_NODES,
    check_weakening_seen,
    nodes_for_loads,
    rounded_up,
    zone_at_edge,
)
from semianalytic.engine.scenes.advancing import advance
from semianalytic.engine.scenes.marched import Extremes, Marched, MarchStatistics
from semianalytic.engine.scenes.nodes import ContactGrid, causal_grid, check_size
from semianalytic.engine.stepping.blocks import Reached
from semianalytic.memory.exponentials import Memory, fit_memory
from semianalytic.memory.impedance import impedance_of
from semianalytic.memory.line_memory import Past
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
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


@dataclass(frozen=True)
class MarchPlan:
    """The checked options of `march`, all but the number of nodes."""

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
    entry: float

    def enough_nodes(self, nodes: int | None, least: int, memory: float | None) -> int:
        """Return the given nodes, or from `least` on as many as loads, edge and friction law need.

        Raises
        ------
        SceneError
            If the loads need more than are given, or more than `MOST_NODES`.
        """
        self._check_size(nodes or least, memory)
        scene, most = self.scene, nodes or MOST_NODES
        if nodes is None:
            zone, weakening = zone_at_edge(scene, self.end_time), process_zone(scene)
            resolving = [math.ceil(WEAKENING_NODES * self.length / weakening)]
            resolving += [math.ceil(ZONE_NODES * self.length / zone)] if zone else []
            # A zone that even MOST_NODES do not resolve is marched on the usual number of nodes
            # and reported as "unresolved" (`Marched.caution`).
            nodes = max(least, LEAST_NODES, *(one for one in resolving if one <= MOST_NODES))
        # Nodes that were given are not raised silently.
        needed, name = nodes_for_loads(scene, self.latest, self.length, nodes, self.step_ratio)
        if needed > most:
            raise SceneError(
                f"march: the {name} history turns faster than {most} nodes on a length of "
                f"{self.length:.4g} follow; raise `nodes` to {rounded_up(needed)}, or shorten "
                f"`length` {needed / most:.2g} times (docs/limits.md)."
            )
        return needed

    def run_within(
        self,
        rtol: float,
        memory: float | None,
        progress: Callable[[int, int], object] | None,
    ) -> Marched:
        """March on more and more nodes until the error estimate is at most `rtol`; return the last.

        See docs/spacetime.md, "Error of a march".
        """
        # The first march takes 0.05 s (`preloaded`, 0.6 % off).
        nodes, coarser = self.enough_nodes(None, 250, memory), None
        while True:
            marched = self.run(nodes, memory, progress)
            stopped = marched.end_time < self.end_time
            tried = Tried(nodes, marched.departure.share)
            if coarser is not None and not stopped:
                marched = replace(marched, order=order_seen(coarser, tried))
            estimate = marched.error_estimate
            if stopped or nodes >= MOST_NODES or estimate <= rtol:
                return marched
            nodes = more_nodes(nodes, estimate, rtol, marched.order, MOST_NODES)
            coarser = tried

    def run(
        self,
        nodes: int,
        memory: float | None,
        progress: Callable[[int, int], object] | None,
    ) -> Marched:
        """March on a given number of contact nodes."""
        started = time.perf_counter()
        self._check_size(nodes, memory)
        check_weakening_seen(self.scene, self.length / nodes)
        at_rest = replace(self.at_rest(nodes), rtol=self.rtol)
        setup = time.perf_counter() - started
        return advance(at_rest, self.end_time, memory, setup, progress)

    def _check_size(self, nodes: int, memory: float | None) -> None:
        """Raise SceneError if the march does not fit into the memory."""
        reach = self.scene, self.latest, self.length
        check_size(*reach, nodes, memory, self.companion, self.entry)

    def at_rest(self, nodes: int) -> Marched:
        """Return the march on a number of contact nodes before its first step."""
        grid = causal_grid(self.scene, self.latest, self.length, nodes, self.entry)
        # The largest argument q c_t t of h.  The companion has half the largest wavenumber, so the
        # same sum of exponentials serves both.
        passing = self.latest + max(self.scene.front_slowness, 0.0) * self.entry
        horizon = grid.line.wavenumbers[-1] * self.scene.material.shear_speed * passing
        past = fit_memory(impedance_of(self.scene), horizon, self.tolerance)
        marched = self._on(grid, past)
        if not self.companion:
            return marched
        # twice the spacing exactly, so that its nodes lie half-way between pairs of nodes
        coarse = math.ceil(nodes / 2)
        length = 2 * grid.spacing * coarse
        coarser = causal_grid(self.scene, self.latest, length, coarse, self.entry)
        return replace(marched, companion=self._on(coarser, past))

    def _on(self, grid: ContactGrid, past: Memory) -> Marched:
        """Return a march on a grid before its first step, without a companion."""
        poles, no_times, rest = len(past.poles), np.zeros(0), np.zeros(grid.size - grid.slot)
        still = np.zeros(grid.observed)
        marched = Marched(
            scene=self.scene,
            interface=InterfaceHistory(grid.x, no_times, *[np.zeros((0, grid.observed))] * 5),
            totals=Totals(*[no_times] * 4),
            latest=self.latest,
            step_ratio=self.step_ratio,
            damping=self.damping,
            every=self.every,
            statistics=MarchStatistics(0, grid.size, poles, past.error, {"setup": 0, "steps": 0}),
            grid=grid,
            memory=past,
            reached=Reached(0.0, np.zeros(grid.size), rest, rest, rest, rest),
            past=Past(np.zeros((1, poles, grid.size), complex), np.zeros((1, grid.size))),
            seen=Extremes(still, still, np.full(grid.observed, np.inf)),
            entry=self.entry,
        )
        return replace(marched, reached=replace(marched.reached, time=marched.begins))
