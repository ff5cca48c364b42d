"""Companions: runs on coarser meshes, carried by a simulation and kept in its file."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
from catalogue import SHOCK

import semianalytic as sf
from fem import companions, simulate, with_companions
from fem.results import load_simulation
from fem.run import run_plan
from semianalytic.scene.given.finding import find_scene
from tests.fem.runs import OF_CLOCK, assert_same, sheared


@pytest.fixture(scope="module")
def carrying(mesh_cache):
    return with_companions(simulate(SHOCK, resolution=40))


def assert_same_run(first, other):
    """Equal in everything but the time it took and what it carries."""
    assert_same(first, other, but=(*OF_CLOCK, "companion"))


def test_companions_are_the_run_until_a_half_and_a_quarter_of_its_end(carrying):
    """In units of length and time twice and four times as long: the scene has neither."""
    assert_same_run(carrying, simulate(SHOCK, resolution=40))
    coarse, ratio = carrying.companion, 2
    while coarse is not None:
        assert coarse.resolution == carrying.resolution / ratio
        assert coarse.steps == carrying.steps / ratio
        seen, part = coarse.interface, carrying.interface
        levels, nodes = slice(len(seen.t)), slice(len(seen.x))
        np.testing.assert_allclose(seen.x, ratio * part.x[nodes], atol=1e-12)
        for name, power in (("slip", 1), ("slip_rate", 0), ("shear_traction", 0)):
            known, expected = getattr(seen, name), ratio**power * getattr(part, name)
            np.testing.assert_allclose(known, expected[levels, nodes], atol=1e-10)
        coarse, ratio = coarse.companion, 2 * ratio
    assert ratio == 8


def test_companions_come_back_from_the_file(carrying, tmp_path):
    carrying.save(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["simulation.h5"]
    first, other = carrying, load_simulation(tmp_path)
    for _ in range(3):
        assert_same_run(first, other)
        assert first.seconds == other.seconds
        first, other = first.companion, other.companion
    assert first is other is None


def test_damaged_companion_is_an_error(carrying, tmp_path):
    carrying.save(tmp_path)
    with h5py.File(tmp_path / "simulation.h5", "a") as file:
        del file["companion/companion/state"]
    with pytest.raises(sf.DataFileError, match=r"simulation\.h5"):
        load_simulation(tmp_path)


def test_only_what_is_missing_is_run(carrying, monkeypatch):
    runs = []

    def counted(plan, *arguments, **options):
        runs.append(plan.settings.resolution)
        return run_plan(plan, *arguments, **options)

    monkeypatch.setattr(companions, "run_plan", counted)
    again = with_companions(carrying)
    assert (runs, again.companion.companion) == ([], carrying.companion.companion)
    with_companions(replace(carrying, companion=replace(carrying.companion, companion=None)))
    assert runs == [10]


def test_companions_have_the_settings_of_the_simulation():
    options = {"damping": 0.05, "step_ratio": 0.7, "end_time": 0.5}
    options |= {"model": "two-blocks"}
    simulation = with_companions(simulate(SHOCK, resolution=32, every=4, **options))
    pair = replace(SHOCK, lower_material=sf.Material(2.0, 1.0, 0.3))
    for run in (simulation, with_companions(simulate(pair, resolution=32))):
        for times, other in ((2, run.companion), (4, run.companion.companion)):
            assert (other.scene, other.resolution) == (run.scene, run.resolution / times)
            for name in ("damping", "model", "end_time"):
                assert getattr(other, name) == getattr(run, name), name
            assert other.time_step == pytest.approx(times * run.time_step)
    assert simulation.companion.interface.t[1] == pytest.approx(simulation.interface.t[1])
    run = with_companions(simulate(SHOCK, resolution=20, every=10**6))
    assert len(run.companion.interface.t) <= 3


@pytest.mark.thinned(4)
@pytest.mark.parametrize("resolution", [15, 16, 31, 32, 33])
def test_companions_end_where_meshes_would_be_too_coarse(resolution):
    run = with_companions(simulate(find_scene("stuck"), resolution=resolution))
    seen = []
    while (run := run.companion) is not None:
        seen.append(run.resolution)
    expected = [round(resolution / 2), round(resolution / 4)]
    assert seen == [mesh for mesh in expected if mesh >= 8]


@pytest.mark.thinned(2)
@pytest.mark.parametrize("history", [sf.Harmonic(2.0), sf.Pulse(0.21)])
def test_companions_need_not_follow_the_load(history):
    scene = sheared(history)
    run = with_companions(simulate(scene, resolution=40))
    assert run.companion.companion.resolution == 10
    with pytest.raises(sf.SceneError, match="faster than this mesh can follow"):
        simulate(scene, resolution=10)


def test_companions_end_where_a_coarse_mesh_cannot_be_run(monkeypatch):
    def refused(plan, *arguments, **options):
        if plan.settings.resolution < 10:
            raise sf.SceneError("friction falls faster than a node of this mesh can radiate.")
        return run_plan(plan, *arguments, **options)

    monkeypatch.setattr(companions, "run_plan", refused)
    run = with_companions(simulate(find_scene("stuck"), resolution=36))
    assert run.companion.resolution == 18
    assert run.companion.companion is None


def test_progress_is_told_and_the_coarse_mesh_is_not_complained_about(recwarn):
    steps = []
    slow = sf.Material(0.16, 1.0, 1 / 3)  # 16 elements in the simulation, 8 and 4 in companions
    run = simulate(replace(SHOCK, lower_material=slow), resolution=40)
    run = with_companions(run, lambda step, of: steps.append((step, of)))
    assert not recwarn.list
    assert run.companion.caution
    coarse, coarsest = run.companion.steps, run.companion.companion.steps
    assert steps == [(n, of) for of in (coarse, coarsest) for n in range(1, of + 1)]
