"""Errors of a grid next to edges of contacts: singular fields, slip and gaps that no node shows.

All of it is read off the first nodes, by what a crack tip is on a grid (`dissimilar.grid_edge`).
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from semianalytic.dissimilar.grid_edge import (
    MOST_NODES,
    EdgeReading,
    edge_factors,
    read_beside_edge,
    zone_beside_edge,
)
from semianalytic.dissimilar.kernels import pair_of
from semianalytic.engine.stepping.tuning import BESIDE_EDGE_ERROR, FILM_EDGE_ERROR, LEAST_GAP
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.line.fields import at_nodes

SMALLEST = 1e-300
"""Least divisor of a relative error, where nothing slips."""


def film_error(first: Array, second: Array, slope: Any, impedance: float) -> Array:
    """Return the error of slip or its rate next to edges under a film, over the node distance.

    Farther from an edge than mu t / viscosity a film is all but stuck: its slip rate follows the
    singular traction of a contact that sticks, of which the first two nodes have a known ratio.

    Parameters
    ----------
    first, second : arrays
        Values of the first node and of the one behind it.
    slope : array or float
        Traction of the film over its slip rate [stress time / length].
    impedance : float
        Traction of plane waves over the slip rate, which bear the rest [stress time / length].
    """
    offset, of_contact, _ = edge_factors(0.0)
    ratio = np.sqrt(offset / (1 + offset)) * (of_contact[1] / of_contact[0]).real
    singular = np.clip((np.abs(first) - np.abs(second)) / (1 - ratio), 0.0, np.abs(first))
    return np.asarray(FILM_EDGE_ERROR * slope / (slope + impedance) * singular)


def hidden_openings(
    pressure: Array, left: Array, shear: Array, spacing: float, compliance: float
) -> tuple[Array, Array]:
    """Return the areas of openings that no node shows, and the forces of which they relieve slip.

    A singular tension opens an edge as far as the pressure that is left there lets it, like slip
    against its strength [length^2, stress length].  Half of the slip that a force at an edge
    causes is on the slot: half the force is returned.

    Parameters
    ----------
    pressure, shear : arrays
        Tractions of the first node [stress].
    left : array
        Pressure without the singular part [stress].
    spacing, compliance : float
        As in `zone_beside_edge`.
    """
    closed = (pressure > 0) & (pressure < left)
    lengths, areas = zone_beside_edge(left - pressure, left, closed, spacing, compliance)
    return areas, lengths / 2 * np.abs(shear) * left / np.where(closed, pressure, 1.0)


def hidden_force(marched: Any) -> float:
    """Return the force that openings at the edge which no node shows take off slip in a march
    next to a slot, over that which drives it."""
    scene, known, spacing = marched.scene, marched.interface, marched.spacing
    held, load = scene.superposition
    left = held.pressure - load.pressure * scene.pressure_history.value(known.t)
    shear, slips = known.shear_traction, known.slip_rate[:, 0] != 0
    force = hidden_openings(known.pressure[:, 0], left, shear[:, 0], spacing, 0.0)[1][slips].sum()
    if not force:  # arrays of all levels take as long as a seventh of the march
        return 0.0
    driving = spacing * np.abs(shear - held.shear).sum()
    return float(force / (force + driving))


def film_share(marched: Any) -> float:
    """Return the error of the slip rate at the edge of a film next to a slot, over all of it."""
    rates, slope = marched.interface.slip_rate, marched.scene.law.steady_slope()
    if not slope or marched.nodes == 1:
        return 0.0
    wrong = film_error(rates[:, 0], rates[:, 1], slope, marched.scene.impedance)
    return float(wrong.sum() / max(np.abs(rates).sum(), SMALLEST))


class EdgeNodes:
    """The e first nodes of the contacts of a line next to slots.

    Parameters
    ----------
    done : Marched
        The march along a line, on m frames.
    """

    def __init__(self, done: Any) -> None:
        self._done, known = done, done.interface
        self._on, self._spacing = known.touching, done.scene.period / done.nodes
        left, right = np.roll(self._on, 1), np.roll(self._on, -1)
        if done.scene.even:
            left[0] = right[-1] = True  # mirror images of themselves
        self._first = np.flatnonzero(self._on & ~(left & right))
        inward = np.where(left[self._first], -1, 1 * right[self._first])
        self._second = (self._first + inward) % len(self._on)
        self._place = np.searchsorted(np.flatnonzero(self._on), self._first)
        self._law_x = known.x[self._on]
        self._law = done.scene.law.on(self._law_x, self._spacing)
        self._shear, self._pressure = (
            at_nodes(name, getattr(done.scene.base, name), known.x, self._on, self._spacing)[
                self._first
            ]
            for name in ("shear", "pressure")
        )

    def _at(self, name: str) -> Array:
        """Return a field there, (m, e)."""
        return np.asarray(getattr(self._done.interface, name)[:, self._first])

    @cached_property
    def _slips(self) -> NDArray[np.bool_]:
        return self._at("slip_rate") != 0

    @cached_property
    def wrong(self) -> dict[str, float]:
        """Errors of fields there, summed over edges and frames.

        Where they are singular, nodes are off there by the same part on any grid, of which the
        difference of two grids shows little (`BESIDE_EDGE_ERROR`).
        """
        known, shear = self._done.interface, self._at("shear_traction")
        pressure = self._at("pressure")
        off = np.abs(pressure - self._pressure)
        # Where it slips, traction follows pressure.
        ratio = np.divide(np.abs(shear), pressure, out=np.zeros_like(shear), where=pressure > 0)
        stuck = np.abs(shear - self._shear)
        found = {"pressure": off, "shear_traction": np.where(self._slips, ratio * off, stuck)}
        found = {name: BESIDE_EDGE_ERROR * error for name, error in found.items()}
        slope = self._law.steady_slope()
        if slope is not None:
            slope = np.broadcast_to(slope, len(self._law_x))[self._place]
            for name in ("slip", "slip_rate", "shear_traction"):
                first, second = self._at(name), getattr(known, name)[:, self._second]
                more = film_error(first, second, slope, self._done.scene.impedance)
                found[name] = found.get(name, 0.0) + more
        of_zones = self._of_zone_ends
        return {
            name: float(errors.sum()) + of_zones.get(name, 0.0) for name, errors in found.items()
        }

    @cached_property
    def _of_zone_ends(self) -> dict[str, float]:
        """Errors at the ends of slip zones under a film, summed over ends and frames.

        The node there slips by the mean of the excess over 1.5 node distances (`area_means`): where
        the excess is e and changes by r over half of that, by (e + r)^2 / (4 r) for max(e, 0).  A
        film keeps that local: the traction of the slip that is too much is that of a stuck line,
        |k| / (2 C) for a wavenumber k, whose absolute sum over nodes is pi / (2 C h).
        """
        slope, known = self._law.steady_slope(), self._done.interface
        if slope is None or not np.any(slope):
            return {}
        impedance, found = self._done.scene.impedance, dict[str, float]()
        beside = np.diff(np.flatnonzero(self._on)) == 1
        slips = known.slip_rate[:, self._on] != 0
        ends = (slips[:, 1:] != slips[:, :-1]) & beside
        share = np.broadcast_to(slope / (slope + impedance), len(self._law_x))[1:]
        for name in ("slip", "slip_rate"):
            values = np.abs(getattr(known, name)[:, self._on])
            steps = np.pad(np.abs(np.diff(values, axis=1)) * beside, ((0, 0), (2, 2)))
            reach = 0.75 * sliding_window_view(steps, 5, axis=1).max(axis=-1)
            mean = np.where(slips[:, 1:], values[:, 1:], values[:, :-1])
            excess = np.maximum(2 * np.sqrt(reach * mean) - reach, 0.0)
            found[name] = float((share * (mean - excess))[ends & (mean < reach)].sum())
        compliance = self._compliance(self._done.scene.mode != "antiplane")
        of_slip = np.pi / (2 * self._spacing * compliance) * found["slip"]
        found["shear_traction"] = of_slip + impedance * found["slip_rate"]
        return found

    @cached_property
    def missed_slip(self) -> tuple[float, float]:
        """The longest slip next to edges whose first node sticks, and the areas of all, added up.

        The first node may stick on any grid that is too coarse, and slip that is zero on two grids
        does not differ.
        """
        scene, known = self._done.scene, self._done.interface
        if not scene.law.has_threshold or not len(self._first):
            return 0.0, 0.0
        still = np.zeros(len(self._law_x))
        frames = zip(known.felt_pressure[:, self._on], known.state[:, self._on], strict=True)
        strength = [self._law.strength(p, still, state)[self._place] for p, state in frames]
        change = self._at("shear_traction") - self._shear
        room = np.array(strength) - np.sign(change) * self._shear
        sticks = (self._at("slip") == 0) & (room > 0) & (self._at("gap") <= 0)
        lengths, areas = zone_beside_edge(
            np.abs(change), room, sticks, self._spacing, self._compliance(scene.mode != "antiplane")
        )
        return float(lengths.max(initial=0.0)), float(areas.sum())

    @cached_property
    def missed_opening(self) -> tuple[float, float]:
        """The areas of `hidden_openings`, added up, and their forces over what drives slip."""
        known, shear, pressure = (
            self._done.interface,
            self._at("shear_traction"),
            self._at("pressure"),
        )
        left, size = np.broadcast_to(self._pressure, pressure.shape), self._spacing
        areas, forces = hidden_openings(pressure, left, shear, size, self._compliance(True))
        base = at_nodes("shear", self._done.scene.base.shear, known.x, self._on, size)
        driving = size * float(np.abs(known.shear_traction - base)[:, self._on].sum())
        force = float(forces[self._slips].sum())
        return float(areas.sum()), force / (force + driving) if force else 0.0

    def _compliance(self, in_plane: bool) -> float:
        """Return the mean of (1 - nu) / mu of both bodies, or of 1 / mu [1 / stress]."""
        scene = self._done.scene
        bodies = (scene.material, scene.lower_material or scene.material)
        return sum((1 - in_plane * body.poisson_ratio) / body.shear_modulus for body in bodies) / 2


def read_edge(run: Any, edge: float, frame: int) -> EdgeReading:
    """Return what `Marched.beside_edge` describes."""
    known, scene, spacing = run.interface, run.scene, run.scene.period / run.nodes
    ends = [float(end) for part in scene.contact.intervals for end in part]
    near = min(ends, key=lambda end: abs(end - edge))
    if not abs(near - edge) < spacing / 2:
        raise SceneError(
            f"edge: no part of the contact begins or ends at x = {edge:g}; ends are "
            f"{', '.join(f'{end:g}' for end in ends if abs(end) < math.inf) or 'nowhere'}."
        )
    side = 1 if ends.index(near) % 2 == 0 else -1
    inside = np.flatnonzero(known.touching & (side * (known.x - near) > 0))[::side]
    outside = np.flatnonzero(~known.touching & (side * (known.x - near) < 0))[::-side]
    inside, outside = (
        nodes[: min(_unbroken(nodes) // 2, MOST_NODES)] for nodes in (inside, outside)
    )
    if min(len(inside), len(outside)) < _LEAST_READ:
        raise SceneError(
            f"edge: fewer than {2 * _LEAST_READ} nodes lie between x = {near:g} and the next end "
            "of the contact; take more nodes."
        )
    slip = np.abs(known.slip[frame])
    if slip[inside[:_LEAST_READ]].max() > LEAST_GAP * slip[outside[0]]:
        raise SceneError(
            f"edge: the contact slips next to x = {near:g} at t = {known.t[frame]:g}, so that "
            "tractions are not those of a stuck edge; read nodal values."
        )
    base = sampled("scene: shear", scene.base.shear, known.x, spacing)[inside]
    pressed = sampled("scene: pressure", scene.base.pressure, known.x, spacing)[inside]
    shear, gone = (
        known.shear_traction[frame, inside] - base,
        pressed - known.pressure[frame, inside],
    )
    beta = 0.0
    if (pair := pair_of(scene)) is not None:
        beta = pair.sense * pair.kernels.compliance.dundurs
    # x and shear change sign together where the contact lies on the other side
    slot = side * known.slip[frame, outside] + 1j * known.gap[frame, outside]
    distance, traction, depth, motion = read_beside_edge(
        side * shear + 1j * gone, slot, spacing, beta
    )
    return EdgeReading(
        distance,
        side * traction.real + base[1:-1],
        pressed[1:-1] - traction.imag,
        depth,
        side * motion.real,
        motion.imag,
    )


def _unbroken(nodes: NDArray[np.intp]) -> int:
    """Return how many of the nodes, from the first one on, are neighbours of one another."""
    breaks = np.flatnonzero(np.abs(np.diff(nodes)) > 1)
    return int(breaks[0]) + 1 if len(breaks) else len(nodes)


_LEAST_READ = 4
"""Nodes on either side of an edge that must stick, or be free, for its tractions to be read."""
