"""Interface fields sampled on a grid of positions and times: the result all solvers share."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.datasets import dataset
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.errors import SceneError

FORMAT = "slipfront interface history 2"


@asked_in_units
@dataclass(frozen=True, eq=False)
class InterfaceHistory:
    """The fields of the contact x > 0, sampled at positions x and times t.

    Attributes
    ----------
    x : (n,) array
        Positions along the contact [length], increasing.
    t : (m,) array
        Times [time], increasing.
    slip, slip_rate : (m, n) arrays
        Relative slip [length] and slip rate [length / time], upper minus lower face.
    shear_traction, pressure : (m, n) arrays
        Total tractions, base included [stress], compressive pressure positive.
    gap : (m, n) array
        Opening of the contact [length], 0 where it is closed.

    Examples
    --------
    >>> from semianalytic import solve
    >>> history = solve("preloaded").history(x=[0.25, 0.5], t=[0.5, 1.0, 1.5])
    >>> history.slip_rate.shape
    (3, 2)
    """

    x: NDArray[np.float64]
    t: NDArray[np.float64]
    slip: NDArray[np.float64]
    slip_rate: NDArray[np.float64]
    shear_traction: NDArray[np.float64]
    pressure: NDArray[np.float64]
    gap: NDArray[np.float64]

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
    def rubbing_rate(self) -> NDArray[np.float64]:
        """Slip rate where the sides touch, 0 where the contact is open (m, n) [length / time]."""
        return np.where(self.gap > 0, 0.0, self.slip_rate)

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
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return dataset(values.pop("x"), values.pop("t"), values)

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
