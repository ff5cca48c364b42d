"""Fronts in both bodies, as lines on which the fields of a scene jump or are singular."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from semianalytic import Scene
from semianalytic.scene.arrays import Array

FLANK = 0.1
"""Least change of a load, over its largest value, in a flank that counts as a jump."""


@dataclass(frozen=True)
class StraightFront:
    """A straight front t = source |x| + (wave^2 - source^2)^1/2 |y| on one side of the edge.

    It begins where it touches the circular front of the wave.
    """

    wave: float  # slowness of the wave [time / length]
    # slowness of the source along the surface: 0 for plane waves that come at once, that of the P
    # wave for head waves, of a moving load for its plane waves, of a zone edge for its Mach fronts
    source: float
    side: int  # 1 or -1: sign of x

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
    """All fronts of a scene, and the contact edge."""

    starts: tuple[float, ...]  # times at which a load jumps and sends out all the fronts [time]
    circles: tuple[float, ...]  # slownesses of the waves that spread from the edge [time / length]
    lines: tuple[StraightFront, ...]
    # velocities of the surface points at which fields jump or are infinite: Rayleigh points and
    # zone edges [length / time]
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
class SceneFronts:
    """The fronts of a scene: alike in both bodies, or in the upper body and in the lower one."""

    bodies: tuple[Fronts, ...]

    def distance(self, x: Array, y: Array, t: float) -> Array:
        """Distance of points from the nearest front of their body, or from the edge [length]."""
        distances = [body.distance(x, y, t) for body in self.bodies]
        return np.where(np.signbit(y), distances[-1], distances[0])


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


def fronts_of(scene: Scene, edges: Sequence[float] = (), shortest: float = 0.0) -> SceneFronts:
    """Return the fronts that jumps of the loads of a scene send out.

    Whatever runs along the contact faster than a wave of a body, a wave of either body or the end
    of a zone, sends straight fronts into that body.  Edges are the velocities of the ends of slip
    zones and openings [length / time]; flanks of loads that are shorter than the shortest count as
    jumps [time].
    """
    alike, load = scene.lower_material is None, scene.superposition.taken_off
    front, moving = -scene.front_slowness, [edge for edge in edges if 0 < edge < math.inf]
    bodies = scene.bodies[: 1 if alike else 2]
    both = [(1 / solid.longitudinal_speed, 1 / solid.shear_speed) for solid in bodies]
    waves = [own[1:] if scene.shears_alone else own for own in both]
    sources = sorted({1 / edge for edge in moving}.union(*waves))
    found = []
    for body, own in zip(bodies, waves, strict=True):
        pressure, shear, points = own[0], own[-1], list(moving)
        if front > 0:  # the load runs over the slot and is reflected as waves that are slower
            lines = [StraightFront(wave, front, -1) for wave in own if front < wave]
            points.append(-1 / front)
        else:  # one that comes along the slot has plane waves that do not end at the circle
            at_once = ((shear, load.shear), (pressure, load.pressure)) if front == 0 else ()
            lines = [StraightFront(wave, 0.0, -1) for wave, size in at_once if size]
        lines += [StraightFront(shear, 0.0, 1)] if scene.far_slip_rate else []
        lines += [StraightFront(shear, u, -1) for u in own if u < shear]
        lines += [StraightFront(s, u, 1) for s in own for u in sources if u < s]
        if not scene.shears_alone:
            rayleigh = body.rayleigh_speed
            points += [-rayleigh, *([rayleigh] if alike else [])]
        found.append(Fronts(jump_times(scene, shortest), own, tuple(lines), tuple(points)))
    return SceneFronts(tuple(found))
