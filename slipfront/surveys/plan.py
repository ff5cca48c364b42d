"""The plan of a survey: its parameters, options, and the chunks that are solved and saved whole."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from importlib.metadata import version
from itertools import product
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.answer import FIELDS
from semianalytic.results.memory import check_memory
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import among, checked_count, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.scene import Scene
from slipfront.surveys.parameters import checked_subject, checked_values, parameter_name

Region = tuple[slice, ...]

SWEPT, SOLVED, PAIRS, MARCHED, RUN = 2500, 100, 20, 4, 1
"""Default points per chunk for scenes that are swept together, solved one by one, of two bodies, or
marched, and for interfaces.  Each kind of chunk takes seconds on one core."""
_SWEPT_TOGETHER = {"poisson_ratio": 100, "friction": 25}
"""Shape of a chunk in the plane of Poisson ratio and friction.

It is long in Poisson ratio, along which zones change less.  Processor time for 10,000 points grows
in the order of chunks of 100 x 25, 67 x 34, 50 x 50 and 25 x 100."""


MOST_VALUES, MOST_POINTS, MOST_CHUNKS = 10**7, 10**8, 10**5
"""Largest number of values of a parameter, of points of a survey, and of its chunks.

A hundred million points take a day on one core; laying out a hundred thousand chunks takes seconds
and some 100 MB."""
_POINT_BYTES = 250
"""Largest memory per point without fields: 115 as a dataset, 223 while writing NetCDF [bytes]."""
_NUMBER_BYTES = 20
"""Largest memory per number of a field [bytes].

