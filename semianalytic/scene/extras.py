"""Optional packages: which extra installs each, and the sentence that asks for a missing one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from semianalytic.scene.errors import MissingLibraryError

FEM = ("skfem", "meshio", "gmsh", "h5py", "platformdirs")
"""Modules that the finite-element model imports."""
HDF5 = ("h5py",)
"""Modules that saved results need."""
PLOT = ("matplotlib",)
"""Modules that figures need."""
EXPLORE = ("bokeh",)
"""Modules that the page in the browser needs, besides those of figures."""
XARRAY = ("xarray", "h5netcdf", "h5py")
"""Modules that datasets and their files need."""
CLUSTER = ("dask", "distributed")
"""Modules that runs on several machines need."""
UNITS = ("pint",)
"""Modules that parse the names of units in files."""

_HOUSE = Path(__file__).parents[2]
"""Folder that the packages are in: of the checkout, or that of installed packages."""
_DISTRIBUTIONS = {"skfem": "scikit-fem"}
_EXTRAS = {
    "fem": FEM,
    "plot": PLOT,
    "explore": EXPLORE,
    "xarray": XARRAY,
    "cluster": CLUSTER,
    "units": UNITS,
}
"""Modules of each extra.  A module of two extras is asked for by the first of them, unless another
one that is missing calls for the second."""


def require(what: str, *modules: str) -> None:
    """Make sure that modules are installed, before anything is computed.

    Raises MissingLibraryError if one is missing: `what`, the part of the package that needs them,
    and the command that installs all.
    """
    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        raise MissingLibraryError(_sentence(what, missing))


@contextmanager
def needing(what: str) -> Iterator[None]:
    """Make imports in this context raise MissingLibraryError for packages of an extra.

    The message begins with `what`, the part of the package that needs them.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        # Only what an extra brings is explained; any other missing module is a fault of the code
        # that imports it.
        module = (error.name or "").split(".")[0]
        if not any(module in modules for modules in _EXTRAS.values()):
            raise
        raise MissingLibraryError(_sentence(what, [module])) from error


def _sentence(what: str, missing: list[str]) -> str:
    """Say in one sentence which packages are missing and how to install them."""
    names = [_DISTRIBUTIONS.get(module, module) for module in missing]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    extras = ",".join(_extras_of(missing))
    are = "is" if len(names) == 1 else "are"
    return f"{what} needs {listed}, which {are} not installed; run {how_to_install(extras)}."


def how_to_install(extras: str) -> str:
    """Return the command that adds extras to this installation.

    An installed wheel is extended by its name, also if it came from a file.  A checkout has to be
    installed from its folder, because no index needs to have its version.  Names of extras are
    separated by commas.

    Examples
    --------
    >>> how_to_install("xarray")  # from a checkout, in which the examples run
    "`pip install '.[xarray]'` in the folder of slipfront"
    """
    if (_HOUSE / "pyproject.toml").is_file():
        return f"`pip install '.[{extras}]'` in the folder of slipfront"
    return f"`pip install 'slipfront[{extras}]'`"


def _extras_of(missing: list[str]) -> list[str]:
    """Return the one extra that brings all missing modules, or several."""
    # One extra for all, where there is one, is a shorter command than several.
    for extra, modules in _EXTRAS.items():
        if set(missing) <= set(modules):
            return [extra]
    first = (
        next(extra for extra, modules in _EXTRAS.items() if module in modules) for module in missing
    )
    return list(dict.fromkeys(first))
