"""Whether friction between two given bodies has an answer, in their units, before any is sought.

Uniform sliding under Coulomb friction is unstable between many pairs: waves along the interface
grow, the shorter the faster, and no computation converges on finer grids (Adams 1995; Ranjith and
Rice 2001).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.delay import fastest_delayed_growth
from semianalytic.dissimilar.growth import growing_waves
from semianalytic.dissimilar.pair import check_contrast
from semianalytic.dissimilar.thresholds import (
    LEAST_FRICTION,
    generalised_rayleigh_speed,
    growth_threshold,
    stoneley_speed,
)
from semianalytic.scene.arguments import checking
from semianalytic.scene.checks import checked_number
from semianalytic.scene.scene import Material


@dataclass(frozen=True)
class SlidingWave:
    """A wave along a sliding interface whose amplitude grows.

    Attributes
    ----------
    growth : float
        Growth rate over wave number [length / time]: a wave of wavelength L grows by a factor of e
        in L / (2 pi growth).
    velocity : float
        Velocity of the crests [length / time], positive in the direction in which the upper body
        slides.
    per_wavelength : float
        Factor by which the amplitude grows while the wave runs one wavelength.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> (wave,) = sa.sliding_stability(gouge, rock, 0.6).waves
    >>> round(wave.velocity), round(wave.per_wavelength, 3)  # in m/s, with the upper body
    (2416, 1.053)
    """

    growth: float
    velocity: float
    per_wavelength: float


@dataclass(frozen=True)
class SlidingStability:
    """Stability of two bodies that slide on one another, known before a scene is solved.

    Attributes
    ----------
    upper, lower : Material
    friction : float
    dundurs : float
        Dundurs' parameter beta, the static coupling of slip and pressure; 0 for identical bodies.
    generalised_rayleigh_speed : float or None
        Speed of the wave along a closed interface without friction [length / time]; where there is
        one, friction is unstable at any coefficient.
    stoneley_speed : float or None
        Speed of the wave along a bonded interface [length / time].
    threshold_with, threshold_against : float
        Friction coefficients above which waves grow that run in the direction in which the upper
        body slides, and in the opposite one; 0 if they grow at every coefficient, inf if at none.
    waves : tuple of SlidingWave
        All waves that grow at this friction, the fastest growing first.
    delayed_growth : float or None
        G: if friction follows pressure with a delay t*, d(sigma')/dt = (sigma - sigma') / t*, no
        wave grows faster than exp(G t / t*), and one does so; None where nothing grows.  A delay
        may let waves grow that decay without it.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> known = sa.sliding_stability(gouge, rock, 0.6)
    >>> known.well_posed, round(known.threshold, 4)
    (False, 0.5314)
    """

    upper: Material
    lower: Material
    friction: float
    dundurs: float
    generalised_rayleigh_speed: float | None
    stoneley_speed: float | None
    threshold_with: float
    threshold_against: float
    waves: tuple[SlidingWave, ...]
    delayed_growth: float | None

    @property
    def well_posed(self) -> bool:
        """Whether no wave grows, so that sliding in either sense is well posed."""
        return not self.waves

    @property
    def threshold(self) -> float:
        """Friction coefficient below which no wave grows, 0 if below 1e-6."""
        # Both directions are there in any sliding: the first to grow decides.
        limit = min(self.threshold_with, self.threshold_against)
        return limit if limit > LEAST_FRICTION else 0.0

    @property
    def verdict(self) -> str:
        """Sentence that says whether waves grow, how fast, and what would prevent it."""
        if self.well_posed:
            bounded = self.threshold < np.inf
            under = f"friction below {self.threshold:.4g}" if bounded else "any friction"
            return f"well posed: no wave grows while these bodies slide under {under}."
        wave = self.waves[0]
        way = "with" if wave.velocity > 0 else "against"
        end = f"lower it below {self.threshold:.3g}" if self.threshold else "no less friction helps"
        sentence = (
            f"ill-posed: waves that run {way} the upper body grow by "
            f"{100 * (wave.per_wavelength - 1):.3g} % over every wavelength, however short; {end}"
        )
        if self.delayed_growth:
            sentence += (
                ", or let friction follow pressure with a delay t*, under which waves grow by a "
                f"factor of e in {1 / self.delayed_growth:.3g} t* at the fastest"
            )
        return f"{sentence}."


@checking
def sliding_stability(upper: Material, lower: Material, friction: float) -> SlidingStability:
    """Return whether and how fast waves grow while two bodies slide under Coulomb friction.

    Parameters
    ----------
    upper, lower : Material
        The solids on y > 0 and y < 0.
    friction : float
        Coulomb friction coefficient f > 0.

    Returns
    -------
    SlidingStability

    Raises
    ------
    SceneError
        If a body is not a `Material`, friction is not positive, or the bodies differ by more than
        1e10 in modulus or density.
    ComputationError
        If fewer growing waves are found than the argument principle counts.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> known = sa.sliding_stability(gouge, rock, 0.4)
    >>> known.verdict
    'well posed: no wave grows while these bodies slide under friction below 0.5314.'
    """
    friction = checked_number(
        "pair: friction", friction, "be positive and finite", lambda given: given > 0
    )
    # There the threshold of a rigid body, 1, still has eight digits.
    check_contrast(upper, lower, 1e10)
    # Everything below is in units of the upper body; speeds alone have to be turned back.
    compliance, unit = compliance_of(upper, lower), upper.shear_speed
    delayed = fastest_delayed_growth(compliance, friction)
    waves = tuple(
        SlidingWave(wave.growth * unit, wave.velocity * unit, float(np.exp(wave.per_wavelength)))
        for wave in growing_waves(compliance, friction)
    )

    def scaled(speed: float | None) -> float | None:
        return None if speed is None else speed * unit

    speeds = scaled(generalised_rayleigh_speed(compliance)), scaled(stoneley_speed(compliance))
    limits = float(growth_threshold(compliance, 1)), float(growth_threshold(compliance, -1))
    bodies = upper, lower, friction, compliance.dundurs
    return SlidingStability(*bodies, *speeds, *limits, waves, delayed.rate if delayed else None)
