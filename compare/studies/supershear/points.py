"""Spontaneous ruptures under linear slip weakening: onset of slip, speed of the front, transition.

The strength parameter S = (peak strength - shear) / (shear - dynamic strength) sets how far a
rupture runs before it overtakes shear waves.  Lengths are in units of L_c, the half-length at which
a static crack of the same fracture energy becomes critical,
L_c = mu (peak - dynamic) distance / (pi (1 - nu) (shear - dynamic)^2), after Andrews (1976).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic import Interface, InterfaceLoad, Material, SlipDependent
from semianalytic.engine.steps import Stepper
from semianalytic.engine.tuning import STEP_RATIO

Array = NDArray[np.float64]

SOLID = Material(1.0, 1.0, 0.25)
SUB_RAYLEIGH, SUPERSHEAR = "sub-Rayleigh", "supershear"
SUPERSHEAR_SPEED = 1.02
"""Front speed over c_t from which a rupture counts as supershear.  With 1.01 and 1.1 the
transitions at S = 0.8 and 1 are within 0.06 L_c of what they are with 1.02."""
WINDOW = 1.0
"""Length [L_c] over which the speed of a front is taken.  With half of it the transitions at
S = 0.8 and 1 are 0.2 L_c farther out, with twice its value 0.4 L_c farther in."""
NUCLEUS, NUCLEATION_SPEED = 1.5, 0.3
"""The rupture is forced out to 1.5 L_c, at 0.3 c_t.  At S = 1 a speed of 0.2 moves the transition
by -4 %, one of 0.5 by 4 %, and a radius of 2 not at all."""
_LEFT = 1e-9
"""Share of the pressure that is left in the nucleus: strength is gone, the contact stays closed."""
_RATE = 1e-9
"""Slip rate at which a node counts as slipping, over the rate stress drop / impedance."""
_SLOWEST = 0.85
"""Mean speed of a front over c_t from which the end time follows: every front is faster, so that
all of them reach the farthest point."""
_MARGIN = 4.0
"""Distance [L_c] that waves of the neighbouring period keep from the farthest point."""


@dataclass(frozen=True)
class RupturePoint:
    """A rupture at one distance: its style and the speed of its front over c_t.

    Attributes
    ----------
    strength : float
        S.
    distance : float
        Distance from the centre, in the middle of a cell of the map [L_c].
    speed : float
        Mean speed of the front over c_t in that cell.
    style : str
        "sub-Rayleigh" or "supershear": whether the rupture has overtaken shear waves there.
    """

    strength: float
    distance: float
    speed: float
    style: str


@dataclass(frozen=True)
class TransitionPoint:
    """The distance at which a rupture overtakes shear waves.

    Attributes
    ----------
    strength : float
        S.
    nodes : int
        Nodes per L_c.
    transition : float
        Distance from the centre [L_c]; nan if the rupture stays sub-Rayleigh.
    farthest : float
        Distance to which the rupture was followed [L_c].
    """

    strength: float
    nodes: int
    transition: float
    farthest: float


def rupture(strength: float, half_length: float) -> Interface:
    """Return the interface of a rupture of strength S on a period of two half-lengths [L_c].

    Stress drop, c_t and L_c are 1.  The pressure in the nucleus, and with it the strength, is taken
    off behind a front at 0.3 c_t.
    """

    def nucleus(x: Array, t: float) -> Array:
        return np.where(np.abs(x) < min(NUCLEATION_SPEED * t, NUCLEUS), _LEFT - 1, 0.0)

    return Interface(
        SOLID,
        SlipDependent(
            static=1 + strength,
            dynamic=0.0,
            distance=math.pi * (1 - SOLID.poisson_ratio) / (1 + strength),
        ),
        2 * half_length,
        pressure=1.0,
        shear=1.0,
        loads=[InterfaceLoad(pressure=nucleus, history=None)],
        even=True,
    )


def onsets(strength: float, nodes: int, farthest: float) -> tuple[Array, Array]:
    """Return positions x >= 0 [L_c] and the times at which slip begins there [L_c / c_t].

    The march ends when slip reaches the farthest position; where it has not begun, the time is
    inf.

    Parameters
    ----------
    strength : float
        S.
    nodes : int
        Nodes per L_c.
    farthest : float
        Distance that the rupture has to reach [L_c].
    """
    end = NUCLEUS / NUCLEATION_SPEED + farthest / _SLOWEST
    # Waves of the nucleus of the next period must not arrive before the rupture does.
    half = math.ceil((farthest + _MARGIN + SOLID.longitudinal_speed * end) / 2)
    interface = rupture(strength, half)
    stepper = Stepper(interface, 4 * math.ceil(half * nodes / 2), STEP_RATIO, end_time=end)
    now, x = stepper.begin(), stepper.grid.x
    begun = np.full(len(x), math.inf)
    last = int(np.searchsorted(x, farthest))
    while now.time < end and not math.isfinite(begun[last]):
        now = stepper.step(now, *stepper.length(now))
        begun[(now.rate > _RATE) & np.isinf(begun)] = now.time
    return x, begun


def front_speeds(x: Array, begun: Array, window: float = WINDOW) -> tuple[Array, Array]:
    """Return positions and the speed of the front over c_t in a window around each, (n,) each.

    The front is at x when slip has begun at x or anywhere beyond; a rupture that jumps ahead to a
    daughter crack so has an infinite speed on the way, written as inf.
    """
    first = np.minimum.accumulate(begun[::-1])[::-1]
    reached = np.isfinite(first)
    x, first = x[reached], first[reached]
    count = round(window / (x[1] - x[0]))
    taken = first[count:] - first[:-count]
    with np.errstate(divide="ignore"):
        speeds = (x[count:] - x[:-count]) / taken
    return (x[count:] + x[:-count]) / 2, speeds


def transition(x: Array, speeds: Array) -> float:
    """Return the position from which on the front is faster than shear waves; nan if there is none.

    The nucleus, which is forced, does not count.
    """
    slow = np.flatnonzero(speeds <= SUPERSHEAR_SPEED)
    if len(slow) == 0 or slow[-1] + 1 == len(x):
        return math.nan
    return float(x[slow[-1] + 1])


def transition_point(strength: float, nodes: int, farthest: float) -> TransitionPoint:
    """Follow a rupture and find where it overtakes shear waves."""
    x, speeds = front_speeds(*onsets(strength, nodes, farthest))
    return TransitionPoint(strength, nodes, transition(x, speeds), farthest)


def rupture_points(
    strength: float, nodes: int, farthest: float, count: int
) -> tuple[list[RupturePoint], TransitionPoint]:
    """Follow a rupture and give its style and speed in cells of equal length."""
    begun = onsets(strength, nodes, farthest)
    change = transition(*front_speeds(*begun))
    cell = farthest / count
    x, speeds = front_speeds(*begun, cell)
    points = []
    for distance in (cell * (np.arange(count) + 0.5)).tolist():
        style = SUPERSHEAR if distance >= change else SUB_RAYLEIGH
        at = int(np.argmin(np.abs(x - distance)))
        points.append(RupturePoint(strength, distance, float(speeds[at]), style))
    return points, TransitionPoint(strength, nodes, change, farthest)
