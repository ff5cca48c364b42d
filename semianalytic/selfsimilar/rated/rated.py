"""Newton's method for strength that depends on slip rate in any smooth way, S(f p, |V|).

About a slip rate V_k the strength is S + S' (|V| - |V_k|), so that on slip of sense s

    dtau/dv = s f dp/dv + eta dV/dv + dg/dv,    eta = S',
    dg/dv = s (dS/d(f p) - 1) f dp/dv + (d eta/dv) (V - V_k).

This is a viscous problem with eta(v) and a given slope of strength, which `cut` solves exactly. The
last term contains the new V; it is iterated while the edges are moved to the positions required by
the linear problem. V_k is stored at the nodes of panels, which move with the edges, on a held rule.
See docs/rate.md, "Newton's method for any smooth law".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Layout, Zone, lies_between
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.cut.quadrature.running import RunningIntegral
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import REACH, Rule, rule_for
from semianalytic.halfplane.stuck import traction_of
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import RateFriction
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.corrections import corrected
from semianalytic.selfsimilar.zones.coulomb import violations
from semianalytic.selfsimilar.zones.edges import Placement, locate_edges, polish_edges
from semianalytic.selfsimilar.zones.estimate import difference

_LOCATED, _LEFT = 1e-7, 1e-13  # shifts of edges at which Newton's method and Broyden's end


@dataclass(frozen=True)
class UnitLaw:
    """Friction law in units of stress and of the one-sided slip rate, b = mu = 1.

    `share` is the part of the change of constant friction that is applied, for steps towards the
    law.
    """

    law: RateFriction
    stress: float
    rate: float
    share: float = 1.0

    def strength(self, frictional: Array, speed: Array) -> Array:
        """Return the strength S(f p, |V|)."""
        whole = self.law.strength(self.stress * frictional, self.rate * speed, 0.0)
        return np.asarray((1 - self.share) * frictional + self.share / self.stress * whole)

    def slopes(self, frictional: Array, speed: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives with respect to f p, to |V|, to both, and to |V| twice."""
        given = self.law.rate_slopes(self.stress * frictional, self.rate * speed)
        by_friction, by_rate, mixed, twice = (self.share * one for one in given)
        # Chain rule for the units of slip rate and of stress.
        unit = self.rate / self.stress
        by_friction = by_friction + (1 - self.share)
        return by_friction, unit * by_rate, self.rate * mixed, unit * self.rate * twice


@dataclass(frozen=True)
class SlipRate:
    """Slip rate of a profile as a function of slowness, independent of the profile.

    Attributes
    ----------
    panels : Panels
    integral : RunningIntegral
        V from the left end of each panel.
    starts : (p,) array
        V at the left ends.
    ahead : float
        V(inf).
    """

    panels: Panels
    integral: RunningIntegral
    starts: Array
    ahead: float

    @classmethod
    def of(cls, profile: Profile) -> SlipRate:
        """Return the slip rate of a profile of one set of zones."""
        ahead = float(profile.fields.load.far_slip_rate)
        return cls(profile.panels, profile.rate_integral, profile.rate_starts, ahead)

    def __call__(self, at: CutPoints) -> Array:
        """Return V at points of any shape."""
        flat, senses = CutPoints(at.parts.reshape(4, -1)), self.panels.sense
        rate = np.full(flat.v.shape, self.ahead)
        panel = self.panels.panel_of(flat)
        for i in np.unique(panel[panel >= 0]):
            here = panel == i
            rate[here] = self.starts[i] + self.integral(int(i), flat[here]) if senses[i] else 0.0
        return rate.reshape(at.v.shape)


