"""Linear complementarity by complementary pivoting (Lemke's method)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.halfplane.rayleigh import Array
from semianalytic.scene.errors import ComputationError


@dataclass(frozen=True)
class Complementary:
    """Solution z of w = q + M z, w >= 0, z >= 0, w z = 0, and the pivots it took."""

    z: Array
    pivots: int


def lemke(matrix: Array, q: Array, most_pivots: int | None = None) -> Complementary:
    """Solve w = q + M z, w >= 0, z >= 0, w.z = 0 by complementary pivoting.

    Parameters
    ----------
    matrix : (n, n) array
    q : (n,) array
    most_pivots : int, optional
        Give up after this many; 20 n by default.

    Raises
    ------
    ComputationError
        On a ray (no solution on the path) or after `most_pivots`.
    """
    n = len(q)
    if np.all(q >= 0):
        return Complementary(np.zeros(n), 0)
    # Tableau of w - M z - d z0 = q; columns: w (0..n-1), z (n..2n-1), z0 (2n), right-hand side.
    tableau = np.hstack([np.eye(n), -matrix, -np.ones((n, 1)), q[:, None]])
    basis = np.arange(n)
    scale = np.abs(matrix).max()
    row, entering = int(np.argmin(q)), 2 * n
    for pivot in range(1, (most_pivots or 20 * n) + 1):
        leaving = basis[row]
        basis[row] = entering
        tableau[row] /= tableau[row, entering]
        column = tableau[:, entering].copy()
        column[row] = 0.0
        tableau -= np.outer(column, tableau[row])
        if leaving == 2 * n:
            z = np.zeros(2 * n)
            z[basis] = np.maximum(tableau[:, -1], 0.0)
            return Complementary(z[n:], pivot)
        entering = leaving + n if leaving < n else leaving - n
        column = tableau[:, entering]
        allowed = column > 1e-12 * scale
        if not allowed.any():
            raise ComputationError(
                "the complementarity problem of stick and slip ended on a ray after "
                f"{pivot} pivots; use another number of grid points."
            )
        ratio = np.full(n, np.inf)
        ratio[allowed] = tableau[allowed, -1] / column[allowed]
        row = int(np.argmin(ratio))
        tied = np.flatnonzero(ratio <= ratio[row] + 1e-14)
        if 2 * n in basis[tied]:
            row = int(tied[np.flatnonzero(basis[tied] == 2 * n)[0]])
    raise ComputationError(
        f"the complementarity problem of stick and slip took over {most_pivots or 20 * n} pivots; "
        "use another number of grid points."
    )
