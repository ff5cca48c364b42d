"""The inverse square root at the edge of the slot as a spectral grid sees it.

Collocated at equally spaced nodes with the band-limited symbol |theta|, a static stuck contact
has nodal tractions that are the coefficients of P_+(z) / sqrt(1 - z), where |theta| =
2 |sin(theta/2)| P(theta) and P = P_+(z) P_+(1/z), z = exp(i theta) (Wiener-Hopf for the grid;
docs/theory.md, "The edge on a grid").  For large n they follow K / sqrt(2 pi (n + offset) h): the
grid has its own edge, and its own first few values.  Pressure that is compared with shear on the
grid has to be represented in the same way.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.arrays import Array

_CIRCLE = 1 << 16
_NODES = 512


@lru_cache(maxsize=1)
def log_factor() -> Array:
    """Return the coefficients of z, z^2, ... in ln P_+(z)."""
    angle = 2 * np.pi * np.arange(_CIRCLE) / _CIRCLE
    angle = np.minimum(angle, 2 * np.pi - angle)
    ratio = np.ones(_CIRCLE)
    ratio[1:] = angle[1:] / (2 * np.sin(angle[1:] / 2))
    # The series of ln P(theta) in cos(n theta): its coefficients n > 0 are those of ln P_+(z).
    return np.asarray(np.fft.ifft(np.log(ratio)).real[1 : _CIRCLE // 2])


def exponential(series: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Return the coefficients of exp(sum_k c_k z^k), (m + 1,), given c_k for k = 1 ... m."""
    values = np.zeros(len(series) + 1, dtype=series.dtype)
    values[0] = 1.0
    moments = np.arange(1, len(values)) * series
    for n in range(1, len(values)):  # n p_n = sum k c_k p_(n - k)
        values[n] = moments[:n] @ values[n - 1 :: -1][:n] / n
    return values


@lru_cache(maxsize=1)
def edge_offset_and_factors() -> tuple[float, Array]:
    """Return the offset of the grid's own edge, and the factors of the first nodal values.

    The offset is the distance from the grid's edge to the first contact node, over the node
    distance.  The factors are nodal values over 1/sqrt(n + offset), for n = 0 ... (m,), and 1
    beyond.
    """
    from scipy.special import gammaln

    cepstrum = log_factor()
    moments = np.cumsum(np.arange(1, _CIRCLE // 2) * cepstrum)
    # The slope of ln P_+ at z = 1 moves the edge: offset = 1/4 - sum n c_n.  The kink of |theta| at
    # pi makes the sum alternate; its last two partial sums bracket it.
    offset = 0.25 - float(np.mean(moments[-2:]))
    smooth = exponential(cepstrum[: _NODES - 1])
    node = np.arange(_NODES)
    # coefficients of sqrt(pi) / sqrt(1 - z)
    root = np.exp(gammaln(node + 0.5) - gammaln(node + 1))
    values = np.convolve(root, smooth)[:_NODES] / np.exp(cepstrum.sum())
    return offset, values * np.sqrt(node + offset)
