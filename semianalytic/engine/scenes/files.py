"""Marches in HDF5 files, from which they can go on: a march, and its companion in a group."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

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
from semianalytic.scene.scene import Scene

FORMAT = "slipfront march 5"

_OPTIONS = {"latest": float, "step_ratio": float, "damping": float, "every": int, "entry": float}
_GROUPS = {
    "interface": InterfaceHistory,
    "totals": Totals,
    "grid": Grid,
    "memory": Memory,
    "reached": Reached,
    "past": Past,
    "seen": Extremes,
}

Made = TypeVar("Made")


def write_march(
    path: str | Path,
    scene: Scene,
    march: Mapping[str, Any],
    companion: Mapping[str, Any] | None,
) -> None:
    """Write a march and its companion, each by its attributes, to a file that appears complete.

    Raises
    ------
    MissingLibraryError
        If h5py is not installed.
    DataFileError
        If the file cannot be written.
    """
    with whole_hdf5(path) as file:
        file.attrs["format"] = FORMAT
        file.attrs["scene"] = json.dumps(scene_document(scene))
        _write(file, march)
        if companion is not None:
            _write(file.create_group("companion"), companion)


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
            companion = None
            if "companion" in file:
                companion = make(scene=scene, **_read(file["companion"]))
            return make(scene=scene, companion=companion, **_read(file))
    except (OSError, KeyError, TypeError, ValueError, SceneError) as error:
        raise DataFileError(f"{path} cannot be read as a march ({error}); march again.") from error


def _write(group: Any, march: Mapping[str, Any]) -> None:
    """Write all attributes of a march but scene and companion into an HDF5 group."""
    for name in _OPTIONS:
        group.attrs[name] = march[name]
    for name in ("rtol", "order"):
        if march[name] is not None:
            group.attrs[name] = march[name]
    group.attrs["statistics"] = json.dumps(asdict(march["statistics"]))
    group.attrs["departure"] = json.dumps(asdict(march["departure"]))
    for name in _GROUPS:
        part = group.create_group(name)
        for field in fields(march[name]):
            part[field.name] = getattr(march[name], field.name)


def _read(group: Any) -> dict[str, Any]:
    """Return the attributes that `_write` wrote, by name."""
    parts = {
        name: kind(**{field.name: group[name][field.name][()] for field in fields(kind)})
        for name, kind in _GROUPS.items()
    }
    # HDF5 returns numpy scalars; the grid of a new march holds Python's own numbers.
    parts["grid"] = Grid(
        float(parts["grid"].spacing),
        *(int(getattr(parts["grid"], name)) for name in ("slot", "observed", "size")),
    )
    return {
        **{name: kind(group.attrs[name]) for name, kind in _OPTIONS.items()},
        "statistics": MarchStatistics(**json.loads(group.attrs["statistics"])),
        "departure": Departure(**json.loads(group.attrs["departure"])),
        "rtol": _number_or_none(group, "rtol"),
        "order": _number_or_none(group, "order"),
        **parts,
    }


def _number_or_none(group: Any, name: str) -> float | None:
    return float(group.attrs[name]) if name in group.attrs else None
