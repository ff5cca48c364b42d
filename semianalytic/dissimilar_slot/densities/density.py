"""Solve the singular equations for the slopes of slip and opening rate on given zones.

With q = (dV/dv, dU/dv) on the zones the transforms of the tractions are

    T = Psi z,    z(k) = Psi(0)^(-1) L - k int Psi^T(w) q(w) / n_inf dw / (w + k),

L = (Q_0, -P_0), wherever the zones are.  On the cut C^(-1) = g stands for the rows of the inverse
compliance, and tractions keep to the law of friction where

    -Re g . q + (1/pi) Im g R(-v) PV int Psi^T(w) q(w) / n_inf dw / (w - v)
        = -Im g R(-v) z(0) / (pi v)

with g = (1, s f) C^(-1) where the interface slips or is open (tau + s f sigma does not change), and
g = (0, 1) C^(-1) besides where it is open (nor does sigma); a viscous film adds eta to Re g for V'.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.dissimilar.canonical import Glued
from semianalytic.dissimilar.compliance import Complex, Entries
from semianalytic.dissimilar.stretch import Points, Stretch, Values
from semianalytic.dissimilar_slot.densities.interface import LoadedBodies
from semianalytic.dissimilar_slot.densities.panels import (
    Panel,
    PanelRule,
    between_nodes,
    edge_exponents,
    panels_of,
)
from semianalytic.dissimilar_slot.densities.poles import Pole, poles_on
from semianalytic.dissimilar_slot.densities.zones import MovingZone, neighbours
from semianalytic.scene.arrays import Array

Factor = tuple[Array, bool] | None
"""Cholesky factor of normal equations, as scipy gives it; None if they are singular."""


@dataclass(frozen=True, eq=False)
class OnPanel:
    """Quantities in the equations on one panel, at its nodes and half-way between them."""

    panel: Panel
    rows: Complex  # the vectors g, one where it slips and two where it is open, (r, m, 2)
    turned: Array  # Im g R(-v), (r, m, 2)
    sources: Array  # Psi^T / n_inf at the nodes, (n, 2, 2)
    entries: Entries
    rates: Array  # R(-v), (m, 2, 2)
    poles: tuple[Pole, ...]  # poles at the Rayleigh waves of the free faces, on panels of openings

    @property
    def unknowns(self) -> int:
        """Number of unknowns of the panel."""
        return self.panel.unknowns + 2 * len(self.poles)


@dataclass(frozen=True, eq=False)
class Density:
    """Solved densities on zones."""

    interface: LoadedBodies
    glued: Glued
    zones: tuple[MovingZone, ...]
    parts: tuple[OnPanel, ...]
    # dV/dx and dU/dx at the nodes of every panel, times the spacing, (n, 2) each
    slopes: tuple[Array, ...]
    # amplitudes of both kinds of every pole on every panel, (p, 2) each
    amplitudes: tuple[Array, ...]
    factor: Factor  # factor of the normal equations, or of those of zones that are near
    residual: float  # largest residual over the largest right-hand side

    @cached_property
    def constant(self) -> Array:
        """z(0), (2,)."""
        interface = self.interface
        return self.glued.constant(interface.load_shear, interface.load_pressure)

    @property
    def unknowns(self) -> int:
        """Number of unknowns of the equations."""
        return sum(part.unknowns for part in self.parts)

    @cached_property
    def exponents(self) -> dict[float, float]:
        """Exponents of the slopes of tractions at all zone edges."""
        result: dict[float, float] = {}
        for before, zone, after in neighbours(self.zones):
            left, right = edge_exponents(self.interface, before, zone, after)
            result[zone.left] = left
            if zone.right is not None and right is not None:
                result[zone.right] = right
        return result

    @cached_property
    def masses(self) -> Array:
        """Psi^T q dv / n_inf at the nodes of all panels, (m, 2)."""
        parts = [
            (part.sources @ slope[:, :, None])[..., 0]
            for part, slope in zip(self.parts, self.slopes, strict=True)
        ]
        return np.concatenate([np.zeros((0, 2)), *parts])

    @cached_property
    def smallest_singular_value(self) -> float:
        """Smallest singular value; well below 0.1 the equations do not determine the densities."""
        if not self.parts:
            return 1.0
        if self.factor is None:
            return 0.0
        from scipy.linalg import cho_solve

        vector = np.random.default_rng(0).standard_normal(self.unknowns)
        for _ in range(12):  # the smallest singular value is then known to a tenth
            vector = cho_solve(self.factor, vector / np.linalg.norm(vector))
        # The iteration tends to the largest eigenvalue of (M^T M)^(-1), which is 1 / sigma^2.
        return float(np.linalg.norm(vector) ** -0.5)

    def _on_zone(self, zone: int) -> Iterator[tuple[OnPanel, Array, Array]]:
        """Yield the panels of a zone with their slopes and amplitudes."""
        for part, slope, amplitude in zip(self.parts, self.slopes, self.amplitudes, strict=True):
            if part.panel.zone == zone:
                yield part, slope, amplitude

    def change(self, zone: int) -> Array:
        """Return the changes of V and U across a zone, (2,)."""
        return np.sum([self.panel_change(*on) for on in self._on_zone(zone)], axis=0)

    @staticmethod
    def panel_change(part: OnPanel, slope: Array, amplitude: Array) -> Array:
        """Return the changes of V and U across a panel, (2,)."""
        total = slope.sum(axis=0)
        for pole, size in zip(part.poles, amplitude, strict=True):
            total = total + pole.change(np.array([pole.right]))[0] @ size
        return np.asarray(total)

    def gap_left(self, zone: int) -> float:
        """Return the integral of U across an opening: its end times the gap over time there."""
        moment = 0.0
        for part, slope, amplitude in self._on_zone(zone):
            # By parts: U is 0 at both ends of the opening, so that int U dv = -int v dU.
            moment += float(slope[:, 1] @ part.panel.points.v[: part.panel.count])
            for pole, size in zip(part.poles, amplitude, strict=True):
                end = np.array([pole.right])
                moment += float((pole.right * pole.change(end) - pole.area(end))[0, 1] @ size)
        return -moment

    def _of_poles(self, v: Values) -> Values | float:
        """Return the part of int Psi^T q / n_inf dw / (w - v) due to the poles, (m, 2)."""
        total: Values | float = 0.0
        for part, amplitude in zip(self.parts, self.amplitudes, strict=True):
            for pole, size in zip(part.poles, amplitude, strict=True):
                total = total + pole.transform(v) @ size
        return total

    def normal_slope(self, on: OnPanel) -> Array:
        """Return the change of sigma per step of x on a slip panel, half-way between its nodes.

        With g = (0, 1) C^(-1), d(sigma)/dv = Im g R(-v) z / (pi v) - Re g . q.
        """
        panel, count = on.panel, on.panel.count
        z: Values = np.zeros((count - 1, 2))
        for part, slope in zip(self.parts, self.slopes, strict=True):
            source, nodes = part.panel, slice(0, part.panel.count)
            phi = slope / (source.spacing * source.jacobian / source.weight)[nodes, None]
            # Half-way between the nodes the principal value needs no care, as no node is hit.
            kernel = panel.own_kernel() if part is on else panel.other_kernel(source)
            z += kernel[count:] @ (part.sources @ phi[:, :, None])[..., 0]
        v, scale = panel.points.v[count:], (panel.spacing * panel.jacobian)[count:]
        z = z / panel.weight[count:, None] + self._of_poles(v)
        z = self.constant + v[:, None] * z
        inverse = on.entries.inverse[count:, 1]
        turned = (inverse.imag[:, None] @ on.rates[count:])[:, 0]
        phi = self.slopes[self.parts.index(on)][:, 0] * (panel.weight / panel.jacobian)[:count]
        rate = between_nodes(count) @ phi / panel.weight[count:] / panel.spacing
        slope = (turned * z).sum(axis=1) / (np.pi * v) - inverse[:, 0].real * rate
        return np.asarray(scale * slope)

    def z(self, stretch: Stretch, points: Points) -> Values:
        """Return z(k), (m, 2), at points k = -v off the zones, on a stretch without zone edges."""
        from_nodes = [self._from(stretch, points, part) for part in self.parts]
        sums = _cauchy(np.concatenate(from_nodes, axis=1), points.v.imag, self.masses)
        return np.asarray(self.constant + points.v[:, None] * (sums + self._of_poles(points.v)))

    def above(self, place: Array, offset: Complex) -> Values:
        """Return z(k), (m, 2), at k = place + offset (m,), anywhere on and above the axis."""
        k = place + offset
        total = self._of_poles(-k)
        start = 0
        for part in self.parts:
            masses = self.masses[start : start + part.panel.count]
            total = total + part.panel.above(masses, place, offset)
            start += part.panel.count
        return np.asarray(self.constant - k[:, None] * total)

    def _from(self, stretch: Stretch, points: Points, part: OnPanel) -> Array:
        """Return real parts of the nodes of a panel less points, (m, n), from the nearer end."""
        panel = part.panel
        # Without a right end all points are counted from the left one.
        near_left = np.broadcast_to((points.x.real < 0) | (stretch.right is None), points.v.shape)
        result = np.empty((len(points.v), panel.count))
        for near, end, distance in (
            (near_left, stretch.left, points.from_left),
            (~near_left, stretch.right, -points.to_right),
        ):
            if end is not None and near.any():
                result[near] = _nodes_from(panel, end) - distance[near, None].real
        return result

    def tractions(self, stretch: Stretch, points: Points) -> Values:
        """Return T_tau and T_sigma at k = -v, (m, 2), off the zones; T = Psi z = C^(-1) R z."""
        fronts = self.interface.compliance.fronts
        entries = self.interface.compliance.on_cut(points.v, stretch.minus(points, fronts))
        # R(-v) is off its own cut, and C has a closed form on this one; Psi is known off the cut
        # alone.
        z = self.z(stretch, points) if self.parts else np.broadcast_to(self.constant, (1, 2))
        rates = self.glued.rates(points.v)
        return np.asarray((entries.inverse @ (rates @ z[..., None]))[..., 0])


def _cauchy(real: Array, imag: Array, masses: Array) -> Values:
    """Return the sums (m, 2) of masses (n, 2) over real (m, n) - i imag (m,)."""
    if not imag.any():
        return np.asarray((1 / real) @ masses)
    # real arithmetic takes half the time of complex division
    over = np.square(real)
    over += np.square(imag)[:, None] + 1e-300  # nothing is that close but what does not count
    np.reciprocal(over, out=over)
    turned = imag[:, None] * (over @ masses)
    over *= real
    return np.asarray(over @ masses + 1j * turned)


def _nodes_from(panel: Panel, end: float) -> Array:
    """Return the nodes of a panel less a slowness, exactly if that is an end of the panel."""
    stretch, nodes = panel.stretch, slice(0, panel.count)
    inside = stretch.left < end and (stretch.right is None or end < stretch.right)
    if inside:
        return np.asarray(panel.points.v[nodes] - end)
    return np.asarray(stretch.minus(panel.points, np.array([end]))[0][nodes])


def density_of(
    interface: LoadedBodies,
    glued: Glued,
    zones: Sequence[MovingZone],
    rule: PanelRule,
    near: Density | None = None,
) -> Density:
    """Solve the equations on given zones, by the factor of zones that are near them if given."""
    parts = tuple(_on_panel(interface, glued, p) for p in panels_of(interface, zones, rule))
    if not parts:
        return Density(interface, glued, (), (), (), (), None, 0.0)
    constant = glued.constant(interface.load_shear, interface.load_pressure)
    blocks = [_equations(interface, target, parts, constant) for target in parts]
    closing = [_closing(parts, i) for i, zone in enumerate(zones) if zone.open and zone.right]
    matrix = np.concatenate([*(block for block, _ in blocks), *closing])
    # More rows than unknowns: nodes and points between them, and one row for each gap that closes.
    right = np.concatenate([*(values for _, values in blocks), np.zeros(len(closing))])
    alike = near is not None and near.unknowns == matrix.shape[1]
    solution, factor = _least_squares(matrix, right, near.factor if near and alike else None)
    residual = float(np.abs(matrix @ solution - right).max() / (np.abs(right).max() or 1.0))
    slopes, amplitudes, start = [], [], 0
    for part in parts:
        panel, slope = part.panel, np.zeros((part.panel.count, 2))
        phi = solution[start : start + panel.unknowns].reshape(-1, panel.count)
        scale = panel.spacing * panel.jacobian[: panel.count] / panel.weight[: panel.count]
        slope[:, : len(phi)] = (phi * scale).T
        slopes.append(slope)
        amplitudes.append(solution[start + panel.unknowns : start + part.unknowns].reshape(-1, 2))
        start += part.unknowns
    return Density(
        interface, glued, tuple(zones), parts, tuple(slopes), tuple(amplitudes), factor, residual
    )


def _closing(parts: Sequence[OnPanel], zone: int) -> Array:
    """Return the row, (1, n), of the condition that U is 0 where an opening closes."""
    cells = []
    for part in parts:
        panel, here = part.panel, part.panel.zone == zone
        scale = panel.spacing * panel.jacobian[: panel.count] / panel.weight[: panel.count]
        cells.append(np.zeros(panel.unknowns))
        if here:
            cells[-1][panel.count :] = scale
        for pole in part.poles:
            cells.append(pole.change(np.array([pole.right]))[0, 1] if here else np.zeros(2))
    return np.concatenate(cells)[None]


def _on_panel(interface: LoadedBodies, glued: Glued, panel: Panel) -> OnPanel:
    v, entries = panel.points.v, panel.entries(interface)
    inverse, rates = entries.inverse, glued.rates(v)
    friction = panel.sense * interface.friction
    rows = [inverse[:, 0] + friction * inverse[:, 1]]
    if panel.open:
        rows.append(inverse[:, 1])
    turned = [(row.imag[:, None] @ rates)[:, 0] for row in rows]
    sources = np.swapaxes(glued.psi(v[: panel.count]), -1, -2) / glued.limit
    poles: list[Pole] = []
    # A panel without end has no parabola that vanishes there; openings are cut behind the poles.
    if panel.open and panel.stretch.right is not None:
        ends = panel.stretch.left, panel.stretch.right
        poles = poles_on(glued, interface.rayleigh_slownesses, *ends)
    return OnPanel(panel, np.array(rows), np.array(turned), sources, entries, rates, tuple(poles))


def _equations(
    interface: LoadedBodies, target: OnPanel, parts: Sequence[OnPanel], constant: Array
) -> tuple[Array, Array]:
    """Return rows at the points of a panel over |g| times omega, and right-hand sides."""
    panel, count = target.panel, target.panel.count
    film = 0.0 if panel.open else interface.resistance
    columns: list[list[Array]] = [[] for _ in target.rows]
    for source in parts:
        own = source is target
        kernel = panel.own_kernel() if own else panel.other_kernel(source.panel)
        for component in range(2 if source.panel.open else 1):
            for index, (row, turned) in enumerate(zip(target.rows, target.turned, strict=True)):
                block = kernel * (turned @ source.sources[:, :, component].T / np.pi)
                if own:
                    # A film resists slip alone, in the equation of shear alone.
                    real = row.real[:, component] + (film if not (index or component) else 0.0)
                    block[np.arange(count), np.arange(count)] -= real[:count]
                    # Between the nodes the unknown is the sinc series, at the nodes it is itself.
                    block[count:] -= real[count:, None] * between_nodes(count)
                columns[index].append(block)
        for pole in source.poles:
            transform = pole.transform(panel.points.v)
            own_values = pole.values(panel.points.v) if own else np.zeros_like(transform)
            for index, (row, turned) in enumerate(zip(target.rows, target.turned, strict=True)):
                block = (turned[:, None] @ transform / np.pi - row.real[:, None] @ own_values)[:, 0]
                columns[index].append(block * panel.weight[:, None])
    blocks, values = [], []
    for row, turned, cells in zip(target.rows, target.turned, columns, strict=True):
        # Rows of one size: g vanishes or grows at some fronts, and these points would count for too
        # little or too much.
        size = np.abs(row).max(axis=1) if panel.open else np.abs(row[:, 0] + film)
        right = -(turned @ constant) / (np.pi * panel.points.v) * panel.weight
        blocks.append(np.concatenate(cells, axis=1) / size[:, None])
        values.append(right / size)
    return np.concatenate(blocks), np.concatenate(values)


def _least_squares(matrix: Array, right: Array, factor: Factor) -> tuple[Array, Factor]:
    """Return the least-squares solution and the factor of its normal equations.

    The factor of a matrix that is near serves for its own where corrections by it shrink fast.
    """
    from scipy.linalg import cho_factor, cho_solve  # here, for a quick import

    if factor is not None:
        solution = np.zeros(len(factor[0]))
        for _ in range(5):  # three are usual: edges move by 1e-5 and less on one rule
            rest = cho_solve(factor, (right - matrix @ solution) @ matrix)
            solution += rest
            if np.abs(rest).max() <= 1e-12 * np.abs(solution).max():
                return solution, factor
    # No singular value is small where the zones have an answer: squares cost no digit.
    try:
        factor = cho_factor(matrix.T @ matrix, overwrite_a=True)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0]), None
    solution = cho_solve(factor, right @ matrix)
    return np.asarray(solution + cho_solve(factor, (right - matrix @ solution) @ matrix)), factor
