"""Search for zones that satisfy Coulomb's law, then refine their edges and check them again.

`loose_search` finds zones that satisfy Coulomb's law on a loose rule, `refined_zones` improves
their edges until the error estimate is below rtol, and `checked_zones` checks the law once more, to
rtol.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import RayleighFactors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.corrections import corrected, rearranged
from semianalytic.selfsimilar.zones.coulomb import violations
from semianalytic.selfsimilar.zones.estimate import (
    intensity_gain,
    loose_tolerance,
    missed_slip,
    narrowness,
    numerical_error,
    slip_gain,
)
from semianalytic.selfsimilar.zones.guesses import guesses
from semianalytic.selfsimilar.zones.placement import (
    Placement,
    locate_edges,
    placement_of,
    polish_edges,
)


@dataclass(frozen=True)
class Trial:
    """Zones that were tried, fields on a rule, whether lawful there, Newton steps and zone sets."""

    placement: Placement
    profile: Profile
    lawful: bool
    steps: int = 0
    sets: int = 1


@dataclass(frozen=True)
class _Rules:
    """The rule that locates edges, the shift [c_t] that may be left, and the checking rule."""

    locating: Rule
    shift: float
    checking: Rule


def _search(
    factors: RayleighFactors, load: Load, rtol: float, tolerance: float
) -> tuple[Trial, int]:
    """Return lawful zones on the rule of a tolerance, guess after guess, and the pivots."""
    checking = rule_for(tolerance)
    shift = max(0.1 * rtol, 1e-7)  # shift of edges [c_t] that ends Newton's method
    trial = _unlawful(placement_of(factors, (), load), load, checking)
    pivots = steps = sets = 0
    for guess in guesses(factors, load):
        # Edges need fewer digits than the check of the law. If an earlier guess failed, though, a
        # loose rule may be the reason.
        locating = checking if guess.doubtful else rule_for(3.0 * tolerance)
        trial = _settled(factors, guess.zones, load, _Rules(locating, shift, checking))
        pivots, steps, sets = pivots + guess.pivots, steps + trial.steps, sets + trial.sets
        if trial.lawful:
            break
    return replace(trial, steps=steps, sets=sets), pivots


def loose_search(factors: RayleighFactors, load: Load, rtol: float) -> tuple[Trial, int]:
    """Run `_search` on as loose a rule as rtol and most scenes allow."""
    return _search(factors, load, rtol, loose_tolerance(rtol))


def strict_search(factors: RayleighFactors, load: Load, rtol: float) -> tuple[Trial, int]:
    """Run `_search` for zones that slip so little that a loose rule does not show them."""
    return _search(factors, load, _strict(rtol), min(loose_tolerance(rtol), 1e-9))


def _strict(rtol: float) -> float:
    """Return the accuracy to which zones that hardly slip are searched for."""
    return max(1e-3 * rtol, min(rtol, 1e-12))


# Numbers that overflow end in a status, not in a warning.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def _settled(factors: RayleighFactors, zones: Sequence[Zone], load: Load, rules: _Rules) -> Trial:
    """Correct zones, one set after another, until Coulomb's law holds; return the last trial."""
    steps, may_turn = 0, True
    for sets in range(1, 13):
        placement = locate_edges(factors, zones, load, rules.locating, rules.shift)
        steps += placement.steps
        if zones and zones[0].left is None and not load.slips_from_front(zones[0].sense):
            break
        if not placement.converged:
            others = rearranged(factors, placement.zones, load, may_turn)
            if others is None:
                break
            pairs = zip(zones, others, strict=False)
            # The sense of slip ahead of an opening may be reversed once only, or the search would
            # cycle.
            turned = len(others) == len(zones) and any(p.sense != q.sense for p, q in pairs)
            zones, may_turn = others, may_turn and not turned
            continue
        profile = Profile(ZoneFields(factors, load, placement.zones, rules.checking))
        # None means that the fields are not numbers; an empty list means that the law holds.
        broken = violations(profile, tuning.LAW_TOLERANCE * rules.checking.tolerance)
        if broken is None:
            break
        if not broken:
            return Trial(placement, profile, True, steps, sets)
        zones = corrected(profile.fields.zones, broken, load)
    return replace(_unlawful(placement, load, rules.checking), steps=steps, sets=sets)


def _unlawful(placement: Placement, load: Load, rule: Rule) -> Trial:
    """Return a trial for zones that were given up, or for no zones at all."""
    fields = ZoneFields(placement.edges.factors, load, placement.zones, rule)
    return Trial(placement, Profile(fields), False)


