"""Solve a scene: guess the slip zones, locate their edges, check Coulomb's law, correct, refine.

`solve` converts the scene to a load. `_search` finds zones that satisfy Coulomb's law on a loose
rule, `_refined` improves their edges until the error estimate is below rtol, and `_checked` checks
the law once more, to rtol. See docs/solver.md, "Which zones".
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from time import perf_counter

import numpy as np

from semianalytic.cut.load import Load, check_pressure, contact_opens, scaled_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import (
    CoulombFriction,
    FrictionLaw,
    RateFriction,
    ViscousFriction,
)
from semianalytic.scene.named import checked_scene
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.rated.rated import (
    always_cut_off,
    approached,
    check_rated,
    companion_error,
    settled_zones,
    unit_law,
    unsettled,
)
from semianalytic.selfsimilar.solution import Solution, Statistics
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.corrections import corrected, rearranged
from semianalytic.selfsimilar.zones.coulomb import violations
from semianalytic.selfsimilar.zones.edges import Placement, locate_edges, placement_of, polish_edges
from semianalytic.selfsimilar.zones.estimate import (
    intensity_gain,
    loose_tolerance,
    missed_slip,
    narrowness,
    numerical_error,
    slip_gain,
)
from semianalytic.selfsimilar.zones.guesses import guesses
from semianalytic.selfsimilar.zones.motion import slip_zones
from semianalytic.separation.normal import with_opening

_log = logging.getLogger(__name__)


def solve(scene: Scene | str | PathLike[str], *, rtol: float = 1e-8) -> Solution:
    """Solve a scene for slip and stick on its interface: equations (2.1) and (3.21) of the article.

    The method is described in docs/solver.md; docs/theory.md, "Slip under a step, for given zones"
    states the equations.

    Parameters
    ----------
    scene : Scene, str or path
        A scene with self-similar loads, or its name or file as for `find_scene`.
    rtol : float
        Wanted accuracy, between 1e-12 and 1e-2, of every quantity that `Solution.error_estimate`
        bounds: zone edges (relative to c_t), the slip rate in L1 and at points away from edges and
        from c_R, and integrals.

    Returns
    -------
    Solution
        Its `status` is "converged" if the error estimate is below rtol and Coulomb's law holds
        to rtol at the nodes and between them.

    Raises
    ------
    SceneError
        If there is no such scene, it is not self-similar, its viscosity is so large that slip is
        below rounding, friction falls with slip rate in a way that has no solution here, or rtol is
        out of range.
    TensionError
        If the contact would open to infinity; the message says why.

    Examples
    --------
    >>> from semianalytic import Material, Scene, Tractions, solve
    >>> base, load = Tractions(1.0, 0.0), Tractions(0.0, 1.0)
    >>> solution = solve(Scene(Material(1.0, 1.0, 1 / 3), 1.0, base, load))
    >>> solution.status
    'converged'
    >>> round(solution.zones[0].outer, 6)
    0.375
    >>> len(solve("preloaded").zones)  # a scene by its name
    2
    """
    scene = checked_scene("solve", scene)
    scene.check_self_similar()
    rtol = checked_number(
        "rtol", rtol, "lie between 1e-12 and 1e-2", lambda given: 1e-12 <= given <= 1e-2
    )
    check_pressure(scene)
    rated = _is_rated(scene.friction_law)
    if rated and contact_opens(scene):
        raise SceneError(
            "solve: where the contact opens friction that falls with slip rate is not known; make "
            "base pressure larger, or simulate the scene with finite elements (docs/limits.md)."
        )
    if rated:
        return _solve_rated(scene, rtol)
    load, stress = scaled_load(scene)
    if load.resistance is not None and load.resistance > tuning.STRONGEST_RESISTANCE:
        raise SceneError(
            "solve: under so large a viscosity slip is below rounding; make it less than "
            f"{_strongest_viscosity(scene):.3g} (docs/limits.md)."
        )
    factors = rayleigh_factors(scene.material.poisson_ratio, scene.shear_mode)
    # The normal problem comes first: slip does not change the pressure (docs/separation.md).
    load, normal = with_opening(load, factors, rtol)
    # The opening uses up a part of the wanted accuracy; the slip zones have the rest.
    wanted, rtol = rtol, rtol - (normal.error if normal and normal.error < rtol else 0.0)
    clock = [perf_counter()]
    # Under a strong film slip is so small that a loose rule would not show it.
    strong = load.resistance is not None and load.resistance > tuning.STRONG_RESISTANCE
    trial, pivots = (_strict_search if strong else _loose_search)(factors, load, rtol)
    clock.append(perf_counter())
    best, estimate = _refined(trial, rtol)
    clock.append(perf_counter())
    best, estimate = _checked(trial, best, estimate, rtol)
    # Written with `not` so that an estimate that is not a number also leads to the strict search.
    if not estimate <= rtol and not strong:
        best, estimate, more = _stricter(best, estimate, rtol)
        pivots += more
    clock.append(perf_counter())
    statistics = Statistics(
        pivots=pivots,
        newton_steps=best.steps,
        zone_sets=best.sets,
        unknowns=len(best.placement.unknowns),
        nodes=int(best.profile.panels.jacobian.size),
        seconds=dict(zip(("zones", "edges", "check"), np.diff(clock).tolist(), strict=True)),
    )
    estimate += normal.error if normal else 0.0
    status = _status(best, estimate, wanted)
    zones = slip_zones(best.profile, scene.material)
    _log.debug(
        "solve: %s, %d zones, error estimate %.1e, %d Newton steps, %.3g s",
        *(status, len(zones), estimate, best.steps, clock[-1] - clock[0]),
    )
    return Solution(scene, zones, status, estimate, statistics, best.profile, stress, normal)


def _is_rated(law: FrictionLaw) -> bool:
    """Return whether strength depends on slip rate other than linearly, unlike that of a viscous
    film."""
    return isinstance(law, RateFriction) and not isinstance(law, ViscousFriction)


def _strongest_viscosity(scene: Scene) -> float:
    """Return the largest viscosity for which a scene is solved [stress time / length]."""
    # eta = 2 viscosity / (rho c_t), as in `scaled_load`, solved for the viscosity.
    return tuning.STRONGEST_RESISTANCE * scene.material.shear_impedance / 2


def _solve_rated(scene: Scene, rtol: float) -> Solution:
    """Solve a scene whose strength depends on slip rate, from its solution under constant friction.

    If several solutions exist, this is the one to which Newton's method leads from there
    (docs/rate.md, "Newton's method for any smooth law").
    """
    clock, coulomb = [perf_counter()], replace(scene, friction_law=CoulombFriction())
    dry = solve(coulomb, rtol=max(rtol, 1e-8))
    # Without slip the law is that of Coulomb, since strength at rest is f p.
    if not dry.zones:
        return replace(dry if rtol >= 1e-8 else solve(coulomb, rtol=rtol), scene=scene)
    clock.append(perf_counter())
    law, speed = unit_law(scene, dry.stress_unit), scene.material.shear_speed
    check_rated(dry.profile, law, speed)
    # Slip rates rise more steeply from the edges than under constant friction, so the first rule
    # must not be as loose.
    loose = min(loose_tolerance(rtol), tuning.LOOSEST_RATE_RULE)
    rated, last = approached(dry.profile, law, loose, speed)
    best, estimate = rated, np.inf
    # What the longest rule leaves out no finer one brings back, after seconds to minutes.
    hopeless = rated is not None and always_cut_off(rated, law) > rtol
    if rated is not None and hopeless:
        estimate = companion_error(rated, law, loose)
    # Each pass is on a finer rule, from the previous slip rate, until a coarser companion agrees.
    for share in tuning.RATE_RULE_SHARES:
        if rated is None or hopeless or estimate <= rtol:
            break
        tolerance = max(share * rtol, tuning.FINEST_RATE_RULE)
        best = rated = settled_zones(rated.profile, law, tolerance, speed)
        if rated is not None:
            estimate = companion_error(rated, law, tolerance)
            hopeless = always_cut_off(rated, law) > rtol
    clock.append(perf_counter())
    if best is None:
        reason = unsettled(last, law, speed)
        return replace(dry, scene=scene, status=reason, error_estimate=np.inf)
    profile, clock = best.profile, [*clock, perf_counter()]
    statistics = replace(
        dry.statistics,
        newton_steps=len(best.moves),
        unknowns=len(best.placement.unknowns),
        nodes=int(profile.panels.jacobian.size),
        seconds=dict(zip(("zones", "edges", "check"), np.diff(clock).tolist(), strict=True)),
    )
    exceeded = f"the error estimate {estimate:.1e} exceeds rtol {rtol:.1e}"
    status = "converged" if estimate <= rtol else exceeded
    zones = slip_zones(profile, scene.material)
    return Solution(scene, zones, status, estimate, statistics, profile, dry.stress_unit)


@dataclass(frozen=True)
class _Trial:
    """Zones that were tried, with their fields.

    Attributes
    ----------
    placement : Placement
        Positions of their edges.
    profile : Profile
        Their fields on a rule.
    lawful : bool
        Whether they satisfy Coulomb's law on that rule.
    steps, sets : int
        Numbers of Newton steps and of sets of zones that were needed.
    """

    placement: Placement
    profile: Profile
    lawful: bool
    steps: int = 0
    sets: int = 1


@dataclass(frozen=True)
class _Rules:
    """The rule on which edges are located, the shift [c_t] that may be left, and the checking
    rule."""

    locating: Rule
    shift: float
    checking: Rule


def _search(
    factors: RayleighFactors, load: Load, rtol: float, tolerance: float
) -> tuple[_Trial, int]:
    """Return lawful zones on the rule of a tolerance, trying one guess after another, and the
    pivots."""
    checking = rule_for(tolerance)
    shift = max(tuning.LOCATED_SHIFT * rtol, tuning.LEAST_LOCATED_SHIFT)
    trial = _unlawful(placement_of(factors, (), load), load, checking)
    pivots = steps = sets = 0
    for guess in guesses(factors, load):
        # Edges need fewer digits than the check of the law. If an earlier guess failed, though, a
        # loose rule may be the reason.
        locating = checking if guess.doubtful else rule_for(tuning.COARSER_LOCATING * tolerance)
        trial = _settled(factors, guess.zones, load, _Rules(locating, shift, checking))
        pivots, steps, sets = pivots + guess.pivots, steps + trial.steps, sets + trial.sets
        if trial.lawful:
            break
    return replace(trial, steps=steps, sets=sets), pivots


def _loose_search(factors: RayleighFactors, load: Load, rtol: float) -> tuple[_Trial, int]:
    """Run `_search` on as loose a rule as rtol and most scenes allow."""
    return _search(factors, load, rtol, loose_tolerance(rtol))


def _strict_search(factors: RayleighFactors, load: Load, rtol: float) -> tuple[_Trial, int]:
    """Run `_search` for zones that slip so little that a loose rule does not show them."""
    return _search(factors, load, _strict(rtol), min(loose_tolerance(rtol), tuning.STRICT_RULE))


def _strict(rtol: float) -> float:
    """Return the accuracy to which zones that hardly slip are searched for."""
    return max(tuning.STRICTER * rtol, min(rtol, tuning.STRICTEST))


# Numbers that overflow end in a status, not in a warning.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def _settled(factors: RayleighFactors, zones: Sequence[Zone], load: Load, rules: _Rules) -> _Trial:
    """Correct zones, one set after another, until Coulomb's law holds; return the last trial."""
    steps, may_turn = 0, True
    for sets in range(1, tuning.MOST_ZONE_SETS + 1):
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
            return _Trial(placement, profile, True, steps, sets)
        zones = corrected(profile.fields.zones, broken, load)
    return replace(_unlawful(placement, load, rules.checking), steps=steps, sets=sets)


