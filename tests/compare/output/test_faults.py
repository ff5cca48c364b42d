"""Faults of disks and files: nothing is half-written, nothing damaged is read without a word."""

import os
import shutil

import numpy as np
import pytest
from fault_tasks import history
from faults import (
    FULL,
    all_kinds,
    as_nobody,
    flip_bits,
    full_disk,
    identity_of,
    open_folder,
    randomness,
    start,
)

from compare.figures.saving import save_figure
from compare.output.places import LOCK, check_file, save_somewhere, working_folder, write_text
from fem import simulate
from semianalytic.results.files import check_seal, new_file, whole_hdf5
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import find_scene

NAMES = (
    "history",
    "march",
    "run",
    "simulation",
    "checkpoint",
    "mesh",
    "snapshot",
    "index",
    "chart",
)


@pytest.fixture(scope="module")
def kinds():
    found = all_kinds()
    assert tuple(found) == NAMES
    return found


def write_picture(folder):
    from matplotlib.figure import Figure

    figure = Figure()
    figure.subplots().imshow(np.random.default_rng(1).normal(size=(50, 50)))
    save_figure(figure, folder / "picture.png")


def content(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "filler"}


@pytest.mark.thinned(2)
@pytest.mark.parametrize("how", FULL)
@pytest.mark.parametrize("name", [*(n for n in NAMES if n != "index"), "text", "picture"])
def test_a_full_disk_leaves_what_was_there_and_says_what_is_needed(name, how, kinds, tmp_path):
    others = {
        "text": lambda folder: write_text(folder / "text", "long " * 10_000),
        "picture": write_picture,
    }
    write = others[name] if name in others else kinds[name].write
    path = "text" if name == "text" else "picture.png" if name in others else kinds[name].path
    with full_disk(how, tmp_path) as (folder, make_room):
        (folder / path).write_text("what was there before")
        with pytest.raises(DataFileError, match=r"[\d,]+ bytes are needed in .* and [\d,]+ are"):
            write(folder)
        assert content(folder) == {path: b"what was there before"}
        make_room()
        write(folder)
        assert content(folder)[path] != b"what was there before"


def test_the_message_counts_free_bytes_without_the_file_itself(tmp_path):
    how = "disk" if "disk" in FULL else "limit"
    with full_disk(how, tmp_path) as (folder, _), pytest.raises(DataFileError) as caught:
        write_text(folder / "text", "x" * 100_000)
    assert "100,000 bytes are needed" in str(caught.value)
    assert how == "limit" or "8,192 are free" in str(caught.value)


def test_a_result_that_does_not_fit_is_kept_elsewhere(tmp_path, monkeypatch):
    spare = tmp_path / "spare"
    spare.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(spare))
    (tmp_path / "taken").write_text("")
    with pytest.raises(DataFileError, match=r"Cannot write .*taken.*; the result is kept in"):
        save_somewhere(history().save, tmp_path / "taken" / "a.h5", "a.h5")
    (kept,) = spare.rglob("a.h5")
    assert identity_of(InterfaceHistory.load(kept)) == identity_of(history())


@pytest.mark.parametrize("name", NAMES)
def test_flipped_bits_are_refused_or_change_nothing(name, kinds, tmp_path):
    """All files that are not refused read as if nothing was; a mesh is built again."""
    kind, rng, refused = kinds[name], randomness(1), 0
    kind.write(tmp_path)
    path = tmp_path / kind.path
    intact, sound = path.read_bytes(), identity_of(kind.read(path))
    for trial in range(16):
        cut = intact[: rng.randrange(len(intact))] if trial % 8 == 7 else flip_bits(intact, 3, rng)
        path.write_bytes(cut)
        try:
            assert identity_of(kind.read(path)) == sound
        except DataFileError:
            refused += 1
    assert refused == 0 if name == "mesh" else refused > 12


@pytest.mark.parametrize("name", ["history", "march", "run", "simulation", "checkpoint"])
def test_a_file_without_its_seal_is_refused(name, kinds, tmp_path):
    kinds[name].write(tmp_path)
    path = tmp_path / kinds[name].path
    path.write_bytes(path.read_bytes()[: path.read_bytes().rindex(b"\nslipfront sha256")])
    with pytest.raises(DataFileError, match="lost its checksum"):
        kinds[name].read(path)


def test_other_programs_still_read_sealed_files(kinds, tmp_path):
    import h5py
    import meshio

    for name in ("march", "mesh", "snapshot"):
        kinds[name].write(tmp_path)
        check_seal(tmp_path / kinds[name].path)
    with h5py.File(tmp_path / "march.h5") as file:
        assert file["interface/slip"].shape[1] == 40
    mesh = tmp_path / kinds["mesh"].path
    assert len(meshio.read(mesh).points) == kinds["mesh"].read(mesh)[0].shape[1]
    assert len(meshio.read(tmp_path / "last.vtu").points) == 2 * 41 * 11


@pytest.mark.parametrize("name", NAMES)
def test_no_permission_is_one_clear_error_and_leaves_nothing(name, kinds):
    with open_folder() as folder:
        (folder / "closed").mkdir(mode=0o555)
        with as_nobody(), pytest.raises(DataFileError, match=r"Permission denied"):
            kinds[name].write(folder / "closed")
        assert not list((folder / "closed").iterdir())
        kinds[name].write(folder)
        (folder / kinds[name].path).chmod(0)
        with as_nobody(), pytest.raises(DataFileError):
            kinds[name].read(folder / kinds[name].path)


