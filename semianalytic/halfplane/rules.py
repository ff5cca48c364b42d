"""Quadrature on a uniform grid: trapezoidal rule, sinc indefinite integration, principal values.

Functions of y that are analytic in a strip |Im y| < pi and decay at both ends are integrated
with an error that falls geometrically with the spacing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from semianalytic.halfplane.lazily import cached_property
from semianalytic.scene.arrays import Array

REACH = 1.5
"""Length of a rule over that of decay to its tolerance; beyond it exp(-|y| / 2) is continued."""
_STEPS = 32
"""Spacings per power of two: finer rules come in steps, so that their tables are met again."""
_FEW_POINTS = 20
"""Points of a piece with singularities three half-lengths away: off by 5e-16, with 14 by 1e-11."""
_STEP_TERMS = 18
"""Terms of the series of the integral of sinc between nodes: off by 1e-15, with 16 by 2e-14."""
_TABLES = 12
"""Tables (n, n) of rules that are kept: one takes 18 MB at 1,500 nodes."""
_SMALL, _SMALL_TABLES = 128, 256
"""Nodes of a small table, of which so many are kept: a sweep over the plane meets 300 rules."""


@dataclass(frozen=True)
class BesideEnd:
    """Points near the left end of a panel, from which to interpolate what is smooth there."""

    count: int  # number m of nodes, from the first on, for which the points stand
    # shares of the panel left and right of the points, (q,) each
    share: Array
    rest: Array
    # takes values at the points to the nodes, for functions smooth in the share, (m, q)
    onto: Array
    # the same for the mirror image, near the right end, for functions that are proportional to the
    # share that is left there, relative to themselves, (m, q)
    onto_falling: Array


@dataclass(frozen=True)
class Rule:
    """A uniform grid in y of spacing h, from -reach to reach, and `further` on either side.

    One that is `held` is not replaced where panels need another: neighbours have its nodes.
    """

    spacing: float
    reach: float
    further: int = 0
    held: bool = False

    @cached_property
    def y(self) -> Array:
        """The nodes, (n,), even about 0."""
        count = int(np.ceil((self.reach + self.further) / self.spacing))
        return np.arange(-count, count + 1.0) * self.spacing

    @cached_property
    def core(self) -> slice:
        """The nodes no further out than `reach`."""
        extra = int(self.further / self.spacing)
        return slice(extra, len(self.y) - extra)

    @property
    def tolerance(self) -> float:
        """The tolerance for which `rule_for` has this spacing."""
        return float(np.exp(2 - np.pi**2 / self.spacing))

    @cached_property
    def decay(self) -> Array:
        """Values of exp(-y) at the nodes."""
        return np.exp(-self.y)

    @cached_property
    def share(self) -> Array:
        """The share 1 / (1 + exp(-y)) of a panel to the left of each node."""
        return 1 / (1 + self.decay)

    @cached_property
    def bell(self) -> Array:
        """Slope of `share`."""
        return self.share * self.share[::-1]

    def beside_end(self, halvings: int) -> BesideEnd:
        """Return points for the nodes in the first 2^-halvings of a panel."""
        return _beside_end(len(self.y), self.spacing, halvings)

    @cached_property
    def weights(self) -> Array:
        """Weights of the nodes in an integral, (n,), with the tails exp(-|y| / 2) beyond."""
        result = np.full(len(self.y), self.spacing)
        # The sum of a geometric series: the density goes on like exp(-|y| / 2) beyond its last
        # node.
        result[[0, -1]] /= 1 - np.exp(-self.spacing / 2)
        return result

    def running(self, density: Array) -> Array:
        """Return the integrals from -inf to each node of the interpolant of `density` (..., n)."""
        return np.asarray(density @ _running(len(self.y), self.spacing))

    def halved(self, density: Array) -> Array:
        """Return the integrals from -inf to the middle node, (...)."""
        n = len(self.y)
        return np.asarray(density @ _running(n, self.spacing)[:, n // 2])

    @property
    def alternate(self) -> Array:
        """The matrix 1 / sinh((y_i - y_j) / 2) where i - j is odd, 0 elsewhere."""
        return _alternate(len(self.y), self.spacing)

    def interpolate(self, y: Array, density: Array) -> Array:
        """Return the sinc interpolant of `density` (n,) at y."""
        nodes, values = self._continued(density)
        return np.asarray(np.sinc((y[:, None] - nodes) / self.spacing) @ values)

    def interpolate_running(self, y: Array, density: Array) -> Array:
        """Return the integral from -inf to y of the interpolant of `density`, (n,) or (k, n)."""
        nodes, values = self._continued(density)
        first = round(nodes[0] / self.spacing)
        return _stepped(y / self.spacing, first, (self._longer[2] * values).T)

    def _continued(self, density: Array) -> tuple[Array, Array]:
        """Return nodes a third further out, and `density` (..., n) continued like exp(-|y| / 2).

        Cut off at the ends, its interpolant would ripple by several times the tolerance.
        """
        nodes, decay, _ = self._longer
        before, after = density[..., :1] * decay[::-1], density[..., -1:] * decay
        return nodes, np.concatenate([before, density, after], axis=-1)

    @cached_property
    def _longer(self) -> tuple[Array, Array, Array]:
        """Nodes a third further out, exp(-|y| / 2) from the last of `y` on, and weights."""
        more = np.arange(1.0, np.ceil(self.reach / (3 * self.spacing)) + 1) * self.spacing
        nodes = np.concatenate([self.y[0] - more[::-1], self.y, self.y[-1] + more])
        weights = np.full(len(nodes), self.spacing)
        # The part beyond the continued nodes belongs to the last of them, as in `weights`.
        weights[[0, -1]] = self.weights[[0, -1]]
        return nodes, np.exp(-more / 2), weights


def sinc_step(x: Array) -> Array:
    """Return the integral of sinc from -inf to x."""
    from scipy.special import sici  # here, for `import semianalytic` is to be quick

    return np.asarray(0.5 + sici(np.pi * x)[0] / np.pi)


def _stepped(x: Array, first: int, values: Array) -> Array:
    """Return integrals from -inf to x (m,) of sinc(x - k) times values, k from `first` on."""
    count = len(values)
    near = (x > first) & (x < first + count)
    if np.count_nonzero(near) < 6:  # few points are quicker with Si(pi x) at each
        return np.asarray(sinc_step(x[:, None] - (first + np.arange(count))) @ values)
    result, whole = np.empty((len(x), *values.shape[1:])), np.floor(x[near])
    if not near.all():
        # Positions beyond the nodes, which may be infinite, are not in the table.
        result[~near] = sinc_step(x[~near, None] - (first + np.arange(count))) @ values
    most = 2 ** int(np.ceil(np.log2(count)))
    orders = np.arange(_STEP_TERMS) * np.arccos(2 * (x[near] - whole)[:, None] - 1)
    # Convolved once for all points: 400 points then take about half as long (250 to 1,500 nodes),
    # 60 would take 1.2 to 1.7 times as long.
    if len(whole) < 120 * values[0].size:
        # The integral of sinc from -inf to x - k, for `count` more k on either side.
        steps = np.cos(orders) @ _step_table(most)[:, most - count : most + count + 1]
        chosen = np.lib.stride_tricks.sliding_window_view(steps, count, axis=1)
        result[near] = chosen[np.arange(len(whole)), (count + first - whole).astype(int)] @ values
        return result
    # Coefficients of the whole sum between each two nodes.
    sent = np.fft.rfft(values.T, 2 * most)
    series = np.fft.irfft(_step_spectra(most) * sent[..., None, :])[..., :count]
    here = series[..., (whole - first).astype(int)]
    result[near] = np.einsum("mt,...tm->m...", np.cos(orders), here)
    return result


@lru_cache(maxsize=4)
def _step_table(most: int) -> Array:
    """Return Chebyshev series in f of the integral of sinc to j + f, j = most ... -most."""
    orders = np.arange(_STEP_TERMS)
    turn = np.pi * (orders + 0.5) / _STEP_TERMS
    values = sinc_step((1 + np.cos(turn))[:, None] / 2 + np.arange(most, -most - 1, -1.0))
    onto = np.cos(orders[:, None] * turn) * np.where(orders, 2, 1)[:, None] / _STEP_TERMS
    return np.asarray(onto @ values)


@lru_cache(maxsize=4)
def _step_spectra(most: int) -> Array:
    """Return the Fourier transforms (terms, most + 1) of rows of `_step_table`, j = 0 ... -1."""
    return np.asarray(np.fft.rfft(np.roll(_step_table(most)[:, :0:-1], -most, axis=1)))


def _sinc_step_at_nodes(most: int) -> Array:
    """Return the integral of sinc from -inf to integers -most ... most, (2 most + 1,).

    Si(pi k) = pi / 2 - (-1)^k f(pi k), f(z) = int_0^inf exp(-s) z / (z^2 + s^2) ds: `scipy.special`
    would take half of the time of the first solution.
    """
    points, weights = _laguerre(60)  # off by 1.3e-15 at most; with 40 by 6e-14, with 80 by 4e-15
    k = np.arange(1.0, most + 1)
    z = np.pi * k
    f = (weights / (1 + (points / z[:, None]) ** 2)).sum(axis=1) / z
    beyond = 0.5 - np.where(k % 2, -f, f) / np.pi
    return np.concatenate([0.5 - beyond[::-1], [0.5], 0.5 + beyond])


_laguerre = lru_cache(maxsize=1)(np.polynomial.laguerre.laggauss)


def _kept(table: Callable[[int, float], Array]) -> Callable[[int, float], Array]:
    """Keep tables (n, n) of rules of n nodes and a spacing: many small ones, few large ones."""
    small, large = lru_cache(maxsize=_SMALL_TABLES)(table), lru_cache(maxsize=_TABLES)(table)
    return lambda n, spacing: (small if n <= _SMALL else large)(n, spacing)


@_kept
def _running(n: int, spacing: float) -> Array:
    beyond = _beyond(spacing)
    step = spacing * _sinc_step_at_nodes(n + beyond - 1)
    return _folded(step, n, np.exp(-spacing / 2 * np.arange(1.0, beyond + 1)))


@_kept
def _alternate(n: int, spacing: float) -> Array:
    beyond = _beyond(spacing)
    steps = np.arange(1 - n - beyond, n + beyond)
    inverse = np.zeros(len(steps))
    inverse[steps % 2 != 0] = -1 / np.sinh(steps[steps % 2 != 0] * (spacing / 2))
    return _folded(inverse, n, np.ones(beyond))


@lru_cache(maxsize=2 * _SMALL_TABLES)
def _beside_end(n: int, spacing: float, halvings: int) -> BesideEnd:
    part, orders = 2.0**-halvings, np.arange(_FEW_POINTS)
    nodes = 1 / (1 + np.exp((n // 2 - np.arange(n // 2)) * spacing))
    nodes = nodes[nodes < part]
    turn = np.pi * (orders + 0.5) / _FEW_POINTS
    share = part * np.square(np.sin(turn / 2))
    rest = (1 - part) + part * np.square(np.cos(turn / 2))
    # Values of Chebyshev polynomials in the share.
    at_nodes = np.cos(2 * orders * np.arcsin(np.sqrt(nodes / part))[:, None])
    at_points = np.cos(orders * turn[:, None]) * np.where(orders, 2, 1) / _FEW_POINTS
    onto = at_nodes @ at_points.T
    return BesideEnd(len(nodes), share, rest, onto, (onto * (nodes[:, None] / share))[::-1])


def _beyond(spacing: float) -> int:
    """Return the nodes beyond the ends until exp(-|y| / 2) is below rounding."""
    return int(np.ceil(80 / spacing))


def _folded(kernel: Array, n: int, decay: Array) -> Array:
    """Return the matrix (n, n) from a density at node i to its integral at node j.

    The kernel is that of j - i from 1 - n - b to n + b - 1, `decay` (b,) continues the last node.
    """
    beyond = len(decay)
    # The kernel depends on j - i alone: every row is a window on the same values.
    rows = np.lib.stride_tricks.sliding_window_view(kernel[beyond : len(kernel) - beyond], n)
    result = rows[::-1].copy()
    result[0] += np.correlate(kernel[n + beyond :], decay)
    result[-1] += np.correlate(kernel[: n + beyond - 1], decay[::-1])
    return result


@lru_cache(maxsize=64)
def rule_for(tolerance: float) -> Rule:
    """Return the grid on which end exponents from 1/2 on are integrated to about `tolerance`."""
    digits = np.log(1 / tolerance)
    # Sinc methods leave exp(-pi d / h) for functions analytic in |Im y| < d, here d = pi.
    return Rule(float(np.pi**2 / (digits + 2)), float(REACH * (digits + 1)))


@lru_cache(maxsize=2 * _SMALL_TABLES)
def _finer(rule: Rule, refinements: int, further: int) -> Rule:
    spacing = rule.spacing * 2.0 ** (-refinements / _STEPS)
    return Rule(spacing, rule.reach, max(rule.further, further))


def finer_rule(rule: Rule, strip: float, further: float) -> Rule:
    """Return a rule for functions analytic in |Im y| < pi `strip`, `further` on either side."""
    if rule.held:
        return rule
    # The part further out is below rounding.
    beyond = int(np.ceil(min(further, 100.0))) if further > 0 else 0
    # The spacing that a narrower strip needs is proportional to it, rounded down to a step.
    return _finer(rule, int(np.ceil(-_STEPS * np.log2(strip))), beyond)
