"""The edge of slip ahead of an over-stressed half-line of a closed interface of two bodies.

Of slip V and its traction F = tau + s f sigma only F = -K W is left without a slot, with K =
(A + s f k D) / (A B + k^2 D^2): F is real on the cut where the interface slips, and F / K where it
sticks.  So all follows from the phase theta of K on k = -v + i0, and slip that spreads over x > 0
from x < 0, where it begins at once, ends at the slowness u at which the integral
(1/pi) int^u theta(w) dw / w is ln(1 + chi) (docs/dissimilar.md, "Without a slot").
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from semianalytic.dissimilar.compliance import Compliance
from semianalytic.dissimilar.phase import SlipPhase, slip_phase
from semianalytic.dissimilar.stretch import Stretch, stretches
from semianalytic.halfplane.polynomials import gauss
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

_REACH, _PIECE = 36.0, 1.5
"""Largest |x| on a stretch, and length of pieces: half changes no digit of docs/dissimilar.md."""


def phase_rule(phase: SlipPhase, stop: float) -> tuple[Array, Array, Array]:
    """Return slownesses w from the first wave to `stop`, theta dw with weights, and `stop` - w."""
    sharp = {*phase.numerator.sharp_turns, *phase.denominator.sharp_turns}
    t, weight = gauss(12)
    parts = []
    for whole in stretches(phase.numerator.compliance.distinct_fronts):
        if whole.left >= stop:
            break
        cut = whole.right is None or stop < whole.right
        stretch = Stretch(whole.left, stop) if cut else whole
        ends = _pieces(stretch, sorted(sharp))
        x = (ends[:-1, None] + np.diff(ends)[:, None] * t).ravel()
        at = stretch.at(x)
        beyond = whole.left if whole.right is None else whole.right - at.v
        # The phase knows whole stretches only: the coordinate of the same points on the whole one.
        there = np.log(at.from_left / beyond) if cut else x
        dx = (np.diff(ends)[:, None] * weight).ravel() * np.asarray(stretch.slope(at))
        parts.append((at.v, dx * phase.on(whole, there), at.to_right if cut else stop - at.v))
    if not parts:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    points, weights, distances = zip(*parts, strict=True)
    return np.concatenate(points), np.concatenate(weights), np.concatenate(distances)


def _pieces(stretch: Stretch, sharp: list[float]) -> Array:
    """Return the ends of pieces of a stretch in x, which are shorter about hidden zeros."""
    # Pieces reach twice as far towards an edge, where the rest is a root of the distance.
    ends = np.arange(-_REACH, 2 * _REACH + _PIECE, _PIECE)
    for v in sharp:
        if stretch.left < v and (stretch.right is None or v < stretch.right):
            near = stretch.coordinate(v) + np.linspace(-3.0, 3.0, int(48 / _PIECE) + 1)
            ends = np.concatenate([ends, near[np.abs(near) < _REACH]])
    return np.unique(ends)


def half_line_speed(compliance: Compliance, friction: float, ratio: float) -> float:
    """Return the speed of the edge of slip over c_t of the upper body; refuse if there is none.

    Friction is s f, with the sense of slip, and the ratio chi >= 0 the stress below friction on
    x > 0 over the excess above friction on x < 0.
    """
    phase = slip_phase(compliance, friction)
    if not phase.is_regular(friction):
        raise SceneError(f"friction {abs(friction):.4g} lets waves grow that run ahead of slip.")
    last = phase.numerator.table[-1]
    behind = np.flatnonzero(phase.on(last.stretch, last.x) <= 0)
    # No edge of slip is faster than the slowness beyond which theta is positive.
    first = last.x[behind[-1] + 1] if len(behind) else last.x[0]
    front = Stretch(float(last.stretch.at(np.array([first])).v[0]), None)

    def slowness(x: float) -> float:
        return float(front.at(np.array([x])).v[0])

    def excess(x: float) -> float:
        w, weight, _ = phase_rule(phase, slowness(x))
        return float(weight @ (1 / w) / np.pi) - float(np.log1p(ratio))

    ends = -_REACH, float(np.log(1e8))  # no edge is looked for below 1e-8 of the wave speeds
    if excess(ends[0]) * excess(ends[1]) > 0:
        raise SceneError("no edge of slip is slower than all waves; let more be missing to slip.")
    return 1 / slowness(brentq(excess, *ends, xtol=1e-13))


def half_line_exponent(compliance: Compliance, friction: float, speed: float) -> float:
    """Return the exponent 1 - theta / pi of slip rate at an edge of slip of a given speed."""
    return 1 - slip_phase(compliance, friction).at(1 / speed) / np.pi
