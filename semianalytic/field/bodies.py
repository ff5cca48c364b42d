"""Exact velocity, stress and displacement of a self-similar scene anywhere in both bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.load import normal_load
from semianalytic.cut.zones import ZoneFields
from semianalytic.field import tuning
from semianalytic.field.body import (
    Sent,
    checked_points,
    fields_of,
    points_around,
    reflected_fields,
)
from semianalytic.field.cells import Primitives
from semianalytic.field.sources import Step
from semianalytic.field.transform import Transform
from semianalytic.halfplane.rayleigh import Array, rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.contact import traction_ahead
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
        rows = unit * self._rows(x, y, t)[[0, 1, 7] if self.scene.antiplane else [0, 1]]
        load = self.scene.load
        if isinstance(load, IncidentWave):
            speed = load.particle_velocity(self.scene.material)
            rows += _along(load, speed * (self._lag(load, x, y, t) >= 0), len(rows))
        return rows

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the stress; see `Solution.stress`."""
        rows = self._rows(x, y, t)[[2, 3, 4, 8, 9] if self.scene.antiplane else [2, 3, 4]]
        rows *= self.stress_unit
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
        rows = unit * self._rows(x, y, t)[[5, 6, 10] if self.scene.antiplane else [5, 6]]
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
        at = *points_around(self._shear.reach), 1 / self.scene.material.shear_speed
        rows, step = self._rows(*at), self.scene.superposition.taken_off
        largest = max(abs(step.pressure), abs(step.shear)) / self.stress_unit
        least = min(largest, 1.0) or 1.0  # a base may be far more than what changes
        change = np.abs(rows - coarse._rows(*at)) / (least + np.abs(rows))
        cells = tuning.COARSE_ERROR if self._shear.source.is_coarse else tuning.CELL_ERROR
        return cells + float(change.max())

    def _rows(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the rows of `body.upper` in either body, those of antiplane shear last."""
        x, y, t = checked_points(x, y, t)
        antiplane = self.scene.antiplane
        count, moved = (11, (5, 6, 10)) if antiplane else (7, (5, 6))
        rows = np.zeros((count, *x.shape))
        time, lower = self.scene.material.shear_speed * t, np.signbit(y)
        for below in (False, True):
            parts = self._sent(below)
            here = (t > 0) & (lower == below)
            at = x[here], np.abs(y[here]), time[here]
            rows[:, here] = fields_of(parts, count, moved, at)
            before = (t <= 0) & (lower == below)
            if self.shear.load.slowness > 0:
                at = x[before], np.abs(y[before]), time[before]
                rows[:, before] = reflected_fields(parts, count, at)
        return rows

    def _sent(self, below: bool) -> list[Sent]:
        """Return what shear and pressure send into the upper body, or into the one below."""
        antiplane, none = self.scene.antiplane, np.ones(4 if self.scene.antiplane else 7)
        sheared, signs = (slice(7, 11), _ALONG) if antiplane else (slice(0, 7), _SHEARED)
        parts = [Sent(self._shear, sheared, signs if below else none)]
        if self._normal is not None:
            mirrored = -_SHEARED if below else np.ones(7)
            parts.append(Sent(self._normal, slice(0, 7), mirrored))
        return parts

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
        return Primitives(Step(Transform(replace(fields, rule=longer, tail=True))))


def _along(load: IncidentWave, amount: ArrayLike, count: int) -> Array:
    """Return an amount of motion (...) along the direction of a wave's motion, (count, ...)."""
    return np.stack([part * np.asarray(amount) for part in load.polarisation()[:count]])
