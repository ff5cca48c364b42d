"""Errors of simulated fields: relative L1 errors of all components in each frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from compare.comparison.case import companions_of
from compare.comparison.fields.changes import FieldChange, field_changes
from compare.comparison.fields.frames import Frame, last_frame, listed_frames, read_frame
from compare.comparison.fields.fronts import SceneFronts, fronts_of
from compare.comparison.fields.pairs import Pair, frame_pairs, norms_of
from semianalytic import Scene
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.results.answer import Answer
from semianalytic.results.gridded import AnswerInBodies

if TYPE_CHECKING:
    from fem import Simulation


BAND = 2.0
"""Half-width of the band around a front, in elements."""
COARSEST = 4
"""Elements of the coarsest mesh, in elements."""
SEEN_LAST = 1_000_000
SEEN_BEFORE = 5_000
"""Largest numbers of nodes, and of elements, at which the last frame and each earlier one are
compared.  They are drawn at random; that many suffice for two digits of an error."""


@dataclass(frozen=True)
class FieldError:
    """Error of one component of one frame."""

    time: float  # [time]
    component: str  # v_x, ..., u_x, ..., sigma_xx, ...
    # L1 norm of the difference in both bodies, over that of the prediction (for stresses, of the
    # change since t = 0). Where the component vanishes, it is relative to the largest component of
    # the same field.
    whole: float
    # the same error outside the band of `BAND` elements on either side of all fronts
    outside: float
    band: float  # part of the area that is in the band


@dataclass(frozen=True, eq=False)
class FieldErrors:
    """Errors of all frames, and the last frame itself."""

    element_size: float  # [length]
    frames: tuple[tuple[FieldError, ...], ...]  # in the order of time
    last: dict[str, Pair]  # components of the last frame, by name
    # changes of its components from mesh to mesh, from which error bars come
    changes: tuple[FieldChange, ...]

    @property
    def rows(self) -> tuple[FieldError, ...]:
        """Errors of all components of all frames."""
        return tuple(chain.from_iterable(self.frames))


def field_errors(
    prediction: Answer | PairSolution,
    simulation: Simulation,
    folder: Path,
    progress: Callable[[int, int], None] | None = None,
) -> FieldErrors | None:
    """Compare all frames of a simulation in a folder with a prediction; None if it has no fields.

    The last frame is also compared with those of the companions, if they were kept; `progress` is
    called with (frame, frames) after each.  Errors are those of `listed_frames` and `read_frame`.
    """
    scene, size = simulation.scene, simulation.element_size
    # a march follows a load whose front moves over a part of the slot only
    part = bool(scene.front_slowness) and getattr(prediction, "method", "") == "space-time"
    if part or not getattr(prediction, "has_bodies", False):
        return None
    widest = BAND * COARSEST * size / scene.material.shear_speed
    fronts = fronts_in(prediction, scene, shortest=widest)
    listed = listed_frames(folder, simulation.run)
    frames: list[Frame] = []
    mesh, fields = None, cast(AnswerInBodies, prediction)
    for number, entry in enumerate(listed, start=1):
        frame = read_frame(*entry, mesh)
        mesh, frame = frame.mesh, _undisturbed(simulation, frame, size)
        frames.append(frame.thinned(SEEN_LAST if number == len(listed) else SEEN_BEFORE))
        if progress is not None:
            progress(number, len(listed))
    pairs = frame_pairs(fields, frames)
    errors = tuple(
        tuple(pair_errors(found, fronts, moment.time, BAND * size))
        for found, moment in zip(pairs, frames, strict=True)
    )
    coarser = companion_frames(simulation, folder)
    meshes = [
        (size, frame),
        *((cell, _undisturbed(simulation, coarse, cell)) for cell, coarse in coarser),
    ]
    width = BAND * max(cell for cell, _ in meshes)

    def predict(coarser: Frame) -> dict[str, Pair]:
        return frame_pairs(fields, [coarser.thinned(SEEN_LAST)])[0]

    changes = field_changes(pairs[-1], [mesh for _, mesh in meshes], fronts, width, predict)
    return FieldErrors(size, errors, pairs[-1], changes)


def _undisturbed(simulation: Simulation, frame: Frame, size: float) -> Frame:
    """Return the part of a frame, of a mesh of an element size [length], that no side disturbs.

    Nothing comes back from the sides, but the left side is no part of a slot that goes on: it fixes
    what plane waves of identical bodies do not move, and between different bodies it disturbs their
    waves from t = 0 on.  It also disturbs those of a load that moves, from when the load arrives.
    """
    from meshes.blocks import causal_margin  # commands name all that they lack, not meshes alone

    scene = simulation.scene
    alike, slowness = scene.lower_material is None, -scene.front_slowness
    since = frame.time - slowness * -frame.nodes.x.min()
    if since <= 0 or (alike and not slowness):
        return frame
    speed = scene.fastest_speed
    damping_time = simulation.damping * size / scene.material.shear_speed
    return frame.clear_of_left(speed * since + causal_margin(speed, since, size, damping_time))


def companion_frames(simulation: Simulation, folder: Path) -> list[tuple[float, Frame]]:
    """Element sizes [length] and last frames, those that were kept, of the companions of a run,
    finest first.
    """
    from fem.snapshots import companion_folder, index_run

    frames: list[tuple[float, Frame]] = []
    for number, run in enumerate(companions_of(simulation), start=1):
        place = companion_folder(folder, number)
        if index_run(place) != run.run:
            break
        frames.append((run.element_size, last_frame(place, run.run)))
    return frames


def pair_errors(
    pairs: dict[str, Pair], fronts: SceneFronts, time: float, width: float
) -> Iterator[FieldError]:
    """Errors of all components of a frame at a time [time].

    The band of a width [length] is on either side of a front.
    """
    beyond = {
        id(places): fronts.distance(places.x, places.y, time) > width
        for places in (pair.places for pair in pairs.values())
    }
    whole = norms_of(pairs, lambda places: np.ones(places.x.shape, dtype=bool))
    outside = norms_of(pairs, lambda places: beyond[id(places)])
    for name, pair in pairs.items():
        area, kept = pair.places.area, beyond[id(pair.places)]
        off, away = (
            norms.off / norms.size if norms.size else np.inf if norms.off else 0.0
            for norms in (whole[name], outside[name])
        )
        yield FieldError(time, name, off, away, float(area[~kept].sum() / area.sum()))


def fronts_in(
    prediction: Answer | PairSolution, scene: Scene, shortest: float = 0.0
) -> SceneFronts:
    """Fronts of a scene, including those of the zones and openings of a prediction; flanks of loads
    that are shorter than a time count as jumps."""
    parts = (*getattr(prediction, "zones", ()), *getattr(prediction, "openings", ()))
    edges = [edge for part in parts for edge in (part.inner, part.outer)]
    return fronts_of(scene, edges, shortest)
