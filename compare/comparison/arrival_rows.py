"""Speeds of the Rayleigh, S and P signals along both faces, predicted and simulated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from compare.comparison.arrivals import (
    Waveform,
    Window,
    aligned_speed,
    front_window,
    roughness,
    smeared,
)
from compare.comparison.rows import Row, comparison_row
from compare.comparison.scales import slip_rate_scale, stress_scale, wave_speeds
from semianalytic import Solution

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

LEAST_ROUGHNESS = 1e-3


def arrival_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Speeds in c_t of the Rayleigh, S and P signals on the interface and on the slot face.

    On each face a signal is followed in the field whose predicted waveform is roughest there,
    relative to the reference stress or slip rate, at the last time at which the surroundings of
    the front are still on the recorded part of the face.
    """
    fronts = wave_speeds(solution.scene.material)
    edges = [e for z in solution.zones for e in (z.inner, z.outer) if 0 < e < math.inf]
    for face, others, fields in (
        ("interface", edges, _interface_fields(solution, simulation)),
        ("slot face", [], _slot_fields(solution, simulation)),
    ):
        for signal, front in fronts.items():
            window = front_window(front, {*fronts.values(), *others} - {front})
            yield _arrival_row(f"{signal} arrival on the {face}", window, fields, simulation)


def _arrival_row(
    quantity: str, window: Window, fields: Sequence[_Field], simulation: Simulation
) -> Row:
    shear_speed = simulation.scene.material.shear_speed
    time = fields[0].last_time(window.upper)
    cell = simulation.element_size / (shear_speed * time)
    # Damping C = eta K spreads a front over sqrt(eta t) in time, eta = damping h / c_t.
    width = window.front * math.sqrt(simulation.damping * cell)
    waveforms = [smeared(field.predict, window, width) for field in fields]
    samples = window.samples()
    strength = [roughness(waveform(samples), samples) for waveform in waveforms]
    strongest = int(np.argmax(strength))
    tolerance = (2 * cell, f"arrivals: two elements over c_t t, 2 h / (c_t t), at t = {time:.3g}")
    if strength[strongest] < LEAST_ROUGHNESS:
        return comparison_row(quantity, None, None, *tolerance, "c_t")
    field = fields[strongest]
    speed = aligned_speed(*field.record(time), waveforms[strongest], window)
    return comparison_row(
        f"{quantity} ({field.name})",
        window.front / shear_speed,
        None if speed is None else speed / shear_speed,
        *tolerance,
        "c_t",
    )


@dataclass(frozen=True)
class _Field:
    """A field on one face over its reference value: what was recorded and what is expected.

    Attributes
    ----------
    name : str
    distance : (n,) array
        From the edge [length], increasing.
    time : (m,) array
        [time].
    values : (m, n) array
    predict : callable
        Expected values at similarity velocities [length / time].
    """

    name: str
    distance: Array
    time: Array
    values: Array
    predict: Waveform

    def last_time(self, velocity: float) -> float:
        """Last recorded time at which what travels at a velocity is still on the record."""
        there = self.time[velocity * self.time <= self.distance[-1]]
        return float(there[-1])

    def record(self, time: float) -> tuple[Array, Array]:
        """Similarity velocities and values at a recorded time."""
        return self.distance / time, self.values[np.searchsorted(self.time, time)]


def _interface_fields(solution: Solution, simulation: Simulation) -> tuple[_Field, ...]:
    contact, scene = simulation.interface, solution.scene
    stress, rate = stress_scale(scene), slip_rate_scale(scene)
    return tuple(
        _Field(name, contact.x, contact.t, values / scale, _over(predict, scale))
        for name, values, predict, scale in (
            ("shear traction", contact.shear_traction, solution.shear_traction, stress),
            ("pressure", contact.pressure, solution.pressure, stress),
            ("slip rate", contact.slip_rate, solution.slip_rate, rate),
        )
    )


def _slot_fields(solution: Solution, simulation: Simulation) -> tuple[_Field, ...]:
    slot, rate = simulation.slot, slip_rate_scale(solution.scene)
    outward = np.argsort(-slot.x)

    def component(index: int) -> Callable[[Array, float], Array]:
        return lambda x, t: solution.slot_velocity(-x, t)[index]

    return tuple(
        _Field(
            name, -slot.x[outward], slot.t, values[:, outward] / rate, _over(component(index), rate)
        )
        for index, (name, values) in enumerate((("v_x", slot.velocity_x), ("v_y", slot.velocity_y)))
    )


def _over(predict: Callable[[Array, float], Array], scale: float) -> Waveform:
    """Waveform over similarity velocity, in units of a reference value."""
    return lambda velocity: predict(velocity, 1.0) / scale