@dataclass(frozen=True)
class RateStep:
    """Strength linearised about V_k, with its term in the new V from the last iterate.

    Attributes
    ----------
    law : UnitLaw
    load : Load
        Load without strength that depends on slip rate.
    factors : RayleighFactors
    rate : SlipRate
        V_k as a function of slowness.
    layout : Layout
        Layout of the panels with which V_k moves.
    before, density : (p, n) arrays
        V_k and dV_k/dy at their nodes.
    last : (p, n) array
        Last iterate of V.
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
        """Return a step about a slip rate on the panels of some fields, without its slope."""
        panels, load = fields.panels, replace(fields.load, linearised=None)
        none = np.zeros_like(panels.jacobian)
        step = cls(law, load, fields.factors, rate, panels.layout, none, none, none)
        known = step._known(panels.at, panels.layout)
        return replace(step, before=known, last=known)

    def follows(self, fields: ZoneFields) -> bool:
        """Return whether V_k is known at the nodes of fields."""
        return fields.layout == self.layout and fields.panels.jacobian.shape == self.before.shape

    def carried(self, frictional: Array, speed: Array) -> Array:
        """Return the strength; see `LinearisedStrength`."""
        return self.law.strength(frictional, speed)

    def at(self, points: CutPoints, layout: Layout, jacobian: Array) -> tuple[Array, Array]:
        """Return eta and dg/dv; see `LinearisedStrength`.

        If the panels are other than those with which V_k moves, V_k is taken at fixed slowness.
        """
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
        # d eta/dv along V_k: the derivatives of S' with respect to f p and to |V|.
        bent = mixed * gained + twice * senses * density / jacobian
        # Both terms of dg/dv in the description of this module.
        slope = senses * (by_friction - 1) * gained + bent * (last - before)
        return np.broadcast_to(eta, jacobian.shape), np.where(senses != 0, slope, 0.0)

    def _known(self, points: CutPoints, layout: Layout) -> Array:
        """Return V_k at points (p, ..., n) of panels, 0 where these stick."""
        slipping = layout.slipping.reshape(-1, *[1] * (points.v.ndim - 1))
        return np.where(slipping, self.rate(points), 0.0)

    def _frictional(self, points: CutPoints) -> tuple[Array, Array]:
        """Return f p and its slope."""
        load, factors = self.load, self.factors
        pressure, slope = load.pressure(factors, points), np.zeros(points.v.shape)
        if load.load_pressure:
            unit = traction_of(factors, "I")
            slope = load.load_pressure * unit.slope(factors.seen_in_plane(points))
        return load.friction * pressure, load.friction * slope


def on_any_panels(profile: Profile) -> ZoneFields:
    """Return the fields of a profile in a form that other panels of the same zones can use.

    The strength is linearised about the slip rate itself, which Newton's method leaves unchanged.
    """
    fields = profile.fields
    step = fields.load.linearised
    if not isinstance(step, RateStep):
        return fields
    nowhere = np.zeros((0, 0))
    step = replace(step, rate=SlipRate.of(profile), before=nowhere, density=nowhere, last=nowhere)
    return replace(fields, load=replace(fields.load, linearised=step))


@dataclass(frozen=True)
class Rated:
    """Zones under strength that depends on slip rate, as the last step of Newton's method left
    them.

    Attributes
    ----------
    placement : Placement
    profile : Profile
    moves : tuple of float
        Largest change of V in each step, over the largest V.
    converged : bool
    """

    placement: Placement
    profile: Profile
    moves: tuple[float, ...]
    converged: bool


def unit_law(scene: Scene, stress: float) -> UnitLaw:
    """Return the law of a scene in the units of its load."""
    assert isinstance(scene.friction_law, RateFriction)
    # The law takes the relative slip rate, twice the one-sided one.
    return UnitLaw(scene.friction_law, stress, 2 * stress / scene.material.shear_impedance)


# Iterates that overflow end as unconverged.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def rated_zones(start: Profile, zones: Sequence[Zone], law: UnitLaw, tolerance: float) -> Rated:
    """Apply Newton's method to given zones, from the slip rate of a profile.

    Parameters
    ----------
    start : Profile
        One set of zones, which may differ from `zones`.
    zones : sequence of Zone
        From the longitudinal front inward.
    law : UnitLaw
    tolerance : float
        Tolerance of the quadrature rule.
    """
    factors, load = start.fields.factors, replace(start.fields.load, linearised=None)
    beginning = ZoneFields(factors, load, tuple(zones), rule_for(tolerance))
    # The rule is held: it must not change with the edges, since V_k lives on its nodes.
    rule = _held_rule(beginning, law, tolerance)
    step = RateStep.about(law, replace(beginning, rule=rule), SlipRate.of(start))
    about, most = replace(load, linearised=step), tuning.MOST_RATE_EDGE_STEPS
    placement = locate_edges(factors, zones, about, rule, _LOCATED, most)
    changes: list[float] = []
    profile, left = start, tuning.MOST_RATE_FIELDS
    for _ in range(tuning.MOST_RATE_STEPS):
        # What has not settled by now lies next to c_R, where each of a thousand fields moves the
        # edges as far as the one before.
        if not (placement.converged and left > 0):
            break
        placement, profile, used = _iterated(step, placement, rule, 1 if not changes else left)
        left -= used
        fields, largest = profile.fields, float(profile.largest_rate)
        if not step.follows(fields):  # an edge has passed a front: V_k does not move with it
            changes, step = [], RateStep.about(law, fields, SlipRate.of(profile))
            continue
        new = profile.slip_rate_at_nodes
        changes.append(float(np.abs(new - step.before).max()) / largest)
        # Newton's method has failed once a step is longer than the one before.
        if not (changes[-1] < np.inf and _shrinks(changes)):
            break
        density = fields.slip_rate_slope * fields.panels.jacobian
        step = replace(step, rate=SlipRate.of(profile), before=new, density=density, last=new)
        if not changes[-1] > tuning.RATE_SETTLED:
            break
    settled = placement.converged and bool(changes) and changes[-1] <= tuning.RATE_SETTLED
    return Rated(placement, profile, tuple(changes), settled)


def _iterated(
    step: RateStep, placement: Placement, rule: Rule, most: int
) -> tuple[Placement, Profile, int]:
    """Return edges and fields for one linearisation, with its term in the new V iterated, and how
    many fields that took.

    The iteration ends once it settles, an edge passes a front, or it has taken `most` fields.
    """
    factors, mixed, used = step.factors, list[tuple[Array, Array]](), 0
    while used < most:
        fields = ZoneFields(factors, replace(step.load, linearised=step), placement.zones, rule)
        placement, fields, _ = polish_edges(placement, fields, rule, _LEFT)
        profile, used = Profile(fields), used + 1 + placement.steps
        if not step.follows(fields):
            break
        new = profile.slip_rate_at_nodes
        moved = float(np.abs(new - step.last).max()) / float(profile.largest_rate)
        if not tuning.RATE_ROUNDING < moved < np.inf:
            break
        mixed = [*mixed[-tuning.MIXED_ITERATES :], (step.last, new)]
        step = replace(step, last=_mixed(mixed))
    return placement, profile, used


def _shrinks(changes: Sequence[float]) -> bool:
    """Return whether the last step of Newton's method is shorter than the one before, or
    rounding."""
    return len(changes) < 2 or changes[-1] < max(changes[-2], tuning.RATE_SETTLED)


def _mixed(iterates: Sequence[tuple[Array, Array]]) -> Array:
    """Return the next iterate x of x = g(x) by Anderson's method, from the last pairs (x, g(x)).

    It is the combination with the least residual.
    """
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
    """Return the least exponent of V beside edges slower than c_t, and the slowness of that edge.

    V ~ |v - e|^(1/2 - theta / pi) with tan(theta) = -eta / m.
    """
    least, at = 0.5, np.inf
    for edge in (edge for zone in fields.zones for edge in (zone.left, zone.right)):
        if edge is not None and edge.first[2] > 0:
            eta = float(law.slopes(fields.strength(edge), np.zeros(1))[1][0])
            impedance = abs(float(fields.factors.impedance_behind(edge)[0]))
            # At an edge V = 0; resistance (eta > 0) only makes V smoother and is left out.
            exponent = 0.5 - float(np.arctan2(max(-eta, 0.0), impedance)) / np.pi
            least, at = min((least, at), (exponent, float(edge.v[0])))
    return least, at


def _held_rule(fields: ZoneFields, law: UnitLaw, tolerance: float) -> Rule:
    """Return a rule of a tolerance that is as long as V requires beside the edges of zones."""
    rule = rule_for(tolerance)
    cut_off = rule.reach / REACH  # the logarithm of what may be left out
    # An integrand d^p decays like e^(-p |y|): the smaller the exponent, the longer the rule.
    # It rounds to zero at an edge close enough to c_R.
    slowest = max(_least_exponent(fields, law)[0], cut_off / tuning.FARTHEST_RATE_REACH)
    reach = cut_off / slowest
    longer = replace(rule, reach=max(reach, rule.reach))
    return replace(replace(fields, rule=longer).panels.rule, held=True)


def check_rated(profile: Profile, law: UnitLaw, speed: float) -> None:
    """Raise SceneError where slip that weakens strength has no solution.

    This is the case where it would cover c_R, or where strength falls faster with slip rate than
    radiation can balance. `speed` is c_t.
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
    # eta <= -1 in units of rho c_t: radiation has the slope 1.
    if len(slip) and slopes[steepest] <= -1:
        raise SceneError(
            "solve: friction falls with slip rate faster than radiation can balance, at x/t = "
            f"{speed / at[slip].ravel()[steepest]:.4g}; raise the rate or lower the reduction of "
            "the friction law (docs/limits.md)."
        )


