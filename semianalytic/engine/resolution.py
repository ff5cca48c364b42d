"""The resolution of a march: turns of its loads, the slip zone at the edge, and slip weakening.

A grid of node distance h follows events that last longer than some steps of h / (2 c_t), whatever
the time step.  Measured on waves and pulses of every shape, frictional work is off by 1 to 3 %
where a load turns by no more than 0.32 of its largest value within four such steps: a wave then has
16 of them in a period, a triangle lasts 13, a rectangle 4.  Within one step a load may turn by
0.08; otherwise short pulses on top of longer ones would be lost.  A slip zone of a few nodes is
seen badly, and one shorter than the distance of the first node from the edge is not seen at all.
Slip weakening has a length of its own, that of its process zone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from semianalytic.engine.stepping.pace import TURN_RATIO, nodes_following
from semianalytic.halfplane.stuck import front_share
from semianalytic.halfplane.stuck_histories import intensity_history
from semianalytic.scene.contact import process_zone
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

ZONE_NODES = 5.0
"""Nodes of a resolved zone: work is 1.3 to 1.9 % off, and estimates of 0.38 stay below 0.5."""
WEAKENING_NODES = 8.0
"""Nodes in the process zone: slip is off by 0.1 % with 8, its rate by 2 %, and by 9 % with 3."""


def nodes_for_loads(
    scene: Scene, latest: float, length: float, least: int, step_ratio: float = TURN_RATIO
) -> tuple[int, str]:
    """Return how many nodes on a length follow the loads until a time, and which load needs them.

    The step ratio is the largest c_t dt / h; less than 0.5 does not help.  The second result is
    "pressure" or "shear", or "" if the least number is enough, which then is the first.  Raises
    SceneError if a load reverses instantaneously.
    """
    nodes, reason = least, ""
    # step times nodes: a step of step_ratio h / c_t with h = length / nodes
    times_nodes = max(step_ratio, TURN_RATIO) * length / scene.material.shear_speed
    for name, history in scene.acting_histories.items():
        needed = nodes_following(history, times_nodes, latest, nodes)
        if needed == math.inf:
            raise SceneError(
                f"march: the {name} history reverses instantaneously; "
                "smooth it, or take out samples that lie close together (docs/limits.md)."
            )
        if needed > nodes * (1 + 1e-12):
            nodes, reason = math.ceil(needed), name
    return nodes, reason


def rounded_up(count: float) -> str:
    """Write a number of nodes, rounded up to two figures."""
    unit = 10 ** max(0, int(math.log10(count)) - 1)
    rounded = math.ceil(count / unit) * unit
    return f"{rounded}" if rounded < 1_000_000 else f"{rounded:.1e}"


def zone_at_edge(scene: Scene, end_time: float) -> float:
    """Return the longest slip zone at the edge that the stuck tractions cause until a time.

    Its length is Dugdale's, (pi/8) (K / s)^2, with the excess K of the stress intensity of a stuck
    edge over friction and the strength s next to the edge, and at most that of the waves.

    Parameters
    ----------
    scene : Scene
        Material, friction, tractions and load histories.
    end_time : float
        Time until which the zone is looked for [time].

    Returns
    -------
    float
        Length of the zone [length]; 0 where the edge sticks.
    """
    if scene.front_too_slow:
        return 0.0  # its intensity depends on where the load begins
    breaks = [at for history in scene.acting_histories.values() for at in history.pieces.breaks]
    # Each time costs a sum over all breaks (the Duhamel integral (3.20)), hence fewer of them.
    count = max(40, min(2000, (4 * 10**6) // max(1, len(breaks))))
    times = np.linspace(0, end_time, count + 1)
    times = np.concatenate([times, [at for at in breaks[:count] if at < end_time]])
    mode_one, mode_two = np.zeros(times.shape), np.zeros(times.shape)
    held, load = scene.superposition
    for name, history in scene.acting_histories.items():
        intensities = intensity_history(history, load, scene.material, times, scene.shear_mode)
        if name == "pressure":
            mode_one = intensities[0] * front_share(scene.material, scene.front_slowness, "I")
        else:
            share = front_share(scene.material, scene.front_slowness, scene.shear_mode)
            mode_two = intensities[1] * share
    # Next to the edge |tau| - f p ~ (|K_II| - f K_I) / sqrt(2 pi x).  The zone closes that against
    # f p less the shear that the slot faces carry, both of the tractions left on the slot.
    excess = np.abs(mode_two) - scene.coefficient * mode_one
    strength = scene.coefficient * (
        held.pressure - load.pressure * scene.pressure_history.value(times)
    ) - np.sign(mode_two) * (held.shear - load.shear * scene.shear_history.value(times))
    scale = np.abs(mode_two).max() + scene.coefficient * np.abs(mode_one).max()
    slips = excess > 1e-9 * scale  # rounding
    bounded = strength > 0
    ratio = np.where(slips, excess, 0.0) / np.where(bounded, strength, 1.0)
    # Without strength at the edge nothing bounds the zone but the waves.
    zone = np.where(slips & ~bounded, np.inf, np.pi / 8 * ratio**2)
    return float(np.minimum(zone, scene.fastest_speed * times).max())


@dataclass(frozen=True)
class Shortfall:
    """A reason why a march is too coarse.

    Attributes
    ----------
    reason : str
        The reason, as a clause.
    times : float
        How many times as many nodes would be enough.
    """

    reason: str
    times: float


def check_weakening_seen(scene: Scene, spacing: float) -> None:
    """Raise SceneError if the process zone of slip weakening is shorter than two nodes.

    The grid, not the friction law, would then set the length over which friction weakens.
    """
    zone = process_zone(scene)
    if zone < 2.0 * spacing:  # below two nodes slip is off by 4 %, its rate by 22 %
        raise SceneError(
            f"march: friction weakens within about {zone:.3g} of length, which nodes {spacing:.3g} "
            f"apart do not resolve; raise `nodes` {rounded_up(WEAKENING_NODES * spacing / zone)} "
            "times (docs/limits.md)."
        )


def shortfalls_of(marched: Any) -> tuple[Shortfall, ...]:
    """Return the known reasons why the grid of a march next to a slot is too coarse.

    These are slip at the edge over less than five nodes (which would otherwise look like no slip),
    slip weakening on too few nodes, and an error estimate above `rtol`, or above a half.
    """
    every = missed_zone(marched), _coarse_weakening(marched), _inaccurate(marched)
    return tuple(known for known in every if known is not None)


def missed_zone(marched: Any) -> Shortfall | None:
    """Return a slip zone at the edge that the grid does not resolve, or None."""
    # Any slip ever seen counts: a zone may have been on the grid and have healed since.
    slips, spacing = marched.seen.slip_rate > 0, marched.spacing
    least = ZONE_NODES * spacing
    # The march's own record is asked first, because it costs nothing.
    if float(marched.interface.x[slips].max(initial=0.0)) >= least:
        return None
    zone = zone_at_edge(marched.scene, marched.end_time)
    if not 0 < zone < least:
        return None
    return Shortfall(
        f"the edge slips over a length of about {zone:.2g}, which nodes {spacing:.2g} apart do not "
        "resolve",
        least / zone,
    )


def _coarse_weakening(marched: Any) -> Shortfall | None:
    """Return slip weakening on too few nodes, or None."""
    zone = process_zone(marched.scene)
    nodes = zone / marched.spacing
    if nodes >= WEAKENING_NODES:
        return None
    return Shortfall(
        f"friction weakens within about {zone:.2g} of length, over {nodes:.2g} nodes where "
        f"{WEAKENING_NODES:g} resolve it",
        WEAKENING_NODES / nodes,
    )


def _inaccurate(marched: Any) -> Shortfall | None:
    """Return an error estimate above what was asked for, or None."""
    estimate, rtol = marched.error_estimate, marched.checkpoint.rtol
    # 420 random marches were off by at most 0.86 of their estimates, but for one at 0.75 that
    # missed almost all slip; 0.3 refuses one in forty more, mostly good ones.
    largest = 0.5 if rtol is None else rtol
    # nan (no companion) and inf (a missed zone, which has its own sentence) fail both sides.
    if not largest < estimate < math.inf:
        return None
    limit = "" if rtol is None else f", above the `rtol` of {rtol:.1e}"
    reason = f"the error of the slip rate is estimated as {estimate:.1e}{limit}"
    return Shortfall(reason, estimate / largest)
