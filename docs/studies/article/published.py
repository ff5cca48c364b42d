"""The article's own algorithm (section 5, Appendix B), in every reading its text allows.

It collocates  F(u) = q(u) - f sign(V) p(u) = sum_j b_j L_j(u)  in the slowness u = t/x, with
L_j the integral of basis function j against the kernels of (4.42) at the difference u - u'.
(4.43) presents that as a convolution; the change of variable (4.41) does not give one, so that the
equation solved here is not the contact problem.  The module exists to see what the printed
method yields.  Units b = mu = 1, f P_0 = 1 and Q_0 = 1/chi; slip rates are one-sided.

The text leaves open

- where the unknowns start: at u = 0 as in (4.44), at a or at b, the fronts;
- the delays: (4.44) lets a kernel act only if u - u' exceeds its front slowness, which leaves no
  equation for the last unknowns; or each kernel acts from its own front on;
- the signs of the two terms: equal as printed, or opposite, in two ways;
- whether p and q hold the remote load (the constant of (3.10), (3.14)) or, as section 6 says, not;
- triangular functions (7.8) or boxes;
- the arctan of (7.10) with the factor b^3 it needs, or as printed, which in the article's units
  (b = 0.2) makes the term 125 times larger.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Literal

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.optimize import brentq

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

Start = Literal["0", "a", "b"]
Delay = Literal["printed", "front"]
Signs = Literal["equal", "four minus square", "square minus four"]
Basis = Literal["box", "hat"]

ARTICLE_POISSON_RATIO = 1 / 3
"""Poisson ratio of section 6."""
ARTICLE_SHEAR_SLOWNESS = 0.2
"""Slowness 1 / c_t in the article's units (c_t = 5; section 6 exchanges a and b and halves b)."""
REVERSE_LIMIT = 0.0575
"""chi below which the article finds reverse slip."""
_SIGNS = {"equal": (1, 1), "four minus square": (1, -1), "square minus four": (-1, 1)}


@dataclass(frozen=True)
class AlgorithmReading:
    """One way to read the algorithm; the module's docstring lists what the text leaves open."""

    start: Start = "b"
    delay: Delay = "front"
    signs: Signs = "four minus square"
    remote_load: bool = False
    basis: Basis = "box"
    printed_arctan: bool = False

    @property
    def label(self) -> str:
        """Short description for tables."""
        parts = [f"u' > {self.start}", f"delay {self.delay}", self.signs, self.basis]
        parts.append("p, q with constant" if self.remote_load else "p, q without constant")
        if self.printed_arctan:
            parts.append("arctan as printed")
        return ", ".join(parts)


DEFAULT_READING = AlgorithmReading()
"""The reading that comes closest: its signs settle, it settles as n_u grows, and slip is reversed
ahead and forward behind.  It does so at every chi: it does not reproduce 0.0575.  None does."""


def readings() -> Iterator[AlgorithmReading]:
    """Return all readings."""
    for start, delay, signs, load, basis, arctan in product(
        ("0", "a", "b"), ("printed", "front"), _SIGNS, (False, True), ("box", "hat"), (False, True)
    ):
        yield AlgorithmReading(start, delay, signs, load, basis, arctan)  # type: ignore[arg-type]


def kernel_primitives(
    poisson_ratio: float, u: Array, *, printed_arctan: bool = False
) -> tuple[Array, Array]:
    """Return int 4 v sqrt(v^2 - a^2) dv and int (1 - 2v^2)^2 / (v sqrt(v^2 - 1)) dv up to u, b = 1.

    They are L^(a) of (7.9) and L^(b) of (7.10), each 0 ahead of its front, at slownesses u [1/b].
    """
    a = rayleigh_factors(poisson_ratio).a
    root = np.sqrt(np.maximum(u * u - 1, 0.0))
    factor = ARTICLE_SHEAR_SLOWNESS**-3 if printed_arctan else 1.0
    first = 4 / 3 * np.maximum(u * u - a * a, 0.0) ** 1.5 * (u > a)
    return first, (4 / 3 * root**3 + factor * np.arctan(root)) * (u > 1)


@dataclass(frozen=True, eq=False)
class PublishedGrid:
    """Ends of the intervals (n + 1,) and collocation points (n,) of a reading in u [1/b], its
    matrix L_j(u_k) (n, n) [mu b], and the condition number of that, inf if it is singular."""

    edges: Array
    points: Array
    matrix: Array
    condition: float


