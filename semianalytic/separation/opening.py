"""Edges of the opening: where the pressure falls to zero, and where the gap closes.

The transform P of the change of pressure is real where the contact is open, P / M_+ of mode I is
real where it is closed, and P(0) = P_0.  There is one opening at most:

- from the contact edge for P_0 < 0, its speed in closed form, u_s = p + (J/P_0)^2 M_+(-p)^2 with J
  the jump of pressure at the edge and p the slowness of the front of the load (0 if it comes at
  once);
- around the Rayleigh front for P_0 > 0 and P_b < -P_0 p*(c).  Both ends are smooth: besides R there
  is a term r / (k + e) of the closing edge e, and the rate of the gap and the gap vanish there.

The fields are those of `cut.zones` in mode I, minus pressure for traction and opening of one side
for slip, b = mu = 1.  With r = 0 they have the slopes g_0; the term makes them
g_0 (1 + rho (v - p) / (e (e - v))), rho = r / R_0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np

from semianalytic.cut.load import LEAST_BASE, Load, Opened, normal_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError

CLOSINGS = np.linspace(np.log(0.3), np.log(60.0), 6)
"""Log distances of the closing edge from c over the opening's: 3 at the threshold, 25 at nu =
0.49."""
NUDGE = 1e-6
"""Change of an unknown for its column of the Jacobian: about the root of 1e-12."""
LEAST_ERROR = 1e-14
"""Rounding error, part of every estimate."""


@dataclass(frozen=True)
class OpenPart:
    """The open part of the contact, in slowness, and the constants of P."""

    zone: Zone  # the open part, with sense 1; right None is the contact edge
    # the terms r / (k + edge) of edges at which it closes; none at the contact edge
    closing: tuple[tuple[CutPoints, float], ...]
    # estimate of the error of its edges, relative to c_t, and of its gap, relative to the largest
    error: float


def opening_of(
    poisson_ratio: float, base: float, step: float, tolerance: float, slowness: float = 0.0
) -> OpenPart | None:
    """Return the opening under a step of pressure on a base; None if there is none.

    The base pressure P_b > 0 and the step P_0 that is taken off the slot are in any one unit of
    stress; the tolerance is that of the rule on which its edges are placed; the slowness p [b] is
    that of the front of the load over the slot, 0 for a load that comes at once.  Raises
    ComputationError if Newton's method does not place them.
    """
    if step < 0:
        return _from_contact_edge(poisson_ratio, -base / step, slowness)
    if not step:
        return None
    # The pressure of a stuck contact is least at the Rayleigh front, where p* is negative.
    if base >= -step * stuck_traction(poisson_ratio, "I", slowness).at_rayleigh_front:
        return None
    # The problem is linear in (P_b, P_0): edges depend on their ratio alone.
    unit = detached_opening(poisson_ratio, base / step, tolerance, slowness)
    return replace(unit, closing=tuple((edge, amount * step) for edge, amount in unit.closing))


def _from_contact_edge(poisson_ratio: float, ratio: float, slowness: float) -> OpenPart:
    """Return one zone up to the contact edge, where P = P_0 - P_b: closed form of `reference`."""
    factors = rayleigh_factors(poisson_ratio, "I")
    # p = 0, for which M_+(0)^2 = (1 - nu) / a in mode I.
    start = (1 - poisson_ratio) * (1 + ratio) ** 2 / factors.a
    if slowness:
        start = slowness + ((1 + ratio) * factors.m_plus_off_cut(-slowness)) ** 2
    return OpenPart(Zone(factors.cut([start]), None, 1), (), LEAST_ERROR)


@lru_cache(maxsize=64)
def detached_opening(
    poisson_ratio: float, ratio: float, tolerance: float, slowness: float = 0.0
) -> OpenPart:
    """Return the opening around c under P_0 = 1.

    It is placed on a fine rule and compared with a coarser one.  Those of the 64 most recent scenes
    are cached, since friction and shear do not change them.
    """
    problem = Detached(poisson_ratio, ratio, rule_for(tolerance), slowness)
    # How far the base is below the least that keeps the contact closed: a barely open contact needs
    # a finer rule already for its first edges.
    below = 1 + ratio / stuck_traction(poisson_ratio, "I", slowness).at_rayleigh_front
    # The width of the opening grows like the root of `below`.
    loose = max(min(1e-3, 0.1 * below), 1e-12)
    unknowns, inverse = _located(replace(problem, rule=rule_for(loose)))
    least = max(1e-13, problem.rule.tolerance / 2)
    for _ in range(12):
        left = Left(problem.fields(unknowns))
        # A chord method: the Jacobian of the loose rule serves on the fine one, and each step gains
        # as many digits as both rules agree in.
        move = -inverse @ left.mismatch
        if np.abs(move).max() < least:
            break
        unknowns = unknowns + move
    coarser = rule_for(5.0 * problem.rule.tolerance)
    move = -inverse @ Left(replace(problem, rule=coarser).fields(unknowns)).mismatch
    zone = problem.zone(unknowns)
    assert zone.right is not None
    # R = R_0 (1 - rho / e): `ZoneFields` finds it from r = rho R_0 and P(0)
    amount = float(left.term) * float(left.fields.amplitude[0])
    error = _shift(zone, problem.zone(unknowns + move))
    # The rate of the gap changes several times as much as the edges, relative to itself.
    return OpenPart(zone, ((zone.right, amount),), LEAST_ERROR + 15.0 * error)


def _shift(zone: Zone, other: Zone) -> float:
    """Return the largest difference of edge velocities over c_t, or a narrow opening's width."""
    pairs = ((zone.left, other.left), (zone.right, other.right))
    ends = [(float(1 / p.v[0]), float(1 / q.v[0])) for p, q in pairs if p and q]
    largest = max(abs(before - after) for before, after in ends)
    width = abs(ends[0][0] - ends[-1][0])
    # The gap's error is about 15 times that of edges over the width, for which there is room down
    # to 0.2 c_t.
    return largest / min(1.0, width / 0.2)


