"""Simulation of a periodic interface with explicit finite elements, and what it records."""

from __future__ import annotations

import logging
import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.elements.assembly import X, Y, Z
from fem.interface import ContactFace, FaceMotion, FacePair, Joint, KickTractions
from fem.lines.blocks import LineBlock, check_work, make_blocks
from fem.lines.gauges import GaugeHistory, Gauges
from fem.lines.line import Line, Tractions
from fem.march import March, SidePush, face_pair, half_window
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.checks import checked_count, checked_size

Progress = Callable[[int, int], None]

SAMPLES = 20
"""Times at which fields are kept."""
DAMPING = 0.02
"""Damping of each block, as that of `fem.settings.Settings`."""
SPECIMEN_FORMAT = "slipfront specimen 1"
STEP_RATIO = 0.95
"""Time step over the critical one."""


@dataclass(frozen=True, eq=False)
class LineSimulation:
    """Fields of a simulated interface at evenly spaced times.

    Slip rates and tractions are means over the time in which a shear wave of the slower body
    crosses `fem.march.RATE_WINDOW` squares, which removes the ringing of the mesh.

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
    gauges : GaugeHistory or None
        Motion at points of the blocks of a specimen.
    """

    x: Array
    touching: Mask
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
    gauges: GaugeHistory | None = None

    @property
    def nodes(self) -> int:
        """Number of nodes along the interface."""
        return len(self.x)


class LineTractions:
    """The tractions of each kick on a line; `shear` and `pressure` are the last ones on slots."""

    def __init__(self, line: Line, step: float) -> None:
        self.line, self.step = line, step
        self.shear, self.pressure = (of(0.0)[0][line.slots] for of in (line.shear, line.pressure))

    def __call__(self, level: int) -> KickTractions:
        """Return the tractions of a kick."""
        line, time = self.line, level * self.step
        on, slots = line.touching, line.slots
        shear, slot_shear = kick_tractions(line.shear, time)
        self.shear, along = slot_shear[slots], (shear - slot_shear)[slots]
        if not line.opens:
            return KickTractions(0.0, shear[on], along, 0.0)
        pressure, slot_pressure = kick_tractions(line.pressure, time)
        self.pressure = slot_pressure[slots]
        return KickTractions(pressure[on], shear[on], along, self.pressure - pressure[slots])


def build_line(line: Line, blocks: list[LineBlock], step: float, end_time: float) -> March:
    """Return the bodies and the joint of a line at rest, for a time step [time]."""
    bodies = [block.assembled(step, end_time) for block in blocks]

    def motion(lengths: Array) -> FaceMotion:
        """Return the motion of the nodes that have some length."""
        nodes, firsts = np.flatnonzero(lengths), [block.first for block in blocks]
        of = partial(face_pair, bodies, nodes, lengths[nodes], step, firsts=firsts)
        return FaceMotion(of(Z if line.antiplane else X), of(Y) if line.opens else None)

    contact, slot = map(motion, line.lengths)
    tractions, pressure = LineTractions(line, step), line.pressure(0.0)[0][line.touching]
    joint = Joint(line.friction, line.state, contact, slot, tractions, pressure, line.plate_rate)
    pushes = []
    for block, body in zip(blocks, bodies, strict=True):
        if block.load is not None and (pushed := np.flatnonzero(block.load)).size:
            face = ContactFace.of(body, pushed)
            pushes.append(SidePush(face, block.load[pushed], block.history, step))
    copies = 2 if line.is_odd else 1
    return March(bodies=bodies, joint=joint, time_step=step, copies=copies, pushes=pushes)


def kick_tractions(tractions: Tractions, time: float) -> tuple[Array, Array]:
    """Return the tractions of a kick; one at a jump has the mean of the values on both sides.

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
    progress: Progress | None = None,
) -> LineSimulation:
    """Simulate a periodic interface with finite elements and central differences.

    Contact and friction are satisfied at every pair of nodes and every step, without a penalty.
    The blocks are so deep that nothing comes back from their far sides, or absorb what comes there
    where one is far stiffer than the other.  Each block has its own damping.

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
    blocks = make_blocks(line, end_time, damping)
    return marched(line, blocks, end_time, samples, STEP_RATIO, progress)


