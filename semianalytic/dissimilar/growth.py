"""Find waves that grow while two half-planes slide on one another (Adams 1995).

Uniform sliding of sense s under friction s f p lets waves exp(lambda t + i q x) run along the
interface, lambda = i q / k, with

    Phi(k) = A(k) + s f k D(k) = 0,    Im k > 0,

so that their growth rate is proportional to wave number: waves grow however short they are, and
faster on a finer grid.  The number of such waves follows from the phase of Phi along the cut;
Newton's method is repeated until that many are found.

Where friction follows pressure with a delay t*, d(sigma')/dt = (sigma - sigma') / t*, f is divided
by 1 + lambda t* (Prakash and Clifton, simplified).  Growth is then bounded.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from semianalytic.dissimilar.compliance import Complex, Compliance, Entries
from semianalytic.dissimilar.phase import CutPhase
from semianalytic.dissimilar.stretch import Stretch, stretches
from semianalytic.scene.errors import ComputationError

_REACH, _STEP = 36.0, 0.75
"""Largest |Re x| of the starts of Newton's method, and their spacing: exp(-36) is rounding."""
# -Im x: waves close to the cut are found from 0.02, all others from 0.3 or 1.2.
_STARTS = np.ravel(
    np.arange(-_REACH, _REACH + _STEP / 2, _STEP)[:, None] - 1j * np.array((0.02, 0.3, 1.2))
)
_DIFFERENCE, _ROUNDING = 1e-6, 1e-10
"""Difference in x for a derivative, and the step over |x| + 1 that ends the iteration."""
_LARGEST_EXPONENT = math.log(sys.float_info.max)
_LEAST_HEIGHT = 1e-8
"""Nearer roots run into the real axis of k, where waves neither grow nor decay."""


@dataclass(frozen=True)
class GrowingWave:
    """A wave exp(i q (x + t / k)), Im k > 0, that grows along the interface, over upper c_t."""

    slowness: complex

    @property
    def growth(self) -> float:
        """Growth rate over wave number, Re lambda / q, in units of c_t of the upper body."""
        return (1j / self.slowness).real

    @property
    def velocity(self) -> float:
        """Velocity of the crests, positive towards +x, in units of c_t of the upper body."""
        return -(1 / self.slowness).real

    @property
    def per_wavelength(self) -> float:
        """Logarithm of the growth while the wave runs one wavelength, at most that of a number."""
        return min(2 * np.pi * self.growth / abs(self.velocity), _LARGEST_EXPONENT)


@lru_cache(maxsize=64)
def growing_waves(
    compliance: Compliance, friction: float, delay: float = 0.0
) -> tuple[GrowingWave, ...]:
    """Return all waves that grow while the interface slides, the fastest growing first.

    Results are cached, as each run of the same bodies asks for them anew.

    `friction` is s f, the friction coefficient, negative where the upper body slides towards -x;
    `delay` is q c_t t*, the time in which friction follows pressure over that in which a shear wave
    of the upper body runs a wavelength over 2 pi.  Raises ComputationError if fewer waves are found
    than there are.
    """
    right = _right_going(compliance, friction, delay)
    # A root k of one direction is -conj(k) of the other under friction of the other sign.
    left = [-k.conjugate() for k in _right_going(compliance, -friction, delay)]
    waves = [GrowingWave(k) for k in (*right, *left)]
    return tuple(sorted(waves, key=lambda wave: -wave.growth))