def _located(problem: Detached) -> tuple[Array, Array]:
    """Return approximate edges by Newton's method, and the inverse Jacobian there."""
    unknowns = problem.start()
    # Three sets of edges at once: the edges themselves, and one with either edge nudged.
    nudges = NUDGE * np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for _ in range(30):  # five are usual
        values = Left(problem.fields(unknowns[:, None] + nudges)).mismatch
        jacobian = (values[:, 1:] - values[:, :1]) / NUDGE
        inverse = np.asarray(np.linalg.inv(jacobian))
        move = -inverse @ values[:, 0]
        largest = float(np.abs(move).max())
        unknowns = unknowns + move * min(1.0, 2.0 / largest)
        if largest < 1e-2:  # the Jacobian is kept, and the rule made finer
            return unknowns, inverse
    raise ComputationError("the edges of the opening were not found; please report the scene.")


@dataclass(frozen=True)
class Detached:
    """An opening around c under P_0 = 1 on a base, with its edges as unknowns.

    They are the logit of the opening edge in (a, c), and the log distance of the closing one from
    c.
    """

    poisson_ratio: float
    base: float
    rule: Rule
    slowness: float = 0.0

    @property
    def factors(self) -> RayleighFactors:
        """The factors of mode I."""
        return rayleigh_factors(self.poisson_ratio, "I")

    def zone(self, unknowns: Array) -> Zone:
        """Return the opening of unknowns (2,), or of several (2, k)."""
        factors = self.factors
        width = factors.c - factors.a
        # A logit gives both distances without a subtraction, however near the edge is to a front.
        from_a, from_c = (width / (1 + np.exp(sign * unknowns[0])) for sign in (-1, 1))
        left = np.where(
            from_a < from_c, factors.beside("a", from_a).parts, factors.beside("c", -from_c).parts
        )
        left[1], left[3] = from_a, -from_c
        at_b = np.abs(left[2]) < 1e-14  # rounding of sums: on one side of it in all parts
        left[0] = np.where(at_b, 1.0 + left[2], left[0])
        right = factors.beside("c", np.exp(unknowns[1])).parts
        return Zone(CutPoints(left[..., None]), CutPoints(right[..., None]), 1)

    def start(self) -> Array:
        """Return unknowns to begin with, interpolated between some that are tried.

        Opening edges are tried from where the stuck pressure is zero on.  For each the closing edge
        is found at which no gap is left, and of these pairs the one at which no pressure is left.
        """
        width = self.factors.c - self.factors.a
        first = self._tried_openings()
        second = CLOSINGS[:, None] + np.log(width / (1 + np.exp(first)))
        both = np.stack([np.broadcast_to(first, second.shape), second])
        loose = replace(self, rule=rule_for(1e-2))
        pressure, gap = Left(loose.fields(both.reshape(2, -1))).mismatch.reshape(both.shape)
        # The gap left at the closing edge changes sign between two of the tried edges.
        closes = gap[1:] * gap[:-1] <= 0
        row = np.where(closes.any(axis=0), closes.argmax(axis=0), np.abs(gap[1:]).argmin(axis=0))
        column = np.arange(len(first))
        before, after = gap[row, column], gap[row + 1, column]
        share = np.where(before * after < 0, before / (before - after), 1.0)
        rest, closing = (
            each[row, column] + share * (each[row + 1, column] - each[row, column])
            for each in (pressure, np.broadcast_to(CLOSINGS[:, None], gap.shape))
        )
        # `np.interp` needs increasing abscissas, and the pressure left need not fall with the edge.
        order = np.argsort(rest)
        opens, closing = (np.interp(0.0, rest[order], values[order]) for values in (first, closing))
        return np.array([opens, closing + np.log(width / (1 + np.exp(opens)))])

    def _tried_openings(self) -> Array:
        """Return opening edges to try, as unknowns (m,), from where the stuck pressure is zero on.

        They are ahead of it near c_l, where pressure falls like a root, else behind, on one side of
        cuts.
        """
        factors, logits = self.factors, np.linspace(-40.0, 40.0, 321)
        width, stuck = factors.c - factors.a, stuck_traction(self.poisson_ratio, "I", self.slowness)
        left = stuck(factors.a + width / (1 + np.exp(-logits))) + self.base
        last = int(np.argmax(left < 0))
        start = float(np.interp(0.0, left[[last, last - 1]], logits[[last, last - 1]]))
        # The edge lies at 0.5 to 0.97 of the zero, elsewhere 0.1 to 0.6 beyond it: Newton's method
        # then takes two steps in the median of a hundred scenes.
        stop = start / 2 if start < -1.0 else start + 0.9
        for cut in factors.cuts:
            bound = float(np.log(cut.from_a[0] / -cut.from_c[0]))
            # Panels differ on the two sides of a cut, and with them the mismatch, which would jump.
            if start < bound < stop:
                stop = bound - 0.05 * (bound - start)
        return np.linspace(start, stop, 4)

    def fields(self, unknowns: Array) -> ZoneFields:
        """Return the fields with r = 0, without the part behind the opening."""
        zones = (self.zone(unknowns),)
        load = normal_load(self.base, 1.0, self.slowness)
        return ZoneFields(self.factors, load, zones, self.rule, False)


