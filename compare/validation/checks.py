"""Whether records make sense by themselves, whatever the exact answer is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from compare.comparison.scales import slip_rate_scale
from compare.records.record import Array, Record, Records
from compare.validation.norms import weights
from semianalytic import Scene

SLIDES = 0.05
"""Part of the largest slip rate of a station above which it slides."""
MOVES = 1e-3
"""Over V_0, slip rate below which nothing slides: rounding leaves nine powers of ten less."""
ODD = 0.3
"""Part of the time for which friction may drive slip, or pressure pull, before records make no
sense.

Right runs of UGUCA and SEM2DPACK do for 0.16 of it at most (`remote-shock` on 40 cells, where slip
rate is noisy), all others for 0.09; a reading with the wrong sense does for all of it."""
PULL = 0.02
"""Tension over the largest pressure that is too small to count."""
APART = 1.4
"""Factor between slip and its rate, integrated, beyond which they do not belong together.

Readings differ by two at least.  Right runs of the codes above are within 1.01."""


def nonsense(run: Records, scene: Scene) -> tuple[str, ...]:
    """Faults that no right record of a contact with friction has, in words; none if all is well.

    Parameters
    ----------
    run : Records
        In units and conventions of the scene.
    scene : Scene
    """
    return tuple(_nonsense(run, scene))


def _nonsense(run: Records, scene: Scene) -> Iterator[str]:
    least = MOVES * slip_rate_scale(scene)
    ratio = rate_ratio(run, least)
    if ratio is not None and not 1 / APART < ratio < APART:
        yield f"slip is {ratio:.3g} times the integral of slip rate"
    driven = driven_share(run, least)
    if scene.friction and driven is not None and driven > ODD:
        yield f"friction drives slip for {100 * driven:.0f} % of the time in which it slides"
    pulled = pulled_share(run)
    if pulled is not None and pulled > ODD:
        yield f"pressure is negative for {100 * pulled:.0f} % of the time"


def rate_ratio(run: Records, least: float) -> float | None:
    """Slip over the integral of slip rate, by least squares over all stations.

    None without both, and where nothing slips faster than `least` [length / time].
    """
    products, squares = 0.0, 0.0
    for record in run.stations:
        pair = integrated(record)
        if pair is not None and np.nanmax(np.abs(record.values["slip_rate"])) > least:
            slip, integral = pair
            products += float(slip @ integral)
            squares += float(integral @ integral)
    return products / squares if squares > 0 else None


def integrated(record: Record) -> tuple[Array, Array] | None:
    """Slip (n,) since the first sample and the integral of slip rate, both [length]; None without
    both, or where more than gaps are missing."""
    if not {"slip", "slip_rate"} <= set(record.values):
        return None
    slip, rate = record.values["slip"], record.values["slip_rate"]
    known = np.isfinite(slip) & np.isfinite(rate)
    if known.sum() < 2:
        return None
    t, slip, rate = record.t[known], slip[known], rate[known]
    steps = np.diff(t) * 0.5 * (rate[1:] + rate[:-1])
    return slip - slip[0], np.append(0.0, np.cumsum(steps))


def driven_share(run: Records, least: float) -> float | None:
    """Part of the time of sliding for which shear traction has the sense against slip rate.

    None where nothing slides faster than `least` [length / time], or one of the two was not
    recorded.
    """
    odd, whole = 0.0, 0.0
    for record in run.stations:
        if not {"slip_rate", "shear_traction"} <= set(record.values):
            continue
        rate, traction = record.values["slip_rate"], record.values["shear_traction"]
        weight = weights(record.t, rate + traction)
        if weight.any():
            peak = np.abs(np.where(weight > 0, rate, 0.0)).max()
            slides = (weight > 0) & (np.abs(rate) > max(SLIDES * peak, least))
            odd += float(weight[slides & (rate * traction < 0)].sum())
            whole += float(weight[slides].sum())
    return odd / whole if whole > 0 else None


def pulled_share(run: Records) -> float | None:
    """Part of the time for which the pressure is negative; None where it was not recorded."""
    known = [
        (record.values["pressure"], weights(record.t, record.values["pressure"]))
        for record in run.stations
        if "pressure" in record.values
    ]
    whole = sum(float(weight.sum()) for _, weight in known)
    peak = max((np.nanmax(np.abs(p), initial=0.0) for p, w in known if w.any()), default=0.0)
    if whole == 0:
        return None
    odd = sum(float(w[(w > 0) & (p < -PULL * peak)].sum()) for p, w in known)
    return odd / whole
