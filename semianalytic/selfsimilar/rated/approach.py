"""The way from constant friction to a law of slip rate: in steps, corrected until the law holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import lies_between
from semianalytic.scene.errors import SceneError
from semianalytic.selfsimilar.rated.law import UnitLaw
from semianalytic.selfsimilar.rated.newton import Rated, cut_off, least_exponent, rated_zones
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.corrections import corrected
from semianalytic.selfsimilar.zones.coulomb import violations
from semianalytic.selfsimilar.zones.estimate import difference


def check_rated(profile: Profile, law: UnitLaw, speed: float) -> None:
    """Raise SceneError where slip that weakens strength has no solution; `speed` is c_t.

    Slip covers c_R, or strength falls faster with slip rate than radiation can balance.
    """
    if not law.law.fall_with_rate:
        return
    fields, front = profile.fields, profile.fields.factors.front_c
    rayleigh = fields.factors.has_rayleigh_wave
    if rayleigh and any(lies_between(zone.left, front, zone.right) for zone in fields.zones):
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
            if least_exponent(start.fields, least)[0] < tuning.STEEP_EXPONENT:
                break
            step /= 2
            continue
        start, reached = rated.profile, share
        if reached == 1.0:
            return rated, start
    return None, start


def unsettled(last: Profile, law: UnitLaw, speed: float) -> str:
    """Return a sentence that says why zones of the whole law were not reached from a profile."""
    exponent, at = least_exponent(last.fields, law)
    if exponent < tuning.STEEP_EXPONENT:
        return (
            f"slip rate rises like the power {exponent:.2g} of the distance from a zone edge near "
            f"x/t = {speed / at:.4g}, which no rule resolves; raise the rate or lower the "
            "reduction of the friction law, or march the scene"
        )
    return "Newton's method found no slip rate that agrees with the strength it leaves"


def settled_zones(start: Profile, law: UnitLaw, tolerance: float, speed: float) -> Rated | None:
    """Return zones corrected until Coulomb's law holds, from those of a profile, or None."""
    zones, profile = list(start.fields.zones), start
    for _ in range(12):  # sets of zones tried from one start; more were never needed
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
    """Return the error estimate from a coarser companion with its own edges and slip rate."""
    coarser = tuning.COARSER_COMPANION * tolerance
    coarse = rated_zones(fine.profile, fine.placement.zones, law, coarser)
    if not coarse.converged:
        return np.inf
    edges, unknowns, fields = fine.placement.edges, fine.placement.unknowns, fine.profile.fields
    moved = coarse.placement.unknowns
    between = float(difference(edges, unknowns, moved, fields, coarse.profile.fields))
    return between + cut_off(fine.profile.fields, law)
