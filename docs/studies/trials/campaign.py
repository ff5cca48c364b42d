"""Random scenes of every law, mode and opening: all that an answer says against a better answer.

``python -m docs.studies.trials.campaign campaign-answers --workers 2 --output docs`` solves scenes
whose bases are 1e-6 to 1e6 times the step to 1e-5, 1e-6 or 1e-8.  Edges, slip rate, slip,
tractions, gap, power, stress intensities, fields in the bodies and derivatives are held against an
answer to 1e-12 (1e-9 where strength depends on slip rate), derivatives also against what doubling
all tractions does, and Coulomb friction against its law where no node lies.  An error is counted
over the sum of what both answers say that it may be.
"""

from __future__ import annotations

import math
from contextlib import suppress
from time import process_time
from typing import Any

import numpy as np
from numpy.random import Generator

import semianalytic as sf
from docs.studies.runner import Row, Study, main
from docs.studies.trials.draws import drawn, random_wide_scene
from semianalytic import Solution
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone

SCENES, SEED = 5000, 3
FINE = {"constant": 1e-12, "Coulomb": 1e-9, "RateWeakening": 1e-9}
"""Accuracies of better answers: films that open take minutes to 1e-12, and friction that falls with
slip rate does not come further."""
ROUGH = (1e-5, 1e-6, 1e-8)
_TRACTIONS = ("base_pressure", "base_shear", "load_pressure", "load_shear")
_CLEAR = 0.03
"""Distance from edges and from c_R, over c_t, beyond which errors hold at points."""
_POINTS, _BODY_POINTS = 60, 8
_MOST_NODES = 3000
"""Nodes of an answer up to which its derivatives are asked for: those of more take minutes."""
_ROUNDING = 4e-16
"""Rounding of tractions over the base that is part of them."""
_PER_STRETCH, _BETWEEN = 60, 8
"""Points of a stretch between edges, and points between two places of an edge, at which slip is
looked for."""
_AT_EDGE = 1e-12
"""Velocity over c_t that stands for the contact edge itself."""
QUANTITIES = [
    *("edges", "slip_rate", "slip", "traction", "pressure", "gap", "power", "intensity"),
    *("coulomb", "velocity", "stress", "displacement", "derivatives", "homogeneity"),
]


def answer_row(seed: int, index: int) -> Row:
    """Solve a scene twice and hold all that the rougher answer says against the better one.

    The outcome is "converged", "refused", "unresolved" (either answer says so) or what was raised;
    errors over estimates are nan where not asked or where there is no answer.
    """
    scene, random = drawn(seed, index, random_wide_scene)
    rtol, began = float(random.choice(ROUGH)), process_time()
    law = "constant" if isinstance(scene.friction, float) else type(scene.law).__name__
    ratio = scene.superposition.in_place.pressure / _largest_load(scene)
    row: Row = {"index": index, "law": law, "mode": scene.mode, "ratio": ratio, "rtol": rtol}
    row |= {"opens": False, "outcome": "refused", "seconds": 0.0}
    row |= dict.fromkeys(QUANTITIES, math.nan)
    try:
        rough = sf.solve(scene, method="self-similar", rtol=rtol)
        row |= {"opens": bool(rough.openings), "outcome": "unresolved"}
        # a better answer than one that has said that it is none takes minutes, in vain
        if rough.status == "converged":
            fine = sf.solve(scene, method="self-similar", rtol=FINE[law])
            if fine.error_estimate <= rtol:
                row |= {"outcome": "converged", **errors(rough, fine, random, index)}
    except (sf.SceneError, sf.TensionError):
        pass
    except Exception as error:  # what a campaign is for
        row["outcome"] = f"raised {type(error).__name__}"
    return {**row, "seconds": process_time() - began}


def errors(rough: Solution, fine: Solution, random: Generator, index: int) -> Row:
    """Errors over estimates by quantity; fields in the bodies of one scene in three, derivatives of
    another."""
    found = {"edges": error_between(rough, fine) / _bound(rough, fine)}
    found |= on_the_interface(rough, fine, random) | _totals(rough, fine)
    if isinstance(rough.scene.friction, float):
        found["coulomb"] = broken_law(rough, random) / _bound(rough, fine)
    if index % 3 == 0:
        found |= _in_the_bodies(rough, fine, random)
    rated = isinstance(rough.scene.law, sf.RateWeakening)
    if index % 3 == 1 and not rated and fine.statistics.nodes <= _MOST_NODES:
        with suppress(sf.SceneError):  # there is none, as in its own words
            found |= _derivatives(rough, fine, random)
    return found


