"""Files that hold no records and try to take memory or time: bombs, false headers, rubbish."""

import gzip
import io
import zipfile

import numpy as np

GIGABYTE = 2**30


def _array(path):
    np.save(path, np.random.default_rng(0).normal(size=(100, 4)))


def _gz_bomb(path):
    with gzip.open(path, "wb", compresslevel=9) as stream:
        for _ in range(1200):
            stream.write(b"0.5,0.5,0.5\n" * 87382)


def _zip_bomb(path):
    header = io.BytesIO()
    count = 3 * GIGABYTE // 8
    shape = {"descr": "<f8", "fortran_order": False, "shape": (count,)}
    np.lib.format.write_array_header_1_0(header, shape)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name in ("t", "x", "slip"):
            with file.open(f"{name}.npy", "w", force_zip64=True) as member:
                member.write(header.getvalue())
                for _ in range(3 * 64 if name == "t" else 1):
                    member.write(bytes(2**24))


def _false_shape(path):
    """An array whose header asks for far more than there is."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (2**36,)}
    )
    with zipfile.ZipFile(path, "w") as file:
        for name in ("t", "x", "slip"):
            file.writestr(f"{name}.npy", header.getvalue() + bytes(800))


def _sparse_h5(path):
    import h5py

    with h5py.File(path, "w") as file:
        for name in ("t", "x", "slip"):
            file.create_dataset(name, shape=(2**32,), dtype="f8", chunks=(2**20,))


def _sparse_text(path):
    with path.open("wb") as stream:
        stream.write(b"t,x,slip\n0,1,0\n")
        stream.truncate(8 * GIGABYTE)


def _zeros(path):
    path.write_bytes(b"0\n" * (5 * 2**20))


def _rows_without_end(path):
    path.write_bytes(b"t,x,slip\n" + b"0,1,0\n" * (16 * 2**20))


def _one_line(path):
    path.write_bytes(b"t,x,slip\n" + b"0," * (8 * 2**20))


def _brackets(path):
    path.write_bytes(b"t,x,slip " + b" [" * 2**18 + b"\n0,1,0\n1,1,1\n")


def _bytes(content):
    def write(path):
        path.write_bytes(content)

    return write


_XML = b"""<!DOCTYPE x [<!ENTITY a "aaaaaaaaaaaaaaaaaaaa">%s]><VTKFile>&h;</VTKFile>""" % b"".join(
    b'<!ENTITY %c "%s">' % (98 + n, b"&%c;" % (97 + n) * 20) for n in range(7)
)
JUNK = {
    "plain array": ("run.npy", _array),
    "array of objects": ("run.npy", lambda path: np.save(path, np.array([{}, {}]))),
    "gzip bomb": ("run.csv.gz", _gz_bomb),
    "zip bomb": ("run.npz", _zip_bomb),
    "zip of a false shape": ("run.npz", _false_shape),
    "sparse HDF5": ("run.h5", _sparse_h5),
    "sparse text": ("run.csv", _sparse_text),
    "10 MB of 0": ("run.csv", _zeros),
    "rows without end": ("run.csv", _rows_without_end),
    "a line without end": ("run.csv", _one_line),
    "brackets without end": ("run.csv", _brackets),
    "XML bomb": ("run.pvd", _bytes(_XML)),
    "empty": ("run.csv", _bytes(b"")),
    "picture": ("run.csv", _bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")),
    "zip that is none": ("run.npz", _bytes(b"PK\3\4" + bytes(60))),
    "half an HDF5": ("run.h5", _bytes(b"\x89HDF\r\n\x1a\n" + bytes(90))),
}
"""Files that hold no records, by what they are: their names and what writes them."""
