"""Integrate slip rate and frictional power over position and time, and find the largest slip."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.running import LEAST_SHARE, Power
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.halfplane.rules import Rule, finer_rule
from semianalytic.scene.arrays import Array

EARLIEST = 1e-200
"""Slowness of what has not begun."""


def largest_slip_over_time(profile: Profile) -> float:
    """Return the largest |slip| / t on the contact, b = mu = 1 and one-sided.

    It is the largest value at the nodes of panels that slip and at ever closer points around it, or
    the limit at a slipping edge. Where the interface sticks, slip / t decreases.
    """
    limits = [abs(float(profile.fields.load.far_slip_rate)), abs(profile.edge_slip_rate)]
    slipping = list(profile.panels.layout.slip)
    if not slipping:
        return max(limits)
    # slip / t is stationary where it is largest: an error d of the place costs only d^2.
    u = np.sort(profile.panels.at.v[slipping].ravel())
    # Each narrows the bracket 16 times, in all to 1e-7: slip is flat at its maximum.
    for _ in range(6):
        size = np.abs(profile.slip_over_time(u))
        top = int(np.argmax(size))
        limits.append(float(size[top]))
        u = np.linspace(u[max(top - 1, 0)], u[min(top + 1, len(u) - 1)], 33)
    return max(limits)


def infinite_rates(profile: Profile) -> list[Power]:
    """Powers of `rate_integral` that are infinite at the right ends of closed panels.

    They occur under a film where the contact opens slowly.
    """
    powers, is_open = profile.rate_integral.powers, profile.panels.layout.open
    return [power for power in powers if not is_open[power.panel] and np.all(power.exponent < 0)]


def contact_integral(profile: Profile, weight: Array) -> float:
    """Return the integral of weight |V| over xi, of slip behind the first front; weight (p, n).

    It is integrated by parts: V is unbounded at c, but its slope has a principal value there, which
    the rule of the panels integrates.
    """
    panels, rate, total = profile.panels, profile.rate_integral, 0.0
    # xi = 1 / v, so that |d xi| = dv / v^2.
    density = weight / np.square(panels.at.v)
    passed = panels.rule.running(density * panels.jacobian)
    whole, lost = panels.integrals(density), panels.integrals(passed * rate.density)
    for power in rate.powers:
        i, by_y = power.panel, power.by_y(panels)
        left = passed[i] if power.at_left else passed[i] - whole[i]
        # Next to the left end the running integral has lost its digits to rounding; there it is
        # the density times the distance.
        if power.at_left:
            near = power.share(panels) < LEAST_SHARE
            left[near] = (density * panels.from_left)[i, near]
        lost[i] += panels.rule.spacing * np.sum(left * by_y)
        lost[i] += 0.0 if power.at_left else whole[i] * float(power.total)
    infinite = [power.panel for power in infinite_rates(profile)]
    for i in panels.layout.slip:
        end = profile.rate_starts[i] + rate.totals[i]
        gained = float(end * whole[i] - lost[i])
        # The rate is infinite at an end of this panel, and the weight may be: their product is
        # summed at the nodes, where both are finite.
        if i in infinite:
            product = (density * panels.jacobian)[i] * profile.slip_rate_at_nodes[i]
            gained = _summed(product, panels.rule.spacing)
        total += panels.sense[i] * gained
    return total


def dissipation(profile: Profile, u: Array) -> Array:
    """Return `running_integrals` of the power |tau V| that the contact takes, (2, m)."""
    return running_integrals(profile, u, profile.carried_inside)


def slipped_rate(profile: Profile, zones: Iterable[tuple[float, float, int]]) -> float:
    """Return the integral of |V| over velocities, one-sided and b = mu = 1, behind the first wave.

    Zones are (inner, outer, sense), in velocities over c_t. Without friction, or where the contact
    is open, the panels of a profile have a nominal sense, and its zones say where V is opposite.
    """
    unit = np.ones_like(profile.panels.at.v)
    total = contact_integral(profile, unit)
    against = [ends for *ends, sense in zones if sense != _named_sense(profile, *ends)]
    beyond = {0.0: total}
    ends = np.array([end for edges in against for end in edges if end])
    if len(ends):
        inside = running_integrals(profile, 1 / ends, lambda _, v, __: np.ones_like(v))[0]
        beyond.update(zip(ends.tolist(), inside.tolist(), strict=True))
    # Where V is opposite, its part of the total was counted with the wrong sign.
    return total - 2 * sum(beyond[inner] - beyond[outer] for inner, outer in against)


def _named_sense(profile: Profile, inner: float, outer: float) -> int:
    """Return the nominal sense of the panel between two velocities over c_t, inf ahead of waves."""
    between = 0.5 / max(inner, EARLIEST) if np.isinf(outer) else 2 / (inner + outer)
    lefts = [left.v[0] for left in profile.panels.left]
    return profile.panels.sense[max(int(np.searchsorted(lefts, between)) - 1, 0)]


def running_integrals(
    profile: Profile, u: Array, weight: Callable[[int, Array, Array], Array]
) -> Array:
    """Return integrals of weight |V| over velocities from 1/u to c_l, and over slownesses up to u.

    They are (2, m), one-sided, b = mu = 1; `weight` is a function of panel, slowness and |V|.  The
    first is negative where the interface slips ahead of all waves and u is there.
    """
    panels = profile.panels
    # Beyond the ends of panels the second integrand grows in another way than the slip rate.
    # On the rule of the panels work between nodes was off by up to four tolerances, so by 0.1.
    rule = finer_rule(panels.rule, 0.8, panels.rule.further)
    front = panels.left[0].v[0]
    speed = np.array([panels.sense[0] * float(profile.fields.load.far_slip_rate)])
    # Ahead of all waves V is constant, and its integrals over xi and over v are elementary.
    ahead = weight(0, np.zeros(1), speed) * speed
    reached = np.minimum(u, front)
    result = ahead * np.stack([1 / front - 1 / np.maximum(reached, EARLIEST), reached])
    at = profile.fields.factors.cut(u)
    infinite = {power.panel: power for power in infinite_rates(profile)}
    for panel in panels.layout.slip:
        if panel in infinite:
            result += _beside_opening(profile, infinite[panel], at, weight)
            continue
        for left, right in _pieces(profile, int(panel), float(u.max(initial=0.0))):
            density = _density(profile, int(panel), (left, right), weight, rule)
            from_left, to_right = at.minus(left), -at.minus(right)
            inside, behind = (from_left > 0) & (to_right > 0), to_right <= 0
            # y is the variable of the rule, v = left + width / (1 + e^-y).
            y = np.log(from_left[inside] / to_right[inside])
            result[:, inside] += rule.interpolate_running(y, density).T
            result[:, behind] += (density @ rule.weights)[:, None]
    return result


def _beside_opening(
    profile: Profile, rate: Power, at: CutPoints, weight: Callable[[int, Array, Array], Array]
) -> Array:
    """Return both integrals gained on a closed panel with a power at its right end, (2, m)."""
    panels, panel = profile.panels, rate.panel
    left, right, v = panels.left[panel], panels.right[panel], panels.at.v[panel]
    assert right is not None
    speed = panels.sense[panel] * profile.slip_rate_at_nodes[panel]
    power = weight(panel, v, speed) * speed * panels.jacobian[panel]
    density = np.stack([power / np.square(v), power])
    last = density[:, -2:]
    # The last two nodes determine the power; its integral is taken in closed form.
    exponent = np.log(last[:, :1] / last[:, 1:]) / panels.rule.spacing
    unit = Power(panel, False, exponent, np.ones_like(exponent))
    unit = replace(unit, amount=last[:, 1:] / unit.by_y(panels)[:, -1:])
    # The remainder after the power vanishes at the end of the panel, so the rule converges.
    rest = density - unit.by_y(panels)
    inside, behind = (at.minus(left) > 0) & (at.minus(right) < 0), at.minus(right) >= 0
    result = np.zeros((2, len(at.v)))
    y = panels.coordinate(panel, at[inside])
    result[:, inside] = panels.rule.interpolate_running(y, rest).T + unit.inside(panels, at[inside])
    result[:, behind] = (rest @ panels.rule.weights + unit.total)[:, None]
    return result


def _pieces(profile: Profile, panel: int, most: float) -> Iterator[tuple[CutPoints, CutPoints]]:
    """Yield parts of a panel with singular slip rate at ends only, up to slowness `most`."""
    panels, factors = profile.panels, profile.fields.factors
    right = panels.right[panel]
    ends = [panels.left[panel]]
    if panel == panels.layout.pole:
        ends.append(factors.front_c)
    if right is not None:
        ends.append(right)
    while right is None and ends[-1].v[0] < most:
        # Half, twice and four times leave errors of six scenes at 0.036 of their estimates.
        ends.append(factors.cut(4.0 * ends[-1].v))
    return pairwise(ends)


def _density(
    profile: Profile,
    panel: int,
    ends: tuple[CutPoints, CutPoints],
    weight: Callable[[int, Array, Array], Array],
    rule: Rule,
) -> Array:
    """Return weight |V| / v^2 and weight |V| times dv/dy at nodes between two points, (2, n)."""
    left, right = ends
    width = right.minus(left)
    near_left, near_right = width * rule.share, width * rule.share[::-1]
    at = CutPoints(np.where(rule.y < 0, left.parts + near_left, right.parts - near_right))
    speed = profile.panels.sense[panel] * profile.slip_rate_inside(panel, at)
    power = weight(panel, at.v, speed) * speed * width * rule.bell
    # d xi = dv / v^2 turns an integral over velocities into one over slownesses.
    return np.stack([power / np.square(at.v), power])


def _summed(values: Array, spacing: float) -> float:
    """Return the trapezoidal sum of values (n,) that go on as a geometric series."""
    ratio = values[-1] / values[-2] if values[-2] else 0.0
    return float(spacing * (values.sum() + values[-1] * ratio / (1 - ratio)))
