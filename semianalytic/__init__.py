"""Slip on a frictional interface after a sudden load: the semi-analytic Wiener-Hopf solver."""

from semianalytic.errors import (
    ComputationError,
    DataFileError,
    MissingLibraryError,
    SceneError,
    SlipfrontError,
    TensionError,
)
from semianalytic.friction import CoulombFriction, RateWeakening, SlipWeakening
from semianalytic.history import InterfaceHistory
from semianalytic.loads import Harmonic, History, Pulse, Ramp, Step, Tabulated
from semianalytic.marched import Marched
from semianalytic.predict import slip_history
from semianalytic.scene import Material, Scene, Tractions
from semianalytic.solution import SlipZone, Solution, Statistics
from semianalytic.solver import solve
from semianalytic.spacetime import march, march_on
from semianalytic.sweep import Sweep, sweep

__all__ = [
    "ComputationError",
    "CoulombFriction",
    "DataFileError",
    "Harmonic",
    "History",
    "InterfaceHistory",
    "Marched",
    "Material",
    "MissingLibraryError",
    "Pulse",
    "Ramp",
    "RateWeakening",
    "Scene",
    "SceneError",
    "SlipWeakening",
    "SlipZone",
    "SlipfrontError",
    "Solution",
    "Statistics",
    "Step",
    "Sweep",
    "Tabulated",
    "TensionError",
    "Tractions",
    "march",
    "march_on",
    "slip_history",
    "solve",
    "sweep",
]
