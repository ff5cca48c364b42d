"""Specimens of finite size: two blocks that touch along the part of y = 0 that both have.

What acts before t = 0 is in place: the march computes changes, so that the specimen is at rest to
the last bit until loads come.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.elements.assembly import IN_PLANE, STIFFNESS, X, Y
from fem.lines.blocks import SIDES, LineBlock
from fem.lines.gauges import Gauges
from fem.lines.line import Line
from fem.lines.march import DAMPING, SAMPLES, STEP_RATIO, LineSimulation, Progress, marched
from fem.lines.statics import condensed, contact_forces
from semianalytic.scene.checks import (
    check_fields,
    checked_size,
    shown,
)
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.laws.law import Law
from semianalytic.scene.line.contact import Contact
from semianalytic.scene.loading import Tractions
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material

Array = NDArray[np.float64]

WHOLE = 1e-6
"""Part of a square by which ends of blocks may miss the grid."""


@dataclass(frozen=True)
class Block:
    """A rectangular block of a specimen, on one side of y = 0.

    Sides are "free", "clamped", "roller" (held across, free along), "guided" (free across, held
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
        If it has no height or width, or tractions act where a side is held.

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
        object.__setattr__(self, "height", checked_size("block: height", self.height))
        if not self.left < self.right:
            raise SceneError(
                f"block: left must be below right, got {self.left:g} and {self.right:g}."
            )
        for name, kind in self.kinds.items():
            if kind not in SIDES:
                known = ", ".join(SIDES)
                raise SceneError(f"block: {name}_side must be one of {known}, got {shown(kind)}.")
        for name, traction in (*self.preload.items(), *self.load.items()):
            if name.removesuffix("_side") not in self.kinds or not name.endswith("_side"):
                raise SceneError(
                    f"block: tractions act on far_side, left_side or right_side, not {shown(name)}."
                )
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
        Tractions that are taken off the slot at t = 0 [stress].
    history : LoadHistory
        Factor of that load over time.
    gauges : sequence of (x, y)
        Points at which velocity and strain are recorded [length].

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

    def __post_init__(self) -> None:
        upper, lower = self.blocks
        if not max(upper.left, lower.left) < min(upper.right, lower.right):
            raise SceneError("specimen: the blocks have no part of y = 0 in common; move one.")
        for x, y in self.gauges:
            block = self.upper if y > 0 else self.lower
            if not (block.left <= x <= block.right and 0 < abs(y) <= block.height):
                raise SceneError(
                    f"specimen: the gauge at ({x:g}, {y:g}) is on the joint or outside the blocks; "
                    "move it into one of them."
                )

    def simulated(self, end_time: float | None, **options: Any) -> LineSimulation:
        """Return the simulation until T [time]; options are those of `simulate_specimen`."""
        return simulate_specimen(self, end_time, **options)

    @property
    def law(self) -> Law:
        """The friction law; a coefficient is that of Coulomb."""
        return self.friction if isinstance(self.friction, Law) else Coulomb(self.friction)

    @property
    def blocks(self) -> tuple[Block, Block]:
        """The upper and the lower block."""
        return self.upper, self.lower

    def nodes(self, size: float) -> tuple[Array, list[int]]:
        """Return the positions of the joint's nodes, and the column of the first in each block."""
        left = max(block.left for block in self.blocks)
        right = min(block.right for block in self.blocks)
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
        borders = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
        contact = sum(
            np.maximum(np.minimum(borders[1:], end) - np.maximum(borders[:-1], begin), 0.0)
            for begin, end in self.contact.intervals
        )
        slot, least = np.diff(borders) - contact, WHOLE * (x[1] - x[0])
        return np.where(contact > least, contact, 0.0), np.where(slot > least, slot, 0.0)

    def in_place(
        self, blocks: list[LineBlock], x: Array, law: Law, state: Array
    ) -> tuple[Array, Array]:
        """Return pressure and shear in place at the nodes of the joint, (n,) [stress]."""
        if self.base is not None:
            return self.base.pressure + 0 * x, self.base.shear + 0 * x
        lengths, faces = self.shares(x)[0], []
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


def simulate_specimen(
    specimen: Specimen,
    end_time: float | None,
    *,
    size: float | None = None,
    samples: int = SAMPLES,
    damping: float = DAMPING,
    step_ratio: float = STEP_RATIO,
    progress: Progress | None = None,
) -> LineSimulation:
    """Simulate a specimen with squares of a size [length]; all else as `simulate_line`.

    At t = 0 it is at rest, in equilibrium under its preloads or with its base tractions in place.

    Raises
    ------
    SceneError
        If the blocks do not fit the squares, or would fall apart under their preloads.
    """
    size = checked_size("simulate: size", size)
    end_time = checked_size("simulate: end_time", end_time)
    x, firsts = specimen.nodes(size)
    meshed = [
        LineBlock(
            material=block.material,
            columns=round((block.right - block.left) / size) + 1,
            rows=round(block.height / size),
            size=size,
            damping_time=damping * size / block.material.shear_speed,
            sides=block.kinds,
            first=first,
        )
        for block, first in zip(specimen.blocks, firsts, strict=True)
    ]
    meshed = [
        replace(one, load=side_forces(one, block.load, sign), history=block.history)
        for one, block, sign in zip(meshed, specimen.blocks, (1.0, -1.0), strict=True)
    ]
    shares = specimen.shares(x)
    touching = shares[0] > 0
    law = specimen.law.on(x[touching], size)
    none = np.zeros(int(touching.sum()))
    state = np.asarray(law.start(none + 1, none, none), dtype=float)
    pressure, shear = specimen.in_place(meshed, x, law, state)

    def tractions(base: Array, load: float) -> Callable[..., tuple[Array, Array]]:
        """Return tractions in place, and those on the slot, over time."""

        def at(time: float, after: bool = False) -> tuple[Array, Array]:
            now = np.nextafter(time, np.inf) if after else time
            return base, base - load * float(specimen.history.pieces.value(now))

        return at

    upper, lower = specimen.blocks
    line = Line(
        upper.material,
        lower.material,
        size * len(x),
        x,
        touching,
        law,
        state,
        tractions(shear, specimen.load.shear),
        tractions(pressure, specimen.load.pressure),
        opens=True,
        shares=shares,
    )
    gauges = Gauges(specimen.gauges, meshed, [block.left for block in specimen.blocks])
    return marched(line, meshed, end_time, samples, step_ratio, progress, gauges)
