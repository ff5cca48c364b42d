"""Packages that an installation may lack: the extra that brings each, and a sentence for it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from semianalytic.scene.errors import MissingLibraryError

FEM = ("skfem", "meshio", "gmsh", "h5py", "platformdirs")
"""What the finite-element model imports."""
HDF5 = ("h5py",)
"""What saved results import."""
PLOT = ("matplotlib", "PIL")
"""What figures import."""
EXPLORE = ("bokeh",)
"""What the page in the browser imports, beside figures."""
XARRAY = ("xarray", "h5netcdf", "h5py", "zarr")
"""What datasets, and their files, import."""
CLUSTER = ("dask", "distributed")
"""What runs on several machines imports."""
BAYES = ("emcee",)
"""What samples of posteriors import."""
UNITS = ("pint",)
"""Modules that read the names of units in files."""

_DISTRIBUTIONS = {"skfem": "scikit-fem", "PIL": "pillow"}
_EXTRAS = {
    "fem": FEM,
    "plot": PLOT,
    "explore": EXPLORE,
    "xarray": XARRAY,
    "cluster": CLUSTER,
    "bayes": BAYES,
    "units": UNITS,
}
"""What each extra brings; what two bring is asked for by the first, unless more is missing."""


def require(what: str, *modules: str) -> None:
    """Make sure that modules are installed, before anything is computed.

    Parameters
    ----------
    what : str
        What needs them, for the message.
    *modules : str
        As they are imported.

    Raises
    ------
    MissingLibraryError
        If one is not there; the message is one sentence with the command that installs all.
    """
    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        raise MissingLibraryError(_sentence(what, missing))


@contextmanager
def needing(what: str) -> Iterator[None]:
    """Imports in this context raise MissingLibraryError for packages that an extra would bring.

    Parameters
    ----------
    what : str
        What needs them, for the message.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        module = (error.name or "").split(".")[0]
        if not any(module in modules for modules in _EXTRAS.values()):
            raise
        raise MissingLibraryError(_sentence(what, [module])) from error


def _sentence(what: str, missing: list[str]) -> str:
    """What is missing and how to install it, in one sentence."""
    names = [_DISTRIBUTIONS.get(module, module) for module in missing]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    extras = ",".join(_extras_of(missing))
    return (
        f"{what} needs {listed}, which {'is' if len(names) == 1 else 'are'} not installed; "
        f"run `pip install '.[{extras}]'` in the folder of slipfront."
    )


def _extras_of(missing: list[str]) -> list[str]:
    """One extra that brings all that is missing, or several."""
    for extra, modules in _EXTRAS.items():
        if set(missing) <= set(modules):
            return [extra]
    first = (
        next(extra for extra, modules in _EXTRAS.items() if module in modules) for module in missing
    )
    return list(dict.fromkeys(first))
