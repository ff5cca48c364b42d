"""Marches in HDF5 files, from which they can go on: a march, and its companion in a group."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from semianalytic.engine.convergence import Departure
from semianalytic.engine.scenes.nodes import Grid
from semianalytic.engine.scenes.state import Extremes, MarchStatistics
from semianalytic.engine.stepping.blocks import Reached
from semianalytic.memory.exponentials import Memory
from semianalytic.memory.line_memory import Past
from semianalytic.results.files import sealed_hdf5, whole_hdf5
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.documents import scene_document, scene_from_document

FORMAT = "slipfront march 5"

_PARTS: dict[str, Callable[..., Any]] = {
    "interface": InterfaceHistory,
    "totals": Totals,
    "statistics": MarchStatistics,
    "grid": Grid,
    "memory": Memory,
    "reached": Reached,
    "past": Past,
    "seen": Extremes,
    "departure": Departure,
}

Made = TypeVar("Made")


def write_march(path: str | Path, march: Any) -> None:
    """Write a march and its companion to a file that appears complete.

    Raises
    ------
    MissingLibraryError
        If h5py is not installed.
    DataFileError
        If the file cannot be written.
    """
    with whole_hdf5(path) as file:
        file.attrs["format"] = FORMAT
        file.attrs["scene"] = json.dumps(scene_document(march.scene))
        _write(file, march)


def read_march(path: str | Path, make: Callable[..., Made]) -> Made:
    """Return the march that a file holds, made from its attributes by name.

    Raises
    ------
    MissingLibraryError
        If h5py is not installed.
    DataFileError
        If the file is missing, damaged or not a march.
    """
    try:
        with sealed_hdf5(path) as file:
            if file.attrs.get("format") != FORMAT:
                raise DataFileError(f"{path} is not a slipfront march; give a file of one.")
            scene = scene_from_document(json.loads(file.attrs["scene"]))

            def march(**parts: Any) -> Made:
                return make(scene=scene, **parts)

            return _read(file, march, {**_PARTS, "companion": march})
    except (OSError, KeyError, TypeError, ValueError, SceneError) as error:
        raise DataFileError(f"{path} cannot be read as a march ({error}); march again.") from error


def _write(group: Any, whole: Any) -> None:
    """Write arrays and parts as members of an HDF5 group, numbers as its attributes."""
    for field in fields(whole):
        name, value = field.name, getattr(whole, field.name)
        if name in _PARTS or (name == "companion" and is_dataclass(value)):
            _write(group.create_group(name), value)
        elif isinstance(value, np.ndarray):
            group[name] = value
        elif name != "scene" and value is not None:
            group.attrs[name] = json.dumps(value)


def _read(group: Any, make: Callable[..., Made], parts: dict[str, Callable[..., Any]]) -> Made:
    """Return what `_write` wrote, made from the values by name."""
    values = {
        name: _read(member, parts[name], parts) if name in parts else member[()]
        for name, member in group.items()
    }
    own = {name: json.loads(value) for name, value in group.attrs.items() if name not in _HEAD}
    return make(**values, **own)


_HEAD = ("format", "scene")
