"""Where, when, how fast and which way a frictional interface slips after a sudden load.

``import slipfront as sf`` gives every public name of the package.  Scenes and semi-analytic solvers
come from `semianalytic`, finite elements from `fem`, which needs the extra ``slipfront[fem]``, the
judge of other codes' results from `compare.validation`, many scenes at once from
`slipfront.surveys`, readers of gauges from `slipfront.fits`; closed forms
are in `sf.reference`, thresholds between regimes in `sf.regimes`.  A module is imported when one of
its names is first used, so that the command line starts at once.
"""

import logging
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

_NAMES = {
    "semianalytic": (
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
        "InterfaceHistory",
        "LineSolution",
        "Interface",
        "InterfaceFile",
        "InterfaceHistory",
        "InterfaceLaw",
        "InterfaceLoad",
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
        "find_line",
        "find_material",
        "find_pair",
        "critical_wavelength",
        "find_interface",
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
    ),
    "fem": (
        "BACKWARD",
        "Cost",
        "EnergyHistory",
        "FORWARD",
        "Model",
        "OPEN",
        "Opening",
        "STICK",
        "Settings",
        "Simulation",
        "SlotHistory",
        "cost",
        "load_simulation",
        "opening_sentence",
        "prepare",
        "simulate",
        "with_companions",
    ),
    "compare.interfaces": ("InterfaceJudgement", "compare_interface"),
    "compare.validation": (
        "Conventions",
        "Validation",
        "validate",
    ),
    "slipfront.fits": ("read_gauges",),
    "slipfront.surveys": ("survey",),
}
"""All public names by the module that they come from."""

_ALL = ("semianalytic", "fem", "meshes", "compare")
_NEEDED = {"semianalytic": ("semianalytic",), "fem": ("semianalytic", "fem", "meshes")}
"""Packages beside this one, and those that a module imports where it does without the others."""

_MODULES = {"reference": "semianalytic.reference", "regimes": "semianalytic.regimes"}
"""Modules with names that only some users need: closed forms, and thresholds between regimes."""

_PLACES = {name: module for module, names in _NAMES.items() for name in names}

__all__ = ["__version__"]
__all__ += _PLACES
__all__ += _MODULES

if TYPE_CHECKING:  # which would let a misspelt name pass behind __getattr__
    from compare.validation import *
    from fem import *
    from semianalytic import *
    from semianalytic import reference as reference
    from semianalytic import regimes as regimes
    from slipfront.fits import *
    from slipfront.surveys import *

    __version__: str
else:

    def __getattr__(name: str) -> Any:
        """A public name, from the module that defines it.

        Raises
        ------
        MissingLibraryError
            If a package that the name needs is not installed.
        ImportError
            If a file of the user hides a package of slipfront.
        """
        if name == "__version__":
            from importlib.metadata import version

            value = version("slipfront")
        elif name in _PLACES:
            if _PLACES[name] not in sys.modules:
                _check_that_none_is_hidden(_NEEDED.get(_PLACES[name], _ALL))
            value = getattr(import_module(_PLACES[name]), name)
        elif name in _MODULES:
            _check_that_none_is_hidden(_NEEDED["semianalytic"])
            value = import_module(_MODULES[name])
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = value
        return value


def _check_that_none_is_hidden(packages: tuple[str, ...]) -> None:
    """Raise a sentence that names the user's file, if it would be imported as a package of ours.

    Python looks in the folder of a script first, so that a ``fem.py`` beside it becomes `fem`.
    """
    house = Path(__file__).parents[1]
    for name in packages:
        spec = find_spec(name)
        if spec is None or spec.origin is None or Path(spec.origin).parent != house / name:
            raise ImportError(
                f"{spec and (spec.origin or spec.name)} hides the package {name!r} of slipfront; "
                "rename or move it."
            )


def __dir__() -> list[str]:
    return sorted(__all__)
