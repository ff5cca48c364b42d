"""Slip rate and tractions along the interface at one time, predicted and simulated."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from compare.comparison.measures import in_profile, is_nothing
from compare.comparison.rows import (
    EDGE_CELLS,
    NO_SLIP,
    ZONE_CELLS,
    Row,
    element_over_length,
    error_row,
    nothing_row,
)
from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.comparison.snapshots import SlipRateProfile
from semianalytic import Solution

if TYPE_CHECKING:
    from fem import Simulation


def slip_rate_rows(solution: Solution, simulation: Simulation) -> Iterator[Row]:
    """Relative errors of the slip rate at the final time, or its largest value where none slips.

    None slips either where zones end below 0.02 c_t T.

    Prediction and simulation are the norms of the slip rate over 0.02 < x / (c_t t) < 1.9; the
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
    predicted = solution.slip_rate(profile.x[shown], profile.time)
    if is_nothing(predicted, scale):
        # zones so narrow that none reaches here may be seen wider by what edges may be off
        reach = max((zone.outer for zone in solution.zones), default=0.0)
        shown &= profile.x > reach * profile.time + ZONE_CELLS * simulation.element_size
        predicted = solution.slip_rate(profile.x[shown], profile.time)
        yield nothing_row(quantity, predicted, profile.slip_rate[shown], scale, NO_SLIP, "V₀")
        return
    for order in orders:
        yield error_row(
            quantity,
            predicted,
            profile.slip_rate[shown],
            velocity[shown],
            tolerance=_slip_rate_tolerance(solution, simulation, order),
            unit="V₀",
            scale=scale,
            order=order,
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
    scale = stress_scale(scene)
    for quantity, predict, record in (
        ("shear traction", solution.shear_traction, history.shear_traction),
        ("pressure", solution.pressure, history.pressure),
    ):
        predicted, simulated = predict(place, time), record[-1, shown]
        if is_nothing(predicted, scale):
            reason = f"no {quantity}: what the simulation has of it is rounding, below 1e-6 τ₀"
            yield nothing_row(quantity, predicted, simulated, scale, reason, "τ₀")
            continue
        yield error_row(
            quantity,
            predicted,
            simulated,
            place,
            tolerance=(
                element_over_length(simulation),
                "tractions: error of first order, h / (c_t T), as of an edge half an element off",
            ),
            unit="τ₀",
            scale=scale * np.ptp(place),
        )


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
