"""Friction laws by the names that they have in files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from semianalytic.scene.checks import checked_number, checked_table, finite, made
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.laws.law import Law, coefficient_field, follows_path
from semianalytic.scene.laws.rate_and_state import RateAndState
from semianalytic.scene.laws.weakening import ForcedFront, RateWeakening, SlipWeakening
from semianalytic.scene.plugins import LAWS, kind_of, known_class

LAW_KINDS: Mapping[str, type[Law]] = {
    "coulomb": Coulomb,
    "slip-weakening": SlipWeakening,
    "rate-weakening": RateWeakening,
    "rate-and-state": RateAndState,
    "forced-front": ForcedFront,
}
LAW_WORDS = ("kind", "shape", "evolution")
"""Keys of laws in files whose values are words."""


def law_from_table(name: str, table: Any, coefficient: Any = None) -> Law:
    """Return the law that a table with a kind and parameters describes.

    The table has the fields of the law, and in place of `dynamic` also `reduction`, the part of
    `static` that is lost; the friction coefficient at rest may stand outside the table.  Raises
    SceneError if the kind or a key is unknown, a key is missing or given twice, or a value is out
    of range.
    """
    values = checked_table(name, table)
    kind = values.pop("kind", None)
    described: type[Law] = known_class(name, LAWS, Law, LAW_KINDS, kind)
    own = coefficient_field(described)
    if coefficient is not None:
        if own is None or own in values:
            where = f"{name}.{own}" if own else "no parameter of this law"
            raise SceneError(f"friction is {where}; leave friction out.")
        values[own] = coefficient
    known = {field.name for field in fields(described)}  # type: ignore[arg-type]
    if "reduction" in values and "dynamic" in known and "reduction" not in known:
        if "dynamic" in values or finite(values.get("static")) is None:
            raise SceneError(f"{name}: reduction needs a number for static and excludes dynamic.")
        reduction = checked_number(
            f"{name}: reduction",
            values.pop("reduction"),
            "be a number between 0 and 1",
            lambda given: 0 <= given <= 1,
        )
        values["dynamic"] = values["static"] * (1 - reduction)
    law: Law = made(name, described, values)
    return law


def law_table(law: Law) -> dict[str, Any]:
    """Return the kind of a law of numbers and its parameters that are not at their default.

    The coefficient at rest is left out, which stands outside the table.  The kind of a class that
    no installed package brings is its name with that of its module, by which it is found again
    where that module is loaded.
    """
    described = type(law)
    kind = kind_of(LAWS, Law, LAW_KINDS, described)
    kind = kind or f"{described.__module__}.{described.__qualname__}"
    own, parts = coefficient_field(described), fields(law)  # type: ignore[arg-type]
    return {"kind": kind} | {
        field.name: getattr(law, field.name)
        for field in parts
        if field.name != own and getattr(law, field.name) != field.default
    }


def checked_friction(friction: object) -> float | Law:
    """Return the friction of a scene: a number for Coulomb's law alone, else a law.

    Raises SceneError if it is neither, or negative.
    """
    if callable(friction) and not isinstance(friction, Law):
        friction = Coulomb(friction)  # a coefficient that varies along x
    if not isinstance(friction, Law):
        number = checked_number(
            "scene: friction", friction, "be a finite number or a law such as SlipWeakening"
        )
        if number < 0:
            raise SceneError(f"scene: friction must not be negative, got {number}.")
        return number
    if beyond_similarity(friction):
        return friction
    if friction.coefficient < 0:
        raise SceneError(f"scene: friction must not be negative, got {friction.coefficient}.")
    if friction == Coulomb(friction.coefficient):
        return friction.coefficient
    return friction


def beyond_similarity(law: Law) -> str:
    """Return what a law has that a march along a line alone knows, in words, or ""."""
    if any(callable(entry) or isinstance(entry, np.ndarray) for entry in vars(law).values()):
        return "parameters that vary along x"
    if not (follows_path(type(law)) and law.has_threshold):
        return "a state other than the path"
    if np.any(law.pressure_delay(np.ones(1))):
        return "a delay"
    if getattr(law, "dynamic", 0.0) > law.coefficient:
        return "a dynamic friction above the static one"
    return ""