@lru_cache(maxsize=64)
def published_grid(
    reading: AlgorithmReading,
    size: int,
    poisson_ratio: float = ARTICLE_POISSON_RATIO,
    place: float = 0.5,
) -> PublishedGrid:
    """Matrix of a reading on `size` equal intervals up to u = 5 b, x = c_t t / 5 (5.2)-(5.4).

    It collocates at `place` in each interval, 0.5 for the middle.
    """
    a = rayleigh_factors(poisson_ratio).a
    start = {"0": 0.0, "a": a, "b": 1.0}[reading.start]
    # Slowness [1/b] up to which it collocates: x = c_t t / 5.
    edges = np.linspace(start, 5.0, size + 1)
    points = edges[:-1] + place * np.diff(edges)
    # As printed, a kernel is 0 until the lag exceeds its front; else the lag counts from the front.
    shifts = (0.0, 0.0) if reading.delay == "printed" else (a, 1.0)

    def primitive(lag: Array) -> Array:
        total = np.zeros(lag.shape)
        for which, (sign, shift) in enumerate(zip(_SIGNS[reading.signs], shifts, strict=True)):
            values = kernel_primitives(
                poisson_ratio, np.maximum(lag, 0.0) + shift, printed_arctan=reading.printed_arctan
            )
            total += sign * values[which]
        return total / np.pi

    ends = primitive(points[:, None] - edges)
    if reading.basis == "box":
        matrix = ends[:, :-1] - ends[:, 1:]
    else:
        # hats at the left ends of the intervals, by parts: the mean of the primitive over each
        t, weight = gauss(24)
        mean = np.empty((size, size))
        width = edges[1] - edges[0]
        for k, point in enumerate(points):
            # the lag passes 0 inside the point's own interval
            stop = np.clip(point - edges[:-1], 0.0, width)[:, None]
            # The primitive starts like a root where the lag is 0: t^2 gathers the nodes there.
            lag = point - edges[:-1, None] - stop * (1 - t**2)
            mean[k] = (primitive(lag) * 2 * t * stop / width) @ weight
        matrix = ends[:, :-1] - mean
        matrix[:, 1:] += mean[:, :-1] - ends[:, 1:-1]
    # A row or column of zeros, an equation or an unknown too few, has no finite condition number.
    singular = not np.all(np.abs(matrix).max(axis=0)) or not np.all(np.abs(matrix).max(axis=1))
    condition = np.inf if singular else float(np.linalg.cond(matrix))
    return PublishedGrid(edges, points, matrix, condition)


@dataclass(frozen=True, eq=False)
class PublishedSlip:
    """Slip rates (n,) [f P_0 / (mu b)] of the published algorithm at slownesses u (n,) [1/b], and
    whether the signs of friction agree with those of slip."""

    u: Array
    slip_rate: Array
    settled: bool

    def at(self, u: Array) -> Array:
        """Return the slip rate at slownesses u, linear between the unknowns, 0 ahead of all."""
        return np.interp(u, self.u, self.slip_rate, left=0.0)


def published_slip(
    chi: float,
    reading: AlgorithmReading = DEFAULT_READING,
    size: int = 200,
    *,
    poisson_ratio: float = ARTICLE_POISSON_RATIO,
    place: float = 0.5,
) -> PublishedSlip:
    """Run a reading: solve, reverse friction where slip has the other sign, repeat (5.1), (7.11).

    chi is f P_0 / Q_0 > 0 and `size` n_u; a singular matrix is refused by a SceneError.
    """
    grid = published_grid(reading, size, poisson_ratio, place)
    if not np.isfinite(grid.condition):
        raise SceneError(f"the matrix of this reading is singular ({reading.label}).")
    constant = 1.0 if reading.remote_load else 0.0
    shear = (stuck_traction(poisson_ratio, "II")(grid.points) + constant) / chi
    pressure = stuck_traction(poisson_ratio, "I")(grid.points) + constant
    factored = lu_factor(grid.matrix)
    sense, settled, reversals = np.ones(size), False, 0
    while True:
        rate = lu_solve(factored, shear - sense * pressure)
        # An unknown that is exactly 0 keeps the forward sense, or the rounds would not end.
        slip_sense = np.where(rate < 0, -1.0, 1.0)
        settled = bool(np.array_equal(slip_sense, sense))
        if settled or reversals == 15:  # after 15 rounds signs do not settle
            break
        sense, reversals = slip_sense, reversals + 1
    u = grid.points if reading.basis == "box" else grid.edges[:-1]
    return PublishedSlip(u, rate, settled)


