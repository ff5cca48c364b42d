"""How a scene is simulated: the options of a run, checked."""

from __future__ import annotations

from dataclasses import dataclass

from semianalytic.scene.checks import checked_count, checked_number, checked_size
from semianalytic.scene.errors import SceneError

LEAST_RESOLUTION = 8
STABLE_RATIO = 1.0
LARGEST_RATIO = 1.5
LARGEST_DAMPING = 100.0
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
        object.__setattr__(self, "end_time", checked_size("simulate: end_time", self.end_time))
        for name in ("damping", "step_ratio"):
            object.__setattr__(self, name, checked_number(f"simulate: {name}", getattr(self, name)))
        if not 0 <= self.damping <= LARGEST_DAMPING:
            raise SceneError(
                f"simulate: damping must lie between 0 and {LARGEST_DAMPING:g}, got {self.damping}."
            )
        if not 0 < self.step_ratio <= LARGEST_RATIO:
            raise SceneError(
                f"simulate: step_ratio must be above 0 and at most {LARGEST_RATIO} "
                f"(above {STABLE_RATIO} it is unstable), got {self.step_ratio}."
            )
        for name, least in (("resolution", LEAST_RESOLUTION), ("every", 1), ("frames", 1)):
            object.__setattr__(self, name, check_count(name, getattr(self, name), least))
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
            object.__setattr__(self, "steps", check_count("checkpoint_every", self.steps, 1))
        elif self.seconds is None:
            object.__setattr__(self, "steps", DEFAULT_PACE)
        if self.seconds is not None:
            seconds = checked_size("simulate: checkpoint_seconds", self.seconds)
            object.__setattr__(self, "seconds", seconds)


def check_count(name: str, value: int, least: int) -> int:
    """An option as int; SceneError unless it is an integer of at least `least`."""
    return checked_count(f"simulate: {name}", value, least, "an integer of at least")
