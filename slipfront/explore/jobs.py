"""Computations in other processes: fields while a slider moves, marches, maps of regimes."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from semianalytic import Marched, Scene, march, solve
from slipfront.explore.views import (
    SPEED,
    FieldView,
    end_time,
    field_view,
)

Progress = Callable[[int, int], object]

MARCH_POINTS = 40
"""Points across the picture of the field of a march."""
STEPS_TOLD = 50
"""Number of progress reports of a march."""


class Moment(NamedTuple):
    """Time over T of pictures of both bodies, and the name of the quantity that they show."""

    share: float = 1.0
    of: str = SPEED


class MarchViews(NamedTuple):
    """A march, and the field at one moment, whose computation takes as long."""

    marched: Marched
    moment: Moment
    field: FieldView


def solved_field(
    scene: Scene, points: int, rtol: float, moment: Moment, progress: Progress
) -> FieldView:
    """Compute the field of a self-similar scene."""
    return field_view(solve(scene, rtol=rtol), points, *moment)


def marched_field(marched: Marched, moment: Moment, progress: Progress) -> FieldView:
    """Compute the field of a march that is done."""
    return field_view(marched, MARCH_POINTS, *moment)


def marched_views(scene: Scene, moment: Moment, progress: Progress) -> MarchViews:
    """March a scene until T, and compute its field."""

    def tell(done: int, steps: int) -> None:
        if done * STEPS_TOLD // steps != (done - 1) * STEPS_TOLD // steps:
            progress(done, steps)

    marched = march(scene, end_time(scene), progress=tell)
    return MarchViews(marched, moment, field_view(marched, MARCH_POINTS, *moment))