def _unlawful(placement: Placement, load: Load, rule: Rule) -> _Trial:
    """Return a trial for zones that were given up, or for no zones at all."""
    fields = ZoneFields(placement.edges.factors, load, placement.zones, rule)
    return _Trial(placement, Profile(fields), False)


# Numbers that overflow end in a status, not in a warning.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def _refined(trial: _Trial, rtol: float) -> tuple[_Trial, float]:
    """Improve the edges on finer and finer rules until a coarser companion agrees to rtol.

    Returns
    -------
    The trial, with the number of steps that were taken, and its error estimate.
    """
    if not trial.lawful:
        return replace(trial, steps=0), np.inf
    start, steps, covers_c = trial.placement, 0, trial.profile.panels.layout.pole >= 0
    tolerance = rtol / tuning.RULE_SHARE
    # Where slip covers c_R, the estimate for points between nodes is larger: a finer rule
    # leaves room for it.
    if covers_c and trial.profile.fields.rule is not rule_for(tolerance):
        tolerance = rtol / tuning.RULE_SHARE_AT_POLE
    tolerance = _affordable(trial.profile.fields, tolerance)
    # Slip that is narrow ahead of an opening needs its edge relative to that width, and stress
    # intensity that is a small difference needs it better by what it gains from a shift.
    target = tuning.LEFT_SHIFT * rtol * narrowness(start.edges, start.unknowns)
    usual = tuning.LEFT_SAFETY * tuning.SAFETY
    target *= usual / max(usual, intensity_gain(trial.profile.fields))
    target = max(target, tuning.LEAST_LEFT_SHIFT)
    before = np.inf
    for _ in range(tuning.MOST_REFINEMENTS):
        placement, fields, left = polish_edges(
            trial.placement, trial.profile.fields, rule_for(tolerance), target
        )
        profile = trial.profile if fields is trial.profile.fields else Profile(fields)
        finer = replace(trial, placement=placement, profile=profile)
        steps += placement.steps
        numerical = numerical_error(placement, fields, tolerance, left)
        numerical *= max(1.0, slip_gain(profile) / tuning.COVERED_GAIN)
        missed = float(missed_slip(profile))
        # Zones that shrink to nothing have no relative error.
        if not numerical + missed < np.inf:
            return replace(finer, steps=steps), np.inf
        # What does not decrease any more is rounding: finer rules would only cost more.
        if numerical > tuning.LEAST_GAIN * before:
            break
        # The zone of slip that is missed by more is not known, nor how its slip grows beside it.
        missed *= tuning.MISSED_SAFETY if missed > rtol else 1.0
        trial, before, estimate = finer, numerical, numerical + missed
        # If missed slip alone exceeds rtol, a finer rule does not help: the check finds its zone.
        if estimate <= rtol or numerical <= tuning.HOPED_ERROR * rtol:
            break
        # The error of a rule decreases about in proportion to its tolerance; the next tolerance
        # follows from that, within bounds.
        share = min(tuning.HOPED_ERROR * rtol / numerical, tuning.SLOWEST_REFINEMENT)
        wanted = max(tolerance * max(share, tuning.FASTEST_REFINEMENT), tuning.FINEST_RULE)
        if not (wanted := _affordable(fields, wanted)) < tuning.LEAST_GAIN * tolerance:
            break
        tolerance = wanted
    return replace(trial, steps=steps), estimate


