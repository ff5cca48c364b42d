"""Disks that get full before, during and after a run, and folders that several runs share."""

import json
import shutil
from contextlib import ExitStack, contextmanager
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from catalogue import PRELOADED as SCENE
from faults import FULL, ROOM, full_disk, small_disk

from compare.comparison.fields.frames import last_frame
from fem import simulate
from fem.checkpoint import Keeper
from fem.results import load_simulation
from fem.settings import Pace
from semianalytic.results.files import check_seal
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.commands import main
from tests.fem.runs import FIELDS, interrupted

SMALL = {"resolution": 16, "frames": 4}


@pytest.fixture(autouse=True)
def _wide_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")


@pytest.fixture(scope="module")
def whole(mesh_cache, tmp_path_factory):
    """The run that nothing happens to."""
    return simulate(SCENE, **SMALL, snapshots=tmp_path_factory.mktemp("whole"))


def assert_same_history(left, other):
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(left.interface, name), getattr(other.interface, name))


def command(folder, *options):
    resolution = () if "--resolution" in options else ("--resolution", "16")
    return main(["simulate", "preloaded", *resolution, "--output", str(folder), *options])


def sentence(capsys):
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert "Traceback" not in captured.err
    return captured.err


def listed(folder):
    entries = ElementTree.parse(folder / "fields.pvd").getroot().iter("DataSet")
    return [entry.get("file") for entry in entries]


@contextmanager
def disk_that_fills(how, folder):
    """A folder with room, what takes that room away, and what gives it back."""
    if how == "disk":
        with small_disk(4 << 20) as place:
            yield place, lambda: fill_up(place), (place / "filler").unlink
        return
    with ExitStack() as limited:
        yield folder, lambda: limited.enter_context(full_disk("limit", folder)), limited.close


def fill_up(place):
    (place / "filler").write_bytes(bytes(shutil.disk_usage(place).free - ROOM))


def call_at(moment, action):
    """Progress that does something once so many steps are done."""
    return lambda step, steps: action() if step == moment else None


# --- before the run ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ((), "simulate: field snapshots need about"),
        (("--no-snapshots",), "simulate: the histories need about"),
        (("--no-snapshots", "--checkpoint-every", "5"), "simulate: "),
    ],
)
def test_run_without_room_is_refused_before_it_starts(options, what, tmp_path, monkeypatch, capsys):
    room = {"simulate: field snapshots need about": 10**6}.get(what, 10**4)
    monkeypatch.setattr("fem.budget.free_space", lambda folder: room)
    monkeypatch.setattr("fem.run.build", None)  # nothing is assembled
    out = tmp_path / "out"
    assert command(out, "--quiet", "--resolution", "60", *options) == 3
    told = sentence(capsys)
    assert what in told
    assert str(out) in told
    assert "MB are free" in told
    assert not out.exists()


# --- during the run ---------------------------------------------------------------------------


