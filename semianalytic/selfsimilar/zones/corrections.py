"""Propose the next set of zones where Newton's method failed or Coulomb's law does not hold.

Zones are in slowness, from the longitudinal front inward.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.coulomb import Violation


def rearranged(
    factors: RayleighFactors, zones: Sequence[Zone], load: Load, may_turn: bool = True
) -> list[Zone] | None:
    """Return other zones where Newton's method did not place the edges; None if there are none.

    If `may_turn`, slip ahead of an opening may be tried in the other sense. The caller allows this
    once, so that the sense does not alternate.
    """
    opening = load.opened.zone if load.opened else None
    # The order matters: the mildest change that applies is tried first.
    other = _across_shear_front(factors, zones, opening)
    if other is None:
        other = _without_vanished(zones)
    if other is None:
        other = _joined(zones, load)
    if other is None and opening is not None:
        other = _turned_at_opening(zones, opening, may_turn)
    return other


def _across_shear_front(
    factors: RayleighFactors, zones: Sequence[Zone], opening: Zone | None
) -> list[Zone] | None:
    """Return the zones with edges that ran into the shear front beyond it; None if none did.

    They keep short of the Rayleigh front (1/2 c_t in antiplane shear) and of an opening behind.
    """
    segment = factors.c - 1 if factors.has_rayleigh_wave else 1.0
    if opening is not None and opening.left is not None and opening.left.from_b[0] > 0:
        segment = min(segment, float(opening.left.from_b[0]))
    # Shares of the segments there; half and twice lead to the same answers.
    behind = 1 + 0.1 * segment
    ahead = 1 - 0.02 * (1 - factors.a)

    def started(edge: CutPoints | None) -> CutPoints | None:
        if edge is None or abs(edge.from_b[0]) >= 1e-4:  # it did not run into the shear front
            return edge
        return factors.cut([ahead if edge.from_b[0] > 0 else behind])

    others = []
    for zone in zones:
        left, right = started(zone.left), started(zone.right)
        # with both ends at the front a zone has vanished rather than crossed it
        crossed = left is None or right is None or left.first_below(right)
        others.append(replace(zone, left=left, right=right) if crossed else zone)
    moved = any(
        zone.left is not other.left or zone.right is not other.right
        for zone, other in zip(zones, others, strict=True)
    )
    return others if moved else None


def _turned_at_opening(zones: Sequence[Zone], opening: Zone, may_turn: bool) -> list[Zone] | None:
    """Return zones with the one around the opening ended or turned there, or None."""
    result = list(zones)
    for index, zone in enumerate(zones):
        if not _holds(zone, opening):
            continue
        closing, ahead = opening.right, opening.left
        if not zone.held and _near(closing, zone.right):
            result[index] = replace(zone, right=closing, inward=0, held=True)
            return result
        if may_turn and _near(zone.left, ahead):
            result[index] = replace(zone, sense=-zone.sense, inward=zone.last_sense)
            return result
    return None


def _near(outward: CutPoints | None, inward: CutPoints | None) -> bool:
    """Return whether one point lies slightly inward of another."""
    if outward is None or inward is None:
        return False
    return bool(inward.minus(outward)[0] < tuning.NEAR_OPENING * outward.v[0])


def _holds(zone: Zone, opening: Zone) -> bool:
    """Return whether an opening lies in a zone."""
    assert opening.left is not None
    starts = zone.left is None or not opening.left.first_below(zone.left)
    return starts and (zone.right is None or opening.left.first_below(zone.right))


def _without_vanished(zones: Sequence[Zone]) -> list[Zone] | None:
    """Return zones without nearly closed ones, to whose place held slip goes on; None if none."""
    kept: list[Zone] = []
    for zone in zones:
        left, right = zone.left, zone.right
        # Newton's method has not closed it.
        if left is None or right is None or right.minus(left)[0] > 1e-4 * left.v[0]:
            kept.append(zone)
        elif kept and kept[-1].held:
            kept[-1] = replace(kept[-1], right=left, inward=zone.sense, held=False)
    return None if len(kept) == len(zones) else kept


def _joined(zones: Sequence[Zone], load: Load) -> list[Zone] | None:
    """Return the zones with those at the narrowest stick gap joined, or None.

    A gap around c stays open, where V has a logarithm, unless slip meets resistance.
    """
    gaps = {}
    for i, (outer, inner) in enumerate(pairwise(zones)):
        if outer.last_sense == inner.sense and outer.right is not None and inner.left is not None:
            off_c = bool(outer.right.from_c[0] * inner.left.from_c[0] > 0)
            may_close = off_c or load.resistance is not None
            width = float(inner.left.minus(outer.right)[0] / outer.right.v[0])
            if may_close and width < 0.1:  # zones may have met
                gaps[i] = width
    if not gaps:
        return None
    i = min(gaps, key=lambda i: gaps[i])
    return [*zones[:i], replace(zones[i], right=zones[i + 1].right), *zones[i + 2 :]]


def corrected(zones: Sequence[Zone], violations: list[Violation], load: Load) -> list[Zone]:
    """Return zones without wrong slip, and with missing slip: new ones if the present are sound."""
    if load.opened is not None:
        return _corrected_beside(load.opened.zone, zones, violations, load)
    wrong_slip = [violation for violation in violations if violation.zone >= 0]
    missing_slip = [violation for violation in violations if violation.zone < 0]
    kept = _without_wrong_slip(zones, wrong_slip)
    return _with_missing_slip(kept, missing_slip, load, sound=not wrong_slip)


def _corrected_beside(
    opening: Zone, zones: Sequence[Zone], violations: list[Violation], load: Load
) -> list[Zone]:
    """Return corrected zones where the contact is open, treating its closed parts as zones."""
    parts: list[Zone] = []
    # Index in `parts` of the first part of each zone.
    first = {}
    for index, zone in enumerate(zones):
        first[index] = len(parts)
        parts += _closed_parts(zone, opening) if _holds(zone, opening) else [zone]
    moved = [replace(v, zone=_part_of(v, parts, first.get(v.zone, -1))) for v in violations]
    closed = corrected(parts, moved, replace(load, opened=None))
    return _joined_across(closed, opening)


def _closed_parts(zone: Zone, opening: Zone) -> list[Zone]:
    """Return the closed parts of a zone ahead of an opening and behind it."""
    parts = [replace(zone, right=opening.left, inward=0, held=False)]
    if opening.right is not None and not zone.held:
        parts.append(Zone(opening.right, zone.right, zone.last_sense))
    return parts


def _part_of(violation: Violation, parts: list[Zone], first: int) -> int:
    """Return the closed part that contains a violation of a zone; -1 for a violation in stick."""
    if first < 0:
        return -1
    right = parts[first].right
    if right is None or first + 1 == len(parts) or violation.left.first_below(right):
        return first
    return first + 1


def _joined_across(parts: list[Zone], opening: Zone) -> list[Zone]:
    """Return zones from closed parts, joining those that reach the opening from either side."""
    ahead, closing = opening.left, opening.right
    assert ahead is not None
    before = [part for part in parts if part.left is None or part.left.first_below(ahead)]
    behind = [part for part in parts[len(before) :]]
    last = before[-1] if before else None
    if last is not None and last.right is not None and last.right.first_below(ahead):
        last = None
    # Slip always extends further than the opening at its outer edge, because the strength falls to
    # zero there and the traction does not. If no part reaches the opening, a narrow zone is added.
    if last is None:
        sense = -before[-1].sense if before else (behind[0].sense if behind else 1)
        start = ahead.parts - tuning.NEAR_OPENING / 2 * ahead.v
        if before and before[-1].right is not None:
            start = np.maximum(start, (before[-1].right.parts + ahead.parts) / 2)
        before.append(Zone(CutPoints(start), ahead, sense))
    held = before.pop()
    if closing is None or held.right is None or closing.first_below(held.right):
        return [*before, replace(held, right=held.right if closing is not None else None), *behind]
    if behind and _begins_at(closing, behind[0]):
        joined = replace(held, right=behind[0].right, inward=behind[0].sense)
        return [*before, joined, *behind[1:]]
    return [*before, replace(held, right=closing, held=True), *behind]


def _begins_at(closing: CutPoints, behind: Zone) -> bool:
    """Return whether slip behind an opening begins where it closes, or, by nodes, just behind."""
    if behind.left is None:
        return False
    # On loose rules slip began up to 0.003 of its width behind the closing.
    least = 1e-6 * float(closing.v[0])
    if behind.right is not None:
        least = max(least, 0.05 * float(behind.right.minus(behind.left)[0]))
    return bool(behind.left.minus(closing)[0] < least)


def _without_wrong_slip(zones: Sequence[Zone], violations: list[Violation]) -> list[Zone]:
    """Return zones cut where they slip against their sense: at one end, or in two."""
    result = list(zones)
    # From the contact edge outward, so that the indices of zones still to be cut stay valid.
    for broken in reversed(sorted(violations, key=lambda violation: float(violation.left.v[0]))):
        zone = result[broken.zone]
        to_end = broken.touches_right or _reaches(broken.right, zone.right)
        from_start = broken.touches_left or _reaches(zone.left, broken.left)
        if from_start and broken.right is None:
            # The violation covers all of a zone at the contact edge.
            del result[broken.zone]
        elif from_start:
            result[broken.zone] = replace(zone, left=broken.right)
        elif to_end and zone.right is not None:
            result[broken.zone] = replace(zone, right=broken.left)
        else:
            inner = [] if broken.right is None else [replace(zone, left=broken.right)]
            result[broken.zone : broken.zone + 1] = [replace(zone, right=broken.left), *inner]
    return result


def _reaches(outward: CutPoints | None, inward: CutPoints | None) -> bool:
    """Return whether a point comes up to another; between nodes rounding decides."""
    return outward is not None and inward is not None and not outward.first_below(inward)


def _with_missing_slip(
    zones: list[Zone], violations: list[Violation], load: Load, sound: bool
) -> list[Zone]:
    """Return zones widened where traction exceeds friction near them, and new ones if sound.

    Under a critical base the first starts at the longitudinal front if it slips along the base.
    """
    result = list(zones)
    for broken in violations:
        # Index of the first zone inward of the violation.
        after = sum(zone.left is None or bool(zone.left.v < broken.left.v) for zone in result)
        if broken.touches_right and after < len(result) and result[after].sense == broken.sense:
            result[after] = replace(result[after], left=broken.left)
        elif broken.touches_left and after > 0 and result[after - 1].sense == broken.sense:
            result[after - 1] = replace(result[after - 1], right=broken.right)
        elif sound:
            at_front = after == 0 and load.critical and broken.sense * load.base_shear > 0
            left = None if at_front else broken.left
            result.insert(after, Zone(left, broken.right, broken.sense))
    return result
