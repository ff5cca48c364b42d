"""Units of numbers: SI units if a scene declares them, otherwise the dimensions themselves.

Dimensions are written as in the docstrings: "length / time", "stress sqrt(length)".
"""

from __future__ import annotations

from collections.abc import Mapping

SI = "SI"

_SI_UNITS: Mapping[str, str] = {
    "length": "m",
    "length^2": "m^2",
    "time": "s",
    "1 / time": "Hz",
    "length / time": "m/s",
    "mass / length^3": "kg/m^3",
    "stress": "Pa",
    "stress time / length": "Pa s/m",
    "stress sqrt(length)": "Pa sqrt(m)",
    "stress length": "J/m^2",
    "stress length^2": "J/m",
}


def unit(dimension: str, units: str = "") -> str:
    """Return the unit of a dimension in a system of units.

    Parameters
    ----------
    dimension : str
        The dimension, such as "length / time"; other words, such as "1" or "c_t", are returned as
        they are.
    units : str
        Units of the scene: "SI", or "" for any consistent set, where the dimension itself,
        "length/time", stands for the unit.
    """
    named = _SI_UNITS.get(dimension) if units == SI else None
    return named or dimension.replace(" / ", "/")
