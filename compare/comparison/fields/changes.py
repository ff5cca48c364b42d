"""Changes of whole fields from mesh to mesh, and their errors on each mesh."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from compare.comparison.fields.frames import Frame, Places
from compare.comparison.fields.fronts import SceneFronts
from compare.comparison.fields.pairs import Norms, Pair, area_norm, norms_of
from semianalytic.scene.arrays import Array, Mask

PARTS = ("whole", "outside the band")
SAME = 1e-6
"""Part of the mean distance of nodes within which two coordinates are the same."""


@dataclass(frozen=True, eq=False)
class FieldChange:
    """Error and mesh changes of a component of the last frame, whole or without bands at fronts."""

    component: str  # v_x, ..., u_x, ..., sigma_xx, ...
    part: str  # one of `PARTS`
    norms: Norms  # those over the area; for stresses, of the changes since t = 0
    # norms of the changes from the mesh 2h to h, and from 4h to 2h, over `norms.size`, as far as
    # there are frames of these meshes
    changes: tuple[float, ...]
    before: Callable[[], float]  # returns the difference on the mesh 2h, over `norms.size`

    @property
    def difference(self) -> float:
        """Norm of the difference of both answers, over `norms.size`."""
        return self.norms.off / self.norms.size


def field_changes(
    last: dict[str, Pair],
    frames: Sequence[Frame],
    fronts: SceneFronts,
    width: float,
    predict: Callable[[Frame], dict[str, Pair]],
) -> tuple[FieldChange, ...]:
    """Return the changes of all components of the last frame, whole and outside the band.

    The last frame is compared with the prediction, by the name of the component; frames are those
    of the simulation and of its coarser meshes, finest first, which `predict` compares with the
    prediction.  The band of a width [length] is on either side of a front, the same on all meshes.
    """
    time = frames[0].time
    steps = [
        (coarse, {**between(fine.nodes, coarse.nodes), **between(fine.elements, coarse.elements)})
        for fine, coarse in pairwise(frames)
    ]
    found = []
    for part in PARTS:

        def shown(places: Places, part: str = part) -> Mask:
            if part == "whole":
                return np.ones(places.x.shape, dtype=bool)
            return fronts.distance(places.x, places.y, time) > width

        coarse_masks = [
            {id(places): shown(places) for places in (coarse.nodes, coarse.elements)}
            for coarse, _ in steps
        ]
        for name, norms in norms_of(last, shown).items():
            if not norms.size:
                continue
            changes = []
            for (coarse, fine), held in zip(steps, coarse_masks, strict=True):
                places = coarse.nodes if name in coarse.nodes.fields else coarse.elements
                change = fine[name] - places.fields[name]
                changes.append(area_norm(change, places.area, held[id(places)]) / norms.size)

            def before(
                name: str = name,
                size: float = norms.size,
                shown: Callable[[Places], Mask] = shown,
            ) -> float:
                pair = predict(frames[1])[name]
                return norms_of({name: pair}, shown)[name].off / size

            found.append(FieldChange(name, part, norms, tuple(changes), before))
    return tuple(found)


def between(fine: Places, coarse: Places) -> dict[str, Array]:
    """Fields of a mesh at the places of a coarser one, by name; NaN beyond the finer mesh.

    The two bodies are interpolated separately.  Fields are bilinear between nodes that form a grid
    of rows and columns, and else linear in triangles.
    """
    values = {name: np.full(coarse.x.shape, np.nan) for name in fine.fields}
    for side in (1.0, -1.0):
        here, there = (np.copysign(1.0, places.y) == side for places in (fine, coarse))
        at = np.stack([coarse.x[there], np.abs(coarse.y[there])], axis=1)
        x, y = fine.x[here], np.abs(fine.y[here])
        stacked = np.stack([field[here] for field in fine.fields.values()], axis=1)
        for name, found in zip(values, _linear(x, y, stacked)(at).T, strict=True):
            values[name][there] = found
    return values


def _linear(x: Array, y: Array, values: Array) -> Callable[[Array], Array]:
    """Linear interpolation of values (n, k) at points (n,), NaN outside them."""
    columns, rows = _steps(x), _steps(y)
    if len(columns) * len(rows) != len(x):
        return scipy.interpolate.LinearNDInterpolator(np.stack([x, y], axis=1), values)
    order = np.lexsort(
        (y, np.searchsorted(columns, x - float(np.diff(columns).min(initial=np.inf)) / 2))
    )
    grid = values[order].reshape(len(columns), len(rows), -1)
    return scipy.interpolate.RegularGridInterpolator((columns, rows), grid, bounds_error=False)


def _steps(values: Array) -> Array:
    """Distinct values in order; values that differ by rounding alone count as one."""
    ordered = np.unique(values)
    apart = np.diff(ordered) > SAME * np.ptp(ordered) / np.sqrt(len(values))
    return ordered[np.concatenate([[True], apart])]
