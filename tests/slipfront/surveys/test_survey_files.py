"""Surveys on the disk: whole or not at all, gone on with, the same whoever solved them."""

import os
import signal
import subprocess

import pytest
import xarray
from faults import FULL, ROOT, flip_bits, full_disk, randomness, start

import slipfront as sf
from semianalytic.scene.errors import DataFileError
from slipfront.cli.commands import main
from slipfront.surveys import run, survey
from slipfront.surveys.store import store_folder

SCENE = sf.find_scene("preloaded")
VALUES = {"friction": [0.1, 0.3, 0.9], "poisson_ratio": [0.2, 0.4], "base_pressure": [1.0, -1.0]}
CHUNK = 4
CHUNKS = 4
"""Number of chunks of the survey of these values."""


class Stop(Exception):
    """An interruption."""


def stop_after(chunks):
    calls = []

    def progress(done, count):
        calls.append(done)
        if len(calls) == chunks:
            raise Stop

    return progress


def asked(path=None, **options):
    """The survey of these tests, in memory, without what depends on the machine."""
    data = survey(SCENE, path=path, chunk=CHUNK, **{"workers": 1, **VALUES, **options})
    return plain(data)


def plain(data):
    data = data.load().drop_vars("seconds")
    for name, one in data.variables.items():
        if one.dtype.kind in "OTU":
            data[name] = one.dims, one.values.astype(object), one.attrs
    return data[sorted(map(str, data.data_vars))]


@pytest.fixture(scope="module")
def known():
    """What it is in memory."""
    return asked()


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["a.nc", "a.zarr"])
def test_files_hold_the_survey_with_units_and_statuses(name, tmp_path, known):
    path = tmp_path / name
    data = survey(SCENE, path=path, chunk=CHUNK, workers=1, **VALUES)
    assert plain(data).identical(known)
    engine = {"a.nc": "h5netcdf", "a.zarr": "zarr"}[name]
    with xarray.open_dataset(path, engine=engine) as found:
        assert plain(found).identical(known)
        assert found.edges.attrs["units"] == "length/time"
    assert [one.name for one in tmp_path.iterdir()] == [name]
    refused = known.status.sel(base_pressure=-1.0).values.ravel()
    assert all(status.startswith("scene: base pressure must not") for status in refused)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["a.nc", "a.zarr"])
def test_lists_and_single_numbers_stay_coordinates(name, tmp_path):
    values = {"friction": [0.1, 0.2, -1.0], "poisson_ratio": [0.3, 0.4, 0.1], "load_shear": 0.9}
    known = plain(survey(SCENE, together=True, workers=1, **values))
    survey(SCENE, together=True, workers=1, path=tmp_path / name, **values)
    engine = {"a.nc": "h5netcdf", "a.zarr": "zarr"}[name]
    with xarray.open_dataset(tmp_path / name, engine=engine) as found:
        assert plain(found).identical(known)
        assert {"friction", "poisson_ratio", "load_shear"} <= set(found.coords)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["a.nc", "a.zarr"])
def test_an_interrupted_survey_goes_on(name, tmp_path, known, monkeypatch):
    path = tmp_path / name
    with pytest.raises(Stop):
        asked(path, progress=stop_after(2))
    assert [one.name for one in tmp_path.iterdir()] == [store_folder(path).name]
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
    assert [one.name for one in tmp_path.iterdir()] == [name]


def test_another_survey_is_refused(tmp_path):
    path = tmp_path / "a.nc"
    with pytest.raises(Stop):
        asked(path, progress=stop_after(1))
    with pytest.raises(DataFileError, match="part of another survey") as raised:
        asked(path, rtol=1e-5)
    assert "\n" not in str(raised.value)
    asked(path)
    with pytest.raises(DataFileError, match="holds something else"):
        asked(path, rtol=1e-5)
    path.write_bytes(b"not a survey")
    with pytest.raises(DataFileError, match="cannot be read as a survey"):
        asked(path)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["a.nc", "a.zarr"])
def test_flipped_bits_of_a_finished_survey_are_refused(name, tmp_path, capsys):
    """Formerly 28 of 200 such files ended in a traceback, and 4 were other data without a word."""
    path, line = tmp_path / name, "survey preloaded --friction 0.2,0.4 --workers 1 -q --output"
    assert main([*line.split(), str(path)]) == 0
    files = [one for one in sorted(path.rglob("*")) if one.is_file()] or [path]
    capsys.readouterr()
    for seed in range(12):
        rng = randomness(seed)
        file = rng.choice(files)
        data = file.read_bytes()
        file.write_bytes(flip_bits(data, rng.choice([1, 1, 8]), rng))
        assert main([*line.split(), str(path)]) == 3
        said = capsys.readouterr()
        assert (said.out, said.err.count("\n")) == ("", 1)
        assert said.err.startswith(f"{path} cannot be read as a survey (")
        file.write_bytes(data)
    assert main([*line.split(), str(path)]) == 0


@pytest.mark.slow
def test_processes_make_no_difference(tmp_path, known):
    assert asked(tmp_path / "a.nc", workers=2).identical(known)


KILLED = """
import sys
import slipfront as sf
sys.path.insert(0, "tests/slipfront/surveys")
from test_survey_files import SCENE, VALUES, CHUNK
def say(done, count):
    print(done, flush=True)
sf.survey(SCENE, path=sys.argv[1], chunk=CHUNK, workers=int(sys.argv[2]), progress=say, **VALUES)
"""


@pytest.mark.thinned(2)
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
    assert [one.name for one in tmp_path.iterdir()] == ["a.nc"]


@pytest.mark.slow
def test_a_program_without_a_guard_is_not_run_again(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import slipfront as sf\n"
        "print('begun')\n"
        "data = sf.survey(sf.find_scene('preloaded'), friction=[0.1, 0.2], chunk=1, workers=2)\n"
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
        raise Stop

    with pytest.raises(Stop):
        asked(path, progress=again)


def test_what_is_done_is_told_in_points(tmp_path):
    told = []
    asked(tmp_path / "a.zarr", progress=lambda *two: told.append(two))
    assert told == [(4, 12), (8, 12), (10, 12), (12, 12)]
