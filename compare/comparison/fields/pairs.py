"""Components of a frame, simulated and predicted, and their norms over the bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from compare.comparison.fields.frames import Frame, Places
from compare.comparison.measures import NOTHING
from compare.output.field_files import resolved
from semianalytic.results.gridded import AnswerInBodies
from semianalytic.scene.arrays import Array, Mask

SAMPLED = 60_000
"""Largest number of nodes or elements at which displacement and stress are compared.

They are drawn at random.  Of 190,000 nodes that gives errors within 3 %, 20,000 within 5 %.
"""


@dataclass(frozen=True, eq=False)
class Pair:
    """One component of a frame, simulated and predicted."""

    name: str
    places: Places
    # (m,) arrays: values in the units of the scene; stresses are changes since t = 0
    simulated: Array
    predicted: Array


def frame_pairs(fields: AnswerInBodies, frames: Sequence[Frame]) -> list[dict[str, Pair]]:
    """Return all components of each frame with the prediction there, by name.

    The prediction is evaluated once for all frames.  Displacement and stress are compared at
    `SAMPLED` nodes and elements of a frame at most.  A mesh made for snapshots is so large that
    nothing comes back from its sides, which fix the displacement that plane waves do not have
    (`meshes.blocks.causal_blocks`).
    """
    base = fields.stress(0.0, 1.0, 0.0)[:, None]
    few = [frame.thinned(SAMPLED) for frame in frames]
    kinds = {
        "v": (fields.velocity, [frame.nodes for frame in frames]),
        "u": (fields.displacement, [frame.nodes for frame in few]),
        "sigma": (fields.stress, [frame.elements for frame in few]),
    }
    pairs: list[dict[str, Pair]] = [{} for _ in frames]
    for kind, (field, seen) in kinds.items():
        counts = [len(places.x) for places in seen]
        x, y = (np.concatenate([getattr(places, name) for places in seen]) for name in "xy")
        y = resolved(fields, y) if kind == "sigma" else y
        rows = field(x, y, np.repeat([frame.time for frame in frames], counts))
        own = np.split(rows, np.cumsum(counts)[:-1], axis=1)
        for places, predicted, found in zip(seen, own, pairs, strict=True):
            names = [name for name in places.fields if name.startswith(kind)]
            levels = base if kind == "sigma" else np.zeros((len(names), 1))
            for name, row, level in zip(names, predicted, levels, strict=True):
                found[name] = Pair(name, places, places.fields[name] - level, row - level)
    return pairs


class Norms(NamedTuple):
    """L1 norms of a component: the one that errors are relative to, which is that of the prediction
    or, where that vanishes, of the largest component of the same field, and those of both answers
    and of their difference."""

    size: float
    predicted: float
    simulated: float
    off: float


def norms_of(pairs: Mapping[str, Pair], kept: Callable[[Places], Mask]) -> dict[str, Norms]:
    """Return the norms of all components at the places of a mask, by name."""
    masks = {id(pair.places): kept(pair.places) for pair in pairs.values()}
    norms = {}
    for name, pair in pairs.items():
        fields = pair.predicted, pair.simulated, pair.simulated - pair.predicted
        mask = masks[id(pair.places)]
        norms[name] = [area_norm(values, pair.places.area, mask) for values in fields]
    found = {}
    for name, (predicted, simulated, off) in norms.items():
        largest = max(norms[other][0] for other in norms if alike(name, other))
        size = predicted if predicted > NOTHING * largest else largest
        found[name] = Norms(size, predicted, simulated, off)
    return found


def area_norm(values: Array, area: Array, kept: Mask) -> float:
    """L1 norm of values at the kept places where they are finite: a prediction may be infinite at
    a place, or a mesh may not reach it."""
    kept = kept & np.isfinite(values)
    return float(np.sum(np.abs(values[kept]) * area[kept]))


def alike(name: str, other: str) -> bool:
    """Whether two components belong to one field."""
    return name.partition("_")[0] == other.partition("_")[0]
