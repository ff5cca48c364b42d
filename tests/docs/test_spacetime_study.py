"""Studies of the space-time solver: what they claim, on small grids."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import unit_scene

from compare.comparison.measures import relative_error
from semianalytic import Ramp, solve
from semianalytic.reference import StaticZone, static_zone
from semianalytic.scene.given.named import NAMED_SCENES


def test_static_zone_closes_smoothly():
    """Slip ends with zero slope, starts at 4 (1 - nu)/pi strength length/mu."""
    zone = StaticZone(0.4, 0.3, 2.0 / 0.75)
    x = np.linspace(1e-9, 0.3, 2001)
    slip = zone.slip(x)
    assert slip[0] == pytest.approx(4 * 0.75 / (np.pi * 2) * 0.4 * 0.3, rel=1e-6)
    assert slip[-1] == 0
    assert abs(slip[-2] / (x[-1] - x[-2])) < 0.02 * slip[0] / 0.3
    assert (np.diff(slip) < 0).all()


def slip_of_a_ramp(rise_time, nodes=400):
    """Return the L1 difference of slip at t = 1 from that of the static zone, over the latter."""
    scene = replace(NAMED_SCENES["ramp"].scene, shear_history=Ramp(rise_time))
    static = static_zone(scene, 1.0)
    length = float(np.clip(4 * static.length, 0.4, 2.0))
    marched = solve(
        scene,
        method="space-time",
        end_time=1.0,
        nodes=nodes,
        length=length,
        every=10**9,
        estimate=False,
    )
    x = marched.interface.x
    return relative_error(marched.interface.slip[-1], static.slip(x), x, 1)


@pytest.mark.slow
def test_slow_ramps_approach_the_static_near_field():
    """Measured 13.5, 6.0, 1.4 and 0.4 % in slip for rise times of 1, 4, 16, 64 at 1,500 nodes."""
    slips = [slip_of_a_ramp(rise_time) for rise_time in (1.0, 4.0, 16.0)]
    assert slips[0] > 2 * slips[1] > 4 * slips[2]
    assert slips[-1] < 0.03


def test_friction_work_peaks_at_intermediate_friction():
    """No friction, no work; more friction, less slip: the largest work lies between."""
    slips, works = [], []
    for chi in (0.0, 0.2, 0.6, 2.0):
        scene = unit_scene(chi)
        marched = solve(
            scene,
            method="space-time",
            end_time=1.0,
            nodes=150,
            length=2.0,
            every=10**9,
            estimate=False,
        )
        slips.append(marched.final_path.sum() * marched.spacing)
        works.append(marched.final_work_density.sum() * marched.spacing)
    assert works[0] == 0
    assert slips == sorted(slips, reverse=True)
    assert works.index(max(works)) == 2
