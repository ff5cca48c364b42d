"""Loads at the nodes of a grid: pressure under any history, and fronts that move over the nodes.

Slip between identical bodies does not change the pressure, so it is that of the stuck interface,
(3.10) and (3.20).  Under a load that comes everywhere at once it is evaluated (`GridPressure`),
under a front that moves it is marched (`FrontPressure`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from semianalytic.engine.nodes import ContactGrid, SlotLayout
from semianalytic.engine.stepping.advance import Span, through
from semianalytic.engine.stepping.blocks import ClosedLine, EqualSteps, Level, Reached
from semianalytic.engine.stepping.fronts import ActingFront
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.primitives import stuck_primitive
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import Opening
from semianalytic.memory.line_memory import LineMemory
from semianalytic.scene.arrays import Array
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.line.loads import Part
from semianalytic.scene.loads import Pieces
from semianalytic.scene.scene import Scene

TOLERANCES = (1e-11, 1e-2)
"""Range of the memory's tolerance: 1e-11 takes 45 poles; 1e-2 is coarser than the grid."""
EXACT_KINKS = 4
"""Kinks treated exactly: 4 take 2.6 s, 8 take 6.4 s (1,500 nodes), a table of any number 3 s."""
TABLE_SAMPLES = 2
"""Samples of the table per time step, so that a kink is spread over half a step."""
TABLE_ROWS = 64
"""Nodes whose responses are convolved at once, to stay in the cache."""


def table_bytes(scene: Scene, count: int, steps: float) -> float:
    """Return the size of the table of `GridPressure` for `count` nodes and time steps [bytes]."""
    return TABLE_SAMPLES * steps * count * 8 if _needs_table(scene) else 0.0  # bytes of a number


def _needs_table(scene: Scene) -> bool:
    """Return whether the pressure history has waves, or too many kinks to treat each exactly."""
    pieces = scene.pressure_history.pieces
    load = scene.superposition.taken_off
    return bool(load.pressure and (pieces.waves or len(pieces.kinks) > EXACT_KINKS))