@pytest.mark.parametrize("how", FULL)
def test_snapshots_that_find_no_room_end_no_run(how, whole, tmp_path):
    told = []
    with disk_that_fills(how, tmp_path) as (folder, fill, _):
        progress = call_at(whole.steps // 2 + 1, fill)
        run = simulate(SCENE, **SMALL, snapshots=folder, progress=progress, tell=told.append)
        assert listed(folder) == ["fields-0001.vtu", "fields-0002.vtu"]
        assert last_frame(folder, run.run).time == pytest.approx(0.5, abs=run.time_step)
        left = {path.name for path in folder.iterdir()} - {"filler"}
        assert left == {"fields.pvd", *listed(folder)}  # nothing half-written
        for name in left:
            check_seal(folder / name)
    assert_same_history(run, whole)
    assert told == [run.unwritten]
    assert "snapshots from t = 0.75" in run.unwritten
    assert "bytes are needed" in run.unwritten


def test_snapshots_leave_room_for_the_histories(whole, tmp_path, monkeypatch):
    monkeypatch.setattr("fem.snapshots.free_space", lambda folder: 1000)
    with pytest.warns(UserWarning, match="would leave no room"):
        run = simulate(SCENE, **SMALL, snapshots=tmp_path)
    assert_same_history(run, whole)
    assert listed(tmp_path) == []
    assert [path.name for path in tmp_path.iterdir()] == ["fields.pvd"]
    assert "snapshots from t = 0.25" in run.unwritten


def test_command_keeps_the_histories_and_says_which_snapshots_are_missing(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr("fem.snapshots.free_space", lambda folder: 1000)
    assert command(tmp_path, "--quiet") == 3
    captured = capsys.readouterr().err.splitlines()
    assert "snapshots from t" in captured[-1]
    assert load_simulation(tmp_path).unwritten in captured[-1]


@pytest.mark.parametrize("how", FULL)
def test_checkpoint_that_finds_no_room_ends_no_run(how, whole, tmp_path):
    told = []
    with disk_that_fills(how, tmp_path) as (folder, fill, make_room):
        kept = {"checkpoint": folder / "checkpoint.h5", "checkpoint_every": 10}
        progress = call_at(15, fill)
        run = simulate(SCENE, resolution=16, **kept, progress=progress, tell=told.append)
        make_room()
        seen = []
        again = simulate(
            SCENE, resolution=16, **kept, resume=True, progress=lambda *entry: seen.append(entry[0])
        )
    assert "checkpoint.h5" in told[0]
    assert seen[0] == 11  # the checkpoint before is there and sound
    assert_same_history(run, again)


def test_checkpoint_wanted_now_is_an_error_if_it_cannot_be_written(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    keeper = Keeper(tmp_path / "file" / "checkpoint.h5", Pace(), {})
    empty = SimpleNamespace(step=3, frames=(), parts={})
    monkeypatch.setattr("fem.checkpoint.take_checkpoint", lambda *state: empty)
    with pytest.raises(DataFileError, match="Cannot write"):
        keeper.step_done(3, SimpleNamespace(steps=9), None, [], True)
    keeper.step_done(100, SimpleNamespace(steps=999), None, [], False)
    assert "Cannot write" in keeper.missing


# --- after the run ----------------------------------------------------------------------------


@pytest.mark.skipif("disk" not in FULL, reason="small file systems can be mounted by root only")
def test_history_that_finds_no_room_is_kept_elsewhere(whole, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("fem.budget.check_room", lambda *given: None)
    monkeypatch.setattr("fem.run.check_room", lambda *given: None)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with full_disk("disk", tmp_path) as (folder, _):
        assert command(folder, "--no-snapshots", "--quiet") == 3
        told = sentence(capsys)
        assert not (folder / "simulation.h5").exists()
        assert not [path for path in folder.iterdir() if path.name != "filler"]
    kept = told.split(" is kept in ")[1].split(" instead")[0]
    assert load_simulation(kept).steps == whole.steps


# --- one folder, several runs -----------------------------------------------------------------


def test_fewer_frames_leave_none_of_the_run_before(tmp_path):
    simulate(SCENE, resolution=12, frames=6, snapshots=tmp_path)
    simulate(SCENE, **SMALL, snapshots=tmp_path)
    assert sorted(path.name for path in tmp_path.glob("*.vtu")) == listed(tmp_path)


def test_frame_put_in_from_another_run_is_refused(tmp_path):
    simulation = simulate(SCENE, **SMALL, snapshots=tmp_path / "one")
    simulate(SCENE, **SMALL, damping=0.05, snapshots=tmp_path / "other")
    shutil.copy(tmp_path / "other" / "fields-0004.vtu", tmp_path / "one")
    with pytest.raises(DataFileError, match="of another run"):
        last_frame(tmp_path / "one", simulation.run)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_report_and_figures_go_with_the_simulation_they_belong_to(tmp_path):
    main(["compare", "preloaded", "--resolution", "16", "--output", str(tmp_path), "--quiet"])
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["finite_elements"]["run"] == load_simulation(tmp_path).run
    (tmp_path / "mine.png").write_text("")
    assert command(tmp_path, "--quiet") == 0  # the same run once more
    assert (tmp_path / "report.json").is_file()
    assert (tmp_path / "interface.png").is_file()
    (tmp_path / "snapshots" / "mine.txt").write_text("notes")
    (tmp_path / "snapshots" / "fields-mine.vtu").write_text("not a frame of slipfront")
    assert command(tmp_path, "--quiet", "--no-snapshots", "--end-time", "0.9") == 0
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {"mine.png", "simulation.h5", "snapshots"}
    left = {path.name for path in (tmp_path / "snapshots").iterdir()}
    assert left == {"mine.txt", "fields-mine.vtu"}


def test_another_run_leaves_a_checkpoint_alone(whole, tmp_path, capsys):
    path = tmp_path / "checkpoint.h5"
    options = {"resolution": 18, "checkpoint": path, "checkpoint_every": 10}
    interrupted(find_scene("preloaded"), 15, **options)
    assert command(tmp_path, "--no-snapshots", "--quiet") == 0
    assert path.is_file()
    given = ("--no-snapshots", "--quiet", "--resolution", "18", "--resume")
    assert command(tmp_path, *given, "--checkpoint-every", "10") == 0
    assert not path.exists()
    assert "to resume from" not in capsys.readouterr().err
    assert command(tmp_path, *given) == 0
    assert f"there is no {path} to resume from; it starts at t = 0" in capsys.readouterr().err


def test_resumed_run_says_which_of_its_snapshots_are_gone(whole, tmp_path):
    path, fields = tmp_path / "checkpoint.h5", tmp_path / "fields"
    options = {**SMALL, "checkpoint": path, "checkpoint_every": 1, "snapshots": fields}
    interrupted(SCENE, int(0.6 * whole.steps) + 1, **options)
    (fields / "fields-0001.vtu").unlink()
    with pytest.warns(UserWarning, match="1 of the 2 snapshots"):
        run = simulate(SCENE, **options, resume=True)
    assert_same_history(run, whole)
    assert listed(fields) == [f"fields-000{number}.vtu" for number in (2, 3, 4)]
    assert "1 of the 2 snapshots" in run.unwritten
