"""Zones of weak friction: slip everywhere, but for stick gaps where it changes its sense.

If friction is small compared with the load, the interface slips behind the longitudinal front at
nearly the rate V of a frictionless interface, and a stick gap opens where V changes sense. Across
the gap the traction goes from one bound of friction to the other. Behind the shear front the
impedance is i m, and around a gap between slownesses l and r

    T = pi v m V' ((v - l) / (v - r))^(1/2),    r - l = 4 f p / (pi m |V'|),

because the integral of Im T / (pi v) over the gap is 2 f p.  No grid resolves gaps of the order of
friction; as a start for Newton's method this is accurate to the order of their width
(docs/solver.md, "Weak friction and thresholds").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.selfsimilar.zones import tuning


def frictionless_profile(factors: RayleighFactors, load: Load, rule: Rule) -> Profile:
    """Return the profile of slip everywhere without friction."""
    return Profile(ZoneFields(factors, load, (Zone(None, None, 1),), rule))


def slip_senses(profile: Profile) -> tuple[list[int], list[CutPoints]]:
    """Return the senses of slip without friction, from the longitudinal front inward.

    The second list holds the points at which they change; both are empty if nothing slips.
    """
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    factors = profile.fields.factors
    # Noise over tolerance; V is no less just behind the front.
    least = 1e-2 * profile.fields.rule.tolerance * float(profile.largest_rate)
    low, ahead = np.log(tuning.NEAREST_TO_C), factors.c - factors.a * (1 + 1e-6)
    senses: list[int] = []
    changes: list[CutPoints] = []
    for side, high in ((-1, np.log(ahead)), (1, np.log(1e6))):

        def rate(log: float, side: int = side) -> float:
            at = factors.beside("c", [side * np.exp(log)])
            return float(profile.slip_rate_at(at)[0])

        # Points even in the logarithm of the distance from c resolve the strip of reverse slip,
        # however narrow it is.
        logs = np.linspace(high, low, int(tuning.POINTS_PER_E * (high - low)))[::-side]
        rates = profile.slip_rate_at(factors.beside("c", side * np.exp(logs)))
        before = None
        for log, sense in zip(logs, np.sign(rates) * (np.abs(rates) > least), strict=True):
            if not sense:
                continue
            if not senses or sense != senses[-1]:
                if senses and before is not None:
                    root = brentq(rate, before, log, xtol=1e-14)
                    changes.append(factors.beside("c", [side * np.exp(root)]))
                # The sense changes between the last point ahead of c and the first one behind it.
                elif senses:
                    changes.append(factors.front_c)
                senses.append(int(sense))
            before = log
    return senses, changes


def weak_friction_zones(factors: RayleighFactors, load: Load) -> list[Zone] | None:
    """Return the zones of friction weak against the step; None if not, or by wide gaps."""
    friction, far = float(load.friction), float(load.far_slip_rate)
    strongest = friction * max(load.base_pressure, load.load_pressure)
    if not strongest < tuning.WEAK_FRICTION * abs(load.load_shear):
        return None
    without = replace(load, friction=0.0)
    profile = frictionless_profile(factors, without, rule_for(1e-6))
    senses, changes = slip_senses(profile)
    first = int(np.sign(far or load.load_shear))
    # Ahead of the shear front M is complex and the formula for the gaps does not hold.
    if senses[:1] != [first] or any(change.from_b[0] <= 0 for change in changes):
        return None
    left = None
    if not far and not (load.critical and first * load.base_shear > 0):
        left = opening_behind_front(factors, load, first)
        if left is None:
            return None
    zones = []
    for start, end, sense in _gaps(profile, load, senses, changes):
        zones.append(Zone(left, start, sense))
        left = end
    return [*zones, Zone(left, None, senses[-1])]


def _gaps(
    profile: Profile, load: Load, senses: list[int], changes: list[CutPoints]
) -> list[tuple[CutPoints, CutPoints, int]]:
    """Return stick gaps where V changes sense, each with the sense of the zone ahead of it.

    Gaps too wide for the strip around c are one, twice as wide.
    """
    widths = [_gap_width(profile, load, change) for change in changes]
    # Next to a narrow strip the ratio is below 4 / pi.
    if len(changes) == 2 and widths[0] > 1.2 * abs(changes[0].from_c[0]):
        strip = [2 * change.from_c[0] for change in changes]
        if -strip[0] < 2 * tuning.NARROWEST_GAP:
            return []
        around = profile.fields.factors.beside("c", strip)
        return [(around[[0]], around[[1]], senses[0])]
    return [
        (CutPoints(change.parts - width / 2), CutPoints(change.parts + width / 2), sense)
        for sense, change, width in zip(senses, changes, widths, strict=False)
        if abs(change.from_c[0]) > tuning.NARROWEST_GAP
    ]


def _gap_width(profile: Profile, load: Load, change: CutPoints) -> float:
    """Return the width in slowness of the stick gap that friction opens where V changes sense."""
    fields, from_c = profile.fields, change.from_c
    step = 1e-4 * from_c
    beside = fields.factors.beside("c", np.concatenate([from_c - step, from_c + step]))
    before, after = profile.slip_rate_at(beside)
    slope = abs((after - before) / (2 * step[0]))
    strength = replace(fields, load=load).strength(change)[0]
    impedance = abs(fields.factors.impedance_behind(change)[0])
    # r - l = 4 f p / (pi m |V'|), with M = i m behind the shear front.
    return float(4 * strength / (np.pi * impedance * slope))


def behind_front(factors: RayleighFactors) -> CutPoints:
    """Return points from the longitudinal to the shear front, even in the log of distance."""
    nearest, farthest = np.log(1e-16), np.log(1 - factors.a)
    return factors.beside("a", np.exp(np.arange(nearest, farthest, tuning.FRONT_STEP)))


def opening_behind_front(factors: RayleighFactors, load: Load, sense: int) -> CutPoints | None:
    """Return where a zone opens that slips behind the longitudinal front nearly without friction.

    There T = Q_0, turned by the phase of the impedance, has raised the traction to friction. The
    result is None if that happens nowhere ahead of the shear front.
    """
    at = behind_front(factors)
    # A front of slowness p makes T = Q_0 k / (k + p) of the load: v - p takes the place of v.
    over = np.pi * (at.v - load.slowness)
    slope = load.load_shear * np.sin(factors.phase(at)) / over * at.from_a
    # Trapezoidal sum of dtau/dv = Im T / (pi v) in the logarithm of v - a.
    gained = np.cumsum((slope[1:] + slope[:-1]) / 2 * tuning.FRONT_STEP)
    mode_one = load.stuck(factors, "I")
    strength = load.friction * (load.base_pressure + load.load_pressure * mode_one.at(at[1:]))
    above = np.flatnonzero(sense * (load.base_shear + gained) >= strength)
    return at[[above[0] + 1]] if len(above) else None


def with_slip_at_front(
    factors: RayleighFactors, zones: Sequence[Zone], load: Load
) -> Sequence[Zone]:
    """Return the zones with one ahead of them if a base at friction is released at the first front.

    This zone ends approximately where the stuck interface would satisfy Coulomb's law again.
    """
    sense = int(np.sign(load.base_shear))
    held = not (load.critical and sense and load.load_pressure) or bool(load.far_slip_rate)
    if held or (zones and zones[0].left is None):
        return zones
    first = zones[0] if zones else None
    if factors.mode == "III" and first and first.left is not None and first.left.from_b[0] < 0:
        # In antiplane shear no shear arrives ahead of the shear front, which would hold the strip.
        return [replace(first, left=None), *zones[1:]]
    at = behind_front(factors)
    at = at[at.from_a > 1e-11]  # of less rounding shows nothing
    if load.opened is None:
        pressure = load.friction * load.load_pressure * load.stuck(factors, "I").at(at)
    else:
        pressure = load.friction * (load.pressure(factors, at) - load.base_pressure)
    # Stuck traction less strength, both less their value ahead, where the base is exactly at
    # friction.
    excess = sense * load.load_shear * load.stuck(factors, factors.mode).at(at) - pressure
    kept = np.flatnonzero(excess <= 0)
    # At nu = 0 the pressure falls too late behind the front, and no strip is found.
    if not len(kept) or not kept[0]:
        return zones
    right = at[[kept[0]]]
    if zones and zones[0].left is not None and not right.first_below(zones[0].left):
        return zones
    return [Zone(None, right, sense), *zones]