class GridPressure:
    """The contact pressure at grid nodes, seen as the grid sees its own edge (`edge_factors`).

    Jumps of the history are treated exactly, with p*, and so are kinks if they are few, with the
    primitive of p* in slowness.  Waves and the kinks of tables are replaced by functions that are
    linear between half time steps: waves by their interpolant, each kink by two neighbouring ones
    of the same sum and first moment.  Their kinks are convolved with the primitive by FFT; the
    table takes 16 bytes per node and step.

    Parameters
    ----------
    scene : Scene
        Material, pressure history and tractions.
    count : int
        Contact nodes, the first half a node distance from the edge.
    spacing : float
        Node distance [length].
    end_time, time_step : float
        Last time and resolution of the table of waves [time].
    """

    def __init__(
        self, scene: Scene, count: int, spacing: float, end_time: float, time_step: float
    ) -> None:
        offset, factors = edge_offset_and_factors()
        self.spacing = spacing
        held, self._load = (part.pressure for part in scene.superposition)
        # a wave of normal incidence that is no step: the contact carries base and f times its load
        self._arriving = scene.arrives and not scene.is_step
        held = scene.before_load.pressure if self._arriving else held
        self._history = scene.pressure_history
        self._factor = np.ones(count)
        self._factor[: len(factors)] = factors[:count]
        # The grid sees the inverse square root as if its first node were 0.310 h from the edge,
        # and has to take the pressure in the same way.
        self._x = (np.arange(count) + offset) * spacing
        self._arrival = self._x / scene.material.longitudinal_speed
        self._per = self._x / scene.material.shear_speed
        self._pieces = self._history.pieces if self._load else Pieces()
        nu = scene.material.poisson_ratio
        self._stuck, self._primitive = stuck_traction(nu, "I"), stuck_primitive(nu, "I")
        self._held = np.full(count, held)
        self._table = np.zeros((0, count))
        self._kinks = self._pieces.kinks
        if _needs_table(scene):
            self._kinks = self._kinks if len(self._kinks) <= EXACT_KINKS else ()
            self._rows = TABLE_SAMPLES * int(np.ceil(end_time / time_step))
            self._interval = end_time / self._rows
            self._table = self._response_table(count)

    def after(self, time: float) -> Array:
        """Return the pressure at a time (n,), after a jump there [stress]."""
        (pressure,) = self._block(np.array([time]))
        if not self._arriving:
            return pressure
        return pressure + self._load * float(self._history.value(math.nextafter(time, math.inf)))

    def over(self, ends: Array, steps: Sequence[float]) -> Iterator[Array]:
        """Yield the pressure at the ends of steps, (n,) each [stress], before a jump there."""
        rows = max(1, (1 << 16) // len(self._x))  # pressures that stay in the cache
        arrived = self._load * self._history.value(ends)
        for first in range(0, len(ends), rows):
            part = slice(first, first + rows)
            for pressure, more in zip(self._block(ends[part]), arrived[part], strict=True):
                yield pressure + more if self._arriving else pressure

    def _block(self, times: Array) -> Iterator[Array]:
        """Yield the pressure at a few times, for which it is computed at once."""
        if self._load == 0:
            yield from (self._held for _ in times)
            return
        response = np.zeros((len(times), len(self._x)))
        self._add(response, times, self._pieces.jumps, lambda u, per: self._stuck(u))
        self._add(response, times, self._kinks, lambda u, per: per * self._primitive(u))
        if len(self._table):
            at = times / self._interval
            low = np.minimum(at.astype(int), self._rows - 1)
            step = self._table[low + 1] - self._table[low]
            response += self._table[low] + (at - low)[:, None] * step
        # Singular at the edge is the response together with the load: that sum vanishes on the
        # slot faces.  Only it is multiplied by the factors of the grid's first nodes.
        load = self._history.value(times)[:, None]
        yield from self._held + self._load * ((response + load) * self._factor - load)

    def _add(
        self,
        response: Array,
        times: Array,
        pieces: tuple[tuple[float, float], ...],
        unit: Callable[[Array, Array], Array],
    ) -> None:
        """Add to (m, n) responses those to jumps or kinks, of which `unit` is one of height 1."""
        for start, amplitude in pieces:
            lag = times - start
            reached = lag[:, None] > self._arrival
            if reached.any():
                per = np.broadcast_to(self._per, reached.shape)[reached]
                u = np.broadcast_to(lag[:, None], reached.shape)[reached] / per
                response[reached] += amplitude * unit(u, per)

    def _response_table(self, count: int) -> Array:
        """Return the response to waves and many kinks at even times, (rows + 1, n)."""
        from scipy.fft import irfft, next_fast_len, rfft

        t: Array = self._interval * np.arange(self._rows + 1, dtype=float)
        kinks = self._grid_kinks(t)
        size = next_fast_len(2 * len(t), real=True)
        transform = rfft(kinks, size)
        table = np.empty((len(t), count))
        for first in range(0, count, TABLE_ROWS):
            per = self._per[first : first + TABLE_ROWS, None]
            ramps = np.zeros((len(per), len(t)))
            reached = t > self._arrival[first : first + TABLE_ROWS, None]
            # a ramp of slope 1 from t = 0 on: x / c_t times the primitive of p* at u = c_t t / x
            u = (t / per)[reached]
            ramps[reached] = np.broadcast_to(per, reached.shape)[reached] * self._primitive(u)
            full = irfft(transform * rfft(ramps, size, axis=1), size, axis=1)
            table[:, first : first + TABLE_ROWS] = full[:, : len(t)].T
        return table

    def _grid_kinks(self, t: Array) -> Array:
        """Return the changes of slope at the table's times that stand for waves and kinks.

        The shape is (rows + 1,).
        """
        samples = np.sum([wave.value(t) for wave in self._pieces.waves], axis=0) + 0 * t
        kinks = np.diff(samples, prepend=0.0, append=samples[-1])[1:] / self._interval
        kinks[1:] -= kinks[:-1].copy()  # slopes to changes of slope
        if not self._kinks:
            at, slope = np.array(self._pieces.kinks).reshape(-1, 2).T
            at, slope = at[at < t[-1]] / self._interval, slope[at < t[-1]]
            low = np.minimum(at.astype(int), self._rows - 1)
            # a kink between two times is shared between them: same sum, same first moment
            np.add.at(kinks, low, slope * (low + 1 - at))
            np.add.at(kinks, low + 1, slope * (at - low))
        return kinks


Front = Callable[[Part, float, float], tuple[Any, Any]]
"""The traction of the uncut interface, and that which slot faces keep, under a front that moves.

Both are asked for by name, time and step [time], and given at all nodes (size,) and at those of the
slot (slot,) [stress], or as numbers.
"""


def front_of(scene: Scene, grid: ContactGrid, entry: float) -> Front:
    """Return the load of a scene whose front moves over the nodes, from where it begins on.

    Each node receives the whole of the load, whatever the step (`ActingFront`).  A load that comes
    along the slot begins at the distance `entry` from the tip [length].
    """
    assert isinstance(scene.load, IncidentWave | MovingLoad)
    x, loaded = grid.nodes, np.ones(grid.size)
    if scene.front_slowness > 0:
        # the part of the cell of each node that the load reaches
        loaded = np.clip((x + entry) / grid.spacing + 0.5, 0.0, 1.0)
    fronts = {
        name: ActingFront(scene.load, history, material=scene.material)
        for name, history in scene.acting_histories.items()
    }

    def tractions(name: Part, t: float, step: float) -> tuple[Any, Any]:
        base = getattr(scene.before_load, name)
        if name not in fronts:
            return base, base
        load = loaded * fronts[name].traction(x, t, of=name, spread=(grid.spacing, step))
        return (base + load, base) if scene.arrives else (base, base - load[: grid.slot])

    return tractions


class FreeFaces(ClosedLine):
    """A line next to a slot, whose faces are free, and whose contact moves as is known.

    It is its own law and local problem.  The grid sees the edge as it sees that of a march.

    Parameters
    ----------
    scene : Scene
        What is marched.
    nodes : ContactGrid
        Nodes, also those of a longer slot than that of the march.
    layout : SlotLayout
        Memory and damping.
    name : {"pressure", "shear"}
        The quantity of the load: rates are those at which the slot closes, or slips.
    front : Front, optional
        The load at the nodes, if its front moves.
    given : function of times (k,) and whether they are just after jumps, optional
        Rates of the contact, (k, contact) [length / time]; by default it stays closed.
    """

    follows_state = False

    def __init__(
        self,
        scene: Scene,
        nodes: ContactGrid,
        layout: SlotLayout,
        name: Part,
        front: Front | None,
        given: Callable[[Array, bool], Array] | None = None,
    ) -> None:
        solid, kernel = scene.material, layout.kernel
        self.grid, self.kept, self.damping = nodes.line, nodes.contact, layout.damping
        self.speed, self.impedance = solid.shear_speed, solid.shear_impedance / 2
        self.jumps: Sequence[float] = ()
        if name == "pressure":
            self.impedance = solid.density * solid.longitudinal_speed / 2
            opening = Opening(solid.shear_speed / solid.longitudinal_speed)
            # as accurate as the memory of shear
            tolerance = min(max(kernel.error, 2 * TOLERANCES[0]), TOLERANCES[1])
            kernel = fit_memory(opening, kernel.horizon, tolerance)
        self.memory = LineMemory(kernel, self.grid.wavenumbers)
        self.law: Any = self
        self.balance: Any = self
        self.on, self._slot, self._front, self._name = nodes.contact, nodes.slot, front, name
        self._load = getattr(scene.superposition.taken_off, name)
        self._history = getattr(scene, f"{name}_history")
        self._given = given or (lambda times, _: np.zeros((len(times), nodes.size - nodes.slot)))

    def levels(self, ends: list[float], steps: list[float]) -> Iterator[Level]:
        """Yield the ends of steps (`ClosedLine.levels`), with known rates as pressures."""
        for end, step, rates in zip(ends, steps, self._given(np.array(ends), False), strict=True):
            yield self._level(end, step, end, rates)

    def after(self, time: float, step: float) -> Level:
        """Return a level just after loads have jumped (`ClosedLine.after`)."""
        rates = self._given(np.array([time]), True)[0]
        return self._level(time, step, math.nextafter(time, math.inf), rates)

    def _level(self, time: float, step: float, since: float, rates: Array) -> Level:
        """Return a level under the load of a time."""
        if self._front is not None:
            return Level(time, step, *self._front(self._name, time, step), rates)
        return Level(time, step, self._load * float(self._history.value(since)), 0.0, rates)

    def closed(
        self, stopping: Array, slot: Any, _: Array, rates: Array, out: Array, *__: Any
    ) -> None:
        """Write the rates of all nodes (`Balance.closed`)."""
        out[self.on] = rates
        out[: self._slot] = (stopping[: self._slot] - slot) / self.impedance

    def strength(self, *_: Array) -> float:
        """Return that what is known does no work."""
        return 0.0

    def turn(self, *_: Array) -> None:
        """Do nothing at a new level."""

    forget = recall = turn


class FrontPressure(FreeFaces):
    """The contact pressure at grid nodes under a front that moves, marched as shear is.

    Parameters
    ----------
    scene, nodes, layout
        As of `FreeFaces`.
    front : Front
        The load at the nodes.
    step : float
        Largest time step before the time [time] from which pressures are asked for, `since`.
    """

    def __init__(
        self,
        scene: Scene,
        nodes: ContactGrid,
        layout: SlotLayout,
        front: Front,
        step: float,
        since: float,
    ) -> None:
        super().__init__(scene, nodes, layout, "pressure", front)
        none = np.zeros(nodes.size - nodes.slot)
        begun = Reached(layout.begins, np.zeros(nodes.size), none, none, none, none)
        self._blocks = EqualSteps(self, begun)
        self._blocks.jump(self.after(layout.begins, step))
        if since > layout.begins:
            until = [Span(layout.begins, since, step)]
            for _ in through(self, self._blocks, until, lambda time: False):
                pass

    def now(self) -> Array:
        """Return the pressure at the time reached, (contact,) [stress]."""
        return self._blocks.reached.traction

    def over(self, ends: Array, steps: Sequence[float]) -> Iterator[Array]:
        """Yield the pressure at the ends of steps, which go on from those before."""
        levels = self.levels(ends.tolist(), list(steps))
        while self._blocks.time < ends[-1]:
            self._blocks.advance(levels, lambda time: False)
            yield from self._blocks.levels[1][1:].copy()
