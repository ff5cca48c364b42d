"""Zone edges between frictions at which they are known, by polynomials, and what they are worth."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.edges import Edges
from semianalytic.rayleigh import Array
from semianalytic.scene import Scene
from semianalytic.solver import (
    SAFETY,
    edge_shift,
    scaled_load,
)

_CONVERGING = 0.5  # differences that shrink less are no estimate
_DOUBT = 5.0  # true errors were up to three times the plain estimate beside thresholds


def fits(edges: Edges, scene: Scene) -> bool:
    """Whether zones are open ahead of all waves only where friction is reached there."""
    critical = scaled_load(scene)[0].critical
    return critical if edges.open_ends[0] else not scene.far_slip_rate


def lagrange(at: Array, to: ArrayLike) -> Array:
    """Weights (..., m) of values at different places `at` (m,) in the polynomial through them,
    at places `to` (...)."""
    own = np.eye(len(at), dtype=bool)
    others = np.where(own, 1.0, np.asarray(to, dtype=float)[..., None, None] - at)
    return np.asarray(np.prod(others / (at[:, None] - at + own), axis=-1))


def interpolated(
    edges: Edges,
    at: Array,
    loose_at: Array,
    corrections: Array,
    to: Array,
    loose_to: Array,
    estimates: Array,
) -> tuple[Array, Array]:
    """Unknowns (t, e) at frictions `to`, and their error estimates (t,).

    From those on the loose rule (t, e) and the corrections (m, e) of those (m, e) at frictions
    `at`, the most central first.  Estimated from the polynomials without the last and the last
    but one: from the first difference if it is well below the second, else from the larger.  The
    estimates (m,) of the known add to it: the larger of the two nearest ones, or all as the
    interpolation amplifies them less the safety they contain.  Of polynomials in friction and in
    the edge that moves most, which are smoother near thresholds, the better is taken.
    """
    if not edges.segments:
        return loose_to, np.full(len(to), estimates.max())
    best, least = loose_to, np.full(len(to), np.inf)
    which = int(np.argmax(np.ptp(loose_at, axis=0)))
    order = np.argsort(at)
    steps = np.diff(loose_at[order, which])
    places = [(at, to)]
    if np.all(steps > 0) or np.all(steps < 0):
        places.append((loose_at[:, which], loose_to[:, which]))
    for here, there in places:
        full, fewer, fewest = (
            loose_to + lagrange(here[:m], there) @ corrections[:m]
            for m in (len(at), len(at) - 1, len(at) - 2)
        )
        both = _apart(edges, np.concatenate([full, fewer]), np.concatenate([fewer, fewest]))
        first, second = np.split(both, 2)
        doubt = _DOUBT * np.where(first < _CONVERGING * second, first, np.maximum(first, second))
        amplified = np.abs(lagrange(here, there)) @ estimates / SAFETY
        doubt += np.maximum(estimates[:2].max(), amplified)
        better = doubt < least
        best = np.where(better[:, None], full, best)
        least = np.where(better, doubt, least)
    return best, least


def _apart(edges: Edges, one: Array, other: Array) -> Array:
    """(t,): how far two interpolations (t, e) are apart, for an error estimate."""
    shift = SAFETY * edge_shift(edges, one.T, other.T)
    return np.maximum(shift, np.abs(one - other).max(axis=1))
