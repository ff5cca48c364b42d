"""The field of tractions on y = 0 in the upper body, summed over wavenumbers and frequencies.

A traction exp(i (omega t + q x)) makes a P wave that falls off like exp(-A y) and an S wave that
falls off like exp(-B y), A^2 = q^2 - omega^2 / c_l^2, B^2 = q^2 - omega^2 / c_t^2, with the
amplitudes of `field.waves` at the slowness k = q / omega.  Frequencies are taken on a line below
the real axis, omega - i eta, where nothing is singular and the periodic repetition in time is
small.  This is the method of the exponential window (docs/spacetime.md, "Fields in the bodies").
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.rayleigh import Mode

FIELD_LEVELS = 400
"""Depths beyond which fields are interpolated; half are three for the shortest wave."""
LEVEL_DEGREE = 5
"""Degree of that interpolation; its error is below 5e-4 with 200 levels."""
FIELD_BLOCK = 20_000
"""Pairs that are formed at once otherwise."""

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

Quantity = Literal["velocity", "stress", "displacement"]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Amplitudes of tractions on y = 0 at wavenumbers and complex frequencies, c_t = mu = 1.

    Attributes
    ----------
    wavenumbers : (n,) array
        Wavenumbers q >= 0 [1 / length].
    frequencies : (m,) complex array
        Frequencies omega / c_t [1 / length].
    shear, normal : (n, m) complex arrays or None
        Changes of sigma_xy (sigma_yz in antiplane shear) and of sigma_yy.
    """

    wavenumbers: Array
    frequencies: Complex
    shear: Complex | None
    normal: Complex | None

    @property
    def mirrored(self) -> Spectrum:
        """The spectrum as seen from the lower body.

        The signs of the fields are those of shear there, hence the opposite sign of sigma_yy.
        """
        return self if self.normal is None else replace(self, normal=-self.normal)


