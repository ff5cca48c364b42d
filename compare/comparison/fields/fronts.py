"""Fronts in both bodies, as lines on which the fields of a scene jump or are singular."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from semianalytic import Scene
from semianalytic.arrays import Array

FLANK = 0.1
"""Least change of a load, over its largest value, in a flank that counts as a jump."""


@dataclass(frozen=True)
class StraightFront:
    """A straight front t = source |x| + (wave^2 - source^2)^1/2 |y| on one side of the edge.

    It begins where it touches the circular front of the wave.

    Attributes
    ----------
    wave : float
        Slowness of the wave [time / length].
    source : float
        Slowness of the source along the surface: 0 for plane waves that come at once, that of the P
        wave for head waves, of a moving load for its plane waves, of a zone edge for its Mach
        fronts.
    side : 1 or -1
        Sign of x.
    """

    wave: float
    source: float
    side: int

    def line(self, t: float, share: Array) -> tuple[Array, Array]:
        """Points x, y >= 0 of the front at time t [length], by their share of the way from the
        surface to the circle; not for plane waves that come at once, which do not end there."""
        ratio = self.source / self.wave
        foot, touch = t / self.source, t / self.wave * ratio
        x = self.side * (foot + share * (touch - foot))
        return x, share * t / self.wave * math.sqrt(1 - ratio * ratio)

    def distance(self, x: Array, y: Array, t: float) -> Array:
        """Distance of points from the front at time t [length]; beyond its end, from the end."""
        along, across = self.side * x, np.abs(y)
        rise = math.sqrt(self.wave**2 - self.source**2)
        back = (rise * along - self.source * across) / self.wave
        gap = np.abs(self.source * along + rise * across - t) / self.wave
        return np.asarray(np.hypot(gap, np.maximum(0.0, -back)))


@dataclass(frozen=True)
class Fronts:
    """All fronts of a scene, and the contact edge.

    Attributes
    ----------
    starts : tuple of float
        Times at which a load jumps and sends out all the fronts [time].
    circles : tuple of float
        Slownesses of the waves that spread from the edge [time / length].
    lines : tuple of StraightFront
    points : tuple of float
        Velocities of the surface points at which fields jump or are infinite: Rayleigh points and
        zone edges [length / time].
    """

    starts: tuple[float, ...]
    circles: tuple[float, ...]
    lines: tuple[StraightFront, ...]
    points: tuple[float, ...]

    def distance(self, x: Array, y: Array, t: float) -> Array:
        """Distance of points from the nearest front, or from the edge, at time t [length]."""
        r = np.hypot(x, y)
        distances = [r]
        for since in (t - start for start in self.starts if start < t):
            distances += [np.abs(r - since / wave) for wave in self.circles]
            distances += [line.distance(x, y, since) for line in self.lines]
            distances += [np.hypot(x - speed * since, y) for speed in self.points]
        return np.asarray(np.minimum.reduce(distances))


@dataclass(frozen=True)
class TwoBodies:
    """The fronts in two different bodies.

    Attributes
    ----------
    upper, lower : Fronts
    """

    upper: Fronts
    lower: Fronts

    def distance(self, x: Array, y: Array, t: float) -> Array:
        """Distance of points from the nearest front of their body, or from the edge [length]."""
        above, below = (body.distance(x, y, t) for body in (self.upper, self.lower))
        return np.where(np.signbit(y), below, above)


def fronts_between(scene: Scene, edges: Sequence[float] = ()) -> TwoBodies:
    """Return the fronts that a step on the slot sends into two different bodies.

    Whatever runs along the contact faster than a wave of a body, a wave of either body or the end
    of a zone, sends straight fronts into that body.  Edges are the velocities of the ends of slip
    zones and openings [length / time].
    """
    bodies, load = scene.bodies, scene.superposition.taken_off
    moving = [edge for edge in edges if 0 < edge < math.inf]
    waves = [(1 / solid.longitudinal_speed, 1 / solid.shear_speed) for solid in bodies]
    sources = {1 / edge for edge in moving}.union(*waves)
    found = []
    for (pressure, shear), body in zip(waves, bodies, strict=True):
        lines = [StraightFront(shear, 0.0, -1)] if load.shear else []
        lines += [StraightFront(pressure, 0.0, -1)] if load.pressure else []
        lines.append(StraightFront(shear, pressure, -1))
        lines += [StraightFront(s, u, 1) for s in (pressure, shear) for u in sources if u < s]
        points = (*moving, -body.rayleigh_speed)
        found.append(Fronts((0.0,), (pressure, shear), tuple(lines), points))
    return TwoBodies(*found)


def jump_times(scene: Scene, shortest: float = 0.0) -> tuple[float, ...]:
    """Times at which a load of a scene jumps, in order [time].

    Flanks of a history that are shorter than a time count as jumps, at their beginning and end, if
    the load changes by more than `FLANK` of its largest value; finely tabulated ones do not.
    """
    load = scene.superposition.taken_off
    histories = ((scene.pressure_history, load.pressure), (scene.shear_history, load.shear))
    starts: set[float] = set()
    for history, step in histories:
        if not step:
            continue
        starts.update(time for time, _ in history.pieces.jumps)
        times = history.pieces.breaks
        values = history.value(np.array(times)) if times else np.zeros(0)
        steep = np.abs(np.diff(values)) > FLANK * np.abs(values).max(initial=0.0)
        for (begin, end), rises in zip(pairwise(times), steep, strict=True):
            if rises and end - begin < shortest:
                starts.update((begin, end))
    return tuple(sorted(starts))


def fronts_of(scene: Scene, edges: Sequence[float] = (), shortest: float = 0.0) -> Fronts:
    """Return the fronts that jumps of the loads of a scene send out.

    Edges are the velocities of the ends of slip zones and openings [length / time]; flanks of loads
    that are shorter than the shortest count as jumps [time].
    """
    material, load = scene.material, scene.superposition.taken_off
    shear, pressure = 1 / material.shear_speed, 1 / material.longitudinal_speed
    moving = [edge for edge in edges if 0 < edge < math.inf]
    in_plane = not scene.antiplane or load.pressure != 0
    waves = (pressure, shear) if in_plane else (shear,)
    rayleigh = material.rayleigh_speed
    points = [*moving, *((rayleigh, -rayleigh) if in_plane else ())]
    front = -scene.front_slowness
    if front > 0:  # the load runs over the slot and is reflected as waves that it is faster than
        lines = [StraightFront(wave, front, -1) for wave in waves if front < wave]
        points.append(-1 / front)
    else:
        lines = [StraightFront(shear, 0.0, -1)] if load.shear else []
        lines += [StraightFront(pressure, 0.0, -1)] if load.pressure else []
    lines += [StraightFront(shear, 0.0, 1)] if scene.far_slip_rate else []
    lines += [StraightFront(shear, pressure, side) for side in (1, -1) if in_plane]
    lines += [StraightFront(s, 1 / edge, 1) for edge in moving for s in waves if s * edge > 1]
    return Fronts(jump_times(scene, shortest), waves, tuple(lines), tuple(points))