# Numbers that overflow end in a status, not in a warning.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def refined_zones(trial: Trial, rtol: float) -> tuple[Trial, float]:
    """Improve edges on finer rules until a companion agrees to rtol; return trial and estimate."""
    if not trial.lawful:
        return replace(trial, steps=0), np.inf
    start, steps, covers_c = trial.placement, 0, trial.profile.panels.layout.pole >= 0
    tolerance = rtol / tuning.RULE_SHARE
    # Where slip covers c_R, the estimate for points between nodes is larger: a finer rule
    # leaves room for it.
    if covers_c and trial.profile.fields.rule is not rule_for(tolerance):
        tolerance = rtol / 20.0  # leaves room for what lies between nodes there
    tolerance = affordable(trial.profile.fields, tolerance)
    # Slip that is narrow ahead of an opening needs its edge relative to that width, and stress
    # intensity that is a small difference needs it better by what it gains from a shift.
    target = tuning.LEFT_SHIFT * rtol * narrowness(start.edges, start.unknowns)
    usual = tuning.LEFT_SAFETY * tuning.SAFETY
    target *= usual / max(usual, intensity_gain(trial.profile.fields))
    target = max(target, tuning.LEAST_LEFT_SHIFT)
    before = np.inf
    for _ in range(8):  # rules tried until the estimate is below rtol
        placement, fields, left = polish_edges(
            trial.placement, trial.profile.fields, rule_for(tolerance), target
        )
        profile = trial.profile if fields is trial.profile.fields else Profile(fields)
        finer = replace(trial, placement=placement, profile=profile)
        steps += placement.steps
        numerical = numerical_error(placement, fields, tolerance, left)
        # `SAFETY` covers slip up to a gain of 6, which 195 of 4,264 random scenes exceed; with half
        # or twice of it slip is off by 0.29 and 1.1 of its estimate at most.
        numerical *= max(1.0, slip_gain(profile) / 6.0)
        missed = float(missed_slip(profile))
        # Zones that shrink to nothing have no relative error.
        if not numerical + missed < np.inf:
            return replace(finer, steps=steps), np.inf
        # A residual that no longer decreases is rounding: finer rules would only cost more.
        if numerical > 0.5 * before:  # beyond that only rounding changes
            break
        # The zone of slip that is missed by more is not known, nor how its slip grows near it.
        # Errors of 35 bases just below friction were up to 2.2 times their estimates without this.
        missed *= 4.0 if missed > rtol else 1.0
        trial, before, estimate = finer, numerical, numerical + missed
        # If missed slip alone exceeds rtol, a finer rule does not help: the check finds its zone.
        if estimate <= rtol or numerical <= tuning.HOPED_ERROR * rtol:
            break
        # The error of a rule decreases about in proportion to its tolerance; the next tolerance
        # follows from that, within bounds.
        share = min(tuning.HOPED_ERROR * rtol / numerical, 0.1)
        wanted = max(tolerance * max(share, 1e-2), tuning.FINEST_RULE)
        if not (wanted := affordable(fields, wanted)) < 0.5 * tolerance:
            break
        tolerance = wanted
    return replace(trial, steps=steps), estimate


def affordable(fields: ZoneFields, tolerance: float) -> float:
    """Return a tolerance whose rule has at most `MOST_NODES` nodes, the given one if it does.

    The number of nodes is predicted from that of another rule.
    """
    # Rules of films are made longer, in proportion to the rule that was asked for.
    per_node = fields.panels.jacobian.size / len(fields.rule.y)
    # The number of nodes grows with the logarithm of 1 / tolerance: doubling is a small step.
    while per_node * len(rule_for(tolerance).y) > tuning.MOST_NODES:
        tolerance *= 2
    return tolerance


def checked_zones(
    trial: Trial, refined: Trial, estimate: float, rtol: float
) -> tuple[Trial, float]:
    """Check refined zones to rtol, correct and solve if need be; return trial and estimate."""
    refined, fields = replace(refined, steps=trial.steps + refined.steps), refined.profile.fields
    # The search has checked the law on this very rule.
    if fields.rule is trial.profile.fields.rule:
        return refined, estimate
    # Violations are measured relative to the largest slip rate; where that is small, the tolerance
    # for tractions becomes stricter in the same ratio.
    strictness = min(max(float(refined.profile.largest_rate), 1 / tuning.LAW_TOLERANCE), 1.0)
    broken = violations(refined.profile, strictness * rtol)
    if broken is None:
        return replace(refined, lawful=False), np.inf
    if not broken or not trial.lawful:
        return refined, estimate
    zones = corrected(fields.zones, broken, fields.load)
    rule = rule_for(affordable(fields, rtol / tuning.RULE_SHARE))
    rules = _Rules(rule, max(0.1 * rtol, tuning.LEAST_LEFT_SHIFT), rule)
    again = _settled(fields.factors, zones, fields.load, rules)
    last, estimate = refined_zones(again, rtol)
    steps = refined.steps + again.steps + last.steps
    return replace(last, steps=steps, sets=trial.sets + again.sets), estimate


def stricter(best: Trial, estimate: float, rtol: float) -> tuple[Trial, float, int]:
    """Return the better of the present solution and one found on strict rules.

    A zone that hardly slips is driven by less traction than a loose rule resolves. Also returned
    are its error estimate and the additional pivots.
    """
    fields, strict = best.profile.fields, _strict(rtol)
    trial, pivots = strict_search(fields.factors, fields.load, rtol)
    again, lower = checked_zones(trial, *refined_zones(trial, strict), strict)
    return (again, lower, pivots) if lower <= estimate else (best, estimate, pivots)
