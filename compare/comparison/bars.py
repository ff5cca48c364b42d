"""Error bars of a simulation, from the same run on coarser meshes.

Roache's grid convergence index with the least that may be assumed of a scheme whose answers have
fronts in them, first order: what changes from a mesh of element size 2h to one of h is what is
still missing at h.  Where a mesh difference is small by chance the one before it, halved, stands
in; the order that the two differences show is told, not used.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

SAFETY: Mapping[str, float] = {
    "arrival": 1.0,
    "zone edge": 0.7,
    "opening edge": 0.7,
    "slip rate": 1.2,
    "slip": 0.7,
    "gap": 0.7,
    "work": 1.0,
    "shear traction": 0.9,
    "pressure": 0.5,
    "onset": 0.7,
    "sense": 0.5,
}
"""Factors of safety by kind of row, set on random scenes and tested on others (docs/judge.md).

Below 1 where the order is above the one that is assumed."""

OPENING = 2.0
OPENING_KINDS = ("slip", "work", "pressure")
"""Times more for what heals behind an opening or is squeezed between its ends: it converges more
slowly than with first order."""

ONE_CHANGE = 2.0
"""Times more where two meshes are all there is, and nothing guards against a small difference."""


def error_bar(kind: str, changes: Sequence[float], ratio: float = 2.0) -> float:
    """How far what a simulation says may be off.

    Parameters
    ----------
    kind : str
        Of the row, a key of `SAFETY`.
    changes : sequence of float
        Differences from the mesh 2h to h, from 4h to 2h where there is such a mesh, ...: norms, or
        differences of one value.
    ratio : float
        Of the element sizes of two meshes.
    """
    largest = max(abs(change) / ratio**step for step, change in enumerate(changes))
    factor = SAFETY[kind] * (ONE_CHANGE if len(changes) == 1 else 1.0)
    return factor * largest / (ratio - 1)


def observed_order(changes: Sequence[float], ratio: float = 2.0) -> float | None:
    """Order of convergence that two mesh differences show; None where they show none."""
    if len(changes) < 2 or not all(changes[:2]):
        return None
    return math.log(abs(changes[1] / changes[0]), ratio)
