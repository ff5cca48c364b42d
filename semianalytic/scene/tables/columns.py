"""Columns of tables that belong to a scene, with the units that their headings name."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Collection
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from semianalytic.scene.checks import shown
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.tables.text import Array, read_table
from semianalytic.scene.tables.units import EXAMPLES, common_size, known_size

_BRACKETED = re.compile(r"([^\[(]*)[\[(]([^\[\]()]*(?:\([^()]*\)[^\[\]()]*)?)[\])]\s*\Z")


@dataclass(frozen=True, eq=False)
class Column:
    """A column of a table: its heading, the name and the unit in it, and its numbers."""

    heading: str
    name: str
    unit: str
    values: Array

    def numbers(self, path: str | PathLike[str], dimensions: Collection[str]) -> Array:
        """The numbers in SI units, all of them finite; raises a SceneError."""
        size = known_size(self.unit, dimensions)
        if size is None:
            raise SceneError(
                f"{path}: {self.name} must have no unit, or one such as "
                f"{', '.join(EXAMPLES[unit] for unit in dimensions)}, got {shown(self.unit)}."
            )
        if not np.isfinite(self.values).all():
            raise SceneError(f"{path}: {self.name} must hold finite numbers in every row.")
        return size * self.values


class UnreadColumns(UserWarning):
    """Columns of a table that no field is read from."""


class Tables:
    """The tables of one scene, each read once, and which of their columns it asks for."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Column, ...]] = {}
        self._asked: set[tuple[str, str]] = set()

    def pair(self, path: str | PathLike[str], name: str = "") -> tuple[Column, Column]:
        """Return the first column, x, and the one of a name; the second one without a name."""
        key = str(path)
        columns = self._known[key] = self._known.get(key) or read_columns(path)
        found = next((cell for cell in columns[1:] if name in ("", cell.name, cell.heading)), None)
        if found is None:
            names = ", ".join(column.heading for column in columns)
            raise SceneError(f"{path}: there is no column {shown(name)}; it has {names}.")
        self._asked.add((key, found.heading))
        return columns[0], found

    def warn_of_unread(self) -> None:
        """Warn once of each table that has columns nothing asked for."""
        for path, columns in self._known.items():
            headings = (column.heading for column in columns[1:])
            names = [heading for heading in headings if (path, heading) not in self._asked]
            if names:
                known = ", ".join(name[:40] for name in names[:10]) + ", ..." * bool(names[10:])
                sentence = f"{path}: columns that are not read: {known}."
                warnings.warn(sentence, UnreadColumns, stacklevel=2)


def split_heading(heading: str, dimensions_of: Callable[[str], Collection[str]]) -> tuple[str, str]:
    """Return the name in a heading, and the unit, in brackets or behind _, or "".

    `dimensions_of` says which dimensions a name may have: what follows _ is else part of it.
    """
    bracketed = _BRACKETED.match(heading)
    if bracketed:
        return bracketed[1].strip(), bracketed[2].strip()
    words = heading.strip().split("_")
    for behind in (1, 2):  # x_mm, v_mm_s
        stem, unit = "_".join(words[:-behind]), "/".join(words[-behind:])
        if any(common_size(unit, entry) is not None for entry in dimensions_of(stem) if stem):
            return stem, unit
    return heading.strip(), ""


def read_columns(path: str | PathLike[str]) -> tuple[Column, ...]:
    """Return the columns of a table.

    Raises SceneError if it cannot be read or has no headings: it is part of the description of a
    scene.
    """
    try:
        table = read_table(Path(path))
    except DataFileError as error:
        raise SceneError(str(error)) from error
    if not table.names:
        raise SceneError(f"{path} has no header; begin it with names, as t [us],value.")
    split = [split_heading(heading, lambda _: EXAMPLES) for heading in table.names]
    return tuple(
        Column(heading, name, unit, table.rows[:, place])
        for place, (heading, (name, unit)) in enumerate(zip(table.names, split, strict=True))
    )
