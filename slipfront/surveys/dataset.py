"""A survey as an xarray dataset, filled chunk by chunk, and as a NetCDF file."""

from __future__ import annotations

import json
from collections.abc import Iterable
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.families import rayleigh_family
from semianalytic.parameters.numbers import numbers_of
from semianalytic.scene.given.documents import MATERIAL
from semianalytic.scene.units import unit
from slipfront.surveys.plan import SurveyPlan, of_two_bodies
from slipfront.surveys.points import DEFAULT_RTOL, unpacked
from slipfront.surveys.quantities import QUANTITIES, SPEEDS, TEXT

Chunks = Iterable[tuple[int, bytes]]
"""Index and packed columns of every chunk."""
Variables = dict[str, tuple[tuple[str, ...], NDArray[Any], dict[str, str]]]
"""Dimensions, values and attributes of variables of a dataset, by name."""


def _filled(plan: SurveyPlan, chunks: Chunks) -> dict[str, Any]:
    """Return the arrays of all quantities that the chunks hold, absent values where none has one.

    Zones get as much room as the chunk with most of them needs.
    """
    arrays: dict[str, Any] = {}
    for index, data in chunks:
        region = plan.regions[index]
        shape = tuple(part.stop - part.start for part in region)
        for name, column in unpacked(data).items():
            own, quantity = column.shape[1:], QUANTITIES[name]
            room = np.maximum(own, 1) if own else ()
            known = arrays.get(name)
            if known is None or np.any(np.array(known.shape[len(shape) :]) < room):
                kind: Any = object if quantity.kind == TEXT else quantity.kind
                arrays[name] = np.full((*plan.shape, *room), quantity.absent, dtype=kind)
                if known is not None:
                    arrays[name][tuple(map(slice, known.shape))] = known
            place = (*region, *map(slice, own))
            arrays[name][place] = column.reshape(*shape, *own)
    return arrays


def _wave_speeds(plan: SurveyPlan) -> Variables:
    """Return the speeds of all waves along the dimensions that change the material of their body.

    Those of a different lower body begin with ``lower_``.
    """
    result: Variables = {}
    both = of_two_bodies(plan.scene, (*plan.values, *plan.fixed))
    bodies = plan.scene.bodies if both else (plan.scene.material,)
    for prefix, body in zip(("", "lower_"), bodies, strict=False):
        names = {f"{prefix}{name}": getattr(body, name) for name in MATERIAL}
        varied = {name: row for name, row in plan.values.items() if name in names}
        rows = list(varied.values())
        meshes = rows if plan.together else np.meshgrid(*rows, indexing="ij")
        shape = plan.shape if plan.together else tuple(map(len, rows))
        values = names | dict(plan.fixed) | dict(zip(varied, meshes, strict=True))
        modulus, density, poisson_ratio = (values[name] for name in names)
        shear, ratio = np.broadcast_arrays(
            np.sqrt(np.divide(modulus, density)), np.broadcast_to(poisson_ratio, shape)
        )
        sound = (ratio > -1) & (ratio < 0.5)
        family = rayleigh_family(np.where(sound, ratio, 0.0).ravel())
        slowness = {"rayleigh": family.c, "shear": None, "longitudinal": family.a}
        for name, inverse in slowness.items():
            speed = shear if inverse is None else shear / inverse[:, 0].reshape(shape)
            quantity = SPEEDS[f"{name}_speed"]
            attrs = _attrs(plan, quantity.dimension, quantity.meaning)
            attrs["long_name"] += " of the lower body" if prefix else ""
            along = tuple(plan.sizes) if plan.together else tuple(varied)
            result[f"{prefix}{name}_speed"] = along, np.where(sound, speed, np.nan), attrs
    return result


def _coordinates(plan: SurveyPlan) -> Variables:
    """Return the coordinates: parameters, positions and times of fields, edges and modes."""
    result: Variables = {}
    numbers = numbers_of(plan.scene)
    for name, values in {**plan.values, **plan.fixed}.items():
        along = () if name in plan.fixed else ("point",) if plan.together else (name,)
        attrs = _attrs(plan, numbers[name].dimension, name.replace("_", " "))
        result[name] = along, np.asarray(values), attrs
    for name, samples, dimension, meaning in (
        ("t", plan.question.t, "time", "time since the load"),
        ("x", plan.question.x, "length", "position along the contact"),
    ):
        if samples:
            result[name] = (name,), np.array(samples), _attrs(plan, dimension, meaning)
    result["edge"] = ("edge",), np.array(["inner", "outer"]), {}
    if not plan.scene.on_line:
        result["mode"] = ("mode",), np.array(["I", plan.scene.shear_mode]), {}
    return result


def _attrs(plan: SurveyPlan, dimension: str, meaning: str) -> dict[str, str]:
    """Return the attributes of a variable: its unit, and what it is."""
    return {"units": unit(dimension, plan.scene.units), "long_name": meaning}


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

    arrays, variables = _filled(plan, chunks), Variables()
    for name, quantity in QUANTITIES.items():
        if name in arrays:
            attrs = _attrs(plan, quantity.dimension, quantity.meaning)
            variables[name] = (*plan.sizes, *quantity.along), arrays[name], attrs
    variables |= _wave_speeds(plan)
    used = {along for dimensions, *_ in variables.values() for along in dimensions}
    coords = _coordinates(plan).items()
    return xarray.Dataset(
        variables,
        coords={name: parts for name, parts in coords if used.issuperset(parts[0])},
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