def _affordable(fields: ZoneFields, tolerance: float) -> float:
    """Return a tolerance whose rule has at most `MOST_NODES` nodes, the given one if it does.

    The number of nodes is predicted from that of another rule.
    """
    # Rules of films are made longer, in proportion to the rule that was asked for.
    per_node = fields.panels.jacobian.size / len(fields.rule.y)
    # The number of nodes grows with the logarithm of 1 / tolerance: doubling is a small step.
    while per_node * len(rule_for(tolerance).y) > tuning.MOST_NODES:
        tolerance *= 2
    return tolerance


def _checked(trial: _Trial, refined: _Trial, estimate: float, rtol: float) -> tuple[_Trial, float]:
    """Check refined zones to rtol, and solve for corrected zones where they break Coulomb's law.

    Returns
    -------
    The trial, with the numbers of all its steps and sets of zones, and its error estimate.
    """
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
    rule = rule_for(_affordable(fields, rtol / tuning.RULE_SHARE))
    rules = _Rules(rule, max(tuning.LOCATED_SHIFT * rtol, tuning.LEAST_LEFT_SHIFT), rule)
    again = _settled(fields.factors, zones, fields.load, rules)
    last, estimate = _refined(again, rtol)
    steps = refined.steps + again.steps + last.steps
    return replace(last, steps=steps, sets=trial.sets + again.sets), estimate


