"""Where slip zones end and when slip begins, predicted and simulated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from compare.comparison.measures import NOTHING, onset_time, sampled_zones
from compare.comparison.rows import ZONE_CELLS, Row, comparison_row, element_over_length
from compare.comparison.scales import slip_rate_scale, speed_regime
from semianalytic import SlipZone, Solution

if TYPE_CHECKING:
    from fem import Simulation

PROBES = (0.25, 0.5, 0.75)
SLIP_THRESHOLD = NOTHING


def zone_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Velocities in c_t of all zone edges, except 0, infinity and the P front, an arrival.

    Edges of the simulation are read off its final slip rate alone.  What the same reading makes
    of the predicted slip rate at the same nodes shows its bias, which is taken off; edges that it
    does not find there, of zones narrower than the mesh, are left out.
    """
    contact, scene = simulation.interface, solution.scene
    time, shear_speed = contact.t[-1], scene.material.shear_speed
    cell = simulation.element_size / time
    threshold = SLIP_THRESHOLD * slip_rate_scale(scene)
    simulated, predicted = (
        sampled_zones(contact.x / time, slip_rate, threshold)
        for slip_rate in (contact.slip_rate[-1], solution.slip_rate(contact.x, time))
    )
    for number, zone in enumerate(solution.zones, start=1):
        seen, expected = (_closest_zone(zone, zones) for zones in (simulated, predicted))
        for end in ("inner", "outer"):
            edge = getattr(zone, end)
            if not 0 < edge < math.inf or speed_regime(edge, scene.material) == "at c_l":
                continue
            if expected is None or not abs(getattr(expected, end) - edge) <= ZONE_CELLS * cell:
                continue
            shift = math.inf if seen is None else getattr(seen, end) - getattr(expected, end)
            yield comparison_row(
                f"zone {number}, {end} edge",
                edge / shear_speed,
                (edge + shift) / shear_speed if math.isfinite(shift) else None,
                ZONE_CELLS * element_over_length(simulation),
                "zone edges: two elements, 2 h / (c_t T)",
                "c_t",
            )


def onset_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Times in T at which slip is first seen at all at three probe points.

    Both records are read at the times of the simulation and with the same threshold, 1e-6 V₀.
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
            f"first slip (1e-6 V₀) at x = {place / length:.2f} c_t T",
            None if predicted is None else predicted / end,
            None if seen is None else seen / end,
            2 * element_over_length(simulation),
            "first slip: two elements at c_t, 2 h / (c_t T)",
            "T",
        )


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
