"""Runs that are killed, interrupted or go unstable, and what they leave behind."""

import dataclasses
import os
import random
import signal
import subprocess
import sys
import time
import types
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from catalogue import under
from faults import ROOT

import semianalytic as sf
from fem import simulate
from fem.checkpoint import Keeper
from fem.results import load_simulation
from fem.settings import Pace
from tests.fem.runs import MIXED, UNLOADED, assert_same, interrupted

PULSED = dataclasses.replace(
    MIXED,
    friction=sf.SlipWeakening(0.5, 0.2, 0.02),
    pressure_history=sf.Harmonic(2.0),
    shear_history=sf.Pulse(0.4, "triangle"),
)
OPTIONS = {"resolution": 24, "frames": 5}

RUN = """
import sys, time
from pathlib import Path
from fem import simulate
from tests.fem.runs import UNLOADED

def slowly(step, steps):
    time.sleep(0.005)

folder = Path(sys.argv[1])
simulate(
    UNLOADED, resolution=24, frames=5, snapshots=folder / "fields", progress=slowly,
    checkpoint=folder / "checkpoint.h5", checkpoint_every=int(sys.argv[2]), resume=True,
).save(folder)
"""


def start(folder, every):
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    command = [sys.executable, "-c", RUN, str(folder), str(every)]
    return subprocess.Popen(command, env=os.environ | {"PYTHONPATH": paths})


def wait_until_stepping(process, path):
    """Wait for a checkpoint newer than the process."""
    before = path.stat().st_mtime_ns if path.exists() else 0
    while process.poll() is None and not (path.exists() and path.stat().st_mtime_ns > before):
        time.sleep(0.001)


@pytest.mark.slow
def test_killed_runs_resume_to_the_last_bit(tmp_path):
    seed = random.SystemRandom().randrange(10**6)
    print(f"moments drawn with seed {seed}")
    draw = random.Random(seed)
    (tmp_path / "run").mkdir()
    whole = simulate(UNLOADED, **OPTIONS, snapshots=tmp_path / "whole")
    kills = 0
    while True:
        process = start(tmp_path / "run", every=draw.randint(1, 9))
        if kills == 4:
            assert process.wait() == 0
            break
        wait_until_stepping(process, tmp_path / "run" / "checkpoint.h5")
        time.sleep(draw.uniform(0, 0.1))
        process.kill()
        kills += process.wait() == -signal.SIGKILL
        if process.returncode == 0:
            break
    assert kills > 0
    assert_same(whole, load_simulation(tmp_path / "run"))
    for frame in sorted((tmp_path / "whole").iterdir()):
        assert frame.read_bytes() == (tmp_path / "run" / "fields" / frame.name).read_bytes()


