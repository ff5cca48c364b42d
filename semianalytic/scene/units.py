"""Units of numbers: SI units if a scene declares them, otherwise the dimensions themselves.

Dimensions are written as in the docstrings: "length / time", "stress sqrt(length)".
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping

from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError

SI = "SI"

_SI_UNITS: Mapping[str, str] = {
    "length": "m",
    "length^2": "m^2",
    "time": "s",
    "1 / time": "Hz",
    "length / time": "m/s",
    "length / time^2": "m/s^2",
    "length / time^3": "m/s^3",
    "mass / length^3": "kg/m^3",
    "stress": "Pa",
    "stress / time": "Pa/s",
    "stress / time^2": "Pa/s^2",
    "stress length / time": "N/(m s)",
    "stress time / length": "Pa s/m",
    "stress sqrt(length)": "Pa sqrt(m)",
    "stress length": "J/m^2",
    "stress length^2": "J/m",
    "angle": "degree",
}
_PREFIXES: Mapping[str, float] = {
    **{"": 1.0, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3},
    **{"c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9},
}
_SIZES: Mapping[str, Mapping[str, float]] = {
    "length": {f"{prefix}m": size for prefix, size in _PREFIXES.items() if size < 1e6},
    "time": {f"{prefix}s": size for prefix, size in _PREFIXES.items() if size <= 1},
    "stress": {f"{prefix}Pa": size for prefix, size in _PREFIXES.items() if size >= 1},
    "1 / time": {f"{prefix}Hz": size for prefix, size in _PREFIXES.items() if size >= 1},
    "mass / length^3": {"kg/m^3": 1.0, "kg/m3": 1.0, "g/cm^3": 1e3, "g/cm3": 1e3},
    "length / time": {f"{prefix}m/s": size for prefix, size in _PREFIXES.items() if size < 1e6},
    "stress time / length": {"Pa s/m": 1.0, "kPa s/m": 1e3, "MPa s/m": 1e6, "GPa s/m": 1e9},
    "stress length": {"J/m^2": 1.0, "J/m2": 1.0, "N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3},
    "angle": {**dict.fromkeys(("deg", "degree", "degrees", "°"), 1.0), "rad": math.degrees(1.0)},
    "1": {"": 1.0, "1": 1.0, "%": 1e-2},
}
"""Sizes of the units that need no library, by dimension."""
_SHOWN: Mapping[str, str] = {
    "length": "m, cm, mm, um or km",
    "time": "s, ms, us or ns",
    "stress": "Pa, kPa, MPa or GPa",
    "1 / time": "Hz, kHz or MHz",
    "mass / length^3": "kg/m^3 or g/cm^3",
    "length / time": "m/s, mm/s or km/s",
    "stress time / length": "Pa s/m or MPa s/m",
    "stress length": "N/m, kN/m or N/mm",
    "angle": "deg or rad",
    "1": "%",
}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*\Z", re.DOTALL)
_NOT_FINITE = frozenset({"nan", "inf", "infinity"})

PARAMETERS: Mapping[str, str] = {
    "shear_modulus": "stress",
    "density": "mass / length^3",
    "poisson_ratio": "1",
    "friction": "1",
    "pressure": "stress",
    "shear": "stress",
    "rise_time": "time",
    "duration": "time",
    "frequency": "1 / time",
    "t": "time",
    "value_at_t": "1",
    "viscosity": "stress time / length",
    **dict.fromkeys(("static", "dynamic", "reduction", "a", "b", "f0", "weakened"), "1"),
    "cohesion": "stress",
    **dict.fromkeys(("delay", "theta", "arrival", "fall"), "time"),
    **dict.fromkeys(("distance", "delay_slip", "period", "held", "at"), "length"),
    **dict.fromkeys(("rate", "plate_rate", "v0", "weakening_rate"), "length / time"),
    "angle": "angle",
    "velocity": "length / time",
    "stress": "stress",
    "speed": "length / time",
    "wave_velocity": "length / time",
    "wave_stress": "stress",
}
"""Dimensions of the parameters of a scene and of its parts, laws among them, by name."""
ARGUMENTS: Mapping[str, str] = {
    **{"x": "length", "y": "length", "t": "time"},
    **{"inner": "length", "outer": "length"},
    **{"end_time": "time", "latest": "time", "length": "length"},
}
"""Dimensions of what an answer is asked for, by the name of the argument."""


class InSI(float):
    """A number that was given with a unit, in that of the SI.

    Attributes
    ----------
    name : str
        Name of the unit that it was given in.
    size : float
        That unit in the one of the SI.

    Examples
    --------
    >>> from semianalytic.scene.units import measure
    >>> length = measure("5cm", "length")
    >>> length, length.name, length.size
    (0.05, 'cm', 0.01)
    """

    name: str
    size: float

    def __new__(cls, number: float, name: str, size: float) -> InSI:
        """Make the number of so many units of a size and name."""
        # 15 digits: 30 us are 3e-05 s and no digit more
        value = super().__new__(cls, f"{number * size:.15g}")
        value.name, value.size = name, size
        return value


def unit(dimension: str, units: str = "") -> str:
    """Return the unit of a dimension in a system of units.

    Words that are no dimension, such as "1" or "c_t", are returned as they are.  Units of the scene
    are "SI", or "" for any consistent set, where the dimension itself, "length/time", stands for
    the unit.
    """
    # Without a system of units the dimension stands for the unit: length/time.
    named = _SI_UNITS.get(dimension) if units == SI else None
    return named or dimension.replace(" / ", "/")


def with_unit(value: float, dimension: str, units: str, digits: int = 4) -> str:
    """Write a value to some digits, with its unit if the scene is in a system of units."""
    return f"{value:.{digits}g} {unit(dimension, units)}" if units else f"{value:.{digits}g}"


def size_of(name: str, dimension: str) -> float | None:
    """Return the factor from a unit with a common prefix to that of the SI; None for others."""
    return _SIZES.get(dimension, {}).get(name.strip())


def units_shown(dimension: str) -> str:
    """Return the names of the units of a dimension that need no library, for messages."""
    return _SHOWN.get(dimension, unit(dimension, SI))


def measure(text: str, dimension: str, size: Callable[[str, str], float | None] = size_of) -> float:
    """Return the number that a text such as "5cm", "30 us", "80GPa" or "0.3" stands for.

    A unit may follow the number, which has to meet the dimension; `size` returns the size of a
    unit's name and a dimension in the SI, None if it is not known.  It is an `InSI` if there is a
    unit, else a plain number.  Raises SceneError if it is no finite number, or the unit is unknown
    or of another dimension; the message lists units.
    """
    # A number, then whatever follows it as the unit: 5cm, 30 us, 1e-3 kg/m3.
    match = _NUMBER.match(text)
    name = match[2] if match else ""
    factor = size(name, dimension) if name else None
    number = float(match[1]) if match else math.nan
    if math.isinf(number) or text.strip().lstrip("+-").lower() in _NOT_FINITE:
        raise SceneError(f"must be a finite number, got {shown(text)}.")
    if match is None or (name and factor is None):
        raise SceneError(
            f"must be a number alone or in {units_shown(dimension)}, got {shown(text)}."
        )
    return number if factor is None else InSI(number, name, factor)
