"""Properties of the contact that follow from a scene without solving it: tractions and a length.

The functions take a whole scene, so they stand above the modules that describe its parts.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Scene


def superposed_by(scene: Scene, name: str) -> tuple[str, ...]:
    """Return the parts of the superposition to which a traction of base or load is added.

    The name is "base_pressure", "base_shear", "load_pressure" or "load_shear"; any other is added
    to nothing.  The result has the same names, where "base_..." stands for the traction in place
    and "load_..." for the traction taken off.
    """
    part, _, kind = name.partition("_")
    if part not in ("base", "load"):
        return ()
    # A load that arrives is in place on the contact as well as taken off the slot faces.
    comes_everywhere = part == "load" and scene.arrives
    return (f"base_{kind}", name) if comes_everywhere else (name,)


def traction_ahead(
    scene: Scene, kind: Literal["pressure", "shear"], x: ArrayLike, t: ArrayLike
) -> Array:
    """Return a traction of the contact ahead of the waves from the slot [stress].

    It is that of the base before the front of the load, t = p x, and the traction in place from
    then on.  The shape is that of the positions x [length] and times t [time] together.
    """
    before, after = getattr(scene.base, kind), getattr(scene.superposition.in_place, kind)
    slowness, lag = scene.front_slowness, np.asarray(t, dtype=float)
    if slowness:
        lag = lag - slowness * np.asarray(x, dtype=float)
    return np.where(lag < 0, before, after)


def wave_slips_ahead(scene: Scene, until: float) -> bool:
    """Return whether an incident wave alone makes the contact slip, ahead of the edge's waves.

    Other loads than incident waves and remote ones make nothing slip; `until` is the time after its
    front to which the history of the wave matters [time].
    """
    if not scene.arrives:
        return False
    base, load, low, high = scene.before_load, scene.superposition.taken_off, 0.0, 0.0
    for history in scene.acting_histories.values():
        # The crest of a harmonic of ten periods is known to 1.2e-4, with twice as many to 3e-5.
        times = np.append(np.linspace(0.0, until, 2000), history.pieces.breaks)
        # just before and just after a jump; the load is linear in the value
        values = history.value(np.concatenate([times, np.nextafter(times, np.inf)]))
        low, high = min(low, float(values.min())), max(high, float(values.max()))
    # Friction minus shear is concave in the share of the load, so that its least value lies at an
    # end of the range.
    for share in (low, high):
        shear = abs(base.shear + share * load.shear)
        strength = scene.strength(base.pressure + share * load.pressure)
        if shear > strength * (1 + 1e-12):
            return True
    return False


def process_zone(scene: Scene) -> float:
    """Return the length within which friction weakens behind a front [length].

    It is mu / ((1 - nu) w), in antiplane shear without 1 - nu, where w is the largest fall of
    strength per slip under the pressure in place: a crack of about that length is as compliant as
    friction weakens.  It is inf if friction does not weaken with slip.
    """
    fall = scene.law.weakening(np.array([scene.superposition.in_place.pressure]))
    return scene.static_modulus / fall if fall else math.inf
