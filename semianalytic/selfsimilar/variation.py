"""Differentiate placed zones and their fields with respect to a parameter, implicitly.

The edges e satisfy m(e, p) = 0 for every value of a parameter p, so that de/dp = -J^(-1) dm/dp with
the Jacobian J of the mismatch m. At the nodes of panels, which move with the edges, fields are
analytic in p whatever their powers at the edges. They are therefore differenced there, along de/dp,
to fourth order; the contribution of the motion of the nodes is subtracted afterwards (`varied`).
For fixed zones the fields are linear in the tractions, and that part is exact. See
docs/derivatives.md, "Fields".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import Array, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar import tuning
from semianalytic.selfsimilar.edges import Edges, edges_of, linearised
from semianalytic.separation.normal import with_opening

_OF_SLOWNESS = 0.5
"""Step of the slowness of the front of a load over its distance from the first front, before which
fields bend; the share of the step in it is that of every unknown."""
_OF_POISSON = 0.25
"""Step of the Poisson ratio over its distance from its bounds: the longitudinal front moves, and
fields on nodes right behind it bend faster than the ratio itself."""


_OF_LOAD = (
    "friction",
    "base_pressure",
    "base_shear",
    "load_pressure",
    "load_shear",
    "far_slip_rate",
    "resistance",
    "slowness",
)
"""Numbers of a load that a parameter may change."""


@dataclass(frozen=True)
class Rates:
    """Derivatives of the load and the material with respect to a parameter.

    Attributes
    ----------
    friction : float
        Derivative of the coefficient.
    base_pressure, base_shear, load_pressure, load_shear : float
        Derivatives of tractions [stress unit].
    far_slip_rate : float
        Derivative of V(inf) [stress unit / (mu b)].
    resistance : float
        Derivative of eta [mu b].
    poisson_ratio : float
        1 for the Poisson ratio itself.
    slowness : float
        Derivative of the slowness p of the front of the load [b].
    front_excess : float
        Derivative of the base shear less friction, where slip starts at the longitudinal front of
        a base at friction; the base ahead of it then sticks [stress unit].
    """

    friction: float = 0.0
    base_pressure: float = 0.0
    base_shear: float = 0.0
    load_pressure: float = 0.0
    load_shear: float = 0.0
    far_slip_rate: float = 0.0
    resistance: float = 0.0
    poisson_ratio: float = 0.0
    slowness: float = 0.0
    front_excess: float = 0.0

    @property
    def nonlinear(self) -> bool:
        """Whether fields are not linear in what changes, for fixed zones."""
        return bool(self.poisson_ratio or self.resistance or self.slowness)

    @property
    def of_pressure(self) -> bool:
        """Whether a pressure of the base or the load changes."""
        return bool(self.base_pressure or self.load_pressure)

    def of_load(self, load: Load) -> Load | None:
        """Return the load whose fields are the derivatives of those of a load, for fixed zones.

        All fields are linear in shear tractions and in friction times pressure. The result is None
        if anything else changes: impedances, or the open part of the contact.
        """
        # A change of pressure moves the ends of the opening, and fields are not linear in these.
        if self.nonlinear or (load.opened and self.of_pressure):
            return None
        friction, pressures = load.friction, (self.base_pressure, self.load_pressure)
        # d(f p) = df p + f dp, of which one part is zero.
        if self.friction or load.opened:  # whose pressure stays
            friction, pressures = self.friction, (load.base_pressure, load.load_pressure)
        return replace(
            load,
            friction=friction,
            base_pressure=pressures[0],
            base_shear=self.base_shear,
            load_pressure=pressures[1],
            load_shear=self.load_shear,
            far_slip_rate=self.far_slip_rate,
        )


@dataclass(frozen=True)
class Stencil:
    """Finite difference: offsets of its points in steps, their weights, and the step."""

    offsets: Array
    weights: Array
    step: float

    @property
    def points(self) -> Array:
        """Differences of the parameter from its own value."""
        return self.offsets * self.step

    def difference(self, values: Array, axis: int) -> Array:
        """Return the derivative from values at all points, which lie along an axis."""
        return np.tensordot(values, self.weights / self.step, ([axis], [0]))


# Weights of f' from f at the offsets: central of order 2 and 4, and one-sided of order 4.
_SECOND_ORDER = np.array([-1.0, 1.0]), np.array([-0.5, 0.5])
_FOURTH_ORDER = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / 12
_TO_ONE_SIDE = np.arange(5.0), np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12


def _stencils(step: float, central: tuple[Array, Array]) -> Iterator[Stencil]:
    """Yield central differences, and one-sided ones for neighbours with other panels on one
    side."""
    # Beside a change of the set of zones a tenth of the step may still stay on this side.
    for size in (step, step / 10):
        yield Stencil(*central, size)
        yield Stencil(*_TO_ONE_SIDE, size)
        yield Stencil(*_TO_ONE_SIDE, -size)


@dataclass(frozen=True)
class NodeFields:
    """Fields at the nodes of panels, times dv/dy, and the positions of the panels; or derivatives.

    Attributes
    ----------
    rate, traction : (p, n) arrays
        Slopes of slip rate, and of traction less the part unbounded at a stuck contact edge,
        times dv/dy.
    rate_starts, traction_starts : (p,) arrays
        Slip rate and traction at the left of each panel.
    ends, skew : (4, m, 1) and (p, 1) arrays
        Ends and rho of the panels.
    amounts, exponents : (q, 1) arrays
        Powers that the slope of slip rate has beside borders of an opening; not part of `rate`.
    tail : () array
        Limit of v^2 dV/dv, as of `Profile`.
    intensity : () array
        Intensity of the traction at a stuck contact edge.
    """

    rate: Array
    traction: Array
    rate_starts: Array
    traction_starts: Array
    ends: Array
    skew: Array
    amounts: Array
    exponents: Array
    tail: Array
    intensity: Array

    @classmethod
    def of(cls, profile: Profile) -> NodeFields:
        """Return the fields of a profile; for k sets of zones, with an axis of k where `_SETS`
        says."""
        panels, (rate, traction) = profile.panels, profile.starts
        return cls(
            profile.rate_integral.density * panels.jacobian,
            profile.traction_integral.density * panels.jacobian,
            rate,
            traction,
            panels.ends.parts,
            panels.skew,
            *_of_powers(profile),
            profile.tail,
            np.asarray(profile.edge_intensity),
        )

    @classmethod
    def zero(cls, profile: Profile) -> NodeFields:
        """Return the derivatives of a profile that does not change."""
        return cls(*(np.zeros_like(part) for part in NodeFields.of(profile)._parts))

    @property
    def _parts(self) -> list[Array]:
        return [getattr(self, one.name) for one in fields(self)]

    @classmethod
    def difference(cls, beside: list[NodeFields], stencil: Stencil) -> NodeFields:
        """Return derivatives from neighbours on a stencil: one by one, or all as sets of one."""
        parts, count = [], len(stencil.weights)
        for every, axis in zip(
            zip(*(one._parts for one in beside), strict=True), _SETS, strict=True
        ):
            values = np.stack(every, axis) if len(beside) > 1 else every[0]
            # Numbers that all sets share have no axis of sets, and their difference is 0.
            if axis == 0:
                values = np.broadcast_to(values, (count,))
            parts.append(stencil.difference(values, axis))
        return cls(*parts)

    def plus(self, other: NodeFields) -> NodeFields:
        """Return the sum of two derivatives."""
        return NodeFields(*(a + b for a, b in zip(self._parts, other._parts, strict=True)))

    @property
    def of_resting_panels(self) -> NodeFields:
        """The part of the derivatives that is left if panels and the exponents of X are held."""
        resting = {
            name: np.zeros_like(getattr(self, name)) for name in ("ends", "skew", "exponents")
        }
        return replace(self, **resting)


_SETS = (1, 1, 1, 1, 2, 1, 1, 1, 0, 0)


def _widths(fields: ZoneFields) -> Array:
    """Return the widths (r, ...) of what lies between the ends of panels, without hidden roots.

    Fields are smooth at the cut beside a hidden root. An edge that lies close to it may cross it,
    so that a panel that ends there does not limit the step.
    """
    cuts = [cut.first[0] for cut in fields.factors.in_plane.cuts[:-1]]
    panels, kept, before = fields.panels, [], np.zeros(1)
    for width, right in zip(panels.widths[..., 0], panels.right, strict=False):
        before = before + width
        if right is None or right.first[0] not in cuts:
            kept.append(before)
            before = np.zeros(1)
    return np.reshape(kept, (len(kept), *panels.widths.shape[1:-1]))


def _of_powers(profile: Profile) -> tuple[Array, Array]:
    """Return amounts and exponents (q, ..., 1) of the powers of a profile's slope of slip rate."""
    powers, shape = profile.rate_integral.powers, (*profile.panels.jacobian.shape[1:-1], 1)
    amounts, exponents = np.empty((2, len(powers), *shape))
    for i, power in enumerate(powers):
        amounts[i], exponents[i] = power.amount, power.exponent
    return amounts, exponents


