"""Strength that depends on slip rate in any smooth way, S(f p, |V|): Newton's method.

About a slip rate V_k strength is S + S' (|V| - |V_k|), so that on slip of sense s

    dtau/dv = s f dp/dv + eta dV/dv + dg/dv,    eta = S',
    dg/dv = s (dS/d(f p) - 1) f dp/dv + (d eta/dv) (V - V_k):

a viscous problem with eta(v) and a given slope of strength, solved exactly (`cut`).  The last term
holds the new V; it is iterated, while the edges are moved to where the linear problem wants them.
V_k is kept at the nodes of panels and moves with them, on a held rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.layout import Layout, Zone, lies_between
from semianalytic.cut.load import Load
from semianalytic.cut.panels import Panels
from semianalytic.cut.profile import Profile
from semianalytic.cut.running import RunningIntegral
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import REACH, Rule, rule_for
from semianalytic.halfplane.stuck import traction_of
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import RateFriction
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar import tuning
from semianalytic.selfsimilar.corrections import corrected
from semianalytic.selfsimilar.coulomb import violations
from semianalytic.selfsimilar.edges import Placement, locate_edges, polish_edges
from semianalytic.selfsimilar.estimate import difference

_LOCATED, _LEFT = 1e-7, 1e-13  # shifts of edges at which Newton's method and Broyden's end


@dataclass(frozen=True)
class UnitLaw:
    """A law in units of stress and of the one-sided slip rate, b = mu = 1.

    Of what it makes of constant friction only a `share`, on the way there.
    """

    law: RateFriction
    stress: float
    rate: float
    share: float = 1.0

    def strength(self, frictional: Array, speed: Array) -> Array:
        """S(f p, |V|)."""
        whole = self.law.strength(self.stress * frictional, self.rate * speed, 0.0)
        return np.asarray((1 - self.share) * frictional + self.share / self.stress * whole)

    def slopes(self, frictional: Array, speed: Array) -> tuple[Array, Array, Array, Array]:
        """Derivatives by f p, |V|, both, and |V| twice."""
        given = self.law.rate_slopes(self.stress * frictional, self.rate * speed)
        by_friction, by_rate, mixed, twice = (self.share * one for one in given)
        unit = self.rate / self.stress
        by_friction = by_friction + (1 - self.share)
        return by_friction, unit * by_rate, self.rate * mixed, unit * self.rate * twice


@dataclass(frozen=True)
class SlipRate:
    """The slip rate of a profile as a function of slowness, without what it came from.

    Attributes
    ----------
    panels : Panels
    integral : RunningIntegral, V from the left end of each panel
    starts : (p,) array, V there
    ahead : float, V(inf)
    """

    panels: Panels
    integral: RunningIntegral
    starts: Array
    ahead: float

    @classmethod
    def of(cls, profile: Profile) -> SlipRate:
        """That of a profile of one set of zones."""
        ahead = float(profile.fields.load.far_slip_rate)
        return cls(profile.panels, profile.rate_integral, profile.starts[0], ahead)

    def __call__(self, at: CutPoints) -> Array:
        """V at points of any shape."""
        flat, senses = CutPoints(at.parts.reshape(4, -1)), self.panels.sense
        rate = np.full(flat.v.shape, self.ahead)
        panel = self.panels.panel_of(flat)
        for i in np.unique(panel[panel >= 0]):
            here = panel == i
            rate[here] = self.starts[i] + self.integral(int(i), flat[here]) if senses[i] else 0.0
        return rate.reshape(at.v.shape)


@dataclass(frozen=True)
class RateStep:
    """Strength linear about V_k, its term in the new V from the last iterate.

    Attributes
    ----------
    law : UnitLaw
    load : Load, without strength that depends on slip rate
    factors : RayleighFactors
    rate : SlipRate, V_k
    layout : Layout, of the panels with which V_k moves
    before, density : (p, n) arrays, V_k and dV_k/dy at their nodes
    last : (p, n) array, the last iterate of V
    """

    law: UnitLaw
    load: Load
    factors: RayleighFactors
    rate: SlipRate
    layout: Layout
    before: Array
    density: Array
    last: Array

    @classmethod
    def about(cls, law: UnitLaw, fields: ZoneFields, rate: SlipRate) -> RateStep:
        """About a slip rate as it is on the panels of some fields, whatever its slope."""
        panels, load = fields.panels, replace(fields.load, linearised=None)
        none = np.zeros_like(panels.jacobian)
        step = cls(law, load, fields.factors, rate, panels.layout, none, none, none)
        known = step._known(panels.at, panels.layout)
        return replace(step, before=known, last=known)

    def follows(self, fields: ZoneFields) -> bool:
        """Whether V_k is known at the nodes of fields."""
        return fields.layout == self.layout and fields.panels.jacobian.shape == self.before.shape

    def carried(self, frictional: Array, speed: Array) -> Array:
        """See `LinearisedStrength`."""
        return self.law.strength(frictional, speed)

    def at(self, points: CutPoints, layout: Layout, jacobian: Array) -> tuple[Array, Array]:
        """See `LinearisedStrength`; V_k is that at a slowness where the panels are other ones than
        those with which it moves."""
        count, (*sets, size) = len(layout.sense), points.v.shape[1:]
        shape = (count, *[1] * len(sets), size)
        if size == self.before.shape[1] and layout.begins(self.layout):
            before, density, last = (
                part[:count].reshape(shape) for part in (self.before, self.density, self.last)
            )
        else:
            before = last = self._known(points, layout)
            density = np.zeros_like(before)
        senses = np.array(layout.sense).reshape(-1, *[1] * (points.v.ndim - 1))
        frictional, gained = self._frictional(points)
        by_friction, eta, mixed, twice = self.law.slopes(frictional, np.abs(before))
        bent = mixed * gained + twice * senses * density / jacobian
        slope = senses * (by_friction - 1) * gained + bent * (last - before)
        return np.broadcast_to(eta, jacobian.shape), np.where(senses != 0, slope, 0.0)

    def _known(self, points: CutPoints, layout: Layout) -> Array:
        """V_k at points (p, ..., n) of panels, 0 where these stick."""
        slipping = layout.slipping.reshape(-1, *[1] * (points.v.ndim - 1))
        return np.where(slipping, self.rate(points), 0.0)

    def _frictional(self, points: CutPoints) -> tuple[Array, Array]:
        """f p and its slope."""
        load, factors = self.load, self.factors
        pressure, slope = load.pressure(factors, points), np.zeros(points.v.shape)
        if load.load_pressure:
            unit = traction_of(factors, "I")
            slope = load.load_pressure * unit.slope(factors.seen_in_plane(points))
        return load.friction * pressure, load.friction * slope


def on_any_panels(profile: Profile) -> ZoneFields:
    """The fields of a profile such that they may be formed on other panels of the same zones: about
    its slip rate, which Newton's method leaves as it is."""
    fields = profile.fields
    step = fields.load.linearised
    if not isinstance(step, RateStep):
        return fields
    nowhere = np.zeros((0, 0))
    step = replace(step, rate=SlipRate.of(profile), before=nowhere, density=nowhere, last=nowhere)
    return replace(fields, load=replace(fields.load, linearised=step))


