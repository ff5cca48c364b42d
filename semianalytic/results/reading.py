"""Readings at points of the contact: arrival times, slip and tractions, each with an error bar.

An exact self-similar answer and an answer that was sampled on a grid know their errors in different
ways; `Reading` is the table that both return.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.answer import ARRIVALS, FIELDS
from semianalytic.results.intervals import contact_positions, line_positions
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.scene import Scene

SAMPLED_SAFETY = 1.6
"""Bar over the companion's difference: it holds 99.9 % of 37 marches, 99.7 % of 12 simulations."""
_STENCIL = (-2, -1, 0, 1, 2)
"""Node distances of the companion at which it is compared: where curves cross nothing differs."""
_MEAN = 50
"""Places and times of the mean difference: without it bars hold 96.5 % of the values of slip."""

_DRIVEN = ("slip", "slip_rate", "shear_traction")
"""Fields that follow from friction, which openings that neither grid shows take off."""


class Measured(NamedTuple):
    """A value and its error bar, arrays of one shape and unit.

    The bar is meant as a bound; it is inf where nothing is known about the error.

    Examples
    --------
    >>> from semianalytic.results.reading import Measured
    >>> Measured(value=2.0, error=0.1)
    Measured(value=2.0, error=0.1)
    """

    value: Array
    error: Array


@dataclass(frozen=True, eq=False)
class Reading:
    """Arrival times and fields of an answer at points of the contact, each with its error.

    The method `reading` of an answer returns it.  Positions and times are broadcast.

    Attributes
    ----------
    x, t : arrays
        Positions [length] and times [time].
    arrivals : dict of str to Measured
        First times [time] of "slip", of slip in the sense "forward" (+1) and "reverse" (-1), and of
        "opening", inf where there is none; see `Solution.arrival`.
    slip, slip_rate, shear_traction, pressure, gap : Measured
        Fields at x and t, as the methods of these names return them.
    status : str
        The status of the answer.

    Examples
    --------
    >>> from semianalytic import solve
    >>> reading = solve("preloaded").reading(x=0.5, t=1.0)
    >>> when, error = reading.arrivals["slip"]
    >>> when.round(4), bool(0 < error < 1e-7)
    (np.float64(0.4711), True)
    >>> reading.slip.value.round(4), bool(0 < reading.slip.error < 1e-7)
    (np.float64(0.1673), True)
    """

    x: Array
    t: Array
    arrivals: Mapping[str, Measured]
    slip: Measured
    slip_rate: Measured
    shear_traction: Measured
    pressure: Measured
    gap: Measured
    status: str


def first_times(x: ArrayLike, zones: Iterable[Any]) -> Array:
    """Return when the first of zones inner t < x < outer t comes to positions x [time].

    It is x over the largest speed of an outer edge: inf without a zone, 0 where slip is ahead of
    all waves.
    """
    x = contact_positions(x)
    fastest = max((zone.outer for zone in zones), default=0.0)
    if fastest == 0:
        return np.full(x.shape, np.inf)
    return np.asarray(x / fastest)


def self_similar_reading(
    answer: Any, x: ArrayLike, t: ArrayLike, speed: float, scales: Mapping[str, Any]
) -> Reading:
    """Return the reading of an exact answer at x and t, which broadcast.

    Edges are known up to `error_estimate` times a wave speed [length / time].  A field may be wrong
    by that share of its scale, besides itself, and by what it changes by if all edges are shifted
    so far: a square root near an edge is then as uncertain as the place of the edge makes it, and
    so is the logarithm at c_R.  Scales are those of each of `FIELDS`, and broadcast with t.
    """
    x, t = np.broadcast_arrays(contact_positions(x), np.asarray(t, dtype=float))
    # an answer that broke the law may be wrong anywhere; one above its rtol has an estimate still
    known = answer.status == "converged" or answer.status.startswith("the error estimate")
    share = answer.error_estimate if known else math.inf
    shift = share * speed
    arrivals = {of: _arrival(answer, x, of, shift) for of in ARRIVALS}
    fields = {}
    for name in FIELDS:
        field = getattr(answer, name)
        value = np.asarray(field(x, t))
        if not math.isfinite(share):
            fields[name] = Measured(value, np.full(value.shape, np.inf))
            continue
        moved = shift * np.maximum(t, 0.0)
        change = np.zeros(value.shape)
        with np.errstate(invalid="ignore"):
            for sign in (-1, 1):
                # However large the error of an edge, the point stays on the contact.
                beside = np.asarray(field(np.maximum(x + sign * moved, x / 2), t))
                # At c_R both may be infinite; `fmax` passes over the difference, which is no
                # number.
                change = np.fmax(change, np.abs(beside - value))
            error = share * (np.abs(value) + scales[name]) + change
        at_rest = t < 0
        error = np.where(np.isnan(error), np.inf, error)
        fields[name] = Measured(value, np.where(at_rest, 0.0, error))
    return Reading(x, t, arrivals, status=answer.status, **fields)


def _arrival(answer: Any, x: Array, of: str, shift: float) -> Measured:
    """Return when an edge comes that may be slower or faster by a shift [length / time]."""
    when = answer.arrival(x, of)
    comes = np.isfinite(when) & (when > 0)
    edge = np.divide(x, when, out=np.full(x.shape, np.inf), where=comes)
    # An edge that is slower than its own error may never come: there is no latest time.
    bounded = edge > shift
    slowest = np.where(bounded & comes, edge, 1.0) - (shift if math.isfinite(shift) else 0.0)
    # x / speed is convex: being late is the larger of the two errors.
    late = np.divide(x, slowest, out=np.full(x.shape, np.inf), where=bounded)
    return Measured(when, np.where(comes, late - np.where(comes, when, 0.0), 0.0))


