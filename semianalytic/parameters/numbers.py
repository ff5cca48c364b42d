"""The numbers of a problem by name: those that surveys, fits, derivatives and options change.

Names are those of files with underscores for dots, as base_pressure or friction_law_distance; the
numbers of the upper body have no prefix.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, TypeVar

from semianalytic.scene.checks import finite
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.laws.law import Law, coefficient_field
from semianalytic.scene.laws.weakening import RateWeakening, SlipWeakening
from semianalytic.scene.line.fields import Scaled
from semianalytic.scene.line.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.scene import Scene
from semianalytic.scene.units import PARAMETERS

_OF_LINE = ("period", "held", "rate", "plate_rate")
"""Numbers of a scene on a line itself."""
_ADHESION: Mapping[str, str] = {"strength": "stress", "length": "length"}
"""Dimensions of the numbers of adhesion."""
_PARTS: Mapping[str, str] = {
    **{"material": "", "lower_material": "lower_", "base": "base_", "load": "load_"},
    **{f"{name}_history": f"{name}_history_" for name in ("pressure", "shear")},
}
"""Prefixes of the numbers of the parts of a scene."""

Problem = TypeVar("Problem")
Path = tuple[Any, ...]
"""Names of fields, and places in tuples, from the problem to one of its numbers."""


@dataclass(frozen=True)
class Number:
    """A number of a problem."""

    value: float
    dimension: str  # such as "length / time"
    # where it stands: several places if ends of contacts mirror one another
    targets: tuple[tuple[Path, float], ...]


def spelled(given: str) -> str:
    """Return a name that is spelled as in TOML, dotted, or with underscores, with underscores."""
    name = given.replace(".", "_").replace("-", "_").removeprefix("material_")
    name = name.replace("lower_material_", "lower_")
    # the coefficient at rest goes by one name, whatever a law calls it
    return re.sub("^friction_law_(friction|static)", "friction", name)


def numbers_of(scene: Any) -> dict[str, Number]:
    """Return all numbers of a scene by name.

    A field that is a function, an expression or a table has the number NAME_factor, by which it is
    multiplied; numbers that an expression names are numbers of their own.  Constant friction has a
    viscosity of 0.

    Examples
    --------
    >>> from semianalytic import find
    >>> from semianalytic.parameters.numbers import numbers_of, with_numbers
    >>> scene = with_numbers(find("preloaded"), {"friction": 0.2, "base_pressure": 2.0})
    >>> scene.friction, scene.base.pressure, numbers_of(scene)["base_pressure"].dimension
    (0.2, 2.0, 'stress')
    """
    law, of_law, found = scene.law, dict[str, Number](), dict[str, Number]()
    own = coefficient_field(type(law))
    if own is not None and finite(getattr(law, own)) is None:
        _add_field(found, "friction", "1", getattr(law, own), ("law", own))
    elif own is not None:
        _add_field(found, "friction", "1", scene.coefficient, ("law", "coefficient"))
    for part, prefix in _PARTS.items():
        if part == "lower_material" and scene.on_line and scene.lower_material is None:
            continue
        held = scene.bodies[1] if part == "lower_material" else getattr(scene, part)
        prefix = "wave_" if isinstance(held, IncidentWave) else prefix
        if isinstance(held, tuple):
            for at, load in enumerate(held):
                _add_load(found, f"{prefix}{at + 1}_", load, (part, at))
        else:
            _add_load(found, prefix, held, (part,))
    if "wave_angle" in found:
        found["angle"] = found.pop("wave_angle")
    _add_numbers(of_law, "", law, ("law",), PARAMETERS)
    if {"static", "dynamic"} <= of_law.keys():
        # the part of the static friction that is lost, without roundings
        lost = float(f"{1 - law.dynamic / law.static:.14g}") if law.static else 0.0
        _add_field(of_law, "reduction", "1", lost, ("law", "reduction"))
    # scenes next to a slot know no delays, and name the cohesion of a law that has one
    for name, number in of_law.items():
        if name.removesuffix("_factor") == own or (
            not scene.on_line
            and (name in ("delay", "delay_slip") or (name == "cohesion" and not number.value))
        ):
            continue
        film = name == "viscosity" and isinstance(law, Coulomb)
        found[name if film else f"friction_law_{name}"] = number
    if scene.on_line:
        for name in _OF_LINE:
            _add_field(found, name, PARAMETERS[name], getattr(scene, name), (name,))
        _add_numbers(found, "adhesion_", scene.adhesion, ("adhesion",), _ADHESION)
        found |= dict(_ends(scene.contact, scene.even))
    return found


def _add_field(found: dict[str, Number], name: str, dimension: str, value: Any, path: Path) -> None:
    """Add the number of a field, or the factor of one that varies, and the numbers it names."""
    number = finite(value)
    if number is not None:
        found[name] = Number(number, dimension, ((path, 1.0),))
        return
    if not callable(value):
        return
    factor = getattr(value, "factor", 1.0)
    found[f"{name}_factor"] = Number(factor, "1", (((*path, "factor"), 1.0),))
    inside = getattr(value, "field", value)
    for key, number in getattr(inside, "numbers", {}).items():
        # One named number may stand in several expressions, and changes in all of them.
        before = found[key].targets if key in found else ()
        found[key] = Number(number, "1", (*before, ((*path, key), 1.0)))


def _add_numbers(
    found: dict[str, Number], prefix: str, part: Any, path: Path, known: Mapping[str, str]
) -> None:
    """Add all numbers of a part that is a dataclass."""
    for field in fields(part) if is_dataclass(part) else ():
        # laws and histories of other packages declare dimensions themselves
        dimension = field.metadata.get("dimension", known.get(field.name, "1"))
        value = getattr(part, field.name)
        _add_field(found, f"{prefix}{field.name}", dimension, value, (*path, field.name))


def _add_load(found: dict[str, Number], prefix: str, load: Any, path: Path) -> None:
    """Add the numbers of a part of a scene; of a load along x also those of front and history."""
    if not isinstance(load, InterfaceLoad | FrontLoad):
        _add_numbers(found, prefix, load, path, PARAMETERS)
        return
    for field in fields(load):
        value, name = getattr(load, field.name), f"{prefix}{field.name}"
        if field.name in ("front", "history") and is_dataclass(value):
            inner = prefix if field.name == "front" else f"{name}_"
            _add_numbers(found, inner, value, (*path, field.name), PARAMETERS)
        # Without a history the load is one expression of x and t, which has no separate number.
        elif callable(value) or load.history is not None:
            _add_field(found, name, PARAMETERS.get(field.name, "1"), value, (*path, field.name))


def _ends(contact: Any, even: bool) -> Iterator[tuple[str, Number]]:
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
        alone = len({n for n, _, size in places if not even or size > 0}) == 1
        name = f"contact_{'' if alone else f'{own}_'}{('begin', 'end')[side]}"
        yield name, Number(end, "length", tuple(targets))


def with_numbers(problem: Problem, values: Mapping[str, float], **parts: Any) -> Problem:
    """Return a scene with other values of some of `numbers_of`.

    All are replaced at once, and with them whole `parts` by name, for one change after the other
    might pass through a scene that does not exist.  A friction coefficient takes the dynamic
    friction of a law along, in its ratio to it.

    Raises SceneError if a value is out of range.
    """
    known = numbers_of(problem)
    changes = {
        path: sign * value for name, value in values.items() for path, sign in known[name].targets
    }
    changes |= {(name,): part for name, part in parts.items()}
    changed: Problem = _changed(problem, changes) if changes else problem
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
    if hasattr(part, "intervals"):
        return replace(part, intervals=_changed(part.intervals, changes))
    if isinstance(part, Law):
        # first the coefficient: it takes dynamic friction along where that is not given as well
        if "coefficient" in below:
            part = part.with_coefficient(below.pop("coefficient")[()])
        if "reduction" in below and isinstance(part, SlipWeakening | RateWeakening):
            if "dynamic" in below:
                raise SceneError("reduction and dynamic friction say the same; give one of them.")
            below["dynamic"] = {(): part.static * (1 - below.pop("reduction")[()])}
    if isinstance(part, tuple):
        return tuple(
            _changed(item, below[number]) if number in below else item
            for number, item in enumerate(part)
        )
    held = {head: getattr(part, head) for head in below}
    if held.get("lower_material", part) is None:  # a lower body of its own begins as the upper one
        held["lower_material"] = part.material
    changed = {head: _changed(value, below[head]) for head, value in held.items()}
    if "law" in changed and isinstance(part, Scene):  # whose friction may be a number
        changed["friction"] = changed.pop("law")
    return replace(part, **changed)
