"""Answers in words next to the pictures: where the interface slips, and the scales of the axes."""

from __future__ import annotations

from typing import Any

from compare.comparison.scales import reference_values
from semianalytic import Scene
from semianalytic.results.in_words import digits_apart, kind_of_slip, number_or_infinity
from semianalytic.scene.units import unit
from slipfront.explore.views import end_time


def readings(answer: Any) -> list[list[str]]:
    """Return further results of an answer, each with name and value."""
    scene = answer.scene
    if answer.method == "space-time":
        slip = float(answer.max_slip(answer.end_time))
        return [["largest slip", f"{slip:.4g} {unit('length', scene.units)}"]]
    speed = scene.material.shear_speed
    parts = [
        (kind_of_slip(zone.sense), zone.inner / speed, zone.outer / speed) for zone in answer.zones
    ]
    parts += [("open", opening.inner / speed, opening.outer / speed) for opening in answer.openings]
    digits = digits_apart((end for _, *ends in parts for end in ends), 5)
    rows = [
        [kind, f"{inner:.{digits}g} … {number_or_infinity(outer, digits)} c_t"]
        for kind, inner, outer in sorted(parts, key=lambda part: part[1])
    ]
    return rows or [["interface", "sticks everywhere"]]


def scales(scene: Scene) -> list[list[str]]:
    """Return the scales of the axes: symbol, value with its unit."""
    time = end_time(scene)
    named = reference_values(scene, time)
    named["c_t T"] = (scene.material.shear_speed * time, unit("length", scene.units))
    shown = {symbol: named[symbol] for symbol in ("c_t T", "T", "τ₀", "V₀")}
    return [[symbol, f"{value:.4g} {name}"] for symbol, (value, name) in shown.items()]
