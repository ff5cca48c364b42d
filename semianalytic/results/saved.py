"""Answers as sealed HDF5 files: dataclasses of arrays, numbers, scenes and further dataclasses."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

import numpy as np

from semianalytic.results.files import sealed_hdf5, whole_hdf5
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.documents import scene_document, scene_from_document
from semianalytic.scene.scene import Scene

Made = TypeVar("Made")
SOLVED = "slipfront solution 1"
"""Format of exact answers, which are solved again."""


@dataclass(frozen=True)
class SavedScene:
    """The scene of an exact answer, and the settings of `solve` that were given for it."""

    scene: Scene
    settings: Mapping[str, Any]


def write_answer(
    path: str | Path, kind: str, answer: Any, *, compression: int | None = None
) -> None:
    """Write an answer to a file that appears under its name only when it is complete.

    The kind is the name and version of what is written.  Arrays of the answer, a dataclass, become
    datasets, compressed by a level of gzip, and its dataclasses groups; all else becomes JSON in
    attributes.  Errors are those of `whole_hdf5`.
    """
    with whole_hdf5(path) as file:
        file.attrs["format"] = kind
        _write(file, answer, compression)


def read_answer(
    path: str | Path, kind: str, make: type[Made], instead: str, again: str, **known: Any
) -> Made:
    """Return what `write_answer` wrote.

    The kind is the name and version of what it must hold, `make` the class of the answer, a
    dataclass; `instead` and `again` are the file to give in place of another one, and the remedy if
    this one is damaged; `known` are fields that the file lacks.

    Raises MissingLibraryError if h5py is not installed, DataFileError if the file is missing,
    damaged or of another kind.
    """
    name = kind.rpartition(" ")[0]
    try:
        with sealed_hdf5(path) as file:
            if file.attrs.get("format") != kind:
                raise DataFileError(f"{path} is not a {name}; give {instead}.")
            return _read(file, make, known)
    except (OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise DataFileError(f"{path} cannot be read as a {name} ({error}); {again}.") from error


def kind_of_file(path: str | Path) -> str:
    """Return what a file holds, without its version; "" if `write_answer` did not write it.

    Raises MissingLibraryError without h5py, and DataFileError if the file cannot be read.
    """
    try:
        with sealed_hdf5(path) as file:
            return str(file.attrs.get("format", "")).rpartition(" ")[0]
    except (OSError, RuntimeError, ValueError) as error:
        raise DataFileError(f"{path} cannot be read as an answer ({error}).") from error


def _write(group: Any, whole: Any, compression: int | None) -> None:
    for field in fields(whole):
        name, value = field.name, getattr(whole, field.name)
        if isinstance(value, np.ndarray):
            group.create_dataset(name, data=value, compression=compression if value.size else None)
        elif is_dataclass(value) and not isinstance(value, Scene):
            _write(group.create_group(name), value, compression)
        else:
            plain = scene_document(value) if isinstance(value, Scene) else value
            group.attrs[name] = json.dumps(plain)


def _read(group: Any, make: type[Made], known: dict[str, Any]) -> Made:
    values, kinds = dict(known), get_type_hints(make)
    for field in fields(make):  # type: ignore[arg-type]
        name, kind = field.name, kinds[field.name]
        if name in known:
            continue
        if name in group.attrs:
            value = json.loads(group.attrs[name])
            if kind is Scene and '{"function": ' in group.attrs[name]:
                raise DataFileError(
                    "the file holds the answer of a scene with Python functions, which no file "
                    "can contain; give the scene as well: sf.load(path, scene)."
                )
            values[name] = scene_from_document(value) if kind is Scene else value
        elif name in group and not hasattr(group[name], "shape"):
            held = {*group[name], *group[name].attrs}
            (part,) = (  # the one of several classes that has such fields
                part
                for part in (kind, *get_args(kind))
                if hasattr(part, "__dataclass_fields__")
                and held <= {known.name for known in fields(part)}
            )
            # a companion is of the same scene
            given = {named.name: known[named.name] for named in fields(part) if named.name in known}
            values[name] = _read(group[name], part, given)
        elif name in group:
            # no deflated array is a thousandth of its size; one that was never written holds none
            if group[name].nbytes > 1100 * (group[name].id.get_storage_size() + 1000):
                raise ValueError(f"{name} has {group[name].nbytes:.3g} bytes, more than the file")
            values[name] = group[name][()]
    return make(**values)