A number takes 8 as a dataset, 10 while NetCDF is written, and 18 in a chunk while it is solved and
packed."""


@dataclass(frozen=True)
class Question:
    """Options that hold at every point of a survey; they are the arguments of `survey`."""

    rtol: float | None = None
    end_time: float | None = None
    nodes: int | None = None
    length: float | None = None
    x: tuple[float, ...] = ()
    t: tuple[float, ...] = ()
    fields: tuple[str, ...] = ()

    def checked(self, of_interface: bool = False) -> Question:
        """Return all options in their final form; SceneError if one is out of range.

        An interface has positions of either sign, and onsets and speeds at x without times.
        """
        changes: dict[str, Any] = {}
        for name in ("rtol", "end_time", "length"):
            if getattr(self, name) is not None:
                changes[name] = checked_size(f"survey: {name}", getattr(self, name))
        if self.nodes is not None:
            changes["nodes"] = checked_count("survey: nodes", self.nodes, 1, "a whole number from")
        if of_interface and not self.x and self.t:
            raise SceneError("survey: t are times of fields at positions; give x as well.")
        if not of_interface and bool(self.x) != bool(self.t):
            raise SceneError("survey: fields are given at positions and times; give x and t.")
        if not all(map(math.isfinite, (*self.x, *self.t))):
            raise SceneError("survey: x and t must be finite numbers.")
        if not of_interface and not all(x > 0 for x in self.x):
            raise SceneError("survey: x must be positions on the contact, x > 0.")
        unknown = [name for name in self.fields if not among(name, FIELDS)]
        if unknown:
            raise SceneError(
                f"survey: fields must be some of {', '.join(FIELDS)}, got {shown(unknown[0])}."
            )
        if self.t and self.end_time is None and max(self.t) > 0 and not of_interface:
            changes["end_time"] = max(self.t)
        return replace(self, **changes)


@dataclass(frozen=True, eq=False)
class SurveyPlan:
    """A survey: a scene, the values of its parameters, and its options."""

    scene: Scene
    values: Mapping[str, Array]  # mapping of parameter to (n,) array
    # parameters that replace those of the scene by one value at all points
    fixed: Mapping[str, float]
    together: bool  # whether the values are one list of points instead of a grid
    question: Question
    chunk: int  # largest number of points in a chunk

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions by name."""
        if self.together:
            return {"point": len(next(iter(self.values.values())))}
        return {name: len(values) for name, values in self.values.items()}

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    @property
    def count(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @cached_property
    def block(self) -> dict[str, int]:
        """Number of points of a chunk along each dimension; the last chunk may be shorter."""
        sizes, room = self.sizes, self.chunk
        block = dict.fromkeys(sizes, 1)
        scale = math.sqrt(self.chunk / SWEPT)
        plane = [name for name in _SWEPT_TOGETHER if name in sizes]
        if len(plane) == 2:
            name = plane[0]
            parts = max(round(sizes[name] / (scale * _SWEPT_TOGETHER[name])), 1)
            block[name] = min(math.ceil(sizes[name] / parts), room)
        for name in [*reversed(plane), *plane, *(n for n in reversed(sizes) if n not in plane)]:
            free = room // math.prod(length for key, length in block.items() if key != name)
            block[name] = max(block[name], min(sizes[name], free))
        return {
            name: math.ceil(sizes[name] / math.ceil(sizes[name] / length))
            for name, length in block.items()
        }

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        pairs = zip(self.sizes.values(), self.block.values(), strict=True)
        return math.prod(math.ceil(size / length) for size, length in pairs)

    @cached_property
    def regions(self) -> list[Region]:
        """The chunks, each as slices along the dimensions."""
        cuts = [
            [slice(start, min(start + self.block[name], size)) for start in range(0, size, step)]
            for (name, size), step in zip(self.sizes.items(), self.block.values(), strict=True)
        ]
        return list(product(*cuts))

    def region_values(self, region: Region) -> dict[str, Array]:
        """Return the values of all parameters at the points of a chunk, each (m,), in C order."""
        if self.together:
            return {name: values[region[0]] for name, values in self.values.items()}
        parts = [values[part] for values, part in zip(self.values.values(), region, strict=True)]
        meshes = np.meshgrid(*parts, indexing="ij")
        return {name: mesh.ravel() for name, mesh in zip(self.values, meshes, strict=True)}

    @cached_property
    def document(self) -> dict[str, Any]:
        """The scene as text and numbers."""
        return scene_document(self.scene)

    @cached_property
    def identity(self) -> dict[str, Any]:
        """Properties that distinguish this survey from others, ready for JSON."""
        return {
            "slipfront": version("slipfront"),
            "scene": self.document,
            "fixed": dict(self.fixed),
            "together": self.together,
            "parameters": {
                name: {
                    "count": len(values),
                    "first": float(values[0]),
                    "last": float(values[-1]),
                    "sha256": hashlib.sha256(values.tobytes()).hexdigest(),
                }
                for name, values in self.values.items()
            },
            "chunk": self.chunk,
            **asdict(self.question),
        }

    def check_memory(self) -> None:
        """Refuse a survey that needs more memory than there is, and say what to ask for instead."""
        asked = self.question
        numbers = len(asked.fields) * len(asked.x) * len(asked.t)
        each = _POINT_BYTES + _NUMBER_BYTES * numbers
        fields = f" of {numbers:,} numbers" if numbers else ""
        least = math.prod(self.block.values())
        advice = "ask for fewer positions and times"
        if least > 1:
            advice += ", or lower `chunk`"
        what = f"survey: a chunk of {least:,} points{fields}"
        check_memory(each * least, None, what, advice)
        advice = "ask for less, or for parts of the values, each in a file of its own"
        check_memory(each * self.count, None, f"survey: {self.count:,} points{fields}", advice)

    @property
    def digest(self) -> str:
        """Hash of the identity, 16 hexadecimal digits."""
        text = json.dumps(self.identity, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @property
    def call(self) -> str:
        """The survey as a call of `survey`, with long arrays of values abbreviated."""
        given = [f"{name}={_row(values)}" for name, values in self.values.items()]
        given += [f"{name}={value!r}" for name, value in self.fixed.items()]
        options = {"together": self.together, **asdict(self.question)}
        given += [f"{name}={value!r}" for name, value in options.items() if value]
        return f"survey(scene, {', '.join(given)})"


def _row(values: Array) -> str:
    if len(values) <= 4:
        return str(values.tolist())
    return f"[{values[0]:.10g}, {values[1]:.10g}, ... {values[-1]:.10g}] ({len(values)})"


def planned(
    scene: Scene | str | PathLike[str],
    parameters: Mapping[str, ArrayLike],
    question: Question,
    *,
    together: bool = False,
    chunk: int | None = None,
) -> SurveyPlan:
    """Plan a survey; parameters with a single number are fixed.

    SceneError is raised if there is no such parameter, no parameter has several values, lists that
    go together differ in length, or an option is out of range.
    """
    scene = checked_subject(scene)
    of_interface = bool(scene.on_line)
    if of_interface and question.length is not None:
        raise SceneError("survey: length is for a slot; the line has a `period`.")
    values: dict[str, Array] = {}
    fixed: dict[str, float] = {}
    for given, row in parameters.items():
        name = parameter_name(scene, given)
        if name in values or name in fixed:
            raise SceneError(f"survey: {name} is given twice; leave one of the two out.")
        numbers = checked_values(name, row)
        if numbers.ndim:
            values[name] = numbers
            _check_count(f"values of {name}", len(numbers), MOST_VALUES)
        else:
            fixed[name] = float(numbers)
    if not values:
        raise SceneError("survey: give values of at least one parameter, such as friction.")
    lengths = {name: len(row) for name, row in values.items()}
    if together and len(set(lengths.values())) > 1:
        listed = ", ".join(f"{length} of {name}" for name, length in lengths.items())
        raise SceneError(f"survey: lists that vary together must have equal lengths, got {listed}.")
    points = _usual_chunk(scene, list(values)) if chunk is None else chunk
    points = checked_count("survey: chunk", points, 1, "a whole number from")
    question = question.checked(of_interface)
    if of_two_bodies(scene, parameters) and (question.nodes or question.length):
        raise SceneError(
            "survey: nodes and length are for marches, and two different bodies are solved "
            "exactly; leave them out."
        )
    plan = SurveyPlan(scene, values, fixed, together, question, points)
    _check_count("points", plan.count, MOST_POINTS)
    if plan.chunks > MOST_CHUNKS:
        raise SceneError(
            f"survey: {plan.chunks:.3g} chunks are too many; raise `chunk` to "
            f"{math.ceil(points * plan.chunks / MOST_CHUNKS):,}, or ask for fewer points."
        )
    return plan


def of_two_bodies(scene: Scene, names: Iterable[str]) -> bool:
    """Return whether a survey of a scene over parameters is of two different bodies."""
    lower = any(name.startswith("lower_") for name in names)
    return not scene.on_line and (lower or scene.lower_material is not None)


def _check_count(what: str, count: int, most: int) -> None:
    """Raise SceneError if there are more values or points than a survey can have."""
    if count > most:
        raise SceneError(f"survey: {count:.3g} {what} are too many; take at most {most:.0e}.")


def _usual_chunk(scene: Scene, names: Sequence[str]) -> int:
    if bool(scene.on_line):
        return RUN
    if of_two_bodies(scene, names):
        return PAIRS
    if not scene.is_self_similar or scene.law.fall_with_rate:
        return MARCHED
    return SWEPT if set(_SWEPT_TOGETHER) & set(names) else SOLVED