def marched(
    line: Line,
    blocks: list[LineBlock],
    end_time: float,
    samples: int,
    step_ratio: float,
    progress: Progress | None,
    gauges: Gauges | None = None,
) -> LineSimulation:
    """March blocks until T [time] and return what is recorded; raises as `simulate_line`."""
    samples = checked_count("simulate: samples", samples, 1, "a whole number of at least")
    started = clock.perf_counter()
    steps = count_steps(blocks, end_time, samples, step_ratio)
    step = end_time / steps
    check_work(blocks, steps)
    slowest = min(block.material.shear_speed for block in blocks)
    window = half_window(line.spacing, slowest, step)
    march = build_line(line, blocks, step, end_time)
    record = _LineRecord(march, line, steps // samples * np.arange(1, samples + 1), window)
    with np.errstate(over="ignore", invalid="ignore"), deferred_interrupt() as interruption:
        for level in range(steps + window + 1):
            march.kick(level)
            record.level(level)
            if gauges is not None:
                gauges.level(march)
            march.drift()
            if interruption.pressed:
                raise KeyboardInterrupt
            if progress is not None and level:
                progress(min(level, steps), steps)
    seconds = clock.perf_counter() - started
    work = line.spacing, march.unknowns, steps, seconds
    logging.getLogger(__name__).info("squares of side %.6g, %d unknowns, %d steps in %.3g s", *work)
    return LineSimulation(
        x=line.x,
        touching=line.touching,
        t=sample_times(end_time, samples),
        **record.fields(),
        imbalance=imbalance(march),
        steps=steps,
        unknowns=march.unknowns,
        seconds=seconds,
        gauges=None if gauges is None else gauges.history(step, steps),
    )


def sample_times(end_time: float, samples: int = SAMPLES) -> Array:
    """Return the times at which fields are kept, (samples,) [time]; the last one is the end."""
    # the share of the end is exactly 1, so that no rounding leads beyond it
    return np.asarray(end_time * (np.arange(1, samples + 1) / samples))


def count_steps(blocks: list[LineBlock], end_time: float, samples: int, step_ratio: float) -> int:
    """Return the number of steps until the end time, a multiple of the number of samples."""
    critical = min(block.critical_step for block in blocks)
    return samples * math.ceil(end_time / (samples * step_ratio * critical))


def planned_work(line: Line, end_time: float) -> float:
    """Return the unknowns times steps of `simulate_line` with its defaults, before it is run."""
    blocks = make_blocks(line, end_time, DAMPING)
    steps = count_steps(blocks, end_time, SAMPLES, STEP_RATIO)
    return float(steps) * sum(block.unknowns for block in blocks)


def imbalance(march: March) -> float:
    """Return the energy and the work that is taken, less that of tractions, over the larger one."""
    kinetic, strain, friction, damping, external, impact = march.energies().tolist()
    taken = kinetic + strain + friction + damping + impact
    size = max(abs(taken), abs(external))
    return (taken - external) / size if size else 0.0


def _offset(faces: FacePair | None) -> float | Array:
    """Return the relative displacement of faces, (n,) [length]; 0 where symmetry forbids it."""
    return 0.0 if faces is None else faces.offset()


class _LineRecord:
    """Fields at some levels; slip rates and tractions are means over a window around each."""

    def __init__(self, march: March, line: Line, levels: NDArray[np.int64], window: int) -> None:
        self.march, self.line, self.levels, self.window = march, line, levels, window
        count = (len(levels), len(line.x))
        self._slip, self._gap = np.zeros(count), np.zeros(count)
        self._ends, self._window = np.zeros((count[0], 2, count[1])), np.zeros((count[0], 2))
        self._means = {name: np.zeros(count) for name in ("shear_traction", "pressure", "strength")}

    def level(self, level: int) -> None:
        """Record a level whose kick is done."""
        near = np.flatnonzero(np.abs(self.levels - level) <= self.window).tolist()
        if not near:
            return
        joint, step, slot = self.march.joint, self.march.time_step, self.march.joint.slot
        tractions: Any = joint.tractions
        slip = self._whole(_offset(joint.sliding), _offset(slot.sliding))
        slip += joint.plate_rate * level * step
        now = (
            self._whole(joint.shear, tractions.shear),
            self._whole(joint.pressure, tractions.pressure),
            self._whole(joint.strength, 0.0),
        )
        for number in near:
            at = self.levels[number]
            first, last = max(at - self.window, 0), at + self.window
            for end, limit in enumerate((first, last)):
                if level == limit:
                    self._ends[number, end] = slip
                    self._window[number, end] = level * step
            if level == at:
                self._slip[number] = slip
                self._gap[number] = self._whole(_offset(joint.pressing), _offset(slot.pressing))
            for mean, values in zip(self._means.values(), now, strict=True):
                mean[number] += values / (last - first + 1)

    def _whole(self, contact: float | Array, slots: float | Array) -> Array:
        """Return values at all nodes (n,), from those on the contact and on slots."""
        values = np.empty(len(self.line.x))
        values[self.line.slots] = slots
        values[self.line.touching] = contact
        return values

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
