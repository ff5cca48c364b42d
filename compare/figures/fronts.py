"""Where fronts are in the bodies, what moves on the interface, and how far any of it has come."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from compare.comparison.fields.fronts import StraightFront
from compare.comparison.scales import scene_fronts
from compare.figures.quantities import Array
from semianalytic.results.answer import WholeFields

Window = tuple[float, float, float, float]
"""x from, to, y from, to [length]."""

MARGIN = 1.05
"""How much further than the first wave a picture reaches unless it is told."""


@dataclass(frozen=True)
class Moving:
    """A part of the contact whose sides move: start < x < end [length].

    Attributes
    ----------
    kind : str
        "slip", "reverse slip" or "open".
    start, end : float
    """

    kind: str
    start: float
    end: float

    def covers(self, x: float) -> bool:
        """Whether a place is within it."""
        return self.start < x < self.end


@dataclass(frozen=True)
class Front:
    """A line over which fields of the upper body change their form, and its mirror image below.

    Attributes
    ----------
    name : str
    x, y : (n,) arrays
        [length], y >= 0.
    share : float
        How far along it its name stands; beside its start if 0.
    """

    name: str
    x: Array
    y: Array
    share: float


def reach(fields: WholeFields, time: float) -> Window:
    """All that a wave can have come to until a time [time], and a little more."""
    far = MARGIN * fields.scene.fastest_speed * time
    return -far, far, -far, far


def moving_parts(fields: WholeFields, time: float) -> list[Moving]:
    """What slips and what is open at a time [time]."""
    slipping = [
        Moving("slip" if zone.sense > 0 else "reverse slip", zone.start, zone.end)
        for zone in fields.zones_at(time)
    ]
    return slipping + [Moving("open", one.start, one.end) for one in fields.openings_at(time)]


def fronts(fields: WholeFields, time: float) -> Iterator[Front]:
    """Wave fronts at a time [time], counted from loads that start at t = 0.

    Circles about the edge of the slot; plane waves of the loads on the slot faces; the S waves that
    run along with the P wave on the free faces (head waves) or with the edges of zones faster than
    them (Mach fronts).
    """
    scene, speeds = fields.scene, scene_fronts(fields.scene)
    angle = np.linspace(0.0, np.pi, 361)
    for name, share in (("P", 0.36), ("S", 0.30)):
        if name in speeds:
            radius = speeds[name] * time
            yield Front(name, radius * np.cos(angle), radius * np.sin(angle), share)
    taken_off = scene.superposition.taken_off
    for name, load in (("P", taken_off.pressure), ("S", taken_off.shear)):
        if load and name in speeds:
            far = 1e3 * scene.fastest_speed * time
            right = far if name == "S" and scene.far_slip_rate else 0.0
            x = np.array([-far, -0.8 * scene.fastest_speed * time, right])
            yield Front(f"plane {name}", x, np.full(3, speeds[name] * time), 0.5)
    slow = speeds["S"]
    if "P" in speeds:
        yield _tangent("head wave", -speeds["P"], slow, time, 0.4)
    if not scene.is_self_similar:
        return
    parts = moving_parts(fields, time)
    if "P" in speeds and any(part.covers(speeds["P"] * time) for part in parts):
        yield _tangent("head wave", speeds["P"], slow, time, 0.4)
    edges = sorted({place / time for part in parts for place in (part.start, part.end)})
    for speed in edges:
        for name in ("S", "P"):
            if name in speeds and speeds[name] < speed < np.inf:
                yield _tangent("Mach front", speed, speeds[name], time, 0.0)


def _tangent(name: str, speed: float, wave: float, time: float, share: float) -> Front:
    """From a point that runs along the interface to the circle of a wave that is slower."""
    front = StraightFront(1 / wave, 1 / abs(speed), 1 if speed > 0 else -1)
    x, y = front.line(time, np.linspace(0.0, 1.0, 41))
    return Front(name, x, y, share)
