"""Integrals of the densities of waves from a fixed point to any k of the upper half-plane.

They are analytic there, and singular at a few points of the real axis: wave fronts, zone edges, 0.
Around each of these the half-plane is divided into cells along lines of ln(k - centre), and, far
above them all, around the one that parts what is ahead from what is behind; in each cell, powers
and logarithms are polynomials of low degree, down to the centre.  Cells are formed when a point
falls into them.  Each takes its constant of integration from a neighbour: up to the cells far
above, from these inwards, and at last from where no wave has arrived yet, left of this point.
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
    """A cell, by a side of a centre, its level and its sector.

    Sides 2 i and 2 i + 1 are left and right of centre i; there sectors begin at the axis, and level
    0 ends where the next centre is.  Side -1 is around the parting point, far from all centres, in
    all sectors from the right.
    """

    side: int
    level: int
    sector: int


_STEP = np.pi / tuning.SECTORS
"""Size of a cell in ln(k - centre), real and imaginary."""
_QUARTER = tuning.SECTORS // 2
_NARROW = 2
"""Levels from the next centre inwards of cells of this size; those further in fill a quarter."""


@lru_cache(maxsize=2)
def _pattern(degree: int, per_side: int) -> tuple[Complex, Complex]:
    """Return nodes (m,) on a border, over half a diagonal, and the matrix to coefficients."""
    side = np.cos(np.pi * (np.arange(per_side) + 0.5) / per_side)
    corner = 1 / np.sqrt(2.0)
    nodes = np.concatenate([(side + 1j) * corner * 1j**turn for turn in range(4)])
    powers = nodes[:, None] ** np.arange(degree + 1)
    # A polynomial that is right on the border is right inside: densities are analytic there.
    return nodes, np.asarray(np.linalg.pinv(powers), dtype=complex)


_Link = tuple[Cell | None, complex, complex]
"""Cell from which another takes its constant, None if nothing has come there, and a common point,
as the polynomials of the other and of the first take it."""


@dataclass(frozen=True)
class Primitives:
    """Integrals of all densities (see `waves`), and the density of v_x in the S wave."""

    source: Source
    # middles of cells, half their diagonals, and coefficients (n, f) in units of these
    _cells: dict[Cell, tuple[complex, float, Complex]] = field(default_factory=dict, repr=False)

    @cached_property
    def reach(self) -> float:
        """Slowness of the slowest front or zone edge."""
        return float(np.abs(self.source.places).max())

    @cached_property
    def _extent(self) -> float:
        """Distance from the parting point from which on all centres are near it."""
        return 2 * float(np.abs(self.source.places - self._places[-1]).max())

    @cached_property
    def _tops(self) -> Array:
        """Logarithms (2 c + 1,) of the radius of each side near the axis, and of that far out."""
        gaps = np.repeat([2 * self._extent, *self.source.between, 2 * self._extent], 2)[1:-1]
        return np.log([*gaps / (2 * np.cos(_STEP)), self._extent])

    @cached_property
    def _places(self) -> Array:
        """Values (2 c + 1,) of k at the centre of each side, and at the parting point."""
        return self.source.places[
            [*np.repeat(range(len(self.source.places)), 2), self.source.parting]
        ]

    def _from_nearest(self, k: Complex) -> tuple[np.ndarray, Complex, np.ndarray]:
        """Return the centres (m,) nearest to points, k - centre, and whether both coincide."""
        places = self.source.places
        # a search takes four times as long for points in no order
        centre = np.sum([k.real > border for border in (places[1:] + places[:-1]) / 2], axis=0)
        offset = k - places[centre]
        return centre, offset, np.abs(offset) <= (tuning.SAME * np.abs(places))[centre]

    def at_centre(self, k: Complex) -> np.ndarray:
        """Return (m,) whether points coincide with a centre to rounding."""
        return self._from_nearest(k)[2]

    def located(self, k: Complex, close: float) -> tuple[np.ndarray, Complex]:
        """Return the cells (3, m) of points (m,), and ln(k - centre), no closer than `close`."""
        centre, offset, same = self._from_nearest(k)
        # ln 0 at a singular point; the caller says how near to it fields are taken.
        offset[same] = close
        side = 2 * centre + (offset.real >= 0)
        far = self._is_far(k, np.abs(offset) > np.exp(self._tops)[side])
        side, offset = np.where(far, -1, side), np.where(far, k - self._places[-1], offset)
        log = np.log(np.abs(offset)) + 1j * np.angle(offset)
        return self._holding(side, log), log

    def _is_far(self, k: Complex, above: np.ndarray) -> np.ndarray:
        """Return (m,) whether points, `above` level 0 of a side or not, are as far from all."""
        offset = k - self._places[-1]
        upright = k.imag > np.tan(_STEP) * np.abs(offset.real)
        return np.asarray((np.abs(offset) > self._extent) | above & upright)

    def _holding(self, side: np.ndarray, log: Complex) -> np.ndarray:
        """Return the cells (3, m) of sides (m,) that hold points ln(k - centre)."""
        steps, far = (log.real - self._tops[side]) / _STEP, side < 0
        level = np.ceil(steps).astype(int)
        wide = (level <= -_NARROW) & ~far
        level = np.where(wide, (level + _NARROW + _QUARTER - 1) // _QUARTER - _NARROW, level)
        angle = np.abs(np.pi * (side % 2 == 0) - log.imag)
        sector = np.minimum((angle / _STEP).astype(int), _QUARTER * (1 + far) - 1)
        return np.stack([side, level, np.where(wide, 0, sector)])

    def _squares(self, cells: np.ndarray) -> tuple[Complex, Array]:
        """Return the middles of cells (3, m) in ln(k - centre), and half their diagonals."""
        side, level, sector = cells
        wide = (level <= -_NARROW) & (side >= 0)
        size = np.where(wide, _QUARTER, 1) * _STEP
        end = _STEP * np.where(wide, _QUARTER * (level + _NARROW) - _NARROW, level)
        angle = np.abs(np.pi * (side % 2 == 0) - (sector + 0.5) * size)
        return self._tops[side] + end - size / 2 + 1j * angle, size / np.sqrt(2.0)

    def _links(self, cells: np.ndarray) -> list[_Link]:
        """Return the cells from which cells (3, m) take their constants, and common points."""
        (side, level, sector), parting = cells, 2 * self.source.parting
        middles, halves = self._squares(cells)
        turn, home = middles.imag - np.pi / 2, side // 2 == self.source.parting
        upright, onwards = np.abs(turn) < 0.8 * halves, np.where(side % 2, 1j, -1j)
        # upright cells lead straight to those far above, or up; those far out lead back in their
        # sector, for errors of large integrals would add up on another path to the slot faces
        across = np.exp(middles + onwards * halves / np.sqrt(2.0)) + self._places[side]
        leaves = upright & ~home & (side >= 0)
        beside = np.where(leaves & ~self._is_far(across, leaves), 1, onwards)
        around = np.where((level > 1) | upright & (turn > 0), -1, np.where(turn < 0, 1j, -1j))
        way = np.where(side < 0, around, np.where(home, np.where(level > 0, -1, 1j), beside))
        # a little beyond the border
        known = (side == parting) & (sector == 0) & (level <= 0)
        log = middles + way * halves * (np.where(known, 1, 1 + 1e-9) / np.sqrt(2.0))
        k = np.exp(log) + self._places[side]
        offset = k - self._places[-1]
        other = parting + (offset.real >= 0)
        enters = (side < 0) & (way == -1) & (np.abs(offset) < np.exp(self._tops)[other])
        leaves &= self._is_far(k, leaves)
        crossed = np.where(home, parting + (log.imag <= np.pi / 2), side)
        side = np.select([enters, leaves], [other, -1], crossed)
        at = np.where(enters | leaves, np.log(offset), log)
        following = self._holding(side, at)
        theirs, unit = self._squares(following)
        rows = following.T.tolist(), known, (at - theirs) / unit, (log - middles) / halves
        return [
            (None if ends else Cell(*other), *points)
            for other, ends, *points in zip(*rows, strict=True)
        ]

    def _missing(self, cells: list[Cell]) -> dict[Cell, _Link]:
        """Return missing cells and those before them with links to their constants."""
        links: dict[Cell, _Link] = {}
        while fresh := [at for at in cells if at not in self._cells and at not in links]:
            links.update(zip(fresh, self._links(np.array(fresh).T), strict=True))
            cells = [*dict.fromkeys(other for cell in fresh if (other := links[cell][0]))]
        return links

    def _form(self, links: Mapping[Cell, _Link]) -> None:
        """Add cells; threads may form the same one."""
        cells = list(links)
        middles, halves = self._squares(np.array(cells).T)
        offsets = np.exp(middles[:, None] + halves[:, None] * self._pattern[0])
        # Rounding must not take a node below the axis, where the densities continue on another
        # sheet.
        offsets = offsets.real + 1j * np.maximum(offsets.imag, 0.0)
        matrix, kept = self._pattern[1], self.source.kept
        owners = [cell.side // 2 if cell.side >= 0 else self.source.parting for cell in cells]
        values = self.source.densities(np.array(owners), offsets)
        # dk = (k - centre) d ln(k - centre), and the unit of the polynomials is half a diagonal.
        integrands = np.ascontiguousarray(np.moveaxis(values * (offsets * halves[:, None]), 0, -1))
        fresh = np.zeros((len(cells), len(matrix) + 1, len(values)), dtype=complex)
        fresh[:, 1:] = matrix @ integrands / np.arange(1.0, len(matrix) + 1)[:, None]
        if kept is not None:
            fresh[:, :-1, kept] = values[kept] @ matrix.T
            fresh[:, -1, kept] = 0.0
        self._add_constants(links, fresh)
        pieces = zip(middles.tolist(), halves.tolist(), fresh, strict=True)
        self._cells.update(zip(cells, pieces, strict=True))

    def _add_constants(self, links: Mapping[Cell, _Link], fresh: Complex) -> None:
        """Set constants of new cells (c, n, f), whose digits do not depend on other new ones."""
        numbers, kept = {cell: number for number, cell in enumerate(links)}, self.source.kept
        others = np.zeros_like(fresh)
        for number, (other, *_) in enumerate(links.values()):
            if other is None:
                others[number, 0] = self.source.ahead
            else:
                known = other not in numbers
                others[number] = self._cells[other][2] if known else fresh[numbers[other]]
        at_other, at_own = (
            np.vander(within, fresh.shape[1], increasing=True)[:, None, 1:]
            for within in np.array([points for _, *points in links.values()]).T
        )
        changes = (at_other @ others[:, 1:] - at_own @ fresh[:, 1:])[:, 0]
        waiting = dict(numbers)
        while waiting:
            for cell, number in [*reversed(waiting.items())]:  # chains begin at their last cell
                other = links[cell][0]
                if other not in waiting:
                    del waiting[cell]
                    constant = fresh[numbers[other], 0] if other in numbers else others[number, 0]
                    continuing = constant + changes[number]
                    if kept is not None:
                        continuing[kept] = fresh[number, 0, kept]
                    fresh[number, 0] = continuing

    @cached_property
    def _pattern(self) -> tuple[Complex, Complex]:
        if self.source.is_coarse:
            # Coarse cells are up to 3e-7 off fine ones in seven scenes; with 12 and 4 three times
            # as much, with 6 and 4 2e-4.
            return _pattern(13, 4)
        # Fields are then within 5e-12 of those by 30 and 14 in seven scenes, as by 22 and 10; 8
        # nodes leave 8e-11 beside the Rayleigh front of an interface that sticks there.
        return _pattern(24, 9)

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
        codes = np.ravel_multi_index(tuple(keys - keys.min(1, keepdims=True)), np.ptp(keys, 1) + 1)
        # A stable sort of short integers takes time proportional to their number.
        order = np.argsort(codes.astype(np.uint16) if codes.max() < 2**16 else codes, kind="stable")
        begins = np.diff(codes[order], prepend=-1) != 0
        begins[:: tuning.POWERS_AT_ONCE] = True
        starts = np.flatnonzero(begins)
        cells = [Cell(*key) for key in keys[:, order[starts]].T.tolist()]
        if missing := self._missing(cells):
            self._form(missing)
        result, logs = np.empty((len(mix), len(k))), logs[order]
        for cell, here in zip(cells, map(slice, starts, [*starts[1:], len(k)]), strict=True):
            # Integrals are polynomials in ln(k - centre).
            middle, half, coefs = self._cells[cell]
            within = (logs[here] - middle) / half
            result[:, order[here]] = (mix @ coefs.T @ powers(within, len(coefs))).imag
        return result
