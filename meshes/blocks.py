"""The rectangles that the blocks occupy, and the size that causality requires."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import SceneError

PATTERNS = ("squares", "graded", "triangles")
"""Mesh patterns: squares, rows that grow away from the interface, unstructured triangles."""
GROWTH = 1.05
"""Height of each row of a graded mesh over that of the row before, so h + 0.05 |y|."""
MOST_ELEMENTS = 10_000_000
"""Largest mesh accepted; putting its matrix together takes about 35 gigabytes."""


@dataclass(frozen=True)
class Blocks:
    """One or two rectangles of elements that meet along y = 0.

    The upper block covers -left*size <= x <= right*size, 0 <= y <= `far`; the lower one
    is its mirror image.  They share no node: each has its own slot face (x <= 0), contact
    face (x >= 0) and edge node (x = 0).

    Parameters
    ----------
    size : float
        Element size h [length], of graded meshes that at the interface.
    left, right, height : int
        Elements left of the edge, right of it, and from the interface to the far side.
    lower : bool
        Whether there is a lower block as well.
    pattern : str
        One of `PATTERNS`.

    Raises
    ------
    SceneError
        If size is not positive and finite, a count is below 1, the pattern is unknown, or the
        elements are too many.
    """

    size: float
    left: int
    right: int
    height: int
    lower: bool = False
    pattern: str = "squares"

    def __post_init__(self) -> None:
        if self.pattern not in PATTERNS:
            raise SceneError(
                f"mesh: the mesh must be one of {', '.join(PATTERNS)}, got {self.pattern!r}."
            )
        if not (math.isfinite(self.size) and self.size > 0):
            raise SceneError(f"mesh: the element size must be positive, got {self.size}.")
        if min(self.left, self.right, self.height) < 1:
            raise SceneError(
                "mesh: every side needs at least one element, "
                f"got {self.left} left, {self.right} right, {self.height} high."
            )
        if self.elements > MOST_ELEMENTS:
            raise SceneError(
                f"mesh: {self.elements} elements are more than {MOST_ELEMENTS}; "
                "lower `resolution`, leave snapshots off, or lower `poisson_ratio`."
            )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the blocks."""
        return ("upper", "lower") if self.lower else ("upper",)

    @property
    def elements(self) -> int:
        """Number of quadrilaterals in all blocks; triangles are about twice as many."""
        return len(self.names) * (self.left + self.right) * self.height

    @property
    def nodes(self) -> int:
        """Number of corners of the quadrilaterals in all blocks."""
        return len(self.names) * (self.left + self.right + 1) * (self.height + 1)

    @property
    def rows(self) -> NDArray[np.float64]:
        """Distances of the rows of nodes from the interface [length], (height + 1,)."""
        number = np.arange(self.height + 1.0)
        if self.pattern == "graded":
            number = np.expm1(math.log(GROWTH) * number) / (GROWTH - 1)
        return np.asarray(self.size * number, dtype=np.float64)

    @property
    def far(self) -> float:
        """Distance of the far side from the interface [length]."""
        return float(self.rows[-1])

    def sides(self, block: str) -> dict[str, int]:
        """Return the names of a block's boundaries and the number of element sides on each."""
        far = "top" if block == "upper" else "bottom"
        return {
            f"{block}_slot": self.left,
            f"{block}_contact": self.right,
            f"{block}_right": self.height,
            f"{block}_{far}": self.left + self.right,
            f"{block}_left": self.height,
        }


def causal_margin(speed: float, end_time: float, size: float, damping_time: float = 0.0) -> float:
    """Return how far numerical forerunners run ahead of the pressure front until T [length].

    A wave of a mesh has no sharp front: dispersion smears it over a few elements, and the damping C
    = eta K spreads it like a diffusion of strength eta c_l^2, eta being the damping time.  Beyond 8
    h + 3 c_l sqrt(eta T) what is left is below rounding for every purpose here.
    """
    return 8 * size + 3 * speed * math.sqrt(damping_time * end_time)


def causal_blocks(
    speed: float,
    end_time: float,
    size: float,
    *,
    damping_time: float = 0.0,
    full: bool = False,
    lower: bool = False,
    free_walls: bool = False,
    pattern: str = "squares",
) -> Blocks:
    """Return blocks just large enough that no reflection is seen before the end time T.

    All waves but plane ones start at the edge at t = 0 and travel at most at c_l.  The plane waves
    of a loaded slot or a sliding interface run straight up and pass along side walls that hold u_y
    (shear) or u_x (pressure) without any reflection.  Hence

    - right wall: what leaves the edge meets it after c_l T, so the whole disturbed contact
      0 < x < c_l T is observed;
    - far side: up and back is 2 H >= c_l T, so H = c_l T / 2;
    - left wall: there and back to the slot face at -S is 2 L - S >= c_l T.  The slot is
      observed as far as S = c_l T / 2 (see `observed_slot`), so L = 3/4 c_l T.

    When whole fields are looked at (`full`), nothing may come back at all: all three are
    c_l T.  Each path gets the margin of `causal_margin` on top.

    Parameters
    ----------
    speed : float
        Speed of the fastest wave, c_l; c_t under antiplane shear alone, whose plane waves free
        side walls let pass [length / time].
    end_time : float
        T [time], positive.
    size : float
        Element size h [length].
    damping_time : float
        eta of the damping C = eta K [time].
    full : bool
        Whether whole fields are observed, not only the interface.
    lower : bool
        Whether to include the lower block.
    free_walls : bool
        Whether the side walls disturb the plane waves of the slot, as free walls do, and any walls
        those of a load that moves: the left one sends out waves from t = 0 on, so L - S >= c_l T.
    pattern : str
        One of `PATTERNS`.

    Returns
    -------
    Blocks

    Raises
    ------
    SceneError
        If the mesh would be too large.
    """
    reach = speed * end_time
    margin = causal_margin(speed, end_time, size, damping_time)

    def elements(length: float) -> int:
        return math.ceil(length / size)

    def rows(length: float) -> int:
        if pattern != "graded":
            return elements(length)
        return math.ceil(math.log1p((GROWTH - 1) * length / size) / math.log(GROWTH))

    far, slot = reach + margin, observed_slot(speed, end_time, full)
    there_and_back = far + (far if full else slot)
    left = far + slot if free_walls else there_and_back / 2
    height = far if full else far / 2
    return Blocks(size, elements(left), elements(far), rows(height), lower, pattern)


def observed_slot(speed: float, end_time: float, full: bool = False) -> float:
    """Return the length of slot next to the edge that no reflection reaches until T [length]."""
    return speed * end_time / (1 if full else 2)
