"""Which zones to try next where solved ones break the law of contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from semianalytic.dissimilar_slot.admissible import BrokenLaw
from semianalytic.dissimilar_slot.densities.zones import (
    MovingZone,
    edges_of,
    joined,
    moved,
    neighbours,
)
from semianalytic.dissimilar_slot.placement import PlacedZones

_AT_FRONT, _BEYOND_FRONT = 1e-4, 0.1
"""Relative distance of an edge that ran into a front; where it restarts in the next segment."""
_MET = 1e-3
"""Relative width below which Newton's method is taken to have closed a stick gap or a zone."""
_PARTED = 1e-3
"""Half the relative width of the stick zone that is put between slip of opposite senses."""


def corrected(
    zones: Sequence[MovingZone], violations: Sequence[BrokenLaw]
) -> tuple[MovingZone, ...]:
    """Return the zones with one kind of violation corrected.

    Slip against its sense and negative gaps are removed first.  If there are none, the widest
    interval in tension is opened.  If there is none either, slip is added where the shear traction
    exceeds friction.
    """
    wrong = [violation for violation in violations if violation.kind in ("reversed", "overlap")]
    pulled = [violation for violation in violations if violation.kind == "pull"]
    result = list(zones)
    if wrong:
        # From the slowest on, so that the numbers of the zones ahead stay what they are.
        for violation in sorted(wrong, key=lambda broken: -broken.left):
            _cut(result, violation)
    elif pulled:
        # One opening changes the pressure everywhere: the others may be gone after it.
        widest = max(pulled, key=_extent)
        _open(result, widest)
    else:
        for violation in sorted(violations, key=lambda violation: -violation.left):
            _slip(result, violation)
    return _tidy(result)


def _tidy(zones: Sequence[MovingZone]) -> tuple[MovingZone, ...]:
    """Merge adjoining slip zones of one sense, and put stick between those of opposite senses."""
    result: list[MovingZone] = []
    for zone in zones:
        last = result[-1] if result else None
        if last is None or zone.open or last.open or not joined(last, zone):
            result.append(zone)
        elif last.sense == zone.sense:
            result[-1] = replace(last, right=zone.right)
        else:
            # Slip cannot jump from one sense to the other; Newton's method finds how long it
            # sticks.
            result[-1] = replace(last, right=zone.left * (1 - _PARTED))
            result.append(replace(zone, left=zone.left * (1 + _PARTED)))
    return tuple(result)


def _extent(broken: BrokenLaw) -> float:
    """Return the ratio of the ends of an interval; it is infinite up to the contact edge."""
    return float("inf") if broken.right is None else broken.right / max(broken.left, 1e-300)


def _at(edge: float | None, other: float | None) -> bool:
    """Tell whether two slownesses are the same edge."""
    if edge is None or other is None:
        return edge is other
    return abs(edge - other) < 1e-6 * other


def _cut(zones: list[MovingZone], wrong: BrokenLaw) -> None:
    """Remove an interval from its zone, or reverse slip that adjoins an opening."""
    index = wrong.zone
    zone = zones[index]
    from_left, to_right = _at(wrong.left, zone.left), _at(wrong.right, zone.right)
    before = index > 0 and joined(zones[index - 1], zone)
    after = index + 1 < len(zones) and joined(zone, zones[index + 1])
    if not zone.open and from_left and to_right and (before or after):
        zones[index] = replace(zone, sense=-zone.sense)
        if after and zones[index + 1].open:
            zones[index + 1] = replace(zones[index + 1], sense=-zone.sense)
    elif from_left and to_right:
        del zones[index]
    elif from_left and wrong.right is not None and not before:
        zones[index] = replace(zone, left=wrong.right)
    elif to_right and not after and zone.right is not None:
        zones[index] = replace(zone, right=wrong.left)
    elif zone.open:
        _close(zones, index, wrong)
    else:
        inner = [] if wrong.right is None else [replace(zone, left=wrong.right)]
        zones[index : index + 1] = [replace(zone, right=wrong.left), *inner]


