"""A survey as an xarray dataset, filled chunk by chunk, and as a NetCDF file."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.families import rayleigh_family
from semianalytic.parameters.numbers import numbers_of
from semianalytic.scene.material import Material
from semianalytic.scene.units import unit
from slipfront.surveys.parameters import MATERIAL, Array
from slipfront.surveys.plan import SurveyPlan, of_two_bodies
from slipfront.surveys.points import DEFAULT_RTOL, held, unpacked
from slipfront.surveys.quantities import QUANTITIES, SPEEDS, TEXT, SurveyVariable

Chunks = Callable[[], Iterable[tuple[int, bytes]]]
"""A function that iterates over index and packed columns of every chunk, each time it is called."""


@dataclass(frozen=True)
class Variable:
    """Shape, dimensions and attributes of a variable, without its values."""

    quantity: SurveyVariable
    along: tuple[str, ...]
    shape: tuple[int, ...]
    attrs: Mapping[str, str]


def variables_of(plan: SurveyPlan, chunks: Chunks) -> dict[str, Variable]:
    """Return the variables that the chunks of a survey hold, each as large as all chunks need."""
    zones = 1
    names: set[str] = set()
    for _, data in chunks():
        some, most = held(data)
        names, zones = names | some, max(zones, most)
    question = plan.question
    lengths = {**plan.sizes, "zone": zones, "edge": 2, "mode": 2}
    lengths |= {"t": len(question.t), "x": len(question.x)}

    def variable(quantity: SurveyVariable, along: tuple[str, ...]) -> Variable:
        along = (*along, *quantity.along)
        attrs = {"units": unit(quantity.dimension, plan.scene.units)}
        attrs["long_name"] = quantity.meaning
        return Variable(quantity, along, tuple(lengths[name] for name in along), attrs)

    points = tuple(plan.sizes)
    result = {name: variable(q, points) for name, q in QUANTITIES.items() if name in names}
    for prefix in _bodies(plan):
        own = tuple(name for name in points if name in _material_of(prefix))
        varied = points if plan.together else own
        for name, quantity in SPEEDS.items():
            words = f"{quantity.meaning}{' of the lower body' if prefix else ''}"
            result[f"{prefix}{name}"] = variable(replace(quantity, meaning=words), varied)
    return result


def _bodies(plan: SurveyPlan) -> dict[str, Material]:
    """Return the bodies whose wave speeds are stored, by the prefix of their names."""
    if of_two_bodies(plan.scene, (*plan.values, *plan.fixed)):
        return dict(zip(("", "lower_"), plan.scene.bodies, strict=True))
    return {"": plan.scene.material}


def _material_of(prefix: str) -> tuple[str, ...]:
    return tuple(f"{prefix}{name}" for name in MATERIAL)


def filled(arrays: Mapping[str, Any], plan: SurveyPlan, chunks: Chunks) -> None:
    """Copy the chunks of a survey into arrays that are filled with absent values."""
    for index, data in chunks():
        region = plan.regions[index]
        shape = tuple(part.stop - part.start for part in region)
        columns = unpacked(data)
        for name, column in columns.items():
            where = region
            if QUANTITIES[name].along[:1] == ("zone",):
                where = (*region, slice(0, column.shape[1]))
            if column.size:
                arrays[name][where] = column.reshape(*shape, *column.shape[1:])


def wave_speeds(plan: SurveyPlan) -> dict[str, Array]:
    """Return the speeds of all waves [length / time] along dimensions that change the material."""
    result: dict[str, Array] = {}
    for prefix, body in _bodies(plan).items():
        result |= {f"{prefix}{name}": row for name, row in _speeds_of(plan, prefix, body).items()}
    return result


def _speeds_of(plan: SurveyPlan, prefix: str, body: Material) -> dict[str, Array]:
    """Return the speeds of the waves of one body."""
    names = _material_of(prefix)
    known = {name: getattr(body, name.removeprefix(prefix)) for name in names} | dict(plan.fixed)
    varied = [name for name in plan.values if name in names]
    rows = [plan.values[name] for name in varied]
    meshes = rows if plan.together else np.meshgrid(*rows, indexing="ij")
    shape = plan.shape if plan.together else tuple(map(len, rows))
    values = known | dict(zip(varied, meshes, strict=True))
    modulus, density, poisson_ratio = (values[name] for name in names)
    shear, ratio = np.broadcast_arrays(
        np.sqrt(np.divide(modulus, density)), np.broadcast_to(poisson_ratio, shape)
    )
    sound = (ratio > -1) & (ratio < 0.5)
    family = rayleigh_family(np.where(sound, ratio, 0.0).ravel())
    slowness = {"rayleigh": family.c, "longitudinal": family.a}
    speeds = {
        f"{name}_speed": np.where(sound, shear / inverse[:, 0].reshape(shape), np.nan)
        for name, inverse in slowness.items()
    }
    return speeds | {"shear_speed": np.where(sound, shear, np.nan)}


def coordinates(
    plan: SurveyPlan,
) -> dict[str, tuple[tuple[str, ...], NDArray[Any], dict[str, str]]]:
    """Return the coordinates by name: dimensions, values, attributes."""
    question = plan.question
    result: dict[str, tuple[tuple[str, ...], NDArray[Any], dict[str, str]]] = {}
    for name, values in plan.values.items():
        along = ("point",) if plan.together else (name,)
        result[name] = along, values, _parameter_attrs(plan, name)
    for name, value in plan.fixed.items():
        result[name] = (), np.array(value), _parameter_attrs(plan, name)
    for name, samples, meaning in (
        ("t", question.t, "time since the load"),
        ("x", question.x, "position along the contact"),
    ):
        if samples:
            dimension = "time" if name == "t" else "length"
            attrs = {"units": unit(dimension, plan.scene.units), "long_name": meaning}
            result[name] = (name,), np.array(samples), attrs
    result["edge"] = ("edge",), np.array(["inner", "outer"]), {}
    if not plan.scene.on_line:
        result["mode"] = ("mode",), np.array(["I", plan.scene.shear_mode]), {}
    return result


def _parameter_attrs(plan: SurveyPlan, name: str) -> dict[str, str]:
    """Return the unit and meaning of a parameter as attributes of its coordinate."""
    units = unit(numbers_of(plan.scene)[name].dimension, plan.scene.units)
    return {"units": units, "long_name": name.replace("_", " ")}


def attributes(plan: SurveyPlan, command: str) -> dict[str, Any]:
    """Return the attributes of the whole dataset."""
    return {
        "title": f"slipfront survey of {plan.count} points",
        "source": f"slipfront {version('slipfront')}",
        "scene": json.dumps(plan.document),
        "rtol": plan.question.rtol or (0.0 if plan.scene.on_line else DEFAULT_RTOL),
        "command": command,
        "survey": plan.digest,
    }


def dataset_of(plan: SurveyPlan, chunks: Chunks, command: str) -> Any:
    """Put the survey together as an `xarray.Dataset` in memory."""
    import xarray

    variables = variables_of(plan, chunks)
    arrays: dict[str, Any] = {}
    for name, variable in variables.items():
        kind: Any = object if variable.quantity.kind == TEXT else variable.quantity.kind
        arrays[name] = np.full(variable.shape, variable.quantity.absent, dtype=kind)
    filled(arrays, plan, chunks)
    arrays |= wave_speeds(plan)
    used = {along for own in variables.values() for along in own.along}
    return xarray.Dataset(
        {name: (own.along, arrays[name], dict(own.attrs)) for name, own in variables.items()},
        coords={
            name: parts for name, parts in coordinates(plan).items() if used.issuperset(parts[0])
        },
        attrs=attributes(plan, command),
    )


def netcdf_bytes(dataset: Any) -> Any:
    """Return a dataset as the bytes of a compressed NetCDF file.

    Text is stored as characters of fixed length.
    """
    encoding: dict[str, dict[str, Any]] = {}
    for name, variable in dataset.data_vars.items():
        if variable.ndim:
            encoding[name] = {"zlib": True, "complevel": 4, "shuffle": True}
            if variable.dtype == object:
                encoding[name] |= {"dtype": "S1", "shuffle": False}
    return dataset.to_netcdf(engine="h5netcdf", encoding=encoding)
