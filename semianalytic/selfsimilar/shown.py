"""Zones of a self-similar solution in words and as a table.

Numbers have as many digits as distinguish the edges.
"""

from __future__ import annotations

from collections.abc import Iterable

from semianalytic.results.in_words import digits_apart, html_table
from semianalytic.scene.scene import Scene
from semianalytic.scene.units import unit
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone


def slips_said(zones: Iterable[SlipZone], openings: Iterable[OpenZone] = ()) -> str:
    """Return where the contact slips and which way, or "no slip", and where it is open."""
    zones, openings = tuple(zones), tuple(openings)
    parts: list[SlipZone | OpenZone] = [*zones, *openings]
    digits = digits_apart((end for part in parts for end in (part.inner, part.outer)), 4)

    def place(part: SlipZone | OpenZone) -> str:
        return f"{part.inner:.{digits}g} < x/t < {part.outer:.{digits}g}"

    slips = ", ".join(f"{place(zone)} ({zone.sense:+d})" for zone in zones)
    opens = ", ".join(map(place, openings))
    said = f"slip at {slips}" if slips else "no slip"
    return f"{said}, open at {opens}" if opens else said


def zones_table(
    scene: Scene, zones: Iterable[SlipZone], openings: Iterable[OpenZone], caption: str
) -> str:
    """Return slip zones and open parts as HTML, from the contact edge outward."""
    speed = scene.material.shear_speed
    parts = [(zone.inner, zone.outer, f"slip {zone.sense:+d}") for zone in zones]
    parts += [(zone.inner, zone.outer, "open") for zone in openings]
    ends = [end for *both, _ in parts for end in both]
    digits, places = digits_apart(ends, 6), digits_apart([end / speed for end in ends], 6)
    rows = [
        (
            kind,
            *(f"{end:.{digits}g}" for end in (inner, outer)),
            *(f"{end / speed:.{places}g}" for end in (inner, outer)),
        )
        for inner, outer, kind in sorted(parts)
    ]
    per = unit("length / time", scene.units)
    columns = ("zone", f"from [{per}]", f"to [{per}]", "from / c_t", "to / c_t")
    moves = "" if rows else "no slip; "
    return html_table(f"Solution: {moves}{caption}", columns, rows)
