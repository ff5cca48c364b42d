"""Whether sliding of two different bodies has an answer on a grid, before and after a run.

Friction that follows pressure at once lets waves grow between many bodies, the shorter the faster
(`dissimilar.stability`).  A delay t*, or viscosity, may bound the growth; the grid has to resolve
waves of length 2 pi c_t t*.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.kernels import BodyPair, PairImpedance
from semianalytic.dissimilar.phase import slip_phase
from semianalytic.dissimilar.stability import sliding_stability
from semianalytic.dissimilar.thresholds import growth_threshold
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.law import Law

_SHARE = 1e-6
"""Relative change of pressure by which friction is measured."""


def check_window(pair: BodyPair, law: Law, pressure: Array, speed: Array, spacing: float) -> None:
    """Raise SceneError if waves grow without bounds while the bodies slide.

    Parameters
    ----------
    pair : BodyPair
        The bodies.
    law : Law
        Friction at the nodes of the contact.
    pressure, speed : (contact,) array
        Pressure [stress] and |slip rate| before loads [length / time].
    spacing : float
        Node distance [length].
    """
    least, delay = least_delay(pair, spacing), float(np.min(law.pressure_delay(speed)))
    if delay >= least:
        return
    friction = growing_friction(pair, law, pressure)
    if not friction:
        return
    if delay == 0:
        verdict = sliding_stability(pair.upper, pair.lower, friction).verdict
        raise SceneError(
            f"scene: friction {friction:.4g} between these bodies is {verdict} On this grid "
            f"`delay` of the friction law must be {_rounded_up(least)} or more."
        )
    raise SceneError(
        f"scene: friction follows pressure with a delay of {delay:.3g}, which the grid "
        f"cannot resolve; raise it to {_rounded_up(least)} or divide the node distance by "
        f"{math.ceil(least / delay)}."
    )


def doubt_of(
    pair: BodyPair,
    law: Law,
    pressure: Array,
    state: Array,
    fastest: float,
    spacing: float,
) -> str:
    """Return why waves may have grown on the grid alone during a run, or nothing.

    Parameters
    ----------
    pair, law, spacing
        As in `check_window`.
    pressure, state : (contact,) array
        Largest pressures of the run, and the last state of friction.
    fastest : float
        Largest |slip rate| of the run [length / time].
    """
    speed, pressed = np.full(len(pressure), fastest), pressure > 0
    if not fastest > 0 or not pressed.any():
        return ""
    if law.has_threshold:
        least, found = least_delay(pair, spacing), float(np.min(law.pressure_delay(speed)))
        if found >= least or not growing_friction(pair, law, pressure):
            return ""
        return (
            f"at the largest slip rate friction follows pressure within {found:.3g}, and the grid "
            f"resolves {_rounded_up(least)}; divide the node distance by {math.ceil(least / found)}"
            " or raise the delay."
        )
    strength = np.asarray(law.strength(pressure, speed, state), dtype=float)[pressed]
    friction = float((strength / pressure[pressed]).max())
    slopes = np.broadcast_to(law.rate_slope(pressure, speed, state), len(pressure))
    viscosity = max(float(slopes[pressed].min()), 0.0)
    if friction < threshold_of(pair.kernels) or is_damped(pair, friction, viscosity):
        return ""
    return (
        f"at the largest slip rate, {fastest:.3g}, friction rises too little with slip rate "
        "to damp the shortest waves between these bodies; raise `a`, or load more slowly."
    )


def growing_friction(pair: BodyPair, law: Law, pressure: Array) -> float:
    """Return the friction under which waves grow if a law has no delay, or 0 where none does."""
    if not law.has_threshold or not (pressure > 0).any():
        # A direct effect of slip rate damps the shortest waves, if it is large (`doubt_of`).
        return 0.0
    friction, viscosity = _response(law, pressure[pressure > 0], pressure > 0)
    if friction < threshold_of(pair.kernels):
        return 0.0
    return 0.0 if viscosity > 0 and is_damped(pair, friction, viscosity) else friction


@lru_cache(maxsize=32)
def threshold_of(kernels: PairImpedance) -> float:
    """Return the friction below which no wave grows, whatever the sense and the direction."""
    return float(min(growth_threshold(kernels.compliance, way) for way in (1, -1)))


def is_damped(pair: BodyPair, friction: float, viscosity: float) -> bool:
    """Return whether no wave grows where traction also rises with slip rate by a viscosity."""
    compliance = pair.kernels.compliance
    unit = viscosity / pair.unit_impedance
    return all(slip_phase(compliance, f, unit).is_regular(f) for f in (friction, -friction))


def least_delay(pair: BodyPair, spacing: float) -> float:
    """Return the shortest delay that a grid resolves [time]."""
    # With less q c_t t* of the shortest wave finer grids show waves that grow faster.
    return 3.0 * spacing / (math.pi * pair.speed)


def _response(law: Law, pressure: Array, where: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the largest change of strength per pressure, and the least per slip rate."""
    count = len(where)
    base, rest = np.ones(count), np.zeros(count)
    base[where] = pressure
    strength = []
    for raised in (base, base * (1 + _SHARE)):
        state = np.asarray(law.start(raised, rest, rest), dtype=float)
        strength.append(np.asarray(law.strength(raised, rest, state), dtype=float))
    friction = (strength[1] - strength[0]) / (_SHARE * base)
    slope = np.broadcast_to(
        law.rate_slope(base, rest, np.asarray(law.start(base, rest, rest), dtype=float)), count
    )
    return float(friction[where].max()), max(float(slope[where].min()), 0.0)


def _rounded_up(value: float) -> str:
    """Return a positive number with three digits, none of them rounded down."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / unit) * unit:.3g}"
