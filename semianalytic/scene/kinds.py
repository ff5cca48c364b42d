"""Kinds of load histories and friction laws, by the names that they have in files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from semianalytic.scene.friction import (
    CoulombFriction,
    FrictionLaw,
    RateWeakening,
    SlipWeakening,
    ViscousFriction,
)
from semianalytic.scene.loads import Harmonic, LoadHistory, Pulse, Ramp, Step
from semianalytic.scene.plugins import HISTORIES, LAWS
from semianalytic.scene.tabulated import Tabulated

HISTORY_KINDS: Mapping[str, type[LoadHistory]] = {
    "step": Step,
    "ramp": Ramp,
    "pulse": Pulse,
    "harmonic": Harmonic,
    "tabulated": Tabulated,
}
FRICTION_LAWS: Mapping[str, type[FrictionLaw]] = {
    "coulomb": CoulombFriction,
    "viscous": ViscousFriction,
    "rate-weakening": RateWeakening,
    "slip-weakening": SlipWeakening,
}


class Part(NamedTuple):
    """A part of a scene that is named by a kind in files.

    It has a group of entry points, the base class of its classes, the classes of this package by
    kind, and the default.
    """

    group: str
    base: type
    own: Mapping[str, type]
    default: LoadHistory | FrictionLaw


_HISTORY = Part(HISTORIES, LoadHistory, HISTORY_KINDS, Step())
PARTS: Mapping[str, Part] = {
    "pressure_history": _HISTORY,
    "shear_history": _HISTORY,
    "friction_law": Part(LAWS, FrictionLaw, FRICTION_LAWS, CoulombFriction()),
}
"""The parts by name of the field of a scene."""
