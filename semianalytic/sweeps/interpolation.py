"""Interpolation of zone edges between frictions by polynomials, with error estimates."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.load import Load, scaled_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import Array
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.zones.coulomb import admissible
from semianalytic.selfsimilar.zones.edges import Edges, edge_shift, moves
from semianalytic.selfsimilar.zones.tuning import FARTHEST, SAFETY
from semianalytic.sweeps import tuning


def confirmed(
    edges: Edges, unknowns: Array, inverse: Array, load: Load, loose: float
) -> tuple[np.ndarray, int]:
    """Return whether zones of unknowns (e, k) pass on the loose rule, (k,), and its nodes."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        fields = ZoneFields(edges.factors, load, edges.zones(unknowns), rule_for(loose))
        sound = admissible(Profile(fields), tuning.LOOSE_CHECK * loose)
        if edges.segments:
            move = np.abs(moves(inverse, fields.mismatch())).max(axis=0)
            sound = sound & (move < 100 * loose)
    return sound, fields.panels.jacobian[:, 0].size


def fits(edges: Edges, scene: Scene) -> bool:
    """Return whether zones slip ahead of all waves only where friction is reached there."""
    critical = scaled_load(scene)[0].critical
    return critical if edges.open_ends[0] else not scene.far_slip_rate


def lagrange(at: Array, to: ArrayLike) -> Array:
    """Return Lagrange weights (..., m) of values at `at` (m,) for the polynomial at `to` (...)."""
    own = np.eye(len(at), dtype=bool)
    others = np.where(own, 1.0, np.asarray(to, dtype=float)[..., None, None] - at)
    return np.asarray(np.prod(others / (at[:, None] - at + own), axis=-1))


def _in_friction(at: Array, unknowns: Array, to: Array) -> Array:
    """Evaluate the polynomial in friction through unknowns (m, e) at frictions `at`, (t, e)."""
    return lagrange(at, to) @ unknowns


def _in_edge(at: Array, unknowns: Array, to: Array) -> Array:
    """Evaluate polynomials in the unknown that moves most, friction being one of them, (t, e).

    They are smoother near thresholds, where edges move fast; nan if it is not monotone.
    """
    # The stencil comes with the most central friction first; monotony is a matter of the order
    # along the axis.
    order = np.argsort(at)
    which = int(np.argmax(np.ptp(unknowns, axis=0)))
    s = unknowns[:, which]
    steps = np.diff(s[order])
    if not (np.all(steps > 0) or np.all(steps < 0)):
        return np.full((len(to), unknowns.shape[1]), np.nan)
    # A start from linear interpolation, then Newton's method for friction(s) = to with the
    # polynomial friction(s).
    place = np.interp(to, at[order], s[order])
    nudge = 1e-4 * float(np.ptp(s))
    for _ in range(4):  # half: 11 answers change
        beside = np.stack([place, place + nudge, place - nudge])
        # Differences from the central friction keep the digits that the subtraction below needs.
        now, up, down = lagrange(s, beside) @ (at - at[0])
        slope = (up - down) / (2 * nudge)
        place = place - (now - (to - at[0])) / np.where(slope == 0, np.nan, slope)
    return lagrange(s, place) @ unknowns


def interpolated(
    edges: Edges, at: Array, unknowns: Array, to: Array, noise: float, rtol: float
) -> tuple[Array, Array]:
    """Interpolate unknowns (t, e) at frictions `to` from those (m, e) at `at`, most central first.

    Error estimates (t,) are returned with them.  They come from the polynomials without the last
    and the last two values: from the first difference if it is well below the second, else from the
    larger.  The largest estimate `noise` of the known values is added, amplified by the
    interpolation, less the safety it contains.  The better of polynomials in friction and in an
    edge is taken; the second are tried where the first do not reach rtol.
    """
    if not edges.segments:
        return np.zeros((len(to), 0)), np.full(len(to), noise)
    best, least = np.zeros((len(to), len(edges.segments))), np.full(len(to), np.inf)
    # The sum of the absolute weights (Lebesgue's function) is the factor by which errors of the
    # nodes may grow.
    amplified = np.maximum(1.0, np.abs(lagrange(at, to)).sum(axis=1) / SAFETY) * noise
    for through in (_in_friction, _in_edge):
        full, fewer, fewest = (
            np.clip(through(at[:m], unknowns[:m], to), -FARTHEST, FARTHEST)
            for m in (len(at), len(at) - 1, len(at) - 2)
        )
        both = _apart(edges, np.concatenate([full, fewer]), np.concatenate([fewer, fewest]))
        first, second = np.split(both, 2)
        # Differences that fall fast, a geometric series, are bounded by the first of them; where
        # they do not fall, the larger one is the only estimate there is.
        # True errors were up to three times the plain estimate next to thresholds.
        doubt = 5.0 * np.where(first < 0.5 * second, first, np.maximum(first, second))
        better = doubt < least
        best[better], least[better] = full[better], doubt[better]
        if np.all(least + amplified <= rtol):
            break
    return best, least + amplified


def _apart(edges: Edges, values: Array, other: Array) -> Array:
    """Return how far two interpolations (t, e) are apart, (t,), for an error estimate."""
    shift = SAFETY * edge_shift(edges, values.T, other.T)
    return np.maximum(shift, np.abs(values - other).max(axis=1))