@dataclass(frozen=True)
class Variation:
    """Derivatives of placed zones and their fields.

    Attributes
    ----------
    rates : Rates
        Derivatives of load and material.
    unknowns : (e,) array
        Derivatives of the unknowns of `edges`.
    nodes : NodeFields
        Derivatives at fixed nodes.
    stencil : Stencil or None
        Stencil by which they were differenced; None if the zones stay.
    normal : NodeFields or None
        Derivatives of the normal problem; None if it stays.
    """

    rates: Rates
    unknowns: Array
    nodes: NodeFields
    stencil: Stencil | None
    normal: NodeFields | None = None

    @property
    def of_normal(self) -> Variation | None:
        """Variation of the normal problem, minus pressure for traction; None if it stays."""
        if self.normal is None:
            return None
        rates = Rates(
            base_shear=-self.rates.base_pressure,
            load_shear=-self.rates.load_pressure,
            poisson_ratio=self.rates.poisson_ratio,
            slowness=self.rates.slowness,
        )
        return Variation(rates, self.unknowns, self.normal, self.stencil)


@dataclass(frozen=True)
class _Change:
    """Derivatives at fixed nodes, of shear and of the normal problem (None if all is closed)."""

    nodes: NodeFields
    normal: NodeFields | None

    @classmethod
    def of(cls, beside: list[ZoneFields], stencil: Stencil) -> _Change:
        """Return the derivatives from neighbours on a stencil."""
        profiles = [Profile(one) for one in beside]
        normals = [NodeFields.of(one.normal) for one in profiles if one.normal is not None]
        return cls(
            NodeFields.difference([NodeFields.of(one) for one in profiles], stencil),
            NodeFields.difference(normals, stencil) if normals else None,
        )

    def plus(self, other: _Change) -> _Change:
        """Return the sum of two changes."""
        normal = self.normal
        if normal is not None and other.normal is not None:
            normal = normal.plus(other.normal)
        return _Change(self.nodes.plus(other.nodes), normal)


