"""Parts of the interface where the sides move along one another, and those in contact."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.results.intervals import contact_points
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.scene import Material
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.weak_friction import slip_senses


@dataclass(frozen=True)
class SlipZone:
    """Part of the interface that slips: inner * t < x < outer * t.

    Attributes
    ----------
    inner, outer : float
        Velocities of the edges [length / time]; inner 0 is the contact edge, outer inf is slip
        ahead of all waves.
    sense : int
        +1 where the upper side slips towards +x, -1 towards -x.

    Examples
    --------
    >>> from semianalytic.selfsimilar.zones.motion import SlipZone
    >>> zone = SlipZone(inner=0.0, outer=0.375, sense=1)
    >>> zone.outer * 2.0
    0.75
    """

    inner: float
    outer: float
    sense: int


@dataclass(frozen=True)
class OpenZone:
    """Part of the interface that is open: inner * t < x < outer * t.

    Attributes
    ----------
    inner, outer : float
        Velocities of the edges [length / time]; inner 0 is the contact edge.

    Examples
    --------
    >>> from semianalytic import Material, Scene, Tractions, solve
    >>> base, load = Tractions(1.0, 0.0), Tractions(-1.0, 0.5)
    >>> solution = solve(Scene(Material(1.0, 1.0, 1 / 3), 0.3, base, load))
    >>> round(solution.openings[0].outer, 6)
    0.1875
    """

    inner: float
    outer: float


def slip_zones(profile: Profile, material: Material) -> tuple[SlipZone, ...]:
    """Return zones of slip in contact [length / time], by sense if without friction."""
    fields = profile.fields
    opening = fields.load.opened.zone if fields.load.opened else None
    if fields.load.frictionless:
        parts = _by_sense(profile)
    else:
        parts = [Zone(zone.left, zone.right, zone.sense, zone.inward) for zone in fields.zones]
    if opening is not None:
        parts = [part for zone in parts for part in _in_contact(zone, opening)]
    zones = (_in_velocity(zone, profile, material) for zone in reversed(parts))
    # Parts near an opening that only rounding leaves are no zones: out of the plane nothing
    # drives slip ahead of the shear front.
    least = 0.0 if opening is None else 1e-9
    speed = material.shear_speed
    return tuple(zone for zone in zones if zone.outer - zone.inner > least * min(zone.outer, speed))


def _in_velocity(zone: Zone, profile: Profile, material: Material) -> SlipZone:
    """Return a zone in velocity [length / time], with its inner edge first."""
    load, speed = profile.fields.load, material.shear_speed
    mode = profile.fields.factors.mode
    # In antiplane shear under constant pressure nothing happens ahead of the shear front.
    sheared = mode == "III" and (load.frictionless or not load.load_pressure)
    front = speed if sheared else material.longitudinal_speed
    ahead = np.inf if load.far_slip_rate else front
    return SlipZone(
        0.0 if zone.right is None else float(speed / zone.right.v[0]),
        float(ahead if zone.left is None else speed / zone.left.v[0]),
        zone.sense,
    )


def _by_sense(profile: Profile) -> list[Zone]:
    """Return the zones of a frictionless interface, of either sense behind the first front."""
    senses, changes = slip_senses(profile)
    return [
        Zone(left, right, sense)
        for (left, right), sense in zip(pairwise((None, *changes, None)), senses, strict=False)
    ]


def _in_contact(zone: Zone, opening: Zone) -> list[Zone]:
    """Return the parts of a zone ahead of an opening and behind it."""
    start, end = opening.left, opening.right
    assert start is not None
    parts = []
    if zone.left is None or not start.first_below(zone.left):
        reaches = zone.right is None or start.first_below(zone.right)
        parts.append(Zone(zone.left, start if reaches else zone.right, zone.sense))
    if end is not None and (zone.right is None or end.first_below(zone.right)):
        reaches = zone.left is None or zone.left.first_below(end)
        parts.append(Zone(end if reaches else zone.left, zone.right, zone.last_sense))
    return parts


def motion(
    profile: Profile, zones: Sequence[SlipZone], opening: OpenZone, speed: float
) -> tuple[SlipZone, ...]:
    """Return the slip zones in contact, and the parts of an opening by sense of motion in it."""
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    points = _points_in_opening(profile)
    # At a point where V is exactly 0 there is no sense; its neighbours decide.
    rate = profile.slip_rate_at(points)
    points, sense = points[rate != 0], np.sign(rate[rate != 0]).astype(int)
    if not len(sense):  # nothing moves there
        return tuple(zones)
    outer, senses = [opening.outer], [int(sense[0])]
    for i in np.flatnonzero(sense[1:] != sense[:-1]):
        start, step = points.parts[:, [i]], points.parts[:, [i + 1]] - points.parts[:, [i]]

        # The root is sought along the chord between two points, in all distances from the fronts.
        def signed(share: float, start: Array = start, step: Array = step) -> float:
            return float(profile.slip_rate_at(CutPoints(start + share * step))[0])

        outer.append(float(speed / (start + brentq(signed, 0.0, 1.0) * step)[0, 0]))
        senses.append(int(sense[i + 1]))
    # Parts are in order of slowness, so that each ends, in velocity, where the next one begins.
    inner = [*outer[1:], opening.inner]
    parts = (SlipZone(*part) for part in zip(inner, outer, senses, strict=True))
    return tuple(sorted((*zones, *parts), key=lambda zone: zone.inner))


def _points_in_opening(profile: Profile) -> CutPoints:
    """Return points in the opening by slowness: nodes of its panels, and more near c.

    Next to powers of slip rate those that only rounding separates from an end are left out.
    """
    panels, factors = profile.panels, profile.fields.factors
    open_panels = np.flatnonzero(panels.layout.open)
    off_ends = np.ones(panels.jacobian[open_panels].shape, dtype=bool)
    if profile.rate_integral.powers:
        nearest = np.minimum(panels.from_left, panels.from_right)[open_panels]
        off_ends = nearest > tuning.OFF_ENDS * panels.at.v[open_panels]
    parts = [panels.at.parts[:, open_panels][:, off_ends]]
    if panels.layout.over_c in open_panels:
        reach = -float(panels.left[panels.layout.over_c].from_c[0])
        logs = np.log(tuning.NEAREST_TO_C), np.log(reach)
        near = np.exp(np.arange(*logs, 1 / tuning.POINTS_PER_E))
        right = panels.right[panels.layout.over_c]
        beyond = near if right is None else near[near < right.from_c[0]]
        # V has a logarithm at c where the contact is open: its sense may change very close to c.
        parts += [factors.beside("c", -near).parts, factors.beside("c", beyond).parts]
    every = np.concatenate(parts, axis=1)
    # Row 3 is the distance from c, which orders points near c that v itself cannot resolve.
    return CutPoints(every[:, np.argsort(every[3], kind="stable")])


def is_open(openings: Iterable[OpenZone], x: ArrayLike, t: ArrayLike) -> Mask:
    """Return where and when the contact is open, for positions and times that broadcast."""
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    velocity = np.divide(x, t, out=np.full(x.shape, np.inf), where=t > 0)
    parts = [(velocity > part.inner) & (velocity < part.outer) for part in openings]
    return np.logical_or.reduce([np.zeros(x.shape, dtype=bool), *parts])


def over_slowness(
    shear_speed: float, x: ArrayLike, t: ArrayLike, field: Callable[[Array], Array]
) -> Array:
    """Evaluate a field over slowness, (m,) or (k, m), at x > 0 and t; it is 0 before t = 0."""
    x, t = contact_points(x, t)
    # Fields are functions of u = t / x, here in units b = 1 / c_t = 1.
    with np.errstate(over="ignore"):
        u = np.minimum(t * shear_speed / x, np.finfo(float).max).ravel()
    value = np.where(u >= 0, field(np.maximum(u, 0.0)), 0.0)
    return value.reshape((*value.shape[:-1], *x.shape))
