"""How a scene is simulated: the options of a run, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from semianalytic.errors import SceneError

STABLE_RATIO = 1.0
LARGEST_RATIO = 1.5
DEFAULT_PACE = 100
"""Steps between checkpoints."""


@dataclass(frozen=True)
class Settings:
    """Options of a simulation; see `fem.simulate`.

    Raises
    ------
    SceneError
        If one is out of range.
    """

    end_time: float
    resolution: int
    damping: float
    step_ratio: float
    model: str
    element: str
    mesh: str
    every: int
    frames: int

    def __post_init__(self) -> None:
        for name in ("end_time", "damping", "step_ratio"):
            _check_number(name, getattr(self, name))
        if self.end_time <= 0:
            raise SceneError(f"simulate: end_time must be positive, got {self.end_time}.")
        if self.damping < 0:
            raise SceneError(f"simulate: damping must not be negative, got {self.damping}.")
        if not 0 < self.step_ratio <= LARGEST_RATIO:
            raise SceneError(
                f"simulate: step_ratio must be above 0 and at most {LARGEST_RATIO} "
                f"(above {STABLE_RATIO} it is unstable), got {self.step_ratio}."
            )
        for name, least in (("resolution", 8), ("every", 1), ("frames", 1)):
            check_count(name, getattr(self, name), least)
        if self.model not in ("auto", "two-blocks"):
            raise SceneError(f"simulate: model must be 'auto' or 'two-blocks', got {self.model!r}.")


@dataclass(frozen=True)
class Pace:
    """How often checkpoints are written: after so many steps or seconds, whichever comes first.

    Raises
    ------
    SceneError
        If one is out of range.
    """

    steps: int | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.steps is not None:
            check_count("checkpoint_every", self.steps, 1)
        elif self.seconds is None:
            object.__setattr__(self, "steps", DEFAULT_PACE)
        if self.seconds is not None:
            _check_number("checkpoint_seconds", self.seconds)
            if self.seconds <= 0:
                raise SceneError(
                    f"simulate: checkpoint_seconds must be positive, got {self.seconds}."
                )


def _check_number(name: str, value: float) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise SceneError(f"simulate: {name} must be a finite number, got {value!r}.")


def check_count(name: str, value: int, least: int) -> None:
    """Raise a SceneError unless an option is an integer of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise SceneError(f"simulate: {name} must be an integer of at least {least}, got {value!r}.")
