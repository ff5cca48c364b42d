"""Arguments of public functions, where they enter: a wrong type is refused in one sentence, and
quantities become numbers.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Mapping
from numbers import Integral, Real
from os import fspath
from typing import Any, TypeVar, get_args

import numpy as np

from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import LARGEST, LARGEST_COUNT, among, listed, plain, shown
from semianalytic.scene.errors import SceneError, SlipfrontError
from semianalytic.scene.quantities import Class, in_units_of, is_quantity, made_in_si
from semianalytic.scene.units import ARGUMENTS, SI

Function = TypeVar("Function", bound=Callable[..., Any])


_BARE = (TypeError, ValueError, ArithmeticError, AttributeError, LookupError)
"""Errors of Python that arguments of a wrong type end in."""
_FLOAT = np.dtype(float)
_PLAIN = frozenset((float, bool, str, np.float64, type(None)))
"""Types with which functions compute as they are, as with arrays of floating-point numbers."""


def _is_number(value: object) -> bool:
    # True is a number to Python; nan compares with nothing
    return _is_real(number := plain(value)) and abs(float(number)) <= LARGEST


def _is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_count(value: object) -> bool:
    count = plain(value)
    whole = isinstance(count, Integral) and not isinstance(count, bool)
    return whole and abs(int(count)) <= LARGEST_COUNT


def floats_of(value: Any) -> Array | None:
    """Return a number, or an array of numbers, of any type as an array; None for other values.

    Masked, complex and ragged arrays, truth values, texts, dates and objects that fail are none.
    """
    try:
        given = np.asarray(value)
        kind = given.dtype.kind
        real = kind in "iuf" or (kind == "O" and all(map(_is_real, given.flat)))
        if not real or np.ma.is_masked(value):
            return None
        with np.errstate(over="raise"):  # of numbers with more digits
            return given.astype(float, copy=False)
    except Exception:  # of any kind: the value may be of a class of another package
        return None


_Check = tuple[Callable[[Any], bool], str]
_NUMBERS = ("float", "ArrayLike", "Array | float", "Array")
"""Annotations of what is computed with as floating-point numbers, whatever its type."""
_ARRAY: _Check = (lambda value: floats_of(value) is not None, "a number or an array of numbers")
_ROW: _Check = (
    lambda value: (row := floats_of(value)) is not None and row.ndim > 0,
    "an array of numbers",
)
_PATH: _Check = (lambda value: "\0" not in fspath(value), "a path without NUL characters")
_TYPES: Mapping[str, _Check] = {
    "float": (_is_number, f"a finite number up to {LARGEST:g}"),
    **dict.fromkeys(("ArrayLike", "Array | float"), _ARRAY),
    **dict.fromkeys(("Array", "Sequence[float]"), _ROW),
    "int": (_is_count, f"a whole number up to {LARGEST_COUNT:g}"),
    "bool": (lambda value: isinstance(plain(value), int) and value in (0, 1), "True or False"),
    "str": (lambda value: isinstance(value, str), "a word"),
    **dict.fromkeys(("Path", "str | Path", "str | PathLike[str]", "str | os.PathLike[str]"), _PATH),
    "Progress": (callable, "a function"),
}
"""Condition that arguments of an annotation fulfil, and its name in messages."""
_CLASSES = (
    *("Material", "Scene", "Marched", "Simulation", "Conventions", "Setup"),
    *("OneZone", "AlgorithmReading", "Solution", "Tractions", "Gauge", "CutPoints"),
    *("Adhesion", "Block", "Contact", "LoadHistory"),
)
_ALIKE: Mapping[str, tuple[Any, str]] = {
    "Mapping": (Mapping, "a mapping"),
    "Sequence": (Iterable, "a sequence"),
    "Callable": (Callable, "a function"),
}


def _check_of(kind: str, names: Mapping[str, Any]) -> _Check | None:
    """The check that an annotation asks for; None if it asks for none that is known here.

    Words that a `Literal` of the module lists are found among its `names`.
    """
    if kind in _TYPES:
        return _TYPES[kind]
    if kind in _CLASSES:  # by name: this module is imported by theirs
        return lambda value: kind in (base.__name__ for base in type(value).__mro__), f"a {kind}"
    if kind.partition("[")[0] in _ALIKE and not kind.count(" | "):
        alike, name = _ALIKE[kind.partition("[")[0]]
        return lambda value: isinstance(value, alike), name
    if words := [word for word in get_args(names.get(kind)) if isinstance(word, str)]:
        return lambda value: among(value, words), listed(words)
    return None


def checking(function: Function, *, at_once: bool = True) -> Function:
    """Let a function refuse arguments of a wrong type, by its annotations.

    It does so before it computes, or if not `at_once` for floating-point numbers only once it has
    failed: solvers call methods of friction laws at every step, with arguments that are right.
    numpy does not warn of what those return at nan and inf.

    Raises
    ------
    SceneError
        "{function}: {argument} must be {what}, got {value}."
    """
    module = getattr(function, "__globals__", {})
    kinds = {
        name: (kind, check, str(annotation).endswith(" | None"))
        for name, annotation in function.__annotations__.items()
        if name != "return"
        and (check := _check_of(kind := str(annotation).removesuffix(" | None"), module))
    }
    names, called = list(inspect.signature(function).parameters), function.__name__
    if makes := called == "__init__":
        called = function.__qualname__.split(".")[-2].lower()
    # a number beyond the range of floating point is inf
    computed = np.errstate(all=None if at_once else "ignore", over="ignore")(function)

    def taken(name: str, value: Any, strictly: bool = at_once) -> Any:
        if not strictly and (
            type(value) in _PLAIN or (type(value) is np.ndarray and value.dtype is _FLOAT)
        ):
            return value
        if name not in kinds or (value is None and kinds[name][2]):
            return value
        kind, (admits, required), _ = kinds[name]
        if kind == "Array" and not strictly:  # for which one number may stand
            admits = _ARRAY[0]
        try:
            right = admits(value)
        except Exception:  # of any kind: the value may be of a class of another package
            right = False
        if not right:
            raise SceneError(f"{called}: {name} must be {required}, got {shown(value)}.")
        if kind not in _NUMBERS:
            return value
        numbers = np.asarray(value, dtype=float)
        return numbers if numbers.ndim else numbers.item()

    @functools.wraps(function)
    def checked(*args: Any, **given: Any) -> Any:
        if not makes:
            args = (*map(taken, names, args), *args[len(names) :])
            given = {name: taken(name, value) for name, value in given.items()}
        try:
            return computed(*args, **given)
        except SlipfrontError:
            raise
        except _BARE as error:
            passed = {**dict(zip(names, args, strict=False)), **given}
            for name, value in passed.items():
                taken(name, value, strictly=True)
            if "broadcast" in str(error):  # by numpy, with one another or with nodes
                shapes = (f"{name} {np.shape(x)}" for name, x in passed.items() if np.ndim(x))
                said = f"{called}: shapes must fit one another and nodes, got {', '.join(shapes)}."
                raise SceneError(said) from error
            raise

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


def _in_methods(described: Class, wrap: Callable[[Any], Any]) -> Class:
    for name, method in list(vars(described).items()):
        if isinstance(method, classmethod):
            setattr(described, name, classmethod(checking(method.__func__)))
        elif not name.startswith("_") and inspect.isfunction(method):
            setattr(described, name, wrap(method))
    return described


def asked_in_units(answer: Class) -> Class:
    """Let all public methods of the class of an answer take quantities, and check their types."""

    def wrap(method: Any) -> Any:
        asked = ARGUMENTS.keys() & inspect.signature(method).parameters.keys()
        return (taking_quantities if asked else checking)(method)

    return _in_methods(answer, wrap)


def checking_methods(described: Class) -> Class:
    """Let a class and its methods say which argument of a wrong type made them fail."""
    checked = functools.partial(checking, at_once=False)
    if "__init__" in vars(described):
        described.__init__ = checked(described.__init__)  # type: ignore[misc]
    return _in_methods(described, checked)