def sampled_reading(answer: Any, x: ArrayLike, t: ArrayLike) -> Reading:
    """Return the reading of an answer on a grid; `SampledAnswer.reading` describes its bars.

    At the front of a wave and at the edge of a slip zone a bar is no less than what the field
    changes by within two nodes of the companion.
    """
    x, t = np.broadcast_arrays(line_positions(x), np.asarray(t, dtype=float))
    arrivals = {of: _sampled_arrival(answer, x, of) for of in ARRIVALS}
    steep = _steep(answer, x, t)
    fields = {name: _sampled_field(answer, name, x, t, steep) for name in FIELDS}
    return Reading(x, t, arrivals, status=answer.status, **fields)


def _around(answer: Any, x: Array) -> tuple[list[Array], float]:
    """Return the places that count around x, and the node distance of the companion."""
    nodes = answer.companion.interface.x
    step = float(nodes[1] - nodes[0]) if len(nodes) > 1 else float(nodes[0])
    # Near either end the stencil is folded onto the contact that both answers know.
    low, high = answer._known_around(x, step)
    return [np.clip(x + k * step, low, high) for k in _STENCIL], step


def _sampled_arrival(answer: Any, x: Array, of: str) -> Measured:
    when, coarse = answer.arrival(x, of), answer.companion
    if coarse is None:
        return Measured(when, np.full(x.shape, np.inf))
    places, step = _around(answer, x)
    error = np.zeros(x.shape)
    for place in places:
        here, there = answer.arrival(place, of), coarse.arrival(place, of)
        both = np.isfinite(here) & np.isfinite(there)
        apart = np.where(both, np.abs(np.where(both, here, 0.0) - np.where(both, there, 0.0)), 0.0)
        error = np.maximum(error, apart)
    first = answer.first_motion(x, of)
    comes, sooner = np.isfinite(when), np.isfinite(first)
    early = np.where(comes & sooner, np.where(comes, when, 0.0) - np.where(sooner, first, 0.0), 0.0)
    error = SAMPLED_SAFETY * error + step / answer.scene.material.shear_speed + np.maximum(early, 0)
    # one that the other never sees, or a motion too slow to count, leaves the time open
    open_ = (comes != np.isfinite(coarse.arrival(x, of))) | (sooner & ~comes)
    return Measured(when, np.where(open_, np.inf, np.where(comes, error, 0.0)))


def _sampled_field(answer: Any, name: str, x: Array, t: Array, steep: Mask) -> Measured:
    field, coarse = getattr(answer, name), answer.companion
    value = np.asarray(field(x, t))
    if coarse is None:
        return Measured(value, np.full(value.shape, np.inf))
    other = getattr(coarse, name)

    def apart(x: Array, t: Array) -> Array:
        return np.abs(np.asarray(field(x, t) - other(x, t)))

    places, step = _around(answer, x)
    lag, end = step / answer.scene.material.shear_speed, min(answer.end_time, coarse.end_time)
    first = max(float(answer.interface.t[0]), 0.0)
    error = np.zeros(value.shape)
    for place in places:
        for k in _STENCIL:
            error = np.maximum(error, apart(place, np.clip(t + k * lag, np.minimum(t, first), end)))
    # where both stick there is slip that neither shows, hence the mean over the contact until then
    until, nodes = min(float(t.max(initial=0.0)), end), answer._moved
    nodes = nodes[:: max(1, len(nodes) // _MEAN)]
    mean = 0.0
    if until > first and len(nodes):
        times = first + (until - first) * np.arange(1, _MEAN + 1) / _MEAN
        mean = float(apart(nodes, times[:, None]).mean())
    error = SAMPLED_SAFETY * np.maximum(error, mean)
    if steep.any():
        near = np.array([np.asarray(field(place, t)) for place in places])
        error = np.where(steep, np.fmax(error, np.ptp(near, axis=0)), error)
    if name in _DRIVEN and answer._hidden:
        # slip of a force at an edge is larger there than its mean, like the logarithm of c_t t / x
        largest = float(np.abs(getattr(answer.interface, name)).max())
        error = error + 4.0 * answer._hidden * largest
    return Measured(value, np.where(t < 0, 0.0, error))


def _steep(answer: Any, x: Array, t: Array) -> Mask:
    """Return where fields of an answer with a companion are steeper than a grid resolves."""
    if answer.companion is None:
        return np.zeros(x.shape, dtype=bool)
    places, step = _around(answer, x)
    fronts = np.zeros(x.shape, dtype=bool)
    if not answer.scene.on_line:  # a slot, whose waves come from its edge at x = 0
        fronts = _on_front(answer.scene, x, t, 2 * step)
    return fronts | _at_edge(answer, places, t)


def _at_edge(answer: Any, places: Iterable[Array], t: Array) -> Mask:
    """Return where the edge of a slip zone, with a root of traction, is among places."""
    slips = [np.asarray(answer.slip_rate(place, t)) != 0 for place in places]
    return np.asarray(np.any(slips, axis=0) & ~np.all(slips, axis=0))


def _on_front(scene: Scene, x: Array, t: Array, width: float) -> Mask:
    """Return where a wave from the tip has its front within a width [length].

    A grid rounds off a cusp or jump: the difference from the companion is a part of the error only.
    """
    begins = {
        0.0,
        *(at for history in scene.acting_histories.values() for at in history.pieces.breaks),
    }
    material = scene.material
    speeds = (material.shear_speed, material.longitudinal_speed)
    found = np.zeros(np.shape(x), dtype=bool)
    for speed, begin in itertools.product(speeds, begins):
        found |= (t > begin) & (np.abs(x - speed * (t - begin)) <= width)
    return found