def _bound(rough: Solution, fine: Solution) -> float:
    return rough.error_estimate + fine.error_estimate


def _largest_load(scene: sf.Scene) -> float:
    load = scene.superposition.taken_off
    return max(abs(load.shear), abs(load.pressure))


def _clear(solution: Solution, random: Generator) -> Array:
    """Positions at unit time off edges and c_R, close to the contact edge too under one body."""
    material = solution.scene.material
    fastest, speed = material.longitudinal_speed, min(b.shear_speed for b in solution.scene.bodies)
    least = 0.0 if solution.scene.lower_material is None else -1.0
    x = np.concatenate(
        [random.uniform(0, 1.1 * fastest, _POINTS), fastest * 10 ** random.uniform(-6, -1, 10)]
    )
    parts: list[SlipZone | OpenZone] = [*solution.zones, *solution.openings]
    edges = [edge for part in parts for edge in (part.inner, part.outer) if least < edge < math.inf]
    marks = np.array([*edges, material.rayleigh_speed])
    return x[np.abs(x[:, None] - marks).min(axis=1) > _CLEAR * speed]


def over(apart: Any, allowed: Any) -> float:
    """The largest share of what is allowed; inf where nothing is and there is a difference."""
    apart, allowed = np.broadcast_arrays(apart, allowed)
    share = np.divide(apart, allowed, out=np.where(apart > 0, np.inf, 0.0), where=allowed > 0)
    return float(share.max(initial=0.0))


def _over(change: Array, scale: Array | float, bound: float) -> float:
    """The largest change over a scale and a bound; 0 where nothing is and nothing changes."""
    return over(np.abs(change), scale) / bound


def _both(rough: Solution, fine: Solution, name: str, *at: Array) -> tuple[Array, Array]:
    """The change of a field at unit time from one answer to the other, and its better values."""
    first, other = (getattr(answer, name)(*at, 1.0) for answer in (rough, fine))
    return first - other, other


def on_the_interface(rough: Solution, fine: Solution, random: Generator) -> Row:
    bound, scene = _bound(rough, fine), rough.scene
    clear, fastest = _clear(fine, random), scene.material.longitudinal_speed
    anywhere = random.uniform(0, 1.05 * fastest, _POINTS)
    rate, rates = _both(rough, fine, "slip_rate", clear)
    slip, _ = _both(rough, fine, "slip", anywhere)
    shear, shears = _both(rough, fine, "shear_traction", clear)
    pressure, pressures = _both(rough, fine, "pressure", clear)
    # between two bodies slip changes the pressure, without a bound at the contact edge
    own = 0.0 if scene.lower_material is None else np.abs(pressures)
    load, base = _largest_load(scene), scene.superposition.in_place.pressure
    rounding = _ROUNDING * max(base * max(scene.coefficient, 1.0), load) / bound
    # a zone that slips less than the estimate may be missing
    peaks = (_peak(fine, zone.inner, zone.outer) for zone in fine.zones)
    fastest_slip = max(np.abs(rates).max(initial=0.0), *peaks, 0)
    # close to a stuck contact edge a large change may take off a large base
    near = np.abs(shears) + np.abs(shears - scene.base.shear) + load + rounding
    found = {
        "slip_rate": _over(rate, fastest_slip, bound),
        "slip": _over(slip, fine.max_slip(1.0), bound),
        "traction": _over(shear, near, bound),
        "pressure": _over(
            pressure, own + base + abs(scene.superposition.taken_off.pressure), bound
        ),
    }
    if fine.openings:
        ends = max(zone.outer for zone in fine.openings)
        x = ends * (np.arange(_POINTS) + 0.5) / _POINTS
        gap, gaps = _both(rough, fine, "gap", x)
        found["gap"] = _over(np.abs(gap).mean(), float(gaps.max()), bound)
    return found