def _stricter(best: _Trial, estimate: float, rtol: float) -> tuple[_Trial, float, int]:
    """Return the better of the present solution and one found on strict rules.

    A zone that hardly slips is driven by less traction than a loose rule resolves. Also returned
    are its error estimate and the additional pivots.
    """
    fields, strict = best.profile.fields, _strict(rtol)
    trial, pivots = _strict_search(fields.factors, fields.load, rtol)
    again, lower = _checked(trial, *_refined(trial, strict), strict)
    return (again, lower, pivots) if lower <= estimate else (best, estimate, pivots)


def _status(best: _Trial, estimate: float, rtol: float) -> str:
    """Return "converged", or a sentence that says what to distrust."""
    nearly = _nearly_at_friction(best.profile.fields.load)
    if not best.lawful:
        return "no set of slip zones was found that fulfils Coulomb's law everywhere" + nearly
    if estimate > rtol:
        finer = max(rtol / tuning.RULE_SHARE, tuning.FINEST_RULE)
        costly = _affordable(best.profile.fields, finer) > finer
        most = f"{tuning.MOST_NODES:,}"
        more = f", for which more than {most} nodes and far more than seconds are needed"
        exceeds = f"the error estimate {estimate:.1e} exceeds rtol {rtol:.1e}"
        return exceeds + more * costly + nearly
    return "converged"


def _nearly_at_friction(load: Load) -> str:
    """Return the end of a status that says what to change about a base just below friction.

    Under a base that dwarfs the step, what then keeps the interface stuck is rounding of the base.
    """
    strength = float(load.friction) * load.base_pressure
    step = max(abs(load.load_shear), float(load.friction) * abs(load.load_pressure))
    lack = strength - abs(load.base_shear)
    nearly = 0 < lack < tuning.NEARLY_AT_FRICTION * strength
    if load.critical or not nearly or not step < tuning.SMALL_STEP * strength:
        return ""
    return (
        f"; the base lacks {lack / strength:.1e} of friction, and the step is "
        f"{step / strength:.1e} of it: let the base be exactly at friction, or lack more than "
        f"{tuning.NEARLY_AT_FRICTION:.0e} of it"
    )
