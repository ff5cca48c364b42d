"""Simulation of a periodic interface with explicit finite elements, and what it records."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.elements.assembly import X, Y, Z
from fem.interface import ContactFace, FacePair, contact_pressure
from fem.lines.blocks import Block, check_work, make_blocks
from fem.lines.line import Line, Tractions
from fem.model import RATE_WINDOW
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.checks import checked_count, checked_size
from semianalytic.scene.errors import ComputationError

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

SAMPLES = 20
"""Times at which fields are kept."""
DAMPING = 0.02
"""Damping of each block, as that of `fem.settings.Settings`."""
STEP_RATIO = 0.95
"""Time step over the critical one."""


@dataclass(frozen=True, eq=False)
class LineSimulation:
    """Fields of a simulated interface at evenly spaced times.

    Slip rates and tractions are means over the time in which a shear wave of the slower body
    crosses `fem.model.RATE_WINDOW` squares, which removes the ringing of the mesh.

    Attributes
    ----------
    x : (n,) array
        Positions of nodes [length].
    touching : (n,) array of bool
        Whether the bodies touch there.
    t : (m,) array
        Times [time]; the last one is the end.
    slip, slip_rate, shear_traction, pressure, gap : (m, n) arrays
        Relative slip and gap [length], slip rate [length / time] and tractions [stress].
    strength : (m, n) array
        Shear traction that friction bears at most, a mean like the tractions [stress]; 0 on slots.
    window : (m, 2) array
        Beginning and end of the time over which means are taken [time].
    window_slip : (m, 2, n) array
        Slip at these times [length].
    imbalance : float
        Energy of the bodies and what far sides absorb, less the work of all tractions, over it.
    steps, unknowns : int
    seconds : float
        Wall-clock time [s].
    """

    x: Array
    touching: NDArray[np.bool_]
    t: Array
    slip: Array
    slip_rate: Array
    shear_traction: Array
    pressure: Array
    gap: Array
    strength: Array
    window: Array
    window_slip: Array
    imbalance: float
    steps: int
    unknowns: int
    seconds: float

    @property
    def nodes(self) -> int:
        """Number of nodes along the interface."""
        return len(self.x)


class LineModel:
    """The bodies of a line, its faces, and the state of its friction, at a time level."""

    def __init__(self, line: Line, blocks: list[Block], step: float) -> None:
        self.line, self.blocks, self.step = line, blocks, step
        self.bodies = [block.assembled(step) for block in blocks]
        self.absorbers = [
            block.absorption(body.root, step)
            for block, body in zip(blocks, self.bodies, strict=True)
        ]
        self.sliding = self._pair(Z if line.antiplane else X)
        self.pressing = self._pair(Y) if line.opens else None
        self.state = line.state
        (self.pressure, _), (self.shear, _) = line.pressure(0.0), line.shear(0.0)
        self.strength = np.zeros(len(line.x))
        self.felt = self.pressure[line.touching]
        self.pushed = self.absorbed = self.imbalance = 0.0

    def _pair(self, component: int) -> FacePair:
        faces = []
        for block, body in zip(self.blocks, self.bodies, strict=True):
            count = len(block.components)
            unknowns = slice(block.components.index(component), count * block.columns, count)
            faces.append(
                ContactFace(body, unknowns, body.root[unknowns], -1.0 if block.below else 1.0)
            )
        return FacePair(faces, self.line.spacing, self.step)

    def kick(self, level: int, part: float) -> None:
        """Kick the bodies at a time level by internal forces, far sides and the interface."""
        for block, body in zip(self.blocks, self.bodies, strict=True):
            body.activate(block.reached((level + 1) * self.step))
            body.kick(part)
        self._settle()
        for body, z in zip(self.bodies, self.absorbers, strict=True):
            far = slice(len(body.root) - len(z), None)
            before = body.before[far]
            body.increment[far] = (body.increment[far] - z * before) / (1 + z)
            mean = (before + body.increment[far]) / 2
            self.absorbed += 2 * float(z @ mean**2) * self.copies
        self._press(level, part)
        self._slide(level, part)

    @property
    def copies(self) -> int:
        """Number of blocks that a body stands for."""
        return 2 if self.line.is_odd else 1

    def drift(self, part: float) -> None:
        """Move the bodies on to the next time level."""
        for body in self.bodies:
            body.drift(part)

    def _settle(self) -> None:
        energies = [body.energy for body in self.bodies]
        energy = self.copies * sum(one.kinetic + one.strain + one.damping for one in energies)
        if not math.isfinite(energy):
            raise ComputationError(
                "the simulation lost its finite values; lower `step_ratio`, or give loads and "
                "moduli of ordinary size."
            )
        size = max(abs(self.pushed), abs(energy))
        self.imbalance = (energy + self.absorbed - self.pushed) / size if size else 0.0

    def _press(self, level: int, part: float) -> None:
        if self.pressing is None:
            return
        line, slot = kick_tractions(self.line.pressure, level * self.step)
        faces, on = self.pressing, self.line.touching
        compliance = part * faces.compliance
        needed = contact_pressure(faces.offset(), faces.increment(), line, compliance)
        before, self.pressure = self.pressure, np.where(on, needed, slot)
        self._past = before
        self._push(faces, self.pressure - line, part)

    def _slide(self, level: int, part: float) -> None:
        line, slot = kick_tractions(self.line.shear, level * self.step)
        faces, on, friction = self.sliding, self.line.touching, self.line.friction
        plate = self.line.plate_rate
        pressure = self.pressure[on]
        if level:
            speed = np.abs(faces.past_increment()[on] / self.step + plate)
            past = pressure if self.pressing is None else self._past[on]
            changing = speed, self.step, past, pressure
            self.state = np.asarray(friction.evolved_under(self.state, *changing))
            self.felt = friction.felt_pressure(self.felt, *changing)
        compliance = part * faces.compliance
        stopping = (line + (faces.increment() + plate * self.step) / compliance)[on]
        impedance = (self.step / compliance)[on]
        touches, size = pressure > 0, np.abs(stopping)
        felt = np.where(touches, self.felt, 1.0)  # nothing rubs an open pair, whatever its law
        speed = friction.slip_speed(size, felt, impedance, self.state)
        speed = np.where(touches, speed, size / impedance)
        self.shear = slot.copy()
        self.shear[on] = stopping - np.sign(stopping) * impedance * speed
        self.strength[on] = touches * friction.strength(self.felt, speed, self.state)
        # sigma_xy pulls the upper body, whose outward normal is -y, by -sigma_xy
        self._push(faces, line - self.shear, part)

    def _push(self, faces: FacePair, traction: Array, part: float) -> None:
        impulse = faces.push(traction, part)
        self.pushed += float(impulse @ faces.mean_increment())

    def slip(self, level: int) -> Array:
        """Return the slip at a level, (n,) [length]."""
        return self.sliding.offset() + self.line.plate_rate * level * self.step

    def gap(self) -> Array:
        """Return the gap, (n,) [length]."""
        return 0 * self.shear if self.pressing is None else self.pressing.offset()


def kick_tractions(tractions: Tractions, time: float) -> tuple[Array, Array]:
    """Return the tractions of a kick; one at a jump has the mean of the values beside it.

    The kick at t = 0 stands for the time after it.
    """
    after = tractions(time, after=True)
    if time == 0:
        return after
    before = tractions(time)
    return (before[0] + after[0]) / 2, (before[1] + after[1]) / 2


def simulate_line(
    line: Line,
    end_time: float,
    *,
    samples: int = SAMPLES,
    damping: float = DAMPING,
    step_ratio: float = STEP_RATIO,
    progress: Progress | None = None,
) -> LineSimulation:
    """Simulate a periodic interface with finite elements and central differences.

    Contact and friction hold exactly at every pair of nodes and every step, without a penalty
    (docs/fem.md).  The blocks are so deep that nothing comes back from their far sides, or absorb
    what comes there where one is far stiffer than the other.  Each block has its own damping.

    Parameters
    ----------
    line : Line
    end_time : float
        T [time].
    samples : int
        Number of times, up to T, at which fields are kept.
    damping : float
        eta of the Kelvin-Voigt damping, over the time in which the shear wave of a block crosses a
        square.
    step_ratio : float
        Time step over the critical one.
    progress : callable, optional
        Called with (step, steps).

    Returns
    -------
    LineSimulation

    Raises
    ------
    SceneError
        If an option is out of range, or the simulation would take hours.
    ComputationError
        If values are no longer finite.
    KeyboardInterrupt
        On Ctrl-C.

    Examples
    --------
    A patch that is suddenly over-stressed, without friction: plane waves in its middle.

    >>> import numpy as np
    >>> from fem.lines import Line, simulate_line
    >>> from semianalytic import Coulomb, Material
    >>> solid, x = Material(1.0, 1.0, 0.25), np.arange(-32, 32) / 16
    >>> shear, still = 1.0 * (abs(x) < 1), np.zeros(64)
    >>> line = Line(solid, solid, 4.0, x, np.full(64, True), Coulomb(0.0), still,
    ...             shear=lambda t, after=False: (shear, still),
    ...             pressure=lambda t, after=False: (1 + still, still))
    >>> done = simulate_line(line, 0.4)
    >>> round(float(done.slip[-1, 32]), 2)  # 2 c_t tau t / mu
    0.8
    """
    end_time = checked_size("simulate: end_time", end_time)
    samples = checked_count("simulate: samples", samples, 1, "a whole number of at least")
    started = clock.perf_counter()
    blocks = make_blocks(line, end_time, damping)
    steps = count_steps(blocks, end_time, samples, step_ratio)
    step = end_time / steps
    check_work(blocks, steps)
    slowest = min(block.material.shear_speed for block in blocks)
    window = max(1, round(RATE_WINDOW / 2 * line.spacing / slowest / step))
    model = LineModel(line, blocks, step)
    record = _Record(model, [steps // samples * k for k in range(1, samples + 1)], window)
    with np.errstate(over="ignore", invalid="ignore"), deferred_interrupt() as interruption:
        for level in range(steps + window + 1):
            part = 1.0 if level else 0.5
            model.kick(level, part)
            record.level(level)
            model.drift(part)
            if interruption.pressed:
                raise KeyboardInterrupt
            if progress is not None and level:
                progress(min(level, steps), steps)
    return LineSimulation(
        x=line.x,
        touching=line.touching,
        t=sample_times(end_time, samples),
        **record.fields(),
        imbalance=model.imbalance,
        steps=steps,
        unknowns=sum(block.unknowns for block in blocks),
        seconds=clock.perf_counter() - started,
    )


def sample_times(end_time: float, samples: int = SAMPLES) -> Array:
    """Return the times at which fields are kept, (samples,) [time]; the last one is the end."""
    # the share of the end is exactly 1, so that no rounding leads beyond it
    return np.asarray(end_time * (np.arange(1, samples + 1) / samples))


def count_steps(blocks: list[Block], end_time: float, samples: int, step_ratio: float) -> int:
    """Return the number of steps until the end time, a multiple of the number of samples."""
    critical = min(block.critical_step for block in blocks)
    return samples * math.ceil(end_time / (samples * step_ratio * critical))


def planned_work(line: Line, end_time: float) -> float:
    """Return the unknowns times steps of `simulate_line` with its defaults, before it is run."""
    blocks = make_blocks(line, end_time, DAMPING)
    steps = count_steps(blocks, end_time, SAMPLES, STEP_RATIO)
    return float(steps) * sum(block.unknowns for block in blocks)


class _Record:
    """Fields at some levels; slip rates and tractions are means over a window around each."""

    def __init__(self, model: LineModel, levels: list[int], window: int) -> None:
        self.model, self.levels, self.window = model, levels, window
        count = (len(levels), len(model.line.x))
        self._slip, self._gap = np.zeros(count), np.zeros(count)
        self._ends, self._window = np.zeros((count[0], 2, count[1])), np.zeros((count[0], 2))
        self._means = {name: np.zeros(count) for name in ("shear_traction", "pressure", "strength")}

    def level(self, level: int) -> None:
        """Record a level whose kick is done."""
        for number, at in enumerate(self.levels):
            first, last = max(at - self.window, 0), at + self.window
            if not first <= level <= last:
                continue
            slip = self.model.slip(level)
            for end, limit in enumerate((first, last)):
                if level == limit:
                    self._ends[number, end] = slip
                    self._window[number, end] = level * self.model.step
            if level == at:
                self._slip[number], self._gap[number] = slip, self.model.gap()
            now = (self.model.shear, self.model.pressure, self.model.strength)
            for mean, values in zip(self._means.values(), now, strict=True):
                mean[number] += values / (last - first + 1)

    def fields(self) -> dict[str, Array]:
        """The fields of a `LineSimulation`."""
        gained, times = np.diff(self._ends, axis=1)[:, 0], np.diff(self._window)
        return {
            "slip": self._slip,
            "slip_rate": gained / times,
            "gap": self._gap,
            "window": self._window,
            "window_slip": self._ends,
            **self._means,
        }
