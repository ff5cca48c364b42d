"""Steps of a run: the longest that friction and convergence allow, and the update of one step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.kernels import pair_of
from semianalytic.engine.stepping.acting import ActingLoads, check_even, check_touching
from semianalytic.engine.stepping.advance import Span
from semianalytic.engine.stepping.balance import Balance, freed_rate
from semianalytic.engine.stepping.blocks import ClosedLine, Level
from semianalytic.engine.stepping.fronts import acting_loads
from semianalytic.engine.stepping.ladder import Ladder
from semianalytic.engine.stepping.line import grid_of, memories
from semianalytic.engine.stepping.means import check_feedback
from semianalytic.engine.stepping.pace import LoadPace, in_fours
from semianalytic.engine.stepping.state import State
from semianalytic.engine.stepping.tuning import BOUND_SHARE
from semianalytic.engine.stepping.unilateral import Faces, Parting, Unilateral
from semianalytic.engine.stepping.window import check_window
from semianalytic.memory.line_memory import LineMemory
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import LARGEST_COUNT
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.laws.law import check_law, check_rate
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.line.contact import Adhesion
from semianalytic.scene.line.fields import required
from semianalytic.scene.scene import Scene


class Stepper(ClosedLine):
    """An interface on a grid, and the time stepping of its fields.

    Fields that are `steady` do not change; the last step of a march `is_cut` at its end.

    Parameters
    ----------
    scene : Scene
        The interface to compute.
    nodes : int
        Nodes of a period.
    step_ratio : float
        Shortest step c_t dt / h.
    sweeps, tolerance
        As in `tuning`.
    shift : float, optional
        Distance by which the grid is moved [length]; what suits the ends of contacts by default.
    """

    is_cut, layout = True, None
    fields = "slip", "slip_rate", "shear_traction", "state", "pressure", "felt_pressure", "gap"

    def __init__(
        self,
        scene: Scene,
        nodes: int,
        step_ratio: float,
        *,
        end_time: float,
        sweeps: int = 2,  # an even number: a free face grows without bounds with 1 or 3
        # With 1e-5 the slip rate of TPV101 changes by 2e-4, with 1e-9 by 5e-7.
        tolerance: float = 1e-7,
        state_share: float = 0.25,  # largest slip of a step over that in which the state changes
        bound_share: float = BOUND_SHARE,
        longest: float = math.inf,
        shift: float | None = None,
    ) -> None:
        material, contact = scene.material, scene.contact
        held = 0.0 if scene.held == math.inf else 2 * math.pi / scene.held
        self.settings = {
            "step_ratio": step_ratio,
            "sweeps": sweeps,
            "tolerance": tolerance,
            "state_share": state_share,
            "bound_share": bound_share,
            "longest": longest,
        }
        self.scene, self.sweeps, self.plate_rate = scene, sweeps, scene.plate_rate
        self.jumps = scene.jumps
        self.grid = grid_of(scene, nodes, shift, held)
        x = self.grid.x
        self.touching = contact.touches(x)
        check_touching(scene, self.touching)
        self._on = x[self.touching]
        spacing = self.grid.spacing
        self.law = scene.law.on(self._on, spacing)
        self.pressure = sampled("scene: pressure", scene.base.pressure, self._on, spacing)
        required("scene: pressure", self.pressure, self.pressure >= 0, "not be negative", self._on)
        # a slot carries base shear before the load, as if it were closed
        self.shear = sampled("scene: shear", scene.base.shear, x, spacing)
        self.pair, self.impedance = pair_of(scene), scene.impedance
        stiff = material.density * material.longitudinal_speed / 2  # pressure per rate of the gap
        if self.pair is not None:
            self.impedance, stiff = self.pair.impedances
        self.speed = material.shear_speed if self.pair is None else self.pair.speed
        fastest = material.shear_speed if self.pair is None else self.pair.fastest
        self.shortest = step_ratio * self.grid.spacing / fastest
        loads = self.acting = acting_loads(scene)
        if scene.even:
            check_even(scene, loads, self.grid, end_time)
        self.loads = ActingLoads("shear", self.shear, loads, x, self.touching, self.shortest)
        self.balance = Balance(self.law, self.impedance, self.touching, self.grid)
        self.memory, opening, stiffness = memories(scene, self.grid, end_time, tolerance)
        check_feedback(self.memory.table(self.shortest * self.speed).feedback[0])
        self.unilateral = None
        if opening is not None:
            base, step = self._base(), self.shortest
            pressed = ActingLoads("pressure", base, loads, x, self.touching, step)
            bonds = scene.adhesion and scene.adhesion.on(x, self.touching)
            self.unilateral = Unilateral(stiff, opening, self.grid, pressed, self.touching, bonds)
            if bonds is not None:
                longest = min(longest, self._check_adhesion(bonds, stiff))
        self._has_slots = not self.touching.all()
        # the stiffness of the mean slip may be that of a shorter wave than the grid has
        q = max(math.pi / spacing, held)
        self.ladder = Ladder(
            self.law,
            self.touching,
            LoadPace(scene, x, end_time),
            self.unilateral,
            impedance=self.impedance,
            shortest=self.shortest,
            longest=longest,
            bound=bound_share * 2 / (stiffness * q),
            state_share=state_share,
        )
        self._is_delayed = bool(np.any(self.law.pressure_delay(np.zeros(len(self._on)))))
        self._latest: tuple[Array | None, Array] = None, np.zeros(0)
        self.nodes, self.climbs = self.grid, self.ladder.climbs
        self.steady: dict[str, Array] = {}
        if self.unilateral is None:  # slip does not change the pressure
            base = self._base()
            self.steady = {"pressure": base, "gap": np.zeros(len(x))}
            if not self._is_delayed:
                self.steady["felt_pressure"] = base

    def _check_adhesion(self, bonds: Adhesion, stiff: float) -> float:
        """Return the longest step [time] in which adhesion may fall, or raise SceneError."""
        soft = float(np.max(bonds.strength / bonds.length))
        # the tension must fall by less than an opening rate takes off the pressure
        longest = stiff / (2 * soft) if soft else math.inf
        if self.shortest > longest:
            nodes = in_fours(self.grid.nodes * self.shortest / longest)
            raise SceneError(
                f"scene: adhesion falls within a gap that this grid cannot follow; take {nodes}"
                " nodes or more, or a larger length."
            )
        return longest

    def _base(self) -> Array:
        """Return the pressure in place before loads, (n,), 0 on slots."""
        base = np.zeros(len(self.grid.x))
        base[self.touching] = self.pressure
        return base

    def spans(self, time: float, end_time: float) -> list[Span]:
        """Return the spans between jumps of the loads from a level on until an end time."""
        begin = max((at for at in self.jumps if at <= time), default=0.0)
        if (end_time - begin) / self.shortest > LARGEST_COUNT:
            raise SceneError(
                f"march: end_time = {end_time:g} is more than {LARGEST_COUNT:g} steps of "
                f"{self.shortest:.3g} away; end earlier."
            )
        stops = [at for at in self.jumps if time < at < end_time] + [end_time]
        return [Span(*span, self.shortest) for span in pairwise([max(begin, 0.0), *stops])]

    def check_sliding(self) -> None:
        """Raise SceneError if friction between different bodies lets waves grow without bounds."""
        if self.pair is not None:
            rate = np.abs(sampled("scene: rate", self.scene.rate, self._on))
            check_window(self.pair, self.law, self.pressure, rate, self.grid.spacing)

    def begin(self) -> State:
        """Return the state at t = 0, before loads that jump there."""
        count = len(self.grid.x)
        rate = np.zeros(count)
        rate[self.touching] = sampled("scene: rate", self.scene.rate, self._on)
        against = rate[self.touching] * self.shear[self.touching] < 0
        words = "have the sense of `shear`, for friction opposes slip"
        required("scene: rate", rate[self.touching], ~against, words, self._on)
        state = np.asarray(
            self.law.start(self.pressure, self.shear[self.touching], np.abs(rate[self.touching])),
            dtype=float,
        )
        check_law(self.law, self.pressure, state)
        check_rate(self.law, self.pressure, state, self.impedance)
        nothing = np.zeros(count)
        faces = Faces(self._base(), nothing, nothing, nothing, nothing)
        return State(
            **vars(faces),
            time=0.0,
            rate=rate,
            slip=nothing,
            traction=self.shear.copy(),
            state=state,
            felt=self.pressure,
            work=np.zeros(len(self._on)),
        )

    def jump(self, now: State) -> State:
        """Return the state after loads have jumped, with the memory as it is."""
        faces: Faces = now
        held = self.memory.convolution(self._amplitudes(now.rate))
        line, slot = self.loads(now.time, after=True)
        if self.pair is not None and self.unilateral is not None:
            line = line + self._drag(self.unilateral.held(now))
            faces = self.unilateral.jump(now, now.time, self._push(held))
        elif self.unilateral is not None:
            faces = self.unilateral.jump(now, now.time)
        stopping = self._stopping(line, held[0])
        felt = now.felt if self._is_delayed else self._pressure(faces)
        rate, traction = self.balance(stopping, slot, now.state, felt, self._open(faces))
        self.memory.exchange(self._amplitudes(rate - now.rate))
        return replace(now, **vars(faces) | {"rate": rate, "traction": traction, "felt": felt})

    def levels(self, ends: list[float], steps: list[float]) -> Iterator[Level]:
        """Yield the ends of steps (`ClosedLine.levels`)."""
        for end, step, loads in zip(ends, steps, self.loads.over(ends), strict=True):
            yield Level(end, step, *loads, self.pressure)

    def after(self, time: float, step: float) -> Level:
        """Return a level just after loads have jumped (`ClosedLine.after`)."""
        line, slot = self.loads(time, after=True)
        return Level(time, step, line, slot[~self.touching], self.pressure)

    def length(self, now: State) -> tuple[float, int]:
        """Return length and rung of the step that may follow a state [time]."""

        def push() -> Array | float:
            if self.pair is None:
                return 0.0
            return self._push(self.memory.convolution(self._amplitudes(now.rate)))

        return self.ladder.following(now, push)

    def advance(self, now: State, stop: float) -> State:
        """Return the state one step later, but no later than a time to stop at.

        A step that is so long that its iteration did not converge at the speeds with which it ends
        is repeated with half its length: friction that rises with the logarithm of the slip rate
        damps short waves the less, the faster the interface slips.  So is one in which slip begins:
        it may have begun at any time of the step.
        """
        length, rung = self.length(now)
        while True:
            left = stop - now.time
            # A step that almost reaches the stop is stretched to it, so that no sliver is left.
            last = left <= length * (1 + 1e-9)
            kept = [memory.past() for memory in self.every_memory()] if rung > 0 else []
            after = self.step(now, left if last else length, rung, stop if last else None)
            begins = after.rate[self.touching].any() and not now.rate[self.touching].any()
            if not kept or (not begins and length <= self.ladder.convergent(after) / BOUND_SHARE):
                return after
            for memory, past in zip(self.every_memory(), kept, strict=True):
                memory.put_back(past)
            rung -= 1
            length = self.ladder.length(rung)

    def every_memory(self) -> list[LineMemory]:
        """Return the memory of slip, and that of opening where the interface may open."""
        opening = [] if self.unilateral is None else [self.unilateral.memory]
        return [self.memory, *opening]

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
        path = self.speed * length
        faces: Faces = now
        parting = None
        if self.unilateral is not None:
            parting = Parting(self.unilateral, now, time, length, path)
        if parting is not None and self.pair is None:  # slip does not change the pressure
            for _ in range(self.sweeps):
                parting.sweep()
            faces, parting = parting.faces, None
        amplitudes = self._amplitudes(now.rate)
        past = self.memory.advance(amplitudes, path)
        feedback = self.memory.feedback
        line, slot = self.loads(time)
        # in the shortest steps iterating over the slots converges as well, and costs less
        solved = rung > 0 and self._has_slots and self.unilateral is None
        old = np.abs(now.rate[self.touching])
        rate = now.rate
        for _ in range(self.sweeps):
            held, dragged = past + feedback[:, None] * amplitudes, line
            if parting is not None:
                parting.sweep(self._push(held))
                faces, dragged = parting.faces, line + self._drag(parting.convolutions)
            stopping = self._stopping(dragged, held[0])
            mean = (old + np.abs(rate[self.touching])) / 2
            state, felt = self._evolved(now, mean, length, faces)
            rate, traction = self.balance(stopping, slot, state, felt, self._open(faces))
            if solved:
                plate, load = self.plate_rate, (line - slot) / self.impedance
                moved = rate - plate
                own = past[0], feedback[0]
                rate = plate + freed_rate(self.grid, self.touching, moved, load, *own)
            amplitudes = self._amplitudes(rate)
        if not math.isfinite(float(amplitudes.sum())):
            raise ComputationError(
                f"the run has values that are not finite at t = {time:.4g}; lower `step_ratio`."
            )
        mean = (old + np.abs(rate[self.touching])) / 2
        state, felt = self._evolved(now, mean, length, faces)
        half = length / 2
        new, turned = rate[self.touching], np.abs(rate - now.rate)[self.touching]
        fastest = max(float(np.abs(new).max()), float(old.max()), 1e-300)
        power = (now.traction * now.rate + traction * rate)[self.touching]
        after = {
            "time": time,
            "rate": rate,
            "slip": now.slip + half * (now.rate + rate),
            "traction": traction,
            "state": state,
            "felt": felt,
            "work": now.work + half * power,
            "rung": rung,
            "pace": float(turned.max()) / fastest / length,
        }
        return State(**vars(faces) | after)

    def _push(self, convolutions: Array) -> Array:
        """Return the pressure (n,) that slip of different bodies exerts."""
        assert self.pair is not None
        return self.impedance * self.grid.values(self.pair.turned(convolutions[1]))

    def _drag(self, convolutions: Array) -> Array:
        """Return the shear traction (n,) that opening between different bodies exerts."""
        assert self.pair is not None
        assert self.unilateral is not None
        turned = self.pair.turned(convolutions[1])
        return self.unilateral.impedance * self.grid.values(turned)

    def _evolved(
        self, now: State, speed: Array, length: float, faces: Faces
    ) -> tuple[Array, Array]:
        """Return the state of friction, and the pressure it follows, after a step (contact,) each.

        The speed is the mean one of the step.
        """
        before, after = self._pressure(now), self._pressure(faces)
        state = self.law.evolved_under(now.state, speed, length, before, after)
        if not self._is_delayed:
            return state, after
        return state, self.law.felt_pressure(now.felt, speed, length, before, after)

    def _open(self, faces: Faces) -> NDArray[np.bool_] | None:
        """Return where nodes are open, (n,); None if nothing ever opens."""
        return None if self.unilateral is None else faces.is_open

    def _pressure(self, faces: Faces) -> Array:
        """Return the pressure of the contact, (contact,); tension counts as none."""
        if self.unilateral is None:
            return self.pressure
        return np.maximum(faces.pressure[self.touching], 0.0)

    def _amplitudes(self, rate: Array) -> Array:
        """Return the amplitudes of a slip rate (rows, m), which must not be changed."""
        # a step begins with the slip rate with which the one before has ended
        if self._latest[0] is not rate:
            self._latest = rate, self.grid.amplitudes(rate - self.plate_rate)
        return self._latest[1]

    def _stopping(self, line: Array, convolution: Array) -> Array:
        """Return the traction of nodes that do not move, given the convolution over the past."""
        return line - self.impedance * (self.grid.values(convolution) - self.plate_rate)
