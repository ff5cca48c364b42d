"""Where, when, how fast and which way a frictional interface slips after a sudden load.

``import slipfront as sf`` gives every public name of the package.  Scenes and semi-analytic solvers
come from `semianalytic`, finite elements from `fem`, which needs the extra ``slipfront[fem]``, the
judge of other codes' results from `compare.validation`, many scenes at once from
`slipfront.surveys`, readers of gauges from `slipfront.fits`; closed forms are in `sf.reference`,
thresholds between regimes in `sf.regimes`.  A module is imported when one of its names is first
used, so that the command line starts at once.
"""

import logging
from typing import Any

from slipfront.hidden import hiding

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked


def __getattr__(name: str) -> Any:
    """A public name, from the module that defines it.

    MissingLibraryError if a package that the name needs is not installed, ImportError if a file of
    the user hides a package of slipfront.
    """
    if name.startswith("__") and name not in ("__all__", "__version__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name == "__version__":
        from importlib.metadata import version

        return version("slipfront")
    if hidden := hiding():
        raise ImportError(hidden)
    from semianalytic.names import attached

    names, get = attached(__name__)
    return [*names, "__version__"] if name == "__all__" else get(name)


def __dir__() -> list[str]:
    return sorted(__getattr__("__all__"))
