"""Columns of tables that belong to a scene, with the units that their headings name."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.tables.text import Array, read_table
from semianalytic.scene.tables.units import EXAMPLES, common_size, names_no_unit, si_size

_BRACKETED = re.compile(r"([^\[(]*)[\[(]([^\[\]()]*(?:\([^()]*\)[^\[\]()]*)?)[\])]\s*\Z")


@dataclass(frozen=True, eq=False)
class Column:
    """A column of a table: its heading, the name and the unit in it, and its numbers."""

    heading: str
    name: str
    unit: str
    values: Array

    def size(self, dimensions: Collection[str]) -> float | None:
        """Factor to SI units, 1 where there is no unit; None for one of none of the dimensions."""
        if any(names_no_unit(self.unit, one) for one in dimensions):
            return 1.0
        # those that need no library come first: ms is a time before it is no length
        sizes = (find(self.unit, one) for find in (common_size, si_size) for one in dimensions)
        return next((one for one in sizes if one is not None), None)


def split_heading(heading: str, dimensions_of: Callable[[str], Collection[str]]) -> tuple[str, str]:
    """Return the name in a heading, and the unit, in brackets or behind _, or "".

    `dimensions_of` says which dimensions a name may have: what follows _ is else part of it.
    """
    bracketed = _BRACKETED.match(heading)
    if bracketed:
        return bracketed[1].strip(), bracketed[2].strip()
    stem, _, last = heading.strip().rpartition("_")
    if any(common_size(last, one) is not None for one in dimensions_of(stem) if stem):
        return stem, last
    return heading.strip(), ""


def read_columns(path: str | PathLike[str]) -> tuple[Column, ...]:
    """Return the columns of a table.

    Raises
    ------
    SceneError
        If it cannot be read or has no headings: it is part of the description of a scene.
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
