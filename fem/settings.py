"""The settings of a run: its mesh, elements, time step, damping, and what it stores."""

from __future__ import annotations

from dataclasses import dataclass

from semianalytic.scene.checks import check_fields, checked_count, checked_size, checked_word
from semianalytic.scene.errors import SceneError

LEAST_RESOLUTION = 8
"""Fewest node distances per c_t T that a run is made with."""
STABLE_RATIO = 1.0
LARGEST_RATIO = 1.5
"""Time step over the critical one up to which the scheme is stable, and up to which it is run."""
LARGEST_DAMPING = 100.0
"""Largest damping that is accepted, in units of h / c_t."""
COMPANIONS = 2
"""How many coarser runs a simulation carries, each at twice the element size of the one before."""
DEFAULT_PACE = 100
"""Steps between checkpoints."""


@dataclass(frozen=True)
class Settings:
    """Settings of a simulation: mesh, elements, time step and what is stored.

    Parameters
    ----------
    resolution : int
        Node distances per c_t T, at least 8: h = c_t T / resolution.
    damping : float
        eta of the Kelvin-Voigt damping C = eta K, where K is the stiffness matrix, in units of h /
        c_t; 0 for none.
    step_ratio : float
        Largest time step over the critical one, above 0.  Beyond 1 the scheme is unstable; values
        up to 1.5 are accepted so that the instability can be shown.
    model : str
        "auto" uses one block where symmetry allows it, which is exact; "two-blocks" never does.
    mesh : str
        "squares", bilinear, or "triangles", linear on an unstructured mesh; both have a diagonal
        mass matrix.
    every : int
        Store every n-th step in the histories; the last one is always stored.
    frames : int
        Number of snapshots of the whole fields, if any are written, at evenly spaced steps.

    Raises
    ------
    SceneError
        If one is out of range.

    Examples
    --------
    >>> from fem import Settings, simulate
    >>> from semianalytic import find
    >>> settings = Settings(resolution=8, mesh="triangles")
    >>> settings.resolution, settings.every
    (8, 1)
    """

    resolution: int = 100
    damping: float = 0.02
    step_ratio: float = 0.95
    model: str = "auto"
    mesh: str = "squares"
    every: int = 1
    frames: int = 10

    def __post_init__(self) -> None:
        check_fields(self, "simulate", ("damping", "step_ratio"))
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
            what, given = f"simulate: {name}", getattr(self, name)
            count = checked_count(what, given, least, "an integer of at least")
            object.__setattr__(self, name, count)
        checked_word("simulate: model", self.model, ("auto", "two-blocks"))


@dataclass(frozen=True)
class Pace:
    """The interval between checkpoints, in steps or seconds, whichever is shorter; SceneError
    refuses one that is out of range."""

    steps: int | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.steps is not None:
            what = "simulate: checkpoint_every"
            steps = checked_count(what, self.steps, 1, "an integer of at least")
            object.__setattr__(self, "steps", steps)
        elif self.seconds is None:
            object.__setattr__(self, "steps", DEFAULT_PACE)
        if self.seconds is not None:
            seconds = checked_size("simulate: checkpoint_seconds", self.seconds)
            object.__setattr__(self, "seconds", seconds)
