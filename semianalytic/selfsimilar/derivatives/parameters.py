"""Parameters with respect to which solutions are differentiated: their values, what each changes.

Also where zones are about to change with one, so that derivatives hold to one side only.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.cut.rates import Rates
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.parameters.numbers import numbers_of
from semianalytic.scene.checks import checked_word
from semianalytic.scene.contact import superposed_by
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import OF_FRONT, IncidentWave, MovingLoad
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.coulomb import doubtful, excess_intensity

PARAMETERS = (
    "friction",
    "poisson_ratio",
    "base_pressure",
    "base_shear",
    "load_pressure",
    "load_shear",
    "viscosity",
    *OF_FRONT,
)
"""Parameters of a scene with respect to which there are derivatives."""


def parameter(scene: Scene, name: str) -> float:
    """Return the value of a number of a scene; 0 for one that it does not have, as viscosity."""
    known = numbers_of(scene)
    if name in known:
        return known[name].value
    if name in ("load_pressure", "load_shear"):  # tractions that a wave brings
        brought = scene.load.tractions(scene.material)
        return float(getattr(brought, name.removeprefix("load_")))
    return 0.0


def changes(scene: Scene, profile: Profile, stress: float, name: str) -> Rates:
    """Return the change of the load with a parameter, and refuse what has no derivative.

    For a base at friction it is that on the side on which the base sticks.
    """
    load = profile.fields.load
    checked_word("derivative: name", name, PARAMETERS)
    if load.linearised is not None:
        raise SceneError(
            "derivative: it exists for constant and viscous friction only; difference two "
            "solutions (docs/limits.md)."
        )
    if name == "friction" and scene.coefficient == 0:
        raise SceneError(
            "derivative: without friction the sense of slip is free, and friction of any size "
            "opens stick gaps; take a small positive friction."
        )
    if name in ("base_pressure", "load_pressure") and load.frictionless and scene.coefficient:
        raise SceneError(
            "derivative: without pressure the sense of slip is free, and friction under any "
            "pressure opens stick gaps; take a small positive base pressure."
        )
    if name == "viscosity" and load.resistance is None:
        raise SceneError(
            "derivative: with respect to viscosity the scene needs friction with a viscosity."
        )
    if name == "viscosity":
        rates = Rates(resistance=2 / scene.material.shear_impedance)
    elif (of_front := _of_front(scene, stress, name)) is not None:
        rates = of_front
    else:
        plain = name in ("friction", "poisson_ratio")
        moved = (name,) if plain else superposed_by(scene, name)
        rates = Rates(**dict.fromkeys(moved, 1.0 if plain else 1 / stress))
    free = load.frictionless and not load.far_slip_rate
    if free or not starts_at_front(profile):
        return rates
    if rates.slowness:
        raise SceneError(
            "derivative: the base is at friction under the wave, where this derivative is not "
            "known; difference two solutions (docs/limits.md)."
        )
    sense, far = profile.fields.zones[0].sense, load.far_slip_rate
    strength = rates.friction * load.base_pressure + load.friction * rates.base_pressure
    # How fast the base moves relative to the friction limit.
    excess = float(rates.base_shear - sense * strength - rates.resistance * far)
    # Slip far ahead balances it: excess = (1 + eta) dV(inf) in units of rho c_t.
    if far:
        return replace(rates, far_slip_rate=float(excess / (1 + (load.resistance or 0.0))))
    if excess and profile.fields.factors.mode == "III" and not load.load_pressure:
        raise SceneError(
            "derivative: the base is at friction, and in antiplane shear the derivative is "
            "infinite at the shear front; lower the base shear a little (docs/limits.md)."
        )
    return replace(rates, front_excess=excess)


def _of_front(scene: Scene, stress: float, name: str) -> Rates | None:
    """Return the change of a wave or moving load, None if it stays; refuse what it has not."""
    load, material = scene.load, scene.material
    if isinstance(load, IncidentWave):
        own = "wave_stress" if load.velocity is None else "wave_velocity"
        if name in ("load_pressure", "load_shear", *OF_FRONT) and name not in ("angle", own):
            raise SceneError(
                f"derivative: the load is an incident wave, with angle and {own}; ask for one of "
                "these."
            )
        if name not in ("angle", own, "poisson_ratio"):
            return None
        slope, slowness = load.derivatives(material, name)
        pressure, shear = slope.pressure / stress, slope.shear / stress
        # of the coefficient, tractions of base and load, far slip, film, ratio and slowness
        moved = 0.0, pressure, shear, pressure, shear, 0.0, 0.0, float(name == "poisson_ratio")
        return Rates(*moved, slowness * material.shear_speed)
    if name in OF_FRONT and not (isinstance(load, MovingLoad) and name == "load_speed"):
        raise SceneError(f"derivative: the load of the scene has no {name}.")
    if name == "load_speed":
        assert isinstance(load, MovingLoad)
        return Rates(slowness=material.shear_speed / load.speed**2)
    return None


def border(scene: Scene, profile: Profile, name: str) -> str:
    """Return what changes next to a solution with a parameter, or ""."""
    load = profile.fields.load
    if name == "load_pressure" and not scene.superposition.taken_off.pressure:
        return "one-sided: a negative step of pressure would open the contact at its edge"
    opens = ("base_pressure", "load_pressure", "poisson_ratio", *OF_FRONT)
    if name in opens and load.load_pressure > 0:
        # The contact opens at the Rayleigh front first, where p* has its minimum.
        stuck = stuck_traction(profile.fields.factors.poisson_ratio, "I", load.slowness)
        least = stuck.at_rayleigh_front
        if abs(load.base_pressure / load.load_pressure + least) < tuning.AT_BORDER:
            return "one-sided: the contact is about to open, or to close, at the Rayleigh front"
    of_shear = name in ("base_shear", "load_shear", *OF_FRONT)
    if of_shear and load.opened is not None and not profile.fields.zones:
        return "one-sided: with any shear the open part moves and slip goes on next to it"
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
    """Return a profile with the base exactly at friction if it lacks so little that none matters.

    Differences do not resolve the strip that sticks behind the longitudinal front then; derivatives
    are those of slip from the front, up to the square of what is lacking.
    """
    fields = profile.fields
    zones, load = fields.zones, fields.load
    left = zones[0].left if zones else None
    strength = float(load.friction) * load.base_pressure
    lacks = strength - abs(load.base_shear)
    # Derivatives of such a base differ from those of one at friction by 1e-6 of themselves at most;
    # differences are off by 1e-5 below 1e-6, and by their own size below 1e-11.
    if left is None or not load.load_pressure or not 0 < lacks < 1e-6 * strength:
        return profile
    if left.from_a[0] > 1e-9 or zones[0].sense * load.base_shear < 0:
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
