"""The process zone of slip weakening: the length over which friction falls behind a front."""

from __future__ import annotations

import math

from semianalytic.scene.scene import Scene


def process_zone(scene: Scene) -> float:
    """Return the length within which friction weakens behind a front [length].

    It is mu / ((1 - nu) f p w), in antiplane shear without 1 - nu, where p is the pressure in place
    and w the largest fall of the friction factor per slip: a crack of about that length is as
    compliant as friction weakens.  It is inf if friction does not weaken with slip.
    """
    held = scene.superposition.in_place
    fall = scene.friction * held.pressure * scene.friction_law.fall_with_slip
    if not fall:
        return math.inf
    return scene.static_modulus / fall
