"""Slip beside stuck edges that a grid does not show, and what is read and saved of runs."""

import errno

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.engine.beside_edges import EdgeNodes
from semianalytic.results import files

SOLID = sf.Material(1.0, 1.0, 1 / 3)


def pushed(friction, **others):
    """A contact x > 0 beside a slot of which the faces are pushed."""
    slot = [sf.InterfaceLoad(1.0, on="slot")]
    contact = sf.Contact.half_line()
    return scene_along(SOLID, sf.Coulomb(friction), 16.0, loads=slot, contact=contact, **others)


@pytest.mark.parametrize("friction", [8.0, pytest.param(12.0, marks=pytest.mark.slow)])
def test_slip_that_no_node_shows_is_an_error_of_all_slip(friction):
    scene = sf.Scene(SOLID, friction, sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 1.0))
    solution = sf.solve(scene)
    (zone,) = solution.zones
    done = sf.solve(pushed(friction), end_time=1.0, nodes=512, times=[1.0])
    assert not done.interface.slip[:, done.interface.touching].any()
    assert done.error_estimates["slip"] == done.error_estimates["slip_rate"] == 1.0
    length, area = EdgeNodes(done).missed_slip
    assert length == pytest.approx(zone.outer, rel=0.1)
    assert f"slips next to an edge over about {length:.2g}" in done.status
    needed = int(done.status.split("use ")[1].split()[0])
    assert sf.solve(pushed(friction), end_time=1.0, nodes=needed, times=[1.0]).status == "done"
    x = zone.outer * (np.arange(400) + 0.5) / 400
    exact = 2 * float(solution.slip(x, 1.0).sum()) * zone.outer / 400  # at both ends
    assert area == pytest.approx(exact, rel=0.25)


def test_edges_that_slip_and_laws_that_never_stick_miss_nothing():
    slips = sf.solve(pushed(3.0), end_time=1.0, nodes=512, times=[1.0])
    whole = sf.solve(scene_along(SOLID, sf.Coulomb(0.5), 8.0), end_time=0.5, nodes=64)
    assert EdgeNodes(slips).missed_slip == EdgeNodes(whole).missed_slip == (0.0, 0.0)


def patch(even):
    """A patch that slips at once, and spreads."""
    load = sf.InterfaceLoad(lambda x: 1.0 * (abs(x) < 1))
    return scene_along(
        sf.Material(1, 1, 0.25), sf.Coulomb(0.5), 16.0, shear=0.1, loads=[load], even=even
    )


def test_rupture_speed_is_from_the_nearest_origin_on_any_grid():
    speeds = [
        sf.solve(patch(e), end_time=3.0, nodes=256, estimate=False).rupture_speed
        for e in (True, False)
    ]
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-9)
    assert speeds[0] == pytest.approx(0.3153, abs=1e-4)


def test_estimates_of_traction_do_not_hang_on_the_stored_frames():
    stored = [
        sf.solve(patch(True), end_time=3.0, nodes=256, times=at) for at in ([0.0, 3.0], [3.0])
    ]
    errors = [level.error_estimates["shear_traction"] for level in stored]
    assert max(errors) < 0.02


def test_a_run_that_cannot_be_saved_leaves_the_earlier_file(tmp_path, monkeypatch):
    done = sf.solve(patch(True), end_time=0.5, nodes=64, estimate=False)
    path = tmp_path / "run.h5"
    done.save(path)

    def full(*given):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(files.os, "replace", full)
    with pytest.raises(sf.DataFileError, match="No space left"):
        done.save(path)
    monkeypatch.undo()
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]
    assert sf.Marched.load(path, done.scene).interface.slip == pytest.approx(done.interface.slip)
