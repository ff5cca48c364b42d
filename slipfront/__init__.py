"""Where, when, how fast and which way a frictional interface slips after a sudden load.

``import slipfront as sf``: everything under the name it is installed by.  Nothing is made here:
scenes and semi-analytic solvers come from `semianalytic`, finite elements from `fem`, which needs
the extra ``slipfront[fem]``, the judge of other codes' results from `compare.validation`, many
scenes at once from `slipfront.surveys`, readers of gauges and samples of posteriors from
`slipfront.fits`.  What a plain solution does without is imported when one of its names is first
used.
"""

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import semianalytic

__version__ = version("slipfront")

__all__ = [
    "BACKWARD",
    "FORWARD",
    "OPEN",
    "STICK",
    "Conventions",
    "Cost",
    "EnergyHistory",
    "Model",
    "Opening",
    "Posterior",
    "Settings",
    "Simulation",
    "SlotHistory",
    "Validation",
    "__version__",
    "cost",
    "load_simulation",
    "opening_sentence",
    "posterior",
    "prepare",
    "read_gauges",
    "simulate",
    "survey",
    "validate",
    "with_companions",
]
__all__ += semianalytic.__all__
_VALIDATION = ("Conventions", "Validation", "validate")
_INVERSION = ("Posterior", "posterior", "read_gauges")


if TYPE_CHECKING:  # which would let a misspelt name pass behind __getattr__
    from slipfront.fits import Posterior, posterior, read_gauges
    from slipfront.surveys import survey
    from compare.validation import Conventions, Validation, validate
    from fem import (
        BACKWARD,
        FORWARD,
        OPEN,
        STICK,
        Cost,
        EnergyHistory,
        Model,
        Opening,
        Settings,
        Simulation,
        SlotHistory,
        cost,
        load_simulation,
        opening_sentence,
        prepare,
        simulate,
        with_companions,
    )
    from semianalytic import *
else:

    def __getattr__(name: str) -> Any:
        """A name of `semianalytic`, `compare.validation`, `.surveys` or `.inversion`, or `fem`.

        Raises
        ------
        MissingLibraryError
            If a package that the finite elements need is not installed.
        """
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        if name in semianalytic.__all__:
            return getattr(semianalytic, name)
        if name in _INVERSION:
            from compare import inversion

            return getattr(inversion, name)
        if name in _VALIDATION:
            from compare import validation

            return getattr(validation, name)
        if name == "survey":
            from slipfront.surveys import survey

            return survey
        import fem

        return getattr(fem, name)


def __dir__() -> list[str]:
    return sorted(__all__)
