"""Fields in a body as sums of waves over wavenumbers and frequencies (`transfer`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.bodies.motion import Levels
from semianalytic.engine.bodies.transfer import FALLEN, decays, driven, laid_down
from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.scene import Material

Asked = Literal["velocity", "displacement", "strain"]

BLOCK, TOGETHER = 1 << 14, 16
"""Pairs of wavenumber and frequency that are formed at once, and wavenumbers among them: they stay
in the cache."""
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
    """Waves in the bodies of a line whose faces move against each other.

    A rate of amplitudes F at q and G at -q, and its derivatives along x of even order, go like

        (F + G) cos(q x) + i (F - G) sin(q x).

    Attributes
    ----------
    levels : Levels
        Times of the transform.
    bodies : one or two Material
    q : (n,) array
        Wavenumbers [1 / length]; the first is 0, or that of the stiffness that holds the mean.
    rates : mapping of (n, frequencies) arrays
        Slip rate "x" or "z" and opening rate "y", each with False for its F + G and True for its
        i (F - G).  A line that is even about its origin lacks what is 0.
    origin : float
        Position at which phases are 0 [length].
    """

    levels: Levels
    bodies: tuple[Material, ...]
    q: Array
    rates: Mapping[tuple[str, bool], Complex]
    origin: float

    @classmethod
    def of(
        cls,
        levels: Levels,
        bodies: tuple[Material, ...],
        first: float,
        spacing: float,
        rates: Mapping[str, Array],
        held: float = 0.0,
        centre: float | None = None,
    ) -> Spectrum:
        """Make the spectrum of a line.

        Parameters
        ----------
        levels : Levels
        bodies : one or two Material
        first, spacing : float
            Position of the first node, and node distance [length].
        rates : mapping of (count, nodes) arrays
            Mean slip rates "x" or "z" and opening rates "y" between the levels [length / time].
        held : float
            Wavenumber of the stiffness that the mean meets [1 / length].
        centre : float, optional
            Position about which the line is even [length].
        """
        origin = centre or 0.0
        nodes = next(iter(rates.values())).shape[1]
        k = 2 * np.pi / (nodes * spacing) * np.arange(nodes // 2)
        q = k.copy()
        q[0] = held
        # A taper, without which the sum would end abruptly and ring.
        taper = np.exp(-7.0 * (k * spacing / np.pi) ** 8)
        placed = (2 / nodes * taper * np.exp(-1j * k * (first - origin)))[:, None]
        placed[0] /= 2  # the mean is counted once
        count = len(levels.frequencies)
        parts = (False,) if centre is not None else (False, True)
        found = dict[tuple[str, bool], Complex]()
        for name, means in rates.items():
            lines = levels.lines(means)
            found |= {(name, part): np.empty((len(k), count), dtype=complex) for part in parts}
            for start in range(0, len(k), TOGETHER):
                here = slice(start, start + TOGETHER)
                line = lines[here] * placed[here]
                # F + G is the transform of the cosines' amplitudes, i (F - G) of the sines'
                for part in parts:
                    found[name, part][here] = levels.transformed(-line.imag if part else line.real)
        return cls(levels, bodies, q, found, origin)

    @cached_property
    def _k(self) -> Array:
        """Wavenumbers of the phases along x, of which the first is 0, (n,) [1 / length]."""
        return np.concatenate([[0.0], self.q[1:]])

    def _terms(self, lower: bool, asked: Asked) -> list[list[Term]]:
        known = {wave for name, _ in self.rates for wave in ("Z" if name == "z" else "PS")}
        rows = terms_of(asked, self.bodies[lower and len(self.bodies) - 1])
        return [[term for term in row if term.wave in known] for row in rows]

    def _first(self, lower: bool, q: float, depth: float) -> int:
        """Return the first frequency whose waves count at a wavenumber and a depth."""
        if q * depth <= FALLEN:
            return 0
        speed = self.bodies[lower and len(self.bodies) - 1].shear_speed
        omega = speed * math.sqrt(q * q - (FALLEN / depth) ** 2)
        return int(omega / self.levels.frequencies[1].imag)

    def _sent(
        self, lower: bool, here: slice, counts: slice
    ) -> tuple[dict[tuple[str, bool], Complex], dict[str, Complex]]:
        """Return waves at the face of a body, seen as if it lay above, and the decays of each kind.

        Waves are Phi as "P" and Psi as "S", v_z as "Z", with False and True as of the rates, at
        some wavenumbers and frequencies.
        """
        q, s = self.q[here, None], self.levels.frequencies[counts]
        roots = decays(self.bodies[lower and len(self.bodies) - 1], q, s)
        waves, names = dict[tuple[str, bool], Complex](), {name for name, _ in self.rates}
        for (name, wave), drive in driven(self.bodies, lower, q, s, names, roots).items():
            # what contains i q turns cosines into sines, and changes its sign with q
            odd = (name, wave) in {("x", "P"), ("y", "S")}
            for part in (False, True):
                if (name, part) in self.rates:
                    turned = drive * (1j - 2j * part) if odd else drive
                    own = turned * self.rates[name, part][here, counts]
                    key = wave, part != odd
                    waves[key] = waves[key] + own if key in waves else own
        return waves, dict(zip("PSZ", (*roots, roots[1]), strict=True))

    def histories(self, lower: bool, asked: Asked, x: Array, depth: float) -> Array:
        """Return a field at all levels of the transform, (rows, points, count + 1).

        Parameters
        ----------
        lower : bool
            Whether it is that in the lower body.
        asked : {"velocity", "displacement", "strain"}
        x : (points,) array
        depth : float
            Distance from the face [length].
        """
        from scipy.fft import irfft  # here, for `import semianalytic` is to be quick

        s, rows, levels = self.levels.frequencies, self._terms(lower, asked), self.levels
        # sums over wavenumbers, before the powers of s
        sums = {
            (term.wave, term.turns, term.falls): np.zeros((len(x), len(s)), dtype=complex)
            for row in rows
            for term in row
        }
        for start in range(0, len(self.q), TOGETHER):
            part = slice(start, start + TOGETHER)
            angle = np.multiply.outer(x - self.origin, self._k[part])
            along = np.cos(angle), np.sin(angle)
            for begin in range(self._first(lower, self.q[start], depth), len(s), BLOCK // TOGETHER):
                seen = slice(begin, begin + BLOCK // TOGETHER)
                waves, roots = self._sent(lower, part, seen)
                for wave in dict.fromkeys(wave for wave, _ in waves):
                    parts = [odd for name, odd in waves if name == wave]
                    falling = np.exp(-depth * roots[wave])
                    sent = [np.concatenate([falling * waves[wave, odd] for odd in parts])]
                    for (name, turns, falls), total in sums.items():
                        if name != wave:
                            continue
                        if falls and len(sent) < 2:
                            sent.append(np.tile(roots[wave], (len(parts), 1)) * sent[0])
                        # derivatives along x turn cosines into sines, in real numbers
                        turned = [TURNS[odd][turns] * along[odd != turns % 2] for odd in parts]
                        factors = np.concatenate(
                            [self.q[part] ** turns * each for each in turned], 1
                        )
                        total[:, seen].view(float)[:] += factors @ sent[falls].view(float)
        found = np.zeros((len(rows), len(x), len(s)), dtype=complex)
        for row, terms in zip(found, rows, strict=True):
            for term in terms:
                row += term.coefficient * s**term.power * sums[term.wave, term.turns, term.falls]
        t = levels.step * np.arange(levels.count + 1)
        values = irfft(found, levels.size, axis=-1)[..., : len(t)]
        return np.asarray(values * (np.exp(levels.fall * t) / levels.step))

    def picture(self, lower: bool, asked: Asked, x: Array, depths: Array, time: float) -> Array:
        """Return a field at points (p,) at one time, (rows, p); all else is as of `histories`."""
        # rows on both sides of the interface are equally deep, but for rounding
        keys = np.rint(depths / (1e-9 * depths.max(initial=1e-300)))
        _, chosen, place = np.unique(keys, return_index=True, return_inverse=True)
        levels, place, weight = depths[chosen], place[:, None], np.ones((len(depths), 1))
        if len(levels) > DEPTHS:
            levels = np.linspace(levels[0], levels[-1], DEPTHS)
            place, weight = between((depths - levels[0]) / (levels[1] - levels[0]), DEPTHS, DEGREE)
        amplitudes = self._amplitudes(lower, asked, levels, time - self.levels.start)
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

    def _amplitudes(self, lower: bool, asked: Asked, depths: Array, time: float) -> Complex:
        """Return amplitudes of exp(i q x), whose real parts add up, (depths, rows, wavenumbers)."""
        rows, s = self._terms(lower, asked), self.levels.frequencies
        at = np.exp(s * time) * (2 / (self.levels.size * self.levels.step))
        at[0] /= 2
        found = np.zeros((len(depths), len(rows), len(self.q)), dtype=complex)
        terms = [(place, term) for place, row in enumerate(rows) for term in row]
        scales = {term.power: s**term.power * at for _, term in terms}
        for index, q in enumerate(self.q):
            counts = slice(self._first(lower, q, depths[0]), None)
            waves, roots = self._sent(lower, slice(index, index + 1), counts)
            for name in dict.fromkeys(name for name, _ in waves):
                own = [(row, term) for row, term in terms if term.wave == name]
                parts = [odd for wave, odd in waves if wave == name]
                factors = {
                    (term.falls, term.power): scales[term.power][counts]
                    * roots[name][0] ** term.falls
                    for _, term in own
                }
                sent = [waves[name, odd] * factor for odd in parts for factor in factors.values()]
                sums = laid_down(depths, roots[name][0], np.concatenate(sent))
                columns = list(product(parts, factors))
                for odd, (row, term) in product(parts, own):
                    # the real part of what goes like a sine is that of -i exp(i q x)
                    turned = (1j * q) ** term.turns * term.coefficient * (-1j if odd else 1.0)
                    column = columns.index((odd, (term.falls, term.power)))
                    found[:, row, index] += turned * sums[:, column]
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
    placed[0] /= 2  # the mean is counted at q and at -q
    for (name, wave), drive in driven(bodies, lower, q, s + 0j, moved, roots).items():
        sent = drive * np.fft.rfft(moved[name])[: len(k)] * placed
        amplitudes[wave] = amplitudes.get(wave, 0.0) + sent
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