@pytest.mark.slow
def test_ctrl_c_leaves_a_checkpoint_of_the_step_it_came_in(tmp_path):
    process = start(tmp_path, every=10**6)  # none would be due before the end
    while not list((tmp_path / "fields").glob("*.vtu")) and process.poll() is None:
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    assert process.wait() != 0
    seen = []
    resumed = simulate(
        UNLOADED,
        **OPTIONS,
        snapshots=tmp_path / "fields",
        checkpoint=tmp_path / "checkpoint.h5",
        resume=True,
        progress=lambda step, steps: seen.append(step),
    )
    assert seen[0] > resumed.steps // 5  # not from the beginning
    assert_same(resumed, simulate(UNLOADED, **OPTIONS, snapshots=tmp_path / "again"))


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A checkpoint in the middle of a run of the scene MIXED."""
    path = tmp_path_factory.mktemp("kept") / "checkpoint.h5"
    stop_after(path, 25)
    return path


def stop_after(path, steps, scene=MIXED, **options):
    options = {"resolution": 24, "checkpoint_every": 10, **options}
    interrupted(scene, steps, checkpoint=path, **options)


def resume(path, **changes):
    options = {"scene": MIXED, "resolution": 24, "resume": True, "checkpoint": path, **changes}
    return simulate(**options)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("options", [{}, {"model": "two-blocks"}, {"every": 7}])
def test_resumed_run_equals_an_uninterrupted_one(options, tmp_path):
    path = tmp_path / "checkpoint.h5"
    stop_after(path, 25, **options)
    assert_same(resume(path, **options), simulate(MIXED, resolution=24, **options))


@pytest.mark.thinned(2)
@pytest.mark.parametrize("law", [sf.SlipWeakening(1.0, 0.4, 0.02), sf.RateWeakening(1.0, 0.6, 1.0)])
@pytest.mark.parametrize("stopped", [11, 37])
def test_resumed_run_remembers_load_path_and_law(law, stopped, tmp_path):
    path = tmp_path / "checkpoint.h5"
    scene = under(PULSED, law)
    stop_after(path, stopped, scene)
    again = resume(path, scene=scene)
    assert_same(again, simulate(scene, resolution=24))
    assert again.final_path.max() > 0.02


def test_checkpoints_come_by_steps_or_seconds(monkeypatch):
    written = []
    monkeypatch.setattr("fem.checkpoint.take_checkpoint", lambda step, *state: step)
    monkeypatch.setattr("fem.checkpoint.write_checkpoint", lambda *given: written.append(given[2]))

    def steps_written(pace):
        times = iter(0.4 * np.arange(100))  # each look at the clock takes 0.4 s
        keeper = Keeper(Path("file"), pace, {}, clock=lambda: next(times))
        written.clear()
        for step in range(21):
            keeper.step_done(step, types.SimpleNamespace(steps=20), None, [], False)
        return written.copy()

    by_seconds = steps_written(Pace(seconds=1.0))
    either = steps_written(Pace(steps=7, seconds=1.0))
    by_steps = steps_written(Pace(steps=7))
    assert by_seconds == [3, 6, 9, 12, 15, 18]
    assert by_steps == [7, 14]
    assert either == [3, 6, 7, 10, 13, 14, 17]


def test_pace_has_a_default_and_bounds():
    assert Pace() == Pace(steps=100)
    assert Pace(seconds=5.0).steps is None
    for given in ({"steps": 0}, {"seconds": 0.0}, {"seconds": np.nan}, {"seconds": "1"}):
        with pytest.raises(sf.SceneError, match="simulate: checkpoint_"):
            Pace(**given)


def test_run_writes_a_checkpoint_as_often_as_the_clock_says(tmp_path):
    path = tmp_path / "checkpoint.h5"
    interrupted(MIXED, 9, resolution=24, checkpoint=path, checkpoint_seconds=1e-9)
    with h5py.File(path) as file:
        assert '"step": 9' in file.attrs["facts"]


def test_without_a_checkpoint_resume_starts_at_the_beginning(tmp_path):
    run = resume(tmp_path / "checkpoint.h5")
    assert_same(run, simulate(MIXED, resolution=24))


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"scene": UNLOADED}, "scene"),
        ({"scene": PULSED}, "scene"),
        ({"resolution": 25}, "resolution"),
        ({"damping": 0.03}, "damping"),
        ({"every": 2}, "every"),
        pytest.param({"mesh": "triangles"}, "mesh", marks=pytest.mark.gmsh),
        ({"scene": replace(MIXED, lower_material=sf.Material(2.0, 1.0, 0.2))}, "scene"),
    ],
)
def test_checkpoint_of_another_run_is_refused(kept, changes, named):
    with pytest.raises(
        sf.DataFileError, match=rf"checkpoint\.h5 is of another run: its {named} is"
    ):
        resume(kept, **changes)


def test_checkpoint_of_another_version_is_refused(kept, monkeypatch):
    monkeypatch.setattr("fem.checkpoint._versions", lambda: {"slipfront version": "99.0"})
    with pytest.raises(sf.DataFileError, match="slipfront version is"):
        resume(kept)


def flip_a_bit(path):
    """In the middle of the largest array."""
    with h5py.File(path, "r") as file:
        place = file["body 0/displacement"].id.get_offset() + 8 * 100
    data = bytearray(path.read_bytes())
    data[place] ^= 1
    path.write_bytes(data)


def be_foreign(path):
    with h5py.File(path, "a") as file:
        file.attrs["format"] = "something else"


@pytest.mark.parametrize("damage", [flip_a_bit, be_foreign])
def test_damaged_checkpoint_is_refused(damage, kept, tmp_path):
    """Others in compare/output/test_faults.py."""
    path = tmp_path / "checkpoint.h5"
    path.write_bytes(kept.read_bytes())
    damage(path)
    with pytest.raises(sf.DataFileError, match=r"checkpoint\.h5 .*delete it"):
        resume(path)


def test_file_in_place_of_the_folder_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(sf.DataFileError, match=r"Cannot write .*checkpoint\.h5"):
        resume(tmp_path / "file" / "checkpoint.h5", checkpoint_every=1)


def test_failed_write_keeps_the_checkpoint_before(tmp_path, monkeypatch):
    path = tmp_path / "checkpoint.h5"
    stop_after(path, 12)
    monkeypatch.setattr("os.fsync", lambda number: (_ for _ in ()).throw(OSError("disk full")))
    told = []
    run = resume(path, checkpoint_every=10, tell=told.append)
    assert told == [f"Cannot write {path}: disk full."]  # once, not at every one that was due
    monkeypatch.undo()
    whole = simulate(MIXED, resolution=24)
    assert_same(run, whole)
    assert_same(resume(path), whole)


@pytest.mark.thinned(3)
@pytest.mark.parametrize(("ratio", "damping"), [(1.05, 0.0), (1.05, 0.02), (1.3, 0.1)])
def test_unstable_run_stops_and_keeps_what_was_written(ratio, damping, tmp_path):
    path = tmp_path / "checkpoint.h5"
    reached = []
    with pytest.raises(sf.ComputationError, match=r"unstable at step \d+ of .*lower `step_ratio`"):
        simulate(
            MIXED,
            resolution=100,
            step_ratio=ratio,
            damping=damping,
            checkpoint=path,
            checkpoint_every=1,
            progress=lambda step, steps: reached.append((step, steps)),
        )
    step, steps = reached[-1]
    assert step < steps
    with h5py.File(path) as file:  # the last one before the step that was refused
        assert f'"step": {step}' in file.attrs["facts"]
        assert np.isfinite(file["body 0/displacement"][...]).all()
