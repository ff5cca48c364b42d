"""Arguments of public functions, where they enter: a wrong type is refused in one sentence, and
quantities become numbers.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Mapping
from numbers import Integral, Real
from os import fspath
from typing import Any, TypeVar

import numpy as np

from semianalytic.scene.checks import plain, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.quantities import Class, in_units_of, is_quantity, made_in_si
from semianalytic.scene.units import ARGUMENTS, SI

Function = TypeVar("Function", bound=Callable[..., Any])


def _is_number(value: object) -> bool:
    return isinstance(plain(value), Real) and np.ndim(np.asarray(plain(value), dtype=float)) == 0


def _is_array(value: Any) -> bool:
    # texts and dates would become numbers; rows of different lengths raise, as in all checks
    kind = np.asarray(value).dtype.kind
    np.asarray(value, dtype=float)
    return kind in "biuf" or (kind == "O" and all(isinstance(x, Real) for x in np.ravel(value)))


_Check = tuple[Callable[[Any], bool], str]
_PATH: _Check = (lambda value: "\0" not in fspath(value), "a path")
_TYPES: Mapping[str, _Check] = {
    "float": (_is_number, "a number"),
    "ArrayLike": (_is_array, "a number or an array of numbers"),
    "Array": (_is_array, "an array of numbers"),
    "int": (lambda value: isinstance(plain(value), Integral), "a whole number"),
    **dict.fromkeys(("str", "Loading"), (lambda value: isinstance(value, str), "a word")),
    **dict.fromkeys(("Path", "str | Path", "str | PathLike[str]"), _PATH),
    "Progress": (callable, "a function"),
}
"""Condition that arguments of an annotation fulfil, and its name in messages."""
_CLASSES = (
    *("Material", "Scene", "Marched", "Simulation", "Conventions", "Setup"),
    *("OneZone", "AlgorithmReading", "Solution"),
)
_ALIKE: Mapping[str, tuple[Any, str]] = {
    "Mapping": (Mapping, "a mapping"),
    "Sequence": (Iterable, "a sequence"),
    "Callable": (Callable, "a function"),
}


def _check_of(kind: str) -> _Check | None:
    """The check that an annotation asks for; None if it asks for none that is known here."""
    if kind in _CLASSES:  # by name: this module is imported by theirs
        return lambda value: kind in (base.__name__ for base in type(value).__mro__), f"a {kind}"
    if kind.partition("[")[0] in _ALIKE and not kind.count(" | "):
        alike, name = _ALIKE[kind.partition("[")[0]]
        return lambda value: isinstance(value, alike), name
    return _TYPES.get(kind)


def checking(function: Function) -> Function:
    """Let a function refuse arguments of a wrong type, by its annotations.

    It raises SceneError, "{function}: {argument} must be {what}, got {value}."
    """
    kinds = {
        name: (*check, str(annotation).endswith(" | None"))
        for name, annotation in function.__annotations__.items()
        if name != "return" and (check := _check_of(str(annotation).removesuffix(" | None")))
    }
    names = list(inspect.signature(function).parameters)

    @functools.wraps(function)
    def checked(*args: Any, **given: Any) -> Any:
        for name, value in (*zip(names, args, strict=False), *given.items()):
            if name not in kinds or (value is None and kinds[name][2]):
                continue
            admits, required, _ = kinds[name]
            try:
                right = admits(value)
            except (TypeError, ValueError, OverflowError):
                right = False
            if not right:
                what = f"{function.__name__}: {name}"
                raise SceneError(f"{what} must be {required}, got {shown(value)}.")
        return function(*args, **given)

    return checked  # type: ignore[return-value]


def checking_functions(package: dict[str, Any]) -> None:
    """Let the functions of a package refuse arguments of a wrong type, given its `globals`.

    Its own modules, which call each other with what was checked, are not slowed down.
    """
    for name, member in list(package.items()):
        if inspect.isfunction(member) and member is not checking_functions:
            package[name] = checking(member)
            package[name].__module__ = package["__name__"]  # where pickle finds it


def taking_quantities(
    function: Function, described: Callable[[Any], object] = lambda first: first
) -> Function:
    """Let a function of a scene, or a method of an answer, take quantities for its `ARGUMENTS`.

    They become numbers in the units of the scene, which is the first argument, or that of the
    answer; `described` returns the scene if the first argument is only its name.
    """
    names, checked = list(inspect.signature(function).parameters), checking(function)

    @functools.wraps(function)
    def asked(*args: Any, **given: Any) -> Any:
        if any(map(is_quantity, (*args[1:], *given.values()))):
            given = {**dict(zip(names, args, strict=False)), **given}
            first = described(given[names[0]])
            scene = getattr(first, "scene", first)
            args, units = (), SI if made_in_si(scene) else getattr(scene, "units", "")
            for name in given.keys() & ARGUMENTS.keys():
                what = f"{function.__name__}: {name}"
                given[name] = in_units_of(units, what, given[name], ARGUMENTS[name])
            args = (given.pop(names[0]),)
        return checked(*args, **given)

    return asked  # type: ignore[return-value]


def asked_in_units(answer: Class) -> Class:
    """Let all public methods of the class of an answer take quantities, and check their types."""
    for name, method in list(vars(answer).items()):
        if isinstance(method, classmethod):
            setattr(answer, name, classmethod(checking(method.__func__)))
        elif not name.startswith("_") and inspect.isfunction(method):
            asked = ARGUMENTS.keys() & inspect.signature(method).parameters.keys()
            setattr(answer, name, (taking_quantities if asked else checking)(method))
    return answer
