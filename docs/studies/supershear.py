"""Spontaneous ruptures under linear slip weakening: speed of the front, where it is supershear.

The strength parameter S = (peak strength - shear) / (shear - dynamic strength) sets how far a
rupture runs before it overtakes shear waves.  Lengths are in units of L_c, the half-length at which
a static crack of the same fracture energy becomes critical,
L_c = mu (peak - dynamic) distance / (pi (1 - nu) (shear - dynamic)^2), after Andrews (1976).

``python -m docs.studies.supershear --output docs`` makes table and figure of regimes.md.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from compare.figures.style import BLACK, SMALL, outline
from docs.studies.lines import scene_along
from docs.studies.runner import Point, Row, Study, drawn, main
from semianalytic import InterfaceLoad, Material, Scene, SlipWeakening
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.engine.stepping.tuning import STEP_RATIO
from semianalytic.scene.arrays import Array

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
DISTANCES = {0.8: 12.0, 0.9: 16.0, 1.0: 21.0, 1.1: 28.0, 1.2: 38.0, 1.3: 54.0}
"""How far to follow the rupture of each S [L_c]: a fifth beyond its transition."""
STRENGTHS = (0.5, 1.6)
"""S of the first and the last column of the map.  Above 1.6 the transition is beyond 300 L_c, where
a map to 100 L_c shows sub-Rayleigh ruptures alone."""
_REST = 1e-9
"""Share of the pressure that remains in the nucleus: strength is gone, the contact stays closed."""
_RATE = 1e-9
"""Slip rate at which a node counts as slipping, over the rate stress drop / impedance."""
_SLOWEST = 0.85
"""Mean speed of a front over c_t from which the end time follows: every front is faster, so that
all of them reach the farthest point."""
_MARGIN = 4.0
"""Distance [L_c] that waves of the neighbouring period keep from the farthest point."""


def rupture(strength: float, half_length: float) -> Scene:
    """Return the interface of a rupture of strength S on a period of two half-lengths [L_c].

    Stress drop, c_t and L_c are 1.  The pressure in the nucleus, and with it the strength, is taken
    off behind a front at 0.3 c_t.
    """

    def nucleus(x: Array, t: float) -> Array:
        return np.where(np.abs(x) < min(NUCLEATION_SPEED * t, NUCLEUS), _REST - 1, 0.0)

    distance = math.pi * (1 - SOLID.poisson_ratio) / (1 + strength)
    return scene_along(
        SOLID,
        SlipWeakening(static=1 + strength, dynamic=0.0, distance=distance),
        2 * half_length,
        pressure=1.0,
        shear=1.0,
        loads=[InterfaceLoad(pressure=nucleus, history=None)],
        even=True,
    )


def onsets(strength: float, nodes: int, farthest: float) -> tuple[Array, Array]:
    """Return positions x >= 0 [L_c] and the times at which slip begins there [L_c / c_t].

    There are so many `nodes` per L_c.  The march ends when slip reaches the farthest position
    [L_c]; where it has not begun, the time is inf.
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


def rupture_rows(strength: float, nodes: int, farthest: float, count: int) -> list[Row]:
    """Follow a rupture; return its style and speed over c_t in cells of equal length [L_c]."""
    begun = onsets(strength, nodes, farthest)
    change, cell = transition(*front_speeds(*begun)), farthest / count
    x, speeds = front_speeds(*begun, cell)
    return [
        {
            "strength": strength,
            "distance": distance,
            "speed": float(speeds[np.argmin(np.abs(x - distance))]),
            "style": SUPERSHEAR if distance >= change else SUB_RAYLEIGH,
            "transition": change,
        }
        for distance in (cell * (np.arange(count) + 0.5)).tolist()
    ]


def map_points(quick: bool) -> list[Point]:
    """Return one rupture for each S, the longest, at high S, first."""
    nodes, farthest, count = (8, 12.0, 4) if quick else (16, 100.0, 12)
    strengths = np.linspace(*STRENGTHS, count).tolist()[::-1]
    return [(strength, nodes, farthest, count) for strength in strengths]


def transition_row(strength: float, farthest: float, coarse: int, fine: int) -> Row:
    """Return the transition [L_c] of a rupture on two grids, given by their nodes per L_c."""
    found = [transition(*front_speeds(*onsets(strength, n, farthest))) for n in (coarse, fine)]
    row = dict(zip(("strength", "coarse", "fine"), (strength, *found), strict=True))
    return row | {"difference": abs(found[0] / found[1] - 1)}


def rupture_figure(rows: list[Row]) -> Figure:
    """Draw the speed of rupture fronts over S and distance, with the transition as a curve."""
    words = "Speed of spontaneous ruptures under linear slip weakening"
    mapped = {
        "x": "strength",
        "y": "distance",
        "value": "speed",
        "label": "speed of the front / $c_t$",
        "style": {"vmin": 0.5, "vmax": 1.75, "cmap": "viridis", "shading": "gouraud"},
        "xlabel": "$S$ = (peak strength $-$ shear) / (shear $-$ dynamic strength)",
        "ylabel": "distance from the centre / $L_c$",
    }
    figure = drawn(rows, [mapped], f"{words} (in-plane, ν = 1/4)")
    panel = figure.axes[0]
    changes = sorted({(row["strength"], row["transition"]) for row in rows})
    style: dict[str, Any] = {"color": BLACK, "ms": 3, "path_effects": outline()}
    panel.plot(*zip(*changes, strict=True), "o-", label="overtakes shear waves", **style)
    for text, place in ((SUPERSHEAR, (0.28, 0.75)), (SUB_RAYLEIGH, (0.8, 0.15))):
        where: dict[str, Any] = {"transform": panel.transAxes, "ha": "center", "fontsize": SMALL}
        panel.text(*place, text, path_effects=outline(), **where)
    panel.legend(loc="upper right", fontsize=SMALL)
    return figure


STUDIES = [
    Study("supershear", map_points, rupture_rows, figures={"supershear": rupture_figure}),
    Study(
        "supershear-transitions",
        lambda quick: [(*entry, *((16, 32) if quick else (32, 64))) for entry in DISTANCES.items()],
        transition_row,
    ),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.supershear", STUDIES))
