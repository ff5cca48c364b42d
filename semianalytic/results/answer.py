"""The questions about the contact that every solver answers, with the same meaning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.datasets import dataset
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.memory import check_memory
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Scene

FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
"""Methods of positions and times."""
TOTALS = ("max_slip", "accumulated_slip", "frictional_work")
"""Methods of times alone."""
Arrival = Literal["slip", "forward", "reverse", "opening"]
"""Events that may reach a position: slip of either sense, slip of one sense, and opening."""
ARRIVALS = get_args(Arrival)


@dataclass(frozen=True)
class SlipInterval:
    """A part of the contact that slips at one time: start < x < end.

    Attributes
    ----------
    start, end : float
        Positions [length]; 0 is the contact edge, inf is slip ahead of all waves, or beyond all
        that was recorded.
    sense : int
        +1 where the upper side slips towards +x, -1 towards -x.

    Examples
    --------
    >>> from semianalytic import solve
    >>> first, second = solve("preloaded").zones_at(1.0)
    >>> first.start, round(first.end, 2), first.sense
    (0.0, 0.88, 1)
    """

    start: float
    end: float
    sense: int


@dataclass(frozen=True)
class OpenInterval:
    """A part of the contact whose sides do not touch at one time: start < x < end.

    Attributes
    ----------
    start, end : float
        Positions [length]; 0 is the contact edge.

    Examples
    --------
    >>> from semianalytic import solve
    >>> (opening,) = solve("tap").openings_at(1.0)
    >>> 0 < opening.start < 1 < opening.end < 2
    True
    """

    start: float
    end: float


class Answer(Protocol):
    """An answer to a scene: slip, tractions, gap and totals of the contact, from any solver.

    Positions x > 0 [length] and times t [time] broadcast; before t = 0 the base state is returned.
    Slip and slip rate are relative, upper minus lower side; tractions include the base, and
    pressure is positive in compression.  All methods raise SceneError for positions off the
    contact, for values that are not finite numbers, and beyond what the answer has recorded.

    Examples
    --------
    >>> from semianalytic import solve
    >>> from semianalytic.results.answer import Answer
    >>> answer: Answer = solve("preloaded")
    >>> round(float(answer.slip_rate(0.1, 1.0)), 3)
    0.771
    >>> answer.pressure([0.1, 0.2], 1.0).tolist()
    [1.0, 1.0]
    """

    @property
    def scene(self) -> Scene:
        """The scene that was asked."""

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip rate [length / time]."""

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip since t = 0 [length]."""

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Shear traction sigma_xy [stress]."""

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Contact pressure [stress], 0 where the contact is open."""

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the opening of the contact [length], 0 where it is closed."""

    def max_slip(self, t: ArrayLike) -> Array:
        """Largest |slip| on the contact at times t [length]."""

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Integral over the contact of the |slip| accumulated until t [length^2]."""

    def frictional_work(self, t: ArrayLike) -> Array:
        """Energy turned to heat on the contact until t, per unit depth [stress length^2]."""

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        """Return the parts that slip at a time, from the contact edge outward.

        There are none before the load.  Open parts move without friction and are not among them.
        """

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        """Return the open parts at a time, from the contact edge outward."""

    def history(self, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        """Return all fields at positions x (n,) and times t (m,)."""

    def to_xarray(self, x: ArrayLike, t: ArrayLike) -> Any:
        """Return fields and totals at positions x (n,) and times t (m,), an `xarray.Dataset`."""


def sampled_history(answer: Answer, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
    """Return all fields at x (n,) [length] and t (m,) [time]; refuse 70 % of the memory."""
    x, t = (np.atleast_1d(np.asarray(samples, dtype=float)) for samples in (x, t))
    # Looking at the memory takes longer than small histories do.
    if x.size * t.size > 100_000:  # so many take a third of a gigabyte
        # 1,800 bytes a point were measured of constant friction, 3,500 of a viscous film.
        check_memory(
            3600 * x.size * t.size,
            None,
            f"history: {x.size:,} positions and {t.size:,} times",
            "ask for fewer of them, or for some times after others",
        )
    return InterfaceHistory(x, t, *(getattr(answer, name)(x, t[:, None]) for name in FIELDS))


def answer_dataset(answer: Answer, x: ArrayLike, t: ArrayLike) -> Any:
    """Return fields and totals of an answer as an `xarray.Dataset` of dimensions t and x.

    `Gridded.to_xarray` describes it.
    """
    history = answer.history(x, t)
    totals = {name: getattr(answer, name)(history.t) for name in TOTALS}
    data = dataset(history.x, history.t, {**history.values, **totals}, answer.scene.units)
    data.attrs["title"] = repr(answer)
    return data


def method_of(answer: object) -> str:
    """Return the method of an answer, as "self-similar"; the name of its class if it says none."""
    return str(getattr(type(answer), "method", type(answer).__name__))
