"""Slip on a frictional interface after a sudden load: exact where self-similar, else marched.

The modules that `solve` needs are imported at once, the others when one of their names is first
used.
"""

import logging
from importlib import import_module
from typing import TYPE_CHECKING, Any

from semianalytic.results.answer import Answer, OpenInterval, SlipInterval
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.reading import Measured, Reading
from semianalytic.scene.errors import (
    ComputationError,
    DataFileError,
    MissingLibraryError,
    PluginError,
    SceneError,
    SlipfrontError,
    TensionError,
)
from semianalytic.scene.friction import (
    CoulombFriction,
    FrictionLaw,
    RateFriction,
    RateWeakening,
    SlipWeakening,
    ViscousFriction,
)
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.solids import find_material
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.loads import Harmonic, LoadHistory, Pulse, Ramp, Step
from semianalytic.scene.scene import Material, Scene, Tractions
from semianalytic.scene.tabulated import Tabulated
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve
from semianalytic.selfsimilar.statistics import Statistics
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

__all__ = [
    "Adhesion",
    "Answer",
    "ComputationError",
    "Contact",
    "Coulomb",
    "CoulombFriction",
    "DataFileError",
    "Derivative",
    "EdgeReading",
    "Fit",
    "ForcedFront",
    "FrictionLaw",
    "FrontLoad",
    "Gauge",
    "GrowingSlot",
    "GrowingSolution",
    "HalfLine",
    "Harmonic",
    "IncidentWave",
    "Interface",
    "InterfaceFile",
    "InterfaceHistory",
    "InterfaceLaw",
    "InterfaceLoad",
    "LineSolution",
    "LoadHistory",
    "LogNormal",
    "Marched",
    "Material",
    "Measured",
    "MissingLibraryError",
    "MovingLoad",
    "Normal",
    "OpenDerivative",
    "OpenInterval",
    "OpenZone",
    "Pair",
    "PairDerivative",
    "PairSolution",
    "PairStatistics",
    "Patch",
    "PluginError",
    "PointForce",
    "Pulse",
    "Ramp",
    "RateAndState",
    "RateDependent",
    "RateFriction",
    "RateWeakening",
    "Reading",
    "Run",
    "Scene",
    "SceneError",
    "Setup",
    "SlidingStability",
    "SlidingWave",
    "SlipDependent",
    "SlipInterval",
    "SlipWeakening",
    "SlipZone",
    "SlipfrontError",
    "Solution",
    "Statistics",
    "Step",
    "Sweep",
    "Table",
    "Tabulated",
    "TensionError",
    "Tractions",
    "Uniform",
    "ViscousFriction",
    "WholeLine",
    "ZoneDerivative",
    "critical_wavelength",
    "find_interface",
    "find_line",
    "find_material",
    "find_pair",
    "find_scene",
    "fit",
    "fringe_order",
    "fringes",
    "march",
    "march_on",
    "predict",
    "run",
    "sliding_stability",
    "solve",
    "solve_growing",
    "solve_line",
    "solve_pair",
    "strain",
    "supershear_strength",
    "sweep",
]