def _largest_forward(slip: PublishedSlip) -> float:
    """Return x / (c_t t) of the largest slip rate behind 1.02 b, off the singular start."""
    behind = slip.u > 1.02
    return float(1 / slip.u[behind][np.argmax(slip.slip_rate[behind])])


def _end_of_first_slip(slip: PublishedSlip) -> float:
    """Return x / (c_t t) at which slip first changes sense behind the shear front; 0 if never."""
    behind = slip.u > 1.02
    changes = np.flatnonzero(np.diff(np.sign(slip.slip_rate[behind])))
    return float(1 / slip.u[behind][changes[0]]) if len(changes) else 0.0


def reverse_slip_limit(reading: AlgorithmReading, size: int = 200) -> float:
    """Return chi below which slip between c_R t and c_t t is reversed, with forward slip behind.

    The mean over b < u < c decides.  It is 0 if slip is not reversed at chi = 0.005, and inf if it
    still is at chi = 2.
    """
    c = rayleigh_factors(ARTICLE_POISSON_RATIO).c
    strip = np.linspace(1.0, c, 42)[1:-1]

    def mean(log_chi: float) -> float:
        return float(np.mean(published_slip(float(np.exp(log_chi)), reading, size).at(strip)))

    low, high = np.log(0.005), np.log(2.0)
    if mean(low) >= 0:
        return 0.0
    if mean(high) < 0:
        return np.inf
    return float(np.exp(brentq(mean, low, high, xtol=1e-3)))


@dataclass(frozen=True)
class ReadingResult:
    """The behaviour of one reading at the article's parameters.

    Attributes
    ----------
    reading : AlgorithmReading
    condition : float, at the finer grid; inf if singular, and then all that follows is nan
    change : float, change of the slip rate from n_u to 2 n_u in the mean over 1.1 < u < 4,
        relative to its mean size there (chi = 0.5)
    settled : bool, whether the sign reversals end at chi = 0.5 and chi = 2
    slip_end : float, x / (c_t t) at which slip first changes sense behind the shear front at
        chi = 2; the article's slip wave ends near a/b = 0.5; 0 if it does not within x > c_t t / 5
    maximum : float, x / (c_t t) of the largest slip rate at chi = 0.5
    reverse_limit : float, chi below which slip is reversed between c_R t and c_t t
    off_middle : float, as `change`, between collocating at 0.5 and at 0.25 of each interval
    """

    reading: AlgorithmReading
    condition: float
    change: float
    settled: bool
    slip_end: float
    maximum: float
    reverse_limit: float
    off_middle: float


@lru_cache(maxsize=256)
def examine_reading(reading: AlgorithmReading, size: int = 100) -> ReadingResult:
    """Run a reading at the article's parameters on `size` and twice as many intervals."""
    fine_grid = published_grid(reading, 2 * size)
    if not np.isfinite(fine_grid.condition):
        nan = float("nan")
        return ReadingResult(reading, np.inf, nan, False, nan, nan, nan, nan)
    sample = np.linspace(1.1, 4.0, 300)
    fine = published_slip(0.5, reading, 2 * size)
    scale = float(np.abs(fine.at(sample)).mean())

    def difference(other: PublishedSlip) -> float:
        return float(np.abs(other.at(sample) - fine.at(sample)).mean() / scale)

    above = published_slip(2.0, reading, 2 * size)
    return ReadingResult(
        reading,
        fine_grid.condition,
        difference(published_slip(0.5, reading, size)),
        fine.settled and above.settled,
        _end_of_first_slip(above),
        _largest_forward(fine),
        reverse_slip_limit(reading, 2 * size),
        difference(published_slip(0.5, reading, 2 * size, place=0.25)),
    )


def examine_all(size: int = 100) -> list[ReadingResult]:
    """Run `examine_reading` on all readings; the most settled come first, singular ones last."""
    results = [examine_reading(reading, size) for reading in readings()]
    return sorted(results, key=lambda r: (not r.settled, np.nan_to_num(r.change, nan=np.inf)))
