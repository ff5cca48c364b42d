"""The article's claims judged by three methods; all verdicts are computed from the cases.

V is the relative slip rate, twice that of the article, in units of V_0 = 2 Q_0/(mu b).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from docs.studies.article.cases import LOW_FRICTION, RATIOS, SHEAR_SPEED, Case, Cases, article_scene
from docs.studies.article.published import (
    DEFAULT_READING,
    REVERSE_LIMIT,
    examine_reading,
    published_slip,
)
from docs.studies.runner import Row
from semianalytic import solve
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.selfsimilar.zones.motion import SlipZone

HOLDS, FAILS, PARTLY, SILENT = "holds", "fails", "in part", "no answer"
METHODS = ("published", "exact", "finite_elements")
AUXETIC_RATIO = RATIOS["auxetic"]
NOTICEABLE = 0.01
"""Simulated slip rate over V_0 above which slip counts."""


Verdicts = tuple[str, str, str]
"""What the published algorithm, the exact solution and the simulation say, with their numbers."""
Judge = Callable[[Cases], Verdicts]
CLAIMS: list[Callable[[Cases], Row]] = []
"""Functions that judge the claims, in the order of this file."""


def _claim(section: str, text: str, base: str) -> Callable[[Judge], Judge]:
    """Decorate a function that finds the three verdicts on a claim, and add it to `CLAIMS`."""

    def add(judge: Judge) -> Judge:
        row: Row = {"section": section, "claim": text, "base": base}
        CLAIMS.append(lambda cases: row | dict(zip(METHODS, judge(cases), strict=True)))
        return judge

    return add


def _judge(true: bool, evidence: str) -> str:
    return f"{HOLDS if true else FAILS}: {evidence}"


def _stuck_shear_near_front(case: Case) -> float:
    """Return the largest simulated q* over c_t T < x < c_l T, one cell off the shear front."""
    x = case.history.x / (SHEAR_SPEED * case.history.t[-1])
    ahead = (x > 1 + 1 / case.resolution) & (x < 2)
    held = case.solution.scene.superposition.in_place
    change = case.history.shear_traction[-1, ahead] - held.shear
    return float(change.max() * case.chi)


def _zones_text(zones: tuple[SlipZone, ...]) -> str:
    if not zones:
        return "no slip"
    return ", ".join(
        f"{z.inner / SHEAR_SPEED:.4g} to {z.outer / SHEAR_SPEED:.4g}"
        + (" reversed" if z.sense < 0 else "")
        for z in zones
    )


def published_reversal(chi: float) -> float:
    """Return the published algorithm's mean reversed slip rate / V_0 on 0.63 to 0.95 c_t t."""
    return -chi * float(published_slip(chi).at(np.linspace(1.05, 1.6, 100)).mean())


@_claim("3.6.1", "no shear traction ahead of the shear wave", "any")
def no_shear_ahead(cases: Cases) -> Verdicts:
    front = float(stuck_traction(1 / 3, "II")(1.0))
    simulated = _stuck_shear_near_front(cases["remote", 2.0])
    return (
        _judge(front < NOTICEABLE, f"its own (3.14) gives q = {front:.4f} Q_0 at x = c_t t"),
        _judge(front < NOTICEABLE, f"q rises from 0 at c_l t to {front:.4f} Q_0 at c_t t"),
        _judge(simulated < NOTICEABLE, f"q up to {simulated:.3f} Q_0 on c_t t < x < c_l t"),
    )


@_claim("3.6.1", "the edge sticks for chi >= 1", "remote")
def edge_sticks(cases: Cases) -> Verdicts:
    case = cases["remote", 1.2]
    exact = case.solution.edge_slip_rate / case.scale
    simulated = case.simulated_mean(0.05, 0.3)
    published = published_slip(1.2).slip_rate[-1]
    above = cases["remote", 2.0].simulated_mean(0.05, 0.3)
    return (
        f"{SILENT}: it has no stick; V(x = c_t t/5) = {published:.3g} chi V_0 at chi = 1.2",
        _judge(
            exact <= 1e-9,
            f"V(0+) = {exact:.4f} V_0 at chi = 1.2; the limit is sqrt(b/a) = 1.414, and "
            "with constant pressure the edge slips at every chi",
        ),
        _judge(
            simulated < NOTICEABLE,
            f"V = {simulated:.3f} V_0 next to the edge at chi = 1.2, {above:.1g} at chi = 2",
        ),
    )


