"""Newton's method for strength that depends on slip rate in any smooth way, S(f p, |V|).

About a slip rate V_k the strength is S + S' (|V| - |V_k|), so that on slip of sense s

    dtau/dv = s f dp/dv + eta dV/dv + dg/dv,    eta = S',
    dg/dv = s (dS/d(f p) - 1) f dp/dv + (d eta/dv) (V - V_k).

This is a viscous problem with eta(v) and a given slope of strength, which `cut` solves exactly. The
last term contains the new V; it is iterated while the edges are moved to the positions required by
the linear problem. V_k is stored at the nodes of panels, which move with the edges, on a held rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rules import REACH, Rule, rule_for
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.rated.law import RateStep, SlipRate, UnitLaw
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.placement import Placement, locate_edges, polish_edges


@dataclass(frozen=True)
class Rated:
    """Zones as Newton's method left them, and largest changes of V over the largest V."""

    placement: Placement
    profile: Profile
    moves: tuple[float, ...]
    converged: bool


# Iterates that overflow end as unconverged.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def rated_zones(start: Profile, zones: Sequence[Zone], law: UnitLaw, tolerance: float) -> Rated:
    """Apply Newton's method to given zones, from the slip rate of a profile.

    The profile is of one set of zones, which may differ from `zones`, from the longitudinal front
    inward; the tolerance is that of the quadrature rule.
    """
    factors, load = start.fields.factors, replace(start.fields.load, linearised=None)
    beginning = ZoneFields(factors, load, tuple(zones), rule_for(tolerance))
    # The rule is held: it must not change with the edges, since V_k lives on its nodes.
    rule = held_rule(beginning, law, tolerance)
    step = RateStep.about(law, replace(beginning, rule=rule), SlipRate.of(start))
    # One of 60 scenes took 12 steps, all others 8 at most; next to c_R forty were in vain.
    about, most = replace(load, linearised=step), 16
    placement = locate_edges(factors, zones, about, rule, 1e-7, most)
    changes: list[float] = []
    profile, left = start, tuning.MOST_RATE_FIELDS
    for _ in range(12):  # four are usual
        # Values that have not settled lie next to c_R, where each of a thousand fields moves the
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
        # Newton's method has failed once a step is longer than the one before, but for rounding.
        most_now = max(*changes[-2:-1], tuning.RATE_SETTLED) if changes[1:] else np.inf
        if not changes[-1] < most_now:
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
    """Return edges, fields and fields used for one linearisation, its new V iterated."""
    factors, mixed, used = step.factors, list[tuple[Array, Array]](), 0
    while used < most:
        fields = ZoneFields(factors, replace(step.load, linearised=step), placement.zones, rule)
        placement, fields, _ = polish_edges(placement, fields, rule, 1e-13)
        profile, used = Profile(fields), used + 1 + placement.steps
        if not step.follows(fields):
            break
        new = profile.slip_rate_at_nodes
        moved = float(np.abs(new - step.last).max()) / float(profile.largest_rate)
        # Change of the slip rate, over the largest, that ends the iterations.
        if not 1e-13 < moved < np.inf:
            break
        mixed = [*mixed[-6:], (step.last, new)]
        step = replace(step, last=_mixed(mixed))
    return placement, profile, used


def _mixed(iterates: Sequence[tuple[Array, Array]]) -> Array:
    """Return the next iterate of x = g(x) by Anderson's method from the last (x, g(x))."""
    before, after = (
        np.stack([part.ravel() for part in parts]) for parts in zip(*iterates, strict=True)
    )
    if len(before) == 1:
        return iterates[-1][1]
    left = after - before
    weights, *_ = np.linalg.lstsq(np.diff(left, axis=0).T, left[-1], rcond=None)
    mixed = after[-1] - weights @ np.diff(after, axis=0)
    return np.asarray(mixed.reshape(iterates[-1][1].shape))


def least_exponent(fields: ZoneFields, law: UnitLaw) -> tuple[float, float]:
    """Return the least exponent of V near edges slower than c_t, and the slowness of that edge.

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


def held_rule(fields: ZoneFields, law: UnitLaw, tolerance: float) -> Rule:
    """Return a rule of a tolerance that is as long as V requires near the edges of zones."""
    rule = rule_for(tolerance)
    cut_off = rule.reach / REACH  # the logarithm of what may be left out
    # An integrand d^p decays like e^(-p |y|): the smaller the exponent, the longer the rule.
    # It rounds to zero at an edge close enough to c_R.
    slowest = max(least_exponent(fields, law)[0], cut_off / tuning.FARTHEST_RATE_REACH)
    reach = cut_off / slowest
    longer = replace(rule, reach=max(reach, rule.reach))
    return replace(replace(fields, rule=longer).panels.rule, held=True)


def cut_off(fields: ZoneFields, law: UnitLaw, reach: float | None = None) -> float:
    """Return the relative part of a steep slip rate that a rule of a reach, or their own, omits."""
    reach = fields.rule.reach if reach is None else reach
    return float(np.exp(-reach * least_exponent(fields, law)[0]))
