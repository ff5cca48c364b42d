"""Checks of numbers, keys and tables that users give, and the sentences that refuse wrong ones."""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import MISSING, fields
from numbers import Integral, Real
from reprlib import Repr
from typing import Any

from semianalytic.scene.errors import SceneError

SMALLEST, LARGEST = 1e-60, 1e60
"""Range of all parameters: products of five of them are still finite."""

LARGEST_COUNT = 10**15
"""Largest whole number that is accepted; all up to it are floating-point numbers too."""


class _Shown(Repr):
    """A `repr` that is short, for messages."""

    def __init__(self) -> None:
        super().__init__()
        # Longer values are cut in the middle, so that a message stays on one line.
        self.maxstring = self.maxother = 60

    def repr_int(self, x: int, level: int) -> str:
        """Describe integers of many digits by their size: Python refuses to write the longest."""
        if x.bit_length() < 100:
            return repr(x)
        return f"a whole number of about {round(x.bit_length() * math.log10(2))} digits"


_SHOWN = _Shown()


def shown(value: object) -> str:
    """Write a value for a message, short and on one line."""
    return " ".join(_SHOWN.repr(value).split())


def plain(value: Any) -> Any:
    """Return the number in a zero-dimensional array of numpy or in its scalar; other values, and
    masked ones, as they are."""
    single = getattr(value, "ndim", None) == 0 and hasattr(value, "item")
    return value.item() if single and not getattr(value, "mask", False) else value


def meant(name: str, known: Iterable[str], others: str, cutoff: float = 0.6) -> str:
    """Return a hint at the known name that is most like an unknown one, else at the others."""
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=cutoff)
    return f"did you mean {close[0]}?" if close else others


def among(value: object, words: Collection[str]) -> bool:
    """Return whether a value is one of some words; arrays, which compare in parts, are none."""
    return isinstance(value, str) and value in words


def finite(value: object) -> float | None:
    """Return a finite real number of any type, numpy's scalars included, as float; else None.

    Truth values and text do not count as numbers, nor do integers beyond the range of floating
    point.  Numbers below that range count as 0, for their reciprocals are infinite.
    """
    value = plain(value)
    # True is an Integral to Python; as a friction coefficient it is a mistake.
    if isinstance(value, bool) or not isinstance(value, Real):
        return None
    try:
        number = float(value)
    except Exception:  # too large, or of a class of another package
        return None
    if 0 < abs(number) < sys.float_info.min:
        return 0.0
    return number if math.isfinite(number) else None


def checked_number(
    what: str,
    value: object,
    required: str = "be a finite number",
    admitted: Callable[[float], bool] | None = None,
) -> float:
    """Return a number of any type as float, or refuse it.

    `what` is the owner and name of the number and `required` the requirement, for the message;
    `admitted` is true for admissible finite numbers, all by default.  Raises SceneError, "{what}
    must {required}, got {value}.", or that it is beyond `LARGEST`.
    """
    number = finite(value)
    if number is None or not (admitted is None or admitted(number)):
        raise SceneError(f"{what} must {required}, got {shown(value)}.")
    if abs(number) > LARGEST:
        raise _out_of_range(what, number)
    return number


def checked_size(what: str, value: object, required: str = "be positive and finite") -> float:
    """Return a positive modulus, density, length, time, rate or frequency as float, or refuse it.

    Arguments are those of `checked_number`; raises SceneError if it is not a positive number, or
    beyond `SMALLEST` or `LARGEST`.
    """
    number = checked_number(what, value, required, lambda given: given > 0)
    if number < SMALLEST:
        raise _out_of_range(what, number)
    return number