def _close(zones: list[MovingZone], index: int, overlap: BrokenLaw) -> None:
    """Replace an interval of negative gap by slip."""
    zone = zones[index]
    slip = MovingZone(overlap.left, overlap.right, zone.sense)
    parts = [slip]
    if not _at(overlap.left, zone.left):
        parts.insert(0, replace(zone, right=overlap.left))
    elif index > 0 and joined(zones[index - 1], zone):
        zones[index - 1] = replace(zones[index - 1], right=overlap.right)
        parts = []
    if overlap.right is not None and not _at(overlap.right, zone.right):
        parts.append(replace(zone, left=overlap.right))
    zones[index : index + 1] = parts


def _open(zones: list[MovingZone], pull: BrokenLaw) -> None:
    """Open an interval of slip."""
    zone = zones[pull.zone]
    parts = [MovingZone(pull.left, pull.right, zone.sense, True)]
    if not _at(pull.left, zone.left):
        parts.insert(0, replace(zone, right=pull.left))
    if pull.right is not None:
        parts.append(replace(zone, left=pull.right))
    zones[pull.zone : pull.zone + 1] = parts


def _slip(zones: list[MovingZone], excess: BrokenLaw) -> None:
    """Add slip where the shear traction exceeds friction, to an adjoining zone of that sense or
    new.
    """
    for index, zone in enumerate(zones):
        if zone.open or zone.sense != excess.sense:
            continue
        if _at(excess.right, zone.left):
            zones[index] = replace(zone, left=excess.left)
            return
        if zone.right is not None and _at(excess.left, zone.right):
            zones[index] = replace(zone, right=excess.right)
            return
    place = sum(zone.left < excess.left for zone in zones)
    zones.insert(place, MovingZone(excess.left, excess.right, excess.sense))


def rearranged(placement: PlacedZones) -> tuple[MovingZone, ...] | None:
    """Return zones to try after Newton's method failed to place the edges; None if there are none.

    Edges at a front restart beyond it, zones of one sense that met are one, vanished ones go.
    """
    zones = placement.zones
    crossed = _across_fronts(placement)
    if crossed is not None:
        return crossed
    gaps = [
        (other.left / zone.right - 1, index)
        for index, (zone, other) in enumerate(pairwise(zones))
        if zone.right is not None and zone.sense == other.sense and not (zone.open or other.open)
    ]
    # Stick that shrinks to nothing is what two zones leave that ought to be one.
    if gaps and min(gaps)[0] < _MET:
        index = min(gaps)[1]
        merged = replace(zones[index], right=zones[index + 1].right)
        return (*zones[:index], merged, *zones[index + 2 :])
    for index, (before, zone, after) in enumerate(neighbours(zones)):
        alone = before is None and after is None
        if alone and zone.right is not None and zone.right / zone.left - 1 < _MET:
            return (*zones[:index], *zones[index + 1 :])
    return None


def _across_fronts(placement: PlacedZones) -> tuple[MovingZone, ...] | None:
    """Move each edge that ran into a wave front to the other side of it; None if no edge did."""
    edges = edges_of(placement.zones)
    ends: list[float | None] = [0.0, *placement.density.interface.compliance.distinct_fronts, None]
    result, crosses = list(edges), False
    segments = placement.coordinates.segments
    for index, (edge, (left, right)) in enumerate(zip(edges, segments, strict=True)):
        if right is not None and right - edge < _AT_FRONT * right:
            beyond = ends[ends.index(right) + 1]
            width = right if beyond is None else beyond - right
            result[index], crosses = right + _BEYOND_FRONT * width, True
        elif left > 0 and edge - left < _AT_FRONT * left:
            ahead = ends[ends.index(left) - 1] or 0.0
            result[index], crosses = left - _BEYOND_FRONT * (left - ahead), True
    # An edge must not jump over its neighbour on the way.
    kept = all(edge < other for edge, other in pairwise(result))
    return moved(placement.zones, result) if crosses and kept else None
