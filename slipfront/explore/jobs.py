"""Computations in other processes: fields while a slider moves, marches, maps of regimes."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from semianalytic import Marched, Scene, march, solve
from slipfront.explore.views import (
    FieldView,
    InterfaceView,
    SpaceTimeView,
    end_time,
    field_view,
    interface_view,
    space_time_view,
)

Progress = Callable[[int, int], object]

MARCH_POINTS = 40
"""Points across the picture of the field of a march."""
STEPS_TOLD = 50
"""Number of progress reports of a march."""


class MarchViews(NamedTuple):
    """A march and all its pictures."""

    marched: Marched
    interface: InterfaceView
    space_time: SpaceTimeView
    field: FieldView


def solved_field(scene: Scene, points: int, rtol: float, progress: Progress) -> FieldView:
    """Compute the field of a self-similar scene."""
    return field_view(solve(scene, rtol=rtol), points)


def marched_views(scene: Scene, progress: Progress) -> MarchViews:
    """March a scene until T, and compute everything that is drawn of it."""

    def tell(done: int, steps: int) -> None:
        if done * STEPS_TOLD // steps != (done - 1) * STEPS_TOLD // steps:
            progress(done, steps)

    marched = march(scene, end_time(scene), progress=tell)
    field = field_view(marched, MARCH_POINTS)
    return MarchViews(marched, interface_view(marched), space_time_view(marched), field)