@dataclass(frozen=True)
class Left:
    """The conditions that an opening with given edges does not satisfy, from fields with r = 0."""

    fields: ZoneFields

    @cached_property
    def _share(self) -> Array:
        """Factor (v - p) / (e (e - v)) at the nodes, (p, ..., n), with the closing edge e."""
        panels = self.fields.panels
        from_load = panels.at.v - self.fields.load.slowness
        return -from_load / (panels.ends.v[-1] * panels.from_ends[-1])

    @cached_property
    def _rates(self) -> tuple[Array, Array]:
        """Slopes of the rate of the gap, for R and for the term in r, (p, ..., n)."""
        slope = self.fields.slip_rate_slope
        return slope, slope * self._share

    @cached_property
    def term(self) -> Array:
        """The ratio rho = r / R_0 for which the gap closes at zero rate, () or (k,)."""
        # The rate of the gap starts at zero and has to end at zero: its slopes sum up to nothing.
        smooth, sharp = (self._whole(rate) for rate in self._rates)
        return np.asarray(-smooth / sharp)

    def _whole(self, density: Array) -> Array:
        return np.asarray(self.fields.panels.integrals(density).sum(axis=0))

    @cached_property
    def mismatch(self) -> Array:
        """Residuals of the two conditions, (2,) or (2, k).

        They are the pressure left where the contact opens, over its base, and the gap left where it
        closes, over that of R alone; the known rate of the gap lets v - c weight its slope.
        """
        slope, base = self.fields.traction_slope, -self.fields.load.base_shear
        pressure = base - self._whole(slope) - self.term * self._whole(slope * self._share)
        smooth, sharp = (self._whole(rate * self.fields.panels.at.from_c) for rate in self._rates)
        return np.stack([pressure / base, 1 + self.term * sharp / smooth])


