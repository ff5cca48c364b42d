"""A problem for codes of dynamic contact: its scene, stations, and what is to be reported.

Each stands in two systems of units: mu = rho = c_t = T = 1, and `SI_MATERIAL` with tractions in
units of `SI_STRESS`, where T is one second.  Every answer in SI is the plain one times a number of
`SI_SCALES`.
"""

from __future__ import annotations

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
    find,
)
from semianalytic.dissimilar.described import pair_of
from semianalytic.methods import chosen
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import find_blocks
from semianalytic.scene.given.named import LINES, NAMED_PAIRS
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
        return find_blocks(self.name)[0]

    @property
    def is_pair(self) -> bool:
        """Whether the problem is of two different bodies; all units are those of the upper one."""
        return self.name in NAMED_PAIRS

    @property
    def is_line(self) -> bool:
        """Whether the problem is a line without a slot, and no scene."""
        return self.name in LINES

    @property
    def is_interface(self) -> bool:
        """Whether the problem is an interface (`InterfaceSheet`)."""
        return False

    @property
    def stations(self) -> tuple[float, ...]:
        """Positions of the stations [length]."""
        return STATIONS

    @property
    def times(self) -> tuple[float, ...]:
        """Times at which the answer is written [time]."""
        return TIMES

    @property
    def end_time(self) -> float:
        """T [time]."""
        return 1.0

    @property
    def extent(self) -> float:
        """Length over which cells are counted, here c_t T [length]."""
        return 1.0

    @property
    def crossing(self) -> float:
        """Time in which shear waves cross `extent` [time]."""
        return 1.0

    @property
    def problem(self) -> Scene | Pair | WholeLine:
        """The scene, the two bodies or the whole line, in units mu = rho = c_t = 1."""
        if self.is_pair:
            return find(self.name)
        if not self.is_line:
            return self.scene
        line = find(self.name)
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
        return not self.is_line and chosen(self.scene).name == "space-time"


THRESHOLD = 0.002
"""Slip rate over the largest load over rho c_t, or pressure over that of the base, at which slip or
opening counts as begun."""


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
