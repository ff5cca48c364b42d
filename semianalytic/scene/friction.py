"""Friction laws: how much shear traction the interface carries while it slips.

The article knows Coulomb's law with a constant coefficient only; the others go beyond it.
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

    Strength is what the interface carries where it slips, and at most where it sticks.  It depends
    on the scene's friction coefficient times pressure, f p, on the relative slip rate, and on the
    path, the |slip| accumulated so far.
    """

    @abstractmethod
    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Strength [stress]; shapes broadcast.

        Parameters
        ----------
        frictional : the scene's friction coefficient times pressure [stress].
        slip_rate : relative slip rate [length / time], either sign.
        path : accumulated |slip| [length].
        """

    @abstractmethod
    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """|V| at which strength and radiation balance, 0 where it sticks [length / time].

        The root V >= 0 of impedance V = stopping - strength(frictional, V, path), with the path as
        it is before this slip.

        Parameters
        ----------
        stopping : (n,) array
            |traction| that would stop the interface [stress].
        frictional : (n,) array
            Friction coefficient times pressure [stress].
        impedance : float or (n,) array
            Traction that slip takes off per slip rate [stress time / length].
        path : (n,) array
            Accumulated |slip| [length].
        """

    @property
    @abstractmethod
    def fall_with_rate(self) -> float:
        """Largest fall of strength per slip rate, over f p [time / length]; 0 if it never falls."""

    @property
    @abstractmethod
    def fall_with_slip(self) -> float:
        """Largest fall of strength per accumulated slip, over f p [1 / length]; 0 if it never
        falls."""


class RateFriction(FrictionLaw):
    """A law of smooth strength that depends on slip rate alone: fields stay self-similar."""

    fall_with_slip = 0.0

    @abstractmethod
    def rate_slopes(
        self, frictional: ArrayLike, slip_rate: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """Derivatives of strength by f p, by |V|, by both and by |V| twice; arguments as there."""


def _spread(*given: ArrayLike) -> list[Array]:
    """Arguments of one law at one shape."""
    return list(np.broadcast_arrays(*(np.asarray(one, dtype=float) for one in given)))


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
    """Constant friction: strength f p."""

    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """See `FrictionLaw.strength`."""
        return _spread(frictional, slip_rate, path)[0].copy()

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """See `FrictionLaw.slip_speed`."""
        return np.asarray(np.maximum(stopping - frictional, 0.0) / impedance)

    fall_with_rate = 0.0
    fall_with_slip = 0.0


@dataclass(frozen=True)
class ViscousFriction(RateFriction):
    """A viscous film beside friction: strength f p + viscosity |V|.

    Parameters
    ----------
    viscosity : traction per relative slip rate [stress time / length], >= 0; over rho c_t / 2 it is
        what the film takes for what a plane shear wave takes.

    Raises
    ------
    SceneError
        If the viscosity is negative or not finite.
    """

    viscosity: float

    def __post_init__(self) -> None:
        viscosity = checked_number(
            "viscous friction: viscosity",
            self.viscosity,
            "be a finite number, 0 or more",
            lambda given: given >= 0,
        )
        object.__setattr__(self, "viscosity", viscosity)

    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """See `FrictionLaw.strength`."""
        dry, speed, _ = _spread(frictional, slip_rate, path)
        return np.asarray(dry + self.viscosity * np.abs(speed))

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """See `FrictionLaw.slip_speed`."""
        resistance = np.asarray(impedance) + self.viscosity
        return np.asarray(np.maximum(stopping - frictional, 0.0) / resistance)

    def rate_slopes(
        self, frictional: ArrayLike, slip_rate: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """See `RateFriction.rate_slopes`."""
        none = np.zeros_like(_spread(frictional, slip_rate)[0])
        return none + 1, none + self.viscosity, none, none

    fall_with_rate = 0.0


@dataclass(frozen=True)
class RateWeakening(RateFriction):
    """Friction falling with slip rate: strength f p (1 - reduction |V| / (|V| + rate)).

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

    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """See `FrictionLaw.strength`."""
        dry, slip_rate, _ = _spread(frictional, slip_rate, path)
        speed = np.abs(slip_rate)
        return np.asarray(dry * (1 - self.reduction * speed / (speed + self.rate)))

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """See `FrictionLaw.slip_speed`; the root of a quadratic."""
        excess = stopping - frictional
        knee = np.asarray(impedance) * self.rate
        linear = excess + self.reduction * frictional - knee
        root = np.sqrt(np.maximum(linear**2 + 4 * knee * excess, 0.0))
        return np.asarray(np.where(excess > 0, (linear + root) / 2, 0.0) / impedance)

    def rate_slopes(
        self, frictional: ArrayLike, slip_rate: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """See `RateFriction.rate_slopes`."""
        dry, slip_rate = _spread(frictional, slip_rate)
        above = np.abs(slip_rate) + self.rate
        first = -self.reduction * self.rate / np.square(above)
        lost = self.reduction * (1 - self.rate / above)
        return np.asarray(1 - lost), dry * first, first, -2 * dry * first / above

    @property
    def fall_with_rate(self) -> float:
        """See `FrictionLaw.fall_with_rate`; the fall at rest, where it is steepest."""
        return self.reduction / self.rate


@dataclass(frozen=True)
class SlipWeakening(FrictionLaw):
    """Friction falling linearly with accumulated slip: f p (1 - reduction min(path/distance, 1)).

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

    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """See `FrictionLaw.strength`."""
        dry, _, path = _spread(frictional, slip_rate, path)
        return np.asarray(dry * (1 - self.reduction * np.minimum(path / self.distance, 1.0)))

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """See `FrictionLaw.slip_speed`."""
        weakened = self.strength(frictional, 0.0, path)
        return np.asarray(np.maximum(stopping - weakened, 0.0) / impedance)

    fall_with_rate = 0.0

    @property
    def fall_with_slip(self) -> float:
        """See `FrictionLaw.fall_with_slip`."""
        return self.reduction / self.distance
