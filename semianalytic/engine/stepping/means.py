"""Measures that keep the steps of a march stable and quiet: means over cells, and damped short
waves."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

LARGEST_FEEDBACK = 0.95
"""Largest feedback of the shortest wave: the iteration of a step diverges from 1 on."""


def area_means(
    stopping: Array,
    excess: Array,
    inner: NDArray[np.bool_],
    before: Array | None = None,
    mirror: int | None = None,
) -> Array:
    """Return tractions by which nodes slip at the mean over the stretch of the line around them.

    A node stands for a stretch of 1.5 node distances on which the traction in excess of the
    strength is linear; it slips by the mean of the positive part of the excess.  Without this, the
    end of a slip zone crosses nodes one by one and radiates waves three nodes long.

    Parameters
    ----------
    stopping : (n,) array
        Absolute value of the traction that would stop each node [stress].
    excess : (n,) array
        The same less the strength of a node that does not slip [stress].
    inner : (n,) array of bool
        Whether a node has neighbours of the same contact on both sides.
    before : (n,) array, optional
        Excess at the time level before [stress]: nodes at which it falls do not take the mean,
        which would prolong slip where a zone ends.
    mirror : int, optional
        Node that is the image of the one before the first, on half of an even line.  Otherwise the
        line is periodic, which matters where its first and last nodes are `inner`.
    """
    below, last = excess < 0, len(excess) - 1
    # Next to a stuck edge the excess is singular but of one sign: there the mean must not slip.
    # Elsewhere the mean differs from the value only at a change of sign, which the ends of the
    # line may have beyond them.
    changes = (below[1:] != below[:-1]).nonzero()[0].tolist()
    beside = {*changes, *(node + 1 for node in changes)}
    beside.update(end for end in (0, last) if inner[end])
    means = stopping
    # The few nodes are taken one by one, in a third of the time of arrays.
    for node in beside:
        if not inner[node] or (before is not None and not excess.item(node) > before.item(node)):
            continue
        left, right = node - 1, 0 if node == last else node + 1
        if mirror is not None and last >= mirror:
            left = mirror if node == 0 else left
            right = last - mirror if node == last else right
        here, earlier, later = excess.item(node), excess.item(left), excess.item(right)
        if min(earlier, here, later) >= 0 or max(earlier, here, later) <= 0:
            continue
        # Where strength or load jumps, the two one-sided slopes differ: the smaller one counts.
        slope = min(abs(later - earlier) / 4, abs(later - here), abs(here - earlier))
        # A traction of no size is the least there is: with more, slip would push against its sense.
        # With means over 0, 1.5 and 2 nodes the slip rate of `antiplane` is off by 2.6, 0.9 and
        # 0.3e-4, that of a zone of a thirteenth of the contact by 4.0, 1.8 and 3.0 %.
        reach = min(1.5 * slope, stopping.item(node))
        if abs(here) < reach:
            if means is stopping:
                means = stopping.copy()
            means[node] += (here + reach) * (here + reach) / (4 * reach) - here
    return means


def check_feedback(feedback: Array) -> None:
    """Raise SceneError if the iteration of a step cannot converge under the memory's feedback.

    The iteration contracts by the feedback (size,) of the shortest wave, the largest.  h(0) = 0, so
    that it grows like the square of the step.
    """
    shortest = float(feedback[-1])
    if shortest >= LARGEST_FEEDBACK:
        raise SceneError(
            f"march: `step_ratio` is beyond the stable range for this Poisson ratio; lower it "
            f"by {math.ceil(100 * (1 - math.sqrt(LARGEST_FEEDBACK / shortest)))} %."
        )


def damped(feedback: Array, wavenumbers: Array, damping: float) -> Array:
    """Return the feedback of the memory (size,), raised so that short waves are damped.

    That of the shortest wave is raised to `damping`, and that of longer waves much less.
    """
    lacking = max(damping - float(feedback[-1]), 0.0)
    return np.asarray(feedback + lacking * (wavenumbers / wavenumbers[-1]) ** 4)
