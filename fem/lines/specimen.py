"""Specimens of finite size: two blocks that touch along the part of y = 0 that both have.

What acts before t = 0 is in place: the march computes changes, so that the specimen is at rest to
the last bit until loads come.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse

from fem.elements.assembly import IN_PLANE, STIFFNESS, X, Y
from fem.lines.blocks import MOST_WORK, SIDES, LineBlock
from fem.lines.gauges import Gauges
from fem.lines.line import Line
from fem.lines.march import DAMPING, SAMPLES, STEP_RATIO, LineSimulation, Progress, marched
from fem.lines.statics import condensed, contact_forces
from fem.settings import Settings
from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import (
    check_fields,
    check_keys,
    checked_size,
    checked_word,
    finite,
    shown,
)
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.laws.law import Law
from semianalytic.scene.line.contact import Contact
from semianalytic.scene.line.fields import Table
from semianalytic.scene.loading import Tractions
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material
from semianalytic.scene.scene import Scene

WHOLE = 1e-6
"""Part of a square by which ends of blocks may miss the grid."""


@checking_methods
@dataclass(frozen=True)
class Block:
    """A rectangular block of a specimen, on one side of y = 0.

    Sides are "free", "clamped", "roller" (fixed across, free along), "guided" (free across, fixed
    along) or "absorbing" (plane waves pass; at rest it is free).

    Parameters
    ----------
    material : Material
    height : float
        Height of the block [length].
    left, right : float
        Positions x of its sides [length].
    far_side, left_side, right_side : str
        Kinds of its sides.
    preload, load : mapping of str to Tractions
        Tractions on "far_side", "left_side" and "right_side": pressure and sigma_xy [stress].
        Preloads act before t = 0, when the specimen is in equilibrium; loads follow the history.
    history : LoadHistory
        Factor of loads over time.

    Raises
    ------
    SceneError
        If it has no height or width, or tractions act where a side is fixed.

    Examples
    --------
    >>> import slipfront as sf
    >>> sf.Block(sf.Material(1.0, 1.0, 0.25), 0.1, -1.0, 1.0, far_side="clamped").height
    0.1
    """

    material: Material
    height: float
    left: float
    right: float
    far_side: str = "free"
    left_side: str = "free"
    right_side: str = "free"
    preload: Mapping[str, Tractions] = field(default_factory=dict)
    load: Mapping[str, Tractions] = field(default_factory=dict)
    history: LoadHistory = field(default_factory=Step)

    def __post_init__(self) -> None:
        check_fields(self, "block", ("left", "right"))
        check_fields(self, "block", ("height",), checked_size)
        if not self.left < self.right:
            raise SceneError(
                f"block: left must be below right, got {self.left:g} and {self.right:g}."
            )
        for name, kind in self.kinds.items():
            checked_word(f"block: {name}_side", kind, SIDES)
        for name, traction in (*self.preload.items(), *self.load.items()):
            if name.removesuffix("_side") not in self.kinds or not name.endswith("_side"):
                raise SceneError(
                    f"block: tractions act on far_side, left_side or right_side, not {shown(name)}."
                )
            if not isinstance(traction, Tractions):
                raise SceneError(f"block: {name} takes Tractions, got {shown(traction)}.")
            kind = getattr(self, name)
            across, along, _ = SIDES[kind]
            if (across and traction.pressure) or (along and traction.shear):
                raise SceneError(
                    f"block: the {name} is {kind} and bears no such traction of its own; free it."
                )

    @property
    def kinds(self) -> dict[str, str]:
        """Kinds of the sides far, left and right."""
        return {"far": self.far_side, "left": self.left_side, "right": self.right_side}


@checking_methods
@dataclass(frozen=True)
class Specimen:
    """Two blocks that meet on y = 0, for `simulate`.

    Parameters
    ----------
    upper, lower : Block
        The blocks on y > 0 and y < 0; the joint is where both have a face.
    friction : float or Law
        Friction coefficient, or a law.
    contact : Contact
        Where the joint touches; the rest is slot.  The whole joint by default.
    base : Tractions, optional
        Tractions in place on the joint [stress]; by default those of equilibrium under preloads.
    load : Tractions
        Tractions that are removed from the slot faces at t = 0 [stress].
    history : LoadHistory
        Factor of that load over time.
    gauges : sequence of (x, y)
        Points at which velocity and strain are recorded [length].
    run : mapping
        End time and size of the squares of a simulation, unless others are given.

    Raises
    ------
    SceneError
        If the blocks have no common face, or a gauge is outside them or on the joint.

    Examples
    --------
    Layers under a pressure of 1, the upper one suddenly sheared by 0.4 on its top:

    >>> import slipfront as sf
    >>> plate = {"material": sf.Material(1.0, 1.0, 0.25), "height": 1.0, "left": 0.0, "right": 0.2}
    >>> plate |= {"left_side": "guided", "right_side": "guided"}
    >>> upper = sf.Block(**plate, load={"far_side": sf.Tractions(0.0, 0.4)})
    >>> layers = sf.Specimen(upper, sf.Block(**plate, far_side="absorbing"), 0.3,
    ...                      base=sf.Tractions(1.0, 0.0))
    >>> run = sf.simulate(layers, 2.0, size=0.05)
    >>> round(float(run.slip[-1, 2]), 1)  # (0.8 - 0.6) 2 c_t tau t / mu after a transit
    0.2
    """

    upper: Block
    lower: Block
    friction: float | Law
    contact: Contact = field(default_factory=Contact)
    base: Tractions | None = None
    load: Tractions = field(default_factory=lambda: Tractions(0.0, 0.0))
    history: LoadHistory = field(default_factory=Step)
    gauges: Sequence[tuple[float, float]] = ()
    run: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_keys("run.", self.run, (), ("end_time", "size"))
        if not isinstance(self.load, Tractions):
            raise SceneError(
                f"specimen: load must be Tractions on the slot, got {shown(self.load)}."
            )
        upper, lower = self.blocks
        if not max(upper.left, lower.left) < min(upper.right, lower.right):
            raise SceneError("specimen: the blocks have no part of y = 0 in common; move one.")
        for given in self.gauges if np.iterable(self.gauges) else (self.gauges,):
            place = tuple(map(finite, given)) if np.iterable(given) else ()
            if len(place) != 2 or None in place:
                raise SceneError(
                    f"specimen: gauges must be pairs of numbers x and y, got {shown(given)}."
                )
            x, y = map(float, given)
            block = self.upper if y > 0 else self.lower
            if not (block.left <= x <= block.right and 0 < abs(y) <= block.height):
                raise SceneError(
                    f"specimen: the gauge at ({x:g}, {y:g}) is on the joint or outside the blocks; "
                    "move it into one of them."
                )

    def simulated(
        self,
        end_time: float | None = None,
        *,
        size: float | None = None,
        samples: int = SAMPLES,
        damping: float = DAMPING,
        step_ratio: float = STEP_RATIO,
        progress: Progress | None = None,
    ) -> LineSimulation:
        """Simulate the specimen with square elements of the given size [length]; all else is as for
        `simulate_line`.

        At t = 0 it is at rest, in equilibrium under its preloads or with its base in place.

        Raises
        ------
        SceneError
            If the blocks do not fit the squares, or would fall apart under their preloads.
        """
        Settings(damping=damping, step_ratio=step_ratio)  # refuses what is out of range
        x, meshed = self.meshed(size, damping)
        size = meshed[0].size
        shares = self.shares(x)
        touching = shares[0] > 0
        law, state = self.friction_at(x[touching], size)
        pressure, shear = self.in_place(x, meshed)

        def tractions(base: Array, load: float) -> Callable[..., tuple[Array, Array]]:
            """Return tractions in place, and those on the slot, over time."""

            def at(time: float, after: bool = False) -> tuple[Array, Array]:
                now = np.nextafter(time, np.inf) if after else time
                return base, base - load * float(self.history.pieces.value(now))

            return at

        upper, lower = self.blocks
        line = Line(
            upper.material,
            lower.material,
            size * len(x),
            x,
            touching,
            law,
            state,
            tractions(shear, self.load.shear),
            tractions(pressure, self.load.pressure),
            opens=True,
            shares=shares,
        )
        gauges = Gauges(self.gauges, meshed, [block.left for block in self.blocks])
        end_time = checked_size("simulate: end_time", end_time or self.run.get("end_time"))
        return marched(line, meshed, end_time, samples, step_ratio, progress, gauges)

    def friction_at(self, x: Array, size: float) -> tuple[Law, Array]:
        """Return the friction law at nodes x (n,) with the given spacing [length], and its state at
        t = 0.
        """
        law = self.friction if isinstance(self.friction, Law) else Coulomb(self.friction)
        law, none = law.on(x, size), np.zeros(len(x))
        return law, np.asarray(law.start(none + 1, none, none), dtype=float)

    @property
    def blocks(self) -> tuple[Block, Block]:
        """The upper and the lower block."""
        return self.upper, self.lower

    def nodes(self, size: float) -> tuple[Array, list[int]]:
        """Return the positions of the joint's nodes, and the column of the first in each block."""
        left, right = self.joint
        area = sum((block.right - block.left) * block.height for block in self.blocks)
        if area > MOST_WORK * size**2:
            raise SceneError(f"simulate: squares of {size:g} are too many; choose a larger size.")
        for block in self.blocks:
            spans = np.array([left - block.left, right - left, block.right - right, block.height])
            if np.abs(spans / size - np.rint(spans / size)).max() > WHOLE * spans.max() / size:
                raise SceneError(
                    f"simulate: heights and ends of the blocks must be whole numbers of elements "
                    f"of {size:g}; choose another size."
                )
        x = np.asarray(left + size * np.arange(round((right - left) / size) + 1.0))
        return x, [round((left - block.left) / size) for block in self.blocks]

    def shares(self, x: Array) -> tuple[Array, Array]:
        """Return the lengths of contact and of slot that belong to nodes of the joint [length]."""
        if np.ndim(x) != 1 or len(x) < 2:
            raise SceneError(f"shares: x must be two nodes or more in a row, got {shown(x)}.")
        borders = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
        contact = sum(
            np.maximum(np.minimum(borders[1:], end) - np.maximum(borders[:-1], begin), 0.0)
            for begin, end in self.contact.intervals
        )
        slot, least = np.diff(borders) - contact, WHOLE * (x[1] - x[0])
        return np.where(contact > least, contact, 0.0), np.where(slot > least, slot, 0.0)

    @property
    def joint(self) -> tuple[float, float]:
        """Ends of the joint [length]."""
        ends = [(block.left, block.right) for block in self.blocks]
        return max(ends)[0], min(end for _, end in ends)

    def half_planes(self, size: float | None = None) -> Scene:
        """Return the half-planes that describe the specimen until waves from its ends arrive.

        Contact or slot at an end of the joint continues beyond it, and so do the initial tractions
        due to preloads, which are computed statically on squares of the given size [length].
        """
        (left, right), base = self.joint, self.base
        contact = [
            (begin if begin > left else -math.inf, end if end < right else math.inf)
            for begin, end in self.contact.intervals
        ]
        if base is None:
            x, blocks = self.meshed(size)
            on = self.shares(x)[0] > 0
            found = self.in_place(x, blocks)
            base = Tractions(*(Table(x[on], values[on]) for values in found))
        return Scene(
            self.upper.material,
            self.friction,
            base,
            self.load,
            pressure_history=self.history,
            shear_history=self.history,
            lower_material=self.lower.material,
            contact=Contact(contact),
        )

    def felt(self, x: Array) -> Array:
        """Return the times at which waves from the boundaries of the blocks first arrive at points
        of the joint, (n,) [time].

        First waves run at c_l from loaded slots to a far side and back, or along the joint to its
        ends and back; a slot that reaches such an end emits them at t = 0, unless the sides there
        transmit the plane waves of its load.  Waves of loads on sides arrive directly.
        """
        x, (left, right) = np.asarray(x, dtype=float), self.joint
        found, acts = np.full(len(x), math.inf), bool(self.load.pressure or self.load.shear)
        ends = [left, *(side for part in sorted(self.contact.intervals) for side in part), right]
        slots = [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if acts and a < b]
        for block in self.blocks:
            speed, sides = block.material.longitudinal_speed, ((left, "left"), (right, "right"))
            for begin, end in slots:
                aside = np.maximum(np.maximum(begin - x, x - end), 0.0)
                found = np.minimum(found, np.hypot(2 * block.height, aside) / speed)
                for at, name in sides:
                    near, far = sorted((abs(begin - at), abs(end - at)))
                    way = far if near == 0 and self._passes(at, name) else near
                    found = np.minimum(found, (way + np.abs(x - at)) / speed)
            for name in block.load:
                ways = {"left_side": x - block.left, "right_side": block.right - x}
                found = np.minimum(found, ways.get(name, block.height + 0 * x) / speed)
        return found

    def _passes(self, at: float, name: str) -> bool:
        """Return whether plane waves of the load on the slot run along the sides at a place."""
        held = {"guided"} if not self.load.pressure else set()
        held |= {"roller"} if not self.load.shear else set()
        return all(
            getattr(box, name) == at and getattr(box, f"{name}_side") in held for box in self.blocks
        )

    def meshed(self, size: float | None, damping: float = DAMPING) -> tuple[Array, list[LineBlock]]:
        """Return the nodes of the joint [length] and the blocks with their loads, on squares."""
        size = checked_size("simulate: size", self.run.get("size") if size is None else size)
        x, firsts = self.nodes(size)
        blocks = []
        for block, first, sign in zip(self.blocks, firsts, (1.0, -1.0), strict=True):
            entry = LineBlock(
                material=block.material,
                columns=round((block.right - block.left) / size) + 1,
                rows=round(block.height / size),
                size=size,
                damping_time=damping * size / block.material.shear_speed,
                sides=block.kinds,
                first=first,
                history=block.history,
            )
            blocks.append(replace(entry, load=side_forces(entry, block.load, sign)))
        return x, blocks

    def in_place(self, x: Array, blocks: list[LineBlock]) -> tuple[Array, Array]:
        """Return pressure and shear in place at the nodes of the joint, (n,) [stress]."""
        if self.base is not None:
            return self.base.pressure + 0 * x, self.base.shear + 0 * x
        lengths, faces = self.shares(x)[0], []
        law, state = self.friction_at(x[lengths > 0], blocks[0].size)
        for number, (block, meshed) in enumerate(zip(self.blocks, blocks, strict=True)):
            stiffness = STIFFNESS[IN_PLANE](meshed.mesh[0], block.material, meshed.mesh[1])
            free = np.isfinite(meshed.resistance()).astype(float)
            keep = sparse.diags_array(free)
            held = sparse.diags_array(stiffness.diagonal() * (1 - free))
            stiffness = sparse.csr_array(keep @ stiffness @ keep + held)
            force = free * side_forces(meshed, block.preload, -1.0 if number else 1.0)
            faces.append(condensed(stiffness, force, 2 * meshed.columns))
        columns = np.flatnonzero(lengths)
        unit, still = np.ones(len(columns)), np.zeros(len(columns))
        friction = law.strength(unit, still, state) - law.strength(still, still, state)
        forces = contact_forces(faces, [block.first + columns for block in blocks], friction)
        pressure, shear = np.zeros((2, len(x)))
        pressure[columns], shear[columns] = (force / lengths[columns] for force in forces)
        return pressure, shear


def side_forces(block: LineBlock, tractions: Mapping[str, Tractions], sign: float) -> Array:
    """Return the forces of tractions on the sides of a block, (n,) [stress length].

    The sign is -1 for a lower block, which is described by its mirror image.
    """
    forces = np.zeros(block.unknowns)
    for name, traction in tractions.items():
        side = name.removesuffix("_side")
        nodes, lengths = block.side(side)
        outward = -1.0 if side == "left" else 1.0
        across, along = (Y, X) if side == "far" else (X, Y)
        forces[2 * nodes + across] -= outward * traction.pressure * lengths
        forces[2 * nodes + along] += sign * outward * traction.shear * lengths
    return forces
