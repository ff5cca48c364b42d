"""How steeply slip rate rises from the edges of zones, and the length of rule that this needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rules import REACH, Rule, rule_for
from semianalytic.selfsimilar.rated.law import UnitLaw
from semianalytic.selfsimilar.zones import tuning


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
