"""Periodic blocks of squares on both sides of the interface, and how deep they are.

Nodes are numbered row by row from the interface on, so that those which no wave has reached are the
last ones.  A lower block is described by its mirror image.  Far sides absorb plane waves: a dashpot
rho c per area on each node.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad

from fem.elements.assembly import IN_PLANE, OUT_OF_PLANE, Space, X, Y
from fem.lines.line import Line
from fem.march import body_matrix, highest_of_patch
from fem.stepping import MarchedBody, critical_step
from meshes.blocks import causal_margin
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material

MARGIN = 8
"""Rows of nodes beyond those that the first wave passes twice until the end."""
STIFF = 1000.0
"""Ratio of the shear moduli from which on the stiffer block may be shallow: its motion is 0.1 % of
the whole or less, and its far side absorbs most of the waves."""
SHALLOW = 0.25
"""Depth of such a block over the period of the line.  Slip of steel on rubber (2.4e4) is that of a
depth of 2 to 5e-6; with half of this value it is to 6e-6, with twice to 3e-6."""
MOST_WORK = 5e11
"""Unknowns times steps that are accepted, which take one to two hours."""


SIDES: Mapping[str, tuple[bool, bool, bool]] = {
    "free": (False, False, False),
    "clamped": (True, True, False),
    "roller": (True, False, False),
    "guided": (False, True, False),
    "absorbing": (False, False, True),
}
"""Whether a side holds motion across it, holds motion along it, and absorbs plane waves."""


@dataclass(frozen=True)
class LineBlock:
    """One block of squares, before it is assembled."""

    material: Material
    # columns of nodes, and rows of squares
    columns: int
    rows: int
    size: float  # side of the squares [length]
    damping_time: float  # eta of the damping C = eta K [time]
    components: tuple[int, ...] = IN_PLANE  # displacement components
    # kind, of `SIDES`, of the sides "far", "left" and "right"; without the last two the block is
    # periodic
    sides: Mapping[str, str] = field(default_factory=lambda: {"far": "absorbing"})
    first: int = 0  # column of the first node of the joint
    # (n,) array: forces on its unknowns [stress length], which follow a history from t = 0 on
    load: Array | None = None
    history: LoadHistory = field(default_factory=Step)

    @property
    def fastest(self) -> float:
        """Speed of the first wave [length / time]."""
        solid = self.material
        return solid.longitudinal_speed if self.components == IN_PLANE else solid.shear_speed

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return len(self.components) * self.columns * (self.rows + 1)

    @property
    def critical_step(self) -> float:
        """Largest stable step [time], that of a free patch, which no larger block exceeds."""
        highest = highest_of_patch(self.size, self.material, self.components)
        return critical_step(highest, self.damping_time)

    @cached_property
    def mesh(self) -> tuple[Space, NDArray[np.int64]]:
        """Mesh from x = 0 on, and the number of each of its nodes, row by row from the joint."""
        across = self.columns - 1 if "left" in self.sides else self.columns
        along, away = (self.size * np.arange(count + 1.0) for count in (across, self.rows))
        space = Space(MeshQuad.init_tensor(along, away))
        column, row = np.rint(space.points / self.size).astype(np.int64)
        # the last column of nodes of a periodic block is the first one again
        return space, self.columns * row + column % self.columns

    def side(self, name: str) -> tuple[NDArray[np.int64], Array]:
        """Return the nodes of a side and the length of it that belongs to each."""
        numbers = np.arange(self.columns * (self.rows + 1)).reshape(-1, self.columns)
        nodes = {"far": numbers[-1], "left": numbers[:, 0], "right": numbers[:, -1]}[name]
        lengths = np.full(len(nodes), self.size)
        if "left" in self.sides:
            lengths[[0, -1]] /= 2
        return nodes, lengths

    def resistance(self) -> Array:
        """Return the dashpot of each unknown (n,) [mass / time], inf where it is held."""
        solid = self.material
        dashpots = np.zeros(self.unknowns)
        for name, kind in self.sides.items():
            nodes, lengths = self.side(name)
            *held, absorbs = SIDES[kind]
            for index, component in enumerate(self.components):
                is_across = component == (Y if name == "far" else X)
                speed = solid.longitudinal_speed if is_across else solid.shear_speed
                own = len(self.components) * nodes + index
                dashpots[own] += solid.density * speed * lengths if absorbs else 0.0
                dashpots[own] += np.inf if held[not is_across] else 0.0
        return dashpots

    def assembled(self, step: float, end_time: float) -> MarchedBody:
        """Return the block at rest, for a time step and an end time [time]."""
        matrix, root = body_matrix(self.mesh[0], self.material, self.components, self.mesh[1])
        matrix.data *= step**2
        margin = causal_margin(self.fastest, end_time, self.size, self.damping_time)
        away = self.size * np.arange(self.rows + 1.0)
        arrival = np.repeat((away - margin) / self.fastest, self.columns)
        if self.load is not None and self.load.any():
            arrival[:] = 0.0
        dashpots = self.resistance()
        sides = np.flatnonzero(dashpots)
        absorption = step * dashpots[sides] / (2 * root[sides] ** 2)
        eta = self.damping_time / step
        return MarchedBody(self.components, matrix, root, eta, arrival, sides, absorption)


def make_blocks(line: Line, end_time: float, damping: float) -> list[LineBlock]:
    """Return the blocks of a line until T [time]: one where both move oppositely, else two.

    The damping is eta of each block, over the time in which its shear wave crosses a square.
    """
    size, columns = line.spacing, len(line.x)
    softest = min(line.upper.shear_modulus, line.lower.shear_modulus)
    components = OUT_OF_PLANE if line.antiplane else IN_PLANE
    blocks = []
    for material in [line.upper, line.lower][: 1 if line.is_odd else 2]:
        fastest = material.shear_speed if line.antiplane else material.longitudinal_speed
        # what comes back from the far side arrives after the end
        rows = math.ceil(fastest * end_time / (2 * size)) + MARGIN
        if material.shear_modulus >= STIFF * softest:
            rows = min(rows, math.ceil(SHALLOW * columns))
        damping_time = damping * size / material.shear_speed
        blocks.append(LineBlock(material, columns, rows, size, damping_time, components))
    return blocks


def check_work(blocks: list[LineBlock], steps: int) -> None:
    """Raise SceneError if a simulation would take hours."""
    work = sum(block.unknowns for block in blocks) * steps
    if work > MOST_WORK:
        raise SceneError(
            f"simulate: {steps} steps of finite elements with "
            f"{sum(block.unknowns for block in blocks)} unknowns would take hours, because a step "
            "cannot be longer than a wave takes to cross a square; take fewer nodes, or an earlier "
            "end time."
        )
