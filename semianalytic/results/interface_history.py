"""Interface fields sampled on a grid of positions and times: the result all solvers share."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.datasets import dataset
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.errors import SceneError

FORMAT = "slipfront interface history 2"


@asked_in_units
@dataclass(frozen=True, eq=False)
class InterfaceHistory:
    """The fields of the interface, sampled at positions x and times t.

    Attributes
    ----------
    x : (n,) array
        Positions along the interface [length], increasing.
    t : (m,) array
        Times [time], increasing.
    slip, slip_rate : (m, n) arrays
        Relative slip [length] and slip rate [length / time], upper minus lower face.
    shear_traction, pressure : (m, n) arrays
        Total tractions, base included [stress], compressive pressure positive.
    gap : (m, n) array
        Opening of the contact [length], 0 where it is closed, and the change of their width on
        slots.
    mask : (n,) array of bool, optional
        Whether the bodies touch at these positions; without it they touch at all of them.
    state, felt_pressure : (m, n) arrays, optional
        State of friction, nan on slots, and the pressure that friction follows [stress], that of
        the contact unless the law has a delay.

    Examples
    --------
    >>> from semianalytic import solve
    >>> history = solve("preloaded").history(x=[0.25, 0.5], t=[0.5, 1.0, 1.5])
    >>> history.slip_rate.shape
    (3, 2)
    """

    x: Array
    t: Array
    slip: Array
    slip_rate: Array
    shear_traction: Array
    pressure: Array
    gap: Array
    mask: Mask | None = field(default=None, kw_only=True)
    state: Array | None = field(default=None, kw_only=True)
    felt_pressure: Array | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        shape = (len(self.t), len(self.x))
        for name in ("slip", "slip_rate", "shear_traction", "pressure", "gap"):
            if getattr(self, name).shape != shape:
                raise SceneError(
                    f"history: {name} has shape {getattr(self, name).shape}, expected {shape}."
                )

    def __repr__(self) -> str:
        ranges = (
            f"{len(row)} {what}" + (f" from {row.min():.4g} to {row.max():.4g}" if len(row) else "")
            for what, row in (("times", self.t), ("positions", self.x))
        )
        return f"<InterfaceHistory: {', '.join(ranges)}>"

    @property
    def touching(self) -> Mask:
        """Whether the bodies touch, (n,)."""
        return np.ones(len(self.x), dtype=bool) if self.mask is None else self.mask

    def beside(self, x: ArrayLike) -> tuple[Any, Any, Array]:
        """Return the positions of the contact on either side of places, by number, and the share of
        the way from one to the other."""
        left, right, along = between(self.x, np.asarray(x, dtype=float))
        if self.mask is None:
            return left, right, along
        # at the end of a contact one of the two is of the slot, and does not count
        first = self.mask[left] & (along < 1)
        share = np.where(first & self.mask[right], along, 0.0)
        return np.where(first, left, right), right, share

    @property
    def rubbing_rate(self) -> Array:
        """Slip rate where the sides touch, 0 where the contact is open (m, n) [length / time]."""
        return np.where(self.gap > 0, 0.0, self.slip_rate)

    @property
    def values(self) -> dict[str, Array]:
        """Fields by name, (m, n) each; those that there are."""
        named = {known.name: getattr(self, known.name) for known in fields(self)}
        names = named.keys() - {"x", "t", "mask"}
        return {name: value for name, value in named.items() if name in names and value is not None}

    def save(self, path: str | Path) -> None:
        """Write the history as HDF5; the file appears under its name only when it is complete."""
        # Fields ahead of the waves are constant, and half of most histories is ahead of the waves.
        from semianalytic.results.saved import write_answer  # most answers are not saved

        write_answer(path, FORMAT, self, compression=4)

    def to_xarray(self) -> Any:
        """Return the history as an `xarray.Dataset` of dimensions t and x, with units.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        return dataset(self.x, self.t, self.values)

    @classmethod
    def load(cls, path: str | Path) -> InterfaceHistory:
        """Read a history written by `save`.

        Raises
        ------
        DataFileError
            If the file is missing, damaged or not an interface history.
        """
        from semianalytic.results.saved import read_answer

        instead = "a file written by `slipfront simulate`"
        return read_answer(path, FORMAT, cls, instead, "simulate again")


def between(samples: Array, at: Array) -> tuple[Any, Any, Array]:
    """Return the samples on either side, and the fraction of the way from one to the other."""
    after = np.clip(np.searchsorted(samples, at, "right"), 0, len(samples) - 1)
    before = np.maximum(after - 1, 0)
    width = samples[after] - samples[before]
    share = (at - samples[before]) / np.where(width > 0, width, 1.0)
    return before, after, np.clip(share, 0.0, 1.0)
