"""Fields along x at nodes: their values there, and means where they jump."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError

BARRIER = 10.0
"""Ratio at a jump up to which nodes take means: at 3 slip is .9 % off, at 30 5 % either way."""


def sampled(
    what: str, field: Any, x: Array, spacing: float = 0.0, largest: float = math.inf
) -> Array:
    """Return a number, function of x or Table at positions x, (n,) [length].

    Where a field jumps within a cell, one node `spacing` [length] long, the node takes the mean, if
    values in the cell are within the ratio `largest`.  A node that took its value would move the
    jump by up to half a node distance, an error of first order.  Raises SceneError, which names
    `what`, if the field is of another kind, or has no finite number at one of the positions.
    """
    number = finite(field)
    if number is not None:
        return np.full(len(x), number)
    if not callable(field):
        raise SceneError(
            f"{what} must be a number, a function of x or a Table, got {shown(field)}."
        )
    try:
        values = np.asarray(field(x), dtype=float)
    except TypeError as error:  # of a function of other arguments
        raise SceneError(
            f"{what} must be a function of an array of x, by np.exp and not math.exp, and of "
            f"nothing else ({error}); a load of x and t has history=None."
        ) from error
    if values.shape not in ((), x.shape):
        raise SceneError(
            f"{what}: the function of x must return {len(x)} numbers, got shape {values.shape}."
        )
    values = np.broadcast_to(values, x.shape).copy()
    if not np.isfinite(values).all():
        missing = x[~np.isfinite(values)]
        raise SceneError(
            f"{what} has no finite value at x = {missing[0]:.4g} … {missing[-1]:.4g}; "
            "it must cover the contact."
        )
    return _with_jumps(field, x, values, spacing, largest) if spacing else values


def barrier_misfit(field: Any, x: Array, spacing: float) -> float:
    """Return how far nodes x (n,) have the ends of barriers from their places, over their distance.

    The node of a cell in which a field jumps beyond `BARRIER` takes its value: the grid has the
    jump at an end of the cell.
    """
    size = np.abs(_across(field, x, spacing, (np.arange(64) + 0.5) / 64 - 0.5))
    cut = size.max(axis=0) > BARRIER * size.min(axis=0)
    part = (size > np.sqrt(BARRIER) * size.min(axis=0)).mean(axis=0)[cut]
    return float(np.minimum(part, 1 - part).max(initial=0.0))


def widened(field: Any, by: float) -> Any:
    """Return a function of x whose barriers reach farther by a distance on either side [length]."""

    def wider(x: Array) -> Array:
        own, *others = (np.broadcast_to(field(x + shift), x.shape) for shift in (0.0, -by, by))
        for other in others:
            own = np.where(np.abs(other) > BARRIER * np.abs(own), other, own)
        return np.asarray(own, dtype=float)

    return wider


def moving(field: Any, x: Array, t: float, spacing: float) -> Array:
    """Return a function of x and t at nodes (n,) and a time, with means where it jumps.

    Its cells are looked at only where two neighbours differ by more than all others near them,
    as they do at a jump; a smooth function costs no more than its values at nodes.
    """
    values = np.broadcast_to(np.asarray(field(x, t), dtype=float), x.shape)
    steps = np.abs(np.diff(values))
    beside = np.concatenate([[0.0, 0.0], steps, [0.0, 0.0]])
    around = beside[:-4] + beside[1:-3] + beside[3:-1] + beside[4:]
    if not (steps > around).any():
        return values

    def now(x: Array) -> Any:
        return field(x, t)

    return _with_jumps(now, x, values.copy(), spacing, math.inf)


def _with_jumps(field: Any, x: Array, values: Array, spacing: float, largest: float) -> Array:
    """Return values at nodes (n,), of which those whose cells hold a jump are means."""
    # With 4 a bump as wide as a cell passes for a jump, with 16 the same jumps are found.
    parts = _across(field, x, spacing, np.linspace(-0.5, 0.5, 9))
    with np.errstate(invalid="ignore"):  # beyond the ends of a table there is nan
        steps = np.abs(np.diff(parts, axis=0))
        # A smooth field has its change in many of the parts, 1/8 in each where it is linear and 1/4
        # at a maximum, a jump in one.
        jumps = steps.max(axis=0) > 0.5 * steps.sum(axis=0)
        low, high = np.abs(parts).min(axis=0), np.abs(parts).max(axis=0)
        jumps &= np.isfinite(parts).all(axis=0) & (high / largest <= low)
    if not jumps.any():
        return values
    # A mean that moved in steps with the place of a jump would have no derivative by it.
    nodes, means = np.arange(len(x)), (parts[1:] + parts[:-1]).mean(axis=0) / 2
    for step in np.argsort(steps, axis=0)[-2:]:
        before, after = parts[step, nodes], parts[step + 1, nodes]
        if (before[jumps] == after[jumps]).all():
            continue
        low, high = (spacing * ((step + end) / 8 - 0.5) for end in (0.0, 1.0))
        amid = (low + high) / 2  # where the mean of parts has it
        for _ in range(45):  # to rounding
            middle = (low + high) / 2
            value = _at(field, x + middle)
            is_before = np.abs(value - before) < np.abs(value - after)
            low, high = np.where(is_before, middle, low), np.where(is_before, high, middle)
        means += (before - after) * ((low + high) / 2 - amid) / spacing
    values[jumps] = means[jumps]
    return values


def _across(field: Any, x: Array, spacing: float, shares: Array) -> Array:
    """Return a field at shares of a cell from its node, (count, n)."""
    return np.array([_at(field, x + by) for by in spacing * shares])


def _at(field: Any, x: Array) -> Array:
    """Return a field at as many places as there are nodes: it may be made for these alone."""
    with np.errstate(all="ignore"):  # a formula may have no value near the contact
        return np.broadcast_to(np.asarray(field(x), float), x.shape)
