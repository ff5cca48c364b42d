"""Fields in a body as sums of waves over wavenumbers and frequencies (`transfer`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.bodies.motion import Levels
from semianalytic.engine.bodies.transfer import decays, potentials
from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.scene import Material

Asked = Literal["velocity", "displacement", "strain"]

BLOCK = 1 << 14
"""Pairs of wavenumber and frequency that are formed at once: they stay in the cache, and products
for ten places are too small for several threads, which would wait for one another."""
FALLEN = 35.0
"""Waves that have fallen by more than exp of this do not count."""
TURNS = (1.0, -1.0, -1.0), (1.0, 1.0, -1.0)
"""Signs of the derivatives of cosines and sines, by their order."""
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
        factor: Complex | float = decay if self.falls else 1.0
        return factor * s**self.power if self.power else factor


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
        [Term("P", p, 0, 0, 1), *(term._replace(coefficient=-1.0) for term in along)],
        [Term("P", -1.0, 1, 1, -1), Term("S", 1.0, 2, 0, -1), Term("S", -s / 2, 0, 0, 1)],
        [Term("Z", 0.5, 1, 0, -1)],
        [Term("Z", -0.5, 0, 1, -1)],
    ]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Amplitudes of the waves that the face of a body sends, seen as if it lay above.

    A wave of amplitudes F at q and G at -q, and its derivatives along x of even order, go like

        (F + G) cos(q x) + i (F - G) sin(q x).

    Attributes
    ----------
    levels : Levels
        Times of the transform.
    body : Material
    q : (n,) array
        Wavenumbers [1 / length]; the first is 0, or that of the stiffness that holds the mean.
    waves : mapping of (n, frequencies) arrays
        Phi as "P" and Psi as "S", v_z on the face as "Z", each with False for its F + G and True
        for its i (F - G).  A line that is even about its origin lacks what is 0.
    origin : float
        Position at which phases are 0 [length].
    """

    levels: Levels
    body: Material
    q: Array
    waves: Mapping[tuple[str, bool], Complex]
    origin: float

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
        centre: float | None = None,
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
        centre : float, optional
            Position about which the line is even [length].
        """
        origin, even = centre or 0.0, centre is not None
        nodes = next(iter(rates.values())).shape[1]
        k = 2 * np.pi / (nodes * spacing) * np.arange(nodes // 2)
        q = k.copy()
        q[0] = held
        # A taper, without which the sum would end abruptly and ring.
        placed = (np.exp(-7.0 * (k * spacing / np.pi) ** 8) * np.exp(-1j * k * (first - origin)))[
            :, None
        ]
        placed[0] /= 2  # the mean is counted at q and at -q
        s, block = levels.frequencies, max(1, BLOCK // levels.size)
        waves = dict[tuple[str, bool], Complex]()
        for name, means in rates.items():
            lines = levels.lines(means)[: len(k)]
            # what contains i q changes its sign with q
            odd = {"Z": False} if name == "z" else {"P": name == "x", "S": name == "y"}
            for wave, is_odd in odd.items():
                for part in [is_odd] if even else [False, True]:
                    waves.setdefault((wave, part), np.zeros((len(k), len(s)), dtype=complex))
            for start in range(0, len(k), block):
                here = slice(start, start + block)
                ahead, back = levels.transformed(lines[here])
                ahead *= placed[here]
                back *= placed[here].conj()
                drives: tuple[Any, ...] = (-0.5 if lower else 0.5,)  # v_z of either face
                if name != "z":
                    drives = potentials(bodies, lower, q[here, None], s, name == "y")
                for (wave, is_odd), drive in zip(odd.items(), drives, strict=True):
                    both, apart = ahead + back, 1j * (ahead - back)
                    waves[wave, is_odd][here] += drive * (1j * both if is_odd else both)
                    if not even:
                        other = apart if not is_odd else ahead - back
                        waves[wave, not is_odd][here] += drive * other
        return cls(levels, bodies[lower and len(bodies) - 1], q, waves, origin)

    @cached_property
    def _k(self) -> Array:
        """Wavenumbers of the phases along x, of which the first is 0, (n,) [1 / length]."""
        return np.concatenate([[0.0], self.q[1:]])

    def _terms(self, asked: Asked) -> list[list[Term]]:
        rows = terms_of(asked, self.body)
        known = {name for name, _ in self.waves}
        return [[term for term in row if term.wave in known] for row in rows]

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
            (term.wave, term.turns, term.falls): np.zeros((len(x), len(s)), dtype=complex)
            for row in rows
            for term in row
        }
        block = max(1, BLOCK // len(s))
        for start in range(0, len(self.q), block):
            part = slice(start, start + block)
            seen = slice(self._first(self.q[start], depth), None)
            roots = decays(self.body, self.q[part, None], s[seen])
            angle = np.multiply.outer(x - self.origin, self._k[part])
            along = np.cos(angle), np.sin(angle)
            falling = {}
            for (wave, odd), amplitudes in self.waves.items():
                decay = roots[wave != "P"]
                if wave not in falling:
                    falling[wave] = np.exp(-depth * decay)
                sent = [amplitudes[part, seen] * falling[wave]]
                for (name, turns, falls), total in sums.items():
                    if name == wave:
                        if falls and len(sent) < 2:
                            sent.append(decay * sent[0])
                        # derivatives along x turn cosines into sines, in real numbers
                        factors = (
                            TURNS[odd][turns] * self.q[part] ** turns * along[odd != turns % 2]
                        )
                        total.view(float)[:, 2 * seen.start :] += factors @ sent[falls].view(float)
        found = np.zeros((len(rows), len(x), len(s)), dtype=complex)
        for row, terms in zip(found, rows, strict=True):
            for term in terms:
                row += term.coefficient * s**term.power * sums[term.wave, term.turns, term.falls]
        t = levels.step * np.arange(levels.count + 1)
        values = irfft(found, levels.size, axis=-1)[..., : len(t)]
        return np.asarray(values * (np.exp(levels.fall * t) / levels.step))

    def picture(self, asked: Asked, x: Array, depths: Array, time: float) -> Array:
        """Return a field at points (p,) at one time, (rows, p); `depths` are as of `histories`."""
        # rows on both sides of the interface are equally deep, but for rounding
        keys = np.rint(depths / (1e-9 * depths.max(initial=1e-300)))
        _, chosen, place = np.unique(keys, return_index=True, return_inverse=True)
        levels, place, weight = depths[chosen], place[:, None], np.ones((len(depths), 1))
        if len(levels) > DEPTHS:
            levels = np.linspace(levels[0], levels[-1], DEPTHS)
            place, weight = between((depths - levels[0]) / (levels[1] - levels[0]), DEPTHS, DEGREE)
        amplitudes = self._amplitudes(asked, levels, time - self.levels.start)
        at, which = np.unique(x, return_inverse=True)
        shared = len(at) <= 4 * len(levels)  # points of a picture that lie above one another
        phases = np.exp(1j * np.multiply.outer((at if shared else x) - self.origin, self._k))
        found = np.zeros((amplitudes.shape[1], len(x)))
        order = np.argsort(place[:, 0], kind="stable")
        ends = np.searchsorted(place[order, 0], np.arange(len(levels) + 1))
        for first, (begin, end) in enumerate(pairwise(ends.tolist())):
            here = order[begin:end]
            along = phases[which[here] if shared else here]
            for step in range(weight.shape[1] if len(here) else 0):
                values = (along @ amplitudes[first + step].T).real
                found[:, here] += weight[here, step] * values.T
        return found

    def _amplitudes(self, asked: Asked, depths: Array, time: float) -> Complex:
        """Return amplitudes of exp(i q x), whose real parts add up, (depths, rows, wavenumbers)."""
        rows, s = self._terms(asked), self.levels.frequencies
        wave = np.exp(s * time) * (2 / (self.levels.size * self.levels.step))
        wave[0] /= 2
        found = np.zeros((len(depths), len(rows), len(self.q)), dtype=complex)
        terms = [(place, term) for place, row in enumerate(rows) for term in row]
        for index, q in enumerate(self.q):
            counts = slice(self._first(q, depths[0]), None)
            roots = decays(self.body, q, s[counts])
            for (name, odd), amplitudes in self.waves.items():
                own = [term for term in terms if term[1].wave == name]
                decay, sent = roots[name != "P"], amplitudes[index, counts] * wave[counts]
                factors = [term.factor(q, decay, s[counts]) for _, term in own]
                sums = laid_down(depths, decay, np.stack([factor * sent for factor in factors]))
                for column, (row, term) in enumerate(own):
                    # the real part of what goes like a sine is that of -i exp(i q x)
                    turned = (1j * q) ** term.turns * term.coefficient * (-1j if odd else 1.0)
                    found[:, row, index] += turned * sums[:, column].real
        return found


def steady(
    asked: Asked,
    bodies: tuple[Material, ...],
    lower: bool,
    first: float,
    spacing: float,
    moved: Mapping[str, Array],
    x: Array,
    depths: Array,
    held: float = 0.0,
) -> Array:
    """Return the static field of slip "x" or "z" and opening "y" at nodes (n,), (rows, p).

    It is the velocity if these are rates; all else is as of `Spectrum.of` and `picture`.
    """
    body, nodes = bodies[lower and len(bodies) - 1], len(next(iter(moved.values())))
    k = 2 * np.pi / (nodes * spacing) * np.arange(nodes // 2)
    q = np.append(held, k[1:])
    # so slow that waves obey statics to 1e-8, and not so slow that digits cancel
    s = 1e-4 * body.shear_speed * np.maximum(q, 1e-3 * k[1])
    roots, amplitudes = decays(body, q, s + 0j), dict[str, Complex]()
    placed = np.exp(-1j * k * first) / nodes * (1.0 if asked == "velocity" else s)
    for name, values in moved.items():
        rate = np.fft.rfft(values)[: len(k)] * placed
        rate[0] /= 2  # the mean is counted at q and at -q
        drives: tuple[Any, ...] = (-0.5 if lower else 0.5,)
        if name != "z":
            drives = potentials(bodies, lower, q, s + 0j, name == "y")
        for wave, drive in zip("Z" if name == "z" else "PS", drives, strict=True):
            amplitudes[wave] = amplitudes.get(wave, 0.0) + drive * rate
    rows = [[term for term in row if term.wave in amplitudes] for row in terms_of(asked, body)]
    found, levels = np.zeros((len(rows), len(x))), depths.tolist()
    for depth in set(levels):
        here = depths == depth
        waves = np.exp(1j * np.multiply.outer(x[here], k))
        for row, terms in zip(found, rows, strict=True):
            for term in terms:
                decay = roots[term.wave != "P"]
                sent = amplitudes[term.wave] * term.factor(q, decay, s) * np.exp(-decay * depth)
                row[here] += 2 * (waves @ (term.coefficient * (1j * q) ** term.turns * sent)).real
    return found


def laid_down(depths: Array, decay: Complex, sent: Complex) -> Complex:
    """Return the sums over frequencies at depths (d,) of waves (k, m) that fall off, (d, k).

    For many evenly spaced depths about sqrt(d) exponentials are formed from one.
    """
    count, step = math.isqrt(len(depths)), depths[-1] - depths[0]
    even = depths[0] + step * np.linspace(0.0, 1.0, len(depths))
    if count < 4 or np.abs(depths - even).max() > 1e-8 * step:
        return np.asarray(np.exp(-np.multiply.outer(depths, decay)) @ sent.T)
    powers, once = np.ones((count, len(decay)), complex), np.exp(-step / (len(depths) - 1) * decay)
    for before, after in pairwise(powers):
        np.multiply(before, once, out=after)
    found = np.empty((len(depths), len(sent)), complex)
    sent, leap = sent * np.exp(-depths[0] * decay), once * powers[-1]
    for start in range(0, len(depths), count):
        part = found[start : start + count]
        part[:] = (powers @ sent.T)[: len(part)]
        sent *= leap
    return found


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
    for node in order:
        others = order != node
        weight[:, node] = np.prod(offset[:, others] / (node - order[others]), axis=1)
    return first[:, None] + order, weight
