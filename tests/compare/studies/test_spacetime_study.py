"""Studies of the space-time solver: what they claim, on small grids."""

import numpy as np
import pytest
from catalogue import unit_scene

from docs.studies.accuracy import spacetime
from docs.studies.accuracy.march_fields import field_errors
from docs.studies.accuracy.spacetime import (
    accuracy,
    cost,
    edge,
    memory,
    ramp_errors,
    resolution,
)
from semianalytic import march
from semianalytic.reference import StaticZone
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


@pytest.mark.slow
def test_slow_ramps_approach_the_static_near_field():
    """Measured 13.5, 6.0, 1.4 and 0.4 % in slip for rise times of 1, 4, 16, 64 at 1,500 nodes."""
    slips = [ramp_errors(rise_time, 400).slip for rise_time in (1.0, 4.0, 16.0)]
    assert slips[0] > 2 * slips[1] > 4 * slips[2]
    assert slips[-1] < 0.03


@pytest.mark.slow
def test_edge_table_names_the_grids_own_edge_best():
    errors = [row.error for row in edge()]
    assert errors[0] < 1e-4
    assert min(errors[1:]) > 100 * errors[0]


def test_field_errors_fall_with_the_grid():
    scene = NAMED_SCENES["antiplane"].scene
    coarse, fine = (field_errors(scene, nodes, points=40) for nodes in (32, 64))
    assert all(2 * after < before for before, after in zip(coarse, fine, strict=True))
    assert max(fine) < 3e-3


@pytest.mark.slow
def test_rows_of_accuracy_cost_memory_and_resolution(monkeypatch):
    for name, value in {
        "GRIDS": (64, 128),
        "COST_GRIDS": (64, 128),
        "TOLERANCES": (1e-3, 1e-6),
        "FINEST": 330,
        "MEMORY_NODES": 128,
        "STEPS_PER_PERIOD": (16, 32),
        "NODES_IN_ZONE": (1, 2),
    }.items():
        monkeypatch.setattr(spacetime, name, value)
    monkeypatch.setattr(spacetime, "_timed", lambda run, repeats=3: (1.0, run()))
    rows = accuracy()
    assert [(row.scene, row.nodes) for row in rows[:2]] == [("preloaded", 64), ("preloaded", 128)]
    assert len(rows) == 6
    assert rows[1].order == pytest.approx(np.log2(rows[0].error / rows[1].error))
    assert np.isnan(rows[2].order)
    coarse, fine = cost()
    assert 3.5 < fine.past / coarse.past < 4.5
    loose, strict = memory()
    assert loose.poles < strict.poles
    assert loose.transform_error > strict.transform_error
    wave, finer_wave, zone, finer_zone = resolution()
    assert wave.study == finer_wave.study != zone.study == finer_zone.study
    assert wave.error > finer_wave.error
    assert zone.error > finer_zone.error


def test_friction_work_peaks_at_intermediate_friction():
    """No friction, no work; more friction, less slip: the largest work lies between."""
    slips, works = [], []
    for chi in (0.0, 0.2, 0.6, 2.0):
        scene = unit_scene(chi)
        marched = march(scene, 1.0, 150, length=2.0, every=10**9, companion=False)
        slips.append(marched.final_path.sum() * marched.grid.spacing)
        works.append(marched.final_work_density.sum() * marched.grid.spacing)
    assert works[0] == 0
    assert slips == sorted(slips, reverse=True)
    assert works.index(max(works)) == 2
