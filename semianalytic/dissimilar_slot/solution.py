"""Fields of a solved pair on the interface as functions of position and time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.dissimilar.growth import GrowingWave, growing_waves
from semianalytic.dissimilar_slot.densities.profile import (
    GAP,
    NORMAL,
    OPENING,
    RATE,
    SHEAR,
    SLIP,
    PairProfile,
)
from semianalytic.dissimilar_slot.densities.zones import MovingZone
from semianalytic.results.gridded import AnswerInBodies
from semianalytic.results.reading import Reading, self_similar_reading
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material, Scene
from semianalytic.selfsimilar.answer import SelfSimilarAnswer
from semianalytic.selfsimilar.shown import slips_said
from semianalytic.selfsimilar.statistics import Statistics
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone, is_open, over_slowness

if TYPE_CHECKING:  # imported where it is asked for, for a quick import
    from semianalytic.dissimilar_slot.bodies import PairBodies
    from semianalytic.dissimilar_slot.derivative import PairDerivative


@asked_in_units
@dataclass(frozen=True, eq=False)
class PairSolution(SelfSimilarAnswer, AnswerInBodies):
    """Self-similar slip, stick and opening between two different half-planes.

    Fields broadcast over positions x > 0 [length] and times t [time]; before t = 0 there is the
    base state.  Slip and gap are relative, upper minus lower side.  As all results that hold
    arrays, a solution equals only itself; compare fields.

    Attributes
    ----------
    scene : Scene
    zones : tuple of SlipZone
        Closed parts that slip, from the contact edge outward, in velocities [length / time].
    openings : tuple of OpenZone
    status : str
        "converged", or a sentence on what is unreliable.
    error_estimate : float
        Estimate, meant as a bound, of the errors of

        - zone edges, relative to the lesser of themselves and the slowest wave speed;
        - slip rate and rate of opening at points further than 0.03 of that speed from zone edges,
          relative to their largest value; slip and gap likewise;
        - shear traction and pressure there, relative to themselves plus base and load.
    statistics : Statistics
    profile : PairProfile
        The fields over slowness, in units of b and mu of the upper body and `stress_unit`.
    stress_unit : float
        Unit of stress of `profile`.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> base, load = sa.Tractions(10e6, 0.0), sa.Tractions(0.0, 4e6)
    >>> scene = sa.Scene(gouge, 0.4, base, load, lower_material=rock)
    >>> answer = sa.solve(scene, rtol=1e-6)
    >>> answer.slip_rate(1.0, 2e-3).round(3), (answer.pressure(1.0, 2e-3) / 1e6).round(3)
    (np.float64(0.25), np.float64(9.633))
    """

    scene: Scene
    zones: tuple[SlipZone, ...]
    openings: tuple[OpenZone, ...]
    status: str
    error_estimate: float
    statistics: Statistics
    profile: PairProfile
    stress_unit: float

    @property
    def _solids(self) -> tuple[Material, ...]:
        return self.scene.bodies

    def __repr__(self) -> str:
        moving = slips_said(self.zones, self.openings)
        return f"<PairSolution: {moving}; {self.status}, error estimate {self.error_estimate:.1e}>"

    def _evaluate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the functions of the profile at positions and times, (6, ...); 0 before t = 0."""
        return over_slowness(self.scene.material.shear_speed, x, t, self.profile.at)

    @property
    def _rate_unit(self) -> float:
        return self.stress_unit / self.scene.material.shear_impedance

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip rate [length / time].

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return np.asarray(self._rate_unit * self._evaluate(x, t)[RATE])

    def gap_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """How fast the contact opens [length / time], 0 where closed; raises as `slip_rate`."""
        return np.asarray(self._rate_unit * self._evaluate(x, t)[OPENING])

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip since t = 0 [length]; raises as `slip_rate`."""
        return self._integrated(x, t, SLIP)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """How far the contact is open [length], 0 where closed; raises as `slip_rate`."""
        gap = self._integrated(x, t, GAP)
        return np.where(is_open(self.openings, x, t), np.maximum(gap, 0.0), 0.0)

    def _integrated(self, x: ArrayLike, t: ArrayLike, function: int) -> Array:
        """Return the integral of a rate over time, x times its integral over slowness."""
        length = self._rate_unit * np.asarray(x, dtype=float) / self.scene.material.shear_speed
        return np.asarray(length * self._evaluate(x, t)[function])

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Total shear traction sigma_xy [stress], 0 where open; raises as `slip_rate`."""
        change = self.stress_unit * self._evaluate(x, t)[SHEAR]
        return np.where(is_open(self.openings, x, t), 0.0, self.scene.base.shear + change)

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Contact pressure [stress], 0 where open; raises as `slip_rate`."""
        change = self.stress_unit * self._evaluate(x, t)[NORMAL]
        return np.where(is_open(self.openings, x, t), 0.0, self.scene.base.pressure - change)

    def slot_velocity(self, x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
        """Particle velocity (v_x, v_y) [length / time] of the upper slot face, at x < 0; it is
        infinite at the Rayleigh front of the upper body.

        Raises
        ------
        SceneError
            If a position is not negative, or x or t is not finite.
        """
        if np.any(np.asarray(x) >= 0):
            raise SceneError("the slot is x < 0; ask for negative positions.")
        along, across = self.velocity(x, 0.0, t)
        return along, across

    @cached_property
    def _bodies(self) -> PairBodies:
        from semianalytic.dissimilar_slot.bodies import PairBodies

        return PairBodies(self.scene, self.profile.density, self.stress_unit)

    def derivative(self, name: str) -> PairDerivative:
        """Return the derivative of zones and fields with respect to one parameter alone.

        Parameters
        ----------
        name : str
            "friction", "viscosity" (with `Coulomb` of a viscosity), "base_pressure", "base_shear",
            "load_pressure", "load_shear"; "shear_modulus", "density" or "poisson_ratio" of the
            upper body, and these with "lower_" before them of the lower one.

        Returns
        -------
        PairDerivative
            Its `status` says where zones are about to change: it is then valid on one side only.

        Raises
        ------
        SceneError
            If there is no such parameter.
        ComputationError
            If zones of this kind have no edges at a nearby value.
        """
        from semianalytic.dissimilar_slot.derivative import differentiated
        from semianalytic.dissimilar_slot.neighbours import Member

        own = Member(self.scene, self.profile, self.stress_unit)
        return differentiated(own, name, (self.zones, self.openings), self.status)

    @cached_property
    def growing(self) -> tuple[GrowingWave, ...]:
        """Waves that grow where the interface slips.

        They run towards the contact edge: those that run ahead of slip are refused.  They leave the
        exact answer as it is, but a march on a grid lets them grow from its rounding, the faster
        the finer it is.
        """
        compliance = self.profile.density.interface.compliance
        senses = sorted({zone.sense for zone in self.zones})
        frictions = [sense * self.scene.coefficient for sense in senses]
        return tuple(wave for f in frictions for wave in growing_waves(compliance, f))

    @cached_property
    def edge_slip_rate(self) -> float:
        """Relative slip rate at the contact edge, x -> 0+ [length / time]; 0 if it sticks."""
        return float(self._rate_unit * self.profile.parts[-1].series.ends[1][RATE])

    def max_slip(self, t: ArrayLike) -> Array:
        """Largest |slip| on the contact at times t [length]; it grows linearly in time."""
        return np.asarray(self._rate_unit * np.maximum(t, 0.0) * self.profile.most_slip)

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Integral over the contact of the |slip| accumulated until t [length^2]; grows as t^2."""
        area = self._rate_unit * self.scene.material.shear_speed * self.profile.slipped / 2
        return np.asarray(area * np.maximum(np.asarray(t, dtype=float), 0.0) ** 2)

    def frictional_power(self, t: ArrayLike) -> Array:
        """Power turned to heat on the contact per unit depth [stress length^2 / time]."""
        unit = self._rate_unit * self.stress_unit * self.scene.material.shear_speed
        return np.asarray(unit * self.profile.dissipated * np.maximum(np.asarray(t, float), 0.0))

    def frictional_work(self, t: ArrayLike) -> Array:
        """Energy turned to heat on the contact until t, per unit depth [stress length^2]."""
        # Power grows as t, so that its integral is half of it times t.
        return self.frictional_power(t) * np.maximum(np.asarray(t, dtype=float), 0.0) / 2

    def reading(self, x: ArrayLike, t: ArrayLike) -> Reading:
        """Arrivals and fields at x and t, each with its error bar; as `Solution.reading`."""
        scene, profile = self.scene, self.profile
        load, base, rate = scene.superposition.taken_off, scene.base, self._rate_unit
        largest = max(abs(load.pressure), abs(load.shear))
        time = np.maximum(np.asarray(t, dtype=float), 0.0)
        scales = {
            "slip": self.max_slip(t),
            "slip_rate": rate * profile.largest_rate,
            "shear_traction": base.pressure + abs(base.shear) + largest,
            "pressure": base.pressure + abs(base.shear) + largest,
            "gap": rate * profile.largest_gap * time if self.openings else 0.0,
        }
        # The estimate is relative to the lesser of an edge and the slowest wave.
        slowest = min(body.shear_speed for body in scene.bodies)
        return self_similar_reading(self, x, t, slowest, scales)


def in_velocity(
    zones: tuple[MovingZone, ...], speed: float
) -> tuple[tuple[SlipZone, ...], tuple[OpenZone, ...]]:
    """Convert zones in slowness to slip zones and openings, from the contact edge outward."""
    slips, opens = [], []
    # Zones are in order of slowness, from the fastest wave inward.
    for zone in reversed(zones):
        inner = 0.0 if zone.right is None else speed / zone.right
        if zone.open:
            opens.append(OpenZone(inner, speed / zone.left))
        else:
            slips.append(SlipZone(inner, speed / zone.left, zone.sense))
    return tuple(slips), tuple(opens)