@_claim("6.0.1", "a slip wave for any chi > 1, bounded by x = (a/b) c_t t and c_t t", "remote")
def slip_wave_above_one(cases: Cases) -> Verdicts:
    case, lower = cases["remote", 2.0], cases["remote", 1.2]
    end = examine_reading(DEFAULT_READING).slip_end
    largest = float(np.abs(case.simulated()[1]).max())
    return (
        f"{PARTLY}: slip of one sense from c_t t to {end:.3f} c_t t at chi = 2 (a/b = 0.5); p* = 0 "
        "at 0.590 c_t t, where the bound without base load changes sign",
        _judge(
            bool(case.solution.zones),
            f"{_zones_text(case.solution.zones)} at chi = 2; at chi = 1.2 it slips on x/(c_t t) = "
            f"{_zones_text(lower.solution.zones)}",
        ),
        _judge(largest > NOTICEABLE, f"largest V = {largest:.1g} V_0 at chi = 2"),
    )


@_claim("6.0.2", "for chi < 1 slip fills 0 < x < c_t t and ends there", "remote; preloaded")
def slip_reaches_shear_front(cases: Cases) -> Verdicts:
    remote, preloaded = cases["remote", 0.5], cases["preloaded", 0.5]
    ahead = remote.simulated_mean(1.2, 1.8)
    velocity, rate = preloaded.simulated()
    last = float(velocity[rate > NOTICEABLE].max())
    zones = preloaded.solution.zones
    return (
        f"{HOLDS}: by construction: the unknowns start at u = b",
        _judge(
            bool(zones) and abs(zones[-1].outer / SHEAR_SPEED - 1) < 1e-3,
            f"remote: everywhere, {remote.exact(np.array([1.5]))[0]:.3f} V_0 at 1.5 c_t t; "
            f"preloaded, chi = 0.5: x/(c_t t) = {_zones_text(zones)}",
        ),
        _judge(
            abs(last - 1) < 0.02 and ahead < NOTICEABLE,
            f"remote: {ahead:.3f} V_0 on 1.2 to 1.8 c_t t; preloaded: last slip at "
            f"{last:.3f} c_t t",
        ),
    )


@_claim("6.0.2", "for chi < 1 slip has a maximum that lags the shear front", "remote")
def maximum_lags(cases: Cases) -> Verdicts:
    remote = cases["remote", 0.5]
    velocity, rate = remote.simulated()
    inside = (velocity > 0.1) & (velocity < 0.9)
    spread = float(np.ptp(rate[inside]) / rate[inside].mean())
    sample = remote.exact(np.linspace(0.05, 0.99, 50))
    place = examine_reading(DEFAULT_READING).maximum
    return (
        _judge(place < 0.95, f"maximum at x = {place:.3f} c_t t for chi = 0.5"),
        _judge(
            float(np.ptp(sample)) > 1e-6,
            f"V = {sample[0]:.5f} V_0 everywhere behind the shear front, no maximum; with "
            "constant pressure V is largest at the edge",
        ),
        _judge(spread > 0.05, f"V varies by {spread:.1%} over 0.1 < x/(c_t t) < 0.9"),
    )


@_claim(
    "6.0.3", f"reverse slip on c_R t < x < c_t t for chi < {REVERSE_LIMIT}", "remote; preloaded"
)
def reverse_slip(cases: Cases) -> Verdicts:
    limit = examine_reading(DEFAULT_READING).reverse_limit
    low = (cases["remote", LOW_FRICTION], cases["preloaded", LOW_FRICTION])
    reversed_zones = [z for case in low for z in case.solution.zones if z.sense < 0]
    least = min(float(case.simulated()[1].min()) for case in low)
    auxetic = cases["auxetic", LOW_FRICTION]
    return (
        f"{PARTLY}: reversed there at every chi up to 2: no limit"
        if np.isinf(limit)
        else f"{HOLDS}: limit chi = {limit:.4f}",
        _judge(
            bool(reversed_zones),
            f"none at chi = {LOW_FRICTION} and nu = 1/3; at nu = {AUXETIC_RATIO}, preloaded, "
            f"x/(c_t t) = {_zones_text(auxetic.solution.zones)}",
        ),
        _judge(
            least < -NOTICEABLE,
            f"least V = {least:.1g} V_0 at chi = {LOW_FRICTION}; at nu = {AUXETIC_RATIO} "
            f"{auxetic.simulated()[1].min():.3f}",
        ),
    )


