"""Interpolation from scattered neighbours by local polynomials of one or two variables."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class Stencils:
    """The neighbours of t points, m each, and the weights of their values at these points.

    Attributes
    ----------
    near : (t, m) array
        Indices of neighbours.
    weights : (d, t, m) array
        Weights for polynomials of degree 0, 1 ...
    """

    near: np.ndarray
    weights: Array

    def blended(self, table: Array, known: Array) -> tuple[Array, Array]:
        """Return values (t, ...) of a table (n, ...) by two polynomials, two degrees apart.

        They are those that differ least for known values (n, e).  Polynomials one degree apart
        agree among symmetric neighbours, even if both are wrong.
        """
        near = table[self.near]
        # Too few neighbours for polynomials two degrees apart: the nearest value, with an error
        # that nobody knows.
        if len(self.weights) < 3:
            return near[:, 0], np.full_like(near[:, 0], np.nan)
        apart, _ = self._differences(known)
        lower, points = apart.max(axis=-1, initial=0.0).argmin(axis=0), np.arange(len(near))
        both = (self.weights[degree, points] for degree in (lower + 2, lower))
        value, other = (np.einsum("tm,tm...->t...", weights, near) for weights in both)
        return value, other

    def of_each(self, known: Array) -> tuple[Array, Array]:
        """Return the values (t, e) of the two best polynomials of each column of known ones (n, e).

        With too few neighbours they are the nearest values, and not numbers.
        """
        if len(self.weights) < 3:
            nearest = known[self.near[:, 0]]
            return nearest, np.full_like(nearest, np.nan)
        apart, each = self._differences(known)
        lower = apart.argmin(axis=0)[None]
        value, other = (np.take_along_axis(each, i, axis=0)[0] for i in (lower + 2, lower))
        return value, other

    def _differences(self, known: Array) -> tuple[Array, Array]:
        """Return differences (d - 2, t, e) of polynomials two degrees apart, infinite where these
        are no numbers, and the values (d, t, e) of all, from known ones (n, e).
        """
        each = np.einsum("dtm,tme->dte", self.weights, known[self.near])
        return np.nan_to_num(np.abs(each[2:] - each[:-2]), nan=np.inf), each


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """Points (n, d) at which values are known, d = 1 or 2."""

    places: Array

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree  # here, for `import semianalytic` is to be quick

        return cKDTree(self.places)

    def nearest(self, to: Array, count: int) -> np.ndarray:
        """Return indices (t, m) of the m <= count points nearest to others (t, d), in order."""
        count = min(count, len(self.places))
        return np.asarray(self._tree.query(to, count)[1]).reshape(len(to), count)

    def stencils(self, to: Array, most: int = 32) -> Stencils:
        """Return local polynomials around points (t, d), by weighted least squares.

        In the plane they are fitted to at most `most` known points.
        """
        # Known points that a polynomial is fitted to; the degrees are up to 7 on a line, and 5.
        near = self.nearest(to, 12 if self.places.shape[1] == 1 else most)
        offset = self.places[near] - to[:, None]
        # Offsets over the distance of the farthest neighbour lie in the unit disc, so that
        # monomials of any degree stay comparable.
        radius = np.linalg.norm(offset, axis=-1).max(axis=1)
        offset = offset / np.where(radius > 0, radius, 1.0)[:, None, None]
        # Near neighbours count more, by the inverse distance; the constant keeps one that coincides
        # with the point from outweighing all others.
        own = 1 / np.sqrt(0.05 + np.square(offset).sum(axis=-1))
        x, *others = np.moveaxis(offset, -1, 0)
        terms = last = [own]
        degrees = [1]
        while len(terms) + len(last) + len(others) <= near.shape[1] / 1.4:
            # The monomials of the next degree: x times each of the last degree, and y times its
            # last one, y^d.
            last = [*(x * term for term in last), *(y * last[-1] for y in others)]
            terms = terms + last
            degrees.append(len(terms))
        q, r = np.linalg.qr(np.moveaxis(np.stack(terms), 0, -1))
        # For neighbours that lie on a line.
        lower = np.swapaxes(r, 1, 2) + 1e-14 * np.eye(len(terms))
        # The value at the point itself is the coefficient of the constant term, since offsets count
        # from there.
        at_centre = np.zeros((len(to), len(terms), 1))
        at_centre[:, 0] = 1.0
        share = np.linalg.solve(lower, at_centre)
        # With W A = Q R the weights are e_1^T R^-1 Q^T W; the first columns of Q make the weights
        # of the lower polynomials, at no further cost.
        weights = q @ (share * (np.arange(len(terms))[:, None] < degrees)) * own[..., None]
        return Stencils(near, np.ascontiguousarray(np.moveaxis(weights, -1, 0)))