@dataclass(frozen=True)
class Surroundings:
    """Placed zones, and neighbouring zones on the same nodes.

    Attributes
    ----------
    profile : Profile
        Profile of the zones.
    finer : Surroundings or None
        Surroundings of which these are the `companion`.
    """

    profile: Profile
    finer: Surroundings | None = None

    @cached_property
    def companion(self) -> Surroundings:
        """Surroundings of the same zones on a coarser rule, with the edges that this rule requires.

        Their derivatives share only the Jacobian with those of the zones, and the Jacobian only
        affects the direction of differences. Rule, nodes, edges and step differ.
        """
        (edges, unknowns), fields = self._placed, self._fields
        rule = rule_for(tuning.COARSER_COMPANION * fields.rule.tolerance)
        # One chord step places the edges on the coarser rule: they are off by its error only.
        if len(unknowns):
            left = replace(fields, rule=rule).mismatch()
            unknowns = unknowns - self._inverse @ left.reshape(-1)
        placed = replace(fields, rule=rule, zones=edges.zones(unknowns))
        return Surroundings(Profile(placed), self)

    @property
    def _fields(self) -> ZoneFields:
        return self.profile.fields

    @cached_property
    def _rule(self) -> Rule:
        return replace(self.profile.panels.rule, held=True)

    @cached_property
    def _loose_rule(self) -> Rule:
        """Rule on which directions are found, to the digits of a Jacobian."""
        return rule_for(max(tuning.DIRECTION_RULE, self._fields.rule.tolerance))

    @cached_property
    def _placed(self) -> tuple[Edges, Array]:
        opened = self._fields.load.opened
        opening = opened.zone if opened else None
        return edges_of(self._fields.factors, self._fields.zones, opening)

    @cached_property
    def _inverse(self) -> Array:
        """Inverse Jacobian (e, e) of the mismatch, to about six digits."""
        if self.finer is not None:
            return self.finer._inverse
        edges, unknowns = self._placed
        if not len(unknowns):
            return np.zeros((0, 0))
        _, jacobian = linearised(edges, unknowns, self._fields.load, self._loose_rule)
        return np.asarray(np.linalg.inv(jacobian))

    def _neighbours(
        self, rates: Rates, moved: Array, points: Array, rule: Rule | None = None
    ) -> list[ZoneFields]:
        """Return neighbouring zones: as sets of one, or one by one if more than the edges changes.

        They are on the nodes of these zones, or on another rule without the tail behind the last
        edge.
        """
        (edges, unknowns), fields = self._placed, self._fields
        every, tail = unknowns[:, None] + moved[:, None] * points, rule is None
        fields = replace(fields, rule=rule or self._rule, tail=tail)
        if not self._one_by_one(rates):
            return [replace(fields, zones=edges.zones(every))]
        result = []
        for point, column in zip(points.tolist(), every.T, strict=True):
            own, load = self._beside(rates, point)
            opening = load.opened.zone if load.opened else None
            zones = replace(edges, factors=own, opening=opening).zones(column)
            result.append(replace(fields, factors=own, load=load, zones=zones))
        return result

    def _one_by_one(self, rates: Rates) -> bool:
        """Return whether more than the edges changes, so that neighbours cannot share one sweep."""
        opened = self._fields.load.opened is not None and rates.of_pressure
        return bool(rates.nonlinear or opened)

    def _beside(self, rates: Rates, point: float) -> tuple[RayleighFactors, Load]:
        """Return factors and load at a changed value of the parameter, with the opening under that
        load."""
        factors, load = self._fields.factors, self._fields.load
        own = rayleigh_factors(factors.poisson_ratio + rates.poisson_ratio * point, factors.mode)
        changed = {
            name: getattr(load, name) + getattr(rates, name) * point
            for name in _OF_LOAD
            if getattr(rates, name)
        }
        load = replace(load, **changed)
        # A film changes no pressure, so the opening stays where it is.
        if load.opened is None or rates.resistance:
            return own, load
        known = self._opened
        if (rates, point) not in known:
            opened, _ = with_opening(replace(load, opened=None), own, tuning.VARIED_OPENING)
            known[rates, point] = opened
        return own, known[rates, point]

    @cached_property
    def _opened(self) -> dict[tuple[Rates, float], Load]:
        """Loads with their openings, for neighbours that have been computed."""
        return {}

    def _unfulfilled(self, beside: list[ZoneFields], stencil: Stencil) -> Array:
        """Return the derivatives (e,) of the mismatch from neighbours."""
        values = np.stack([one.mismatch() for one in beside], -1)
        return stencil.difference(values.reshape(-1, len(stencil.points)), 1)

    def _step(self, rates: Rates, moved: Array) -> float:
        """Return the longest step in a direction that changes no panel by much; infinite if none
        moves."""
        step = self._step_of_unknowns(rates, moved)
        for _ in range(tuning.MOST_NARROWINGS if step < np.inf else 0):
            change = self._change_of_widths(rates, moved, step)
            if change <= self._share_of_step:
                break
            step *= max(self._share_of_step / change, tuning.FASTEST_NARROWING)
        return step

    def _change_of_widths(self, rates: Rates, moved: Array, step: float) -> float:
        """Return the largest change of the logarithm of a panel's width by a step in a direction.

        The unknowns do not represent how narrow a zone is, nor the slip ahead of an opening.
        """
        beside = self._neighbours(rates, moved, np.array([-step, step]), self._loose_rule)
        one, other = (_widths(fields) for fields in (beside[0], beside[-1]))
        if len(beside) == 1:
            one, other = one[:, 0], other[:, 1]
        # Other panels, or a negative width, mean that the step crosses a change of zones.
        if one.shape != other.shape or np.any(one <= 0) or np.any(other <= 0):
            return np.inf
        return float(np.abs(np.log(other / one)).max(initial=0.0)) / 2

    def _step_of_unknowns(self, rates: Rates, moved: Array) -> float:
        """Return the longest step in a direction that the unknowns and the parameter itself
        allow."""
        steps, nu = [np.inf], self._fields.factors.poisson_ratio
        if moved.any():
            steps.append(1 / float(np.abs(moved).max()))
        # Fields are singular at nu = 1/2, where a = 0, and at nu = -1.
        if rates.poisson_ratio:
            steps.append(_OF_POISSON * min(0.5 - nu, 1 + nu))
        if rates.resistance:
            steps.append(float(np.max(self._fields.load.resistance or 0.0)))
        if rates.slowness:
            # the pole of the load at v = p keeps its distance from the first front
            distance = self._fields.panels.ends.v[0].flat[0] - self._fields.load.slowness
            steps.append(_OF_SLOWNESS * float(distance) / abs(rates.slowness))
        steps.extend(self._steps_of_opening(rates))
        return self._share_of_step * min(steps)

    def _steps_of_opening(self, rates: Rates) -> list[float]:
        """Return changes of a parameter that would close the contact or bring the base to zero."""
        load, factors = self._fields.load, self._fields.factors
        if load.opened is None:
            return []
        stuck = load.stuck(factors, "I").at_rayleigh_front
        margin = load.base_pressure
        if load.load_pressure > 0:
            # The contact closes at the Rayleigh front when P_b + P_0 p*(c) = 0.
            margin = min(margin, abs(margin + load.load_pressure * stuck))
        fastest = abs(rates.base_pressure) + abs(rates.load_pressure)
        of_front = abs(rates.poisson_ratio) + abs(rates.slowness)
        fastest += of_front * abs(load.load_pressure) * (load.load_pressure > 0)
        return [margin / fastest] if fastest else []

    @property
    def _share_of_step(self) -> float:
        shorter = 1.0 if self.finer is None else tuning.COMPANION_STEP
        return tuning.VARIED_STEP * shorter

    def _stencil(
        self, rates: Rates, moved: Array, central: tuple[Array, Array] = _FOURTH_ORDER
    ) -> Stencil | None:
        """Return a stencil whose neighbours in a direction have the same panels; None if none
        moves."""
        step = self._step(rates, moved)
        if step == np.inf:
            return None
        for stencil in _stencils(step, central):
            ends = (stencil.points[[0, 0]], stencil.points[[-1, -1]])
            outer = [one for end in ends for one in self._neighbours(rates, moved, end)]
            if all(one.layout == self._fields.layout for one in outer):
                return stencil
        raise ComputationError(
            "the zones beside the solution are of another kind however near; ask for the "
            "derivative a little to one side of the parameter."
        )

    def variation(self, rates: Rates) -> Variation:
        """Return the derivatives with respect to a parameter.

        Parameters
        ----------
        rates : Rates
            Derivatives of load and material with respect to it.

        Raises
        ------
        ComputationError
            If zones on either side of these, however near, have other panels.
        """
        load, resting = rates.of_load(self._fields.load), np.zeros(len(self._placed[1]))
        differenced = load is None
        if differenced and rates.front_excess:
            # What a sticking base retains is linear in the tractions, however the opening moves.
            load = Rates().of_load(self._fields.load)
        nodes, unfulfilled = NodeFields.zero(self.profile), resting
        # The exact part: fields of the load of derivatives on the present panels.
        if load is not None:
            fixed = self._let_go(replace(self._fields, load=load, rule=self._rule), rates)
            nodes = NodeFields.of(Profile(fixed)).of_resting_panels
            unfulfilled = fixed.mismatch().reshape(-1)
        along = unfulfilled
        if differenced and len(resting):
            # A second-order difference on a loose rule suffices to find the direction de/dp.
            first = Stencil(*_SECOND_ORDER, self._step(rates, resting))
            beside = self._neighbours(rates, resting, first.points, self._loose_rule)
            along = unfulfilled + self._unfulfilled(beside, first)
        # The mismatch F(e, p) stays 0: de/dp = -(dF/de)^-1 dF/dp.
        moved = -self._inverse @ along
        stencil = self._stencil(rates, moved)
        if stencil is None:
            return Variation(rates, moved, nodes, None)
        beside = self._neighbours(rates, moved, stencil.points)
        change = _Change.of(beside, stencil)
        change = replace(change, nodes=nodes.plus(change.nodes))
        if len(moved):
            unfulfilled = unfulfilled + self._unfulfilled(beside, stencil)
            # The Jacobian is inexact; one more difference along the residual compensates for that.
            moved, change = self._improved(moved, change, unfulfilled)
        normal = change.normal if self._one_by_one(rates) else None
        return Variation(rates, moved, change.nodes, stencil, normal)

    def _let_go(self, fields: ZoneFields, rates: Rates) -> ZoneFields:
        """Return fields with the part of slip at the longitudinal front that a sticking base
        retains.

        Behind the front the traction equals the strength. It jumps by minus the excess, like a term
        r / (k + a) of T, and the slip rate by the excess over the impedance. A strip that sticks
        behind the front makes both smooth; its width is of higher order (docs/derivatives.md,
        "Where the set of zones changes").
        """
        if not rates.front_excess:
            return fields
        factors, load, front = fields.factors, fields.load, self.profile.panels.left[0]
        root = float(np.sqrt(1 - factors.a**2))
        # M(a) in units b = mu = 1.
        impedance = root if factors.mode == "III" else (1 - 2 * factors.a**2) ** 2 / root
        rate = rates.front_excess / float(impedance + (load.resistance or 0.0))
        amount = impedance * rate * factors.a / self._fields.canonical.values[0, ..., 0]
        # T(0) is that of the load: V behind the front is no far slip rate
        load = replace(load, far_slip_rate=rate, load_shear=load.load_shear + rate)
        return replace(fields, load=load, closing=((front, float(amount)),))

    def _improved(self, moved: Array, change: _Change, unfulfilled: Array) -> tuple[Array, _Change]:
        """Return derivatives of unknowns and fields, corrected for the remaining mismatch."""
        largest = float(np.abs(moved).max())
        for _ in range(tuning.MOST_IMPROVEMENTS):
            more = -self._inverse @ unfulfilled
            if np.abs(more).max() <= tuning.NEGLIGIBLE_CHANGE * largest:
                break
            stencil = self._stencil(Rates(), more, _SECOND_ORDER)
            assert stencil is not None
            beside = self._neighbours(Rates(), more, stencil.points)
            change = change.plus(_Change.of(beside, stencil))
            unfulfilled = unfulfilled + self._unfulfilled(beside, stencil)
            moved = moved + more
        return moved, change
