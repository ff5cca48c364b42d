"""The rectangle that each block occupies, and the size that causality requires."""

from __future__ import annotations

import math
from dataclasses import dataclass

from semianalytic.scene.checks import checked_word, shown
from semianalytic.scene.errors import SceneError

PATTERNS = ("squares", "triangles")
"""Mesh patterns: bilinear squares, and unstructured linear triangles."""
MOST_ELEMENTS = 10_000_000
"""Largest mesh accepted; putting its matrix together takes about 35 gigabytes."""


@dataclass(frozen=True)
class Blocks:
    """The rectangle of elements of the upper block, whose mirror image is the lower one.

    It covers -left*size <= x <= right*size, 0 <= y <= `far`.  The blocks share no node: each has
    its own slot face (x <= 0), contact face (x >= 0) and edge node (x = 0).

    Parameters
    ----------
    size : float
        Element size h [length].
    left, right, height : int
        Elements left of the edge, right of it, and from the interface to the far side.
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
    pattern: str = "squares"

    def __post_init__(self) -> None:
        checked_word("mesh: the mesh", self.pattern, PATTERNS)
        if not (math.isfinite(self.size) and self.size > 0):
            raise SceneError(f"mesh: the element size must be positive, got {self.size}.")
        if min(self.left, self.right, self.height) < 1:
            raise SceneError(
                "mesh: every side needs at least one element, "
                f"got {self.left} left, {self.right} right, {self.height} high."
            )
        if self.elements > MOST_ELEMENTS:
            raise SceneError(
                f"mesh: {shown(self.elements)} elements are more than {MOST_ELEMENTS}; lower "
                "`resolution`, leave snapshots off, or lower `poisson_ratio` or the wave speed of "
                "the lower body."
            )

    @property
    def elements(self) -> int:
        """Number of squares; triangles are about twice as many."""
        return (self.left + self.right) * self.height

    @property
    def nodes(self) -> int:
        """Number of corners of the squares."""
        return (self.left + self.right + 1) * (self.height + 1)

    @property
    def far(self) -> float:
        """Distance of the far side from the interface [length]."""
        return self.size * self.height

    @property
    def sides(self) -> dict[str, int]:
        """Names of the boundaries and the number of element sides on each."""
        return {
            "slot": self.left,
            "contact": self.right,
            "right": self.height,
            "far": self.left + self.right,
            "left": self.height,
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

    far, slot = reach + margin, observed_slot(speed, end_time, full)
    there_and_back = far + (far if full else slot)
    left = far + slot if free_walls else there_and_back / 2
    height = far if full else far / 2
    return Blocks(size, elements(left), elements(far), elements(height), pattern)


def observed_slot(speed: float, end_time: float, full: bool = False) -> float:
    """Return the length of slot next to the edge that no reflection reaches until T [length]."""
    return speed * end_time / (1 if full else 2)
