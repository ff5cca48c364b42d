"""Integrals along panels: of densities at their nodes, of poles, and of powers near their ends.

`PanelIntegral` computes slip rate from its slope, slip from slip rate, and traction along panels.
`Power` is the part s^e of a density that is large at an end of a panel.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.quadrature.panels import Panels
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.scene.arrays import Array

LEAST_SHARE = 1e-8
"""Share of a panel down to which a density at its end is taken as it is."""


@dataclass(frozen=True)
class Power:
    """Density with the integral amount s^exponent near an end of a panel, exponent > -1.

    s is the share of the panel between the end and a point, 1 at the other end. A negative exponent
    stands for the finite part, as if the integral were 0 where s is 0. The derivative of such a
    density with respect to a parameter on which its exponent depends has the integral (amount +
    of_log ln s) s^exponent.
    """

    panel: int
    at_left: bool  # whether the end is the left one
    # (..., 1) each
    exponent: Array
    amount: Array
    of_log: Array | float = 0.0  # 0 where there is no logarithm, (..., 1)

    def share(self, panels: Panels) -> Array:
        """Return s at the nodes, (..., n)."""
        distance = panels.from_left if self.at_left else panels.from_right
        return self._over_width(panels, distance[self.panel])

    def _over_width(self, panels: Panels, distance: Array) -> Array:
        if panels.right[self.panel] is None:
            return np.asarray(distance / (distance + panels.skew[self.panel]))
        return np.asarray(distance / panels.widths[self.panel])

    def by_y(self, panels: Panels) -> Array:
        """Return the density times dv/dy at the nodes, (..., n); like v^-3 if unbounded."""
        share = self.share(panels)
        per_share = self._slope(panels, share)
        # ds/dy = s (1 - s) for the map of a panel.
        return np.asarray((per_share if self.at_left else -per_share) * share * (1 - share))

    def _slope(self, panels: Panels, share: Array) -> Array:
        """Return the derivative of the integral with respect to s."""
        exponent = self.exponent
        rest, factor, by_exponent = np.ones_like(share), exponent, np.ones_like(exponent)
        # On an unbounded panel the integral has the factor 1 + exponent (1 - s), so that its slope
        # vanishes at infinity.
        if panels.right[self.panel] is None:
            rest = 1 - share
            factor, by_exponent = exponent * (1 + exponent), 1 + 2 * exponent
        slope = self.amount * factor * rest * share ** (exponent - 1)
        if np.any(self.of_log):
            of_log = by_exponent + factor * np.log(share)
            slope = slope + self.of_log * of_log * rest * share ** (exponent - 1)
        return np.asarray(slope)

    def _up_to(self, panels: Panels, share: Array) -> Array:
        """Return the integral from the left end of the panel to given shares."""
        exponent, inside = self.exponent, np.where(share > 0, share, 1.0)
        factor, by_exponent = np.ones_like(share), np.zeros_like(share)
        if panels.right[self.panel] is None:
            factor, by_exponent = 1 + exponent * (1 - share), 1 - share
        power = self.amount * factor
        if np.any(self.of_log):
            power = power + self.of_log * (by_exponent + factor * np.log(inside))
        value = np.where(share > 0, power * inside**exponent, 0.0)
        # Counted from the right end, the integral from the left end is less by that over the panel.
        return np.asarray(value if self.at_left else value - self.amount)

    def at_nodes(self, panels: Panels) -> Array:
        """Return the integrals from the left end of the panel to the nodes, (..., n)."""
        return self._up_to(panels, self.share(panels))

    def inside(self, panels: Panels, at: CutPoints) -> Array:
        """Return the integrals to points (m,) inside the panel (one set of zones)."""
        left, right = panels.left[self.panel], panels.right[self.panel]
        distance = at.minus(left) if self.at_left or right is None else -at.minus(right)
        return self._up_to(panels, self._over_width(panels, np.maximum(distance, 0.0)))

    def slope(self, panels: Panels, at: CutPoints) -> Array:
        """Return the density at points (m,) inside, infinite at an end of exponent below 1."""
        left, right = panels.left[self.panel], panels.right[self.panel]
        distance = at.minus(left) if self.at_left or right is None else -at.minus(right)
        share = self._over_width(panels, np.maximum(distance, 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            per_share = self._slope(panels, share)
        if right is None:
            per_v = np.square(1 - share) / panels.skew[self.panel]
        else:
            per_v = (1.0 if self.at_left else -1.0) / panels.widths[self.panel]
        return np.asarray(per_share * per_v)

    def moment_by_y(self, panels: Panels) -> Array:
        """Return the density times distance from the end times dv/dy at nodes, (..., n)."""
        from_end = panels.from_left if self.at_left else -panels.from_right
        return np.asarray(from_end[self.panel] * self.by_y(panels))

    def end(self, panels: Panels) -> Array:
        """Return the slowness of the end, (..., 1)."""
        return np.asarray(panels.ends.v[self.end_index])

    @property
    def end_index(self) -> int:
        """Index of this end among the ends of all panels."""
        return self.panel + (not self.at_left)

    @property
    def total(self) -> Array:
        """Integral over the panel, (...)."""
        return np.asarray((self.amount if self.at_left else -self.amount)[..., 0])


def split_power(
    panels: Panels, density: Array, panel: int, at_left: bool, exponent: Array
) -> Power:
    """Return the power of an exponent that a density has near an end of a panel.

    It is subtracted from the density (p, ..., n) in place. Divided by the power, the density is g_0
    + g_1 s + g_2 s ln s. Three nodes determine the coefficients. The nearest of them lies where
    rounding equals the neglected part of g_1 s.
    """
    unit = Power(panel, at_left, exponent, np.ones_like(exponent))
    jacobian, shape, share = panels.jacobian[panel], unit.by_y(panels), unit.share(panels)
    away = share.reshape(-1, share.shape[-1]).min(axis=0) > LEAST_SHARE
    nodes = np.flatnonzero(away)[:: 1 if at_left else -1]
    # From the shares of two nodes the density is continued to 1e-16, the rounding.
    stride = max(1, round(2.0 / panels.rule.spacing))
    three, near = nodes[[0, stride, 2 * stride]], ~away
    terms = np.stack([np.ones_like(share), share, share * np.log(share)], axis=-1)
    over = (density[panel] * jacobian)[..., three] / shape[..., three]
    fitted = np.linalg.solve(terms[..., three, :], over[..., None])
    power = replace(unit, amount=fitted[..., 0, :])
    density[panel] -= power.by_y(panels) / jacobian
    # Nearer to the end the remainder follows from the fit: a difference would be rounding.
    left = (terms[..., near, 1:] @ fitted[..., 1:, :])[..., 0]
    density[panel][..., near] = left * shape[..., near] / jacobian[..., near]
    return power


@dataclass(frozen=True)
class PanelIntegral:
    """Integrals of a density g(v), and of v g over v, from the left end of each panel.

    g may have a simple pole at c inside a panel, and decay like tail / v^2 on the unbounded one.
    Both are integrated in closed form, the rest by sinc indefinite integration.
    """

    panels: Panels
    density: Array  # g at the nodes, without its powers, (p, ..., n)
    c: float  # Rayleigh slowness
    powers: tuple[Power, ...] = ()  # parts of g that are large near ends of panels
    # residue of g at c where it is known, (...); None to interpolate it between nodes, with half as
    # many digits as integrals have
    residue: Array | None = None
    # Limit of v^2 g, (...), with which v g is integrated in closed form. None where v g may be far
    # larger elsewhere than at the points asked for, as under a film: the integral over v is then
    # the solution of an equation of its own, which leaves the end of the rule, 1e-12 of slip.
    tail: float | Array | None = None

    @cached_property
    def totals(self) -> Array:
        """Integrals of g over whole panels, (p, ...); principal values where g has a pole."""
        result = self.panels.integrals(self.density)
        for power in self.powers:
            result[power.panel] += power.total
        return result

    @cached_property
    def halves(self) -> Array:
        """Integrals of g from the left end of each panel to the middle node, (p, ...)."""
        panels = self.panels
        result = panels.rule.halved(self.density * panels.jacobian)
        for power in self.powers:
            result[power.panel] += power.at_nodes(panels)[..., len(panels.rule.y) // 2]
        return result

    def powers_on(self, panel: int) -> list[Power]:
        """Return the powers near ends of a panel."""
        return [power for power in self.powers if power.panel == panel]

    @cached_property
    def residues(self) -> Array:
        """Residues of g at c, (p, ...), 0 on panels that do not cover it."""
        panels, rule, pole = self.panels, self.panels.rule, self.panels.layout.pole
        result = np.zeros(self.density.shape[:-1])
        if pole >= 0 and self.residue is not None:
            result[pole] = self.residue
        elif pole >= 0:
            left, right = panels.left[pole], panels.right[pole]
            share = 1.0 if right is None else (right.from_c / right.minus(left))[..., 0]
            decaying = 1.0 if right is not None else np.square(self.c / panels.at.v[pole])
            numerator = self.density[pole] * panels.at.from_c[pole] * panels.jacobian[pole]
            # c lies at y = spacing / 2, between two nodes; g (v - c) is interpolated there.
            kernel = np.sinc((rule.spacing / 2 - rule.y) / rule.spacing)
            result[pole] = (numerator * decaying) @ kernel / (-left.from_c[..., 0] * share)
        return result

    def level_at_c(self, panel: int) -> Array:
        """Return the integral of g up to c on its panel, less residue times ln |v - c|."""
        rule, left = self.panels.rule, self.panels.left[panel]
        regular = rule.interpolate_running(np.array([rule.spacing / 2]), self._regular[panel])[0]
        log = -np.log(np.abs(left.from_c))
        if self.panels.right[panel] is None:
            log = log - np.log(self.c / left.v) + 1 - self.c / left.v
        return np.asarray(regular + self.residues[panel] * log[..., 0])

    @cached_property
    def _regular(self) -> Array:
        """g without its pole, times dv/dy, (p, ..., n)."""
        panels = self.panels
        rest, i = self.density * panels.jacobian, self._pole
        if i is not None:
            # On the unbounded panel the pole is taken with the factor (c / v)^2, so that it decays
            # like g.
            shape = 1.0 if panels.right[i] is not None else np.square(self.c / panels.at.v[i])
            pole = self.residues[i][..., None] * shape / panels.at.from_c[i]
            rest[i] = (self.density[i] - pole) * panels.jacobian[i]
        return rest

    @cached_property
    def _pole(self) -> int | None:
        """Panel on which g has a pole, or None."""
        pole = self.panels.layout.pole
        return pole if pole >= 0 and self.residues[pole].any() else None

    @cached_property
    def _slopes(self) -> dict[int, Array]:
        """Slopes of moment or mean by panel, kept because a mean is that of n equations."""
        return {}

    def _slope_of_moment(self, panel: int, tail: float | Array) -> Array:
        """Return v g without pole and tail, times dv/dy, (n,)."""
        panels = self.panels
        v, moment = panels.at.v[panel], panels.at.v[panel] * self._regular[panel]
        if panels.right[panel] is None:
            moment = moment - tail * panels.from_left[panel] / v**2 * panels.jacobian[panel]
        for power in self.powers_on(panel):
            moment = moment + power.moment_by_y(panels)
        return np.asarray(moment)

    def _slope_of_mean(self, panel: int) -> Array:
        """Return dK/dy (n,) at the nodes, of K = int v' g dv' / v from the left end, without pole.

        K is nowhere larger than the integral of |g|, so that it loses no digits far from where v g
        is largest: under a film of viscosity 1e8 that is at v = 1e8.  It obeys
        dK/dy = g dv/dy - K (dv/dy) / v, which holds at all nodes at once.
        """
        panels = self.panels
        v, density = panels.at.v[panel], self._regular[panel]
        for power in self.powers_on(panel):
            density = density + power.moment_by_y(panels) / v
        share = panels.jacobian[panel] / v
        running = panels.rule.running(np.eye(len(v)))
        mean = np.linalg.solve(np.eye(len(v)) + running.T * share, density @ running)
        return np.asarray(density - share * mean)

    def __call__(self, panel: int, at: CutPoints) -> Array:
        """Return the integral of g from the left end to points inside a panel of one set."""
        y = self.panels.coordinate(panel, at)
        regular = self.panels.rule.interpolate_running(y, self._regular[panel])
        return regular + self._of_pole(panel, at) + self._of_powers(panel, at)

    def _of_powers(self, panel: int, at: CutPoints) -> Array | float:
        """Return the closed form of the powers' part of the integral of g."""
        return sum(power.inside(self.panels, at) for power in self.powers_on(panel))

    def slope(self, panel: int, at: CutPoints) -> Array:
        """Return g without its powers at points inside a panel of one set of zones."""
        left, right, v = self.panels.left[panel], self.panels.right[panel], at.v
        per_y = at.minus(left)
        if right is not None:
            per_y = per_y * -at.minus(right) / self.panels.widths[panel]
        y = self.panels.coordinate(panel, at)
        pole = self.residues[panel] / at.from_c if panel == self._pole else np.zeros(v.shape)
        if right is None:
            pole = pole * np.square(self.c / v)
        return np.asarray(self.panels.rule.interpolate(y, self._regular[panel]) / per_y + pole)

    def slope_of_powers(self, panel: int, at: CutPoints) -> Array:
        """Return the density of the powers at points (m,) inside a panel (one set of zones)."""
        slope = np.zeros(at.v.shape)
        for power in self.powers_on(panel):
            slope += power.slope(self.panels, at)
        return slope

    @cached_property
    def at_nodes(self) -> Array:
        """Integrals of g from the left end of each panel to its nodes, (p, ..., n)."""
        result = self.panels.rule.running(self._regular)
        if self._pole is not None:
            result[self._pole] += self._of_pole(self._pole, self.panels.at[self._pole])
        for power in self.powers:
            result[power.panel] += power.at_nodes(self.panels)
        return result

    def with_mean(self, panel: int, at: CutPoints) -> tuple[Array, Array]:
        """Return the integrals of g, and of v g over v, from the left end to points inside."""
        y = self.panels.coordinate(panel, at)
        tail = self.tail
        if panel not in self._slopes:
            self._slopes[panel] = (
                self._slope_of_mean(panel) if tail is None else self._slope_of_moment(panel, tail)
            )
        both = np.stack([self._regular[panel], self._slopes[panel]])
        plain, mean = self.panels.rule.interpolate_running(y, both).T
        left, residue = self.panels.left[panel], self.residues[panel]
        bounded = self.panels.right[panel] is not None
        if tail is not None:
            mean = mean / at.v
            if not bounded:
                share = left.v / at.v  # 0 at the contact edge, where share ln share is 0
                log = np.log(np.maximum(share, np.finfo(float).tiny))
                mean = mean + tail / left.v * share * (share - 1 - log)
        if residue:
            log = self._log(panel, at)
            if bounded:
                # v / (v - c) = 1 + c / (v - c).
                mean = mean + residue * (at.minus(left) + self.c * log) / at.v
            else:
                mean = mean + residue * self.c * (log - np.log(at.v / left.v)) / at.v
        for power in self.powers_on(panel):
            mean = mean + power.end(self.panels) * power.inside(self.panels, at) / at.v
        return plain + self._of_pole(panel, at) + self._of_powers(panel, at), mean

    def _log(self, panel: int, at: CutPoints) -> Array:
        # At c itself V is infinite; x/t equals that of its neighbours in rounding.
        return np.log(np.maximum(np.abs(at.from_c / self.panels.left[panel].from_c), 1e-16))

    def _of_pole(self, panel: int, at: CutPoints) -> Array | float:
        """Return the closed form of the pole's part of the integral of g."""
        if panel != self._pole:
            return 0.0
        log, left = self._log(panel, at), self.panels.left[panel]
        if self.panels.right[panel] is None:
            log = log - np.log(at.v / left.v) + self.c / at.v - self.c / left.v
        return self.residues[panel][..., None] * log
