"""Quadrature over similarity velocity xi = x/t between the wave fronts, b = mu = 1.

Every response of the half-plane surface to a history of traction or slip is a superposition
of straight rays x = xi t, 0 < xi < c_l, with a density that has square-root ends at c_t and
c_l and, for Lamb's functions, a simple pole at c_R.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Array, RayleighFactors


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


def principal_panels(factors: RayleighFactors, order: int) -> tuple[Array, Array]:
    """Return nodes and weights on 0 < xi < c_l for densities with a simple pole at c_R.

    The panel around c_R is symmetric and of even order, which makes it a principal value; the
    panels beside it grow in proportion to their distance from the pole.

    Parameters
    ----------
    factors : RayleighFactors
    order : Gauss nodes per panel, even.
    """
    rayleigh, longitudinal = 1 / factors.c, 1 / factors.a
    reach = (1 - rayleigh) / 2
    widths = reach * 3.0 ** np.arange(40)
    left = [0.0, *(rayleigh - widths[widths < 0.8 * rayleigh])[::-1]]
    right = [rayleigh + reach, 1.0, longitudinal]
    nodes_left, weights_left = square_root_panels(left, order)
    nodes_right, weights_right = square_root_panels(right, order)
    t, weight = gauss(order)
    # Gauss nodes of even order are symmetric about the pole and miss it: its two sides cancel.
    middle = rayleigh + reach * (2 * t - 1)
    return (
        np.concatenate([nodes_left, middle, nodes_right]),
        np.concatenate([weights_left, 2 * reach * weight, weights_right]),
    )
