"""Friction laws: what multiplies a scene's friction coefficient while the interface slips.

The article knows Coulomb's law with a constant coefficient only; the other two go beyond it, and
only the space-time solver and the finite elements know them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.checks import checked_number, checked_size

Array = NDArray[np.float64]


def _check(owner: str, law: RateWeakening | SlipWeakening, scale_name: str) -> None:
    """Keep the parameters of a law as floats; raise a SceneError if one is out of range."""
    reduction = checked_number(
        f"{owner}: reduction",
        law.reduction,
        "be a number between 0 and 1",
        lambda given: 0 <= given <= 1,
    )
    object.__setattr__(law, "reduction", reduction)
    scale = checked_size(f"{owner}: {scale_name}", getattr(law, scale_name))
    object.__setattr__(law, scale_name, scale)


@dataclass(frozen=True)
class CoulombFriction:
    """Constant friction: the factor is 1."""

    def factor(self, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Friction over the scene's coefficient; shapes broadcast.

        Parameters
        ----------
        slip_rate : relative slip rate [length / time], either sign.
        path : accumulated |slip| [length].
        """
        return np.ones(np.broadcast_shapes(np.shape(slip_rate), np.shape(path)))


@dataclass(frozen=True)
class RateWeakening:
    """Friction falling with slip rate: factor 1 - reduction |V| / (|V| + rate).

    Well posed only while the strength falls more slowly than the radiated traction rises,
    f p reduction / rate < rho c_t / 2; solvers refuse anything steeper.

    Parameters
    ----------
    reduction : part of friction lost at high slip rate, 0 ... 1.
    rate : slip rate at which half of that is lost [length / time], positive.

    Raises
    ------
    SceneError
        If a parameter is out of range.
    """

    reduction: float
    rate: float

    def __post_init__(self) -> None:
        _check("rate weakening", self, "rate")

    def factor(self, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Friction over the scene's coefficient; parameters as `CoulombFriction.factor`."""
        speed = np.abs(np.asarray(slip_rate, dtype=float)) + 0 * np.asarray(path, dtype=float)
        return 1 - self.reduction * speed / (speed + self.rate)


@dataclass(frozen=True)
class SlipWeakening:
    """Friction falling linearly with accumulated slip: factor 1 - reduction min(path/distance, 1).

    Slip localises within about G distance / ((1 - nu) f p reduction): a grid has to resolve it.

    Parameters
    ----------
    reduction : part of friction lost after `distance`, 0 ... 1.
    distance : accumulated |slip| over which it is lost [length], positive.

    Raises
    ------
    SceneError
        If a parameter is out of range.
    """

    reduction: float
    distance: float

    def __post_init__(self) -> None:
        _check("slip weakening", self, "distance")

    def factor(self, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Friction over the scene's coefficient; parameters as `CoulombFriction.factor`."""
        share = np.asarray(path, dtype=float) / self.distance + 0 * np.asarray(slip_rate, float)
        return 1 - self.reduction * np.minimum(share, 1.0)


FrictionLaw = CoulombFriction | RateWeakening | SlipWeakening
