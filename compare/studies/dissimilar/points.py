"""Growth of waves over contrast and friction, and the frictions at which it begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compare.studies.dissimilar.pairs import NAMED, of_contrast
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.growth import growing_waves
from semianalytic.dissimilar.thresholds import generalised_rayleigh_speed, growth_threshold

CONTRASTS = (1.02, 4.0)
"""Speeds of the lower over the upper body, of the same density and Poisson ratio: beyond 4 the map
is that of a rigid body but for the growth against the slower one, of which 4 has all."""
FRICTIONS = (0.01, 1.25)


@dataclass(frozen=True)
class GrowthPoint:
    """Growth per wavelength [%] of the fastest growing wave that runs with the slower body, and of
    the fastest against it; 0 where none grows."""

    contrast: float
    friction: float
    growth_with: float
    growth_against: float


@dataclass(frozen=True)
class ThresholdPoint:
    """Frictions above which waves grow that run with and against the slower body, and the speed of
    the generalised Rayleigh wave over c_t of the slower body (nan: none)."""

    contrast: float
    threshold_with: float
    threshold_against: float
    rayleigh_speed: float


@dataclass(frozen=True)
class NamedPoint:
    """The fastest growing wave of a named pair at one friction: growth per wavelength [%], and
    velocity over c_t of the upper body, positive with that body's slip; nan where none grows."""

    pair: str
    friction: float
    growth: float
    velocity: float


def contrasts(size: int) -> list[float]:
    """Return the contrasts of the columns of a map."""
    return np.geomspace(*CONTRASTS, size).tolist()


def frictions(size: int) -> list[float]:
    """Return the friction coefficients of the rows of a map."""
    return np.geomspace(*FRICTIONS, size).tolist()


def column(contrast: float, size: int) -> list[GrowthPoint]:
    """One column of the map."""
    compliance = compliance_of(*of_contrast(contrast))
    points = []
    for friction in frictions(size):
        waves = growing_waves(compliance, friction)
        grown = [100 * float(np.expm1(wave.per_wavelength)) for wave in waves]
        ahead = [one for one, wave in zip(grown, waves, strict=True) if wave.velocity > 0]
        behind = [one for one, wave in zip(grown, waves, strict=True) if wave.velocity < 0]
        points.append(
            GrowthPoint(contrast, friction, max(ahead, default=0), max(behind, default=0))
        )
    return points


def threshold_point(contrast: float) -> ThresholdPoint:
    """Thresholds at one contrast."""
    compliance = compliance_of(*of_contrast(contrast))
    return ThresholdPoint(
        contrast,
        float(growth_threshold(compliance, 1)),
        float(growth_threshold(compliance, -1)),
        generalised_rayleigh_speed(compliance) or np.nan,
    )


def named_points(pair: str, values: tuple[float, ...]) -> list[NamedPoint]:
    """One named pair at some frictions."""
    compliance, points = compliance_of(*NAMED[pair]), []
    for friction in values:
        waves = growing_waves(compliance, friction)
        growth = 100 * float(np.expm1(waves[0].per_wavelength)) if waves else np.nan
        points.append(NamedPoint(pair, friction, growth, waves[0].velocity if waves else np.nan))
    return points
