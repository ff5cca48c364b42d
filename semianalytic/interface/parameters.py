"""The numbers of an interface by name, which surveys vary and fits seek."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from semianalytic.interface.contact import Contact
from semianalytic.interface.fields import Expression, Scaled
from semianalytic.interface.interface import Interface
from semianalytic.scene.checks import finite
from semianalytic.scene.units import PARAMETERS

_OWN: Mapping[str, str] = {
    "length": "length",
    "held": "length",
    "pressure": "stress",
    "shear": "stress",
    "rate": "length / time",
    "plate_rate": "length / time",
}
"""Dimensions of the numbers of an interface itself."""
_LAW: Mapping[str, str] = {
    **dict.fromkeys(("friction", "static", "dynamic", "a", "b", "f0", "weakened"), "1"),
    **{"cohesion": "stress", "viscosity": "stress time / length"},
    **dict.fromkeys(("delay", "theta", "arrival", "fall"), "time"),
    **dict.fromkeys(("distance", "delay_slip"), "length"),
    **dict.fromkeys(("rate", "v0", "weakening_rate"), "length / time"),
}
"""Dimensions of the parameters of laws by name; those of other laws may go by the same names."""
_ADHESION: Mapping[str, str] = {"strength": "stress", "length": "length"}
"""Dimensions of the numbers of adhesion."""
_POINTS, _TIMES = 257, 9
"""Positions and times at which functions are sampled to tell one interface from another."""

Path = tuple[Any, ...]
"""Names of fields, and places in tuples, from the interface to one of its numbers."""


@dataclass(frozen=True)
class Parameter:
    """A number of an interface.

    Attributes
    ----------
    value : float
        Its value.
    dimension : str
        Its dimension, such as "length / time".
    targets : tuple of (path, sign)
        Where it stands: several places if ends of contacts mirror one another.
    """

    value: float
    dimension: str
    targets: tuple[tuple[Path, float], ...]


def spelled(given: str) -> str:
    """Return a name that is spelled as in TOML, dotted, or with underscores, with underscores."""
    return given.replace(".", "_").replace("-", "_").removeprefix("material_")


def interface_parameters(interface: Interface) -> dict[str, Parameter]:
    """Return all numbers of an interface by name.

    A field that is a function, an expression or a table has the parameter NAME_factor, by which it
    is multiplied; numbers that an expression names are parameters of their own.
    """
    found: dict[str, Parameter] = {}
    for name in _OWN:
        _add_field(found, name, _OWN[name], getattr(interface, name), (name,))
    for solid, prefix in (("material", ""), ("lower_material", "lower_material_")):
        if getattr(interface, solid) is not None:
            _add_numbers(found, prefix, getattr(interface, solid), (solid,), PARAMETERS)
    _add_numbers(found, "law_", interface.law, ("law",), _LAW)
    _add_numbers(found, "adhesion_", interface.adhesion, ("adhesion",), _ADHESION)
    for number, load in enumerate(interface.loads):
        prefix = "load_" if len(interface.loads) == 1 else f"load_{number + 1}_"
        _add_load(found, prefix, load, ("loads", number))
    for name, parameter in _ends(interface.contact, interface.even):
        found[name] = parameter
    return found


def _add_field(
    found: dict[str, Parameter], name: str, dimension: str, value: Any, path: Path
) -> None:
    """Add the number of a field, or the factor of one that varies, and the numbers it names."""
    number = finite(value)
    if number is not None:
        found[name] = Parameter(number, dimension, ((path, 1.0),))
        return
    if not callable(value):
        return
    factor = value.factor if isinstance(value, Scaled) else 1.0
    found[f"{name}_factor"] = Parameter(factor, "1", (((*path, "factor"), 1.0),))
    inside = value.field if isinstance(value, Scaled) else value
    for key, number in (inside.numbers if isinstance(inside, Expression) else {}).items():
        # One named number may stand in several expressions, and changes in all of them.
        before = found[key].targets if key in found else ()
        found[key] = Parameter(number, "1", (*before, ((*path, key), 1.0)))


def _add_numbers(
    found: dict[str, Parameter], prefix: str, part: Any, path: Path, known: Mapping[str, str]
) -> None:
    """Add all numbers of a part that is a dataclass."""
    for one in fields(part) if is_dataclass(part) else ():
        name = f"{prefix}{one.name}"
        _add_field(
            found, name, known.get(one.name, "1"), getattr(part, one.name), (*path, one.name)
        )


def _add_load(found: dict[str, Parameter], prefix: str, load: Any, path: Path) -> None:
    """Add the numbers of a load, and of its front and history."""
    for one in fields(load):
        value, name = getattr(load, one.name), f"{prefix}{one.name}"
        if one.name in ("front", "history"):
            inner = prefix if one.name == "front" else f"{name}_"
            if is_dataclass(value):
                _add_numbers(found, inner, value, (*path, one.name), PARAMETERS)
            elif callable(value):
                _add_field(found, name, "1", value, (*path, one.name))
        # Without a history the load is one expression of x and t, which has no number beside it.
        elif callable(value) or getattr(load, "history", load) is not None:
            _add_field(found, name, _LOAD.get(one.name, "1"), value, (*path, one.name))


_LOAD: Mapping[str, str] = {"shear": "stress", "pressure": "stress", "at": "length"}


def _ends(contact: Contact, even: bool) -> Iterator[tuple[str, Parameter]]:
    """Yield the finite ends of contacts; of an even interface those at x > 0, with their images."""
    places = [
        (number, side, end)
        for number, interval in enumerate(contact.intervals)
        for side, end in enumerate(interval)
        if finite(end) is not None
    ]
    counted: dict[int, int] = {}
    for number, side, end in places:
        # The image of an end on an even line is no parameter of its own, or fits would break
        # symmetry.
        if even and end <= 0:
            continue
        own = counted.setdefault(number, len(counted) + 1)
        mirrored = [(n, s) for n, s, other in places if even and other == -end]
        targets = [(("contact", number, side), 1.0)]
        targets += [(("contact", n, s), -1.0) for n, s in mirrored]
        alone = len({n for n, _, one in places if not even or one > 0}) == 1
        name = f"contact_{'' if alone else f'{own}_'}{('begin', 'end')[side]}"
        yield name, Parameter(end, "length", tuple(targets))


def interface_at(interface: Interface, values: Mapping[str, float]) -> Interface:
    """Return the interface with other values of some parameters.

    Raises
    ------
    SceneError
        If a value is out of range.
    """
    known = interface_parameters(interface)
    changes = {
        path: sign * value for name, value in values.items() for path, sign in known[name].targets
    }
    changed: Interface = _changed(interface, changes)
    return changed


def _changed(part: Any, changes: Mapping[Path, float]) -> Any:
    """Return a part with other numbers, by their paths."""
    # The path ends here: this is the number itself.
    if () in changes:
        return changes[()]
    # Fields are functions: their numbers are a common factor and those that an expression names.
    if callable(part) and not isinstance(part, type):
        factor = {path[0]: value for path, value in changes.items()}.pop("factor", None)
        named = {path[0]: value for path, value in changes.items() if path[0] != "factor"}
        if isinstance(part, Scaled):
            inner = part.field.with_numbers(named) if named else part.field
            return Scaled(inner, part.factor if factor is None else factor)
        inner = part.with_numbers(named) if named else part
        return inner if factor is None else Scaled(inner, factor)
    heads = dict.fromkeys(path[0] for path in changes)
    below = {
        head: {path[1:]: value for path, value in changes.items() if path[0] == head}
        for head in heads
    }
    if isinstance(part, Contact):
        return Contact(_changed(part.intervals, changes))
    if isinstance(part, tuple):
        return tuple(
            _changed(one, below[number]) if number in below else one
            for number, one in enumerate(part)
        )
    return replace(part, **{head: _changed(getattr(part, head), below[head]) for head in heads})


def interface_document(
    interface: Interface, end: float, options: Mapping[str, Any]
) -> dict[str, Any]:
    """Return an interface, its end time and the options of its run as text and numbers, for JSON.

    Functions are told apart by their values at some positions and times.
    """
    x = np.linspace(-interface.length / 2, interface.length / 2, _POINTS)
    t = np.linspace(0.0, end, _POINTS)
    return {
        "interface": _written(interface, x, t),
        "end_time": end,
        "options": {name: _written(value, x, t) for name, value in options.items()},
    }


def _written(value: Any, x: Any, t: Any) -> Any:
    # JSON has these as they are; numbers of numpy become Python's own below.
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        # JSON has no infinity.
        return value if np.isfinite(value) else str(value)
    if isinstance(value, Expression):
        return {"text": value.text, **value.numbers} if value.numbers else value.text
    if isinstance(value, tuple | list):
        return [_written(one, x, t) for one in value]
    if isinstance(value, np.ndarray):
        long = value.size > _POINTS
        return hashlib.sha256(value.tobytes()).hexdigest() if long else value.tolist()
    if isinstance(value, np.floating | np.integer):
        return value.item()
    if is_dataclass(value) and not isinstance(value, type):
        written = {one.name: _written(getattr(value, one.name), x, t) for one in fields(value)}
        return {"kind": type(value).__name__, **written}
    if callable(value):
        return {"function": _digest(value, x, t)}
    return repr(value)


def _digest(function: Callable[..., Any], x: Any, t: Any) -> str:
    """Return a digest of the values of a function of x, of x and t, or of t."""
    digest = hashlib.sha256()
    # A function does not say what it takes: all three ways are tried, and failures count too.
    for arguments in ((x,), *((x, one) for one in t[:: _POINTS // _TIMES]), *((one,) for one in t)):
        try:
            digest.update(np.asarray(function(*arguments), dtype=float).tobytes())
        except Exception:  # a function of other arguments fails in any way
            digest.update(b"-")
    return digest.hexdigest()


def can_travel(interface: Interface) -> bool:
    """Return whether other processes can receive an interface.

    They cannot receive functions and laws of a notebook or of the program that is running.
    """
    try:
        # Pickle refers to such functions by name, and other processes have another __main__.
        return b"__main__" not in pickle.dumps(interface)
    except Exception:  # what cannot be pickled fails in any way
        return False