@_claim(
    "6.0.3",
    "the Rayleigh speed separates forward from reverse slip",
    f"preloaded, nu = {AUXETIC_RATIO}",
)
def rayleigh_separates(cases: Cases) -> Verdicts:
    case = cases["auxetic", LOW_FRICTION]
    rayleigh = case.solution.scene.material.rayleigh_speed / SHEAR_SPEED
    slip = published_slip(LOW_FRICTION)
    behind = slip.u > 1.02
    change = np.flatnonzero(np.diff(np.sign(slip.slip_rate[behind])))[0]
    published = float(1 / slip.u[behind][change])
    zone = next(z for z in case.solution.zones if z.sense < 0)
    inner, outer = zone.inner / SHEAR_SPEED, zone.outer / SHEAR_SPEED
    velocity, rate = case.simulated()
    seen = velocity[rate < -NOTICEABLE * np.abs(rate).max()]
    extent = f"{seen.min():.3f} to {seen.max():.3f}" if len(seen) else "none"
    return (
        _judge(
            abs(published - 0.9325) < 0.02,
            f"senses change at {published:.3f} c_t t (c_R = 0.933 c_t, chi = {LOW_FRICTION})",
        ),
        _judge(
            min(abs(inner - rayleigh), abs(outer - rayleigh)) < 1e-3,
            f"reverse slip straddles c_R = {rayleigh:.3f} c_t: {inner:.3f} to {outer:.3f} c_t",
        ),
        _judge(
            bool(len(seen)) and abs(float(seen.min()) - rayleigh) < 0.01,
            f"reversed on x/(c_t t) = {extent}, c_R at {rayleigh:.3f}",
        ),
    )


@_claim("6.0.2", "the slip zone has no natural limit and grows with time", "preloaded")
def no_natural_limit(cases: Cases) -> Verdicts:
    case = cases["preloaded", 0.5]
    outer = case.solution.zones[0].outer / SHEAR_SPEED
    widths = []
    for row in (len(case.history.t) // 2, -1):
        slipping = case.history.slip_rate[row] > NOTICEABLE * case.scale
        widths.append(float(case.history.x[slipping].max() / case.history.t[row]) / SHEAR_SPEED)
    return (
        f"{HOLDS}: by construction: a function of x/t",
        f"{HOLDS}: self-similar: the zone ends at x = {outer:.4f} c_t t (chi = 0.5)",
        _judge(
            abs(widths[1] / widths[0] - 1) < 0.1,
            f"it ends at {widths[0]:.3f} c_t t at half time and {widths[1]:.3f} c_t t at the end",
        ),
    )


@_claim("6.0.1", "for chi > 1 full stick is approached over time", "remote")
def full_stick_approached(cases: Cases) -> Verdicts:
    case, stuck = cases["remote", 1.2], cases["remote", 2.0]
    exact = case.solution.edge_slip_rate / case.scale
    simulated = case.simulated_mean(0.02, 0.1)
    published = published_slip(2.0)
    rates = published.slip_rate[published.u > 3.5]
    changes = int(np.count_nonzero(np.diff(np.sign(rates))))
    return (
        _judge(
            float(np.abs(rates).max()) < NOTICEABLE,
            f"|V| up to {np.abs(rates).max():.2g} chi V_0 on 0.2 to 0.29 c_t t, changing sign "
            f"{changes} times (chi = 2)",
        ),
        f"{PARTLY}: above chi = 1.414 only; at chi = 1.2 V tends to {exact:.4f} V_0 at every point",
        f"{PARTLY}: V = {simulated:.3f} V_0 at x = 0.02 to 0.1 c_t t for chi = 1.2, "
        f"{stuck.simulated_mean(0.02, 0.1):.1g} for chi = 2",
    )


@_claim("6.0.3, 7", "lower friction gives worse reversal", f"preloaded, nu = {AUXETIC_RATIO}")
def lower_friction_worse(cases: Cases) -> Verdicts:

    def reversed_width(chi: float) -> float:
        zones = solve(article_scene("auxetic", chi)).zones
        return sum((z.outer - z.inner) / SHEAR_SPEED for z in zones if z.sense < 0)

    middle, lowest = published_reversal(0.5), published_reversal(0.01)
    low, high = reversed_width(LOW_FRICTION), reversed_width(0.1)
    _, rate = cases["auxetic", LOW_FRICTION].simulated()
    return (
        _judge(
            lowest > middle,
            f"mean reversed V on 0.63 to 0.95 c_t t {middle:.3f} V_0 at chi = 0.5, "
            f"{lowest:.3f} at 0.01",
        ),
        f"{PARTLY if low > high else FAILS}: width of reverse slip {low:.3f} c_t t at chi = "
        f"{LOW_FRICTION}, {high:.3f} at 0.1; nothing of the kind at nu = 1/3",
        f"{PARTLY if rate.min() < -NOTICEABLE else FAILS}: least V {rate.min():.3f} V_0 at chi = "
        f"{LOW_FRICTION}; none at nu = 1/3",
    )