@dataclass(frozen=True)
class Rated:
    """Zones under strength that depends on slip rate, as Newton's method left them.

    Attributes
    ----------
    placement : Placement
    profile : Profile
    moves : tuple of float, largest change of V in each step, over the largest V
    converged : bool
    """

    placement: Placement
    profile: Profile
    moves: tuple[float, ...]
    converged: bool


def unit_law(scene: Scene, stress: float) -> UnitLaw:
    """The law of a scene in the units of its load."""
    assert isinstance(scene.friction_law, RateFriction)
    return UnitLaw(scene.friction_law, stress, 2 * stress / scene.material.shear_impedance)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # ends unconverged
def rated_zones(start: Profile, zones: Sequence[Zone], law: UnitLaw, tolerance: float) -> Rated:
    """Newton's method for given zones, from the slip rate of a profile.

    Parameters
    ----------
    start : Profile of one set of zones, perhaps others
    zones : sequence of Zone, from the longitudinal front inward
    law : UnitLaw
    tolerance : of the rule
    """
    factors, load = start.fields.factors, replace(start.fields.load, linearised=None)
    beginning = ZoneFields(factors, load, tuple(zones), rule_for(tolerance))
    rule = _held_rule(beginning, law, tolerance)
    step = RateStep.about(law, replace(beginning, rule=rule), SlipRate.of(start))
    about, most = replace(load, linearised=step), tuning.MOST_RATE_EDGE_STEPS
    placement = locate_edges(factors, zones, about, rule, _LOCATED, most)
    changes: list[float] = []
    profile = start
    for _ in range(tuning.MOST_RATE_STEPS):
        if not placement.converged:
            break
        placement, profile = _iterated(step, placement, rule, once=not changes)
        fields, largest = profile.fields, float(profile.largest_rate)
        if not step.follows(fields):  # an edge has passed a front: V_k does not move with it
            changes, step = [], RateStep.about(law, fields, SlipRate.of(profile))
            continue
        new = profile.slip_rate_at_nodes
        changes.append(float(np.abs(new - step.before).max()) / largest)
        if not (changes[-1] < np.inf and _shrinks(changes)):
            break
        density = fields.slip_rate_slope * fields.panels.jacobian
        step = replace(step, rate=SlipRate.of(profile), before=new, density=density, last=new)
        if not changes[-1] > tuning.RATE_SETTLED:
            break
    settled = placement.converged and bool(changes) and changes[-1] <= tuning.RATE_SETTLED
    return Rated(placement, profile, tuple(changes), settled)


