"""Friction laws: what multiplies a scene's friction coefficient while the interface slips.

The article knows Coulomb's law with a constant coefficient only; the other two go beyond it, and
only the space-time solver and the finite elements know them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.checks import checked_number, checked_size

Array = NDArray[np.float64]


class FrictionLaw(ABC):
    """What a solver asks a friction law; one that leaves an answer out cannot be made.

    Strength is the scene's friction coefficient times pressure; a law multiplies it by a factor
    that may depend on the relative slip rate and on the path, the |slip| accumulated so far.
    """

    @abstractmethod
    def factor(self, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Friction over the scene's coefficient; shapes broadcast.

        Parameters
        ----------
        slip_rate : relative slip rate [length / time], either sign.
        path : accumulated |slip| [length].
        """

    @abstractmethod
    def slip_speed(
        self, stopping: Array, strength: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """|V| at which friction and radiation balance, 0 where it sticks [length / time].

        The root V >= 0 of impedance V = stopping - strength factor(V, path), with the path as it is
        before this slip.

        Parameters
        ----------
        stopping : (n,) array
            |traction| that would stop the interface [stress].
        strength : (n,) array
            Friction coefficient times pressure [stress].
        impedance : float or (n,) array
            Traction that slip takes off per slip rate [stress time / length].
        path : (n,) array
            Accumulated |slip| [length].
        """

    @property
    @abstractmethod
    def fall_with_rate(self) -> float:
        """Largest fall of the factor per slip rate [time / length]; 0 if it does not matter."""

    @property
    @abstractmethod
    def fall_with_slip(self) -> float:
        """Largest fall of the factor per accumulated slip [1 / length]; 0 if it does not matter."""


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
class CoulombFriction(FrictionLaw):
    """Constant friction: the factor is 1."""

    def factor(self, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """See `FrictionLaw.factor`."""
        return np.ones(np.broadcast_shapes(np.shape(slip_rate), np.shape(path)))

    def slip_speed(
        self, stopping: Array, strength: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """See `FrictionLaw.slip_speed`."""
        return np.asarray(np.maximum(stopping - strength, 0.0) / impedance)

    fall_with_rate = 0.0
    fall_with_slip = 0.0


@dataclass(frozen=True)
class RateWeakening(FrictionLaw):
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
        """See `FrictionLaw.factor`."""
        speed = np.abs(np.asarray(slip_rate, dtype=float)) + 0 * np.asarray(path, dtype=float)
        return 1 - self.reduction * speed / (speed + self.rate)

    def slip_speed(
        self, stopping: Array, strength: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """See `FrictionLaw.slip_speed`; the root of a quadratic."""
        excess = stopping - strength
        knee = np.asarray(impedance) * self.rate
        linear = excess + self.reduction * strength - knee
        root = np.sqrt(np.maximum(linear**2 + 4 * knee * excess, 0.0))
        return np.asarray(np.where(excess > 0, (linear + root) / 2, 0.0) / impedance)

    @property
    def fall_with_rate(self) -> float:
        """See `FrictionLaw.fall_with_rate`; the fall at rest, where it is steepest."""
        return self.reduction / self.rate

    fall_with_slip = 0.0


@dataclass(frozen=True)
class SlipWeakening(FrictionLaw):
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
        """See `FrictionLaw.factor`."""
        share = np.asarray(path, dtype=float) / self.distance + 0 * np.asarray(slip_rate, float)
        return 1 - self.reduction * np.minimum(share, 1.0)

    def slip_speed(
        self, stopping: Array, strength: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """See `FrictionLaw.slip_speed`."""
        weakened = strength * self.factor(0.0, path)
        return np.asarray(np.maximum(stopping - weakened, 0.0) / impedance)

    fall_with_rate = 0.0

    @property
    def fall_with_slip(self) -> float:
        """See `FrictionLaw.fall_with_slip`."""
        return self.reduction / self.distance
