"""Spoilt files of other codes: each ends in one sentence that names it, or is read."""

import gzip
import io
import re
import shutil
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest
from faults import flip_bits, randomness

from compare.records.read import read_records
from compare.records.record import ReadingOptions
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import DataFileError

ENTRANTS = Path(__file__).parents[2] / "data" / "entrants"
GOOD = "t,x,slip_rate\n" + "".join(f"{t},{x},{t}\n" for t in (0.0, 0.5, 1.0) for x in (0.25, 0.5))
SCEC = "t h-slip h-slip-rate\n0 0 0\n1 1 1\n"
ZEROS = np.zeros((3, 2))


def packed(save=np.savez, /, **arrays):
    file = io.BytesIO()
    save(file, **arrays)
    return file.getvalue()


def hdf5(**arrays):
    file = io.BytesIO()
    with h5py.File(file, "w") as group:
        for name, array in arrays.items():
            group[name] = array
    return file.getvalue()


T3, X2 = np.linspace(0, 1, 3), np.array([0.25, 0.5])

FILES = {
    "empty": ("run.csv", "", "no row of numbers"),
    "comments alone": ("run.csv", "# nothing\n# at all\n", "no row of numbers"),
    "header alone": ("run.csv", "t,x,slip_rate\n", "no row of numbers"),
    "text in a number": ("run.csv", GOOD.replace("0.5,0.25", "0.5,O.25"), "line 4: 'O.25' is not"),
    "stars of Fortran": ("run.csv", GOOD + "2.0,0.25,******\n", "line 8: '******' is not"),
    "row cut off": ("run.csv", GOOD[:-8], "line 7: there are"),
    "row too long": ("run.csv", GOOD + "1.5,0.25,1,2\n", "line 8: there are 4 entries where 3"),
    "two numbers in one": ("run.csv", GOOD + "1.5,0.25,1.0.0\n", "line 8: '1.0.0' is not"),
    "huge entry": ("run.csv", GOOD + "1.5,0.25," + "9x" * 9999 + "\n", "9x...' is not a number"),
    "no times": ("run.csv", GOOD.replace("t,", "step,", 1), "no column of times"),
    "no quantity": ("run.csv", GOOD.replace("slip_rate", "temperature"), "none of it is"),
    "no names": ("run.csv", "0 1 2 3 4\n1 1 2 3 4\n", "no line that names them"),
    "quantity twice": ("run.csv", "t,x,v,slip_rate\n0,1,1,1\n1,1,1,1\n", "are both slip_rate"),
    "no position": ("run.csv", SCEC.replace("h-", ""), "where its station is"),
    "position no number": ("run.csv", "# x = 1.2.3\nt,slip\n0,0\n1,1\n", "in a comment is not"),
    "strain without y": ("run.csv", "t,x,exx\n0,1,0\n", "needs its y: 1 rows are left out"),
    "slip inside a body": ("run.csv", "t,x,y,slip\n0,1,2,0\n", "where y is 0 or missing"),
    "strain of a station": ("x1.csv", "t,exx\n0,0\n", "give columns x and y"),
    "infinite": ("run.csv", "t,x,v\n0,1,0\n1,1,inf\n2,1,3\n", "infinite at x = 1, t = 1"),
    "all nan": ("run.csv", re.sub(r"[\d.]+\n", "nan\n", GOOD), "no finite number at x"),
    "times all nan": ("run.csv", re.sub(r"\n[\d.]+,", "\nnan,", GOOD), "no time at x"),
    "positions all nan": ("run.csv", "t,x,slip\n0,nan,0\n1,nan,1\n", "no row with a position"),
    "bytes in text": ("run.csv", GOOD.encode() + b"\0\1\2\n", "line 8: there are bytes"),
    "picture": ("run.csv", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "bytes that are no text"),
    "not utf-8": ("run.csv", GOOD.encode() + b"# caf\x80\n", "line 8: a character"),
    "half of a gzip": ("run.csv.gz", gzip.compress(GOOD.encode())[:40], "cannot be unpacked"),
    "rupture time alone": ("cplot.txt", "j k t\n0 0 0.1\n", "fewer than two times of rupture"),
    "rupture times damaged": ("cplot.txt", "j k t\n0 0 0.1\n1 0\n", "line 3: there are 2 entries"),
    "zip cut off": ("run.npz", packed(t=T3, x=X2, slip=ZEROS)[:200], "cannot be read"),
    "no zip": ("run.npz", b"PK but nothing else", "cannot be read"),
    "npz without times": ("run.npz", packed(x=X2, slip=ZEROS), "no array of times among x, slip"),
    "npz without positions": ("run.npz", packed(t=T3, slip=ZEROS), "no array of positions"),
    "npz without quantity": ("run.npz", packed(t=T3, x=X2, q=ZEROS), "none of it is"),
    "npz of a wrong shape": ("run.npz", packed(t=T3, x=X2, slip=np.zeros((4, 2))), "has shape"),
    "npz of words": ("run.npz", packed(t=T3, x=X2, slip=np.array([["a"] * 2] * 3)), "real numbers"),
    "npz of objects": ("run.npz", packed(t=T3, x=X2, slip=np.array([{}, {}])), "real numbers"),
    "npz with a grid of times": ("run.npz", packed(t=ZEROS, x=X2, slip=ZEROS), "one dimension"),
    "hdf5 cut off": ("run.h5", hdf5(t=T3, x=X2, slip=ZEROS)[:600], "cannot be read"),
    "no hdf5": ("run.h5", b"nothing of the kind", "cannot be read"),
    "hdf5 without data": ("run.h5", hdf5(), "no array of times among none"),
    "frame without time": ("run.vtu", "<VTKFile/>", "does not say its time"),
    "pvd that is no xml": ("run.pvd", "<VTKFile", "cannot be read"),
    "pvd without frames": ("run.pvd", "<VTKFile/>", "0 frames"),
    "entities": ("run.pvd", '<!DOCTYPE V [<!ENTITY a "b">]><V/>', "defines entities of XML"),
    "entities in UTF-16": (
        "run.pvd", '<!DOCTYPE V [<!ENTITY a "b">]><V/>'.encode("utf-16"), "defines entities"
    ),
    "pvd without times": ("run.pvd", '<V><DataSet file="a.vtu"/></V>', "lacks its timestep"),
    "pvd of nothing": ("run.pvd", '<V><DataSet timestep="0" file="a.vtu"/></V>', "a.vtu cannot be"),
    "xdmf that is none": ("run.xdmf", "<Xdmf>", "cannot be read"),
    "uguca without parts": ("run.info", "time_description a.time\n", "coord_description"),
    "uguca of one word": ("run.info", "time_description\n", "line 1: there should be 2 words"),
    "header of no fault": ("Flt01_sem2d.hdr", "NPTS\n", "is not a header of fault data"),
}  # fmt: skip


