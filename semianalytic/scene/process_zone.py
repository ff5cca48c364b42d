"""The length that slip weakening gives a front."""

from __future__ import annotations

import math

from semianalytic.scene.scene import Scene


def process_zone(scene: Scene) -> float:
    """Length within which friction weakens behind a front [length]; inf if slip does not weaken it.

    mu / ((1 - nu) f p w), in antiplane shear without 1 - nu, under the pressure p in place, w being
    the largest fall of the friction factor per slip: a crack of about that length is as compliant
    as friction weakens.
    """
    held = scene.superposition.in_place
    fall = scene.friction * held.pressure * scene.friction_law.fall_with_slip
    if not fall:
        return math.inf
    return scene.static_modulus / fall