def approached(
    start: Profile, law: UnitLaw, tolerance: float, speed: float
) -> tuple[Rated | None, Profile]:
    """Return zones reached from a profile under constant friction, and the last profile on the way.

    The law is introduced at once or in steps of `UnitLaw.share`, which are halved if one fails. The
    zones are None if the steps lead nowhere, for example to slip rates too steep for any rule.
    """
    reached, step = 0.0, 1.0
    while step >= tuning.LEAST_RATE_SHARE:
        share = min(reached + step, 1.0)
        rated = settled_zones(start, replace(law, share=share), tolerance, speed)
        if rated is None:
            # Too steep for any rule is the whole law at the edges that a part of it has moved, or
            # even the smallest part of it at those of constant friction.
            least = law if reached else replace(law, share=tuning.LEAST_RATE_SHARE)
            if _least_exponent(start.fields, least)[0] < tuning.STEEP_EXPONENT:
                break
            step /= 2
            continue
        start, reached = rated.profile, share
        if reached == 1.0:
            return rated, start
    return None, start


def unsettled(last: Profile, law: UnitLaw, speed: float) -> str:
    """Return a sentence that says why zones of the whole law were not reached from a profile."""
    exponent, at = _least_exponent(last.fields, law)
    if exponent < tuning.STEEP_EXPONENT:
        return (
            f"slip rate rises like the power {exponent:.2g} of the distance from a zone edge near "
            f"x/t = {speed / at:.4g}, which no rule resolves; raise the rate or lower the "
            "reduction of the friction law, or march the scene"
        )
    return "Newton's method found no slip rate that agrees with the strength it leaves"


