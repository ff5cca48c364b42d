"""Fields in a body as sums of waves over wavenumbers and frequencies (`transfer`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.bodies.motion import Levels
from semianalytic.engine.bodies.transfer import decays, potentials, shares
from semianalytic.scene.scene import Material

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Asked = Literal["velocity", "displacement", "strain"]

BLOCK = 1 << 16
"""Pairs of wavenumber and frequency that are formed at once, to stay in the cache."""
FALLEN = 35.0
"""Waves that have fallen by more than exp of this do not count."""
NEAR = 6.0
"""Depth in node distances from which pictures take half the wavenumbers and frequencies.

That changes velocities by 1e-4 of the largest, and takes a quarter of the time.
"""
DEPTHS, DEGREE = 400, 5
"""Depths of a picture beyond which it is interpolated between them, and the degree of that."""


class Term(NamedTuple):
    """A part of a field, coefficient s^power (i q)^turns decay^falls, of a wave of `transfer`."""

    wave: str
    coefficient: float
    turns: int
    falls: int
    power: int

    def factor(self, q: Array, decay: Complex, s: Complex) -> Complex | float:
        """Return decay^falls s^power."""
        one: Complex | float = decay if self.falls else 1.0
        return one * s**self.power if self.power else one


def terms_of(asked: Asked, body: Material) -> list[list[Term]]:
    """Return the rows of a field as sums of terms: x, y, z, or xx, yy, xy, xz, yz of the tensor."""
    if asked != "strain":
        power = -1 if asked == "displacement" else 0
        return [
            [Term("P", 1.0, 1, 0, power), Term("S", 1.0, 0, 1, power)],
            [Term("P", -1.0, 0, 1, power), Term("S", 1.0, 1, 0, power)],
            [Term("Z", 1.0, 0, 0, power)],
        ]
    p, s = (speed**-2 for speed in (body.longitudinal_speed, body.shear_speed))
    along = [Term("P", 1.0, 2, 0, -1), Term("S", 1.0, 1, 1, -1)]
    return [
        along,
        [Term("P", p, 0, 0, 1), *(one._replace(coefficient=-1.0) for one in along)],
        [Term("P", -1.0, 1, 1, -1), Term("S", 1.0, 2, 0, -1), Term("S", -s / 2, 0, 0, 1)],
        [Term("Z", 0.5, 1, 0, -1)],
        [Term("Z", -0.5, 0, 1, -1)],
    ]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Amplitudes of the waves that the face of a body sends, seen as if it lay above.

    Attributes
    ----------
    levels : Levels
        Times of the transform.
    body : Material
    q : (n,) array
        Wavenumbers [1 / length]; the first is 0, or that of the stiffness that holds the mean.
    waves : mapping of (2, n, frequencies) arrays
        Phi as "P" and Psi as "S", v_z on the face as "Z": at wavenumbers q and at -q.
    """

    levels: Levels
    body: Material
    q: Array
    waves: Mapping[str, Complex]

    @classmethod
    def of(
        cls,
        levels: Levels,
        bodies: tuple[Material, ...],
        lower: bool,
        first: float,
        spacing: float,
        rates: Mapping[str, Array],
        held: float = 0.0,
    ) -> Spectrum:
        """Make the spectrum of one body.

        Parameters
        ----------
        levels : Levels
        bodies : one or two Material
        lower : bool
            Whether it is that of the lower body.
        first, spacing : float
            Position of the first node, and node distance [length].
        rates : mapping of (count, nodes) arrays
            Mean slip rates "x" or "z" and opening rates "y" between the levels [length / time].
        held : float
            Wavenumber of the stiffness that the mean meets [1 / length].
        """
        nodes = next(iter(rates.values())).shape[1]
        k = 2 * np.pi / (nodes * spacing) * np.arange(nodes // 2)
        q = k.copy()
        q[0] = held
        # A taper, without which the sum would end abruptly and ring.
        placed = (np.exp(-7.0 * (k * spacing / np.pi) ** 8) * np.exp(-1j * k * first))[:, None]
        placed[0] /= 2  # the mean is counted at q and at -q
        s, waves = levels.frequencies, dict[str, Complex]()
        for name, means in rates.items():
            ahead, back = (one[: len(k)] for one in levels.transformed(means))
            ahead, back = ahead * placed, back * placed.conj()
            if name == "z":
                share = shares(bodies, lower, q[:, None], s)
                waves["Z"] = np.stack([share * ahead, share * back])
                continue
            one = potentials(bodies, lower, q[:, None], s)[name == "y"]
            # what contains i q changes its sign with q
            signs = (-1, 1) if name == "x" else (1, -1)
            for wave, drive, sign in zip("PS", one, signs, strict=True):
                sent = np.stack([drive * ahead, sign * drive * back])
                waves[wave] = waves[wave] + sent if wave in waves else sent
        return cls(levels, bodies[lower and len(bodies) - 1], q, waves)

    @cached_property
    def _k(self) -> Array:
        """Wavenumbers of the phases along x, of which the first is 0, (n,) [1 / length]."""
        return np.concatenate([[0.0], self.q[1:]])

    def _terms(self, asked: Asked) -> list[list[Term]]:
        rows = terms_of(asked, self.body)
        return [[term for term in row if term.wave in self.waves] for row in rows]

    def _first(self, q: float, depth: float) -> int:
        """Return the first frequency whose waves count at a wavenumber and a depth."""
        if q * depth <= FALLEN:
            return 0
        omega = self.body.shear_speed * math.sqrt(q * q - (FALLEN / depth) ** 2)
        return int(omega / self.levels.frequencies[1].imag)

    def histories(self, asked: Asked, x: Array, depth: float) -> Array:
        """Return a field at all levels of the transform, (rows, points, count + 1).

        Parameters
        ----------
        asked : {"velocity", "displacement", "strain"}
        x : (points,) array
        depth : float
            Distance from the face [length].
        """
        from scipy.fft import irfft  # here, for `import semianalytic` is to be quick

        s, rows, levels = self.levels.frequencies, self._terms(asked), self.levels
        # sums over wavenumbers, before the powers of s
        sums = {
            (one.wave, one.turns, one.falls): np.zeros((len(x), len(s)), dtype=complex)
            for row in rows
            for one in row
        }
        block = max(1, BLOCK // len(s))
        for start in range(0, len(self.q), block):
            part = slice(start, start + block)
            seen = slice(self._first(self.q[start], depth), None)
            roots = decays(self.body, self.q[part, None], s[seen])
            phase = np.exp(1j * np.multiply.outer(x, self._k[part]))
            for wave, amplitudes in self.waves.items():
                decay = roots[wave != "P"]
                fall = np.exp(-depth * decay)
                for side, turn in enumerate((1j, -1j)):
                    sent = amplitudes[side, part, seen] * fall
                    fallen = decay * sent
                    for (name, turns, falls), total in sums.items():
                        if name == wave:
                            along = (phase if side == 0 else phase.conj()) * (
                                turn * self.q[part]
                            ) ** turns
                            total[:, seen] += along @ (fallen if falls else sent)
        found = np.zeros((len(rows), len(x), len(s)), dtype=complex)
        for row, terms in zip(found, rows, strict=True):
            for one in terms:
                row += one.coefficient * s**one.power * sums[one.wave, one.turns, one.falls]
        t = levels.step * np.arange(levels.count + 1)
        values = irfft(found, levels.size, axis=-1)[..., : len(t)]
        return np.asarray(values * (np.exp(levels.fall * t) / levels.step))

    def picture(self, asked: Asked, x: Array, depths: Array, time: float, spacing: float) -> Array:
        """Return a field at points (p,) at one time, (rows, p).

        `depths` are distances from the face, and `spacing` is the node distance [length].
        """
        levels, place = np.unique(depths, return_inverse=True)
        place, weight = place[:, None], np.ones((len(depths), 1))
        if len(levels) > DEPTHS:
            levels = np.linspace(levels[0], levels[-1], DEPTHS)
            place, weight = between((depths - levels[0]) / (levels[1] - levels[0]), DEPTHS, DEGREE)
        near = int(np.searchsorted(levels, NEAR * spacing))
        every = np.concatenate(
            [
                self._amplitudes(asked, levels[part], time - self.levels.start, share)
                for part, share in ((slice(near), 1.0), (slice(near, None), 0.5))
                if len(levels[part])
            ]
        )  # (depths, rows, wavenumbers)
        at, which = np.unique(x, return_inverse=True)
        phases = np.exp(1j * np.multiply.outer(at, self._k)) if len(at) <= 4 * len(levels) else None
        found = np.zeros((every.shape[1], len(x)))
        order = np.argsort(place[:, 0], kind="stable")
        ends = np.searchsorted(place[order, 0], np.arange(len(levels) + 1))
        for begin, end in zip(ends[:-1], ends[1:], strict=True):
            if end == begin:
                continue
            here, first = order[begin:end], place[order[begin], 0]
            along = np.exp(1j * np.multiply.outer(x[here], self._k)) if phases is None else None
            along = phases[which[here]] if along is None else along
            for step in range(weight.shape[1]):
                values = (along @ every[first + step].T).real
                found[:, here] += weight[here, step] * values.T
        return found

    def _amplitudes(self, asked: Asked, depths: Array, time: float, share: float) -> Complex:
        """Return amplitudes of exp(i q x), whose real parts add up, (depths, rows, wavenumbers).

        `share` is the part of wavenumbers and frequencies that counts.
        """
        rows, count = self._terms(asked), math.ceil(share * len(self.q))
        s = self.levels.frequencies[: math.ceil(share * len(self.levels.frequencies))]
        wave = np.exp(s * time) * (2 / (self.levels.size * self.levels.step))
        wave[0] /= 2
        if share < 1:
            wave *= np.exp(-36.0 * (s.imag / s.imag[-1]) ** 8)
        found = np.zeros((len(depths), len(rows), len(self.q)), dtype=complex)
        terms = [(place, one) for place, row in enumerate(rows) for one in row]
        for index, q in enumerate(self.q[:count]):
            seen = slice(self._first(q, depths[0]), None)
            if not len(s[seen]):
                continue
            roots, last = decays(self.body, q, s[seen]), share < 1
            taper = math.exp(-7.0 * (index / count) ** 8) if last else 1.0
            for name, amplitudes in self.waves.items():
                own = [one for one in terms if one[1].wave == name]
                decay = roots[name != "P"]
                factors = np.stack([one.factor(q, decay, s[seen]) * wave[seen] for _, one in own])
                ahead, back = amplitudes[:, index, : len(s)][:, seen]
                sent = np.concatenate([factors * ahead, factors * back])
                sums = (fallen(depths, decay) @ sent.T).reshape(len(depths), 2, len(own))
                for column, (row, one) in enumerate(own):
                    turned = (1j * q) ** one.turns * one.coefficient * taper
                    # the real part of a wave at -q is that of its conjugate at q
                    both = turned * (sums[:, 0, column] + sums[:, 1, column].conj())
                    found[:, row, index] += both
        return found


def fallen(depths: Array, decay: Complex) -> Complex:
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


def between(at: Array, count: int, degree: int) -> tuple[NDArray[np.intp], Array]:
    """Return indices of evenly spaced samples around places, and their Lagrange weights.

    Parameters
    ----------
    at : (n,) array
        Places in units of the spacing, 0 at the first of `count` samples.
    count, degree : int
        Number of samples, and degree of the polynomial.
    """
    order = np.arange(degree + 1)
    first = np.clip(at.astype(int) - degree // 2, 0, count - len(order))
    offset = (at - first)[:, None] - order
    weight = np.ones(offset.shape)
    for one in order:
        others = order != one
        weight[:, one] = np.prod(offset[:, others] / (one - order[others]), axis=1)
    return first[:, None] + order, weight
