"""A slot under a load and a strength that both grow as the same power of time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Mode, rayleigh_factors
from semianalytic.results.intervals import contact_points
from semianalytic.results.reading import Reading, self_similar_reading
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loading import GrowingLoad
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.answer import SelfSimilarAnswer
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone
from semianalytic.whole_line.drive import check_law
from semianalytic.whole_line.growing_zone import GrowingZone, growing_zone


@asked_in_units
@dataclass(frozen=True, eq=False)
class GrowingSolution(SelfSimilarAnswer):
    """Slip from the edge of a slot under a load and a strength that grow as t^n.

    Fields broadcast over positions x > 0 [length] and times t [time]; up to t = 0 all are zero.
    Slip is relative, upper minus lower side.  Fields over t^n depend on x/t alone, slip rate ends
    smoothly, and no edge has a stress intensity.

    Attributes
    ----------
    scene : Scene
    status : str
        "converged", or a sentence that says which values are not to be trusted.
    error_estimate : float
        Estimate, meant as a bound, of the relative errors of edge speed, slip rate, slip and
        totals, and of the shear traction over strength plus load.  It is the relative difference
        between the traction behind the edge and the strength.
    zone : GrowingZone
        The fields over x/t, dimensionless.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid = sa.Material(1.0, 1.0, 1 / 3)
    >>> answer = sa.solve(sa.Scene(solid, 0.5, sa.Tractions(0.0, 0.0), sa.GrowingLoad(1.0, 1.0)))
    >>> answer.status, round(answer.edge_speed, 9)
    ('converged', 0.357143225)
    >>> answer.slip_rate(0.1, [1.0, 2.0]).round(6).tolist()
    [0.451293, 1.113968]
    """

    scene: Scene
    status: str
    error_estimate: float
    zone: GrowingZone

    def __repr__(self) -> str:
        where = f"slip at 0 < x/t < {self.edge_speed:.4g} ({self.sense:+d})"
        estimate = f"error estimate {self.error_estimate:.1e}"
        return f"<GrowingSolution: {where}, n = {self.load.power}; {self.status}, {estimate}>"

    @property
    def load(self) -> GrowingLoad:
        """The load of the scene."""
        assert isinstance(self.scene.load, GrowingLoad)
        return self.scene.load

    @property
    def sense(self) -> int:
        """+1 if the upper side slips towards +x, -1 if it slips towards -x."""
        return 1 if self.load.shear > 0 else -1

    @property
    def edge_speed(self) -> float:
        """Speed of the edge of slip [length / time]."""
        return self.scene.material.shear_speed / self.zone.edge

    @property
    def zones(self) -> tuple[SlipZone, ...]:
        """The zone of slip, from the contact edge on."""
        return (SlipZone(0.0, self.edge_speed, self.sense),)

    @property
    def openings(self) -> tuple[OpenZone, ...]:
        """Empty, since the pressure grows everywhere."""
        return ()

    @property
    def edge_amplitude(self) -> float:
        """A of the slip rate A t^n sqrt(1 - x / (edge_speed t)) next to the edge of slip.

        It is relative, positive, in [length / time^(n + 1)].
        """
        return abs(self._rate_unit) * self.zone.edge_amplitude

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip rate [length / time].

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        xi, time = self._velocity(x, t)
        return self._rate_unit * time**self.load.power * self.zone.slip_rate(xi)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip since t = 0 [length]; raises as `slip_rate`."""
        xi, time = self._velocity(x, t)
        return self._rate_unit * time ** (self.load.power + 1) * self.zone.slip(xi)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Shear traction [stress]; raises as `slip_rate`."""
        xi, time = self._velocity(x, t)
        # Behind the edge the contact carries its strength, and `traction` is known ahead of it
        # only.
        ahead = np.maximum(xi, 1 / self.zone.edge)
        held = np.where(xi * self.zone.edge < 1, self.zone.ratio, self.zone.traction(ahead))
        return self.load.shear * time**self.load.power * held

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Contact pressure [stress], P_0 t^n; raises as `slip_rate`."""
        _, time = self._velocity(x, t)
        return np.asarray(self.load.pressure * time**self.load.power)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return zeros [length]: nothing opens; raises as `slip_rate`."""
        return np.zeros(self._velocity(x, t)[0].shape)

    def reading(self, x: ArrayLike, t: ArrayLike) -> Reading:
        """Arrivals and fields at x and t, each with its error bar; as `Solution.reading`."""
        load, time = self.load, np.maximum(np.asarray(t, dtype=float), 0.0)
        stress = (load.pressure + abs(load.shear)) * time**load.power
        scales = {"slip": self.max_slip(t), "slip_rate": abs(self.edge_slip_rate(t)), "gap": 0.0}
        scales |= {"shear_traction": stress, "pressure": stress}
        return self_similar_reading(self, x, t, self.scene.material.shear_speed, scales)

    def edge_slip_rate(self, t: ArrayLike) -> Array:
        """Relative slip rate at the contact edge, x -> 0+, at times t [length / time]."""
        time = np.maximum(np.asarray(t, dtype=float), 0.0)
        return np.asarray(self._rate_unit * time**self.load.power * self.zone.slip_rate(0.0))

    def max_slip(self, t: ArrayLike) -> Array:
        """Largest |slip| at times t [length]: that at the contact edge; it grows as t^(n + 1)."""
        time = np.maximum(np.asarray(t, dtype=float), 0.0)
        slip = abs(self._rate_unit) * self.zone.slip(0.0)
        return np.asarray(slip * time ** (self.load.power + 1))

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Integral over the contact of the |slip| until t [length^2]; it grows as t^(n + 2)."""
        n, time = self.load.power, np.maximum(np.asarray(t, dtype=float), 0.0)
        # The slip rate grows as t^n on a zone as long as t: its integral over x is one of t^(n +
        # 1).
        return np.asarray(self._area * time ** (n + 2) / (n + 2))

    def frictional_work(self, t: ArrayLike) -> Array:
        """Energy turned to heat on the contact until t, per unit depth [stress length^2].

        It grows as t^(2n + 2).
        """
        n, time = self.load.power, np.maximum(np.asarray(t, dtype=float), 0.0)
        strength = self.scene.coefficient * self.load.pressure
        # The strength grows as t^n besides, so that the power grows as t^(2n + 1).
        return np.asarray(strength * self._area * time ** (2 * n + 2) / (2 * n + 2))

    @property
    def _rate_unit(self) -> float:
        """Slip rate over that of one side, dimensionless, over t^n; its sign is that of slip."""
        return 2 * self.load.shear / self.scene.material.shear_impedance

    @cached_property
    def _area(self) -> float:
        """Integral of |slip rate| over x at t = 1."""
        t, weight = gauss(20)
        # Each half as long as the last towards the contact edge.
        ends = np.concatenate([[0.0], 0.5 ** np.arange(40, -1, -1)])
        # share = 1 - s^2 takes the root at the edge of slip
        share = ends[:-1, None] + np.diff(ends)[:, None] * t
        rule = np.diff(ends)[:, None] * weight
        s = 1 - share
        rates = self.zone.slip_rate((1 - s**2) / self.zone.edge)
        area = float(np.sum(rule * 2 * s * rates)) / self.zone.edge
        return abs(self._rate_unit) * self.scene.material.shear_speed * area

    def _velocity(self, x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
        """Return x / (c_t t), beyond all waves up to t = 0, and t or 0."""
        x, t = contact_points(x, t)
        speed = self.scene.material.shear_speed
        xi = np.divide(x, speed * t, out=np.full(x.shape, np.inf), where=t > 0)
        # Before t = 0 any velocity beyond that of the first wave, 1/a, stands for infinity.
        return np.minimum(xi, 2 / self.zone.factors.a), np.maximum(t, 0.0)


def refuses(scene: Scene) -> None:
    """Return None: whether a second zone would start is seen when the scene is solved."""


def solve(scene: Scene) -> GrowingSolution:
    """Solve a slot under a `GrowingLoad`: load and strength grow as t^n.

    Raises
    ------
    SceneError
        If the base is not zero, so that the edge of slip accelerates (a march computes this case),
        or no closed form is known: the edge of slip would be faster than the Rayleigh wave, or the
        shear traction reaches the strength ahead of it.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid = sa.Material(1.0, 1.0, 1 / 3)
    >>> load, nothing = sa.GrowingLoad(1.0, 1.0), sa.Tractions(0.0, 0.0)
    >>> round(sa.solve(sa.Scene(solid, 1.0, nothing, load, mode="antiplane")).edge_speed, 9)
    0.120614758
    """
    load = scene.load
    assert isinstance(load, GrowingLoad)
    check_law(scene, "growing load")
    if scene.base.pressure or scene.base.shear:
        raise SceneError(
            "growing load: with a base the edge of slip accelerates (x as t^3 at first under a "
            "ramp) and fields are not self-similar; set the base to 0, or march a scene with this "
            "base and shear_history = Ramp(rise_time), slipfront solve --method space-time."
        )
    if not scene.coefficient > 0:
        raise SceneError(f"growing load: friction must be positive, got {scene.coefficient:.6g}.")
    mode: Mode = "III" if scene.antiplane else "II"
    factors = rayleigh_factors(scene.material.poisson_ratio, mode)
    # strength over load, chi = f P_0 / |Q_0|
    zone = growing_zone(factors, load.power, scene.coefficient * load.pressure / abs(load.shear))
    _check_one_zone(zone)
    # The j-th condition is a moment of v^j: of the size u_s^j times the jump of traction.
    scale = zone.edge ** np.arange(load.power + 1) * (1 + zone.ratio)
    error = float(np.abs(zone.conditions / scale).max()) + 1e-14
    status = "converged"
    if error > 1e-9:  # that of n = 2 is some 1e-10
        status = f"the error estimate {error:.1e} exceeds 1e-09"
    return GrowingSolution(scene, status, error, zone)


def _check_one_zone(zone: GrowingZone) -> None:
    """Raise SceneError if shear meets strength ahead of slip, or slip turns."""
    edge, fastest = 1 / zone.edge, 1 / zone.factors.a
    share = np.arange(1, 300) / 300
    # Traction turns at the shear wave and at the Rayleigh wave, which samples might pass over.
    ahead = np.sort([1.0, 1 / zone.factors.c, *(edge + (fastest - edge) * share)])
    traction = np.abs(zone.traction(ahead[ahead > edge]))
    if traction.max() > zone.ratio:
        raise SceneError(
            "growing load: a second zone of slip starts at the shear wave, where shear would be "
            f"{traction.max() / zone.ratio:.3g} times the strength, and no closed form is known "
            "for two zones; raise pressure or friction, or lower the shear."
        )
    if zone.slip_rate(edge * share).min() < 0:
        raise SceneError(
            "growing load: slip would reverse within its zone, for which no closed form is known; "
            "raise pressure or friction, or lower the shear."
        )
