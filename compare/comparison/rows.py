"""The comparison quantity by quantity: two values, a tolerance and where that comes from."""

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
from compare.comparison.measures import (
    NOTHING,
    in_profile,
    is_nothing,
    norm,
    onset_time,
    relative_error,
    slip_zones,
)
from compare.comparison.scales import slip_rate_scale, speed_regime, stress_scale, wave_speeds
from compare.comparison.snapshots import SlipRateProfile
from semianalytic import SlipZone, Solution

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

PROBES = (0.25, 0.5, 0.75)
SLIP_THRESHOLD = NOTHING
LEAST_ROUGHNESS = 1e-3
EDGE_CELLS = 4
ZONE_CELLS = 2
"""Elements by which zone edges may be off."""

NO_SLIP = "no slip: the simulation sticks exactly, rounding is below 1e-6 × 2 τ₀ / (ρ c_t)"


def shown_number(value: float | None) -> str:
    """Four decimals, two digits of what would be lost in them, a dash for nothing."""
    if value is None:
        return "—"
    return f"{value:.4f}" if value == 0 or abs(value) >= 5e-4 else f"{value:.1e}"


@dataclass(frozen=True)
class Row:
    """One quantity, predicted and simulated.

    Attributes
    ----------
    quantity : str
        What is compared, with its unit.
    prediction, simulation : float or None
        The two values; None where the signal or zone is not there.
    difference : float or None
        What is held against the tolerance; None if one of the two values is missing.
    tolerance : float
        Largest absolute difference that passes.
    reason : str
        Where the tolerance comes from.
    """

    quantity: str
    prediction: float | None
    simulation: float | None
    difference: float | None
    tolerance: float
    reason: str

    @property
    def present(self) -> bool:
        """Whether either answer holds the quantity at all."""
        return self.prediction is not None or self.simulation is not None

    @property
    def passed(self) -> bool:
        """Whether the two agree; so they do on something that is in neither."""
        if self.difference is None:
            return not self.present
        return bool(abs(self.difference) <= self.tolerance)


def comparison_row(
    quantity: str, predicted: float | None, seen: float | None, tolerance: float, reason: str
) -> Row:
    """A row whose difference is that of the two values, if both are there."""
    difference = None if predicted is None or seen is None else seen - predicted
    return Row(quantity, predicted, seen, difference, tolerance, reason)


def nothing_row(quantity: str, wanted: Array, found: Array, unit: float, reason: str) -> Row:
    """A row for a field that is predicted to be nothing (`is_nothing`): largest values over a unit.

    An error relative to the prediction would be infinite or noise; the largest difference over the
    unit is held against 1e-6 instead.
    """
    predicted, seen, difference = (
        float(np.abs(values).max(initial=0.0)) / unit for values in (wanted, found, found - wanted)
    )
    return Row(f"{quantity}, largest", predicted, seen, difference, NOTHING, reason)


def arrival_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Speeds over c_t of the Rayleigh, S and P signals on the interface and on the slot face.

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
        return comparison_row(quantity, None, None, *tolerance)
    field = fields[strongest]
    speed = aligned_speed(*field.record(time), waveforms[strongest], window)
    return comparison_row(
        f"{quantity} ({field.name})",
        window.front / shear_speed,
        None if speed is None else speed / shear_speed,
        *tolerance,
    )


def zone_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Velocities over c_t of all zone edges, except 0, infinity and the P front, an arrival.

    Edges of the simulation are read off its final slip rate alone.  What the same reading makes
    of the predicted slip rate at the same nodes shows its bias, which is taken off; edges that it
    does not find there, of zones narrower than the mesh, are left out.
    """
    history, scene = simulation.contact, solution.scene
    time, shear_speed = history.t[-1], scene.material.shear_speed
    cell, velocity = simulation.element_size / time, history.x / time
    threshold = SLIP_THRESHOLD * slip_rate_scale(scene)
    seen, expected = (
        slip_zones(velocity, slip_rate, threshold)
        for slip_rate in (
            history.slip_rate[-1],
            solution.slip_rate(history.x, time),
        )
    )
    for number, zone in enumerate(solution.zones, start=1):
        found, sampled = _closest_zone(zone, seen), _closest_zone(zone, expected)
        for end in ("inner", "outer"):
            edge = getattr(zone, end)
            if not 0 < edge < math.inf or speed_regime(edge, scene.material) == "at c_l":
                continue
            if sampled is None or not abs(getattr(sampled, end) - edge) <= ZONE_CELLS * cell:
                continue
            shift = math.inf if found is None else getattr(found, end) - getattr(sampled, end)
            yield comparison_row(
                f"zone {number}, {end} edge",
                edge / shear_speed,
                (edge + shift) / shear_speed if math.isfinite(shift) else None,
                ZONE_CELLS * element_over_length(simulation),
                "zone edges: two elements, 2 h / (c_t T)",
            )


def slip_rate_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Relative errors of the slip rate at the final time, or its largest value where none slips.

    None slips either where zones end below 0.02 c_t T.

    Prediction and simulation are the norms of slip rate / V₀ over 0.02 < x / (c_t t) < 1.9; the
    difference is the norm of their difference over that of the prediction.
    """
    history = simulation.interface
    profile = SlipRateProfile(float(history.t[-1]), history.x, history.slip_rate[-1])
    return _profile_rows("slip rate", profile, (1, 2), solution, simulation)


