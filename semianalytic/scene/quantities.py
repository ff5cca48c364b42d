"""Numbers with units, such as quantities of pint, where scenes and answers take numbers.

They become numbers of the SI here and nowhere else.  A quantity is whatever has a magnitude and a
method ``to``, so that no library of units is imported.
"""

from __future__ import annotations

import difflib
import functools
import inspect
from typing import Any, TypeVar

from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.units import PARAMETERS, SI, InSI, unit

_USUAL = {
    **dict.fromkeys(("E", "youngs_modulus", "young"), "Material.from_young(E, nu, rho)"),
    **dict.fromkeys(("mu", "G"), "shear_modulus"),
    **dict.fromkeys(("c_l", "c_t", "vp", "vs"), "Material.from_speeds(c_l, c_t, rho)"),
    **{"nu": "poisson_ratio", "rho": "density", "f": "friction"},
    **dict.fromkeys(("law", "friction_law"), "friction"),
}
"""Usual symbols of parameters, and what they are called here."""
Class = TypeVar("Class", bound=type)


def is_quantity(value: object) -> bool:
    """Return whether a value, or one in a list, has a unit: a quantity, or an `InSI`."""
    if isinstance(value, list | tuple):
        return any(map(is_quantity, value))
    return isinstance(value, InSI) or (hasattr(value, "magnitude") and hasattr(value, "to"))


def made_in_si(part: object) -> bool:
    """Return whether a part of a scene was made of numbers with units."""
    return getattr(part, "_made_in_si", False) is True


def in_si(what: str, value: Any, dimension: str) -> Any:
    """Return a quantity as a number, or an array, of the SI; other values as they are.

    Raises SceneError if the quantity is of another dimension.
    """
    if isinstance(value, list | tuple) and is_quantity(value):
        return [in_si(what, item, dimension) for item in value]
    if isinstance(value, InSI) or not is_quantity(value):
        return value
    wanted = "dimensionless" if dimension == "1" else unit(dimension, SI)
    try:
        number = value.to(wanted).magnitude
    except Exception as error:  # a library of units has errors of its own
        said = "no unit" if dimension == "1" else f"a unit of {dimension}, such as {wanted}"
        raise SceneError(f"{what} must have {said}, got {shown(str(value))}.") from error
    # what conversion leaves in the last digits would be shown with the scene
    return float(f"{number:.15g}") if isinstance(number, float) else number


def in_units_of(units: str, what: str, value: Any, dimension: str) -> Any:
    """Return a quantity as a number in the units of a scene; other values as they are.

    Raises SceneError if the scene has no units, or as `in_si`.
    """
    # angles and shares are the same in all systems of units
    if units != SI and dimension not in ("angle", "1") and is_quantity(value):
        raise SceneError(
            f"{what} has a unit, but the scene does not say which units its own numbers have; "
            'say units = "SI" in the scene (--units SI), or give a number alone.'
        )
    return in_si(what, value, dimension)


def with_quantities(described: Class) -> Class:
    """Let the dataclass of a scene, or of a part of one, take quantities for its `PARAMETERS`.

    Objects made of quantities, or of such parts, contain numbers of the SI, and `made_in_si`
    says so.  A keyword that the class does not have is refused with the one that was meant.
    """
    plain = described.__init__  # type: ignore[misc]
    names, what = list(inspect.signature(plain).parameters)[1:], described.__name__.lower()

    @functools.wraps(plain)
    def init(self: Any, *args: Any, **given: Any) -> None:
        values = (*args, *given.values())
        for name in given:
            if name not in names:
                close = difflib.get_close_matches(name, names, n=1)
                meant = _USUAL.get(name) or (close[0] if close else "")
                others = f"it has {', '.join(names)} (docs/not_here.md)."
                hint = f"did you mean {meant}?" if meant else others
                raise SceneError(f"{what}: there is no parameter {shown(name)}; {hint}")
        if any(map(is_quantity, values)) or any(map(made_in_si, values)):
            given = {**dict(zip(names, args, strict=False)), **given}
            for name in given.keys() & PARAMETERS.keys():
                given[name] = in_si(f"{what}: {name}", given[name], PARAMETERS[name])
            args = ()
            object.__setattr__(self, "_made_in_si", True)
        plain(self, *args, **given)

    described.__init__ = init  # type: ignore[misc]
    return described
