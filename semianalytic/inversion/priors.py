"""What is known of a parameter before the data: small densities."""

from __future__ import annotations

import math
from dataclasses import dataclass

from semianalytic.scene.checks import checked_number, checked_size
from semianalytic.scene.errors import SceneError

_SPREAD = 3.0
"""Standard deviations within which a search looks."""


@dataclass(frozen=True)
class Normal:
    """Known as `mean` ± `sd`, its standard deviation.

    Raises
    ------
    SceneError
        If one is not finite, or the standard deviation not positive.
    """

    mean: float
    sd: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mean", checked_number("normal prior: mean", self.mean))
        object.__setattr__(self, "sd", checked_size("normal prior: sd", self.sd))

    @property
    def range(self) -> tuple[float, float]:
        """Where a search looks."""
        return self.mean - _SPREAD * self.sd, self.mean + _SPREAD * self.sd

    def misfit(self, value: float) -> tuple[float, float]:
        """Standard deviations from the middle, and their derivative."""
        return (value - self.mean) / self.sd, 1 / self.sd

    def log_density(self, value: float) -> float:
        """Of a value, up to a constant."""
        return -(self.misfit(value)[0] ** 2) / 2


@dataclass(frozen=True)
class LogNormal:
    """Positive, known within a factor: its logarithm is normal.

    Parameters
    ----------
    median : float
    factor : float
        Above 1; two thirds lie between median / factor and median times factor.

    Raises
    ------
    SceneError
        If the median is not positive, or the factor not above 1.
    """

    median: float
    factor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "median", checked_size("lognormal prior: median", self.median))
        factor = checked_number(
            "lognormal prior: factor", self.factor, "be above 1", lambda given: given > 1
        )
        object.__setattr__(self, "factor", factor)

    @property
    def range(self) -> tuple[float, float]:
        """Where a search looks."""
        most = self.factor**_SPREAD
        return self.median / most, self.median * most

    def misfit(self, value: float) -> tuple[float, float]:
        """Standard deviations of the logarithm from the middle, and their derivative."""
        if value <= 0:
            return math.inf, math.inf
        size = math.log(self.factor)
        return math.log(value / self.median) / size, 1 / (value * size)

    def log_density(self, value: float) -> float:
        """Of a value, up to a constant."""
        if value <= 0:
            return -math.inf
        return -(self.misfit(value)[0] ** 2) / 2 - math.log(value)


@dataclass(frozen=True)
class Uniform:
    """Anywhere between `low` and `high`, and nowhere else.

    Raises
    ------
    SceneError
        If they are not finite, or not in this order.
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            number = checked_number(f"uniform prior: {name}", getattr(self, name))
            object.__setattr__(self, name, number)
        if self.low >= self.high:
            raise SceneError(f"uniform prior: low must be below high, got {self.low}, {self.high}.")

    @property
    def range(self) -> tuple[float, float]:
        """Where a search looks."""
        return self.low, self.high

    def log_density(self, value: float) -> float:
        """Of a value, up to a constant."""
        return 0.0 if self.low <= value <= self.high else -math.inf


Prior = Normal | LogNormal | Uniform
