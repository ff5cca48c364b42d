"""The slip zone of a slot that is loaded slowly: the static near field, in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.halfplane.stuck_histories import intensity_history
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Scene


@dataclass(frozen=True)
class StaticZone:
    """The static slip zone near the contact edge under a constant strength.

    The stress intensity of the zone's own traction at its far end cancels that of the load,
    2 strength sqrt(2 length / pi) = K_II or K_III (Dugdale; Barenblatt).

    Attributes
    ----------
    strength : float
        Friction bound less shear traction of the slot [stress].
    length : float
        Length of the zone [length].
    modulus : float
        mu / (1 - nu), in antiplane shear mu [stress].
    """

    strength: float
    length: float
    modulus: float

    def slip(self, x: Array) -> Array:
        """Return the relative slip at x > 0, (n,) [length]."""
        # The logarithm is infinite at x = 0, where its factor vanishes faster.
        share = np.clip(x / self.length, 1e-300, 1.0)
        root = np.sqrt(1 - share)
        shape = root - share / 2 * np.log((1 + root) / (1 - root + 1e-300))
        return 4 / (np.pi * self.modulus) * self.strength * self.length * shape


def static_zone(scene: Scene, t: float) -> StaticZone:
    """Return the static zone of a scene with slow shear under constant pressure, at a time."""
    held, load = scene.superposition
    gone = load.shear * float(scene.shear_history.value(t))
    # In excess of the shear that the slot faces still carry: the base less what the load took off.
    strength = scene.coefficient * held.pressure - held.shear + gone
    _, intensity = intensity_history(scene.shear_history, load, scene.material, t, scene.shear_mode)
    # K = 2 strength sqrt(2 length / pi), solved for the length.
    length = np.pi / 8 * (float(intensity) / strength) ** 2
    return StaticZone(strength, float(length), scene.static_modulus)
