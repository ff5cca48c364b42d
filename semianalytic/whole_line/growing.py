"""A slot under a load and a strength that both grow as the same power of time."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Array, Mode, rayleigh_factors
from semianalytic.results.places import contact_points
from semianalytic.results.reading import Reading, self_similar_reading
from semianalytic.scene.checks import checked_number, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.arguments import asked_in_units
from semianalytic.scene.scene import ANTIPLANE, IN_PLANE, MODES, Material, Tractions
from semianalytic.scene.units import SI
from semianalytic.selfsimilar.answer import SelfSimilarAnswer
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone
from semianalytic.whole_line.growing_zone import GrowingZone, growing_zone

POWERS = (1, 2)


@dataclass(frozen=True)
class GrowingSlot:
    """A slot whose faces are sheared by Q_0 t^n, beside a contact under a pressure P_0 t^n.

    The slot is x < 0, its faces receive the change of shear traction -Q_0 t^n, as those of a
    `Scene` do in a step.  The pressure acts evenly on contact and slot faces, so that the slot does
    not disturb it; strength is friction times it.  Strength and load keep their ratio, and edges
    their speeds.

    Parameters
    ----------
    material : Material
    friction : float
        Coulomb friction coefficient f > 0.
    load : Tractions
        Rates (P_0, Q_0) [stress / time^n], P_0 > 0.
    power : 1 or 2
        n; a step, n = 0, is a `Scene`.
    base : Tractions
        Must be (0, 0): with a base, strength is not proportional to the load.
    mode : "in-plane" or "antiplane"
    units : "" or "SI"

    Raises
    ------
    SceneError
        If a part is of another kind or out of range, or if there is a base, with which the edge of
        slip accelerates; `march` computes that case.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid = sa.Material(1.0, 1.0, 1 / 3)
    >>> slot = sa.GrowingSlot(solid, 0.5, sa.Tractions(1.0, 1.0))
    >>> slot.strength_ratio
    0.5
    """

    material: Material
    friction: float
    load: Tractions
    power: int = 1
    base: Tractions = field(default_factory=lambda: Tractions(0.0, 0.0))
    mode: str = IN_PLANE
    units: str = ""

    def __post_init__(self) -> None:
        for name, kind in (("material", Material), ("load", Tractions), ("base", Tractions)):
            if not isinstance(getattr(self, name), kind):
                raise SceneError(
                    f"growing load: {name} must be a {kind.__name__}, got "
                    f"{shown(getattr(self, name))}."
                )
        friction = checked_number(
            "growing load: friction", self.friction, "be positive", lambda given: given > 0
        )
        object.__setattr__(self, "friction", friction)
        power = checked_number(
            "growing load: power",
            self.power,
            "be 1 or 2 (a step is a scene, other histories are marched)",
            lambda given: given in POWERS,
        )
        object.__setattr__(self, "power", int(power))
        if self.mode not in MODES:
            raise SceneError(
                f"growing load: mode must be {' or '.join(MODES)}, got {shown(self.mode)}."
            )
        if self.units not in ("", SI):
            raise SceneError(
                f"growing load: units must be {SI!r} or left out, got {shown(self.units)}."
            )
        if self.base.pressure or self.base.shear:
            raise SceneError(
                "growing load: with a base the edge of slip accelerates (x as t^3 at first under a "
                "ramp) and fields are not self-similar; leave the base out, or march a scene with "
                "this base and shear_history = Ramp(rise_time), slipfront solve --method "
                "space-time."
            )
        if not self.load.pressure > 0:
            raise SceneError(
                "growing load: pressure must be positive, because strength is proportional to it, "
                f"got {self.load.pressure:.6g}."
            )
        if not self.load.shear:
            raise SceneError("growing load: without shear nothing slips; give load a shear.")

    @property
    def antiplane(self) -> bool:
        """Whether shear and slip are along z."""
        return self.mode == ANTIPLANE

    @property
    def sense(self) -> int:
        """+1 where the upper side slips towards +x, -1 towards -x."""
        return 1 if self.load.shear > 0 else -1

    @property
    def strength_ratio(self) -> float:
        """Strength over load, chi = f P_0 / |Q_0|."""
        return self.friction * self.load.pressure / abs(self.load.shear)


@asked_in_units
@dataclass(frozen=True, eq=False)
class GrowingSolution(SelfSimilarAnswer):
    """Slip from the edge of a slot under a load and a strength that grow as t^n.

    Fields broadcast over positions x > 0 [length] and times t [time]; up to t = 0 all are zero.
    Slip is relative, upper minus lower side.  Fields over t^n depend on x/t alone, slip rate ends
    smoothly, and no edge has a stress intensity.

    Attributes
    ----------
    slot : GrowingSlot
    status : str
        "converged", or a sentence that says which values are not to be trusted.
    error_estimate : float
        Estimate, meant as a bound, of the relative errors of edge speed, slip rate, slip and
        totals, and of the shear traction over strength plus load.  It is the distance of the
        traction behind the edge from the strength.
    zone : GrowingZone
        The fields over x/t, dimensionless.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid = sa.Material(1.0, 1.0, 1 / 3)
    >>> answer = sa.solve(sa.GrowingSlot(solid, 0.5, sa.Tractions(1.0, 1.0)))
    >>> answer.status, round(answer.edge_speed, 9)
    ('converged', 0.357143225)
    >>> answer.slip_rate(0.1, [1.0, 2.0]).round(6).tolist()
    [0.451293, 1.113968]
    """

    slot: GrowingSlot
    status: str
    error_estimate: float
    zone: GrowingZone

    def __repr__(self) -> str:
        where = f"slip at 0 < x/t < {self.edge_speed:.4g} ({self.slot.sense:+d})"
        estimate = f"error estimate {self.error_estimate:.1e}"
        return f"<GrowingSolution: {where}, n = {self.slot.power}; {self.status}, {estimate}>"

    @property
    def scene(self) -> GrowingSlot:
        """The slot that was asked."""
        return self.slot

    @property
    def edge_speed(self) -> float:
        """Speed of the edge of slip [length / time]."""
        return self.slot.material.shear_speed / self.zone.edge

    @property
    def zones(self) -> tuple[SlipZone, ...]:
        """The zone of slip, from the contact edge on."""
        return (SlipZone(0.0, self.edge_speed, self.slot.sense),)

    @property
    def openings(self) -> tuple[OpenZone, ...]:
        """None: pressure grows everywhere."""
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
        return self._rate_unit * time**self.slot.power * self.zone.slip_rate(xi)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip since t = 0 [length]; raises as `slip_rate`."""
        xi, time = self._velocity(x, t)
        return self._rate_unit * time ** (self.slot.power + 1) * self.zone.slip(xi)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Shear traction [stress]; raises as `slip_rate`."""
        xi, time = self._velocity(x, t)
        # Behind the edge the contact carries its strength, and `traction` is known ahead of it
        # only.
        ahead = np.maximum(xi, 1 / self.zone.edge)
        held = np.where(
            xi * self.zone.edge < 1, self.slot.strength_ratio, self.zone.traction(ahead)
        )
        return self.slot.load.shear * time**self.slot.power * held

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Contact pressure [stress], P_0 t^n; raises as `slip_rate`."""
        _, time = self._velocity(x, t)
        return np.asarray(self.slot.load.pressure * time**self.slot.power)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return zeros [length]: nothing opens; raises as `slip_rate`."""
        return np.zeros(self._velocity(x, t)[0].shape)

    def reading(self, x: ArrayLike, t: ArrayLike) -> Reading:
        """Arrivals and fields at x and t, each with a bar of its error; as `Solution.reading`."""
        slot, time = self.slot, np.maximum(np.asarray(t, dtype=float), 0.0)
        stress = (slot.load.pressure + abs(slot.load.shear)) * time**slot.power
        scales = {"slip": self.max_slip(t), "slip_rate": abs(self.edge_slip_rate(t)), "gap": 0.0}
        scales |= {"shear_traction": stress, "pressure": stress}
        return self_similar_reading(self, x, t, slot.material.shear_speed, scales)

    def edge_slip_rate(self, t: ArrayLike) -> Array:
        """Relative slip rate at the contact edge, x -> 0+, at times t [length / time]."""
        time = np.maximum(np.asarray(t, dtype=float), 0.0)
        return np.asarray(self._rate_unit * time**self.slot.power * self.zone.slip_rate(0.0))

    def max_slip(self, t: ArrayLike) -> Array:
        """Largest |slip| at times t [length]: that at the contact edge; it grows as t^(n + 1)."""
        time = np.maximum(np.asarray(t, dtype=float), 0.0)
        slip = abs(self._rate_unit) * self.zone.slip(0.0)
        return np.asarray(slip * time ** (self.slot.power + 1))

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Integral over the contact of the |slip| until t [length^2]; it grows as t^(n + 2)."""
        n, time = self.slot.power, np.maximum(np.asarray(t, dtype=float), 0.0)
        # The slip rate grows as t^n on a zone as long as t: its integral over x is one of t^(n +
        # 1).
        return np.asarray(self._area * time ** (n + 2) / (n + 2))

    def frictional_work(self, t: ArrayLike) -> Array:
        """Energy turned to heat on the contact until t, per unit depth [stress length^2].

        It grows as t^(2n + 2).
        """
        n, time = self.slot.power, np.maximum(np.asarray(t, dtype=float), 0.0)
        strength = self.slot.friction * self.slot.load.pressure
        # The strength grows as t^n besides, so that the power grows as t^(2n + 1).
        return np.asarray(strength * self._area * time ** (2 * n + 2) / (2 * n + 2))

    @property
    def _rate_unit(self) -> float:
        """Slip rate over that of one side, dimensionless, over t^n; its sign is that of slip."""
        return 2 * self.slot.load.shear / self.slot.material.shear_impedance

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
        return abs(self._rate_unit) * self.slot.material.shear_speed * area

    def _velocity(self, x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
        """Return x / (c_t t), beyond all waves up to t = 0, and t or 0."""
        x, t = contact_points(x, t)
        speed = self.slot.material.shear_speed
        xi = np.divide(x, speed * t, out=np.full(x.shape, np.inf), where=t > 0)
        # Before t = 0 any velocity beyond that of the first wave, 1/a, stands for infinity.
        return np.minimum(xi, 2 / self.zone.factors.a), np.maximum(t, 0.0)


def refuses(slot: GrowingSlot) -> None:
    """Return None: whether a second zone would start is seen when the slot is solved."""


def solve(slot: GrowingSlot) -> GrowingSolution:
    """Solve a slot under a load and a strength that grow as t^n.

    Parameters
    ----------
    slot : GrowingSlot

    Returns
    -------
    GrowingSolution

    Raises
    ------
    SceneError
        If no closed form is known: the edge of slip would be faster than the Rayleigh wave, or the
        shear traction reaches the strength ahead of it.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid = sa.Material(1.0, 1.0, 1 / 3)
    >>> slot = sa.GrowingSlot(solid, 1.0, sa.Tractions(1.0, 1.0), mode="antiplane")
    >>> round(sa.solve(slot).edge_speed, 9)
    0.120614758
    """
    mode: Mode = "III" if slot.antiplane else "II"
    factors = rayleigh_factors(slot.material.poisson_ratio, mode)
    zone = growing_zone(factors, slot.power, slot.strength_ratio)
    _check_one_zone(zone)
    # The j-th condition is a moment of v^j: of the size u_s^j times the jump of traction.
    scale = zone.edge ** np.arange(slot.power + 1) * (1 + slot.strength_ratio)
    error = float(np.abs(zone.conditions / scale).max()) + 1e-14
    status = "converged"
    if error > 1e-9:  # that of n = 2 is some 1e-10
        status = f"the error estimate {error:.1e} exceeds 1e-09"
    return GrowingSolution(slot, status, error, zone)


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