def test_places_without_permission_are_refused_before_anything(tmp_path):
    refusal = r"Cannot write .*Permission denied"
    with open_folder() as folder:
        closed = folder / "closed"
        closed.mkdir(mode=0o555)
        with as_nobody():
            for place in ("a.h5", "new/a.h5"):
                with pytest.raises(DataFileError, match=refusal):
                    check_file(closed / place)
            for place in (".", "new", "new/new"):
                with pytest.raises(DataFileError, match=refusal), working_folder(closed / place):
                    raise AssertionError
        assert not list(closed.iterdir())


def test_a_folder_that_vanishes_is_made_again_or_named(tmp_path):
    folder = tmp_path / "a" / "b"
    with working_folder(folder):
        shutil.rmtree(tmp_path / "a")
        history().save(folder / "history.h5")
    assert [path.name for path in folder.iterdir()] == ["history.h5"]
    with (
        pytest.raises(DataFileError, match=r"Cannot write .*text: No such file"),
        new_file(folder / "text"),
    ):
        shutil.rmtree(tmp_path / "a")
    assert not (tmp_path / "a").exists()


def test_a_vanished_working_directory_is_one_sentence(tmp_path):
    gone = tmp_path / "gone"
    gone.mkdir()
    code = (
        "import os, shutil, sys; from slipfront.cli.commands import main;"
        "os.chdir(sys.argv[1]); os.rmdir(sys.argv[1]);"
        "sys.exit(main(['solve', 'ramp', '--nodes', '40', '--save', 'a.h5']))"
    )
    process = start(code, gone)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 3
    assert errors.count("\n") == 1
    assert "Cannot write a.h5" in errors


def test_checkpoints_go_on_when_their_folder_vanishes_and_the_clock_goes_back(
    tmp_path, monkeypatch
):
    """The time of day runs backwards by an hour with every look."""
    scene, path, now = find_scene("preloaded"), tmp_path / "run" / "checkpoint.h5", [2e9]
    whole = simulate(scene, resolution=16)

    def earlier(*_):
        now[0] -= 3600.0
        return now[0]

    def vanish(step, steps):
        if step == 10:
            shutil.rmtree(path.parent)

    monkeypatch.setattr("time.time", earlier)
    monkeypatch.setattr("time.time_ns", lambda: int(1e9 * earlier()))
    simulate(scene, resolution=16, checkpoint=path, checkpoint_seconds=1e-9, progress=vanish)
    assert path.exists()
    resumed = simulate(scene, resolution=16, checkpoint=path, resume=True)
    assert identity_of(resumed.interface) == identity_of(whole.interface)
    assert all(seconds >= 0 for seconds in resumed.seconds.values())


@pytest.mark.parametrize("time", [-1e9, 4e9])
def test_dates_of_files_from_a_wrong_clock_change_nothing(time, tmp_path, kinds, monkeypatch):
    kinds["mesh"].write(tmp_path)
    path = tmp_path / kinds["mesh"].path
    sound, built = identity_of(kinds["mesh"].read(path)), path.stat().st_ino
    os.utime(path, (time, time))
    assert identity_of(kinds["mesh"].read(path)) == sound
    assert path.stat().st_ino == built
    leftover = tmp_path / ".text.0123456789ab.part"
    leftover.write_text("of a killed writer")
    os.utime(leftover, (time, time))
    write_text(tmp_path / "text", "new")
    assert not leftover.exists()


def test_writers_in_the_same_process_do_not_meet(tmp_path):
    path = tmp_path / "a.h5"
    with whole_hdf5(path) as left, whole_hdf5(path) as two:
        left["x"], two["x"] = 1, 2
    with new_file(path) as first:
        with new_file(path) as second:
            second.write_text("second")
        assert first.exists()
        first.write_text("first")
    assert content(tmp_path) == {"a.h5": b"first"}


def test_a_folder_is_written_by_one_run_at_a_time(tmp_path):
    folder = tmp_path / "run"
    with working_folder(folder):
        for _ in range(2):
            with (
                pytest.raises(DataFileError, match=r"another run is writing to .*run"),
                working_folder(folder),
            ):
                raise AssertionError
        assert [path.name for path in folder.iterdir()] == [LOCK]
    assert not folder.exists()
    with working_folder(folder):
        (folder / "result").write_text("")
    assert [path.name for path in folder.iterdir()] == ["result"]


def test_the_lock_of_a_folder_that_was_made_again_is_left_alone(tmp_path):
    folder = tmp_path / "run"
    with working_folder(folder):
        shutil.rmtree(folder)
        with working_folder(folder):
            (folder / "result").write_text("")
    assert [path.name for path in folder.iterdir()] == ["result"]
    shutil.rmtree(folder)
    first = working_folder(folder)
    first.__enter__()
    shutil.rmtree(folder)
    with working_folder(folder):
        first.__exit__(None, None, None)
        assert (folder / LOCK).exists()


@pytest.mark.parametrize(
    ("name", "refusal"),
    [
        ("/dev/null", SceneError),
        (".", SceneError),
        ("/proc/none/a.h5", DataFileError),
        ("x" * 300, DataFileError),
        ("taken/a.h5", DataFileError),
    ],
)
def test_places_that_cannot_be_written_are_found_out(name, refusal, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("")
    with pytest.raises(refusal, match=r"Cannot write|is a folder|is not an ordinary file"):
        check_file(type(tmp_path)(name))
    with pytest.raises(DataFileError, match="Cannot write"):
        history().save(name)
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
    assert os.path.exists("/dev/null")
    assert not os.path.isfile("/dev/null")


def test_links_stay_links(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "there" / "text")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "there" / "text").read_text() == "new"
