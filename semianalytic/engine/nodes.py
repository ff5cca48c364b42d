"""What a march goes on from, and the nodes next to a slot, whose ends send no wave back."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from semianalytic.engine.convergence import Departure
from semianalytic.engine.resolution import check_weakening_seen
from semianalytic.engine.stepping import line as stepping_line
from semianalytic.engine.stepping.state import Extremes, State
from semianalytic.memory.exponentials import Memory, fit_memory
from semianalytic.memory.impedance import impedance_of
from semianalytic.memory.line_memory import Past
from semianalytic.results.memory import check_memory
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene


@dataclass(frozen=True)
class ContactGrid:
    """The nodes x = (i + 1/2) h of a march: `slot` of them on x < 0, the others on the contact.

    Attributes
    ----------
    spacing : float
        Node distance h [length].
    slot, observed, size : int
        Numbers of nodes on the slot, on the observed part of the contact, and in all.
    """

    spacing: float
    slot: int
    observed: int
    size: int

    @property
    def x(self) -> Array:
        """Positions of the observed nodes of the contact (observed,) [length]."""
        return np.asarray((np.arange(self.observed) + 0.5) * self.spacing)

    @property
    def weights(self) -> Array:
        """Length of the contact for which each observed node stands, (observed,) [length]."""
        return np.full(self.observed, self.spacing)

    @property
    def contact(self) -> slice:
        """The slice of all nodes that lie on the contact."""
        return slice(self.slot, self.size)

    @property
    def shown(self) -> slice:
        """The slice of all nodes that are observed."""
        return slice(self.slot, self.slot + self.observed)

    @property
    def nodes(self) -> Array:
        """Positions of all nodes, slot included, (size,) [length]."""
        return np.asarray((np.arange(self.size) - self.slot + 0.5) * self.spacing)

    @property
    def line(self) -> stepping_line.Grid:
        """All nodes as half of a line that is even about both of its ends."""
        return stepping_line.Grid(2 * self.size * self.spacing, 2 * self.size, True, True)


@dataclass(frozen=True)
class SlotLayout:
    """How a march next to a slot is laid out in time, which a continuation keeps.

    Attributes
    ----------
    kernel : Memory
        Kernel of the memory.
    latest : float
        Time to which the march can go on [time].
    step_ratio, damping : float
        Options of the march.
    entry, begins : float
        Distance from the tip at which a load that comes along the slot begins [length], else 0, and
        the time of that [time].
    stride : int
        Steps of the march in one step: 2 of a companion.
    """

    kernel: Memory
    latest: float
    step_ratio: float
    damping: float
    entry: float
    begins: float
    stride: int = 1


@dataclass(frozen=True, eq=False)
class MarchCheckpoint:
    """Everything from which a march goes on, and what it was asked for.

    Attributes
    ----------
    grid : Grid or ContactGrid
        Nodes of a line, or those beside a slot.
    state : State
        Where it goes on from: its end, or the state before a last step that was cut to end there.
    end : State
        The state at its end.
    past, opening : Past
        Memories of slip, and of opening where the interface may open, at the time of `state`.
    every, count : int
        Steps per stored level, and steps until the time of `state`.
    seen : Extremes
        Extremes until then.
    latest : float
        Time up to which the march may go on [time].
    layout : SlotLayout or None
        How a march next to a slot is laid out; None along a line.
    settings : dict
        Those of the `Stepper` of a line.
    rtol, order : float or None
        The error that was asked for, and the order of convergence that was seen between this march
        and a coarser one.
    departure : Departure
        Difference from the companion beside a slot.
    seconds : dict
        Seconds by stage: "setup" and "steps".
    """

    grid: stepping_line.Grid | ContactGrid
    state: State
    end: State
    past: Past
    opening: Past | None
    every: int
    count: int
    seen: Extremes
    latest: float
    layout: SlotLayout | None = None
    settings: dict[str, float] = field(default_factory=dict)
    rtol: float | None = None
    order: float | None = None
    departure: Departure = field(default_factory=Departure)
    seconds: dict[str, float] = field(default_factory=dict)


def extents(scene: Scene, latest: float, length: float, entry: float) -> tuple[float, float]:
    """Return the lengths of contact and slot that mirrors at their ends need [length].

    Until the time `latest` no wave from there reaches the observed contact of a `length`.  A load
    that comes along the slot begins at the distance `entry` from the tip [length], else 0.
    """
    speed, slowness = scene.fastest_speed, scene.front_slowness
    begins = -max(slowness, 0.0) * entry
    # waves leave the tip when the first of them, or the front itself, has come there
    reach = speed * (latest - min(0.0, begins + entry / speed))
    # A wave from x = 0 that is mirrored at x = L travels L + (L - length) to the observed contact;
    # one that is mirrored at x = -L travels 2 L back to x = 0, one from x = -entry as much less.
    slot = max(reach / 2, (speed * (latest - begins) + entry) / 2 if entry else 0.0, entry)
    contact = max(length, (reach + length) / 2)
    # A front that outruns the waves meets its mirror image at an end, whose waves come back.
    if slowness < 0:
        slot = max(slot, latest / (1 / speed - slowness))
    elif slowness > 0 and scene.arrives and (scene.far_slip_rate or not scene.is_step):
        contact = max(contact, (latest + length / speed) / (1 / speed + slowness))
    return contact, slot


def causal_grid(
    scene: Scene, latest: float, length: float, nodes: int, entry: float = 0.0
) -> ContactGrid:
    """Return the smallest grid whose mirror images do not reach 0 < x < length until `latest`.

    So many `nodes` lie on that length; `extents` has the other arguments.
    """
    from scipy.fft import next_fast_len

    spacing = length / nodes
    # Without any, 6e-4 of the slip rate comes back from the mirrors (`remote-shock`); from two on
    # nothing.
    contact, slot = (
        math.ceil(part / spacing) + 8 for part in extents(scene, latest, length, entry)
    )
    # the nodes that are added for the fast transform lengthen the slot
    size = next_fast_len(contact + slot, real=True)
    return ContactGrid(spacing, size - contact, nodes, size)


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


def laid_out(
    scene: Scene, nodes: int, length: float, tolerance: float, companion: bool, **options: Any
) -> list[tuple[ContactGrid, SlotLayout]]:
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
    layout = SlotLayout(kernel, begins=begins, **options)
    # twice the spacing exactly, so that its nodes lie half-way between pairs of nodes
    coarse = math.ceil(nodes / 2)
    coarser = causal_grid(scene, latest, 2 * grid.spacing * coarse, coarse, entry)
    return [(grid, layout), (coarser, replace(layout, stride=2))][: 1 + companion]


def state_bytes(size: int, poles: int) -> int:
    """Return the memory of a march on a grid of `size` nodes [bytes], measured at its peak."""
    # Bytes at the peak of a march, measured: eight complex arrays of poles.
    return size * (poles * 128 + 400)


def check_size(
    scene: Scene,
    latest: float,
    length: float,
    nodes: int,
    memory: float | None,
    companion: bool,
    entry: float = 0.0,
) -> None:
    """Refuse a grid whose state, with that of its companion, does not fit into the memory.

    Raises
    ------
    SceneError
        If it does not fit; `memory` [bytes] is what the march may take.
    """
    # all nodes over the observed ones, as in `causal_grid`
    share = sum(extents(scene, latest, length, entry)) / length
    size = int(min(share, 1e30) * min(nodes, 1e30))
    check_memory(
        state_bytes(size + companion * (size // 2), 25),  # 15 to 40 poles
        memory,
        f"march: a grid of {size:.3g} nodes",
        "lower `nodes`, `end_time` or `latest`, or raise `length`",
    )
