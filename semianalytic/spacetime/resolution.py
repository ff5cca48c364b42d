"""What a march resolves: the turns of its loads, the slip zone at the edge, and slip weakening.

A grid of node distance h follows what lasts longer than some steps of h / (2 c_t), whatever the
time step: measured on waves and pulses of every shape (docs/spacetime.md), frictional work is off
by 1 to 3 % where a load turns by no more than 0.32 of its largest value within four such steps.
A wave makes 16 of them a period then, a triangle lasts 13, a rectangle 4.  A turn within one step
may be 0.08, or short pulses on top of longer ones would be lost.  Of a slip zone shorter than some
nodes a grid sees little, and of one below the first node nothing; slip weakening has a length of
its own, that of its process zone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.stuck_histories import intensity_history
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import LoadHistory
from semianalytic.scene.process_zone import process_zone
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.tuning import (
    HALVINGS,
    LARGEST_TURN,
    LEAST_TIMES,
    LEAST_WEAKENING_NODES,
    MOST_SAMPLES,
    NO_INTENSITY,
    STEP_RATIO,
    TIMES,
    WEAKENING_NODES,
    ZONE_NODES,
)

Array = NDArray[np.float64]


def _follows(history: LoadHistory, step: float, latest: float) -> bool:
    return all(
        history.turn(steps * step, latest) <= allowed for steps, allowed in LARGEST_TURN.items()
    )


def nodes_for_loads(
    scene: Scene, latest: float, length: float, least: int, step_ratio: float = STEP_RATIO
) -> tuple[int, str]:
    """Contact nodes that follow the loads until `latest`, `least` or more, and what needs them.

    Parameters
    ----------
    scene : Scene
    latest : float
        [time].
    length : float
        On which the nodes lie [length].
    least : int
        Returned with "" if it is enough.
    step_ratio : float
        Largest c_t dt / h; less than 0.5 does not help.
    """
    nodes, reason = least, ""
    times_nodes = max(step_ratio, STEP_RATIO) * length / scene.material.shear_speed
    for name, history in scene.acting_histories.items():
        step = times_nodes / nodes
        if _follows(history, step, latest):
            continue
        enough, lacking = 0.0, step
        for _ in range(HALVINGS):
            middle = lacking / 16 if enough == 0 else (enough + lacking) / 2
            enough, lacking = (
                (middle, lacking) if _follows(history, middle, latest) else (enough, middle)
            )
            if enough > 0.999 * lacking:
                break
        if enough == 0:
            raise SceneError(
                f"march: the {name} history turns back within no time at all; "
                "smooth it, or take out samples that lie beside each other (docs/limits.md)."
            )
        nodes, reason = math.ceil(times_nodes / enough), name
    return nodes, reason


def check_loads(
    scene: Scene,
    latest: float,
    length: float,
    nodes: int,
    most: int,
    step_ratio: float = STEP_RATIO,
) -> int:
    """Contact nodes to march with: `nodes`, or as many up to `most` as follow the loads.

    Raises
    ------
    SceneError
        If more than `most` are needed, with their number.
    """
    needed, name = nodes_for_loads(scene, latest, length, nodes, step_ratio)
    if needed > most:
        raise SceneError(
            f"march: the {name} history turns faster than {most} nodes on a length of {length:.4g} "
            f"follow; raise `nodes` to {_rounded(needed)}, or shorten `length` "
            f"{needed / most:.2g} times (docs/limits.md)."
        )
    return needed


def _rounded(count: float) -> str:
    """A number of nodes rounded up to two figures."""
    unit = 10 ** max(0, int(math.log10(count)) - 1)
    rounded = math.ceil(count / unit) * unit
    return f"{rounded}" if rounded < 1_000_000 else f"{rounded:.1e}"


def zone_at_edge(scene: Scene, end_time: float) -> float:
    """Longest slip zone at the edge that the stuck tractions call for until a time [length].

    (pi/8) (K / s)^2, Dugdale's, with K what the stress intensity of a stuck edge is above friction
    and s the strength left beside it; what waves have reached at most.  0 where the edge holds.
    """
    breaks = [at for history in scene.acting_histories.values() for at in history.pieces.breaks]
    count = max(LEAST_TIMES, min(TIMES, MOST_SAMPLES // max(1, len(breaks))))
    times = np.linspace(0, end_time, count + 1)
    times = np.concatenate([times, [at for at in breaks[:count] if at < end_time]])
    mode_one, mode_two = np.zeros(times.shape), np.zeros(times.shape)
    held, load = scene.superposition
    for name, history in scene.acting_histories.items():
        intensities = intensity_history(history, load, scene.material, times, scene.shear_mode)
        if name == "pressure":
            mode_one = intensities[0]
        else:
            mode_two = intensities[1]
    excess = np.abs(mode_two) - scene.friction * mode_one
    strength = scene.friction * (
        held.pressure - load.pressure * scene.pressure_history.value(times)
    ) - np.sign(mode_two) * (held.shear - load.shear * scene.shear_history.value(times))
    scale = np.abs(mode_two).max() + scene.friction * np.abs(mode_one).max()
    slips = excess > NO_INTENSITY * scale
    bounded = strength > 0
    ratio = np.where(slips, excess, 0.0) / np.where(bounded, strength, 1.0)
    zone = np.where(slips & ~bounded, np.inf, np.pi / 8 * ratio**2)
    return float(np.minimum(zone, scene.fastest_speed * times).max())


def nodes_for_zone(scene: Scene, end_time: float, length: float) -> int:
    """Contact nodes on a length that resolve the longest slip zone at the edge; 0 without one."""
    zone = zone_at_edge(scene, end_time)
    return math.ceil(ZONE_NODES * length / zone) if zone else 0


def nodes_for_weakening(scene: Scene, length: float) -> int:
    """Contact nodes on a length that resolve the process zone of slip weakening; 0 without one."""
    return math.ceil(WEAKENING_NODES * length / process_zone(scene))


@dataclass(frozen=True)
class Shortfall:
    """What a march is too coarse for.

    Attributes
    ----------
    reason : str
        What is wrong, as a clause.
    times : float
        How many times as many nodes would do.
    """

    reason: str
    times: float


def advice(shortfalls: Sequence[Shortfall], option: str) -> str:
    """What a march is too coarse for, and how many times an option has to be raised; or ""."""
    if not shortfalls:
        return ""
    reasons = "; ".join(one.reason for one in shortfalls)
    return f"{reasons}; raise `{option}` {_rounded(max(one.times for one in shortfalls))} times"


def missed_zone(scene: Scene, end_time: float, spacing: float, reach: float) -> Shortfall | None:
    """A slip zone at the edge of which a march sees next to nothing; None if there is none.

    Parameters
    ----------
    scene : Scene
    end_time : float
        Until when it went [time].
    spacing : float
        Node distance [length].
    reach : float
        How far from the edge it saw slip [length].
    """
    least = ZONE_NODES * spacing
    if reach >= least:
        return None
    zone = zone_at_edge(scene, end_time)
    if not 0 < zone < least:
        return None
    return Shortfall(
        f"the edge slips over a length of about {zone:.2g}, which nodes {spacing:.2g} apart do not "
        "resolve",
        least / zone,
    )


def coarse_weakening(scene: Scene, spacing: float) -> Shortfall | None:
    """Slip weakening on too few nodes, of a distance [length]; None if they are enough."""
    zone = process_zone(scene)
    nodes = zone / spacing
    if nodes >= WEAKENING_NODES:
        return None
    return Shortfall(
        f"friction weakens within about {zone:.2g} of length, over {nodes:.2g} nodes where "
        f"{WEAKENING_NODES:g} resolve it",
        WEAKENING_NODES / nodes,
    )


def check_weakening_seen(scene: Scene, spacing: float) -> None:
    """Raise SceneError if the grid, not the law, would set the length of slip weakening."""
    zone = process_zone(scene)
    if zone < LEAST_WEAKENING_NODES * spacing:
        raise SceneError(
            f"march: friction weakens within about {zone:.3g} of length, which nodes {spacing:.3g} "
            f"apart do not resolve; raise `nodes` {_rounded(WEAKENING_NODES * spacing / zone)} "
            "times (docs/limits.md)."
        )
