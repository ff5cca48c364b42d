"""Sources of waves in a half-plane: densities of its surface, and where they are singular."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, cmp_to_key
from itertools import pairwise
from typing import Protocol

import numpy as np

from semianalytic.field import tuning
from semianalytic.field.transform import Centre, Transform
from semianalytic.field.waves import SHEAR, Complex, Slowness, densities, plane_wave, reflected_wave
from semianalytic.halfplane.rayleigh import RayleighFactors
from semianalytic.scene.arrays import Array


class Source(Protocol):
    """The densities of the waves that a surface sends into the upper half-plane, b = mu = 1.

    They are analytic above the real axis of slowness k.
    """

    @property
    def factors(self) -> RayleighFactors:
        """Rayleigh function of the body, in the mode of its waves."""

    @property
    def antiplane(self) -> bool:
        """Whether the waves are those of antiplane shear."""
        return self.factors.mode == "III"

    @property
    def slownesses(self) -> tuple[float, ...]:
        """Slownesses of the waves: a and b, in antiplane shear b."""
        return (1.0,) if self.antiplane else (self.factors.a, 1.0)

    @property
    def kept(self) -> int | None:
        """Row of a density that is kept without integration, if there is one."""
        return None if self.antiplane else SHEAR

    @property
    def front(self) -> float:
        """Slowness p of the front of the load along the slot; 0 unless it comes along it, p > 0."""
        return 0.0

    @property
    def places(self) -> Array:
        """The singular points k on the real axis, (c,), from left to right."""

    @property
    def between(self) -> Array:
        """Distances of singular points from the next ones, (c - 1,), exact however small."""
        return np.diff(self.places)

    @property
    def parting(self) -> int:
        """Index of the singular point that parts what is ahead from what is behind."""

    @property
    def still(self) -> tuple[float, float]:
        """Interval of k around the parting point, in which no wave has come from the edge."""

    @property
    def ahead(self) -> Complex:
        """All integrals left of the parting point, where no wave has come."""

    @property
    def behind(self) -> Complex:
        """All integrals right of the parting point, where no wave has come."""

    @property
    def is_coarse(self) -> bool:
        """Whether the rule has so few digits that polynomials of a lower degree hold them."""

    def densities(self, owners: np.ndarray, offset: Complex) -> Complex:
        """Return all densities (f, c, m) at offsets (c, m) from `places[owners]`."""


def _order(centre: Centre, other: Centre) -> int:
    """Return -1 or 1 if a centre lies left or right of another, however close, or 0."""
    return int(np.sign(other.distance(centre)))


@dataclass(frozen=True)
class LikeBody(Source):
    """The surface of a body that touches one of its own kind, under tractions of one mode."""

    transform: Transform

    @property
    def factors(self) -> RayleighFactors:
        return self.transform.fields.factors

    @cached_property
    def _centres(self) -> list[Centre]:
        fields = self.transform.fields
        factors = fields.factors
        ends = [Centre(-1, end, index) for index, end in enumerate(fields.panels.left)]
        # Slip across c leaves a logarithm at c, which is a centre even though no panel ends there.
        if fields.layout.slips_at_c and all(end.first[3] for end in fields.panels.left):
            ends.append(Centre(-1, factors.front_c))
            ends.sort(key=lambda centre: centre.place, reverse=True)
        right = [*factors.cuts, factors.front_c] if factors.has_rayleigh_wave else [factors.front_b]
        if factors.has_rayleigh_wave:
            right.insert(0, factors.front_a)
        every = [*ends, self._parting, *(Centre(1, point) for point in right)]
        pole = self.transform.pole
        # The pole may coincide with a front or with the end of a panel, which then serves for both.
        if pole is not None and all(centre.distance(pole) != 0.0 for centre in every):
            every.append(pole)
        return sorted(every, key=cmp_to_key(_order))

    @cached_property
    def places(self) -> Array:
        return np.array([centre.place for centre in self._centres])

    @cached_property
    def between(self) -> Array:
        return np.array([centre.distance(other) for centre, other in pairwise(self._centres)])

    @cached_property
    def parting(self) -> int:
        return next(i for i, centre in enumerate(self._centres) if centre is self._parting)

    @cached_property
    def _parting(self) -> Centre:
        """The pole of the densities in (-a, a): 0, or that of a load faster than all waves."""
        pole = self.transform.pole
        if pole is None or not abs(pole.place) < self.slownesses[0]:
            return Centre(0)
        return pole

    @property
    def still(self) -> tuple[float, float]:
        return -self.factors.a, self.factors.a

    @property
    def front(self) -> float:
        return max(self.transform.fields.load.slowness, 0.0)

    @property
    def is_coarse(self) -> bool:
        return self.transform.fields.rule.tolerance > tuning.COARSE_FROM

    @cached_property
    def ahead(self) -> Complex:
        """All integrals where no wave from the edge has come, x > 0: slip ahead of all waves."""
        factors, load = self.factors, self.transform.fields.load
        far = float(np.asarray(load.far_slip_rate).ravel()[0])
        return -plane_wave(far, factors.mode, factors.a)

    @cached_property
    def behind(self) -> Complex:
        """All integrals where no wave from the edge has come, x < 0: plane waves of the load."""
        factors, load = self.factors, self.transform.fields.load
        if self.transform.pole is not None:
            # A front slower than the first wave parts nothing: its pole is one of the singular
            # points.
            if self._parting is not self.transform.pole:  # no plane wave is ahead of others
                return self.ahead
            reflected = reflected_wave(factors, factors.mode, load.load_shear, load.slowness)
            return self.ahead - reflected
        at_zero = float(load.load_shear - np.asarray(load.far_slip_rate).ravel()[0])
        return self.ahead - plane_wave(at_zero, factors.mode, factors.a)

    def densities(self, owners: np.ndarray, offset: Complex) -> Complex:
        centres, factors = self._centres, self.factors
        fronts = np.array([factors.a, 1.0, factors.in_plane.c])
        gaps = np.array([centre.fronts(fronts) for centre in centres])[owners]
        left, right = np.moveaxis(gaps, 0, -1)[..., None] + offset
        places = np.array([centre.place for centre in centres])[owners]
        at = Slowness(factors, places[:, None] + offset, left, right)
        return densities(at, self.transform.beside(centres, owners, offset), factors.mode)
