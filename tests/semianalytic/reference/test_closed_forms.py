"""Closed forms where they end: ahead of the zone, at the contact edge, off the contact."""

import numpy as np
import pytest

from semianalytic import Material, SceneError
from semianalytic.reference import (
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
    slip_rate_without_friction,
)

MATERIAL = Material(1.0, 1.0, 1 / 3)


def test_nothing_slips_ahead_of_the_zone_and_most_at_the_contact_edge():
    edge = edge_speed_under_shear_step(MATERIAL, 1.0)
    rate = slip_rate_under_shear_step(MATERIAL, 1.0, 1.0, [0.0, 0.5 * edge, edge, 1.1 * edge])
    assert rate[2] == rate[3] == 0.0
    assert rate[0] > rate[1] > 0


@pytest.mark.parametrize(
    "slip_rate",
    [
        lambda velocity: slip_rate_under_shear_step(MATERIAL, 1.0, 1.0, velocity - 1e-9),
        lambda velocity: slip_rate_under_remote_shock(MATERIAL, 1.0, 1.0, 0.5, velocity),
        lambda velocity: slip_rate_without_friction(MATERIAL, 1.0, velocity),
    ],
)
def test_velocities_off_the_contact_are_refused(slip_rate):
    with pytest.raises(SceneError, match="x/t must be"):
        slip_rate(np.array([0.5, 0.0]))