def kept_wavenumbers(period: float, nodes: int, share: float) -> Array:
    """Return the lowest `share` of the wavenumbers of nodes with a period, (n,) [1 / length]."""
    count = math.ceil(min(share, 1.0) * (nodes // 2))
    return np.asarray(2 * np.pi * np.arange(count) / period)


def along_line(values: Array, spacing: float, first: float, wavenumbers: Array) -> Complex:
    """Return the amplitudes (m, n) of exp(i q x) whose real parts add up to tractions (m, nodes).

    Node i is at (i + first) h; the nodes beyond the middle lie one period further left, on the
    slot.
    """
    from scipy.fft import rfft  # here, for `import semianalytic` is to be quick

    # twice, since q > 0 stands for -q as well, but not for q = 0; the phase puts node 0 at first h
    lines = rfft(values, axis=1)[:, : len(wavenumbers)]
    lines *= 2 * np.exp(-1j * first * spacing * wavenumbers) / values.shape[1]
    lines[:, 0] /= 2
    return np.asarray(lines)


@dataclass(frozen=True)
class TimeWindow:
    """An exponential window in time: even levels, a fade-out beyond the last, a fall exp(-eta t).

    Attributes
    ----------
    end : float
        c_t times the last time [length].
    steps : int
        Steps until then.
    """

    end: float
    steps: int

    @property
    def times(self) -> Array:
        """Time levels c_t t, (steps + 1,) [length]."""
        return np.linspace(0.0, self.end, self.steps + 1)

    @property
    def _size(self) -> int:
        """Number of levels in the window, after which the transform repeats."""
        return math.ceil(1.5 * self.steps)  # 2 is no better

    @property
    def _fall(self) -> float:
        """The rate eta / c_t [1 / length]: over one window, exp(-eta t) falls to 1e-5."""
        # With 1e-3 errors are three times as large, 1e-7 gains nothing.
        return math.log(1 / 1e-5) * self.steps / (self._size * self.end)

    def frequencies(self, highest: float) -> Complex:
        """Return the frequencies omega / c_t, (m,), real parts up to the highest [1 / length]."""
        spacing = 2 * np.pi * self.steps / (self._size * self.end)
        count = int(min(highest / spacing, (self._size - 1) // 2))
        return np.asarray(spacing * np.arange(-count, count + 1) - 1j * self._fall, dtype=complex)

    def transformed(self, lines: Complex, frequencies: Complex) -> Complex:
        """Return the amplitudes (n, m) of exp(i omega t) of lines (steps + 1, n)."""
        from scipy.fft import fft

        fading = int(0.25 * self.steps)  # 0.1 and 0.4 do the same
        beyond = np.arange(1, fading + 1)
        fade = 0.5 * (1 + np.cos(np.pi * beyond / fading))[:, None]
        # point reflection about the last value: value and slope continue, the cosine fades it out
        after = fade * (2 * lines[-1] - lines[-1 - beyond])
        whole = np.zeros((self._size, lines.shape[1]), dtype=complex)
        whole[: len(lines)], whole[len(lines) : len(lines) + fading] = lines, after
        whole *= np.exp(-self._fall * self.end / self.steps * np.arange(self._size))[:, None]
        count = len(frequencies) // 2
        order = np.arange(-count, count + 1)
        return np.asarray(fft(whole, axis=0, overwrite_x=True)[order].T / self._size)


def tapered(wavenumbers: Array, frequencies: Complex) -> Array:
    """Return a taper (n, m) that falls from 1 to nearly 0 at the highest wavenumber and frequency.

    It avoids the ringing of a sum that ends abruptly.
    """
    shares = wavenumbers / wavenumbers[-1], np.abs(frequencies.real) / frequencies.real[-1]
    # Down to 1e-3: a power of 4, or 36 or 3 in place of 7, leave errors up to half as large again.
    return np.multiply.outer(*(np.exp(-7.0 * share**8) for share in shares))


def evaluated(
    spectrum: Spectrum, quantity: Quantity, a: float, mode: Mode, x: Array, y: Array, t: Array
) -> Array:
    """Return velocity, stress or displacement (rows, p) at points (p,) of the upper body, y >= 0.

    Parameters
    ----------
    spectrum : Spectrum
        Tractions on y = 0.
    quantity : Quantity
        "velocity", "stress" or "displacement"; rows as in `Solution`, c_t = mu = 1.
    a : float
        c_t / c_l.
    mode : Mode
        "III" if the shear of the spectrum is along z; the rows are then those of z alone.
    x, y, t : (p,) arrays
        Positions and c_t times time [length].
    """
    lines = _Lines.through(y, t)
    # The wavenumbers are even, so exp(i q x) follows by repeated multiplication.  All points of a
    # line of equal y and t share the sum over frequencies.
    turn, phase = np.exp(1j * spectrum.wavenumbers[1] * x), np.ones(len(x), dtype=complex)
    result = 0.0
    for index in range(len(spectrum.wavenumbers)):
        waves = _waves(spectrum, index, quantity, a, mode)
        sums = sum(lines.summed(*wave, spectrum.frequencies) for wave in waves)
        result = result + (phase[:, None] * (lines.pick @ sums)).real
        phase *= turn
    return np.asarray(result).T


def _waves(
    spectrum: Spectrum, index: int, quantity: Quantity, a: float, mode: Mode
) -> list[tuple[Complex, Complex]]:
    """Return decay (m,) and amplitudes (rows, m) of each wave at one wavenumber; see `field.waves`.

    `index` is that of the wavenumber, `a` is c_t / c_l.
    """
    q, omega = spectrum.wavenumbers[index], spectrum.frequencies
    # Im omega < 0 keeps the radicand off its branch cut: the principal root decays upwards, and
    # decay = i omega beta with the beta of `field.waves`
    decay_s = np.sqrt(q * q - omega * omega)
    k, beta = q / omega, decay_s / (1j * omega)
    # displacement is velocity over i omega
    over = 1 / (1j * omega) if quantity == "displacement" else np.ones_like(omega)
    none = np.zeros_like(omega)
    shear, normal = (
        none if part is None else part[index] for part in (spectrum.shear, spectrum.normal)
    )
    if mode == "III":
        waving = (
            np.stack([-k * shear / beta, shear]) if quantity == "stress" else [-over * shear / beta]
        )
        return [(decay_s, np.asarray(waving))]
    decay_p = np.sqrt(q * q - np.square(a * omega))
    alpha, square = decay_p / (1j * omega), 1 - 2 * k * k
    # R(k), docs/theory.md, "Rayleigh function and factors"; its zeros lie on the real axis of omega
    rayleigh = square * square + 4 * k * k * alpha * beta
    # v_x over k of the P wave, and v_x of the S wave
    compression = (square * normal - 2 * k * beta * shear) / rayleigh
    rotation = -beta * (2 * k * alpha * normal + square * shear) / rayleigh
    if quantity == "stress":
        along = 1 - 2 * a * a + 2 * k * k
        pushed, turned = [along, square, -2 * k * alpha], [2 * k, -2 * k, -square / beta]
    else:
        pushed, turned = [over * k, -over * alpha], [over, over * k / beta]
    return [
        (decay_p, compression * np.stack(pushed)),
        (decay_s, rotation * np.stack(turned)),
    ]


@dataclass(frozen=True, eq=False)
class _Lines:
    """Lines of equal y and t on which points lie, or between which they are interpolated in y.

    Attributes
    ----------
    depths, times : (d,), (n,) arrays
        The depths y and times t that occur [length].
    pairs : (l,) array
        Depth and time of each line, as the index of the depth times n plus that of the time.
    pick : sparse (p, l) matrix
        Matrix from values on lines to values at points.
    """

    depths: Array
    times: Array
    pairs: NDArray[np.intp]
    pick: Any

    @classmethod
    def through(cls, y: Array, t: Array) -> _Lines:
        """Make the lines for points (p,)."""
        from scipy.sparse import csr_matrix

        depths, level = np.unique(y, return_inverse=True)
        level, weight = level[:, None], np.ones((len(y), 1))
        if len(depths) > FIELD_LEVELS:
            depths = np.linspace(depths[0], depths[-1], FIELD_LEVELS)
            level, weight = _between(depths, y)
        times, at = np.unique(t, return_inverse=True)
        pairs, column = np.unique(level * len(times) + at[:, None], return_inverse=True)
        starts = weight.shape[1] * np.arange(len(y) + 1)
        shape = (len(y), len(pairs))
        pick = csr_matrix((weight.ravel(), column.ravel(), starts), shape=shape)
        return cls(depths, times, pairs, pick)

    def summed(self, decay: Complex, amplitudes: Complex, frequencies: Complex) -> Complex:
        """Return the sums over frequencies of a wave on all lines, (l, rows)."""
        fallen = _fallen(self.depths, decay)
        waving = np.exp(1j * np.multiply.outer(self.times, frequencies))
        every = len(self.depths) * len(self.times)
        # all pairs of a depth and a time by one matrix product, unless few of them are wanted
        if every <= 4 * len(self.pairs):
            columns = (waving[:, None] * amplitudes).reshape(-1, len(decay)).T
            return (fallen @ columns).reshape(every, -1)[self.pairs]
        depth, time = np.divmod(self.pairs, len(self.times))
        sums = np.empty((len(self.pairs), len(amplitudes)), dtype=complex)
        for first in range(0, len(depth), FIELD_BLOCK):
            part = slice(first, first + FIELD_BLOCK)
            sums[part] = (fallen[depth[part]] * waving[time[part]]) @ amplitudes.T
        return sums


def _fallen(depths: Array, decay: Complex) -> Complex:
    """Return exp(-depth decay), (d, m).

    For many evenly spaced depths it is formed from products of about 2 sqrt(d) exponentials.
    """
    count = math.isqrt(len(depths))
    step = depths[-1] - depths[0]
    even = depths[0] + step * np.linspace(0.0, 1.0, len(depths))
    if count < 4 or np.abs(depths - even).max() > 1e-9 * step:
        return np.exp(-np.multiply.outer(depths, decay))
    blocks = np.exp(-np.multiply.outer(depths[::count], decay))
    within = np.exp(-np.multiply.outer(depths[:count] - depths[0], decay))
    return (blocks[:, None] * within).reshape(-1, len(decay))[: len(depths)]


def _between(levels: Array, y: Array) -> tuple[NDArray[np.intp], Array]:
    """Return indices of evenly spaced levels around each y, and their Lagrange weights."""
    order = np.arange(LEVEL_DEGREE + 1)
    at = (y - levels[0]) / (levels[1] - levels[0])
    first = np.clip(at.astype(int) - LEVEL_DEGREE // 2, 0, len(levels) - len(order))
    offset = (at - first)[:, None] - order
    weight = np.ones(offset.shape)
    for one in order:
        others = order != one
        weight[:, one] = np.prod(offset[:, others] / (one - order[others]), axis=1)
    return first[:, None] + order, weight
