"""Pairs of solids in units of their own that tests of dissimilar half-planes share."""

from __future__ import annotations

from semianalytic import Material, Scene, Tractions
from semianalytic.dissimilar.compliance import compliance_of

ROCK = Material(1.0, 1.0, 0.25)
PAIRS = {
    "0": (Material(1.0, 1.0, 0.25), Material(2.25, 1.0, 0.30)),
    "A": (Material(1.0, 1.0, 0.3), Material(1.7, 1.1, 0.2)),
    "PMMA on aluminium": (Material(3.2 / 2.7, 1.18, 0.35), Material(70 / 2.66, 2.7, 0.33)),
    "C": (Material(1.0, 1.0, 0.25), Material(1.21, 1.0, 0.25)),
}
ALUMINIUM_ON_STEEL = (Material(70 / 2.66, 2.7, 0.33), Material(210 / 2.6, 7.8, 0.30))
GOUGE_ON_ROCK = (Material(12.0, 2.3, 0.25), Material(30.0, 2.7, 0.25))
RUBBER_ON_STEEL = (Material(0.01 / 2.98, 1.1, 0.49), Material(210 / 2.6, 7.8, 0.30))


def contrast(ratio):
    """Rock on a body of the same density and Poisson ratio, faster by a ratio."""
    return compliance_of(ROCK, Material(ratio**2, 1.0, 0.25))


def scene(name, friction, base, load, **law):
    """A scene of one of `PAIRS`; base and load are (pressure, shear)."""
    upper, lower = PAIRS[name]
    sides = Tractions(*base), Tractions(*load)
    return Scene(upper, friction, *sides, lower_material=lower, **law)
