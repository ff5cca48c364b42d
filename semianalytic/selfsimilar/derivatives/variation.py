"""Differentiate placed zones and their fields with respect to a parameter, implicitly.

The edges e satisfy m(e, p) = 0 for every value of a parameter p, so that de/dp = -J^(-1) dm/dp with
the Jacobian J of the mismatch m. At the nodes of panels, which move with the edges, fields are
analytic in p whatever their powers at the edges. They are therefore differenced there, along de/dp,
to fourth order; the contribution of the motion of the nodes is subtracted afterwards (`varied`).
For fixed zones the fields are linear in the tractions, and that part is exact. See
docs/derivatives.md, "Fields".
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.node_fields import SECOND_ORDER, NodeFields, Stencil, stencils
from semianalytic.cut.profile import Profile
from semianalytic.cut.rates import Rates
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.polynomials import FOURTH_ORDER
from semianalytic.halfplane.rayleigh import RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.edges import Edges, edges_of
from semianalytic.selfsimilar.zones.placement import linearised
from semianalytic.separation.opening import with_opening

_OF_LOAD = {field.name for field in fields(Rates)} - {"poisson_ratio", "front_excess"}
"""Numbers of a load that a parameter may change."""


def _widths(fields: ZoneFields) -> Array:
    """Return widths (r, ...) between ends of panels but hidden roots, which edges may cross."""
    cuts = [cut.first[0] for cut in fields.factors.in_plane.cuts[:-1]]
    panels, kept, before = fields.panels, [], np.zeros(1)
    for width, right in zip(panels.widths[..., 0], panels.right, strict=False):
        before = before + width
        if right is None or right.first[0] not in cuts:
            kept.append(before)
            before = np.zeros(1)
    return np.reshape(kept, (len(kept), *panels.widths.shape[1:-1]))


@dataclass(frozen=True)
class Variation:
    """Derivatives of placed zones: of load and material, unknowns (e,), and fields at fixed nodes.

    `stencil` is None if the zones stay, `normal` if the normal problem does.
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
        profiles = [Profile(zones) for zones in beside]
        normals = [NodeFields.of(side.normal) for side in profiles if side.normal is not None]
        return cls(
            NodeFields.difference([NodeFields.of(profile) for profile in profiles], stencil),
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
    """Placed zones, and neighbours on the same nodes; `finer` has these as its `companion`."""

    profile: Profile
    finer: Surroundings | None = None

    @cached_property
    def companion(self) -> Surroundings:
        """Surroundings of the same zones on a coarser rule, with the edges that this rule requires.

        Rule, nodes, edges and step differ; the Jacobian is shared and only directs differences.
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
        # As good as a Jacobian from one-sided differences.
        return rule_for(max(1e-6, self._fields.rule.tolerance))

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
        """Return neighbouring zones, as sets of one or one by one, on these nodes or a rule."""
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
        """Return factors and load, with its opening, at a changed value of the parameter."""
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
            opened, _ = with_opening(replace(load, opened=None), own, 1e-12)
            known[rates, point] = opened
        return own, known[rates, point]

    @cached_property
    def _opened(self) -> dict[tuple[Rates, float], Load]:
        """Loads with their openings, for neighbours that have been computed."""
        return {}

    def _unfulfilled(self, beside: list[ZoneFields], stencil: Stencil) -> Array:
        """Return the derivatives (e,) of the mismatch from neighbours."""
        values = np.stack([neighbour.mismatch() for neighbour in beside], -1)
        return stencil.difference(values.reshape(-1, len(stencil.points)), 1)

    def _step(self, rates: Rates, moved: Array) -> float:
        """Return the longest step in a direction that changes no panel by much, or infinity."""
        step = self._step_of_unknowns(rates, moved)
        for _ in range(8 if step < np.inf else 0):  # a strip of 1e-14 is reached
            change = self._change_of_widths(rates, moved, step)
            if change <= self._share_of_step:
                break
            step *= max(self._share_of_step / change, 1e-2)
        return step

    def _change_of_widths(self, rates: Rates, moved: Array, step: float) -> float:
        """Return the largest change of the log of a panel's width by a step in a direction."""
        beside = self._neighbours(rates, moved, np.array([-step, step]), self._loose_rule)
        before, other = (_widths(fields) for fields in (beside[0], beside[-1]))
        if len(beside) == 1:
            before, other = before[:, 0], other[:, 1]
        # Other panels, or a negative width, mean that the step crosses a change of zones.
        if before.shape != other.shape or np.any(before <= 0) or np.any(other <= 0):
            return np.inf
        return float(np.abs(np.log(other / before)).max(initial=0.0)) / 2

    def _step_of_unknowns(self, rates: Rates, moved: Array) -> float:
        """Return the longest step that the unknowns and the parameter itself allow."""
        steps, nu = [np.inf], self._fields.factors.poisson_ratio
        if moved.any():
            steps.append(1 / float(np.abs(moved).max()))
        # Fields are singular at nu = 1/2, where a = 0, and at nu = -1.
        if rates.poisson_ratio:
            # The longitudinal front moves, and fields right behind it bend faster than the ratio
            # itself.
            steps.append(0.25 * min(0.5 - nu, 1 + nu))
        if rates.resistance:
            steps.append(float(np.max(self._fields.load.resistance or 0.0)))
        if rates.slowness:
            # the pole of the load at v = p keeps its distance from the first front
            distance = self._fields.panels.ends.v[0].flat[0] - self._fields.load.slowness
            # Fields bend before the front of the load reaches the first front.
            steps.append(0.5 * float(distance) / abs(rates.slowness))
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
        # Truncation, of fourth order, shows by three quarters.
        shorter = 1.0 if self.finer is None else 0.7
        return 3e-3 * shorter  # truncation and rounding are each some 1e-11

    def _stencil(
        self, rates: Rates, moved: Array, central: tuple[Array, Array] = FOURTH_ORDER
    ) -> Stencil | None:
        """Return a stencil whose neighbours have the same panels; None if none moves."""
        step = self._step(rates, moved)
        if step == np.inf:
            return None
        for stencil in stencils(step, central):
            ends = (stencil.points[[0, 0]], stencil.points[[-1, -1]])
            outer = [neighbour for end in ends for neighbour in self._neighbours(rates, moved, end)]
            if all(neighbour.layout == self._fields.layout for neighbour in outer):
                return stencil
        raise ComputationError(
            "the set of zones changes at this value of the parameter; take the "
            "derivative a little to one side of the parameter."
        )

    def variation(self, rates: Rates) -> Variation:
        """Return the derivatives with respect to a parameter that changes load and material by
        `rates`.

        ComputationError says that zones on either side, however near, have other panels.
        """
        load, resting = rates.of_load(self._fields.load), np.zeros(len(self._placed[1]))
        differenced = load is None
        if differenced and rates.front_excess:
            # The traction that a sticking base retains is linear in the tractions for any opening.
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
            first = Stencil(*SECOND_ORDER, self._step(rates, resting))
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

        Behind the front the traction jumps by minus the excess, like r / (k + a) of T, and the slip
        rate by the excess over the impedance; a strip of width of higher order makes both smooth.
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
        for _ in range(4):  # one is usual
            more = -self._inverse @ unfulfilled
            if np.abs(more).max() <= 1e-11 * largest:
                break
            stencil = self._stencil(Rates(), more, SECOND_ORDER)
            assert stencil is not None
            beside = self._neighbours(Rates(), more, stencil.points)
            change = change.plus(_Change.of(beside, stencil))
            unfulfilled = unfulfilled + self._unfulfilled(beside, stencil)
            moved = moved + more
        return moved, change
