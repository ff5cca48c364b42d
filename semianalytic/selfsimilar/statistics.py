"""Cost of a self-similar solution."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Statistics:
    """Numbers of iterations, unknowns and nodes of a solution, and the time it took.

    Of two different bodies the equations of the densities are solved, which have a residual.

    Attributes
    ----------
    newton_steps : int
        Newton and Broyden steps for the zone edges.
    zone_sets : int
        Sets of zones tried until Coulomb's law held everywhere.
    unknowns : int
        Number of zone edges.
    nodes : int
        Number of nodes of all panels, of two bodies that of the unknowns of densities.
    seconds : dict
        Time of each stage [s], by its name.
    pivots : int
        Pivots of the complementarity problem on the grid of one body.
    residual, smallest_singular_value : float
        Residual of the equations of two bodies, and their smallest singular value; nan of one.

    Examples
    --------
    >>> from semianalytic import Material, Scene, Tractions, solve
    >>> base, load = Tractions(1.0, 0.0), Tractions(0.0, 1.0)
    >>> solution = solve(Scene(Material(1.0, 1.0, 1 / 3), 1.0, base, load))
    >>> solution.statistics.unknowns, solution.statistics.zone_sets
    (1, 1)
    >>> list(solution.statistics.seconds)
    ['zones', 'edges', 'check']
    """

    newton_steps: int
    zone_sets: int
    unknowns: int
    nodes: int
    seconds: dict[str, float]
    pivots: int = 0
    residual: float = math.nan
    smallest_singular_value: float = math.nan
