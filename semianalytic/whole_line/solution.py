"""The solution of a whole line: slip or opening that spreads symmetrically from its load."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.answer import Arrival
from semianalytic.results.intervals import line_points, line_positions
from semianalytic.results.reading import Reading, self_similar_reading
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.loading import Patch, PointForce
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.answer import SelfSimilarAnswer
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone
from semianalytic.whole_line.drive import Drive
from semianalytic.whole_line.spreading import Spreading


@asked_in_units
@dataclass(frozen=True, eq=False)
class LineSolution(SelfSimilarAnswer):
    """Self-similar slip or opening of a whole line around a growing patch or point force.

    Fields broadcast over positions x [length], of either sign, and times t [time]; up to t = 0 they
    are those of the base.  Slip and gap are relative, upper minus lower side.  Their rates vanish
    like a square root at the edges, so that no edge has a stress intensity.

    Attributes
    ----------
    scene : Scene
    status : str
        "converged", or a sentence that says which values are not to be trusted.
    error_estimate : float
        Estimate, meant as a bound, of the relative errors of edge speed, slip rate, slip and
        totals, and of tractions over base and load, from two evaluations of the condition at the
        edge.
    spreading : Spreading
        The fields over x/t, dimensionless.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid, base = sa.Material(1.0, 1.0, 1 / 3), sa.Tractions(1.0, 0.0)
    >>> answer = sa.solve(sa.Scene(solid, 0.5, base, sa.Patch(speed=0.3, shear=1.0)))
    >>> answer.status, round(answer.edge_speed, 9)
    ('converged', 0.395154377)
    >>> answer.slip_rate([-0.2, 0.2, 0.35], 1.0).round(6).tolist()
    [0.259141, 0.259141, 0.235431]
    """

    scene: Scene
    status: str
    error_estimate: float
    spreading: Spreading

    @cached_property
    def drive(self) -> Drive:
        """Load that drives slip or opening."""
        return Drive(self.scene)

    def __repr__(self) -> str:
        what = "open" if self.drive.opens else "slip"
        sense = "" if self.drive.opens else f" ({self.drive.sense:+d})"
        estimate = f"error estimate {self.error_estimate:.1e}"
        return (
            f"<LineSolution: {what} at |x/t| < {self.edge_speed:.4g}{sense}; "
            f"{self.status}, {estimate}>"
        )

    @property
    def edge_speed(self) -> float:
        """Speed at which either edge of slip or opening moves away from x = 0 [length / time]."""
        return self.scene.material.shear_speed / self.spreading.edge

    @property
    def zones(self) -> tuple[SlipZone, ...]:
        """The zone of slip, from -edge_speed to edge_speed; none where the interface opens."""
        speed = self.edge_speed
        return () if self.drive.opens else (SlipZone(-speed, speed, self.drive.sense),)

    @property
    def openings(self) -> tuple[OpenZone, ...]:
        """The opening, from -edge_speed to edge_speed; none where the interface slips."""
        return (OpenZone(-self.edge_speed, self.edge_speed),) if self.drive.opens else ()

    @property
    def edge_amplitude(self) -> float:
        """Amplitude A of the relative rate A sqrt(1 - |x| / (edge_speed t)) of slip or opening next
        to an edge; positive [length / time].
        """
        patch = self.spreading
        # At the edge ln ((y_p + y) / (y_p - y)) -> 2 y / y_p, and y -> sqrt(2 (1 - |x| / (xi_s
        # t))).
        return float(self._rate_unit * patch.scale * np.sqrt(8.0) / patch.beyond)

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip rate [length / time]; infinite at the end of a patch and at a force.

        Raises
        ------
        SceneError
            If x or t is not finite.
        """
        xi = self._velocity(x, t)
        return self.drive.sense * self._rate_unit * self._moving(xi, self.spreading.slip_rate)

    def gap_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Rate of the gap [length / time], 0 where closed; raises as `slip_rate`."""
        xi = self._velocity(x, t)
        return (
            float(self.drive.opens) * self._rate_unit * self._moving(xi, self.spreading.slip_rate)
        )

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip since t = 0 [length]; raises as `slip_rate`."""
        return self.drive.sense * self._moved(x, t)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Gap between the sides [length], 0 where closed; raises as `slip_rate`."""
        return float(self.drive.opens) * self._moved(x, t)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Shear traction [stress], 0 where open; raises as `slip_rate`."""
        drive, xi = self.drive, self._velocity(x, t)
        if drive.opens:
            return np.zeros(xi.shape)
        slips = drive.sense * drive.scene.coefficient * self._load_pressure(xi)
        held = drive.base.shear + drive.sense * self._ahead(xi)
        return np.where(xi < self.edge_speed, slips, held)

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Contact pressure [stress], 0 where open; raises as `slip_rate`."""
        drive, xi = self.drive, self._velocity(x, t)
        if drive.opens:
            closed = drive.base.pressure - self._ahead(xi)
            return np.where(xi < self.edge_speed, 0.0, closed)
        return self._load_pressure(xi)

    def path(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Accumulated |slip| [length], which has one sense; raises as `slip_rate`."""
        return np.abs(self.slip(x, t))

    def arrival(self, x: ArrayLike, of: Arrival = "slip") -> Array:
        """First time of slip or opening at x [time], inf without one; as `Solution.arrival`.

        For "slip", the motion of the open part counts as well.
        """
        moves = self.drive.opens if of == "opening" else of != "opening"
        if of in ("forward", "reverse"):
            moves = self.drive.sense == (1 if of == "forward" else -1)
        far = np.abs(line_positions(x))
        return far / self.edge_speed if moves else np.full(far.shape, np.inf)

    def reading(self, x: ArrayLike, t: ArrayLike) -> Reading:
        """Arrivals and fields at x and t, each with its error bar; as `Solution.reading`."""
        drive, time = self.drive, np.maximum(np.asarray(t, dtype=float), 0.0)
        stress = abs(drive.base.pressure) + abs(drive.base.shear) + self._stress_unit
        # a rate has no largest value at the end of a patch, and slip none at a point force
        rate = self._rate_unit * self.spreading.scale
        moved = {"slip_rate": rate, "slip": rate * time, "gap": rate * time}
        scales = {**moved, "shear_traction": stress, "pressure": stress}
        found = self_similar_reading(self, np.abs(x), t, drive.scene.material.shear_speed, scales)
        return replace(found, x=np.broadcast_to(np.asarray(x, dtype=float), found.x.shape))

    def max_slip(self, t: ArrayLike) -> Array:
        """Largest |slip| at times t [length]: that at x = 0, infinite at a point force."""
        return np.abs(self.slip(0.0, t))

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Integral over the line of the |slip| accumulated until t [length^2]; grows as t^2."""
        # The sense is 0 where the interface opens: nothing slips there.
        return abs(self.drive.sense) * self._areas(self.spreading.area, t)

    def frictional_work(self, t: ArrayLike) -> Array:
        """Energy turned to heat on the interface until t, per unit depth [stress length^2]."""
        drive = self.drive
        if drive.opens:
            return np.zeros(np.shape(t))
        # Strength is uniform but for the pressure of the load, which acts on the patch alone.
        work = drive.strength * self._areas(self.spreading.area, t)
        if isinstance(drive.load, Patch) and drive.load.pressure:
            share = self._areas(self.spreading.area_on_patch, t)
            work = work + drive.scene.coefficient * drive.load.pressure * share
        return np.asarray(work)

    @property
    def _stress_unit(self) -> float:
        drive = self.drive
        point = isinstance(drive.load, PointForce)
        return drive.excess / (drive.scene.material.shear_speed if point else 1.0)

    @property
    def _rate_unit(self) -> float:
        # `Spreading` gives the rate of one side; the two sides move apart, or along, evenly.
        return 2 * self._stress_unit / self.scene.material.shear_impedance

    def _velocity(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return |x| / t, inf up to t = 0; x or t that is not finite is refused."""
        x, t = line_points(x, t)
        return np.divide(np.abs(x), t, out=np.full(x.shape, np.inf), where=t > 0)

    def _moving(self, xi: Array, field: Any) -> Array:
        """Return a field of the spreading, 0 before the load."""
        speed = self.scene.material.shear_speed
        # Twice the speed of the edge is ahead of all motion, as everything is before the load.
        values = field(np.where(np.isfinite(xi), xi / speed, 2 / self.spreading.edge))
        return np.asarray(values)

    def _moved(self, x: ArrayLike, t: ArrayLike) -> Array:
        xi = self._velocity(x, t)
        time = np.where(np.isfinite(xi), np.broadcast_to(np.asarray(t, dtype=float), xi.shape), 0.0)
        # slip at a point force is infinite, and none at t = 0
        slip = self._moving(xi, self.spreading.slip)
        return np.where(time > 0, self._rate_unit * slip * np.where(time > 0, time, 1.0), 0.0)

    def _ahead(self, xi: Array) -> Array:
        """Return how far the traction that drives motion is above that of the base."""
        speed = self.scene.material.shear_speed
        outside = np.maximum(xi / speed, 1 / self.spreading.edge)
        return self._stress_unit * self.spreading.traction(outside)

    def _load_pressure(self, xi: Array) -> Array:
        """Return the pressure where the interface is closed, which slip does not change."""
        drive = self.drive
        if not isinstance(drive.load, Patch):
            return np.full(xi.shape, drive.base.pressure)
        on_patch = xi < drive.load.speed
        return drive.base.pressure + np.where(on_patch, drive.load.pressure, 0.0)

    def _areas(self, area: float, t: ArrayLike) -> Array:
        # The integral of the rate over x grows as t, and its integral over time as t^2 / 2.
        unit = self._rate_unit * self.scene.material.shear_speed * area / 2
        return np.asarray(unit * np.maximum(np.asarray(t, dtype=float), 0.0) ** 2)
