"""Gauges: velocity and strain at points of the blocks, at every step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.lines.blocks import LineBlock
from fem.march import March
from semianalytic.scene.arrays import Array


@dataclass(frozen=True, eq=False)
class GaugeHistory:
    """Motion at points of a specimen, since t = 0.

    Attributes
    ----------
    points : (k, 2) array
        Positions x and y [length].
    t : (m,) array
        Times [time].
    velocity : (m, k, 2) array
        Velocity along x and y [length / time].
    strain : (m, k, 3) array
        Changes of the strains xx, yy and xy (half the shear angle).
    """

    points: Array
    t: Array
    velocity: Array
    strain: Array


class Gauges:
    """Points in the squares of blocks whose left ends are at x (2,) [length]."""

    def __init__(
        self, points: Sequence[tuple[float, float]], blocks: list[LineBlock], left: list[float]
    ) -> None:
        self.points = np.asarray(points, dtype=float).reshape(-1, 2)
        self.velocity: list[Array] = []
        self.strain: list[Array] = []
        self._parts = []
        for number, (block, start) in enumerate(zip(blocks, left, strict=True)):
            mine = np.flatnonzero((self.points[:, 1] < 0) == bool(number))
            place = (np.abs(self.points[mine] - [start, 0.0])) / block.size
            corner = np.minimum(place.astype(int), [block.columns - 2, block.rows - 1])
            u, v = (place - corner).T
            first = corner @ [1, block.columns]
            nodes = first[:, None] + np.array([0, 1, block.columns, block.columns + 1])
            shape = np.stack([(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v], axis=1)
            slope = np.stack([[v - 1, 1 - v, -v, v], [u - 1, -u, 1 - u, u]]).T / block.size
            # a lower block is described by its mirror image
            sign = np.array([1.0, -1.0 if number else 1.0])
            unknowns = 2 * nodes[..., None] + [0, 1]
            self._parts.append((mine, number, unknowns, shape, slope * sign, sign))

    def level(self, march: March) -> None:
        """Record a level whose kick is done."""
        velocity, strain = np.zeros((len(self.points), 2)), np.zeros((len(self.points), 3))
        for mine, number, unknowns, shape, slope, sign in self._parts:
            body = march.bodies[number]
            scale = sign / body.root[unknowns]
            gained = (body.before[unknowns] + body.increment[unknowns]) * scale
            velocity[mine] = np.einsum("ka,kai->ki", shape, gained) / (2 * march.time_step)
            moved = body.displacement[unknowns] * scale
            gradient = np.einsum("kaj,kai->kji", slope, moved)  # d_j u_i
            strain[mine, :2] = gradient[:, [0, 1], [0, 1]]
            strain[mine, 2] = (gradient[:, 0, 1] + gradient[:, 1, 0]) / 2
        self.velocity.append(velocity)
        self.strain.append(strain)

    def history(self, step: float, steps: int) -> GaugeHistory:
        """Return what was recorded up to a level."""
        t = np.asarray(step * np.arange(steps + 1.0))
        velocity, strain = (np.array(entry[: steps + 1]) for entry in (self.velocity, self.strain))
        return GaugeHistory(self.points, t, velocity, strain)
