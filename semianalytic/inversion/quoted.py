"""Front speed, stress drop, fracture energy and S of a rupture, as laboratories quote them.

At one place, with the shear traction tau_0 before loads, its peak tau_p, and its least value tau_r
after the peak, all in the sense of slip delta:

    stress drop = tau_0 - tau_r,
    fracture energy = integral of (tau - tau_r) d delta from the peak until tau_r,
    S = (tau_p - tau_0) / (tau_0 - tau_r).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from semianalytic.inversion.trials import FINER_SAFETY, Trials
from semianalytic.inversion.unknowns import Setup
from semianalytic.results.reading import Measured
from semianalytic.scene.arrays import Array
from semianalytic.scene.laws.sampling import sampled

PLACES = 5
"""Places between the outermost gauges at which a rupture is described."""
QUOTED = {
    "front_speed": "length / time",
    "stress_drop": "stress",
    "fracture_energy": "stress length",
    "strength_ratio": "1",
}
"""Names of what is quoted, and dimensions."""


@dataclass(frozen=True, eq=False)
class Quoted:
    """Front speed, stress drop, fracture energy and S of a rupture, at places along the contact.

    Values have standard errors: the covariance of the fitted values, propagated by differences of
    solutions, and the error of the grid.  They are nan where nothing slips, stress drop and S also
    where the stress does not drop, and fracture energy where the strength does not fall.

    Attributes
    ----------
    x : (k,) array
        Places between the outermost gauges [length].
    front_speed : Measured
        Speed at which the slip front passes the places, (k,) [length / time].
    stress_drop : Measured
        Shear traction before loads less the least one after its peak, (k,) [stress].
    fracture_energy : Measured
        Work of slip in excess of that least traction until it is reached, (k,) [stress length].
    strength_ratio : Measured
        S, the excess of the peak over the traction before loads, over the stress drop, (k,).
    """

    x: Array
    front_speed: Measured
    stress_drop: Measured
    fracture_energy: Measured
    strength_ratio: Measured


def quoted(trials: Trials, answer: Any, setup: Setup, deviations: Callable[..., Array]) -> Quoted:
    """Return what is quoted of the answer of a fit.

    `deviations` returns the standard deviations (n,) that derivatives (n, p) with respect to the
    unknowns over their sizes make.
    """
    x = np.unique(trials.samples.places[0]) - setup.x0
    x = np.linspace(x[0], x[-1], PLACES) if len(x) > 1 else x
    x = x[answer.scene.contact.touches(x)]
    values = _numbers(trials, answer, x)
    errors = deviations(trials.slopes(answer, setup, lambda near: _numbers(trials, near, x)))
    finer = trials.finer(answer)
    if finer is not None:
        apart = np.abs(_numbers(trials, finer, x) - values).reshape(-1, len(x))
        # at one place the two grids may agree by chance
        largest = np.fmax.reduce(apart, axis=1, initial=0.0)
        errors = np.hypot(errors, FINER_SAFETY * np.repeat(largest, len(x)))
    # what a neighbouring solution lacks may be anywhere
    errors[np.isnan(errors) & np.isfinite(values)] = np.inf
    rows = zip(values.reshape(-1, len(x)), errors.reshape(-1, len(x)), strict=True)
    return Quoted(x, *(Measured(value, error) for value, error in rows))


def _numbers(trials: Trials, answer: Any, x: Array) -> Array:
    """Return what is quoted at places x (k,), one after another, (4 k,)."""
    slip, shear = trials.passage(answer, x)
    # in the sense of slip
    sense = np.where(slip[-1] < 0, -1.0, 1.0)
    slip, shear, before = (
        sense * slip,
        sense * shear,
        sense * sampled("", answer.scene.base.shear, x),
    )
    place, level = np.arange(len(x)), np.arange(len(shear))[:, None]
    peak = shear.argmax(axis=0)
    least = np.where(level >= peak, shear, np.inf).argmin(axis=0)
    residual = shear[least, place]
    excess = (shear[1:] + shear[:-1]) / 2 - residual
    falls = (level >= peak) & (level < least)
    energy = np.sum(np.where(falls[:-1], excess * np.diff(slip, axis=0), 0.0), axis=0)
    drop, speed, law = before - residual, answer.front_speed(x), answer.scene.law
    drop = np.where(drop > 0, drop, np.nan)
    pressure = sampled("", answer.scene.base.pressure, x)
    if law.steady_slope() is not None and not law.weakening(pressure):
        energy[:] = np.nan  # the peak above constant friction is one of rounding
    ratio = (shear[peak, place] - before) / drop
    found = np.stack([np.where(np.isfinite(speed), speed, np.nan), drop, energy, ratio])
    return np.where(slip.any(axis=0), found, np.nan).ravel()
