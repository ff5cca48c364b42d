"""Where solved zones break the law of contact: at closely spaced points, a tenth of x apart.

On stick |tau| <= f p; where it slips V keeps its sense, and on both p >= 0; where it is open the
gap is not negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from semianalytic.dissimilar_slot.profile import GAP, NORMAL, RATE, SHEAR, Part, Profile
from semianalytic.halfplane.rayleigh import Array

Kind = Literal["excess", "pull", "reversed", "overlap"]


@dataclass(frozen=True)
class Violation:
    """An interval of slowness where the law fails.

    Attributes
    ----------
    kind : str
        "excess": shear traction beyond friction on stick; "reversed": slip against its sense;
        "pull": tension where it slips; "overlap": negative gap.
    zone : int
        Index of the zone, -1 on stick.
    sense : int
        Of the traction or the slip rate there.
    left : float
    right : float or None
        None: up to the contact edge.
    """

    kind: Kind
    zone: int
    sense: int
    left: float
    right: float | None


def largest_breach(profile: Profile, slowest: float) -> float:
    """How far the law is broken anywhere, over the scale of each quantity; 0 where it is kept.

    Places slower than the slowest wave by more than a factor of `slowest` are left out.
    """
    breaches = [np.zeros(1)]
    for part in profile.parts:
        breaches += [
            breach for _, breach, _ in _breaches(profile, part, *_points(profile, part, slowest))
        ]
    return max(float(breach.max()) for breach in breaches)


def violations(profile: Profile, tolerance: float, slowest: float) -> list[Violation]:
    """Where the law fails by more than a tolerance, as `largest_breach` measures it."""
    found: list[Violation] = []
    for part in profile.parts:
        v, values = _points(profile, part, slowest)
        for kind, breach, sense in _breaches(profile, part, v, values):
            found += _intervals(part, v, breach > tolerance, (kind, sense))
    return _merged(found)


def _points(profile: Profile, part: Part, slowest: float) -> tuple[Array, Array]:
    """Slownesses of the sampled points of a part, and the functions there."""
    intervals = part.series.intervals
    points = intervals.points
    used = points.v < slowest * profile.density.interface.compliance.last
    return points.v[used], part.at(points.x[used], points.v[used])


def _breaches(
    profile: Profile, part: Part, v: Array, values: Array
) -> list[tuple[Kind, Array, Array]]:
    """What may be broken on a part: kind, by how much over its scale, and in which sense."""
    interface, zones = profile.density.interface, profile.density.zones
    shear = interface.base_shear + values[SHEAR]
    pressure = interface.base_pressure - values[NORMAL]
    frictional = interface.friction * pressure
    scale = np.abs(shear) + np.abs(frictional) + interface.friction * interface.base_pressure
    if part.zone < 0:  # where the contact would pull no friction is left: it slips first
        return [("excess", (np.abs(shear) - np.maximum(frictional, 0.0)) / scale, np.sign(shear))]
    zone = zones[part.zone]
    if zone.open:
        return [("overlap", -values[GAP] / v / profile.largest_gap, shear)]
    against = -zone.sense * values[RATE] / profile.largest_rate
    pull = -pressure / (np.abs(values[NORMAL]) + interface.base_pressure)
    return [
        ("reversed", against, np.sign(values[RATE])),
        ("pull", pull, np.full(v.shape, zone.sense)),
    ]


def _intervals(
    part: Part, v: Array, wrong: np.ndarray, what: tuple[Kind, Array]
) -> list[Violation]:
    """Runs of wrong points, from the last point that is right to the next one that is."""
    kind, sense = what
    bounds = np.flatnonzero(np.diff(wrong.astype(int), prepend=0, append=0))
    stretch, result = part.stretch, []
    for start, stop in zip(bounds[::2], bounds[1::2], strict=True):
        left = float(v[start - 1]) if start else stretch.left
        right = float(v[stop]) if stop < len(v) else stretch.right
        middle = int(np.sign(sense[start:stop].sum())) or 1
        result.append(Violation(kind, part.zone, middle, left, right))
    return result


def _merged(found: list[Violation]) -> list[Violation]:
    """Violations of one kind and sense that touch across a wave front, as one."""
    result: list[Violation] = []
    for one in sorted(found, key=lambda one: (one.kind, one.left)):
        last = result[-1] if result else None
        alike = last is not None and (last.kind, last.zone, last.sense) == (
            one.kind,
            one.zone,
            one.sense,
        )
        if last is not None and alike and last.right == one.left:
            result[-1] = Violation(one.kind, one.zone, one.sense, last.left, one.right)
        else:
            result.append(one)
    return sorted(result, key=lambda one: one.left)