def count_growing(compliance: Compliance, friction: float, delay: float = 0.0) -> int:
    """Count the growing waves that run towards +x; with -s f for s f, those towards -x.

    The principle of the argument is applied to Phi R_1 R_2 on the quarter Re k < 0 < Im k, where
    this function behaves like k^3 at infinity.  The number is (phase on the positive imaginary
    axis + 3 pi / 2 - phase on the cut) / (2 pi).
    """
    phase = CutPhase(compliance, lambda entries: symbol(entries, friction, delay))
    # k D / A tends to i beta, so that Phi / A tends to 1 + i s f beta.
    ahead = np.arctan(friction * compliance.dundurs)
    turns = (ahead + 1.5 * np.pi - phase.limit) / (2 * np.pi)
    count = round(turns)
    # A zero on the cut itself, as at a threshold, leaves half a turn undecided.
    if abs(turns - count) > 0.05:
        raise ComputationError(
            f"the number of growing waves is {turns:.3f}, not an integer; change the friction "
            "coefficient or a modulus a little."
        )
    return count


def symbol(entries: Entries, friction: float, delay: float) -> Complex:
    """Return Phi R_1 R_2 with f / (1 + lambda t*) in place of f."""
    if not delay:
        return entries.frictional(friction)
    # lambda t* = i q t* / k, so that 1 / (1 + lambda t*) = k / (k + i q t*).
    k = entries.slowness
    return entries.frictional(friction * k / (k + 1j * delay))


def _right_going(compliance: Compliance, friction: float, delay: float) -> list[complex]:
    """Return the slownesses of the growing waves that run towards +x."""
    if not friction or compliance.is_alike:
        return []
    count = count_growing(compliance, friction, delay)
    roots: list[complex] = []
    if not count:
        return []
    for k in _newton(compliance, friction, delay):
        if not any(abs(k - other) < 1e-6 * abs(k) for other in roots):  # they are the same root
            roots.append(k)
        if len(roots) == count:
            return roots
    raise ComputationError(
        f"{count} growing waves run along the interface, of which {len(roots)} were found; change "
        "the friction coefficient or a modulus a little."
    )


def _newton(compliance: Compliance, friction: float, delay: float) -> Iterator[complex]:
    """Yield zeros of Phi in the quarter Re k < 0 < Im k as they settle, some more than once.

    Steps are in x of a stretch, at most half of the way out of the half-plane, and all stretches
    step together: zeros settle within ten steps, while hundreds of starts never do.
    """
    moving = {
        stretch: (_STARTS, np.zeros(_STARTS.shape, dtype=bool))
        for stretch in stretches(compliance.distinct_fronts)
    }
    for _ in range(40):
        for stretch, (x, rested) in moving.items():
            beside = np.concatenate([x, x - _DIFFERENCE, x + _DIFFERENCE])
            value, before, after = np.split(_on(compliance, stretch, beside, friction, delay), 3)
            # By differences: the symbol has no closed derivative that would not cancel near a
            # front.
            slope = (after - before) / (2 * _DIFFERENCE)
            step = -value / np.where(slope, slope, np.inf)
            settled = np.abs(step) < _ROUNDING * (1 + np.abs(x))
            room = np.minimum(-x.imag, np.pi + x.imag) / 2
            x = x + step * np.minimum(1.0, room / np.maximum(np.abs(step), _ROUNDING))
            inside = (x.imag < -_LEAST_HEIGHT) & (x.imag > _LEAST_HEIGHT - np.pi)
            inside &= np.abs(x.real) < 2 * _REACH
            # The second short step takes off what the first one leaves.
            ended = settled & rested
            moving[stretch] = x[inside & ~ended], settled[inside & ~ended]
            points = stretch.at(x[inside & ended])
            off = np.minimum(np.abs(points.from_left), np.abs(points.to_right))
            # Steps come to rest on wave fronts as well, where Phi is as small as rounding.
            # In 5 of 430 random pairs and frictions they ended within 1e-17 of one.
            yield from (complex(-k) for k in points.v[off > 1e-14 * np.abs(points.v)] if k.real > 0)


def _on(
    compliance: Compliance, stretch: Stretch, x: Complex, friction: float, delay: float
) -> Complex:
    points = stretch.at(x)
    entries = compliance.on_cut(points.v, stretch.minus(points, compliance.fronts))
    return symbol(entries, friction, delay)