def _totals(rough: Solution, fine: Solution) -> Row:
    bound = _bound(rough, fine)
    power, better = (float(answer.frictional_power(1.0)) for answer in (rough, fine))
    found = {"power": _over(np.array(power - better), abs(better), bound)}
    pairs = zip(rough.stress_intensity(1.0), fine.stress_intensity(1.0), strict=True)
    found["intensity"] = max(_over(np.asarray(a - b), np.abs(b), bound) for a, b in pairs)
    return found


def _in_the_bodies(rough: Solution, fine: Solution, random: Generator) -> Row:
    """Compare the fields at points of both bodies away from the fronts of waves from the edge."""
    scene = rough.scene
    material, load = scene.material, _largest_load(scene)
    fastest, speed = material.longitudinal_speed, material.shear_speed
    x, y = fastest * random.uniform(-1, 1, (2, _BODY_POINTS))
    off = np.abs(np.hypot(x, y)[:, None] - np.array([fastest, speed])).min(axis=1) > _CLEAR * speed
    x, y = x[off], y[off]
    bound = rough.field_error + fine.field_error
    rate = load / material.shear_impedance
    base = scene.superposition.in_place.pressure + abs(scene.superposition.in_place.shear)
    scales = {"velocity": rate, "stress": load + _ROUNDING * base / bound, "displacement": rate}
    found = {}
    for name, scale in scales.items():
        change, better = _both(rough, fine, name, x, y)
        found[name] = _over(change, np.abs(better) + scale, bound)
    return found


def _value(scene: sf.Scene, name: str) -> float:
    part, kind = name.split("_")
    return float(getattr(getattr(scene, part), kind))


def _derivatives(rough: Solution, fine: Solution, random: Generator) -> Row:
    """Compare derivatives of slip rate and slip with those of the better answer, and their weighted
    sum with the fields themselves, since doubling all tractions doubles the fields."""
    scene, x = rough.scene, _clear(fine, random)
    fronts = (scene.material.shear_speed, scene.material.longitudinal_speed)
    x = x[np.abs(x[:, None] - np.array(fronts)).min(axis=1) > _CLEAR * scene.material.shear_speed]
    names = [name for name in _TRACTIONS if _value(scene, name)]
    pairs = {name: (rough.derivative(name), fine.derivative(name)) for name in names}
    worst, sums = 0.0, {"slip_rate": (0.0, 0.0), "slip": (0.0, 0.0)}
    for name, (pair, other) in pairs.items():
        value = abs(_value(scene, name))
        for field in sums:
            own, better = getattr(pair, field)(x, 1.0), getattr(other, field)(x, 1.0)
            exact = np.abs(getattr(fine, field)(x, 1.0)).max(initial=0.0)
            scale = max(np.abs(better).max(initial=0.0), exact / value)
            bound = pair.error_estimate + other.error_estimate
            worst = max(worst, _over(own - better, scale, bound))
            total, allowed = sums[field]
            allowed += pair.error_estimate * value * scale
            sums[field] = total + _value(scene, name) * own, allowed
    left = [
        _over(total - getattr(rough, field)(x, 1.0), allowed, 1.0)
        for field, (total, allowed) in sums.items()
    ]
    return {"derivatives": worst, "homogeneity": max(left)}


