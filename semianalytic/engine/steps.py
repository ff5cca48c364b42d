"""Steps of a run: the longest that friction and convergence allow, and the update of one step."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.contact import area_mean
from semianalytic.engine.fields import at_nodes, required, sampled
from semianalytic.engine.interface import Interface, ShearLoad
from semianalytic.engine.law import check_law
from semianalytic.engine.line import Grid, LineMemory
from semianalytic.engine.tuning import (
    BOUND_SHARE,
    CROSSINGS,
    LADDER,
    LARGEST_HORIZON,
    LEAST_HORIZON,
    RATE_SHARE,
    STATE_SHARE,
    SWEEPS,
    TOLERANCE,
)
from semianalytic.scene.errors import ComputationError
from semianalytic.spacetime.exponentials import Antiplane, InPlane, fit_memory

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class State:
    """The state of an interface at one time, from which the next step starts; arrays are (n,).

    Attributes
    ----------
    time : float
        Time [time].
    rate, slip, traction : array
        Slip rate [length / time], slip [length] and shear traction [stress].
    state : array
        State of friction at nodes of the contact, (contact,).
    work : array
        Work of friction so far [stress length].
    rung : int
        Rung of the ladder of the last step.
    pace : float
        Change of slip rate in the last step, over the largest rate and the step [1 / time].
    """

    time: float
    rate: Array
    slip: Array
    traction: Array
    state: Array
    work: Array
    rung: int = 0
    pace: float = 0.0


class Stepper:
    """An interface on a grid, and the time stepping of its fields.

    Parameters
    ----------
    interface : Interface
        The interface to compute.
    nodes : int
        Nodes of a period.
    step_ratio : float
        Shortest step c_t dt / h.
    sweeps, tolerance
        As in `tuning`.
    """

    def __init__(
        self,
        interface: Interface,
        nodes: int,
        step_ratio: float,
        *,
        end_time: float,
        sweeps: int = SWEEPS,
        tolerance: float = TOLERANCE,
        state_share: float = STATE_SHARE,
        bound_share: float = BOUND_SHARE,
        longest: float = math.inf,
    ) -> None:
        material, contact = interface.material, interface.contact
        held = 0.0 if interface.held == math.inf else 2 * math.pi / interface.held
        self.interface, self.sweeps = interface, sweeps
        self.grid = Grid(interface.length, nodes, not contact.is_whole, interface.even, held)
        x = self.grid.x
        self.touching = contact.touches(x)
        self._on = x[self.touching]
        self.law = interface.law.on(self._on)
        self._inner = self._neighbours()[self.touching]
        self.pressure = sampled("interface: pressure", interface.pressure, self._on)
        required(
            "interface: pressure", self.pressure, self.pressure >= 0, "not be negative", self._on
        )
        # a slot carries base shear before the load, as if it were closed
        self.shear = sampled("interface: shear", interface.shear, x)
        self._fixed = self._static_loads(x)
        speed = material.shear_speed
        self._speed, self.impedance = speed, interface.impedance
        self.shortest = step_ratio * self.grid.spacing / speed
        if interface.mode == "antiplane":
            impedance: Antiplane | InPlane = Antiplane()
        else:
            impedance = InPlane(speed / material.longitudinal_speed)
        q = math.pi / self.grid.spacing
        reach = q * min(speed * end_time, CROSSINGS * interface.length)
        horizon = min(max(reach, LEAST_HORIZON), LARGEST_HORIZON)
        # rounded up to a power of 2, so that runs of different lengths share a fit
        horizon = min(2.0 ** math.ceil(math.log2(horizon)), LARGEST_HORIZON)
        self.memory = LineMemory(fit_memory(impedance, horizon, tolerance), self.grid)
        self._bound = bound_share * 4 / (impedance.static * material.shear_modulus * q)
        self._state_share, self._longest = state_share, longest
        self._state_slip = np.asarray(self.law.state_slip(), dtype=float)

    def _neighbours(self) -> NDArray[np.bool_]:
        """Return which nodes have a neighbour of the contact on either side, (n,)."""
        left, right = np.roll(self.touching, 1), np.roll(self.touching, -1)
        if self.grid.even:
            # the neighbours of the first and the last node are mirror images of nodes
            left[0], right[-1] = self.touching[0], self.touching[-1]
        return np.asarray(self.touching & left & right)

    def _static_loads(self, x: Array) -> list[tuple[Array | None, ShearLoad]]:
        """Return the fields of loads that are products of space and time."""
        fixed: list[tuple[Array | None, ShearLoad]] = []
        for load in self.interface.loads:
            where = self.touching | True if load.on == "line" else ~self.touching
            field = None if load.history is None else at_nodes("load: shear", load.shear, x, where)
            fixed.append((field, load))
        return fixed

    def loads(self, time: float, after: bool = False) -> tuple[Array, Array]:
        """Return the shear that an uncut line carries, and that of slot faces, (n,) each.

        At a jump of a load these are the values before it, or those `after` it.
        """
        line, slot = self.shear.copy(), self.shear.copy()
        for field, load in self._fixed:
            if field is None:
                value = load.traction(self.grid.x, time)
            else:
                value = field * load.factor(time, after)
            if load.on == "line":
                line += value
            else:
                slot -= value
        return line, slot

    def begin(self) -> State:
        """Return the state at t = 0, just after loads that jump there."""
        count = len(self.grid.x)
        rate = np.zeros(count)
        rate[self.touching] = sampled("interface: rate", self.interface.rate, self._on)
        state = np.asarray(
            self.law.start(self.pressure, self.shear[self.touching], np.abs(rate[self.touching])),
            dtype=float,
        )
        check_law(self.law, self.pressure, state)
        nothing = np.zeros(count)
        return self.jump(State(0.0, rate, nothing, self.shear.copy(), state, nothing.copy()))

    def jump(self, now: State) -> State:
        """Return the state after loads have jumped, with the memory as it is."""
        table = self.memory.table(self.memory.last) if self.memory.last else None
        held = self.memory.modes.real.sum(axis=0) + self.memory.lasting
        if table is not None:
            held = held + table.feedback * self._amplitudes(now.rate)
        line, slot = self.loads(now.time, after=True)
        stopping = self._stopping(line, held)
        rate, traction = self._balance(stopping, slot, now.state)
        # The memory lacks the share of the newest rate, which the next step adds from `rate`; the
        # jump changes that rate, so the share that is missing has to change with it.
        if table is not None:
            change = self._amplitudes(rate - now.rate)
            self.memory.modes -= table.end * change
            self.memory.lasting -= table.half * change
        return replace(now, rate=rate, traction=traction)

    def length(self, now: State) -> tuple[float, int]:
        """Return length and rung of the step that may follow a state [time]."""
        speed = np.abs(now.rate[self.touching])
        slope = np.asarray(self.law.rate_slope(self.pressure, speed, now.state))
        least = float(slope.min()) if self.touching.all() else 0.0
        limit = min(self._bound * (max(least, 0.0) + self.impedance), self._longest)
        if now.pace > 0:
            limit = min(limit, RATE_SHARE / now.pace)
        with np.errstate(divide="ignore"):
            limit = min(limit, float(np.min(self._state_share * self._state_slip / speed)))
        rung = 0
        if limit > self.shortest:
            rung = min(int(math.log(limit / self.shortest) / math.log(LADDER)), now.rung + 1)
        return self.shortest * LADDER**rung, rung

    def step(self, now: State, length: float, rung: int, time: float | None = None) -> State:
        """Return the state one step later, and advance the memory to the same time.

        Parameters
        ----------
        now : State
            The state at the beginning of the step.
        length, rung
            Length [time] and rung of the step, as `length` returns them.
        time : float, optional
            Exact time of the end where a load jumps there [time].
        """
        time = now.time + length if time is None else time
        amplitudes = self._amplitudes(now.rate)
        past, feedback = self.memory.advance(amplitudes, self._speed * length)
        line, slot = self.loads(time)
        old = np.abs(now.rate[self.touching])
        rate = now.rate
        for _ in range(self.sweeps):
            stopping = self._stopping(line, past + feedback * amplitudes)
            mean = (old + np.abs(rate[self.touching])) / 2
            rate, traction = self._balance(
                stopping, slot, self.law.evolved(now.state, mean, length)
            )
            amplitudes = self._amplitudes(rate)
        if not math.isfinite(float(amplitudes.sum())):
            raise ComputationError(
                f"the run lost its finite values at t = {time:.4g}; lower `step_ratio`."
            )
        mean = (old + np.abs(rate[self.touching])) / 2
        state = self.law.evolved(now.state, mean, length)
        half = length / 2
        new, turned = rate[self.touching], np.abs(rate - now.rate)[self.touching]
        fastest = max(float(np.abs(new).max()), float(old.max()), 1e-300)
        return State(
            time,
            rate,
            now.slip + half * (now.rate + rate),
            traction,
            state,
            now.work + half * (now.traction * now.rate + traction * rate) * self.touching,
            rung,
            float(turned.max()) / fastest / length,
        )

    def _amplitudes(self, rate: Array) -> Array:
        return self.grid.amplitudes(rate - self.interface.plate_rate)

    def _stopping(self, line: Array, convolution: Array) -> Array:
        """Return the traction of nodes that do not move, given the convolution over the past."""
        plate = self.interface.plate_rate
        return line - self.impedance * (self.grid.values(convolution) - plate)

    def _balance(self, stopping: Array, slot: Array, state: Array) -> tuple[Array, Array]:
        """Return slip rate and traction at which friction, or the load on slots, is met."""
        on = stopping[self.touching]
        size = np.abs(on)
        if self.law.has_threshold:
            rest = self.law.strength(self.pressure, np.zeros(len(on)), state)
            size = rest + area_mean(size - rest, self._inner)
        speed = self.law.slip_speed(size, self.pressure, self.impedance, state)
        rate = (stopping - slot) / self.impedance
        # Slip has the sense of the traction it relaxes; 0.0 - speed keeps +0.0 where it sticks.
        rate[self.touching] = np.where(on < 0, 0.0 - speed, speed)
        return rate, stopping - self.impedance * rate
