"""Velocity of the slot faces under a step on them, over slowness v = -t/x, b = mu = 1.

Shear and pressure on the slot are known from the fields of given zones.  Each of them moves the
face along itself by the impedance of its mode, and across itself by the coupled response of the
half-plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.cut.quadrature.laying import lay_panels
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.cut.quadrature.running import PanelIntegral
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class SlotFaces:
    """Motion of the upper slot face near given zones, for a step of tractions on the slot."""

    fields: ZoneFields

    @cached_property
    def _panels(self) -> Panels:
        return lay_panels(self.fields.factors.in_plane, (Zone(None, None, 1),), self.fields.rule)

    def _transforms(self, k: Array) -> tuple[Array, Array]:
        """Return the transforms of shear traction and of pressure at k > 0."""
        factors = self.fields.factors
        shear = self.fields.stick_transform_off_cut(k) * factors.m_plus(k)
        if self.fields.normal is not None:
            over = -self.fields.normal.stick_transform_off_cut(k)
            return shear, over * factors.m_plus(k, "I")
        unit = factors.m_plus(k, "I") / factors.m_plus_at_zero["I"]
        return shear, self.fields.load.load_pressure * unit

    @cached_property
    def _direct(self) -> tuple[PanelIntegral, PanelIntegral]:
        """Slopes in v = -t/x of v_x (v_z) from shear and of v_y from pressure."""
        factors, panels = self.fields.factors.in_plane, self._panels
        shear, pressure = self._transforms(panels.at.v)

        def slope(transform: Array, mode: Mode) -> PanelIntegral:
            impedance = factors.impedance_on_cut(panels.at, mode)
            density = transform * impedance.imag / np.square(np.abs(impedance))
            return PanelIntegral(panels, density / (np.pi * panels.at.v), factors.c)

        return slope(-shear, self.fields.factors.mode), slope(pressure, "I")

    @cached_property
    def _coupled(self) -> tuple[PanelIntegral, PanelIntegral]:
        """Slopes of v_x from pressure and of v_y from shear: -T k (b^2 - 2k^2 - 2ab) / (mu R)."""
        factors, at = self.fields.factors, self._panels.at
        shear, pressure = self._transforms(at.v)
        z = np.square(at.v)
        product = -at.from_a * at.from_b * (at.v + factors.a) * (at.v + 1)
        root = np.sqrt(np.maximum(product, 0.0))
        rayleigh = np.square(np.square(1 - 2 * z)) + np.square(4 * z * root)
        response = np.where(product > 0, -2 / np.pi * root * (1 - 2 * z) / rayleigh, 0.0)
        return (
            PanelIntegral(self._panels, pressure * response, factors.c),
            PanelIntegral(self._panels, shear * response, factors.c),
        )

    @cached_property
    def _jumps(self) -> tuple[float, float]:
        """Jumps of v_x and v_y at the Rayleigh front of the slot, from the coupled response."""
        factors = self.fields.factors
        # The simple pole of the response at c contributes a jump.
        c = np.array([factors.c])
        shear, pressure = self._transforms(c)
        z = c * c
        numerator = 1 - 2 * z + 2 * np.sqrt((z - factors.a**2) * (z - 1))
        response = numerator / (-2 * c * factors.reduced_rayleigh(c))
        return float((pressure * response)[0]), float((shear * response)[0])

    def velocity(self, v: Array) -> tuple[Array, Array]:
        """Return the tangential and normal velocity of the upper slot face at v = -t/x >= 0.

        Antiplane shear does not move it along the normal, nor does pressure along z.
        """
        load, factors = self.fields.load, self.fields.factors.in_plane
        coupled = self.fields.factors.mode != "III"
        # Ahead of all diffracted waves the loads radiate plane waves into the half-plane, of
        # impedance 1 (shear) and 1/a (pressure).
        plane_waves = (load.load_shear, -load.load_pressure * factors.a)
        lefts = [left.v[0] for left in self._panels.left]
        panel = np.searchsorted(lefts, v, "right") - 1
        result = []
        for axis, far in enumerate(plane_waves):
            value = np.full(v.shape, far)
            integrals = [self._direct[axis]]
            if coupled:
                integrals.append(self._coupled[axis])
                jump = self._jumps[axis]
            for integral in integrals:
                for i in np.unique(panel[panel >= 0]):
                    here = panel == i
                    value[here] += integral.totals[:i].sum()
                    value[here] += integral(int(i), factors.cut(v[here]))
            result.append(np.where(v > factors.c, value + jump, value) if coupled else value)
        return result[0], result[1]
