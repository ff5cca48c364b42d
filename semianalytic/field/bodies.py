"""Exact velocity, stress and displacement of a self-similar scene anywhere in both bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.load import normal_load
from semianalytic.cut.zones import ZoneFields
from semianalytic.field import tuning
from semianalytic.field.body import ALONG, PLANE, Quantity, is_singular, reflected, upper
from semianalytic.field.cells import Primitives
from semianalytic.field.transform import Transform
from semianalytic.halfplane.rayleigh import Array, rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.contact import traction_ahead
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.scene import Scene

_SHEARED = np.array([-1, 1, -1, -1, 1, -1, 1])
"""Signs that turn fields of shear at the mirrored place of the upper body into the lower one's."""
_ALONG = np.array([-1, -1, 1, -1])
"""Signs that turn fields of antiplane shear into those of the lower body in the same way; for
pressure the signs are -_SHEARED."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """The fields in both bodies of a self-similar scene, which its `Solution` returns.

    Attributes
    ----------
    scene : Scene
    shear : ZoneFields
        Fields of the shear tractions on the cut, b = mu = 1 and in `stress_unit`.
    opened : ZoneFields or None
        Fields of the normal problem, with minus pressure as traction, if the contact opens.
    stress_unit : float
        Unit of stress [stress].
    tolerance : float
        Tolerance of the rule on which transforms are formed.
    """

    scene: Scene
    shear: ZoneFields
    opened: ZoneFields | None
    stress_unit: float
    tolerance: float

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the particle velocity; see `Solution.velocity`."""
        unit = self.stress_unit / self.scene.material.shear_impedance
        rows = unit * self._rows("velocity", x, y, t)
        load = self.scene.load
        if isinstance(load, IncidentWave):
            speed = load.particle_velocity(self.scene.material)
            rows += _along(load, speed * (self._lag(load, x, y, t) >= 0), len(rows))
        return rows

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the stress; see `Solution.stress`."""
        rows = self.stress_unit * self._rows("stress", x, y, t)
        load = self.scene.load
        if isinstance(load, IncidentWave):
            base, arrived = self.scene.base, self._lag(load, x, y, t) >= 0
            names = ("xx", "yy", "xy", "xz", "yz")[: len(rows)]
            sigma = load.stresses(self.scene.material)
            rows += np.stack([sigma[name] * arrived for name in names])
            rows[1] -= base.pressure
            rows[-1] += base.shear
            return rows
        rows[1] -= traction_ahead(self.scene, "pressure", x, t)
        rows[-1] += traction_ahead(self.scene, "shear", x, t)
        return rows

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement; see `Solution.displacement`."""
        unit = self.stress_unit / self.scene.material.shear_modulus
        rows = unit * self._rows("displacement", x, y, t)
        load = self.scene.load
        if isinstance(load, IncidentWave):
            speed = load.particle_velocity(self.scene.material)
            rows += _along(load, speed * np.maximum(self._lag(load, x, y, t), 0.0), len(rows))
        return rows

    def _lag(self, load: IncidentWave, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the time since the front of an incident wave has passed [time]."""
        n_x, n_y = (one / load.speed(self.scene.material) for one in load.direction())
        x, y, t = (np.asarray(one, dtype=float) for one in (x, y, t))
        return np.asarray(t - n_x * x - n_y * y)

    @cached_property
    def error(self) -> float:
        """Estimate of the error of velocities and stresses.

        It is relative to themselves plus the largest load, and is the change that a rule ten times
        coarser makes, near the edge as well.
        """
        coarse = replace(self, tolerance=tuning.COARSER * self.tolerance)
        rng, slowest = np.random.default_rng(0), self._shear.reach
        angle, share = rng.uniform(size=(2, tuning.ESTIMATED_POINTS))
        radius, angle = 2 * (2 * slowest) ** -share, 2 * np.pi * angle
        at = radius * np.cos(angle), radius * np.sin(angle), 1 / self.scene.material.shear_speed
        rows, coarser = (
            np.concatenate([one._rows(quantity, *at) for quantity in PLANE])
            for one in (self, coarse)
        )
        step = self.scene.superposition.taken_off
        largest = max(abs(step.pressure), abs(step.shear)) / self.stress_unit
        least = min(largest, 1.0) or 1.0  # a base may be far more than what changes
        change = np.abs(rows - coarser) / (least + np.abs(rows))
        cells = tuning.COARSE_ERROR if self._shear.is_coarse else tuning.CELL_ERROR
        return cells + float(change.max())

    def _rows(self, quantity: Quantity, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the rows of a quantity in either body, those of antiplane shear last."""
        points = [np.asarray(one, dtype=float) for one in (x, y, t)]
        if not all(np.all(np.isfinite(one)) for one in points):
            raise SceneError("positions and times must be finite numbers.")
        x, y, t = np.broadcast_arrays(*points)
        begun = t > 0
        time, below = self.scene.material.shear_speed * t[begun], np.signbit(y[begun])
        at = *_scaled(x[begun], np.abs(y[begun]), time), below
        waved = np.empty((self._count(quantity), len(time)))
        for start in range(0, len(time), tuning.POINTS_AT_ONCE):
            part = slice(start, start + tuning.POINTS_AT_ONCE)
            waved[:, part] = self._finite_or_not(quantity, *(one[part] for one in at))
        if quantity == "displacement":
            waved *= time
        rows = np.zeros((len(waved), *x.shape))
        rows[:, begun] = waved
        before = ~begun
        if before.any() and self.shear.load.slowness > 0:
            speed = self.scene.material.shear_speed
            place = x[before], np.abs(y[before]), speed * t[before]
            below = np.signbit(y[before])
            rows[:, before] = self._in_body(
                quantity, below, lambda part: reflected(part, *place, quantity)
            )
        return rows

    def _count(self, quantity: Quantity) -> int:
        """Return the number of rows of a quantity."""
        every = [PLANE[quantity], *([ALONG[quantity]] if self.scene.antiplane else [])]
        return sum(rows.stop - rows.start for rows in every)

    def _finite_or_not(
        self, quantity: Quantity, x: Array, y: Array, t: Array, below: np.ndarray
    ) -> Array:
        """Return the rows at points (m,), infinite with the right sign where they are singular."""
        rows = self._near(quantity, x, y, t, below, tuning.CLOSE[0])
        singular = np.zeros(x.shape, dtype=bool)
        for part in (self._shear, self._normal):
            if part is not None:
                singular |= is_singular(part, x, y, t)
        if singular.any():
            few = rows[:, singular]
            at = x[singular], y[singular], t[singular], below[singular]
            grown = few - self._near(quantity, *at, tuning.CLOSE[1])
            large = np.abs(grown) > tuning.GROWN * (1 + np.abs(few))
            rows[:, singular] = np.where(large, np.copysign(np.inf, grown), few)
        return rows

    def _near(
        self, quantity: Quantity, x: Array, y: Array, t: Array, below: np.ndarray, close: float
    ) -> Array:
        """Return the rows at points (m,), those on a singularity at the distance `close`."""
        return self._in_body(quantity, below, lambda part: upper(part, x, y, t, close, quantity))

    def _in_body(
        self, quantity: Quantity, below: np.ndarray, in_upper: Callable[[Primitives], Array]
    ) -> Array:
        """Return the rows in either body from those of shear and pressure in the upper one."""
        in_plane, along = _SHEARED[PLANE[quantity], None], _ALONG[ALONG[quantity], None]
        signs = along if self.scene.antiplane else in_plane
        sheared = in_upper(self._shear) * np.where(below, signs, 1)
        normal = 0.0 if self._normal is None else in_upper(self._normal)
        normal = normal * np.where(below, -in_plane, 1)
        return np.concatenate([normal, sheared]) if self.scene.antiplane else sheared + normal

    @cached_property
    def _shear(self) -> Primitives:
        return self._primitives(self.shear)

    @cached_property
    def _normal(self) -> Primitives | None:
        """The integrals of the normal problem; None if the pressure does not change."""
        load = self.shear.load
        if not load.load_pressure or self.opened is not None:
            return None if self.opened is None else self._primitives(self.opened)
        factors = rayleigh_factors(self.scene.material.poisson_ratio, "I")
        closed = normal_load(load.base_pressure, load.load_pressure, load.slowness)
        return self._primitives(ZoneFields(factors, closed, (), self.shear.rule))

    def _primitives(self, fields: ZoneFields) -> Primitives:
        rule = rule_for(self.tolerance)
        longer = replace(rule, reach=rule.reach + tuning.LONGER)
        return Primitives(Transform(replace(fields, rule=longer, tail=True)))


def _along(load: IncidentWave, amount: ArrayLike, count: int) -> Array:
    """Return an amount of motion (...) along the direction of a wave's motion, (count, ...)."""
    return np.stack([part * np.asarray(amount) for part in load.polarisation()[:count]])


def _scaled(x: Array, y: Array, t: Array) -> tuple[Array, Array, Array]:
    """Return the positions (m,) at t = 1 with the same fields, and times 1.

    Fields depend on x / t and y / t alone; displacement is proportional to t besides.  Positions
    are limited to `FARTHEST`, and are put at the edge within `NEAREST` of it.
    """
    with np.errstate(over="ignore"):
        x, y = (np.clip(one / t, -tuning.FARTHEST, tuning.FARTHEST) for one in (x, y))
    at_edge = np.hypot(x, y) < tuning.NEAREST
    return np.where(at_edge, 0.0, x), np.where(at_edge, 0.0, y), np.ones_like(t)
