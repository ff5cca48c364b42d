"""A row of a comparison: two values, their unit, a tolerance and where that comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import NOTHING, norm, relative_error

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

EDGE_CELLS = 4
ZONE_CELLS = 2
"""Elements by which zone edges may be off."""

NO_SLIP = "no slip: the simulation sticks exactly, rounding is below 1e-6 × 2 τ₀ / (ρ c_t)"


def shown_number(value: float | None, digits: int = 4) -> str:
    """Some significant digits of any size, a dash for nothing."""
    if value is None:
        return "—"
    return "0" if value == 0 else f"{value:#.{digits}g}".rstrip(".")


@dataclass(frozen=True)
class Row:
    """One quantity, predicted and simulated.

    Attributes
    ----------
    quantity : str
        What is compared.
    prediction, simulation : float or None
        The two values in `unit`; None where the signal or zone is not there.
    difference : float or None
        What is held against the tolerance; None if one of the two values is missing.
    tolerance : float
        Largest absolute difference that passes.
    reason : str
        Where the tolerance comes from.
    unit : str
        Of the two values: a reference value of `scales.reference_values`, a unit of the scene, or
        "1" for parts and counts.
    relative : bool
        Whether difference and tolerance are relative to the prediction and not in `unit`.
    """

    quantity: str
    prediction: float | None
    simulation: float | None
    difference: float | None
    tolerance: float
    reason: str
    unit: str = "1"
    relative: bool = False

    @property
    def present(self) -> bool:
        """Whether either answer holds the quantity at all."""
        return self.prediction is not None or self.simulation is not None

    @property
    def passed(self) -> bool:
        """Whether the two agree; so they do on something that is in neither."""
        if self.difference is None:
            return not self.present
        return bool(abs(self.difference) <= self.tolerance)


def comparison_row(
    quantity: str,
    predicted: float | None,
    simulated: float | None,
    tolerance: float,
    reason: str,
    unit: str = "1",
) -> Row:
    """A row whose difference is that of the two values, if both are there."""
    difference = None if predicted is None or simulated is None else simulated - predicted
    return Row(quantity, predicted, simulated, difference, tolerance, reason, unit)


def error_row(
    quantity: str,
    predicted: Array,
    simulated: Array,
    position: Array,
    *,
    tolerance: tuple[float, str],
    unit: str,
    scale: float = 1.0,
    order: int = 1,
    time: Array | None = None,
) -> Row:
    """A row of two norms and the relative error of what they are of.

    Parameters
    ----------
    quantity : str
        Without the norm, which is named behind it.
    predicted, simulated, position, order, time
        As for `measures.norm`.
    tolerance : float and str
        Of the relative error, and where it comes from.
    unit : str
    scale : float
        What the norms are divided by to be in that unit.
    """
    return Row(
        f"{quantity} in L{order}",
        norm(predicted, position, order, time) / scale,
        norm(simulated, position, order, time) / scale,
        relative_error(simulated, predicted, position, order, time),
        *tolerance,
        unit,
        relative=True,
    )


def nothing_row(
    quantity: str, predicted: Array, simulated: Array, scale: float, reason: str, unit: str
) -> Row:
    """A row for a field that is predicted to be nothing (`is_nothing`): largest values over a unit.

    An error relative to the prediction would be infinite or noise; the largest difference over the
    unit is held against 1e-6 instead.

    Parameters
    ----------
    quantity : str
    predicted, simulated : arrays of any one shape
    scale : float
        Value of the unit.
    reason : str
    unit : str
        Its name.
    """

    def largest(values: Array) -> float:
        return float(np.abs(values).max(initial=0.0)) / scale

    return Row(
        f"{quantity}, largest",
        largest(predicted),
        largest(simulated),
        largest(simulated - predicted),
        NOTHING,
        reason,
        unit,
    )


def element_over_length(simulation: Simulation) -> float:
    """Element size over c_t T."""
    speed = simulation.scene.material.shear_speed
    return simulation.element_size / (speed * simulation.end_time)