_LATER = {
    "semianalytic.dissimilar.described": ("find_pair",),
    "semianalytic.dissimilar.grid_edge": ("EdgeReading",),
    "semianalytic.dissimilar.pair": ("Pair",),
    "semianalytic.dissimilar.stability": (
        "SlidingStability",
        "SlidingWave",
        "sliding_stability",
    ),
    "semianalytic.dissimilar_slot.derivative": ("PairDerivative",),
    "semianalytic.dissimilar_slot.solution": ("PairSolution", "PairStatistics"),
    "semianalytic.dissimilar_slot.solver": ("solve_pair",),
    "semianalytic.interface.contact": ("Adhesion", "Contact"),
    "semianalytic.interface.fields": ("Table",),
    "semianalytic.interface.interface": ("Interface",),
    "semianalytic.interface.loads": ("FrontLoad", "InterfaceLoad"),
    "semianalytic.interface.coulomb": ("Coulomb",),
    "semianalytic.interface.law": ("InterfaceLaw",),
    "semianalytic.interface.rate_and_state": ("RateAndState",),
    "semianalytic.interface.weakening": ("ForcedFront", "RateDependent", "SlipDependent"),
    "semianalytic.interface.files": ("InterfaceFile",),
    "semianalytic.interface.named": ("find_interface",),
    "semianalytic.engine.result": ("Run",),
    "semianalytic.engine.run": ("run",),
    "semianalytic.reference.ruptures": ("critical_wavelength", "supershear_strength"),
    "semianalytic.field.derived": ("fringe_order", "fringes", "strain"),
    "semianalytic.inversion.fitted": ("Fit",),
    "semianalytic.inversion.fitting": ("fit",),
    "semianalytic.inversion.gauges": ("Gauge",),
    "semianalytic.inversion.priors": ("LogNormal", "Normal", "Uniform"),
    "semianalytic.inversion.unknowns": ("Setup",),
    "semianalytic.prediction": ("predict",),
    "semianalytic.selfsimilar.derivatives.derivative": (
        "Derivative",
        "OpenDerivative",
        "ZoneDerivative",
    ),
    "semianalytic.spacetime.march": ("march", "march_on"),
    "semianalytic.spacetime.marched": ("Marched",),
    "semianalytic.sweeps.sweep": ("Sweep", "sweep"),
    "semianalytic.whole_line.growing": ("GrowingSlot", "GrowingSolution", "solve_growing"),
    "semianalytic.whole_line.line": ("HalfLine", "Patch", "PointForce", "WholeLine"),
    "semianalytic.whole_line.named": ("find_line",),
    "semianalytic.whole_line.solution": ("LineSolution",),
    "semianalytic.whole_line.solver": ("solve_line",),
}
"""Modules that a plain solution does not need, with the public names they define."""

if TYPE_CHECKING:  # which would let a misspelt name pass behind __getattr__
    from semianalytic.dissimilar.described import find_pair
    from semianalytic.dissimilar.grid_edge import EdgeReading
    from semianalytic.dissimilar.pair import Pair
    from semianalytic.dissimilar.stability import (
        SlidingStability,
        SlidingWave,
        sliding_stability,
    )
    from semianalytic.dissimilar_slot.derivative import PairDerivative
    from semianalytic.dissimilar_slot.solution import PairSolution, PairStatistics
    from semianalytic.dissimilar_slot.solver import solve_pair
    from semianalytic.engine.result import Run
    from semianalytic.engine.run import run
    from semianalytic.field.derived import fringe_order, fringes, strain
    from semianalytic.interface.contact import Adhesion, Contact
    from semianalytic.interface.coulomb import Coulomb
    from semianalytic.interface.fields import Table
    from semianalytic.interface.files import InterfaceFile
    from semianalytic.interface.interface import Interface
    from semianalytic.interface.law import InterfaceLaw
    from semianalytic.interface.loads import FrontLoad, InterfaceLoad
    from semianalytic.interface.named import find_interface
    from semianalytic.interface.rate_and_state import RateAndState
    from semianalytic.interface.weakening import ForcedFront, RateDependent, SlipDependent
    from semianalytic.inversion.fitted import Fit
    from semianalytic.inversion.fitting import fit
    from semianalytic.inversion.gauges import Gauge
    from semianalytic.inversion.priors import LogNormal, Normal, Uniform
    from semianalytic.inversion.unknowns import Setup
    from semianalytic.prediction import predict
    from semianalytic.reference.ruptures import critical_wavelength, supershear_strength
    from semianalytic.selfsimilar.derivatives.derivative import (
        Derivative,
        OpenDerivative,
        ZoneDerivative,
    )
    from semianalytic.spacetime.march import march, march_on
    from semianalytic.spacetime.marched import Marched
    from semianalytic.sweeps.sweep import Sweep, sweep
    from semianalytic.whole_line.growing import GrowingSlot, GrowingSolution, solve_growing
    from semianalytic.whole_line.line import HalfLine, Patch, PointForce, WholeLine
    from semianalytic.whole_line.named import find_line
    from semianalytic.whole_line.solution import LineSolution
    from semianalytic.whole_line.solver import solve_line
else:

    def __getattr__(name: str) -> Any:
        """Import the module that defines a public name, when the name is first used."""
        for module, names in _LATER.items():
            if name in names:
                globals()[name] = getattr(import_module(module), name)
                return globals()[name]
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
