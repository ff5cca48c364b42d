"""Integrals of the densities of waves from a fixed point to any k of the upper half-plane.

They are analytic there, and singular at a few points of the real axis: wave fronts, zone edges, 0.
Around each of these the half-plane is divided into cells along lines of ln(k - centre); in each
cell, powers and logarithms are polynomials of low degree, down to the centre.  Cells are formed
when a point falls into them.  Each takes its constant of integration from the neighbour nearer to
where it is known, between 0 and -a, where no wave has arrived yet.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from semianalytic.field import tuning
from semianalytic.field.sources import Source
from semianalytic.field.transform import powers
from semianalytic.field.waves import Complex
from semianalytic.scene.arrays import Array


class Cell(NamedTuple):
    """A cell, by its centre, the side of the centre (1 left, 0 right), its level and its sector.

    Centre -1 stands for the cells far outside, around 0 in all sectors from the right.
    """

    centre: int
    left: int
    level: int
    sector: int


_STEP = np.pi / tuning.SECTORS
"""Size of a cell in ln(k - centre), real and imaginary."""
_HALF = _STEP / np.sqrt(2.0)
"""Half the diagonal of a cell."""
_QUARTER = tuning.SECTORS // 2


@lru_cache(maxsize=2)
def _pattern(degree: int, per_side: int) -> tuple[Complex, Complex]:
    """Return nodes (m,) on a border, over half a diagonal, and the matrix to coefficients."""
    side = np.cos(np.pi * (np.arange(per_side) + 0.5) / per_side)
    corner = 1 / np.sqrt(2.0)
    nodes = np.concatenate([(side + 1j) * corner * 1j**turn for turn in range(4)])
    powers = nodes[:, None] ** np.arange(degree + 1)
    # A polynomial that is right on the border is right inside: densities are analytic there.
    return nodes, np.asarray(np.linalg.pinv(powers), dtype=complex)


_Link = tuple[Cell, complex, complex]
"""Cell from which another takes its constant, and a common point of both, as ln(k - centre) of the
other and of the first."""


@dataclass(frozen=True)
class Primitives:
    """Integrals of all densities (see `waves`), and the density of v_x in the S wave."""

    source: Source
    _cells: dict[Cell, Complex] = field(default_factory=dict, repr=False)

    @property
    def reach(self) -> float:
        """Slowness of the slowest front or zone edge."""
        return self._extent / 2

    @cached_property
    def _extent(self) -> float:
        """Value of |k| from which on all centres are near 0."""
        return 2 * float(np.abs(self.source.places).max())

    @cached_property
    def _gaps(self) -> Array:
        """Distances (c, 2) of each centre to its neighbours on the right and on the left."""
        between, far = self.source.between, 2 * self._extent
        return np.array([[*between, far], [far, *between]]).T

    @cached_property
    def _tops(self) -> Array:
        """Logarithms (c, 2) of the radius of each side of a centre near the axis."""
        return np.log(self._gaps / (2 * np.cos(_STEP)))

    def _nearest(self, k: Complex) -> np.ndarray:
        """Return the centres (m,) nearest to points."""
        return np.searchsorted((self.source.places[1:] + self.source.places[:-1]) / 2, k.real)

    def at_centre(self, k: Complex) -> np.ndarray:
        """Return (m,) whether points coincide with a centre to rounding."""
        result = np.zeros(k.shape, dtype=bool)
        # Only points near the axis can coincide with one on it.
        few = np.flatnonzero(np.abs(k.imag) <= tuning.SAME * self._extent)
        places = self.source.places[self._nearest(k[few])]
        result[few] = np.abs(k[few] - places) <= tuning.SAME * np.abs(places)
        return result

    def located(self, k: Complex, close: float) -> tuple[np.ndarray, Complex]:
        """Return the cells (4, m) of points (m,), and ln(k - centre), no closer than `close`."""
        centre, far = self._nearest(k), np.abs(k) > self._extent
        offset = np.where(far, k, k - self.source.places[centre])
        # ln 0 at a singular point; the caller says how near to it fields are taken.
        offset = np.where(self.at_centre(k), close, offset)
        log = np.log(np.abs(offset)) + 1j * np.angle(offset)
        left = ~far & (log.imag > np.pi / 2)
        angle = np.where(left, np.pi - log.imag, log.imag)
        last = np.where(far, 2 * _QUARTER, _QUARTER) - 1
        sector = np.clip((angle / _STEP).astype(int), 0, last)
        top = np.where(far, np.log(self._extent), self._tops[centre, left.astype(int)])
        level = np.ceil((log.real - top) / _STEP).astype(int)
        level = np.where(~far & (sector == 0), np.minimum(level, 0), level)
        level = np.where(far, np.maximum(level, 1), level)
        return np.stack([np.where(far, -1, centre), left, level, sector]), log

    def _level(self, centre: int, left: int, log: float) -> int:
        """Return the level of a side at a radius, given by its logarithm."""
        return int(np.ceil((log - self._tops[centre, left]) / _STEP))

    def _middle(self, cell: Cell) -> complex:
        """Return ln(k - centre) in the middle of a cell."""
        far = cell.centre < 0
        top = float(np.log(self._extent)) if far else float(self._tops[cell.centre, cell.left])
        angle = (cell.sector + 0.5) * _STEP
        return complex(top + (cell.level - 0.5) * _STEP, np.pi - angle if cell.left else angle)

    def _link(self, cell: Cell) -> _Link | None:
        """Return the cell from which another takes its constant, and a common point of both."""
        centre, left, level, sector = cell
        middle = self._middle(cell)
        if centre < 0:
            inner = middle - _STEP / 2
            if level > 1:
                return cell._replace(level=level - 1), inner, inner
            # Just inside the border, or rounding could find the outer cell again.
            k = np.array([np.exp(inner) * (1 - 1e-12)])
            key, log = self.located(k, tuning.CLOSE[0])
            return Cell(*key[:, 0].tolist()), inner, complex(log[0])
        home = int(centre >= self.source.parting)
        base = 0 if left == home else self._level(centre, left, self._tops[centre].min())
        if level != base:
            step = -1 if level > base else 1
            between = middle + step * _STEP / 2
            return cell._replace(level=level + step), between, between
        turn = 1j * _STEP / 2 * (-1 if left else 1)
        if left != home:
            if sector < _QUARTER - 1:
                return cell._replace(sector=sector + 1), middle + turn, middle + turn
            between = complex(middle.real, np.pi / 2)
            level = self._level(centre, home, between.real)
            return Cell(centre, home, level, sector), between, between
        if sector:
            return cell._replace(sector=sector - 1), middle - turn, middle - turn
        # The chain of constants ends here: left of this point no wave has come, and all is known.
        if centre == self.source.parting:
            return None
        half = np.log(self._gaps[centre, left] / 2)
        next_one = centre - 1 if left else centre + 1
        facing = Cell(next_one, 1 - left, 0, 0)
        return facing, complex(half, np.pi * left), complex(half, np.pi * (1 - left))

    def _missing(self, cells: list[Cell]) -> dict[Cell, _Link | None]:
        """Return missing cells and those before them, in order, with links to their constants."""
        order: dict[Cell, _Link | None] = {}
        for cell in cells:
            chain: dict[Cell, _Link | None] = {}
            at: Cell | None = cell
            while at is not None and at not in self._cells and at not in order:
                chain[at] = link = self._link(at)
                at = link[0] if link else None
            order.update(reversed(chain.items()))
        return order

    def _form(self, links: Mapping[Cell, _Link | None]) -> None:
        """Add cells, each after the one of its constant; threads may form the same one."""
        cells, count = list(links), len(self._pattern[1])
        fresh = np.empty((len(cells), count + 1, len(self.source.ahead)), dtype=complex)
        middles = np.array([self._middle(cell) for cell in cells])
        offsets = np.exp(middles[:, None] + _HALF * self._pattern[0])
        # Rounding must not take a node below the axis, where the densities continue on another
        # sheet.
        offsets = offsets.real + 1j * np.maximum(offsets.imag, 0.0)
        largest = np.maximum(np.abs(offsets).max(axis=1), 1.0)
        sizes = np.floor(np.log(largest) / np.log(tuning.SCALES))
        owners = np.array([cell.centre for cell in cells])
        for owner in np.unique(owners):
            for size in np.unique(sizes[owners == owner]):
                these = np.flatnonzero((owners == owner) & (sizes == size))
                scale = tuning.SCALES ** float(size + 1)
                fresh[these] = self._coefficients(int(owner), offsets[these], scale)
        self._add_constants(links, fresh, middles)
        self._cells.update(zip(cells, fresh, strict=True))

    def _coefficients(self, owner: int, offsets: Complex, scale: float) -> Complex:
        """Return the polynomials (c, n, f) of cells around a centre, with arbitrary constants."""
        matrix, kept = self._pattern[1], self.source.kept
        values = self.source.densities(owner, offsets, scale)
        # dk = (k - centre) d ln(k - centre), and the unit of the polynomials is half a diagonal.
        integrands = np.ascontiguousarray(np.moveaxis(values * (offsets * _HALF), 0, -1))
        grown = matrix @ integrands
        grown /= np.arange(1.0, len(matrix) + 1)[:, None]
        coefs = np.concatenate([np.zeros_like(grown[:, :1]), grown], axis=1)
        if kept is not None:
            series = matrix @ values[kept][..., None]
            coefs[:, :-1, kept], coefs[:, -1, kept] = series[..., 0], 0.0
        return coefs

    def _add_constants(
        self, links: Mapping[Cell, _Link | None], fresh: Complex, middles: Complex
    ) -> None:
        """Set constants of new cells (c, n, f), whose digits do not depend on other new ones."""
        numbers, kept = {cell: number for number, cell in enumerate(links)}, self.source.kept
        count, own, there = fresh.shape[1] - 1, np.copy(middles), np.copy(middles)
        others = np.zeros_like(fresh[:, 1:])
        constants: list[Complex] = [self.source.ahead] * len(links)
        before: list[int | None] = [None] * len(links)
        for number, (cell, link) in enumerate(links.items()):
            if link is None:
                own[number] = complex(np.log(self._gaps[cell.centre, cell.left] / 2), np.pi)
                continue
            other, own[number], at = link
            there[number] += at - self._middle(other)
            before[number] = numbers.get(other)
            coefs = self._cells[other] if before[number] is None else fresh[numbers[other]]
            others[number], constants[number] = coefs[1:], coefs[0]
        at_own, at_other = (
            np.vander(within, count + 1, increasing=True)[:, None, 1:]
            for within in ((own - middles) / _HALF, (there - middles) / _HALF)
        )
        changes = (at_other @ others - at_own @ fresh[:, 1:])[:, 0]
        for number, earlier in enumerate(before):
            # the earlier one comes first, so that it has its constant
            constant = constants[number] if earlier is None else fresh[earlier, 0]
            continuing = constant + changes[number]
            if kept is not None:
                continuing[kept] = fresh[number, 0, kept]
            fresh[number, 0] = continuing

    @cached_property
    def _pattern(self) -> tuple[Complex, Complex]:
        if self.source.is_coarse:
            # Coarse cells are up to 3e-7 off fine ones in seven scenes, in three fifths of the
            # time; with 6 and 4 they are 2e-4 off in a tenth less.
            return _pattern(12, 5)
        # Limits on the interface at rtol 1e-11 are then off by 4e-13 to 4e-12, as with 24 and 20; a
        # degree of 18 leaves 1e-10, 8 nodes leave 1e-12.
        return _pattern(22, 10)

    def __call__(self, k: Complex, close: float, mix: Array | Complex) -> Array:
        """Return imaginary parts of `mix` (g, f) of integrals at k (m,), or `close` to poles."""
        parting, (left, right) = self.source.places[self.source.parting], self.source.still
        still = (k.imag == 0) & (left < k.real) & (k.real < right) & (k != parting)
        if not still.any():
            return self._looked_up(k, close, mix)
        result = np.empty((len(mix), len(k)))
        ahead, behind = (mix @ self.source.ahead).imag, (mix @ self.source.behind).imag
        result[:, still] = np.where(k[still].real < parting, ahead[:, None], behind[:, None])
        result[:, ~still] = self._looked_up(k[~still], close, mix)
        return result

    def _looked_up(self, k: Complex, close: float, mix: Array | Complex) -> Array:
        """Return sums of integrals (g, m) where waves have come, from the cells."""
        if not len(k):
            return np.empty((len(mix), 0))
        keys, logs = self.located(k, close)
        # Keys of a cell are small integers, and one number for each cell is smaller still.
        least = keys.min(axis=1, keepdims=True)
        codes = np.ravel_multi_index(tuple(keys - least), np.ptp(keys, axis=1) + 1)
        # A stable sort of short integers takes time proportional to their number.
        order = np.argsort(codes.astype(np.uint16) if codes.max() < 2**16 else codes, kind="stable")
        starts = np.flatnonzero(np.diff(codes[order], prepend=-1))
        cells = [Cell(*key) for key in keys[:, order[starts]].T.tolist()]
        missing = self._missing(cells)
        if missing:
            self._form(missing)
        grouped, logs = np.empty((len(mix), len(k))), logs[order]
        for cell, here in zip(cells, map(slice, starts, [*starts[1:], len(k)]), strict=True):
            # Integrals are polynomials in ln(k - centre).
            within, coefs = (logs[here] - self._middle(cell)) / _HALF, self._cells[cell]
            grouped[:, here] = (mix @ coefs.T @ powers(within, len(coefs))).imag
        result = np.empty_like(grouped)
        result[:, order] = grouped
        return result
