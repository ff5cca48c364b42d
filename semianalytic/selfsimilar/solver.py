"""Solve a scene: guess the slip zones, locate their edges, check Coulomb's law, correct, refine.

`solve` converts the scene to a load and leads through the stages of `search`, or those of `rated`
where strength depends on slip rate.
"""

from __future__ import annotations

import logging
from dataclasses import replace
from os import PathLike
from time import perf_counter

import numpy as np

from semianalytic.cut.load import Load, check_pressure, contact_opens, scaled_load
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import scene_of_one_solid
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.rated.approach import (
    approached,
    check_rated,
    companion_error,
    settled_zones,
    unsettled,
)
from semianalytic.selfsimilar.rated.law import unit_law
from semianalytic.selfsimilar.rated.newton import cut_off
from semianalytic.selfsimilar.search import (
    Trial,
    affordable,
    checked_zones,
    loose_search,
    refined_zones,
    strict_search,
    stricter,
)
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.statistics import Statistics
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.estimate import loose_tolerance
from semianalytic.separation.opening import with_opening

_log = logging.getLogger(__name__)


def refuses(scene: Scene) -> str | None:
    """Return why a scene is not solved exactly unless that is asked for, or None."""
    try:
        scene.check_self_similar()
    except SceneError as error:
        return str(error).removeprefix("solve: ")
    if scene.law.fall_with_rate > 0:
        return (
            "where friction falls with slip rate the exact answer takes long, and is unstable; ask "
            "for it with `method` self-similar (docs/rate.md)."
        )
    return None


