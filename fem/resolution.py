"""The resolution of loads and friction laws on a mesh.

The mean of a load over a step keeps its impulse, whatever happens within the step.  A load that
only rises, or only falls, is right to first order however suddenly it does so.  A load that rises
and falls again within the time in which a shear wave crosses a few elements is not: the mesh
spreads it and lowers its peak, to which friction responds.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import replace

from semianalytic.scene.contact import process_zone
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import LoadHistory
from semianalytic.scene.scene import Scene

LARGEST_TURN = {1.5: 0.2, 4.0: 0.5}
"""Largest turn of a load, over its largest value, while a shear wave covers so many node distances.
It allows 12 of them in a period of a harmonic, 8 in a triangle, 4 in a rectangle, with frictional
work within 6 %; the shorter time is for ripples."""
LEAST_CROSSED = 16
"""Elements that the shear wave of the slower block should cross until the end: slip at the end is
then within 0.5 %, and 2 % and 6 % with 8 and 4, whatever the ratio of speeds."""
WEAKENING_ELEMENTS = 13
"""Elements in the process zone of slip weakening from which on slip is right to 1 %; slip rate, all
of which is at the front, takes some 40."""
MOST = 2**60
ROUNDING = 1e-9


def resolves(history: LoadHistory, crossing: float, end_time: float) -> bool:
    """Return whether a mesh follows the history of a load until the end time [time].

    The slowest shear wave covers a node distance within the crossing time [time].
    """
    return all(
        history.turn(nodes * crossing, end_time) <= allowed + ROUNDING
        for nodes, allowed in LARGEST_TURN.items()
    )


def needed_resolution(history: LoadHistory, crossing: float, end_time: float) -> int | None:
    """Return the least number of node distances per c_t T that follows a history, or None.

    Here the slowest shear wave covers c_t T within the crossing time [time].
    """
    if resolves(history, crossing, end_time):
        return 1
    low, high = 1, 2
    while not resolves(history, crossing / high, end_time):
        low, high = high, 4 * high
        if high > MOST:
            return None
    return bisect_left(
        range(high), True, low, key=lambda count: resolves(history, crossing / count, end_time)
    )


def check_resolved(scene: Scene, end_time: float, resolution: int) -> None:
    """Raise SceneError if a load turns back faster than the mesh can follow until T [time].

    The resolution is the number of node distances per c_t T.
    """
    slowest = min(body.shear_speed for body in scene.bodies)
    crossing = scene.material.shear_speed * end_time / slowest
    for name, history in scene.acting_histories.items():
        if resolves(history, crossing / resolution, end_time):
            continue
        needed = needed_resolution(history, crossing, end_time)
        if needed is None:
            raise SceneError(
                f"simulate: the {name} history reverses instantaneously; smooth it, or "
                "take out samples that lie close together (docs/limits.md)."
            )
        raise SceneError(
            f"simulate: the {name} history turns back faster than this mesh can follow; raise "
            f"`resolution` from {resolution} to at least {needed}, or shorten `end_time` "
            "(docs/limits.md)."
        )


def slow_body_caution(scene: Scene, resolution: int) -> str:
    """Say in a sentence if the mesh is too coarse for a slower lower block; "" if it is not.

    The shear wave of the upper block covers `resolution` node distances until the end.
    """
    upper, lower = scene.bodies
    ratio = lower.shear_speed / upper.shear_speed
    crossed, needed = resolution * ratio, math.ceil(LEAST_CROSSED / ratio)
    if ratio >= 1 or crossed >= LEAST_CROSSED or resolution >= needed:
        return ""
    return (
        f"the lower block is under-resolved: its shear wave crosses {crossed:.2g} elements until "
        f"the end, {1 / ratio:.3g} times fewer than that of the upper one; a resolution of "
        f"{needed} would make that {LEAST_CROSSED}."
    )


def weakening_caution(scene: Scene, end_time: float, resolution: int) -> str:
    """Say in a sentence if the mesh is too coarse for slip weakening; "" if it is not."""
    zone = min(process_zone(replace(scene, material=body)) for body in scene.bodies)
    elements = zone * resolution / (scene.material.shear_speed * end_time)
    if elements >= WEAKENING_ELEMENTS:
        return ""
    needed = math.ceil(resolution * WEAKENING_ELEMENTS / elements)
    return (
        f"slip weakening is under-resolved: friction weakens within about {zone:.3g} of length, "
        f"which is {elements:.2g} elements; a resolution of {needed} would make that "
        f"{WEAKENING_ELEMENTS}."
    )


def mesh_caution(scene: Scene, end_time: float, resolution: int) -> str:
    """Say in sentences what the mesh is known to be too coarse for; "" if nothing."""
    cautions = (
        slow_body_caution(scene, resolution),
        weakening_caution(scene, end_time, resolution),
    )
    return " ".join(filter(None, cautions))
