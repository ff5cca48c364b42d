"""Weak friction: slip as without friction, but for narrow stick gaps where it changes sense.

Where friction is small against the load, the interface slips behind the longitudinal front at
nearly the rate V of a frictionless one, and a stick gap opens where V changes sense: across it the
traction goes from one bound of friction to the other.  Behind the shear front the impedance is
i m, and around a gap between slownesses l and r

    T = pi v m V' ((v - l) / (v - r))^(1/2),    r - l = 4 f p / (pi m |V'|),

for Im T / (pi v), integrated over the gap, is 2 f p.  Gaps of the order of friction are seen by no
grid; as a start for Newton's method this is good to the order of their width.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.selfsimilar.coulomb import NARROWEST_GAP
from semianalytic.selfsimilar.edges import Edges, edges_of
from semianalytic.selfsimilar.front import opening_behind_front
from semianalytic.selfsimilar.layout import Zone
from semianalytic.selfsimilar.profile import Profile
from semianalytic.selfsimilar.zones import Load, ZoneFields

_WEAK = 0.03  # friction over the step of shear traction
_WIDEST_GAP = 1.2  # over its distance from c; beside a narrow strip it is below 4 / pi
_TOLERANCE = 1e-6  # of the frictionless slip rate
_NOISE = 1e-2  # of a rule, over its tolerance: V is no less just behind the front
_NEAREST = 1e-16  # to c
_PER_E = 3  # points per factor e of the distance from c


def frictionless_profile(factors: RayleighFactors, load: Load, rule: Rule) -> Profile:
    """Slip everywhere, without friction."""
    edges = Edges(factors, (1,), (True, True), ())
    return Profile(ZoneFields(factors, load, edges.zones(np.zeros(0)), rule))


def slip_senses(profile: Profile) -> tuple[list[int], list[CutPoints]]:
    """Senses of slip of a profile without friction, from the longitudinal front inward, and where
    they change; none where it does not slip."""
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    factors = profile.fields.factors
    senses: list[int] = []
    changes: list[CutPoints] = []
    for side, farthest in ((-1, factors.c - factors.a * (1 + 1e-6)), (1, 1e6)):

        def rate(log: float, side: int = side) -> float:
            at = factors.beside("c", [side * np.exp(log)])
            return float(profile.slip_rate_at(at)[0])

        low, high = np.log([_NEAREST, farthest])
        logs = np.linspace(high, low, int(_PER_E * (high - low)))[::-side]
        rates = profile.slip_rate_at(factors.beside("c", side * np.exp(logs)))
        least = _NOISE * profile.fields.rule.tolerance * float(profile.largest_rate)
        before = None
        for log, sense in zip(logs, np.sign(rates) * (np.abs(rates) > least), strict=True):
            if not sense:
                continue
            if not senses or sense != senses[-1]:
                if senses and before is not None:
                    root = brentq(rate, before, log, xtol=1e-14)
                    changes.append(factors.beside("c", [side * np.exp(root)]))
                elif senses:
                    changes.append(factors.front_c)
                senses.append(int(sense))
            before = log
    return senses, changes


def weak_friction_zones(factors: RayleighFactors, load: Load) -> tuple[Edges, Array] | None:
    """Zones under friction that is weak against the step of shear traction, to start from.

    None where it is not weak, or its gaps would be wide or ahead of the shear front.
    """
    friction, far = float(load.friction), float(load.far_slip_rate)
    strongest = friction * max(load.base_pressure, load.load_pressure)
    if not strongest < _WEAK * abs(load.load_shear):
        return None
    profile = frictionless_profile(factors, replace(load, friction=0.0), rule_for(_TOLERANCE))
    senses, changes = slip_senses(profile)
    first = int(np.sign(far or load.load_shear))
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
    return edges_of(factors, [*zones, Zone(left, None, senses[-1])])


def _gaps(
    profile: Profile, load: Load, senses: list[int], changes: list[CutPoints]
) -> list[tuple[CutPoints, CutPoints, int]]:
    """Stick gaps where V changes sense, with the sense of the zone ahead of each.

    Too wide for the strip around c that slips the other way they join to a single one, which is
    twice as wide as the strip would be.
    """
    widths = [_gap_width(profile, load, change) for change in changes]
    if len(changes) == 2 and widths[0] > _WIDEST_GAP * abs(changes[0].from_c[0]):
        strip = [2 * change.from_c[0] for change in changes]
        if -strip[0] < 2 * NARROWEST_GAP:
            return []
        around = profile.fields.factors.beside("c", strip)
        return [(around[[0]], around[[1]], senses[0])]
    return [
        (CutPoints(change.parts - width / 2), CutPoints(change.parts + width / 2), sense)
        for sense, change, width in zip(senses, changes, widths, strict=False)
        if abs(change.from_c[0]) > NARROWEST_GAP
    ]


def _gap_width(profile: Profile, load: Load, change: CutPoints) -> float:
    """Width in slowness of the stick gap that friction opens where V changes sense."""
    fields, from_c = profile.fields, change.from_c
    step = 1e-4 * from_c
    beside = fields.factors.beside("c", np.concatenate([from_c - step, from_c + step]))
    before, after = profile.slip_rate_at(beside)
    slope = abs((after - before) / (2 * step[0]))
    strength = replace(fields, load=load).strength(change)[0]
    impedance = abs(fields.factors.impedance_behind(change)[0])
    return float(4 * strength / (np.pi * impedance * slope))
