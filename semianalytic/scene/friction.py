"""Friction laws: how much shear traction the interface carries while it slips.

The article treats Coulomb's law with a constant coefficient only; the other laws go beyond it
(docs/rate.md; docs/spacetime.md, "Friction laws").
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.checks import checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.quantities import with_quantities

Array = NDArray[np.float64]

_STOPPED = (1.2, 2.0, 5.0)
"""Tractions over friction times pressure at which a law is tried."""


class FrictionLaw(ABC):
    """The interface that every friction law implements; a law must define all abstract methods.

    The strength is the shear traction that the interface carries where it slips, and the most that
    it carries where it sticks.  It depends on the scene's friction coefficient times pressure, f p,
    on the relative slip rate, and on the path, the |slip| accumulated so far.  docs/extending.md
    shows how to write a law of your own.

    Examples
    --------
    >>> from semianalytic import FrictionLaw, SlipWeakening
    >>> law = SlipWeakening(reduction=0.5, distance=0.1)
    >>> isinstance(law, FrictionLaw)
    True
    >>> law.strength(1.0, 0.0, [0.0, 0.05, 0.2]).tolist()
    [1.0, 0.75, 0.5]
    """

    @abstractmethod
    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Return the strength [stress]; the shapes of the arguments broadcast.

        Parameters
        ----------
        frictional : array
            The scene's friction coefficient times pressure [stress].
        slip_rate : array
            Relative slip rate [length / time], of either sign.
        path : array
            Accumulated |slip| [length].
        """

    @abstractmethod
    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """Return the |V| at which strength and radiation balance, 0 where the interface sticks.

        It is the root V >= 0 [length / time] of impedance V = stopping - strength(frictional, V,
        path), with the path as it is before this slip.

        Parameters
        ----------
        stopping : (n,) array
            Absolute value of the traction that would stop the interface [stress].
        frictional : (n,) array
            Friction coefficient times pressure [stress].
        impedance : float or (n,) array
            Traction that slip releases per slip rate [stress time / length].
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
        """Largest fall of strength per accumulated slip, over f p [1 / length].

        It is 0 if the strength never falls with slip.
        """


class RateFriction(FrictionLaw):
    """A friction law whose strength is a smooth function of pressure and slip rate alone.

    Under step loads the fields stay self-similar (docs/rate.md).

    Examples
    --------
    >>> from semianalytic import RateFriction, RateWeakening, SlipWeakening
    >>> isinstance(RateWeakening(0.5, 1.0), RateFriction)
    True
    >>> isinstance(SlipWeakening(0.5, 1.0), RateFriction)
    False
    """

    fall_with_slip = 0.0

    @abstractmethod
    def rate_slopes(
        self, frictional: ArrayLike, slip_rate: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives of strength by f p, by |V|, by both and by |V| twice.

        Arguments are those of `FrictionLaw.strength`.
        """


def check_balance(law: FrictionLaw, frictional: float, impedance: float) -> None:
    """Raise SceneError unless the slip rate of a law balances its own strength.

    The laws of this package do; this one is for those of other packages.

    Parameters
    ----------
    law : FrictionLaw
    frictional : float
        Friction coefficient times pressure [stress], positive.
    impedance : float
        Traction that slip releases per slip rate [stress time / length].
    """
    size, path = np.full(len(_STOPPED), frictional), np.zeros(len(_STOPPED))
    stopping = frictional * np.array(_STOPPED)
    speed = np.asarray(law.slip_speed(stopping, size, impedance, path), dtype=float)
    left = stopping - np.asarray(law.strength(size, speed, path), dtype=float) - impedance * speed
    # Where the interface sticks, strength may exceed the traction; nan is wrong either way.
    off = np.where(speed == 0, np.maximum(left, 0.0), np.abs(left))
    # 1e-3 is far above what the root of any solver misses, and far below a factor left out.
    if not np.all(off <= 1e-3 * stopping):
        raise SceneError(
            f"scene: slip_speed of the friction law {type(law).__name__} must return the slip rate "
            "V >= 0 at which strength(frictional, V, path) + impedance V is the traction that "
            f"stops; for tractions {stopping.tolist()}, frictional {frictional:g} and impedance "
            f"{impedance:g} it returns {speed.tolist()}."
        )


def _spread(*given: ArrayLike) -> list[Array]:
    """Broadcast the arguments of a law to one shape."""
    return list(np.broadcast_arrays(*(np.asarray(one, dtype=float) for one in given)))


