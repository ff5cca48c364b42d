"""Priors: probability densities of what is known of a parameter before the data."""

from __future__ import annotations

import math
from dataclasses import dataclass

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.checks import check_fields, checked_number, checked_size
from semianalytic.scene.errors import SceneError

_SPREAD = 3.0
"""Number of standard deviations within which a search looks."""


@checking_methods
@dataclass(frozen=True)
class Normal:
    """A parameter known as `mean` ± `sd`, with a normal density.

    Parameters
    ----------
    mean : float
        Expected value, in the unit of the parameter.
    sd : float
        Standard deviation, positive.

    Raises
    ------
    SceneError
        If one is not finite, or the standard deviation not positive.

    Examples
    --------
    >>> from semianalytic import Normal
    >>> Normal(mean=0.5, sd=0.25).misfit(1.0)  # in standard deviations, and its derivative
    (2.0, 4.0)
    """

    mean: float
    sd: float

    def __post_init__(self) -> None:
        check_fields(self, "normal prior", ("mean",))
        check_fields(self, "normal prior", ("sd",), checked_size)

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest value that a search considers."""
        return self.mean - _SPREAD * self.sd, self.mean + _SPREAD * self.sd

    def misfit(self, value: float) -> tuple[float, float]:
        """Return the distance of a value from the mean divided by the standard deviation, and its
        derivative.
        """
        return (value - self.mean) / self.sd, 1 / self.sd

    def log_density(self, value: float) -> float:
        """Return the logarithm of the density at a value, up to a constant."""
        return -(self.misfit(value)[0] ** 2) / 2


@checking_methods
@dataclass(frozen=True)
class LogNormal:
    """A positive parameter known within a factor: its logarithm is normal.

    Parameters
    ----------
    median : float
        Median, in the unit of the parameter, positive.
    factor : float
        Factor above 1; two thirds of the values lie between median / factor and median * factor.

    Raises
    ------
    SceneError
        If the median is not positive, or the factor not above 1.

    Examples
    --------
    >>> from semianalytic import LogNormal
    >>> round(LogNormal(median=1e9, factor=2.0).misfit(4e9)[0], 6)  # in standard deviations
    2.0
    """

    median: float
    factor: float

    def __post_init__(self) -> None:
        owner, above = "lognormal prior", (checked_number, "be above 1", lambda given: given > 1)
        check_fields(self, owner, ("median",), checked_size)
        check_fields(self, owner, ("factor",), *above)

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest value that a search considers."""
        # Three standard deviations of the logarithm.
        most = self.factor**_SPREAD
        return self.median / most, self.median * most

    def misfit(self, value: float) -> tuple[float, float]:
        """Return the distance of the logarithm from its mean divided by its standard deviation, and
        the derivative with respect to the value.
        """
        if value <= 0:
            return math.inf, math.inf
        size = math.log(self.factor)
        return math.log(value / self.median) / size, 1 / (value * size)

    def log_density(self, value: float) -> float:
        """Return the logarithm of the density at a value, up to a constant."""
        if value <= 0:
            return -math.inf
        # The last term is the Jacobian of the logarithm; the misfit of least squares lacks it, so
        # that `fit` finds the most probable logarithm.
        return -(self.misfit(value)[0] ** 2) / 2 - math.log(value)


@checking_methods
@dataclass(frozen=True)
class Uniform:
    """A parameter that lies between `low` and `high`, with a uniform density.

    Parameters
    ----------
    low, high : float
        Least and largest value, in the unit of the parameter.

    Raises
    ------
    SceneError
        If they are not finite, or not in this order.

    Examples
    --------
    >>> from semianalytic import Uniform
    >>> Uniform(low=0.1, high=0.6).range
    (0.1, 0.6)
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        check_fields(self, "uniform prior", ("low", "high"))
        if self.low >= self.high:
            raise SceneError(f"uniform prior: low must be below high, got {self.low}, {self.high}.")

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest value that a search considers."""
        return self.low, self.high

    def log_density(self, value: float) -> float:
        """Return the logarithm of the density at a value, up to a constant."""
        return 0.0 if self.low <= value <= self.high else -math.inf


Prior = Normal | LogNormal | Uniform
