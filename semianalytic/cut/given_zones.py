"""Lay the panels of given zones, and the canonical function that their slip and stick require.

The first of the parts that `zones.ZoneFields` is made of: `given_zones`, `transform`, `slopes` and
`zones` follow docs/theory.md, "Slip under a step, for given zones", equation by equation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.canonical import CanonicalFunction
from semianalytic.cut.load import Load
from semianalytic.cut.quadrature.laying import lay_panels
from semianalytic.cut.quadrature.layout import Layout, Zone, lies_between, outline
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.halfplane.cut_points import CutPoints
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import Array, RayleighFactors
from semianalytic.halfplane.rules import Rule, finer_rule


@dataclass(frozen=True)
class GivenZones:
    """A load and a set of zones, their panels and their canonical function X.

    Attributes
    ----------
    zones : tuple of Zone
        From the longitudinal front inward, in slowness; their edges may hold several
        neighbouring sets at once (see `panels`).
    tail : bool
        Whether the fields behind the last edge are included.
    closing : tuple of (edge, r)
        Terms of edges that close a gap.
    shared : Panels or None
        Panels laid for other zones that are to be used, with ends at all edges of these zones.
    """

    factors: RayleighFactors
    load: Load
    zones: tuple[Zone, ...]
    rule: Rule
    tail: bool = True
    closing: tuple[tuple[CutPoints, float | Array], ...] = ()
    shared: Panels | None = None

    @cached_property
    def panels(self) -> Panels:
        """Panels on a rule as fine and as long as these zones need."""
        if self.shared is not None:
            ends, count = tuple(self.shared.left[1:]), len(self.shared.left)
            _, layout = outline(self.factors, self.zones, True, ends, laid=True)
            if len(layout.sense) > count:
                _, layout = outline(self.factors, self.zones, False, ends, laid=True)
            return replace(self.shared, layout=layout)
        sets, load = np.shape(self.load.friction), self.load
        by_slip = load.resists_rate or load.given_slope is not None
        # Slip behind the last edge enters ln X through the phase of M / (M + eta), and C through a
        # given slope: it cannot be left out then.
        tail = self.tail or by_slip
        opening = load.opened.zone if load.opened else None
        rule = finer_rule(self.rule, *self._beside_resistance)
        return lay_panels(self.factors, self.zones, rule, sets, tail, self._cuts, opening)

    @property
    def _beside_resistance(self) -> tuple[float, float]:
        """Strip of analyticity over pi, and more length in y, of slip up to an edge under strong
        films.
        """
        edge = self.zones[-1].left if self.zones and self.zones[-1].right is None else None
        if edge is None or self.load.resistance is None:
            return 1.0, 0.0
        # M + eta vanishes at about v = i eta / kappa: its modulus over the slowness of the edge.
        root = float(np.max(np.abs(self.load.resistance))) / self.factors.kappa / edge.first[0]
        return 1 - float(np.arctan(root)) / np.pi, float(np.log1p(root))

    @cached_property
    def _cuts(self) -> tuple[CutPoints, ...]:
        """Points within zones at which fields change their character."""
        factors, cuts, opened = self.factors, [], self.load.opened
        # The normal problem is solved on the same panels, which therefore end at its cuts too.
        if opened is not None:
            cuts += [factors.of_in_plane(cut) for cut in factors.in_plane.cuts[:-1]]
        if self.load.resists_rate and factors.has_rayleigh_wave:
            front = factors.front_c
            # At c_R the phase of M / (M + eta) jumps by pi, so that panels under resistance end
            # there (docs/theory.md, "Other conditions on the same cut").
            resists = any(lies_between(one.left, front, one.right) for one in self.zones)
            if opened is not None:
                resists &= not lies_between(opened.zone.left, front, opened.zone.right)
            cuts += [front] if resists else []
        return tuple(cuts)

    @property
    def layout(self) -> Layout:
        """Order and kinds of the panels."""
        return self.panels.layout

    @cached_property
    def canonical(self) -> CanonicalFunction:
        """Canonical function: X, real, on panels that slip; X / M_+, real, on panels that stick."""
        resistance = self._resolved.resistance
        given = None if resistance is None else np.asarray(resistance)
        if given is not None and self.load.opened is not None:
            # The film carries no traction where the contact is open.
            closed = ~np.array(self.layout.open).reshape(-1, *[1] * (self.panels.jacobian.ndim - 1))
            given = given * closed
        return CanonicalFunction(self.factors, self.panels, given)

    @cached_property
    def _resolved(self) -> Load:
        """The load, with linearised strength evaluated on the panels."""
        load, panels = self.load, self.panels
        if load.linearised is None:
            return load
        resistance, slope = load.linearised.at(panels.at, panels.layout, panels.jacobian)
        return replace(load, resistance=resistance, given_slope=slope)
