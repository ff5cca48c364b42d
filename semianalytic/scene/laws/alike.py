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
        pairs = ((getattr(self, field.name), getattr(other, field.name)) for field in fields(self))
        return all(_same(*pair) for pair in pairs)

    def __hash__(self) -> int:
        return hash(type(self))


def expression(part: Any) -> str:
    """Return the expression that makes a dataclass, without parameters at their default."""
    given = []
    for field in sorted(fields(part), key=lambda field: bool(field.kw_only)):
        value = getattr(part, field.name)
        factory = field.default_factory
        if not _same(value, field.default if factory is MISSING else factory()):
            given.append(f"{field.name}={value!r}")
    return f"{type(part).__name__}({', '.join(given)})"


def _same(value: Any, other: Any) -> bool:
    if isinstance(value, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(value, other, equal_nan=True)
    return bool(value == other)