def one_sentence(error):
    """What is said of spoilt files: one line that ends."""
    message = str(error)
    assert "\n" not in message
    assert message.endswith(".")
    assert len(message) < 600
    return message


def sentence_of(paths, options=None):
    with pytest.raises(DataFileError) as caught:
        read_records(paths, options)
    return one_sentence(caught.value)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("name", "content", "words"), FILES.values(), ids=FILES)
def test_a_spoilt_file_ends_in_one_sentence(name, content, words, tmp_path):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    message = sentence_of([path])
    assert words in message
    assert str(tmp_path) in message


def test_a_good_file_is_read(tmp_path):
    (tmp_path / "run.csv").write_text(GOOD)
    assert len(read_records([tmp_path / "run.csv"])[0].stations) == 2


def test_files_that_do_not_go_together(tmp_path):
    assert "does not exist" in sentence_of([tmp_path / "run.csv"])
    assert "name at least one" in sentence_of([])
    assert "empty folder" in sentence_of([tmp_path])
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("# x = 1\n" + SCEC)
    assert "both of the station x = 1" in sentence_of([tmp_path / "a.csv", tmp_path / "b.csv"])
    (tmp_path / "run.csv").write_text(GOOD)
    assert "a run of its own" in sentence_of([tmp_path])
    assert "1 positions for 2 files" in sentence_of(["a", "b"], ReadingOptions(at=(1.0,)))


