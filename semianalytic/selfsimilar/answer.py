"""What all self-similar answers share: zones and openings whose edges move evenly."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from semianalytic.halfplane.rayleigh import Array
from semianalytic.results.answer import OpenInterval, SlipInterval
from semianalytic.results.gridded import Gridded
from semianalytic.scene.checks import checked_number
from semianalytic.scene.quantities import asked_in_units

if TYPE_CHECKING:
    from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone


@asked_in_units
class SelfSimilarAnswer(Gridded):
    """An answer whose fields depend on x/t, up to a power of time.

    Zones and openings are those of the classes that inherit from this one.
    """

    if TYPE_CHECKING:  # fields of some dataclasses, for which a property here would be a default

        @property
        def zones(self) -> tuple[SlipZone, ...]:
            """Slip zones in velocities, from the contact edge outward."""

        @property
        def openings(self) -> tuple[OpenZone, ...]:
            """Open parts in velocities, from the contact edge outward."""

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        """Return the intervals that slip at a time [time], from the contact edge outward.

        Until t = 0 there are none.

        Raises
        ------
        SceneError
            If the time is not a finite number.
        """
        t = checked_number("zones_at: t", t)
        parts = self.zones if t > 0 else ()
        return tuple(SlipInterval(t * zone.inner, t * zone.outer, zone.sense) for zone in parts)

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        """Return the open intervals at a time, from the contact edge outward; raises like
        `zones_at`."""
        t = checked_number("openings_at: t", t)
        parts = self.openings if t > 0 else ()
        return tuple(OpenInterval(t * part.inner, t * part.outer) for part in parts)

    @property
    def edge_speeds(self) -> Array:
        """(m, 2) velocities of the inner and outer edge of each zone [length / time].

        From the contact edge outward; 0 is the contact edge itself, inf slip ahead of all waves.
        """
        return np.array([(zone.inner, zone.outer) for zone in self.zones]).reshape(-1, 2)
