"""Quadrature over similarity velocity xi = x/t between the wave fronts, b = mu = 1.

Every response of the half-plane surface to a history of traction or slip is a superposition
of straight rays x = xi t, 0 < xi < c_l, with a density that has square-root ends at c_t and c_l.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Array


def square_root_panels(ends: Iterable[float], order: int) -> tuple[Array, Array]:
    """Return nodes and weights on panels whose integrand may have square-root ends.

    Parameters
    ----------
    ends : ends of the panels in increasing order; empty panels are left out.
    order : Gauss nodes per panel, placed in theta with xi = left + (right - left) sin^2 theta.

    Returns
    -------
    nodes, weights : (n,) arrays
    """
    t, weight = gauss(order)
    share, jacobian = np.sin(t * np.pi / 2) ** 2, np.sin(t * np.pi) * np.pi / 2 * weight
    nodes, weights = [np.zeros(0)], [np.zeros(0)]
    for left, right in pairwise(ends):
        if right > left:
            nodes.append(left + (right - left) * share)
            weights.append((right - left) * jacobian)
    return np.concatenate(nodes), np.concatenate(weights)
