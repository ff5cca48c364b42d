"""How placed zones and their fields change with a parameter: implicit differentiation.

The edges e fulfil m(e, p) = 0 for every value of a parameter p, so de/dp = -J^(-1) dm/dp with the
Jacobian J of the mismatch m.  On the nodes of panels, which move with the edges, fields are
analytic in p whatever their powers at the edges.  So they are differenced there, along de/dp, to
fourth order; what the nodes move by is taken off afterwards (`varied`).  For zones that stay the
fields are linear in the tractions: that part is exact.
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
from semianalytic.halfplane.rules import Rule
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar import tuning
from semianalytic.selfsimilar.edges import Edges, edges_of, linearised


@dataclass(frozen=True)
class Rates:
    """What a parameter changes, and how fast: derivatives with respect to it.

    Attributes
    ----------
    friction : of the coefficient
    base_pressure, base_shear, load_pressure, load_shear : of tractions [stress unit]
    far_slip_rate : of V(inf) [stress unit / (mu b)]
    poisson_ratio : 1 for the Poisson ratio itself
    """

    friction: float = 0.0
    base_pressure: float = 0.0
    base_shear: float = 0.0
    load_pressure: float = 0.0
    load_shear: float = 0.0
    far_slip_rate: float = 0.0
    poisson_ratio: float = 0.0

    def of_load(self, load: Load) -> Load | None:
        """The load whose fields are the derivatives of those of a load, for zones that stay.

        All are linear in shear tractions and in friction times pressure; None if none changes.
        """
        if self.poisson_ratio:
            return None
        shear = {"base_shear": self.base_shear, "load_shear": self.load_shear}
        rest = {**shear, "far_slip_rate": self.far_slip_rate}
        if self.friction:
            return replace(load, friction=self.friction, **rest)
        pressed = {"base_pressure": self.base_pressure, "load_pressure": self.load_pressure}
        return replace(load, **pressed, **rest)


@dataclass(frozen=True)
class Stencil:
    """A difference of fourth order: steps away, their weights, and the step."""

    offsets: Array
    weights: Array
    step: float

    @property
    def points(self) -> Array:
        """Values of the parameter, less its own."""
        return self.offsets * self.step

    def difference(self, values: Array, axis: int) -> Array:
        """The derivative from values on all points, which lie along an axis."""
        return np.tensordot(values, self.weights / self.step, ([axis], [0]))


def _stencils(step: float) -> Iterator[Stencil]:
    """Central ones, and ones to a side for where neighbours on the other have other panels."""
    central = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / 12
    aside = np.arange(5.0), np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12
    for size in (step, step / 10):
        yield Stencil(*central, size)
        yield Stencil(*aside, size)
        yield Stencil(*aside, -size)


@dataclass(frozen=True)
class NodeFields:
    """Fields at the nodes of panels, times dv/dy, and where the panels are; or derivatives of them.

    Attributes
    ----------
    rate, traction : (p, n) arrays, slopes of slip rate, and of traction less what is unbounded at
        a stuck contact edge, times dv/dy
    rate_starts, traction_starts : (p,) arrays, slip rate and traction at the left of each panel
    ends, skew : (4, m, 1) and (p, 1) arrays, of the panels
    tail : () array, limit of v^2 dV/dv
    intensity : () array, of the traction at a stuck contact edge
    """

    rate: Array
    traction: Array
    rate_starts: Array
    traction_starts: Array
    ends: Array
    skew: Array
    tail: Array
    intensity: Array

    @classmethod
    def of(cls, profile: Profile) -> NodeFields:
        """Of a profile; of k sets of zones with an axis of k, at the place `_SETS` says."""
        panels, (rate, traction) = profile.panels, profile._starts
        return cls(
            profile._slip_rate.density * panels.jacobian,
            profile._traction.density * panels.jacobian,
            rate,
            traction,
            panels.ends.parts,
            panels.skew,
            np.asarray(profile._slip_rate.tail),
            np.asarray(profile.edge_intensity),
        )

    @classmethod
    def zero(cls, profile: Profile) -> NodeFields:
        """Derivatives of a profile that does not change."""
        return cls(*(np.zeros_like(part) for part in NodeFields.of(profile)._parts))

    @property
    def _parts(self) -> list[Array]:
        return [getattr(self, one.name) for one in fields(self)]

    @classmethod
    def difference(cls, beside: list[NodeFields], stencil: Stencil) -> NodeFields:
        """Derivatives from neighbours on a stencil: one by one, or all as sets of one."""
        parts, count = [], len(stencil.weights)
        for every, axis in zip(
            zip(*(one._parts for one in beside), strict=True), _SETS, strict=True
        ):
            values = np.stack(every, axis) if len(beside) > 1 else every[0]
            if axis == 0:
                values = np.broadcast_to(values, (count,))
            parts.append(stencil.difference(values, axis))
        return cls(*parts)

    def plus(self, other: NodeFields) -> NodeFields:
        """With the fields of others on the same panels, which stay."""
        sums = [a + b for a, b in zip(self._parts, other._parts, strict=True)]
        return replace(NodeFields(*sums), ends=self.ends, skew=self.skew)


_SETS = (1, 1, 1, 1, 2, 1, 0, 0)


@dataclass(frozen=True)
class Variation:
    """Derivatives of placed zones and their fields.

    Attributes
    ----------
    rates : Rates, of the parameter
    unknowns : (e,) array, of the unknowns of `edges`
    nodes : NodeFields, at fixed nodes
    stencil : Stencil by which they were differenced; None if the zones stay
    """

    rates: Rates
    unknowns: Array
    nodes: NodeFields
    stencil: Stencil | None


@dataclass(frozen=True)
class Surroundings:
    """Placed zones, and what their neighbours on the same nodes show.

    Attributes
    ----------
    profile : Profile of the zones
    step : float, of logits and logarithms of edges between neighbours
    """

    profile: Profile
    step: float = tuning.VARIED_STEP

    @property
    def _fields(self) -> ZoneFields:
        return self.profile.fields

    @cached_property
    def _rule(self) -> Rule:
        return replace(self.profile.panels.rule, held=True)

    @cached_property
    def _placed(self) -> tuple[Edges, Array]:
        return edges_of(self._fields.factors, self._fields.zones)

    @cached_property
    def _inverse(self) -> Array:
        """(e, e) inverse Jacobian of the mismatch, to a few digits."""
        edges, unknowns = self._placed
        if not len(unknowns):
            return np.zeros((0, 0))
        _, jacobian = linearised(edges, unknowns, self._fields.load, self._rule)
        return np.asarray(np.linalg.inv(jacobian))

    def _factors(self, rates: Rates, points: Array) -> list[RayleighFactors]:
        """Those of neighbours, one for all if the Poisson ratio stays."""
        own = self._fields.factors
        if not rates.poisson_ratio:
            return [own]
        return [rayleigh_factors(float(own.poisson_ratio + point)) for point in points]

    def _neighbours(
        self, rates: Rates, moved: Array, points: Array, tail: bool
    ) -> list[ZoneFields]:
        """Zones beside these: sets of one, or one by one if the Poisson ratio changes."""
        edges, unknowns = self._placed
        every = unknowns[:, None] + moved[:, None] * points
        factors = self._factors(rates, points)
        columns = [every] if len(factors) == 1 else list(every.T)
        return [
            replace(
                self._fields,
                factors=own,
                zones=replace(edges, factors=own).zones(column),
                rule=self._rule,
                tail=tail,
            )
            for own, column in zip(factors, columns, strict=True)
        ]

    def _stencil(self, rates: Rates, moved: Array) -> Stencil | None:
        """Points at which neighbours in a direction have the same panels; None if none moves."""
        largest, nu = float(np.abs(moved).max(initial=0.0)), self._fields.factors.poisson_ratio
        lengths = [self.step / largest] if largest else []
        lengths += [self.step * min(0.5 - nu, 1 + nu)] if rates.poisson_ratio else []
        if not lengths:
            return None
        for stencil in _stencils(min(lengths)):
            outer = [
                one
                for point in (stencil.points[0], stencil.points[-1])
                for one in self._neighbours(rates, moved, np.array([point, point]), True)
            ]
            if all(one.layout == self._fields.layout for one in outer):
                return stencil
        raise ComputationError(
            "the zones beside the solution are of another kind however near; ask for the "
            "derivative a little to one side of the parameter."
        )

    def variation(self, rates: Rates) -> Variation:
        """Derivatives with respect to a parameter.

        Raises
        ------
        ComputationError
            If zones on either side of these, however near, have other panels.
        """
        fields, load = self._fields, rates.of_load(self._fields.load)
        fixed = None if load is None else replace(fields, load=load, rule=self._rule)
        unfulfilled, moved = np.zeros((2, len(self._placed[1])))
        if fixed is not None and len(moved):
            unfulfilled = replace(fixed, tail=False).mismatch()
            moved = -self._inverse @ unfulfilled
        stencil = self._stencil(rates, moved)
        for _ in range(tuning.MOST_IMPROVEMENTS if stencil and len(moved) else 0):
            beside = self._neighbours(rates, moved, stencil.points, False)
            values = np.stack([one.mismatch() for one in beside], -1)
            gained = stencil.difference(values.reshape(len(moved), -1), 1)
            change = -self._inverse @ (unfulfilled + gained)
            moved = moved + change
            stencil = self._stencil(rates, moved)
            if np.abs(change).max() <= tuning.IMPROVED_SHARE * np.abs(moved).max():
                break
        nodes = NodeFields.zero(self.profile)
        if stencil:
            beside = self._neighbours(rates, moved, stencil.points, True)
            nodes = NodeFields.difference([NodeFields.of(Profile(one)) for one in beside], stencil)
        if fixed is not None:
            nodes = nodes.plus(NodeFields.of(Profile(fixed)))
        return Variation(rates, moved, nodes, stencil)
