"""Equality and short form of descriptions whose parameters may be arrays, expressions or tables."""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np


class Alike:
    """A dataclass that equals another of its class with equal fields; arrays by their numbers.

    Functions of Python are equal only to themselves.
    """

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other) or not is_dataclass(self):
            return self is other
        pairs = ((getattr(self, one.name), getattr(other, one.name)) for one in fields(self))
        return all(_same(*pair) for pair in pairs)

    def __hash__(self) -> int:
        return hash(type(self))


def expression(part: Any) -> str:
    """Return the expression that makes a dataclass, without parameters at their default."""
    given = []
    for one in sorted(fields(part), key=lambda one: bool(one.kw_only)):
        value = getattr(part, one.name)
        factory = one.default_factory
        if not _same(value, one.default if factory is MISSING else factory()):
            given.append(f"{one.name}={value!r}")
    return f"{type(part).__name__}({', '.join(given)})"


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    return bool(one == other)