RULE_SHARE, LEAST_TOLERANCE = 1e-2, 1e-14
"""Tolerance over what is asked for, and at least: shear is to find nothing missing in it."""


@dataclass(frozen=True)
class NormalFields:
    """Pressure and gap where the contact opens: minus pressure as traction, gap as slip."""

    opening: OpenPart
    profile: Profile
    error: float

    def pressure(self, at: CutPoints) -> Array:
        """Return the contact pressure at points on the cut, any shape; 0 where it is open."""
        return -self.profile.traction_at(CutPoints(at.parts.reshape(4, -1))).reshape(at.v.shape)

    def known_pressure(self) -> Array:
        """Slownesses of the nodes, increasing, and approximate pressures there, (2, n).

        The pressures are sums over nodes, right to some thousandths.
        """
        fields, panels = self.profile.fields, self.profile.panels
        fall = (fields.traction_slope * panels.jacobian).ravel() * panels.rule.spacing
        # Half of what a node stands for lies behind it: the midpoint of the sums around it.
        pressure = -fields.base_traction - np.cumsum(fall) + fall / 2
        pressure[np.repeat(panels.layout.slipping, len(panels.rule.y))] = 0.0
        return np.stack([panels.at.v.ravel(), np.maximum(pressure, 0.0)])


def with_opening(
    load: Load, factors: RayleighFactors, rtol: float
) -> tuple[Load, NormalFields | None]:
    """Return the load with the contact open where it opens, and the normal problem; None if closed.

    `factors` are those of shear, in plane or antiplane.  Raises ComputationError if the edges of
    the opening are not found.
    """
    # So little suction would open the contact within rounding of its edge.
    if -LEAST_BASE * load.base_pressure <= load.load_pressure < 0:
        return replace(load, load_pressure=0.0), None
    normal, of_mode = normal_problem(load, factors.poisson_ratio, rtol), factors.of_in_plane
    if normal is None:
        return load, None
    opened = Opened(
        normal.opening.zone.seen_by(of_mode),
        tuple((of_mode(edge), amount) for edge, amount in normal.opening.closing),
        load.base_pressure,
        load.load_pressure,
        partial(_pressure, normal, factors),  # a function that can be pickled
        normal.known_pressure(),
        load.slowness,
    )
    return replace(load, opened=opened), normal


def _pressure(normal: NormalFields, factors: RayleighFactors, at: CutPoints) -> Array:
    return normal.pressure(factors.seen_in_plane(at))


def normal_problem(load: Load, poisson_ratio: float, rtol: float) -> NormalFields | None:
    """Solve the normal problem of a load to an accuracy; None if the contact stays closed."""
    tolerance = max(rtol * RULE_SHARE, LEAST_TOLERANCE)
    of_load = poisson_ratio, load.base_pressure, load.load_pressure
    opening = opening_of(*of_load, tolerance, load.slowness)
    # Slip zones are placed with the rest of rtol, which the opening must not use up.
    while opening and opening.error > 0.2 * rtol and tolerance > LEAST_TOLERANCE:
        tolerance = max(tolerance * RULE_SHARE, LEAST_TOLERANCE)
        opening = opening_of(*of_load, tolerance, load.slowness)
    if opening is None:
        return None
    given = normal_load(load.base_pressure, load.load_pressure, load.slowness)
    factors, rule = rayleigh_factors(poisson_ratio, "I"), rule_for(tolerance)
    fields = ZoneFields(factors, given, (opening.zone,), rule, closing=opening.closing)
    # At most 4.5 tolerances between nodes, next to the threshold in all scenes.
    return NormalFields(opening, Profile(fields), opening.error + 6.0 * tolerance)
