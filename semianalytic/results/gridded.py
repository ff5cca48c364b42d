"""Answers on a grid of positions and times, which all solvers give in the same way."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from semianalytic.results.answer import ContactFields, answer_dataset, sampled_history
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.quantities import asked_in_units


@asked_in_units
class Gridded:
    """An answer that is asked for all its fields at many positions and times at once."""

    def history(self: ContactFields, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        """Return all fields at positions x (n,) and times t (m,); raises like `slip_rate`."""
        return sampled_history(self, x, t)

    def to_xarray(self: ContactFields, x: ArrayLike, t: ArrayLike) -> Any:
        """Return fields and totals at positions x (n,) and times t (m,) as an `xarray.Dataset`.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        SceneError
            If a position or time is one that `slip_rate` refuses.
        """
        return answer_dataset(self, x, t)