def solve(scene: Scene | str | PathLike[str], *, rtol: float = 1e-8) -> Solution:
    """Solve a scene for slip and stick on its interface: equations (2.1) and (3.21) of the article.

    The method is described in docs/solver.md; docs/theory.md, "Slip under a step, for given zones"
    states the equations.

    Parameters
    ----------
    scene : Scene, str or path
        A scene with self-similar loads, or its name or file as for `find`.
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
    scene = scene_of_one_solid("solve", scene)
    rtol = checked_rtol(scene, rtol)
    if is_rated(scene):
        return _solve_rated(scene, rtol)
    load, stress = scaled_load(scene)
    factors = rayleigh_factors(scene.material.poisson_ratio, scene.shear_mode)
    # The normal problem comes first: slip does not change the pressure.
    load, normal = with_opening(load, factors, rtol)
    # The opening uses up a part of the wanted accuracy; the slip zones have the rest.
    wanted, rtol = rtol, rtol - (normal.error if normal and normal.error < rtol else 0.0)
    clock = [perf_counter()]
    # Under a strong film slip is so small that a loose rule would not show it: from
    # 1e10 [mu b] on no search on loose rules found zones.
    strong = load.resistance is not None and load.resistance > 1e8
    trial, pivots = (strict_search if strong else loose_search)(factors, load, rtol)
    clock.append(perf_counter())
    best, estimate = refined_zones(trial, rtol)
    clock.append(perf_counter())
    best, estimate = checked_zones(trial, best, estimate, rtol)
    # Written with `not` so that an estimate that is not a number also leads to the strict search.
    if not estimate <= rtol and not strong:
        best, estimate, more = stricter(best, estimate, rtol)
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
    _log.debug(
        "solve: %s, error estimate %.1e, %d Newton steps, %.3g s",
        *(status, estimate, best.steps, clock[-1] - clock[0]),
    )
    return Solution(scene, status, estimate, statistics, best.profile, stress, normal)


def is_rated(scene: Scene) -> bool:
    """Return whether strength depends on slip rate other than linearly, as under a film."""
    return type(scene.law) is not Coulomb


def checked_rtol(scene: Scene, rtol: float) -> float:
    """Return rtol as a number; raise what `solve` raises before it begins."""
    scene.check_self_similar()
    rtol = checked_number(
        "rtol", rtol, "lie between 1e-12 and 1e-2", lambda given: 1e-12 <= given <= 1e-2
    )
    check_pressure(scene)
    if is_rated(scene) and contact_opens(scene):
        raise SceneError(
            "solve: where the contact opens friction that falls with slip rate is not known; make "
            "base pressure larger, or simulate the scene with finite elements (docs/limits.md)."
        )
    strongest = tuning.STRONGEST_RESISTANCE * scene.material.shear_impedance / 2
    if isinstance(scene.law, Coulomb) and scene.law.viscosity > strongest:
        raise SceneError(
            "solve: under so large a viscosity slip is below rounding; lower it below "
            f"{strongest:.3g} (docs/limits.md)."
        )
    return rtol


def _solve_rated(scene: Scene, rtol: float) -> Solution:
    """Solve a scene of rate-dependent strength, by Newton's method from its constant friction.

    If several solutions exist, this is the one to which the method leads from there.
    """
    clock, coulomb = [perf_counter()], replace(scene, friction=scene.coefficient)
    dry = solve(coulomb, rtol=max(rtol, 1e-8))
    # Without slip the law is that of Coulomb, since strength at rest is f p.
    if not dry.zones:
        return replace(dry if rtol >= 1e-8 else solve(coulomb, rtol=rtol), scene=scene)
    clock.append(perf_counter())
    law, speed = unit_law(scene, dry.stress_unit), scene.material.shear_speed
    check_rated(dry.profile, law, speed)
    # Slip rates rise more steeply from the edges than under constant friction, so the first rule
    # must not be as loose.
    loose = min(loose_tolerance(rtol), 1e-5)
    rated, last = approached(dry.profile, law, loose, speed)
    best, estimate = rated, np.inf
    # Slip that the longest rule omits is not found by finer ones, after seconds to minutes.
    longest = tuning.FARTHEST_RATE_REACH
    hopeless = rated is not None and cut_off(rated.profile.fields, law, longest) > rtol
    if rated is not None and hopeless:
        estimate = companion_error(rated, law, loose)
    # Each pass is on a finer rule, from the previous slip rate, until a coarser companion agrees.
    for share in (0.1, 0.01):  # what the length of a rule leaves out no finer one brings back
        if rated is None or hopeless or estimate <= rtol:
            break
        tolerance = max(share * rtol, 1e-13)
        best = rated = settled_zones(rated.profile, law, tolerance, speed)
        if rated is not None:
            estimate = companion_error(rated, law, tolerance)
            hopeless = cut_off(rated.profile.fields, law, longest) > rtol
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
    return Solution(scene, status, estimate, statistics, profile, dry.stress_unit)


def _status(best: Trial, estimate: float, rtol: float) -> str:
    """Return "converged", or a sentence on what is unreliable."""
    nearly = _nearly_at_friction(best.profile.fields.load)
    if not best.lawful:
        return "no set of slip zones was found that fulfils Coulomb's law everywhere" + nearly
    if estimate > rtol:
        finer = max(rtol / tuning.RULE_SHARE, tuning.FINEST_RULE)
        costly = affordable(best.profile.fields, finer) > finer
        more = f", for which more than {tuning.MOST_NODES:,} nodes and far more than seconds"
        exceeds = f"the error estimate {estimate:.1e} exceeds rtol {rtol:.1e}"
        return exceeds + f"{more} are needed" * costly + nearly
    return "converged"


def _nearly_at_friction(load: Load) -> str:
    """Return the end of a status that says what to change about a base just below friction."""
    strength = float(load.friction) * load.base_pressure
    step = max(abs(load.load_shear), float(load.friction) * abs(load.load_pressure))
    lack = strength - abs(load.base_shear)
    # Under a base that dwarfs the step, rounding of the base is what then keeps it stuck.
    # Bases at friction, and all that lack 1e-8 of it or more, converge (18 kinds of scene).
    nearly = 0 < lack < 1e-8 * strength
    if load.critical or not nearly or not step < 1e-2 * strength:
        return ""
    return (
        f"; the base lacks {lack / strength:.1e} of friction, and the step is "
        f"{step / strength:.1e} of it: let the base be exactly at friction, or lack more than "
        "1e-08 of it"
    )
