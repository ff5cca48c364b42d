"""Velocity, stress and displacement in both bodies after a march along a line.

The bodies are driven by slip rate and opening rate of the whole line, slots included.  Both are
bounded where tractions are singular, and hold all loads of slots.  One Fourier transform along x
and one in time, at frequencies s = eta + i omega (the exponential window), give the waves that the
faces send (`transfer`); sums over them are the fields (`spectrum`).  Actions
that do not move its faces against each other are added: base, tractions that come from afar, and
the plane wave of an incident load.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.engine.bodies.motion import Levels, Motion
from semianalytic.engine.bodies.spectrum import Asked, Spectrum, between, steady
from semianalytic.engine.stepping.line import Grid
from semianalytic.field.body import Quantity, checked_points
from semianalytic.field.plane_wave import plane_wave
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.results.derived import hooke
from semianalytic.results.questions import ROUNDING, check_times
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import finite
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.line.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.material import Material
from semianalytic.scene.scene import Scene

Flags = NDArray[np.bool_]

STEPS = 0.3, 0.8
"""Spacing of levels over h / c_t: shorter and longer steps of a march are interpolated."""
MOST_LEVELS = 1 << 25
"""Largest number of levels times nodes, of which rates take 12 bytes each, with opening 24."""
STICKS = 1e-3
"""Part of the slip of a slot next to an edge up to which the contact there sticks."""
AT_ONCE = 128
"""Places along x whose histories are formed at once."""
KEPT = 8
"""Depths whose histories are kept."""


@dataclass(frozen=True, eq=False)
class MarchedBodies:
    """The fields in both bodies after a march.

    Attributes
    ----------
    scene : Scene
        What was marched.
    motion : Motion
        Rates of the nodes of one period, slots included, less those of the bodies far away.
    first, spacing : float
        Position of the first node, and node distance [length].
    edges : tuple of (position, side)
        Edges at which tractions are singular, and 1 or -1 for a contact right or left of them.
    centre : float, optional
        Position about which everything is even [length].
    within : (float, float)
        Least and largest x [length]; beyond them all is as it is there.
    nearest : float
        Least distance from the interface at which stress is known [length].
    followed : float
        How far the contact is known [length].
    earlier : Motion, optional
        What moved before the motion, which is then the rate beyond its last one.
    """

    scene: Scene
    motion: Motion
    first: float
    spacing: float
    edges: tuple[tuple[float, float], ...] = ()
    centre: float | None = None
    within: tuple[float, float] = (-math.inf, math.inf)
    nearest: float = 0.0
    followed: float = math.inf
    earlier: Motion | None = None

    @property
    def length(self) -> float:
        """Period of the line [length]."""
        return self.motion.slip.shape[1] * self.spacing

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the particle velocity; see `AnswerInBodies.velocity`."""
        return self._carried(self._field("velocity", x, y, t), y, 1.0)

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement since t = 0; see `AnswerInBodies.displacement`."""
        return self._carried(self._field("displacement", x, y, t), y, np.maximum(t, 0.0))

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the stress; see `AnswerInBodies.stress`."""
        x, y, t = checked_points(x, y, t)
        self._check_depth(y)
        rows, base = self._field("stress", x, y, t), self.scene.base
        rows[1] -= _uniform(base.pressure)
        rows[-1] += _uniform(base.shear)
        for load in self.scene.loads:
            # a load far away that is everywhere at once is in place on both bodies
            if isinstance(load, InterfaceLoad) and load.on == "line" and load.history is not None:
                for row, of, sign in ((1, "pressure", -1.0), (-1, "shear", 1.0)):
                    if size := _uniform(getattr(load, of)):
                        rows[row] += sign * size * _factors(load, t)
        return rows

    def _carried(self, rows: Array, y: ArrayLike, amount: ArrayLike) -> Array:
        """Return rows of a motion with that of the bodies far away added, so often [time]."""
        half = np.copysign(self.scene.plate_rate / 2, np.asarray(y, dtype=float))
        rows[-1 if self.scene.antiplane else 0] += half * np.asarray(amount)
        return rows

    def _field(self, quantity: Quantity, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the rows (n, ...) of a quantity, of which stress is the change by all waves."""
        x, y, t = checked_points(x, y, t)
        check_times(t, self.motion.t)
        self._check_reach(x, y, t)
        rows = np.zeros((self._rows_of(quantity), *x.shape))
        begun = t > self.motion.t[0]
        if begun.any() and self.motion.slip.size:
            rows[:, begun] = self._moved(quantity, x[begun], y[begun], t[begun])
        for load in self.scene.loads:
            if isinstance(load, FrontLoad) and isinstance(load.front, IncidentWave):
                at = x - load.at, y, t
                wave = plane_wave(load.front, self._solids, quantity, at, load.history)
                rows += wave[: len(rows)]
        return rows

    def _rows_of(self, quantity: Quantity) -> int:
        stress, along = quantity == "stress", self.scene.antiplane
        return 2 + stress + along * (1 + stress)

    def _moved(self, quantity: Quantity, x: Array, y: Array, t: Array) -> Array:
        """Return the rows (n, p) of a quantity that motion of the faces makes, at points (p,)."""
        rows, below = np.empty((self._rows_of(quantity), len(x))), np.signbit(y)
        if self._count * self.motion.slip.shape[1] > MOST_LEVELS:
            times = np.unique(t)
            groups = np.split(times, np.flatnonzero(np.diff(times) > self._across) + 1)
            for begin, end in ((float(group[0]), float(group[-1])) for group in groups):
                here, window = (t >= begin) & (t <= end), self._window(begin, end)
                rows[:, here] = window._moved(quantity, x[here], y[here], t[here])
            return rows
        asked: Asked = "strain" if quantity == "stress" else quantity
        place = np.clip(x + self._displaced(x), *self.within)
        # Without opening the lower body is the mirror image of the upper one.
        alike = self.scene.lower_material is None and not self.motion.opening.size
        flips = np.array([1, 1, -1, 1, -1] if asked == "strain" else [1, -1, 1])[: len(rows), None]
        parts: Sequence[tuple[bool, Flags]] = [(False, ~below), (True, below)]
        for lower, here in [(False, np.ones_like(below))] if alike else parts:
            if here.any():
                at = place[here], np.abs(y[here])
                found = self._summed(lower, asked, *at, t[here])
                if self.earlier is not None:
                    found = found + self._carried_on(lower, asked, *at, t[here])
                rows[:, here] = found[: len(rows)]
        # seen from its own face, what is odd in y changes its sign in the lower body
        rows[:, below] *= -flips if alike else flips
        if asked == "strain":
            rows = np.where(below, *(hooke(rows, self.scene.bodies[lower]) for lower in (1, 0)))
        return rows

    def _summed(self, lower: bool, asked: Asked, x: Array, depth: Array, t: Array) -> Array:
        """Return rows at points (p,) of one body, by sums for each depth or for each time."""
        times, depths = np.unique(t), np.unique(depth)
        found = np.empty((5 if asked == "strain" else 3, len(x)))
        # what a depth costs, and a time, over what a wave at one depth does
        if len(times) * (30 + 6 * len(depths)) < 150 * len(depths):
            for time in times:
                at = t == time
                found[:, at] = self._spectrum.picture(lower, asked, x[at], depth[at], float(time))
            return found
        levels = self._levels
        for level in depths:
            at = np.flatnonzero(depth == level)
            places, which = np.unique(x[at], return_inverse=True)
            for start in range(0, len(places), AT_ONCE):
                some = places[start : start + AT_ONCE].tolist()
                record = self._histories(lower, asked, float(level), *some)
                here = (which >= start) & (which < start + AT_ONCE)
                place, weight = between(
                    (t[at[here]] - levels.start) / levels.step, levels.count + 1, 3
                )
                columns = (which[here] - start)[:, None]
                found[:, at[here]] = (record[:, columns, place] * weight).sum(axis=-1)
        return found

    def _carried_on(self, lower: bool, asked: Asked, x: Array, depth: Array, t: Array) -> Array:
        """Return the static field of what moved before, and goes on at its last rates."""
        earlier = self.earlier
        assert earlier is not None
        motion = {"z" if self.scene.antiplane else "x": earlier.slip, "y": earlier.opening}
        rates = {name: rows[-1] for name, rows in motion.items() if rows.shape[1]}
        line, at = (asked, self._solids, lower, self.first, self.spacing), (x, depth, self._held)
        going = steady(*line, rates, *at)
        if asked == "velocity":
            return going
        moved = {name: np.diff(earlier.t) @ motion[name] for name in rates}
        return steady(*line, moved, *at) + (t - earlier.t[-1]) * going

    @cached_property
    def _window(self) -> Callable[[float, float], MarchedBodies]:
        """The bodies from a time before the first asked for, at which all is static."""
        return lru_cache(maxsize=KEPT)(self._from_quiet)

    def _from_quiet(self, begin: float, end: float) -> MarchedBodies:
        most = self._step * (MOST_LEVELS // self.motion.slip.shape[1] - 1)
        parts = self.motion.divided(begin, end, most, self._across)
        if parts is None:
            raise SceneError(
                f"fields in the bodies: slip is never slow in the {most:.3g} before t = {end:.6g}, "
                "and a longer time takes too much memory; end the march earlier, or take fewer "
                "nodes."
            )
        return replace(self, motion=parts[1], earlier=parts[0])

    @property
    def _across(self) -> float:
        """The time in which a shear wave runs along the line [time]."""
        return self.length / self.scene.material.shear_speed

    @cached_property
    def _step(self) -> float:
        """The spacing of the times of the transform [time]."""
        speed = self.scene.material.shear_speed
        least, most = (share * self.spacing / speed for share in STEPS)
        # the shortest steps, but for those that a jump of a load or the end has cut
        return float(np.clip(np.quantile(np.diff(self.motion.t), 0.1), least, most))

    @property
    def _count(self) -> int:
        """The number of times of the transform."""
        return math.ceil((self.motion.t[-1] - self.motion.t[0]) / self._step * (1 - 1e-9))

    @cached_property
    def _levels(self) -> Levels:
        """The times of the transform."""
        return Levels(float(self.motion.t[0]), self._step, max(self._count, 16))

    @property
    def _solids(self) -> tuple[Material, ...]:
        """The solid of both bodies, or both solids."""
        scene = self.scene
        return (scene.material,) if scene.lower_material is None else scene.bodies

    @property
    def _held(self) -> float:
        """Wavenumber of the stiffness that the mean meets [1 / length]."""
        return 0.0 if self.scene.held == math.inf else 2 * math.pi / self.scene.held

    @cached_property
    def _histories(self) -> Callable[..., Array]:
        """Histories of a field at one depth and some places, which gauges ask for repeatedly."""
        return lru_cache(maxsize=KEPT)(
            lambda lower, asked, depth, *x: self._spectrum.histories(
                lower, asked, np.array(x), depth
            )
        )

    @cached_property
    def _spectrum(self) -> Spectrum:
        """The waves that the faces send."""
        motion, along = self.motion, "z" if self.scene.antiplane else "x"
        rates = {along: self._levels.means(motion.t, motion.slip)}
        if motion.opening.size:
            rates["y"] = self._levels.means(motion.t, motion.opening)
        grid = self.first, self.spacing
        return Spectrum.of(self._levels, self._solids, *grid, rates, self._held, self.centre)

    def _displaced(self, x: Array) -> Array:
        """Return how far from places x (p,) the grid has what belongs there [length].

        Next to an edge of singular tractions it has its first node 0.310 h from there, not h / 2.
        """
        if not self.edges:
            return np.zeros_like(x)
        places, sides = np.array(self.edges).T
        nodes = self.motion.slip.shape[1]
        offset, _ = edge_offset_and_factors()
        share = np.interp(x, places, sides, period=nodes * self.spacing)
        return np.asarray((0.5 - offset) * self.spacing * share)

    def _check_reach(self, x: Array, y: Array, t: Array) -> None:
        """Raise SceneError for times and places that the nodes do not determine."""
        end = self.followed
        if end < math.inf:
            # beyond the contact that a march follows something happens from the first wave on
            arrival = (end + np.hypot(x - end, y)) / self.scene.fastest_speed
            if np.any(t > arrival * (1 + ROUNDING)):
                raise SceneError(
                    f"this answer covers the contact to x = {end:.6g} only, and waves from beyond "
                    "have arrived; ask for earlier times, or march farther (docs/limits.md)."
                )
            if self.scene.front_slowness and np.any(x < self.within[0]):
                raise SceneError(
                    "the load that runs along the slot is followed from x = "
                    f"{self.within[0]:.6g} on; ask for fields ahead of that."
                )

    def _check_depth(self, y: Array) -> None:
        """Raise SceneError for points at which the grid does not resolve stress."""
        near = np.abs(y) < self.nearest * (1 - 1e-9)
        if near.any():
            depth = float(np.abs(y[near]).min())
            nodes = self.motion.slip.shape[1]
            instead = "ask for stress farther from the interface"
            if depth > 1e-9 * self.spacing:
                enough = 4 * math.ceil(nodes * self.spacing / depth / 4)
                instead = f"take {enough} nodes of the line, or " + instead
            raise SceneError(
                f"stress: y = {depth:.3g} is nearer to the interface than nodes "
                f"{self.spacing:.3g} apart resolve; {instead}."
            )


def bodies_on(scene: Scene, motion: Motion, grid: Grid) -> MarchedBodies:
    """Return the bodies of a march on a grid, of which all nodes have a motion."""
    slip, opening, first = motion.slip - np.float32(scene.plate_rate), motion.opening, grid.x[0]
    if grid.even:
        # a node at an end of half the line has no image
        alone, first = int(not grid.between), -grid.x[-1]
        slip, opening = (
            np.concatenate([half[:, alone:][:, ::-1], half[:, : half.shape[1] - alone]], axis=1)
            for half in (slip, opening)
        )
    motion = Motion(motion.t, slip, opening if opening.any() else opening[:, :0])
    spacing = grid.spacing
    edges = tuple(singular_edges(scene, motion, first, spacing))
    centre = 0.0 if grid.even else None
    line = scene, motion, float(first), spacing, edges, centre
    return MarchedBodies(*line, nearest=spacing)


def singular_edges(
    scene: Scene, motion: Motion, first: float, spacing: float
) -> Iterator[tuple[float, float]]:
    """Yield the edges at which tractions are singular: those that stick, or slip under a pressure
    that is singular."""
    lengths = np.diff(motion.t)
    nodes = motion.slip.shape[1]
    for end in scene.contact.ends(nodes * spacing):
        side = 1.0 if scene.contact.touches([end + spacing / 2])[0] else -1.0
        place = (end - first) / spacing
        inside = math.floor(place) + 1 if side > 0 else math.ceil(place) - 1
        on, off = inside % nodes, (inside - int(side)) % nodes
        slips, opens = (
            [float(lengths @ np.abs(values[:, at])) for at in (on, off)]
            if values.size
            else [0.0, 0.0]
            for values in (motion.slip, motion.opening)
        )
        pressed = opens[1] > 0 and scene.lower_material is None
        sticks = slips[0] <= STICKS * slips[1] or pressed
        if sticks and opens[0] <= STICKS * opens[1]:
            yield float(end), side


def _uniform(field: object) -> float:
    """Return a field along x if it is a number: one that varies does not say what the bodies carry
    away from the interface."""
    return finite(field) or 0.0


def _factors(load: InterfaceLoad, t: Array) -> Array:
    """Return the factors of a load at times of any shape, after jumps."""
    times, which = np.unique(t, return_inverse=True)
    values = np.array([load.factor(time, after=True) if time >= 0 else 0.0 for time in times])
    return values[which].reshape(t.shape)
