"""Check solved zones against the law of contact, at points about a tenth of x apart.

Where the interface sticks, |tau| <= f p.  Where it slips, V keeps its sense.  In both cases p >= 0.
Where the contact is open, the gap is not negative.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from semianalytic.dissimilar_slot.densities.profile import (
    GAP,
    NORMAL,
    RATE,
    SHEAR,
    PairProfile,
    ProfilePart,
)
from semianalytic.scene.arrays import Array

Kind = Literal["excess", "pull", "reversed", "overlap"]


@dataclass(frozen=True)
class BrokenLaw:
    """An interval of slowness where the law fails."""

    # "excess": shear traction beyond friction on stick; "reversed": slip against its sense; "pull":
    # tension where it slips; "overlap": negative gap
    kind: Kind
    zone: int  # index of the zone, -1 on stick
    sense: int  # sign of the shear traction or of the slip rate there
    left: float
    right: float | None  # None: up to the contact edge


def largest_breach(profile: PairProfile, slowest: float) -> float:
    """Return the largest violation of the law, over the scale of each quantity; 0 if there is none.

    Points of a larger slowness than `slowest` are left out.
    """
    return max(float(breach.max(initial=0.0)) for *_, breach, _ in _breaches(profile, slowest))


def violations(profile: PairProfile, tolerance: float, slowest: float) -> list[BrokenLaw]:
    """Return the intervals where the law fails by more than a tolerance, as in `largest_breach`."""
    found: list[BrokenLaw] = []
    for part, v, kind, breach, sense in _breaches(profile, slowest):
        found += _intervals(part, v, breach > tolerance, (kind, sense))
    return _merged(found)


def _breaches(
    profile: PairProfile, slowest: float
) -> Iterator[tuple[ProfilePart, Array, Kind, Array, Array]]:
    """Yield conditions: part, slownesses of its points, kind, violation over its scale (> 0 where
    the law fails), sense."""
    interface, zones = profile.density.interface, profile.density.zones
    for part in profile.parts:
        every = part.series.intervals.points.v
        v, values = every[every < slowest], part.values[:, every < slowest]
        shear = interface.base_shear + values[SHEAR]
        pressure = interface.base_pressure - values[NORMAL]
        frictional = interface.friction * pressure
        # With f P_b in it the scale cannot vanish where both tractions do.
        scale = np.abs(shear) + np.abs(frictional) + interface.friction * interface.base_pressure
        if part.zone < 0:  # friction is 0 in tension, so that slip is the first failure
            excess = (np.abs(shear) - np.maximum(frictional, 0.0)) / scale
            yield part, v, "excess", excess, np.sign(shear)
        elif zones[part.zone].open:
            yield part, v, "overlap", -values[GAP] / v / profile.largest_gap, shear
        else:
            sense = zones[part.zone].sense
            against = -sense * values[RATE] / profile.largest_rate
            yield part, v, "reversed", against, np.sign(values[RATE])
            pull = -pressure / (np.abs(values[NORMAL]) + interface.base_pressure)
            yield part, v, "pull", pull, np.full(v.shape, sense)


def _intervals(
    part: ProfilePart, v: Array, wrong: np.ndarray, what: tuple[Kind, Array]
) -> list[BrokenLaw]:
    """Return runs of wrong points, each from the last right point before it to the next one."""
    kind, sense = what
    bounds = np.flatnonzero(np.diff(wrong.astype(int), prepend=0, append=0))
    stretch, result = part.stretch, []
    for start, stop in zip(bounds[::2], bounds[1::2], strict=True):
        # The law changes from right to wrong between two points: the interval takes in both.
        left = float(v[start - 1]) if start else stretch.left
        right = float(v[stop]) if stop < len(v) else stretch.right
        # Shear may change its sign within the interval; a new zone needs one sense.
        middle = int(np.sign(sense[start:stop].sum())) or 1
        result.append(BrokenLaw(kind, part.zone, middle, left, right))
    return result


def _merged(found: list[BrokenLaw]) -> list[BrokenLaw]:
    """Join violations of the same kind and sense that meet at a wave front."""
    result: list[BrokenLaw] = []
    for broken in sorted(found, key=lambda broken: (broken.kind, broken.left)):
        last, alike = (
            result[-1] if result else None,
            (broken.kind, broken.zone, broken.sense, broken.left),
        )
        if last is not None and (last.kind, last.zone, last.sense, last.right) == alike:
            result[-1] = replace(last, right=broken.right)
        else:
            result.append(broken)
    return sorted(result, key=lambda violation: violation.left)