def _iterated(
    step: RateStep, placement: Placement, rule: Rule, once: bool
) -> tuple[Placement, Profile]:
    """Edges and fields under strength linear about V_k, its term in the new V iterated until that
    settles or an edge passes a front."""
    factors, mixed = step.factors, list[tuple[Array, Array]]()
    for _ in range(1 if once else tuning.MOST_RATE_ITERATIONS):
        fields = ZoneFields(factors, replace(step.load, linearised=step), placement.zones, rule)
        placement, fields, _ = polish_edges(placement, fields, rule, _LEFT)
        profile = Profile(fields)
        if not step.follows(fields):
            break
        new = profile.slip_rate_at_nodes
        moved = float(np.abs(new - step.last).max()) / float(profile.largest_rate)
        if not tuning.RATE_ROUNDING < moved < np.inf:
            break
        mixed = [*mixed[-tuning.MIXED_ITERATES :], (step.last, new)]
        step = replace(step, last=_mixed(mixed))
    return placement, profile


def _shrinks(changes: Sequence[float]) -> bool:
    """Whether the last step of Newton's method is shorter than the one before, or rounding."""
    return len(changes) < 2 or changes[-1] < max(changes[-2], tuning.RATE_SETTLED)


def _mixed(iterates: Sequence[tuple[Array, Array]]) -> Array:
    """Next iterate x of x = g(x) from the last pairs (x, g(x)): Anderson's, of least residual."""
    before, after = (
        np.stack([part.ravel() for part in parts]) for parts in zip(*iterates, strict=True)
    )
    if len(before) == 1:
        return iterates[-1][1]
    left = after - before
    weights, *_ = np.linalg.lstsq(np.diff(left, axis=0).T, left[-1], rcond=None)
    mixed = after[-1] - weights @ np.diff(after, axis=0)
    return np.asarray(mixed.reshape(iterates[-1][1].shape))


def _least_exponent(fields: ZoneFields, law: UnitLaw) -> tuple[float, float]:
    """Of V beside edges slower than c_t, and its edge: |v - e|^(1/2 - theta / pi), tan(theta) =
    -eta / m."""
    least, at = 0.5, np.inf
    for edge in (edge for zone in fields.zones for edge in (zone.left, zone.right)):
        if edge is not None and edge.first[2] > 0:
            eta = float(law.slopes(fields.strength(edge), np.zeros(1))[1][0])
            impedance = abs(float(fields.factors.impedance_behind(edge)[0]))
            exponent = 0.5 - float(np.arctan2(max(-eta, 0.0), impedance)) / np.pi
            least, at = min((least, at), (exponent, float(edge.v[0])))
    return least, at


def _held_rule(fields: ZoneFields, law: UnitLaw, tolerance: float) -> Rule:
    """A rule of a tolerance, as long as V asks for beside the edges of zones."""
    rule = rule_for(tolerance)
    cut_off = rule.reach / REACH  # the logarithm of what may be left out
    reach = min(cut_off / _least_exponent(fields, law)[0], tuning.FARTHEST_RATE_REACH)
    longer = replace(rule, reach=max(reach, rule.reach))
    return replace(replace(fields, rule=longer).panels.rule, held=True)


