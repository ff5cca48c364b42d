"""Detect where zones are about to change, so that derivatives hold to one side only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.contact import superposed_by
from semianalytic.scene.incident import OF_FRONT
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar import tuning
from semianalytic.selfsimilar.coulomb import doubtful, excess_intensity


def border(scene: Scene, profile: Profile, name: str) -> str:
    """Return a sentence on what changes beside a solution with a parameter; "" if nothing does.

    See docs/derivatives.md, "Where the set of zones changes".
    """
    load = profile.fields.load
    slowness = load.slowness
    if name == "load_pressure" and not scene.superposition.taken_off.pressure:
        return "one-sided: a negative step of pressure would open the contact at its edge"
    opens = ("base_pressure", "load_pressure", "poisson_ratio", *OF_FRONT)
    if name in opens and load.load_pressure > 0:
        # The contact opens at the Rayleigh front first, where p* has its minimum.
        stuck = stuck_traction(profile.fields.factors.poisson_ratio, "I", slowness)
        least = stuck.at_rayleigh_front
        if abs(load.base_pressure / load.load_pressure + least) < tuning.AT_BORDER:
            return "one-sided: the contact is about to open, or to close, at the Rayleigh front"
    if (
        load.opened is not None
        and not profile.fields.zones
        and name in ("base_shear", "load_shear", *OF_FRONT)
    ):
        return "one-sided: with any shear the interface moves where it is open, and slips beside it"
    if load.frictionless:
        return ""
    # How much the base lacks of friction, in the unit of stress of the profile.
    margin = abs(float(load.friction) * load.base_pressure - abs(load.base_shear))
    moved = superposed_by(scene, name)
    if scene.arrives and name in OF_FRONT:
        moved = ("base_pressure", "base_shear")
    of_base = name == "friction" or "base_pressure" in moved or "base_shear" in moved
    if of_base and margin < tuning.AT_BORDER:
        does = "slides" if load.far_slip_rate else "sticks"
        return f"one-sided: the base is at friction, and this holds as long as it {does}"
    if not profile.edge_slips and abs(float(excess_intensity(profile))) < tuning.AT_BORDER:
        return "one-sided: the contact edge is about to slip"
    for zone, width, peak in _sizes(profile):
        if min(width, peak) < tuning.AT_BORDER:
            return f"one-sided: the zone at {zone:.6g} c_t is about to vanish"
    wrong = profile.wrong_at_nodes[..., 1:-1]
    # A nearly violated inequality at a node or between nodes.
    near = np.argwhere(doubtful(profile) & (wrong > -tuning.AT_BORDER))
    for panel, node in near:
        xi = 1 / profile.panels.at.v[panel, node + 1]
        what = "stop slipping" if profile.panels.sense[panel] else "slip"
        return f"one-sided: the interface is about to {what} at {xi:.6g} c_t"
    return ""


def starts_at_front(profile: Profile) -> bool:
    """Return whether slip begins ahead of all waves, or at the front of a base at friction."""
    zones = profile.fields.zones
    return bool(zones) and zones[0].left is None


def at_the_front(profile: Profile) -> Profile:
    """Return a profile with the base exactly at friction if it lacks so little that it does not
    matter.

    Differences do not resolve the strip that sticks behind the longitudinal front then. Derivatives
    are those of slip that starts at the front, up to the square of what is lacking.
    """
    fields = profile.fields
    zones, load = fields.zones, fields.load
    left = zones[0].left if zones else None
    strength = float(load.friction) * load.base_pressure
    lacks = strength - abs(load.base_shear)
    if left is None or not load.load_pressure or not 0 < lacks < tuning.UNSEEN_LACK * strength:
        return profile
    if left.from_a[0] > tuning.UNSEEN_STRIP or zones[0].sense * load.base_shear < 0:
        return profile
    # Put the base exactly at friction, and let the first zone begin at the front.
    load = replace(load, base_shear=float(np.copysign(strength, load.base_shear)))
    return Profile(replace(fields, load=load, zones=(replace(zones[0], left=None), *zones[1:])))


def _sizes(profile: Profile) -> list[tuple[float, float, float]]:
    """Return velocity [c_t], relative width and relative slip rate of every zone."""
    panels, layout = profile.panels, profile.panels.layout
    rate, owners = np.abs(profile.slip_rate_at_nodes), np.array(layout.zone)
    result = []
    for index, zone in enumerate(profile.fields.zones):
        here = layout.slipping & (owners == index)
        outer = 1 / (panels.left[int(np.flatnonzero(here)[0])].v[0])
        inner = 0.0 if zone.right is None else 1 / zone.right.v[0]
        # The width of a zone at the contact edge is its velocity; other widths are relative.
        width = float(outer - inner if inner == 0 else 1 - inner / outer)
        result.append((float(outer), width, float(rate[here].max() / profile.largest_rate)))
    return result