def _check(owner: str, law: RateWeakening | SlipWeakening, scale_name: str) -> None:
    """Store the parameters of a law as floats; raise SceneError if one is out of range."""
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
    """Coulomb friction with a constant coefficient: strength f p.

    Examples
    --------
    >>> from semianalytic import CoulombFriction
    >>> CoulombFriction().strength(0.3, [-1.0, 2.0], 0.0).tolist()
    [0.3, 0.3]
    """

    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Return f p; see `FrictionLaw.strength`."""
        return _spread(frictional, slip_rate, path)[0].copy()

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """Return the slip rate of balance; see `FrictionLaw.slip_speed`."""
        return np.asarray(np.maximum(stopping - frictional, 0.0) / impedance)

    fall_with_rate = 0.0
    fall_with_slip = 0.0


@with_quantities
@dataclass(frozen=True)
class ViscousFriction(RateFriction):
    """Friction with a viscous film: strength f p + viscosity |V| (docs/rate.md).

    Parameters
    ----------
    viscosity : float
        Traction per relative slip rate [stress time / length], at least 0.  Its ratio to
        rho c_t / 2 compares the resistance of the film with radiation by plane shear waves.

    Raises
    ------
    SceneError
        If the viscosity is negative or not finite.

    Examples
    --------
    >>> from semianalytic import ViscousFriction
    >>> ViscousFriction(viscosity=0.5).strength(0.25, [0.0, -2.0], 0.0).tolist()
    [0.25, 1.25]
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
        """Return f p + viscosity |V|; see `FrictionLaw.strength`."""
        dry, speed, _ = _spread(frictional, slip_rate, path)
        return np.asarray(dry + self.viscosity * np.abs(speed))

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """Return the slip rate of balance; see `FrictionLaw.slip_speed`."""
        resistance = np.asarray(impedance) + self.viscosity
        return np.asarray(np.maximum(stopping - frictional, 0.0) / resistance)

    def rate_slopes(
        self, frictional: ArrayLike, slip_rate: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives of strength; see `RateFriction.rate_slopes`."""
        none = np.zeros_like(_spread(frictional, slip_rate)[0])
        return none + 1, none + self.viscosity, none, none

    fall_with_rate = 0.0


@with_quantities
@dataclass(frozen=True)
class RateWeakening(RateFriction):
    """Friction that falls with slip rate: strength f p (1 - reduction |V| / (|V| + rate)).

    The law is well posed only while the strength falls more slowly than the radiated traction
    rises, f p reduction / rate < rho c_t / 2; solvers refuse anything steeper.

    Parameters
    ----------
    reduction : float
        Fraction of friction lost at high slip rate, 0 ... 1.
    rate : float
        Slip rate at which half of that is lost [length / time], positive.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> from semianalytic import RateWeakening
    >>> RateWeakening(reduction=0.5, rate=1.0).strength(1.0, [0.0, 1.0, -3.0], 0.0).tolist()
    [1.0, 0.75, 0.625]
    """

    reduction: float
    rate: float

    def __post_init__(self) -> None:
        _check("rate weakening", self, "rate")

    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Return f p (1 - reduction |V| / (|V| + rate)); see `FrictionLaw.strength`."""
        dry, slip_rate, _ = _spread(frictional, slip_rate, path)
        speed = np.abs(slip_rate)
        return np.asarray(dry * (1 - self.reduction * speed / (speed + self.rate)))

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """Return the slip rate of balance; see `FrictionLaw.slip_speed`."""
        # Times (V + rate) the balance is a quadratic for the radiated traction w = impedance V:
        # w^2 - linear w - knee excess = 0, of which this is the root that is positive.
        excess = stopping - frictional
        knee = np.asarray(impedance) * self.rate
        linear = excess + self.reduction * frictional - knee
        root = np.sqrt(np.maximum(linear**2 + 4 * knee * excess, 0.0))
        return np.asarray(np.where(excess > 0, (linear + root) / 2, 0.0) / impedance)

    def rate_slopes(
        self, frictional: ArrayLike, slip_rate: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives of strength; see `RateFriction.rate_slopes`."""
        dry, slip_rate = _spread(frictional, slip_rate)
        above = np.abs(slip_rate) + self.rate
        first = -self.reduction * self.rate / np.square(above)
        lost = self.reduction * (1 - self.rate / above)
        return np.asarray(1 - lost), dry * first, first, -2 * dry * first / above

    @property
    def fall_with_rate(self) -> float:
        """Fall of strength per slip rate at rest, where it is largest, over f p [time / length]."""
        return self.reduction / self.rate


@with_quantities
@dataclass(frozen=True)
class SlipWeakening(FrictionLaw):
    """Friction that falls linearly with slip: strength f p (1 - reduction min(path/distance, 1)).

    The path is the accumulated |slip|.  Slip localises within about mu distance / ((1 - nu) f p
    reduction), which a grid has to resolve.

    Parameters
    ----------
    reduction : float
        Fraction of friction lost after `distance`, 0 ... 1.
    distance : float
        Accumulated |slip| over which it is lost [length], positive.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> from semianalytic import SlipWeakening
    >>> SlipWeakening(reduction=0.5, distance=0.25).strength(1.0, 0.0, [0.125, 0.25, 1.0]).tolist()
    [0.75, 0.5, 0.5]
    """

    reduction: float
    distance: float

    def __post_init__(self) -> None:
        _check("slip weakening", self, "distance")

    def strength(self, frictional: ArrayLike, slip_rate: ArrayLike, path: ArrayLike) -> Array:
        """Return f p (1 - reduction min(path / distance, 1)); see `FrictionLaw.strength`."""
        dry, _, path = _spread(frictional, slip_rate, path)
        return np.asarray(dry * (1 - self.reduction * np.minimum(path / self.distance, 1.0)))

    def slip_speed(
        self, stopping: Array, frictional: Array, impedance: ArrayLike, path: ArrayLike
    ) -> Array:
        """Return the slip rate of balance; see `FrictionLaw.slip_speed`."""
        weakened = self.strength(frictional, 0.0, path)
        return np.asarray(np.maximum(stopping - weakened, 0.0) / impedance)

    fall_with_rate = 0.0

    @property
    def fall_with_slip(self) -> float:
        """Fall of strength per accumulated slip, over f p [1 / length]."""
        return self.reduction / self.distance
