"""Files of other codes in which bits are flipped are read, or end in one sentence."""

import gzip
import io

import h5py
import numpy as np
import pytest
from faults import flip_bits, randomness

from compare.records.read import read_records
from semianalytic.scene.errors import DataFileError

T, X = np.linspace(0.0, 1.0, 30), np.array([0.25, 0.5, 0.75])
RATE = np.outer(T, X)
HEADER = 400
"""Bytes at the beginning, in which headers are."""


def packed(save):
    file = io.BytesIO()
    save(file, t=T, x=X, slip_rate=RATE, slip=RATE**2)
    return file.getvalue()


def hdf5():
    file = io.BytesIO()
    with h5py.File(file, "w") as group:
        group["t"], group["x"], group["slip_rate"] = T, X, RATE
    return file.getvalue()


def text():
    rows = (f"{t},{x},{t * x}\n" for t in T for x in X)
    return ("t,x,slip_rate\n" + "".join(rows)).encode()


def rows():
    file, table = io.BytesIO(), np.zeros(90, dtype=[(n, float) for n in ("t", "x", "slip_rate")])
    table["t"], table["x"] = np.tile(T, 3), np.repeat(X, 30)
    np.save(file, table)
    return file.getvalue()


FILES = {
    "run.npz": packed(np.savez),
    "packed.npz": packed(np.savez_compressed),
    "run.npy": rows(),
    "run.h5": hdf5(),
    "run.csv": text(),
    "run.csv.gz": gzip.compress(text()),
}


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", FILES)
def test_flipped_bits_end_in_one_sentence_if_they_are_seen(name, tmp_path):
    """Half of them in headers: there were zlib's errors, and those of Python's own parser."""
    path, data = tmp_path / name, FILES[name]
    for seed in range(60):
        rng = randomness(seed)
        part = data[:HEADER] if seed % 2 else data
        path.write_bytes(flip_bits(part, rng.choice([1, 1, 2, 8]), rng) + data[len(part) :])
        try:
            read_records([path])
        except DataFileError as error:
            message = str(error)
            assert str(path) in message
            assert "\n" not in message
            assert message.endswith(".")


def test_a_damaged_file_is_exit_code_three(tmp_path, refused):
    data = bytearray(FILES["packed.npz"])
    data[90:100] = b"\xff" * 10
    (tmp_path / "run.npz").write_bytes(bytes(data))
    refused(f"fit {tmp_path / 'run.npz'} --scene preloaded --parameters friction --noise 0.1", 3)
