"""Exact velocity, stress and displacement of a self-similar scene anywhere in both bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial, partialmethod

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.load import normal_load
from semianalytic.cut.zones import ZoneFields
from semianalytic.field import tuning
from semianalytic.field.body import (
    PLANE,
    Quantity,
    Sent,
    checked_points,
    fields_of,
    points_around,
    reflected_fields,
)
from semianalytic.field.cells import Primitives
from semianalytic.field.plane_wave import plane_wave
from semianalytic.field.sources import LikeBody
from semianalytic.field.transform import Transform
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.arrays import Array
from semianalytic.scene.contact import traction_ahead
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.scene import Scene

_SHEARED = np.array([-1, 1, -1, -1, 1, -1, 1])
"""Signs that turn fields of shear at the mirrored place of the upper body into the lower one's."""
_ALONG = np.array([-1, -1, 1, -1])
"""Signs that turn fields of antiplane shear into those of the lower body in the same way; for
pressure the signs are -_SHEARED."""
_BESIDE = np.outer([-1, 1], 10.0 ** -np.arange(1, 9)).ravel()
"""Relative distances from the end of an opening at which rules are compared."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """The fields in both bodies of a self-similar scene, which its `Solution` returns."""

    scene: Scene
    shear: ZoneFields  # fields of the shear tractions on the cut, b = mu = 1 and in `stress_unit`
    # fields of the normal problem, with minus pressure as traction, if the contact opens
    opened: ZoneFields | None
    stress_unit: float  # [stress]
    tolerance: float  # tolerance of the rule on which transforms are formed

    def _fields(self, quantity: Quantity, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return a quantity, (n, ...); see `Solution.velocity`, `stress` and `displacement`."""
        scene, load = self.scene, self.scene.load
        material, wave = scene.material, isinstance(load, IncidentWave)
        over = {"velocity": material.shear_impedance, "displacement": material.shear_modulus}
        rows = self.stress_unit / over.get(quantity, 1.0) * self._rows(quantity, x, y, t)
        if wave:
            rows = rows + plane_wave(load, (material,), quantity, (x, y, t))[: len(rows)]
        if quantity == "stress":
            # Pressure is positive in compression, sigma_yy in tension; sigma_xx of the base is not
            # known.  The wave has its own tractions.
            base, ahead = scene.before_load, partial(traction_ahead, scene, x=x, t=t)
            rows[1] -= base.pressure if wave else ahead("pressure")
            rows[-1] += base.shear if wave else ahead("shear")
        return rows

    velocity = partialmethod(_fields, "velocity")
    stress = partialmethod(_fields, "stress")
    displacement = partialmethod(_fields, "displacement")

    @cached_property
    def error(self) -> float:
        """Estimate of the error of velocities and stresses, over them plus the largest load."""
        # The change that a rule ten times coarser makes, near the edge as well.
        coarse = replace(self, tolerance=tuning.COARSER * self.tolerance)
        x, y = points_around(self._shear.reach)
        if self.shear.borders and self.opened is not None:
            # the traction of a film jumps on the face at the ends of an opening
            ends = [end for zone in self.opened.zones for end in (zone.left, zone.right) if end]
            beside = np.outer([1 / end.v[0] for end in ends], 1 + _BESIDE).ravel()
            x, y = np.append(x, beside), np.append(y, 0 * beside)
        at = x, y, 1 / self.scene.material.shear_speed
        rows, coarser = (
            np.concatenate([body._rows(quantity, *at) for quantity in PLANE])
            for body in (self, coarse)
        )
        step = self.scene.superposition.taken_off
        largest = max(abs(step.pressure), abs(step.shear)) / self.stress_unit
        least = min(largest, 1.0) or 1.0  # a base may be far more than what changes
        change = np.abs(rows - coarser) / (least + np.abs(rows))
        cells = tuning.COARSE_ERROR if self._shear.source.is_coarse else tuning.CELL_ERROR
        return cells + float(change.max())

    def _rows(self, quantity: Quantity, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the rows of a quantity in either body, those of antiplane shear last."""
        x, y, t = checked_points(x, y, t)
        time, begun = self.scene.material.shear_speed * t, t > 0
        waved = fields_of(self._sent, quantity, (x[begun], y[begun], time[begun]))
        rows = np.zeros((len(waved), *x.shape))
        rows[:, begun] = waved
        before = ~begun
        if before.any() and self.shear.load.slowness > 0:
            at = x[before], y[before], time[before]
            rows[:, before] = reflected_fields(self._sent, quantity, at)
        return rows

    @cached_property
    def _sent(self) -> tuple[Sent, ...]:
        """Waves that shear and, if it changes, pressure send into the bodies."""
        sheared = Sent(self._shear, _ALONG if self.scene.antiplane else _SHEARED)
        return (sheared,) if self._normal is None else (sheared, Sent(self._normal, -_SHEARED))

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
        # A contact that stays closed transmits the pressure of the slot all the same.
        closed = normal_load(load.base_pressure, load.load_pressure, load.slowness)
        return self._primitives(ZoneFields(factors, closed, (), self.shear.rule))

    def _primitives(self, fields: ZoneFields) -> Primitives:
        rule = rule_for(self.tolerance)
        # Transforms grow as k^1/2 at a stuck edge, where the rule of the zones may end earlier: of
        # what is left out at v they miss the share (k / v)^1/2.
        longer = replace(rule, reach=rule.reach + 28.0)
        return Primitives(LikeBody(Transform(replace(fields, rule=longer, tail=True))))