def snapshot_rows(
    solution: Solution, simulation: Simulation, profile: SlipRateProfile
) -> Iterator[Row]:
    """The same error in L1 for the slip rate read back from a field snapshot, at its time."""
    return _profile_rows("slip rate of the last snapshot", profile, (1,), solution, simulation)


def _profile_rows(
    quantity: str,
    profile: SlipRateProfile,
    orders: Sequence[int],
    solution: Solution,
    simulation: Simulation,
) -> Iterator[Row]:
    scene = solution.scene
    scale = slip_rate_scale(scene)
    velocity = profile.x / profile.time / scene.material.shear_speed
    shown = in_profile(velocity)
    predicted = solution.slip_rate(profile.x[shown], profile.time) / scale
    if is_nothing(predicted, 1.0):
        # zones so narrow that none reaches here may be seen wider by what edges may be off
        reach = max((zone.outer for zone in solution.zones), default=0.0)
        shown &= profile.x > reach * profile.time + ZONE_CELLS * simulation.element_size
        predicted = solution.slip_rate(profile.x[shown], profile.time) / scale
        yield nothing_row(quantity, predicted, profile.slip_rate[shown] / scale, 1.0, NO_SLIP)
        return
    seen = profile.slip_rate[shown] / scale
    for order in orders:
        yield Row(
            f"{quantity} in L{order}",
            norm(predicted, velocity[shown], order),
            norm(seen, velocity[shown], order),
            relative_error(seen, predicted, velocity[shown], order),
            *_slip_rate_tolerance(solution, simulation, order),
        )


def onset_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Times over T at which slip starts at three probe points.

    Both records are read at the times of the simulation and with the same threshold.
    """
    scene, history = solution.scene, simulation.interface
    end = history.t[-1]
    length = scene.material.shear_speed * end
    threshold = SLIP_THRESHOLD * slip_rate_scale(scene)
    later = history.t > 0
    for probe in PROBES:
        node = int(np.argmin(np.abs(history.x - probe * length)))
        place, time = history.x[node], history.t[later]
        predicted, seen = (
            onset_time(time, record, threshold)
            for record in (solution.slip_rate(place, time), history.slip_rate[later, node])
        )
        yield comparison_row(
            f"slip onset at x = {place / length:.2f} c_t T",
            None if predicted is None else predicted / end,
            None if seen is None else seen / end,
            2 * element_over_length(simulation),
            "onset times: two elements at c_t, 2 h / (c_t T)",
        )


def traction_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Relative L1 errors of shear traction and pressure at the final time.

    Prediction and simulation are the means of |traction| / τ₀ over the disturbed interface,
    without the four elements next to the edge, where tractions can be singular.  Where there is no
    traction, as without friction, the largest values are compared.
    """
    scene, history = solution.scene, simulation.interface
    time = history.t[-1]
    start = (EDGE_CELLS + 0.5) * simulation.element_size
    end = scene.material.longitudinal_speed * time
    shown = (history.x > start) & (history.x < end)
    place = history.x[shown]
    scale = stress_scale(scene) * np.ptp(place)
    for quantity, predict, record in (
        ("shear traction in L1", solution.shear_traction, history.shear_traction),
        ("pressure in L1", solution.pressure, history.pressure),
    ):
        predicted, seen = predict(place, time), record[-1, shown]
        if is_nothing(predicted, stress_scale(scene)):
            name = quantity.removesuffix(" in L1")
            reason = f"no {name}: what the simulation has of it is rounding, below 1e-6 τ₀"
            yield nothing_row(name, predicted, seen, stress_scale(scene), reason)
            continue
        yield Row(
            quantity,
            norm(predicted, place, 1) / scale,
            norm(seen, place, 1) / scale,
            relative_error(seen, predicted, place, 1),
            element_over_length(simulation),
            "tractions: error of first order, h / (c_t T), as of an edge half an element off",
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


def _closest_zone(zone: SlipZone, seen: tuple[SlipZone, ...]) -> SlipZone | None:
    """The zone of the same sense that overlaps and lies closest, edge by edge."""

    def distance(other: SlipZone) -> float:
        gaps = [
            abs(a - b)
            for a, b in ((zone.inner, other.inner), (zone.outer, other.outer))
            if math.isfinite(a) and math.isfinite(b)
        ]
        return sum(gaps)

    rivals = (
        other
        for other in seen
        if other.sense == zone.sense and other.inner < zone.outer and zone.inner < other.outer
    )
    return min(rivals, key=distance, default=None)


def element_over_length(simulation: Simulation) -> float:
    """Element size over c_t T."""
    speed = simulation.scene.material.shear_speed
    return simulation.element_size / (speed * simulation.end_time)


def _slip_rate_tolerance(
    solution: Solution, simulation: Simulation, order: int
) -> tuple[float, str]:
    """First order in h, half of it where the friction bound jumps or slip covers c_R."""
    refinement = 100 * element_over_length(simulation)
    rayleigh = simulation.scene.material.rayleigh_speed
    if simulation.scene.load.pressure != 0:
        return (
            (0.05 if order == 1 else 0.07) * math.sqrt(refinement),
            "slip rate under a pressure shock: damping smears the friction bound over √h at the "
            "fronts, 5 % in L1 and 7 % in L2 at h = 0.01 c_t T",
        )
    if any(zone.inner < rayleigh < zone.outer for zone in solution.zones):
        return (
            0.05 * math.sqrt(refinement),
            "slip rate across c_R: its logarithm there is smeared over √h, 5 % at h = 0.01 c_t T",
        )
    return (
        0.01 * refinement,
        "slip rate: first order in the mesh, 1 % at h = 0.01 c_t T",
    )