def check_rated(profile: Profile, law: UnitLaw, speed: float) -> None:
    """Raise SceneError where slip that weakens strength has no answer: across c_R, or where
    strength falls faster with slip rate than radiation balances.

    `speed` is c_t.
    """
    if not law.law.fall_with_rate:
        return
    fields, front = profile.fields, profile.fields.factors.front_c
    rayleigh = fields.factors.has_rayleigh_wave
    if rayleigh and any(lies_between(one.left, front, one.right) for one in fields.zones):
        raise SceneError(
            "solve: slip would cover the Rayleigh front, where friction that falls with slip rate "
            "admits no self-similar answer; use the space-time solver for this scene, `march` or "
            "`method` space-time, or the finite elements (docs/limits.md)."
        )
    if profile.edge_slips and fields.load.load_pressure > 0:
        raise SceneError(
            "solve: a step of pressure makes pressure infinite at the contact edge, and friction "
            "that falls with slip rate there falls faster than radiation can balance; leave load "
            "pressure out, or take friction that keeps the edge stuck (docs/limits.md)."
        )
    at, slip = profile.panels.at.v, profile.panels.layout.slip
    bound = profile.strength(at[slip].ravel())
    _, slopes, _, _ = law.slopes(bound, np.abs(profile.slip_rate_at_nodes[slip].ravel()))
    steepest = int(np.argmin(slopes)) if len(slip) else 0
    if len(slip) and slopes[steepest] <= -1:
        raise SceneError(
            "solve: friction falls with slip rate faster than radiation can balance, at x/t = "
            f"{speed / at[slip].ravel()[steepest]:.4g}; raise the rate or lower the reduction of "
            "the friction law (docs/limits.md)."
        )


def approached(
    start: Profile, law: UnitLaw, tolerance: float, speed: float
) -> tuple[Rated | None, Profile]:
    """Zones from a profile under constant friction, at once or in steps of `UnitLaw.share`, halved
    where one fails; None where they lead nowhere, as to slip rates too steep for any rule, and the
    last profile on the way."""
    reached, step = 0.0, 1.0
    while step >= tuning.LEAST_RATE_SHARE:
        share = min(reached + step, 1.0)
        rated = settled_zones(start, replace(law, share=share), tolerance, speed)
        if rated is None:
            if reached and _least_exponent(start.fields, law)[0] < tuning.STEEP_EXPONENT:
                break
            step /= 2
            continue
        start, reached = rated.profile, share
        if reached == 1.0:
            return rated, start
    return None, start


def unsettled(last: Profile, law: UnitLaw, speed: float) -> str:
    """A sentence that says why zones of the whole law were not reached from a profile."""
    exponent, at = _least_exponent(last.fields, law)
    if exponent < tuning.STEEP_EXPONENT:
        return (
            f"slip rate rises like the power {exponent:.2g} of the distance from a zone edge near "
            f"x/t = {speed / at:.4g}, which no rule resolves; raise the rate or lower the "
            "reduction of the friction law, or march the scene"
        )
    return "Newton's method found no slip rate that agrees with the strength it leaves"


def settled_zones(start: Profile, law: UnitLaw, tolerance: float, speed: float) -> Rated | None:
    """Zones corrected from those of a profile until the law of friction holds; None if none do."""
    zones, profile = list(start.fields.zones), start
    for _ in range(tuning.MOST_ZONE_SETS):
        rated = rated_zones(profile, zones, law, tolerance)
        if not rated.converged:
            return None
        profile = rated.profile
        check_rated(profile, law, speed)
        broken = violations(profile, tuning.LAW_TOLERANCE * tolerance)
        if broken is None:
            return None
        if not broken:
            return rated
        zones = corrected(profile.fields.zones, broken, profile.fields.load)
    return None


def companion_error(fine: Rated, law: UnitLaw, tolerance: float) -> float:
    """Error estimate of zones from a coarser companion, with edges and slip rate of its own."""
    coarser = tuning.COARSER_COMPANION * tolerance
    coarse = rated_zones(fine.profile, fine.placement.zones, law, coarser)
    if not coarse.converged:
        return np.inf
    edges, unknowns, fields = fine.placement.edges, fine.placement.unknowns, fine.profile.fields
    moved = coarse.placement.unknowns
    between = float(difference(edges, unknowns, moved, fields, coarse.profile.fields))
    return between + cut_off(fine, law)


def cut_off(rated: Rated, law: UnitLaw) -> float:
    """What the end of a rule leaves out of a slip rate that rises steeply from an edge, over it."""
    fields = rated.profile.fields
    return float(np.exp(-fields.rule.reach * _least_exponent(fields, law)[0]))
