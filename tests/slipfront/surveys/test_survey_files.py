"""Surveys on the disk: whole or not at all, gone on with, the same whoever solved them."""

import os
import re
import signal
import subprocess

import pytest
import xarray
from catalogue import PRELOADED
from faults import FULL, ROOT, flip_bits, full_disk, randomness, start

from semianalytic.scene.errors import DataFileError
from slipfront.surveys import run, survey
from slipfront.surveys.run import store_folder

VALUES = {"friction": [0.1, 0.3, 0.9], "poisson_ratio": [0.2, 0.4], "base_pressure": [1.0, -1.0]}
CHUNK = 4
CHUNKS = 4
"""Number of chunks of the survey of these values."""


def interrupted_after(chunks, path):
    """Interrupt the survey once so many chunks are done."""
    calls = []

    def progress(done, count):
        calls.append(done)
        if len(calls) == chunks:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        asked(path, progress=progress)


def asked(path=None, **options):
    """The survey of these tests, in memory, without what depends on the machine."""
    data = survey(PRELOADED, path=path, chunk=CHUNK, **{"workers": 1, **VALUES, **options})
    return plain(data)


def plain(data):
    data = data.load().drop_vars("seconds")
    for name, variable in data.variables.items():
        if variable.dtype.kind in "OTU":
            data[name] = variable.dims, variable.values.astype(object), variable.attrs
    return data[sorted(map(str, data.data_vars))]


@pytest.fixture(scope="module")
def known():
    """What it is in memory."""
    return asked()


@pytest.mark.thinned(2)
@pytest.mark.parametrize("together", [False, True])
def test_files_hold_the_survey_with_units_and_statuses(together, tmp_path, known):
    """Lists and single numbers stay coordinates."""
    values = VALUES
    if together:
        values = {"friction": [0.1, 0.2, -1.0], "poisson_ratio": [0.3, 0.4, 0.1]}
        values |= {"load_shear": 0.9, "together": True}
        known = plain(survey(PRELOADED, chunk=CHUNK, workers=1, **values))
    data = survey(PRELOADED, path=tmp_path / "a.nc", chunk=CHUNK, workers=1, **values)
    assert plain(data).identical(known)
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as found:
        assert plain(found).identical(known)
        assert found.edges.attrs["units"] == "length/time"
        assert values.keys() - {"together"} <= set(found.coords)
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    refused = [status for status in known.status.values.ravel() if status != "converged"]
    assert all(re.match("(scene: base pressure|Coulomb: friction) must", case) for case in refused)
    assert refused


def test_an_interrupted_survey_goes_on(tmp_path, known, monkeypatch):
    path = tmp_path / "a.nc"
    interrupted_after(2, path)
    assert [path.name for path in tmp_path.iterdir()] == [store_folder(path).name]
    kept = sorted(store_folder(path).glob("*.npz"))
    assert len(kept) == 2
    data = bytearray(kept[0].read_bytes())
    data[100] ^= 1
    kept[0].write_bytes(data)  # a chunk that is damaged is solved again
    solved = []
    whole = run.run_tasks
    monkeypatch.setattr(
        run, "run_tasks", lambda tasks, *a, **k: solved.append(len(tasks)) or whole(tasks, *a, **k)
    )
    assert asked(path).identical(known)
    assert solved == [CHUNKS - 1]
    assert asked(path).identical(known)  # what is there is read
    assert solved == [CHUNKS - 1]
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


def test_another_survey_is_refused(tmp_path):
    path = tmp_path / "a.nc"
    interrupted_after(1, path)
    with pytest.raises(DataFileError, match="part of another survey") as raised:
        asked(path, rtol=1e-5)
    assert "\n" not in str(raised.value)
    asked(path)
    with pytest.raises(DataFileError, match="holds something else"):
        asked(path, rtol=1e-5)
    path.write_bytes(b"not a survey")
    with pytest.raises(DataFileError, match="cannot be read as a survey"):
        asked(path)


def test_flipped_bits_of_a_finished_survey_are_refused(tmp_path, shown, refused):
    """Formerly 28 of 200 such files ended in a traceback, and 4 were other data without a word."""
    path = tmp_path / "a.nc"
    line = f"survey preloaded --friction 0.2,0.4 --workers 1 -q --output {path}"
    shown(line)
    data = path.read_bytes()
    for seed in range(12):
        rng = randomness(seed)
        path.write_bytes(flip_bits(data, rng.choice([1, 1, 8]), rng))
        assert refused(line, 3).startswith(f"{path} cannot be read as a survey (")
    path.write_bytes(data)
    shown(line)


KILLED = """
import sys
import slipfront as sf
sys.path.insert(0, "tests/slipfront/surveys")
from test_survey_files import PRELOADED as SCENE, VALUES, CHUNK
def say(done, count):
    print(done, flush=True)
sf.survey(SCENE, path=sys.argv[1], chunk=CHUNK, workers=int(sys.argv[2]), progress=say, **VALUES)
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_survey_goes_on(number, tmp_path, known):
    """Its processes end with it; a program needs no guard against being run again by them."""
    path = tmp_path / "a.nc"
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "tests")}
    process = start(KILLED, path, 1 if number == signal.SIGINT else 2, env=environment)
    assert process.stdout.readline() == f"{CHUNK}\n"
    process.send_signal(number)
    process.communicate(timeout=120)
    assert process.returncode
    assert list(store_folder(path).glob("*.npz"))
    assert asked(path).identical(known)
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


@pytest.mark.slow
def test_a_program_without_a_guard_is_not_run_again(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import slipfront as sf\n"
        "print('begun')\n"
        "data = sf.survey('preloaded', friction=[0.1, 0.2], chunk=1, workers=2)\n"
        "print(data.sizes['friction'])\n"
    )
    shown = subprocess.run(
        [os.sys.executable, str(script)], capture_output=True, text=True, check=False, timeout=120
    )
    assert (shown.stdout, shown.returncode) == ("begun\n2\n", 0), shown.stderr


@pytest.mark.thinned(2)
@pytest.mark.parametrize("how", FULL)
def test_a_full_disk_loses_nothing_finished(how, tmp_path, known):
    with full_disk(how, tmp_path) as (folder, make_room):
        path = folder / "a.nc"
        with pytest.raises(DataFileError, match=r"^Cannot write .*\.$"):
            asked(path)
        assert not path.exists()
        make_room()
        assert asked(path).identical(known)


def test_one_run_at_a_time(tmp_path):
    path = tmp_path / "a.nc"

    def again(done, count):
        with pytest.raises(DataFileError, match="another run is writing"):
            asked(path)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        asked(path, progress=again)
