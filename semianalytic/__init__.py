"""Slip on a frictional interface after a sudden load: exact where self-similar, else marched."""

from semianalytic.fitting import Fit, Gauge, fit
from semianalytic.prediction import predict
from semianalytic.results.answer import Answer, OpenInterval, SlipInterval
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import (
    ComputationError,
    DataFileError,
    MissingLibraryError,
    SceneError,
    SlipfrontError,
    TensionError,
)
from semianalytic.scene.friction import (
    CoulombFriction,
    FrictionLaw,
    RateWeakening,
    SlipWeakening,
    ViscousFriction,
)
from semianalytic.scene.loads import Harmonic, LoadHistory, Pulse, Ramp, Step, Tabulated
from semianalytic.scene.named import find_scene
from semianalytic.scene.scene import Material, Scene, Tractions
from semianalytic.selfsimilar.derivative import Derivative, OpenDerivative, ZoneDerivative
from semianalytic.selfsimilar.motion import OpenZone, SlipZone
from semianalytic.selfsimilar.solution import Solution, Statistics
from semianalytic.selfsimilar.solver import solve
from semianalytic.spacetime.march import march, march_on
from semianalytic.spacetime.marched import Marched
from semianalytic.sweeps.sweep import Sweep, sweep

__all__ = [
    "Answer",
    "ComputationError",
    "CoulombFriction",
    "DataFileError",
    "Derivative",
    "Fit",
    "FrictionLaw",
    "Gauge",
    "Harmonic",
    "InterfaceHistory",
    "LoadHistory",
    "Marched",
    "Material",
    "MissingLibraryError",
    "OpenDerivative",
    "OpenInterval",
    "OpenZone",
    "Pulse",
    "Ramp",
    "RateWeakening",
    "Scene",
    "SceneError",
    "SlipInterval",
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
    "ViscousFriction",
    "ZoneDerivative",
    "find_scene",
    "fit",
    "march",
    "march_on",
    "predict",
    "solve",
    "sweep",
]
