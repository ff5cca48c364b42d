"""Running integrals on panels: slip rate from its slope, slip from slip rate, traction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.halfplane.rayleigh import Array, CutPoints
from semianalytic.selfsimilar.panels import Panels


@dataclass(frozen=True)
class RunningIntegral:
    """Integrals of a density g(v), and of v g, from the left end of each panel.

    g may have a simple pole at c inside a panel, and decay like tail / v^2 on the unbounded
    one.  Both are integrated in closed form, the rest by sinc indefinite integration.

    Attributes
    ----------
    panels : Panels
    density : (p, ..., n) array, g at the nodes
    c : float, Rayleigh slowness
    tail : float or (...) array, limit of v^2 g (needed for the moment v g only)
    """

    panels: Panels
    density: Array
    c: float
    tail: float | Array = 0.0

    @cached_property
    def totals(self) -> Array:
        """(p, ...) integrals of g over whole panels; principal values where g has a pole."""
        return self.panels.integrals(self.density)

    @cached_property
    def residues(self) -> Array:
        """(p, ...) residues of g at c, 0 on panels that do not cover it."""
        panels, rule, pole = self.panels, self.panels.rule, self.panels.layout.pole
        result = np.zeros(self.density.shape[:-1])
        if pole >= 0:
            left, right = panels.left[pole], panels.right[pole]
            share = 1.0 if right is None else (right.from_c / right.minus(left))[..., 0]
            decaying = 1.0 if right is not None else np.square(self.c / panels.at.v[pole])
            numerator = self.density[pole] * panels.at.from_c[pole] * panels.jacobian[pole]
            kernel = np.sinc((rule.spacing / 2 - rule.y) / rule.spacing)
            result[pole] = (numerator * decaying) @ kernel / (-left.from_c[..., 0] * share)
        return result

    @cached_property
    def _regular(self) -> Array:
        """(p, ..., n): g without pole, times dv/dy."""
        panels = self.panels
        rest, i = self.density * panels.jacobian, self._pole
        if i is not None:
            shape = 1.0 if panels.right[i] is not None else np.square(self.c / panels.at.v[i])
            pole = self.residues[i][..., None] * shape / panels.at.from_c[i]
            rest[i] = (self.density[i] - pole) * panels.jacobian[i]
        return rest

    @cached_property
    def _pole(self) -> int | None:
        """The panel on which g has a pole."""
        pole = self.panels.layout.pole
        return pole if pole >= 0 and self.residues[pole].any() else None

    def _regular_moment(self, panel: int) -> Array:
        """(n,): v g without pole and tail, times dv/dy."""
        panels = self.panels
        v, moment = panels.at.v[panel], panels.at.v[panel] * self._regular[panel]
        if panels.right[panel] is None:
            density = self.tail * panels.from_left[panel] / np.square(v)
            moment = moment - density * panels.jacobian[panel]
        return moment

    def __call__(self, panel: int, at: CutPoints) -> Array:
        """Integral of g from the panel's left end to points inside it (one set of zones)."""
        y = self.panels.coordinate(panel, at)
        regular = self.panels.rule.interpolate_running(y, self._regular[panel])
        return regular + self._of_pole(panel, at)

    @cached_property
    def at_nodes(self) -> Array:
        """(p, ..., n): integrals of g from the left end of each panel to its nodes."""
        result = self.panels.rule.running(self._regular)
        if self._pole is not None:
            result[self._pole] += self._of_pole(self._pole, self.panels.at[self._pole])
        return result

    def with_moment(self, panel: int, at: CutPoints) -> tuple[Array, Array]:
        """Integrals of g and of v g from the panel's left end to points inside it."""
        y = self.panels.coordinate(panel, at)
        both = np.stack([self._regular[panel], self._regular_moment(panel)])
        plain, moment = self.panels.rule.interpolate_running(y, both).T
        left, residue = self.panels.left[panel], self.residues[panel]
        bounded = self.panels.right[panel] is not None
        if residue:
            log = self._log(panel, at)
            if bounded:
                moment = moment + residue * (at.minus(left) + self.c * log)
            else:
                moment = moment + residue * self.c * (log - np.log(at.v / left.v))
        if not bounded:
            moment = moment + self.tail * (np.log(at.v / left.v) + left.v / at.v - 1)
        return plain + self._of_pole(panel, at), moment

    def _log(self, panel: int, at: CutPoints) -> Array:
        # At c itself V is infinite; x/t cannot tell it from its neighbours in rounding.
        return np.log(np.maximum(np.abs(at.from_c / self.panels.left[panel].from_c), 1e-16))

    def _of_pole(self, panel: int, at: CutPoints) -> Array | float:
        """Closed form of the pole's part of the integral of g."""
        if panel != self._pole:
            return 0.0
        log, left = self._log(panel, at), self.panels.left[panel]
        if self.panels.right[panel] is None:
            log = log - np.log(at.v / left.v) + self.c / at.v - self.c / left.v
        return self.residues[panel][..., None] * log