def test_columns_that_are_not_there(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(GOOD)
    assert "no column 'q'" in sentence_of([path], ReadingOptions(columns={"slip": "q"}))
    assert "cannot be 'heat'" in sentence_of([path], ReadingOptions(columns={"heat": "t"}))


def test_a_damaged_history_of_this_package(tmp_path):
    path = tmp_path / "history.h5"
    InterfaceHistory(X2, T3, *[ZEROS] * 5).save(path)
    path.write_bytes(path.read_bytes()[:-200])
    assert str(path) in sentence_of([path])


def frames(folder, points, cells, **fields):
    """A PVD file of two frames."""
    entries = ""
    for i in range(2):
        meshio.Mesh(points, cells, point_data=fields).write(folder / f"f{i}.vtu")
        entries += f'<DataSet timestep="{i}" file="f{i}.vtu"/>'
    (folder / "run.pvd").write_text(f"<VTKFile><Collection>{entries}</Collection></VTKFile>")
    return folder / "run.pvd"


SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
CELLS = [("quad", np.array([[0, 1, 2, 3]]))]


def test_meshes_without_an_interface_or_without_motion(tmp_path):
    moved = np.zeros((4, 3))
    assert "no two faces" in sentence_of(
        [frames(tmp_path, SQUARE + np.array([0, 3, 0]), CELLS, velocity=moved)]
    )
    assert "no field of velocity" in sentence_of([frames(tmp_path, SQUARE, CELLS, heat=moved)])
    path = frames(tmp_path, SQUARE, CELLS, velocity=moved)
    assert "no field 'w'" in sentence_of([path], ReadingOptions(columns={"velocity": "w"}))
    (tmp_path / "f1.vtu").write_text("<VTKFile")
    assert "f1.vtu cannot be read" in sentence_of([path])


@pytest.mark.parametrize("ending", ["_sem2d.dat", "_init_sem2d.tab"])
def test_a_fault_of_sem2dpack_with_parts_cut_off(ending, tmp_path):
    folder = shutil.copytree(ENTRANTS / "sem2dpack-own-files" / "preloaded", tmp_path / "run")
    (part,) = folder.glob("*" + ending)
    part.write_bytes(part.read_bytes()[:-101])
    assert "Flt01" in sentence_of([folder])


def test_a_dump_of_uguca_with_times_cut_off(tmp_path):
    shutil.copytree(ENTRANTS / "uguca-own-files", tmp_path / "run")
    path = tmp_path / "run" / "preloaded.time"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-3]))
    assert "has shape" in sentence_of([tmp_path / "run" / "preloaded.info"])


# --- flipped bits ---------------------------------------------------------------------------------

LONG = {"t": np.linspace(0.0, 1.0, 30), "x": np.array([0.25, 0.5, 0.75])}
LONG["slip_rate"] = np.outer(LONG["t"], LONG["x"])
LONG["slip"] = LONG["slip_rate"] ** 2
TEXT = "t,x,slip_rate\n" + "".join(f"{t},{x},{t * x}\n" for t in LONG["t"] for x in LONG["x"])
HEADER = 400
"""Bytes at the beginning, in which headers are."""


def rows():
    file, table = io.BytesIO(), np.zeros(90, dtype=[(n, float) for n in ("t", "x", "slip_rate")])
    table["t"], table["x"] = np.tile(LONG["t"], 3), np.repeat(LONG["x"], 30)
    np.save(file, table)
    return file.getvalue()


FLIPPED = {
    "run.npz": packed(**LONG),
    "packed.npz": packed(np.savez_compressed, **LONG),
    "run.npy": rows(),
    "run.h5": hdf5(**LONG),
    "run.csv": TEXT.encode(),
    "run.csv.gz": gzip.compress(TEXT.encode()),
}


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", FLIPPED)
def test_flipped_bits_end_in_one_sentence_if_they_are_seen(name, tmp_path):
    """Half of them in headers: there were zlib's errors, and those of Python's own parser."""
    path, data = tmp_path / name, FLIPPED[name]
    for seed in range(60):
        rng = randomness(seed)
        part = data[:HEADER] if seed % 2 else data
        path.write_bytes(flip_bits(part, rng.choice([1, 1, 2, 8]), rng) + data[len(part) :])
        try:
            read_records([path])
        except DataFileError as error:
            message = one_sentence(error)
            assert str(path) in message