def error_between(first: Solution, other: Solution) -> float:
    """Largest shift of a zone edge over c_t, or relative L1 difference of slip rates if larger.

    Inf if zones differ that slip at more than the estimate of the first, over the largest rate. A
    shift past what slips less than that is not counted: `Solution.error_estimate` says so.
    """
    speed = first.scene.material.shear_speed
    edges = []
    # what is open slips too
    seen = first.error_estimate * _peak(other, 0.0, first.scene.material.longitudinal_speed)
    for solution in (first, other):
        peaks = np.array([_peak(solution, zone.inner, zone.outer) for zone in solution.zones])
        certain = peaks > first.error_estimate * peaks.max(initial=0.0)
        zones = [zone for zone, kept in zip(solution.zones, certain, strict=True) if kept]
        pairs = [(zone.inner, zone.outer) for zone in zones]
        edges.append(np.array(pairs).ravel() / speed)
    if len(edges[0]) != len(edges[1]):
        return math.inf
    finite = np.isfinite(edges[1])
    between = np.linspace(edges[0][finite], edges[1][finite], 2 + _BETWEEN, axis=-1)[:, 1:-1]
    between = speed * np.maximum(between, _AT_EDGE)
    beside = np.abs([solution.slip_rate(between, 1.0) for solution in (first, other)])
    counts = (beside > seen).any(axis=(0, -1))
    shift = float(np.abs(edges[0][finite] - edges[1][finite])[counts].max(initial=0.0))
    # between edges and fronts, closer and closer towards both ends
    share = (1 - np.cos(np.pi * (np.arange(_PER_STRETCH) + 0.5) / _PER_STRETCH)) / 2
    weight = np.sin(np.pi * (np.arange(_PER_STRETCH) + 0.5) / _PER_STRETCH)
    ahead = first.scene.material.longitudinal_speed / speed
    ends = np.unique([*edges[1][finite], 0.0, first.scene.material.rayleigh_speed / speed, ahead])
    width = np.diff(ends)[:, None]
    xi = speed * (ends[:-1, None] + width * share)
    rates = [solution.slip_rate(xi, 1.0) for solution in (first, other)]
    size, change = (np.sum(width * weight * np.abs(v)) for v in (rates[1], rates[0] - rates[1]))
    return max(shift, float(change / size) if size else 0.0)


def _peak(solution: Solution, inner: float, outer: float) -> float:
    """About the largest slip rate between two velocities, at unit time."""
    outer = min(outer, solution.scene.material.longitudinal_speed)
    inside = inner + (outer - inner) * (np.arange(20) + 0.5) / 20
    return float(np.abs(solution.slip_rate(inside, 1.0)).max())


def broken_law(solution: Solution, random: Generator) -> float:
    """By how much Coulomb's law fails at random points: of traction, of slip where closed."""
    scene = solution.scene
    x = scene.material.longitudinal_speed * random.uniform(1e-3, 1.0, _POINTS)
    shear, rate = solution.shear_traction(x, 1.0), solution.slip_rate(x, 1.0)
    pressure = solution.pressure(x, 1.0)
    strength, closed = scene.coefficient * pressure, pressure > 0
    held, load = scene.superposition
    loads = (held.shear, load.shear, scene.coefficient * load.pressure)
    largest = max(float(strength.max()), *(abs(load) for load in loads))
    fastest = float(np.abs(rate).max()) or 1.0
    excess = float((np.abs(shear) - strength).max()) / largest
    return max(excess, float((-rate * np.sign(shear) * closed).max()) / fastest, 0.0)


def summary(rows: list[Row]) -> list[Row]:
    """Count outcomes, and for each quantity the checks and the errors beyond their estimates."""
    outcomes = [row["outcome"] for row in rows]
    answered = [row for row in rows if row["outcome"] == "converged"]
    counts = {
        "scenes drawn": len(rows),
        "answered": len(answered),
        "refused with a sentence": outcomes.count("refused"),
        "unresolved": outcomes.count("unresolved"),
        "raised anything else": sum(outcome.startswith("raised") for outcome in outcomes),
        "of a law that depends on slip rate": sum(row["law"] != "constant" for row in answered),
        "in antiplane shear": sum(row["mode"] == "antiplane" for row in answered),
        "where the contact opens": sum(row["opens"] for row in answered),
    }
    far = sum(not 1e-3 < row["ratio"] < 1e3 for row in answered)
    counts["base beyond 1000 times the step or below 1/1000"] = far
    lines: list[Row] = [{"what": what, "result": f"{count}"} for what, count in counts.items()]
    for name in QUANTITIES:
        ratios = np.array([row[name] for row in answered])
        ratios = ratios[~np.isnan(ratios)]
        if len(ratios):
            what = f"{name.replace('_', ' ')}: compared, beyond the estimate, largest ratio to it"
            found = f"{len(ratios)}, {int((ratios > 1).sum())}, {ratios.max():.2g}"
            lines.append({"what": what, "result": found})
    return lines


def points(quick: bool) -> list[tuple[int, int]]:
    """Return seed and number of each scene."""
    return [(SEED, index) for index in range(4 if quick else SCENES)]


STUDIES = [Study("campaign-answers", points, answer_row, summary)]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.trials.campaign", STUDIES))
