"""Sampled quantities as xarray datasets, each with its name and unit."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from numpy.typing import ArrayLike

from semianalytic.scene.extras import needing
from semianalytic.scene.units import SI, unit

QUANTITIES: Mapping[str, tuple[str, str]] = {
    "x": ("length", "position along the contact"),
    "t": ("time", "time since the load"),
    "slip": ("length", "relative slip, upper minus lower side"),
    "slip_rate": ("length / time", "relative slip rate, upper minus lower side"),
    "shear_traction": ("stress", "shear traction, base included"),
    "pressure": ("stress", "contact pressure, base included, compression positive, 0 on slots"),
    "gap": ("length", "how far the contact is open, on slots the change of their width"),
    "state": ("", "state of friction"),
    "felt_pressure": ("stress", "pressure that friction follows, 0 on slots"),
    "max_slip": ("length", "largest |slip| on the contact"),
    "accumulated_slip": ("length^2", "integral of accumulated |slip| over the contact"),
    "frictional_work": ("stress length^2", "energy turned to heat per unit depth"),
}
"""Dimension and meaning of what answers hold."""


def attributes(dimension: str, meaning: str, units: str) -> dict[str, str]:
    """Return the attributes of a variable: `units`, `dimension` and `long_name`.

    Units are those of the SI if the scene is in them.  Those of any other consistent set have no
    name that pint or the CF conventions know: they are "1", and the dimension says what is meant.
    """
    named = unit(dimension, SI) if units == SI else "1"
    return {"units": named if dimension else "", "dimension": dimension, "long_name": meaning}


def dataset(x: ArrayLike, t: ArrayLike, values: Mapping[str, Any], units: str = "") -> Any:
    """Return quantities at positions x (n,) and times t (m,) as an `xarray.Dataset` over t and x.

    The values are fields (m, n) and totals of the contact (m,).  Every variable has `attributes`;
    the dataset names the program and its version as its source.  Raises MissingLibraryError without
    xarray.
    """
    with needing("to_xarray"):
        import xarray

    data = xarray.Dataset(
        # Totals have one axis, which is time; fields have both.
        {name: (("t", "x")[: value.ndim], value) for name, value in values.items()},
        coords={"x": x, "t": t},
    )
    for name in ("x", "t", *values):
        data[name].attrs |= attributes(*QUANTITIES[name], units)
    data.attrs |= {"Conventions": "CF-1.11", "source": f"slipfront {version('slipfront')}"}
    return data
