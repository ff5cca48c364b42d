"""Problems for codes of dynamic contact: scenes, stations, and what is to be reported.

Each stands in two systems of units: mu = rho = c_t = T = 1, and `SI_MATERIAL` with tractions in
units of `SI_STRESS`, where T is one second.  Every answer in SI is the plain one times a number of
`SI_SCALES`.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from semianalytic import (
    Material,
    MovingLoad,
    Pair,
    Patch,
    Scene,
    Tractions,
    ViscousFriction,
    WholeLine,
    find_line,
)
from semianalytic.dissimilar.described import pair_of
from semianalytic.prediction import chosen_method
from semianalytic.scene.errors import SceneError
from semianalytic.scene.named import LINES, find_scene
from semianalytic.scene.units import SI

Array = NDArray[np.float64]

STATIONS = (0.1, 0.25, 0.5, 0.75, 0.95)
"""Distances of the stations from the contact edge, over c_t T."""
TIMES = (*(step / 64 for step in range(1, 64, 2)), 1.0)
"""Times of the exact records, over T; no front of any sheet passes a station at one of them."""
CELLS = (50, 100, 200)
"""Numbers of cells over c_t T that have tolerance classes."""

SLIP, OPENING = "slip", "opening"
SLIPPING = ("slip_rate", "slip", "shear_traction")

SI_SHEAR_MODULUS, SI_DENSITY = 1e10, 2500.0
"""Shear modulus [Pa] and density [kg/m^3] in SI units; shear waves travel at 2000 m/s."""
SI_STRESS = 1e7
"""Traction [Pa] that corresponds to a dimensionless traction of 1."""
SI_SCALES: Mapping[str, float] = {
    "x": 2000.0,  # c_t T [m]
    "t": 1.0,  # T [s]
    "slip_rate": 2.0,  # SI_STRESS / (rho c_t) [m/s]
    "slip": 2.0,  # SI_STRESS c_t T / mu [m]
    "shear_traction": SI_STRESS,
    "pressure": SI_STRESS,
}
"""Factors that convert numbers in units mu = rho = c_t = T = 1 to SI units."""


@dataclass(frozen=True)
class Sheet:
    """A problem.

    Attributes
    ----------
    name : str
        That of the scene, as in `find_scene`.
    title : str
    tests : str
        What a code that passes can do.
    report : tuple of str
        Quantities to record at the stations, among `compare.records.record.QUANTITIES`.
    arrival : str
        What is timed at the stations: "slip", the first slip rate above `THRESHOLD`; "opening", the
        first pressure below it; "" if nothing is.
    note : str
        What else has to be known.
    """

    name: str
    title: str
    tests: str
    report: tuple[str, ...]
    arrival: str = SLIP
    note: str = ""

    @property
    def scene(self) -> Scene:
        """The scene of the problem in units mu = rho = c_t = 1.

        Of two different bodies it is the upper one on its own kind, which has friction, tractions
        and scales of the problem.
        """
        return PAIRS[self.name].alike if self.is_pair else find_scene(self.name)

    @property
    def is_pair(self) -> bool:
        """Whether the problem is of two different bodies; all units are those of the upper one."""
        return self.name in PAIRS

    @property
    def is_line(self) -> bool:
        """Whether the problem is a line without a slot, and no scene."""
        return self.name in LINES

    @property
    def problem(self) -> Scene | Pair | WholeLine:
        """The scene, the two bodies or the whole line, in units mu = rho = c_t = 1."""
        if self.is_pair:
            return PAIRS[self.name]
        if not self.is_line:
            return self.scene
        line = find_line(self.name)
        assert isinstance(line, WholeLine)
        return line

    @property
    def si_problem(self) -> Scene | Pair | WholeLine:
        """The problem in metres, seconds, kilograms and pascals."""
        problem = self.problem
        if isinstance(problem, Pair):
            return pair_in_si(problem)
        return line_in_si(problem) if isinstance(problem, WholeLine) else in_si(problem)

    @property
    def si_scene(self) -> Scene:
        """The scene of the problem in metres, seconds, kilograms and pascals."""
        return in_si(self.scene)

    @property
    def is_marched(self) -> bool:
        """Whether the answer is marched: not exact, but with an error estimate."""
        return not self.is_line and chosen_method(self.scene) == "space-time"


THRESHOLD = 0.002
"""Slip rate over the largest load over rho c_t, or pressure over that of the base, at which slip or
opening counts as begun."""

_SHEETS = (
    Sheet(
        "stuck",
        "A slot struck from afar, friction that holds",
        "diffraction at the edge: both tractions are singular there and nothing may slip",
        (*SLIPPING, "pressure"),
        arrival="",
        note="Slip and slip rate are zero; errors of them are over those that the load would make "
        "on a free surface.",
    ),
    Sheet(
        "preloaded",
        "Supershear daughter",
        "slip from the edge behind the Rayleigh wave, a stick gap, and a daughter zone across the "
        "shear wave",
        SLIPPING,
        note="Slip heals between the two zones.  Of the daughter, hardly faster than the shear "
        "wave, the slip rate is at most a 24th of that at the edge.",
    ),
    Sheet(
        "remote-shock",
        "A shock from afar, friction just low enough",
        "the same two zones under a pressure that varies and is singular at the edge",
        (*SLIPPING, "pressure"),
    ),
    Sheet(
        "auxetic",
        "Reverse slip around the Rayleigh front",
        "slip that changes its sense twice; slip rate has a logarithm at the Rayleigh front",
        SLIPPING,
        note="Poisson ratio -0.5: a code must not take it for positive.",
    ),
    Sheet(
        "viscous",
        "A viscous film",
        "strength that grows with slip rate: one zone across the Rayleigh front",
        SLIPPING,
        note="Strength is friction times pressure plus 0.1 mu/c_t times slip rate.",
    ),
    Sheet(
        "antiplane",
        "Antiplane shear",
        "one zone that grows from the edge, all of it in closed form",
        SLIPPING,
        note="In the place of Kostrov's problem, and not that problem: his crack of 1966 "
        "(J. Appl. Math. Mech. 30, 1241) runs at a speed that is given, with a singular edge; here "
        "friction gives the speed, c_t / (1 + f P_b / Q_0)^2 = 4/9 c_t, at which the edge carries "
        "no singularity.",
    ),
    Sheet(
        "lift-off",
        "The contact opens from its edge",
        "separation: up to 3/16 c_t, parting smoothly",
        ("pressure",),
        arrival=OPENING,
        note="Nothing slips, for there is no shear.",
    ),
    Sheet(
        "lift-off-shear",
        "Slip ahead of an opening",
        "separation with slip: friction grows from nothing at the end of the opening",
        (*SLIPPING, "pressure"),
        note="Where the contact is open, slip is the difference of the tangential displacements.",
    ),
    Sheet(
        "tap",
        "Separation ahead of a tap",
        "a contact that opens ahead of the Rayleigh wave and closes again behind it",
        ("pressure",),
        arrival=OPENING,
        note="Nothing slips, for there is no shear.",
    ),
    Sheet(
        "pulse",
        "A pulse of shear",
        "a load that goes off again, at 0.4 T: slip slows down, heals, and turns back at the edge",
        SLIPPING,
        note="Not self-similar: the answer is marched, to as many digits as are sure.",
    ),
)

SHEETS: Mapping[str, Sheet] = {sheet.name: sheet for sheet in _SHEETS}
LINE_SHEETS: Mapping[str, Sheet] = {
    "whole-line-patch": Sheet(
        "whole-line-patch",
        "Slip around an over-stressed patch",
        "spontaneous edges without a slot: slip spreads smoothly to both sides of a patch whose "
        "ends advance, at a speed that friction decides",
        SLIPPING,
        note="Slip rate has a logarithm at the ends of the patch.  The answer is even in x.",
    )
}
"""Problems without a slot, which have no tolerance classes: our own codes do not take them."""
FRONT_SHEETS: Mapping[str, Sheet] = {
    "incident-sv": Sheet(
        "incident-sv",
        "An SV wave at an angle",
        "a load whose front moves: the wave meets the contact first, adds pressure and shear to "
        "it, and both are singular at the edge, which slips against the wave",
        (*SLIPPING, "pressure"),
        note="The wave has passed all of the contact by t = 0, so that the contact carries it from "
        "the outset. With the stress S = rho c_t v_0 of the wave, 0.3 or 3 MPa, and theta = -20 "
        "degrees, P_0 = -S sin(2 theta) and Q_0 = -S cos(2 theta).",
    )
}
"""Problems with a slot and a load with a moving front, without measured tolerance classes."""
_GOUGE, _ROCK = Material(1.0, 1.0, 0.25), Material(2.5, 1.2, 0.25)
"""A slow solid on a fast one, with the ratios of gouge and rock."""
PAIRS: Mapping[str, Pair] = {
    "pair-slip": Pair(_GOUGE, _ROCK, 0.2, Tractions(2.0, 0.0), Tractions(0.3, 1.0)),
    "pair-opening": Pair(_GOUGE, _ROCK, 0.3, Tractions(1.0, 0.0), Tractions(-1.0, 0.5)),
}
"""Problems of two different bodies, in units of the upper one."""
PAIR_SHEETS: Mapping[str, Sheet] = {
    "pair-slip": Sheet(
        "pair-slip",
        "Slip between two different bodies",
        "slip that changes the pressure it feels: both tractions of the contact are unknown at "
        "once, and their edge turns as it grows",
        (*SLIPPING, "pressure"),
        note="Friction is below the threshold above which waves grow along this interface however "
        "fine the grid, for slip of either sense, so that a delay is neither needed nor wanted.",
    ),
    "pair-opening": Sheet(
        "pair-opening",
        "Two different bodies that part and slip",
        "separation and slip that drive each other: the contact opens from its edge, and slips "
        "ahead of the opening under a pressure that falls to nothing there",
        (*SLIPPING, "pressure"),
        note="Where the contact is open, slip is the difference of the tangential displacements.",
    ),
}
"""Problems of two different bodies, whose classes are those of our finite elements too."""
RATED_SHEETS: Mapping[str, Sheet] = {**SHEETS, **PAIR_SHEETS}
"""Problems with tolerance classes."""
ALL_SHEETS: Mapping[str, Sheet] = {**SHEETS, **LINE_SHEETS, **FRONT_SHEETS, **PAIR_SHEETS}


def find_sheet(name: str) -> Sheet:
    """Sheet of a name.

    Raises
    ------
    SceneError
        If there is none.
    """
    if name in ALL_SHEETS:
        return ALL_SHEETS[name]
    close = difflib.get_close_matches(name, ALL_SHEETS, n=1, cutoff=0.5)
    hint = f"did you mean {close[0]}?" if close else f"choose {', '.join(ALL_SHEETS)}."
    raise SceneError(f"There is no benchmark called {name!r}; {hint}")


def in_si(scene: Scene) -> Scene:
    """A scene in units mu = rho = c_t = T = 1 in those of the SI, T one second.

    Raises
    ------
    SceneError
        If its solid is not of unit shear modulus and density, or its load moves over the slot.
    """
    if (scene.material.shear_modulus, scene.material.density) != (1.0, 1.0):
        raise SceneError("in_si: the scene must have a shear modulus and a density of 1.")
    law, load = scene.friction_law, scene.load
    if isinstance(load, MovingLoad):
        raise SceneError("in_si: moving loads are not known here; give tractions or a wave.")
    if isinstance(load, Tractions):
        load = _in_pascal(load)
    elif load.stress is not None:
        load = replace(load, stress=load.stress * SI_STRESS)
    else:
        load = replace(load, velocity=(load.velocity or 0.0) * SI_SCALES["slip_rate"])
    if isinstance(law, ViscousFriction):
        law = ViscousFriction(law.viscosity * SI_STRESS / SI_SCALES["slip_rate"])
    return replace(
        scene,
        material=Material(SI_SHEAR_MODULUS, SI_DENSITY, scene.material.poisson_ratio),
        base=_in_pascal(scene.base),
        load=load,
        friction_law=law,
        units=SI,
    )


def pair_in_si(pair: Pair) -> Pair:
    """Two bodies in units mu = rho = c_t = T = 1 of the upper one in those of the SI."""
    scene, lower = in_si(pair.alike), pair.lower
    body = Material(
        SI_SHEAR_MODULUS * lower.shear_modulus, SI_DENSITY * lower.density, lower.poisson_ratio
    )
    return pair_of(scene, body)


def line_in_si(line: WholeLine) -> WholeLine:
    """A whole line with a patch, in units mu = rho = c_t = T = 1, in those of the SI."""
    load = line.load
    assert isinstance(load, Patch)
    return replace(
        line,
        material=Material(SI_SHEAR_MODULUS, SI_DENSITY, line.material.poisson_ratio),
        base=_in_pascal(line.base),
        load=Patch(load.speed * SI_SCALES["x"], load.pressure * SI_STRESS, load.shear * SI_STRESS),
        units=SI,
    )


def _in_pascal(tractions: Tractions) -> Tractions:
    return Tractions(*(SI_STRESS * getattr(tractions, part.name) for part in fields(tractions)))