def check_fields(
    described: object,
    owner: str,
    names: Iterable[str],
    check: Callable[..., float] = checked_number,
    *requirement: Any,
) -> None:
    """Replace fields of a frozen dataclass by the numbers that a check makes of them, or refuse.

    `__post_init__` calls this with the owner's name for messages and the names of the fields; the
    check is `checked_number`, or `checked_size` for numbers that have to be positive, with what
    else it takes.  Raises SceneError, as "{owner}: {name} must be a finite number, got {value}."
    """
    for name in names:
        number = check(f"{owner}: {name}", getattr(described, name), *requirement)
        # Frozen dataclasses refuse assignment, also to their own methods.
        object.__setattr__(described, name, number)


def _out_of_range(what: str, number: float) -> SceneError:
    return SceneError(
        f"{what} must lie within {SMALLEST:g} and {LARGEST:g}, or products leave the range of "
        f"floating point, got {number:g}; choose other units."
    )


def checked_count(what: str, value: object, least: int, required: str) -> int:
    """Return a whole number from `least` to `LARGEST_COUNT` as int, or refuse it.

    Arguments are those of `checked_number`, with the least admissible number; raises SceneError,
    "{what} must be {required} {least}, got {value}.", or that it is too large.
    """
    value = plain(value)
    count = int(value) if isinstance(value, Integral) and not isinstance(value, bool) else None
    if count is None or count < least:
        raise SceneError(f"{what} must be {required} {least}, got {shown(value)}.")
    if count > LARGEST_COUNT:
        raise SceneError(f"{what} must be at most {LARGEST_COUNT:g}, got {shown(value)}.")
    return count


def check_keys(
    prefix: str, table: Mapping[str, Any], needed: Collection[str], optional: Collection[str] = ()
) -> None:
    """Raise SceneError unless a table has all keys that are needed, and besides only optional ones.

    The prefix is that of the table, such as "material.", or "".
    """
    known = (*needed, *optional)
    for key in table:
        if key not in known:
            hint = meant(key, known, f"known are {', '.join(known) or 'none'} (docs/not_here.md).")
            raise SceneError(f"unknown key {prefix}{shown(key)[1:-1]}; {hint}")
    for key in needed:
        if key not in table:
            raise SceneError(f"{prefix}{key} is missing.")


def checked_table(name: str, value: Any) -> dict[str, Any]:
    """Return a table; raise SceneError if it is something else."""
    if not isinstance(value, Mapping):
        raise SceneError(f"{name} must be a table, [{name}], got {shown(value)}.")
    return dict(value)


def listed(words: Collection[str]) -> str:
    """Name the words that a value may be, for messages."""
    return " or ".join(words) if len(words) == 2 else f"one of {', '.join(words)}"


def checked_word(what: str, value: Any, words: Collection[str], hint: str = "") -> str:
    """Return one of some words; others raise SceneError, "{what} must be one of {words}, got …"."""
    if not among(value, words):
        more = f" ({hint})" if hint else ""
        raise SceneError(f"{what} must be {listed(words)}, got {shown(value)}{more}.")
    return str(value)


def checked_kind(name: str, kind: Any, kinds: Collection[str], hint: str = "") -> str:
    """Return the kind that a table gives; raise SceneError if it is none of those known."""
    return checked_word(f"{name}: kind", kind, kinds, f"{hint}docs/not_here.md")


def made(
    name: str, described: type, given: Mapping[str, Any], spelled: Mapping[str, str] | None = None
) -> Any:
    """Return the part of a class that a table describes; its key "kind" names the class.

    The class is a dataclass; `spelled` has the keys of fields that go by another name in files.
    Raises SceneError if a key is unknown or missing, or a value is out of range.
    """
    parts = sorted(fields(described), key=lambda part: bool(part.kw_only))  # those of all laws last
    keys = {(spelled or {}).get(field.name, field.name): field for field in parts}
    needed = [key for key, part in keys.items() if part.default is part.default_factory is MISSING]
    values = {key: value for key, value in given.items() if key != "kind"}
    check_keys(f"{name}.", values, needed, [key for key in keys if key not in needed])
    return described(**{keys[key].name: value for key, value in values.items()})
