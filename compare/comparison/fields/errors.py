"""How far simulated fields are from exact ones: relative L1 errors of all components, by frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from compare.comparison.fields.changes import FieldChange, field_changes
from compare.comparison.fields.frames import Frame, last_frame, read_frame
from compare.comparison.fields.fronts import Fronts, fronts_of
from compare.comparison.fields.pairs import Pair, alike, area_norm, frame_pairs
from compare.comparison.measures import NOTHING
from compare.comparison.snapshots import listed_frames
from semianalytic import Scene
from semianalytic.results.answer import Answer, BodyFields

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

BAND = 2.0
"""Elements on either side of a front that make the band around it."""
SEEN_LAST = 1_000_000
SEEN_BEFORE = 5_000
"""Most nodes, and most elements, at which the last frame and each one before it are compared: drawn
at random, so few tell an error in two digits."""


@dataclass(frozen=True)
class FieldError:
    """How far one component of one frame is off.

    Attributes
    ----------
    time : float
        [time].
    component : str
        v_x, ..., u_x, ..., sigma_xx, ...
    whole : float
        L1 norm of the difference over both bodies, over that of the prediction, of stresses the
        change since t = 0; over that of the largest component of the same field where the component
        vanishes.
    outside : float
        The same outside the band of `BAND` elements around all fronts.
    band : float
        Part of the area that is in the band.
    """

    time: float
    component: str
    whole: float
    outside: float
    band: float


@dataclass(frozen=True, eq=False)
class FieldErrors:
    """Errors of all frames, and the last one itself.

    Attributes
    ----------
    element_size : float
        [length].
    frames : tuple of tuples of FieldError
        In the order of time.
    last : dict of Pair
        Of the last frame, by the name of the component.
    changes : tuple of FieldChange
        What its components change by from mesh to mesh, from which error bars come.
    """

    element_size: float
    frames: tuple[tuple[FieldError, ...], ...]
    last: dict[str, Pair]
    changes: tuple[FieldChange, ...]

    @property
    def rows(self) -> tuple[FieldError, ...]:
        """Of all frames."""
        return tuple(chain.from_iterable(self.frames))


def field_errors(
    prediction: Answer,
    simulation: Simulation,
    folder: Path,
    progress: Callable[[int, int], None] | None = None,
) -> FieldErrors | None:
    """Hold all frames of a simulation against a prediction; None if it knows the contact alone.

    The last one is compared with that of its companions too, if they were kept.

    Parameters
    ----------
    prediction : Answer
    simulation : Simulation
    folder : Path
        Of its snapshots.
    progress : callable, optional
        Called with (frame, frames) after each.

    Raises
    ------
    DataFileError
        If the frames cannot be read or are of another run.
    """
    if not isinstance(prediction, BodyFields):
        return None
    scene, size = simulation.scene, simulation.element_size
    fronts = fronts_in(prediction, scene)
    listed = listed_frames(folder, simulation.run)
    frames: list[tuple[FieldError, ...]] = []
    for number, entry in enumerate(listed, start=1):
        frame = read_frame(*entry)
        most = SEEN_LAST if number == len(listed) else SEEN_BEFORE
        pairs = frame_pairs(prediction, frame, most)
        frames.append(tuple(pair_errors(pairs, fronts, frame.time, BAND * size)))
        if progress is not None:
            progress(number, len(listed))
    meshes = [(size, frame), *companion_frames(simulation, folder)]
    width = BAND * max(cell for cell, _ in meshes)

    def predict(coarser: Frame) -> dict[str, Pair]:
        return frame_pairs(prediction, coarser, SEEN_LAST)

    changes = field_changes(pairs, [mesh for _, mesh in meshes], fronts, width, predict)
    return FieldErrors(size, tuple(frames), pairs, changes)


def companion_frames(simulation: Simulation, folder: Path) -> list[tuple[float, Frame]]:
    """Element sizes [length] and last frames of the companions of a simulation, finest first, as
    far as they were kept.

    Raises
    ------
    DataFileError
        If one that was kept cannot be read.
    """
    from fem.snapshots import companion_folder, index_run

    frames: list[tuple[float, Frame]] = []
    run = simulation.companion
    while run is not None:
        place = companion_folder(folder, len(frames) + 1)
        if index_run(place) != run.run:
            break
        frames.append((run.element_size, last_frame(place, run.run)))
        run = run.companion
    return frames


def pair_errors(
    pairs: dict[str, Pair], fronts: Fronts, time: float, width: float
) -> Iterator[FieldError]:
    """Errors of all components of a frame.

    Parameters
    ----------
    pairs : dict of Pair
    fronts : Fronts
    time : float
        [time].
    width : float
        Of the band on either side of a front [length].
    """
    beyond = {
        id(places): fronts.distance(places.x, places.y, time) > width
        for places in (pair.places for pair in pairs.values())
    }
    everywhere = {key: np.ones(kept.shape, dtype=bool) for key, kept in beyond.items()}
    whole, outside = _relative(pairs, everywhere), _relative(pairs, beyond)
    for name, pair in pairs.items():
        area, kept = pair.places.area, beyond[id(pair.places)]
        band = float(area[~kept].sum() / area.sum())
        yield FieldError(time, name, whole[name], outside[name], band)


def _relative(pairs: dict[str, Pair], kept: dict[int, NDArray[np.bool_]]) -> dict[str, float]:
    """L1 errors over the norms of the prediction, at the places that are kept."""
    chosen = {name: kept[id(pair.places)] for name, pair in pairs.items()}
    sizes = {
        name: area_norm(pair.predicted, pair.places.area, chosen[name])
        for name, pair in pairs.items()
    }
    errors = {}
    for name, pair in pairs.items():
        largest = max(sizes[other] for other in pairs if alike(name, other))
        size = sizes[name] if sizes[name] > NOTHING * largest else largest
        off = area_norm(pair.simulated - pair.predicted, pair.places.area, chosen[name])
        errors[name] = off / size if size else np.inf if off else 0.0
    return errors


def fronts_in(prediction: Answer, scene: Scene) -> Fronts:
    """The fronts of a scene, with those of the zones and openings that a prediction has."""
    parts = (*getattr(prediction, "zones", ()), *getattr(prediction, "openings", ()))
    return fronts_of(scene, [edge for part in parts for edge in (part.inner, part.outer)])