def settled_zones(start: Profile, law: UnitLaw, tolerance: float, speed: float) -> Rated | None:
    """Return zones corrected from those of a profile until Coulomb's law holds; None if none do."""
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
    """Return the error estimate of zones from a coarser companion with its own edges and slip
    rate."""
    coarser = tuning.COARSER_COMPANION * tolerance
    coarse = rated_zones(fine.profile, fine.placement.zones, law, coarser)
    if not coarse.converged:
        return np.inf
    edges, unknowns, fields = fine.placement.edges, fine.placement.unknowns, fine.profile.fields
    moved = coarse.placement.unknowns
    between = float(difference(edges, unknowns, moved, fields, coarse.profile.fields))
    return between + cut_off(fine, law)


def cut_off(rated: Rated, law: UnitLaw) -> float:
    """Return the relative part of a steep slip rate that the end of its rule leaves out."""
    fields = rated.profile.fields
    return float(np.exp(-fields.rule.reach * _least_exponent(fields, law)[0]))


def always_cut_off(rated: Rated, law: UnitLaw) -> float:
    """Return the relative part of a steep slip rate that the longest rule leaves out."""
    exponent, _ = _least_exponent(rated.profile.fields, law)
    return float(np.exp(-tuning.FARTHEST_RATE_REACH * exponent))
