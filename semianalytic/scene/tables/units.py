"""Units that files name, in those of the SI; pint knows what the less common ones are called."""

from __future__ import annotations

import re
import tokenize
from collections.abc import Collection, Mapping
from functools import cache
from typing import TYPE_CHECKING

from semianalytic.scene.extras import needing
from semianalytic.scene.units import SI, size_of, unit

if TYPE_CHECKING:
    from pint import UnitRegistry

DIMENSIONS: Mapping[str, str] = {
    "x": "length",
    "t": "time",
    "slip": "length",
    "slip_rate": "length / time",
    "shear_traction": "stress",
    "pressure": "stress",
}
"""Dimensions of the columns that a file may have."""
EXAMPLES: Mapping[str, str] = {
    "length": "mm",
    "time": "µs",
    "length / time": "mm/s",
    "stress": "MPa",
    "1": "µε",
}
"""A unit of each dimension, for messages."""
NO_UNIT = ("", "-", "1", "nd", "dimensionless", "none")
"""Words in the place of a unit where numbers have none, in lower case."""
LONGEST = 32
"""Characters of the name of a unit."""

_BASE = {
    **{"length": "m", "time": "s", "length / time": "m/s", "stress": "Pa", "1 / time": "Hz"},
    **{"mass / length^3": "kg/m**3", "stress time / length": "Pa*s/m"},
    **{"stress length": "N/m", "angle": "degree", "1": ""},
}
_PARTS: Mapping[str, float] = {
    **{"ε": 1.0, "strain": 1.0, "1e-3": 1e-3, "mstrain": 1e-3, "1e-6": 1e-6, "microstrain": 1e-6},
    **{prefix + name: 1e-6 for prefix in "uµμ" for name in ("strain", "ε", "e")},
}
"""Parts of one that instruments name."""
_CASES = {name.lower(): name for name in ("Pa", "kPa", "MPa", "GPa")}
_KNOWN = re.compile(r"[A-Za-zµμ][A-Za-zµμ0-9*/^. ()⁻¹²³·⋅-]*\Z")
_REFUSALS = (ValueError, TypeError, AssertionError, ArithmeticError, SyntaxError)
"""Errors, besides its own, by which pint refuses text that is no unit."""
_RAISED = str.maketrans("⁻¹²³", "-123")


def names_no_unit(text: str, dimension: str) -> bool:
    """Tell whether the place of a unit says that there is none, or holds the dimension itself.

    Commands write "t [time]" and "slip_rate [length/time]" where a scene has no units.
    """
    return text.strip().lower() in NO_UNIT or text.strip() in (dimension, unit(dimension))


def si_size(name: str, dimension: str) -> float | None:
    """Factor from a unit, named as files have it ("mm/s", "m s^-1", "psi"), to that of the SI.

    It is None if it is no known unit of the dimension, one of `semianalytic.scene.units`.  Raises
    MissingLibraryError without pint if it is not one of the SI with a common prefix.
    """
    text = name.strip()
    if text == unit(dimension, SI):
        return 1.0
    common = common_size(text, dimension)
    if common is not None:
        return common
    if len(text) > LONGEST or not _KNOWN.match(text):
        return None
    return _size(_CASES.get(text, text), dimension)


def known_size(text: str, dimensions: Collection[str]) -> float | None:
    """Factor to SI units, 1 where there is no unit; None for a unit of none of the dimensions."""
    if any(names_no_unit(text, dimension) for dimension in dimensions):
        return 1.0
    # those that need no library come first: ms is a time before it is no length
    sizes = (find(text, dimension) for find in (common_size, si_size) for dimension in dimensions)
    return next((size for size in sizes if size is not None), None)


def common_size(text: str, dimension: str) -> float | None:
    """Factor from a unit with a common prefix, or of strain, to that of the SI; None for others."""
    size = size_of(text, dimension)
    return _PARTS.get(text.lower()) if size is None and dimension == "1" else size


@cache
def _size(name: str, dimension: str) -> float | None:
    with needing(f"Reading the unit {name!r}"):
        import pint
    registry = _registry()
    try:
        known = registry.parse_units(_expression(name))
        if not known.is_compatible_with(_BASE[dimension]):
            return None
        size = float(registry.Quantity(1.0, known).to(_BASE[dimension]).magnitude)
    except (pint.PintError, tokenize.TokenError, *_REFUSALS):
        return None
    return size if 0 < size < float("inf") else None


@cache
def _registry() -> UnitRegistry:
    from pint import UnitRegistry

    return UnitRegistry(on_redefinition="ignore")


def _expression(name: str) -> str:
    """A unit as pint parses it: "m s⁻¹" and "m.s-1" as "m*s**-1"."""
    text = re.sub(
        r"(?<=[A-Za-zµμ])([⁻¹²³]+)", lambda found: "^" + found[1].translate(_RAISED), name
    )
    text = text.replace("^", "**").replace("·", "*").replace("⋅", "*")
    text = re.sub(r"(?<=[A-Za-zµμ])(-?\d)", r"**\1", text)
    text = re.sub(r"(?<=[A-Za-zµμ0-9)])[ .](?=[A-Za-zµμ(])", "*", text)
    return text.strip()
