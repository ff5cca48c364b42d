"""Junk and bombs end in one sentence, before they have taken much memory or time."""

import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from junk_files import JUNK

from compare.records.read import read_records
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables import bounds

READ = """
import sys
from compare.records.read import read_records
from semianalytic.scene.errors import DataFileError
try:
    read_records([sys.argv[1]])
except DataFileError as error:
    print(error)
    sys.exit(3)
"""
CHEAP = ("plain array", "array of objects", "zip of a false shape", "sparse HDF5", "sparse text",
         "a line without end", "brackets without end", "XML bomb")  # fmt: skip
MEMORY = 700 * 2**20
"""Bytes that reading junk may take; the largest file that is read takes 500 MB."""


def sentence_of(path):
    with pytest.raises(DataFileError) as caught:
        read_records([path])
    message = str(caught.value)
    assert "\n" not in message
    assert message.endswith(".")
    assert len(message) < 600
    return message


@pytest.mark.parametrize("what", CHEAP)
def test_junk_is_refused_in_one_sentence(what, tmp_path):
    name, write = JUNK[what]
    write(tmp_path / name)
    sentence_of(tmp_path / name)


def test_what_is_no_file_is_not_read():
    assert "is not an ordinary file" in sentence_of(Path("/dev/zero"))


@pytest.mark.slow
@pytest.mark.parametrize("what", [*JUNK, "device"])
def test_junk_takes_little_memory_and_time(what, tmp_path):
    path = Path("/dev/zero")
    if what != "device":
        name, write = JUNK[what]
        path = tmp_path / name
        write(path)

    def limited():
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))

    ran = subprocess.run(
        [sys.executable, "-c", READ, str(path)],
        capture_output=True,
        text=True,
        preexec_fn=limited,
        timeout=120,
    )
    assert (ran.returncode, ran.stderr) == (3, "")
    assert ran.stdout.count("\n") == 1


def test_rows_are_counted_before_they_are_read(tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "LARGEST_NUMBERS", 1000)
    path = tmp_path / "run.csv"
    path.write_text("t,x,slip\n" + "0,1,0\n1,1,1\n" * 150)
    read_records([path])
    path.write_text("t,x,slip\n" + "0,1,0\n1,1,1\n" * 200)
    assert "holds 1.2e+03 numbers, and at most 1e+03 are read" in sentence_of(path)
    np.savez(tmp_path / "run.npz", t=np.arange(50.0), x=np.arange(50.0), slip=np.zeros((50, 50)))
    assert "numbers, and at most" in sentence_of(tmp_path / "run.npz")


def test_stations_and_files_are_counted(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    path.write_text("t,x,slip\n" + "".join(f"{n},{n},0\n{n + 1},{n},0\n" for n in range(30)))
    monkeypatch.setattr("compare.records.stations.LARGEST_STATIONS", 20)
    assert "has 30 stations, and at most 20 are read" in sentence_of(path)
    monkeypatch.setattr("compare.records.read.MOST_FILES", 2)
    for number in range(3):
        (tmp_path / f"s{number}.csv").write_text(f"# x = {number}\nt,slip\n0,0\n1,1\n")
    assert "holds more than 2 files" in sentence_of(tmp_path)


def test_rows_of_named_fields_are_read(tmp_path):
    kind = [("t", float), ("x", float), ("slip", float)]
    np.save(tmp_path / "run.npy", np.array([(0, 1, 0), (1, 1, 2)], dtype=kind))
    (records,) = read_records([tmp_path / "run.npy"])
    assert records.stations[0].values["slip"].tolist() == [0, 2]


@pytest.mark.parametrize("form", ["{}", "{};", "{},", " {} "])
def test_rows_that_are_not_plain_are_read_one_by_one(tmp_path, form):
    rows = [(t, x, 2 * t) for t in (0.0, 0.5, 1.0) for x in (0.25, 0.5)]
    separator = ";" if ";" in form else ","
    lines = [form.format(separator.join(map(str, row))) for row in rows]
    (tmp_path / "run.csv").write_text("\n".join([separator.join(("t", "x", "slip")), *lines]))
    (records,) = read_records([tmp_path / "run.csv"])
    assert records.stations[1].values["slip"].tolist() == [0, 1, 2]
