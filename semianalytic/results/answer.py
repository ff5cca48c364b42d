"""What every solver answers: the same questions about the contact, with the same meaning."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.datasets import dataset
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]

FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
"""Methods of positions and times."""
TOTALS = ("max_slip", "accumulated_slip", "frictional_work")
"""Methods of times alone."""


@dataclass(frozen=True)
class SlipInterval:
    """Part of the contact that slips at one time: start < x < end.

    Attributes
    ----------
    start, end : float
        Positions [length]; 0 is the contact edge, inf is slip ahead of all waves, or beyond all
        that was recorded.
    sense : int
        +1 where the upper side slips towards +x, -1 towards -x.
    """

    start: float
    end: float
    sense: int


@dataclass(frozen=True)
class OpenInterval:
    """Part of the contact whose sides do not touch at one time: start < x < end.

    Attributes
    ----------
    start, end : float
        Positions [length]; 0 is the contact edge.
    """

    start: float
    end: float


def digits_apart(edges: Iterable[float], least: int, form: Literal["f", "g"] = "g") -> int:
    """Digits with which edges that differ are shown as different, and distances to two digits.

    Strips about the Rayleigh front, of reverse slip without friction or of stick with little of
    it, may be narrower than 1e-12 of its speed, and would else be shown as if they were empty.

    Parameters
    ----------
    edges : iterable of float
        Velocities or positions; infinite ones are left out, and what agrees to 15 significant
        digits is taken to be the same.
    least : int
        How many digits at least.
    form : str
        Whether digits are significant ones ("g") or those after the point ("f").
    """
    different = {float(f"{edge:.15g}") for edge in edges if math.isfinite(edge)}
    for digits in range(least, 17):
        if len({f"{one:.{digits}{form}}" for one in different}) == len(different):
            return digits if digits == least else digits + 1
    return 17


class Answer(Protocol):
    """What slips when, how fast and which way, and what it takes.

    Positions x > 0 [length] and times t [time] broadcast; before t = 0 there is the base state.
    Slip and slip rate are relative, upper minus lower side; tractions are the whole ones, base
    included, pressure positive in compression.  All methods raise a SceneError for positions off
    the contact, for what is not a finite number, and beyond what an answer has recorded.
    """

    @property
    def scene(self) -> Scene:
        """The scene that was asked."""
        ...

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip rate [length / time]."""
        ...

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip since t = 0 [length]."""
        ...

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Shear traction sigma_xy [stress]."""
        ...

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Contact pressure [stress], 0 where the contact is open."""
        ...

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """How far the contact is open [length], 0 where it is closed."""
        ...

    def max_slip(self, t: ArrayLike) -> Array:
        """Largest |slip| on the contact at times t [length]."""
        ...

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Integral over the contact of the |slip| accumulated until t [length^2]."""
        ...

    def frictional_work(self, t: ArrayLike) -> Array:
        """Energy turned to heat on the contact until t, per unit depth [stress length^2]."""
        ...

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        """What slips at a time, from the contact edge outward; nothing until the load comes.

        What is open moves without friction, and is not among it.
        """
        ...

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        """What is open at a time, from the contact edge outward; nothing until the load comes."""
        ...

    def history(self, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        """All fields at positions x (n,) and times t (m,)."""
        ...

    def to_xarray(self, x: ArrayLike, t: ArrayLike) -> Any:
        """All fields and totals at positions x (n,) and times t (m,), an `xarray.Dataset`."""
        ...


@runtime_checkable
class BodyFields(Protocol):
    """What knows how both bodies move and what they carry.

    Positions and times broadcast; y > 0 is the upper body, y < 0 the lower one, 0.0 and -0.0 are
    their faces.  What each returns is said at `Solution`.
    """

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Particle velocity (2, ...), in antiplane shear (3, ...) [length / time]."""
        ...

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Stress (3, ...), in antiplane shear (5, ...), tension positive [stress]."""
        ...

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Displacement since t = 0 (2, ...), in antiplane shear (3, ...) [length]."""
        ...


@runtime_checkable
class WholeFields(Answer, BodyFields, Protocol):
    """An answer that knows the bodies too, not the contact alone."""


def sampled_history(answer: Answer, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
    """All fields of an answer at positions x (n,) [length] and times t (m,) [time]."""
    x, t = (np.atleast_1d(np.asarray(samples, dtype=float)) for samples in (x, t))
    return InterfaceHistory(x, t, *(getattr(answer, name)(x, t[:, None]) for name in FIELDS))


def answer_dataset(answer: Answer, x: ArrayLike, t: ArrayLike) -> Any:
    """Fields and totals of an answer as an `xarray.Dataset` of dimensions t and x.

    Parameters
    ----------
    answer : Answer
    x : (n,) array
        [length].
    t : (m,) array
        [time].

    Raises
    ------
    MissingLibraryError
        If xarray is not installed.
    SceneError
        As the methods of the answer.
    """
    history = answer.history(x, t)
    values = {field.name: getattr(history, field.name) for field in fields(history)}
    totals = {name: getattr(answer, name)(history.t) for name in TOTALS}
    data = dataset(values.pop("x"), values.pop("t"), {**values, **totals})
    data.attrs["title"] = repr(answer)
    return data
