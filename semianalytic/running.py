"""Running integrals on panels: slip rate from its slope, slip from slip rate, traction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.panels import Panels
from semianalytic.rayleigh import Array, CutPoints


@dataclass(frozen=True)
class RunningIntegral:
    """Integrals of a density g(v), and of v g, from the left end of each panel.

    g may have a simple pole at c inside a panel, and decay like tail / v^2 on the unbounded
    one.  Both are integrated in closed form, the rest by sinc indefinite integration.

    Attributes
    ----------
    panels : Panels
    density : (p, n) array, g at the nodes
    c : float, Rayleigh slowness
    tail : float, limit of v^2 g (needed for the moment v g only)
    """

    panels: Panels
    density: Array
    c: float
    tail: float = 0.0

    @cached_property
    def totals(self) -> Array:
        """(p,) integrals of g over whole panels; principal values where g has a pole."""
        return self.panels.integrals(self.density)

    @cached_property
    def residues(self) -> Array:
        """(p,) residues of g at c, 0 on panels that do not cover it."""
        panels, rule = self.panels, self.panels.rule
        result = np.zeros(len(panels.left))
        for i, (left, right) in enumerate(zip(panels.left, panels.right, strict=True)):
            slips = panels.sense[i] != 0
            if slips and left.from_c[0] < 0 and (right is None or right.from_c[0] > 0):
                share = 1.0 if right is None else float(right.from_c[0] / right.minus(left)[0])
                decaying = 1.0 if right is not None else np.square(self.c / panels.at.v[i])
                numerator = self.density[i] * panels.at.from_c[i] * panels.jacobian[i] * decaying
                kernel = np.sinc((rule.spacing / 2 - rule.y) / rule.spacing)
                result[i] = kernel @ numerator / (-left.from_c[0] * share)
        return result

    @cached_property
    def _regular(self) -> Array:
        """(p, 2, n): g and v g without pole and tail, times dv/dy."""
        panels = self.panels
        rest = self.density.copy()
        for i in np.flatnonzero(self.residues):
            shape = 1.0 if panels.right[i] is not None else np.square(self.c / panels.at.v[i])
            rest[i] -= self.residues[i] * shape / panels.at.from_c[i]
        moment = panels.at.v * rest
        if panels.right[-1] is None:
            moment[-1] -= self.tail * panels.from_left[-1] / np.square(panels.at.v[-1])
        return np.stack([rest, moment], axis=1) * panels.jacobian[:, None, :]

    def __call__(self, panel: int, at: CutPoints) -> tuple[Array, Array]:
        """Integrals of g and v g from the panel's left end to points inside it."""
        y = self.panels.coordinate(panel, at)
        regular = self.panels.rule.interpolate_running(y, self._regular[panel])
        return self._complete(panel, at, regular.T)

    def at_nodes(self, panel: int) -> tuple[Array, Array]:
        """The same at the panel's nodes."""
        regular = self._regular[panel] @ self.panels.rule.running.T
        return self._complete(panel, self.panels.at[panel], regular)

    def _complete(self, panel: int, at: CutPoints, regular: Array) -> tuple[Array, Array]:
        """Add the closed forms of pole and tail."""
        plain, moment = regular
        c, left = self.c, self.panels.left[panel]
        bounded = self.panels.right[panel] is not None
        residue = self.residues[panel]
        if residue:
            # At c itself V is infinite; x/t cannot tell it from its neighbours in rounding.
            log = np.log(np.maximum(np.abs(at.from_c / left.from_c), 1e-16))
            if bounded:
                plain = plain + residue * log
                moment = moment + residue * (at.minus(left) + c * log)
            else:
                ratio = np.log(at.v / left.v)
                plain = plain + residue * (log - ratio + c / at.v - c / left.v)
                moment = moment + residue * c * (log - ratio)
        if not bounded and self.tail:
            moment = moment + self.tail * (np.log(at.v / left.v) + left.v / at.v - 1)
        return plain, moment
