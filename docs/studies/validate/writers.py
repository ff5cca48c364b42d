"""Files of the trial on disk: records in eight formats, and junk."""

from __future__ import annotations

import gzip
import io
import zipfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from compare.records.record import Array
from docs.studies.validate.cases import CELLS, Case, Style
from docs.studies.validate.settings import Values, mean_rates

NAMES: Mapping[str, str] = {"slip_rate": "V", "shear_traction": "tau", "pressure": "sigma_n"}
"""Headers of files whose units are named; those of other columns are as ours."""


def columns_of(case: Case) -> Values:
    """Columns of a case as its style has them: t (m,), x (n,) and values (m, n)."""
    style, scene = case.style, case.setting.scene
    values = dict(case.values())
    if style.mean:
        values["slip_rate"] = mean_rates(case.setting, values["t"], values["x"], style.mean)
    if style.changes:
        held = scene.superposition.in_place
        values["shear_traction"] = values["shear_traction"] - held.shear
        values["pressure"] = values["pressure"] - held.pressure
    factors = {
        "slip": (0.5 if style.half else 1.0) * (-1 if style.turned else 1),
        "shear_traction": -1.0 if style.turned else 1.0,
        "pressure": -1.0 if style.tension else 1.0,
    }
    factors["slip_rate"] = factors["slip"]
    written = {
        name: factors.get(name, 1.0) * value / style.units.get(name, (1.0, ""))[0]
        for name, value in values.items()
    }
    for name, stem in (("slip_rate", "velocity"), ("slip", "displacement")):
        if style.faces:
            both = written.pop(name)
            written[f"{stem}_upper"] = 0.5 * both
            if style.faces == "both":
                written[f"{stem}_lower"] = -0.5 * both
    return written


def header_of(style: Style, name: str) -> str:
    """Name of a column, with its unit where the style names it."""
    if not style.named or name not in style.units:
        return name
    return f"{NAMES.get(name, name)} [{style.units[name][1]}]"


def written_case(case: Case, folder: Path) -> tuple[Path, list[str]]:
    """Write a case into a folder; its path and the options that go with it."""
    folder.mkdir(parents=True, exist_ok=True)
    columns = columns_of(case)
    path = FORMS[case.style.form](folder, case.style, columns)
    spacing = case.setting.length / CELLS / case.style.units.get("x", (1.0, ""))[0]
    return path, ["--spacing", f"{spacing:.6g}", *case.options]


def _rows(columns: Values) -> tuple[list[str], Array]:
    """Names and rows of a table of all stations."""
    t, x = np.meshgrid(columns["t"], columns["x"], indexing="ij")
    names = [name for name in columns if name not in ("t", "x")]
    parts = [t.ravel(), x.ravel(), *(columns[name].ravel() for name in names)]
    return ["t", "x", *names], np.stack(parts, axis=1)


def _text(style: Style, columns: Values, separator: str, comma: str = ".") -> str:
    names, rows = _rows(columns)
    lines = [separator.join(header_of(style, name) for name in names)]
    lines += [separator.join(f"{value:.9g}".replace(".", comma) for value in row) for row in rows]
    return "\n".join(lines) + "\n"


def _separated(separator: str, comma: str = ".") -> Callable[[Path, Style, Values], Path]:
    def write(folder: Path, style: Style, columns: Values) -> Path:
        path = folder / "run.csv"
        path.write_text(_text(style, columns, separator, comma), encoding="utf-8")
        return path

    return write


def _gz(folder: Path, style: Style, columns: Values) -> Path:
    path = folder / "run.dat.gz"
    path.write_bytes(gzip.compress(_text(style, columns, "\t").encode()))
    return path


def _npz(folder: Path, style: Style, columns: Values) -> Path:
    np.savez(folder / "run.npz", **columns)  # type: ignore[arg-type]
    return folder / "run.npz"


def _h5(folder: Path, style: Style, columns: Values) -> Path:
    import h5py

    with h5py.File(folder / "run.h5", "w") as file:
        for name, value in columns.items():
            file[name] = value
            if style.named and name in style.units:
                file[name].attrs["units"] = style.units[name][1]
    return folder / "run.h5"


def _stations(folder: Path, style: Style, columns: Values) -> Path:
    run = folder / "stations"
    run.mkdir()
    names = [name for name in columns if name != "x"]
    for place, x in enumerate(columns["x"]):
        unit = f" {style.units['x'][1]}" if style.named and "x" in style.units else ""
        lines = [f"# x = {x:.9g}{unit}", ",".join(header_of(style, name) for name in names)]
        for level in range(len(columns["t"])):
            values = (columns[n][level] if n == "t" else columns[n][level, place] for n in names)
            lines.append(",".join(f"{value:.9g}" for value in values))
        (run / f"station{place}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return run


FORMS: Mapping[str, Callable[[Path, Style, Values], Path]] = {
    "csv": _separated(","),
    "semicolon": _separated(";", ","),
    "tab": _separated("\t"),
    "blanks": _separated("  "),
    "gz": _gz,
    "npz": _npz,
    "h5": _h5,
    "folder": _stations,
}

GIGABYTE = 2**30


def _array(path: Path) -> None:
    np.save(path, np.random.default_rng(0).normal(size=(100, 4)))


def _gz_bomb(path: Path) -> None:
    with gzip.open(path, "wb", compresslevel=9) as stream:
        for _ in range(1200):
            stream.write(b"0.5,0.5,0.5\n" * 87382)


def _zip_bomb(path: Path) -> None:
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


def _false_shape(path: Path) -> None:
    """An array whose header asks for far more than there is."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (2**36,)}
    )
    with zipfile.ZipFile(path, "w") as file:
        for name in ("t", "x", "slip"):
            file.writestr(f"{name}.npy", header.getvalue() + bytes(800))


def _sparse_h5(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name in ("t", "x", "slip"):
            file.create_dataset(name, shape=(2**32,), dtype="f8", chunks=(2**20,))


def _sparse_text(path: Path) -> None:
    with path.open("wb") as stream:
        stream.write(b"t,x,slip\n0,1,0\n")
        stream.truncate(8 * GIGABYTE)


def _zeros(path: Path) -> None:
    path.write_bytes(b"0\n" * (5 * 2**20))


def _rows_without_end(path: Path) -> None:
    path.write_bytes(b"t,x,slip\n" + b"0,1,0\n" * (16 * 2**20))


def _one_line(path: Path) -> None:
    path.write_bytes(b"t,x,slip\n" + b"0," * (8 * 2**20))


def _brackets(path: Path) -> None:
    path.write_bytes(b"t,x,slip " + b" [" * 2**18 + b"\n0,1,0\n1,1,1\n")


def _bytes(content: bytes) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        path.write_bytes(content)

    return write


_XML = b"""<!DOCTYPE x [<!ENTITY a "aaaaaaaaaaaaaaaaaaaa">%s]><VTKFile>&h;</VTKFile>""" % b"".join(
    b'<!ENTITY %c "%s">' % (98 + n, b"&%c;" % (97 + n) * 20) for n in range(7)
)
JUNK: Mapping[str, tuple[str, Callable[[Path], None]]] = {
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


def written_junk(folder: Path) -> Iterator[tuple[str, Path]]:
    """Write all junk into a folder, and name /dev/zero as well; what each is, and its path."""
    for place, (what, (name, write)) in enumerate(JUNK.items()):
        path = folder / f"junk{place}" / name
        path.parent.mkdir(parents=True)
        write(path)
        yield what, path
    yield "a device", Path("/dev/zero")
