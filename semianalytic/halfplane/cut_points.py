"""Points on the branch cut, known by their distances from the wave fronts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CutPoints:
    """Slownesses on the cut: v, v - a, v - b and v - c [b], (4, ...), exact however small."""

    parts: Array

    @property
    def v(self) -> Array:
        """The slownesses v."""
        return self.parts[0]

    @property
    def from_a(self) -> Array:
        """Distances v - a."""
        return self.parts[1]

    @property
    def from_b(self) -> Array:
        """Distances v - b."""
        return self.parts[2]

    @property
    def from_c(self) -> Array:
        """Distances v - c."""
        return self.parts[3]

    def minus(self, other: CutPoints) -> Array:
        """Return the differences from points that lie together, formed at their nearest front."""
        return self.parts[other.nearest] - other.parts[other.nearest]

    @cached_property
    def first(self) -> list[float]:
        """The parts of the first point."""
        flat: list[float] = self.parts.reshape(4, -1)[:, 0].tolist()
        return flat

    @cached_property
    def nearest(self) -> int:
        """The front nearest to the first point: 1 for a, 2 for b, 3 for c."""
        _, *distances = map(abs, self.first)
        return distances.index(min(distances)) + 1

    def first_below(self, other: CutPoints) -> bool:
        """Return whether the first of these points is below the first of others."""
        return self.first[other.nearest] < other.first[other.nearest]

    def __getitem__(self, index: Any) -> CutPoints:
        """Return some of the points."""
        return CutPoints(self.parts[:, index])
