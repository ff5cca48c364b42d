"""Whole fields of a stuck interface whose slot is loaded by a unit step, cached per solid."""

from __future__ import annotations

from functools import lru_cache

from semianalytic.cut.load import Load
from semianalytic.cut.zones import ZoneFields
from semianalytic.field import tuning
from semianalytic.field.bodies import Bodies
from semianalytic.halfplane.rayleigh import Mode, rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.scene import ANTIPLANE, IN_PLANE, Material, Scene, Tractions


@lru_cache(maxsize=16)
def stuck_step(material: Material, mode: Mode) -> Bodies:
    """Return the fields of a unit step of pressure (mode I) or of shear (modes II and III).

    The slot faces x < 0 receive the traction change (-1, 0) or (0, -1) [stress]; there is no base.
    """
    load = Tractions(1.0, 0.0) if mode == "I" else Tractions(0.0, 1.0)
    kind = ANTIPLANE if mode == "III" else IN_PLANE
    # Without zones nothing slips, whatever the friction: the scene says the material and the base.
    scene = Scene(material, 0.0, Tractions(0.0, 0.0), load, mode=kind)
    rule = rule_for(tuning.STEP_TOLERANCE)
    sheared = Load(0.0, 0.0, 0.0, load.pressure, load.shear, 0.0)
    factors = rayleigh_factors(material.poisson_ratio, "III" if mode == "III" else "II")
    return Bodies(scene, ZoneFields(factors, sheared, (), rule), None, 1.0, tuning.STEP_TOLERANCE)
