"""Files of other codes come out as the records that went in, in the units that they name."""

import gzip
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

from compare.records.read import read_records
from compare.records.record import ReadingOptions
from fem import simulate
from semianalytic import find, solve
from semianalytic.results.interface_history import InterfaceHistory

ENTRANTS = Path(__file__).parents[2] / "data" / "entrants"
T = np.linspace(0.0, 1.0, 5)
X = np.array([0.25, 0.5])
RATE = np.outer(T, [1.0, 2.0])
SLIP = np.outer(T**2 / 2, [1.0, 2.0])
ROWS = [(t, x, RATE[i, j]) for i, t in enumerate(T) for j, x in enumerate(X)]


def text_of(rows, separator=",", header="t,x,slip_rate", comma="."):
    lines = [separator.join(str(entry).replace(".", comma) for entry in row) for row in rows]
    return "\n".join([header.replace(",", separator), *lines]) + "\n"


def written(path, content):
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        path.write_text(content)
    return path


def check(records, rate=RATE, x=X):
    assert [station.x for station in records.stations] == pytest.approx(list(x))
    for j, station in enumerate(records.stations):
        np.testing.assert_allclose(station.t, T)
        np.testing.assert_allclose(station.values["slip_rate"], rate[:, j], rtol=1e-7)


TEXTS = {
    "comma": text_of(ROWS),
    "semicolon": text_of(ROWS, ";", comma=","),
    "tab": text_of(ROWS, "\t"),
    "blanks": text_of(ROWS, "  "),
    "decimal-comma": text_of(ROWS, " ", comma=","),
    "comma-blank": text_of(ROWS, ", "),
    "reversed": "# made by hand\n\n" + text_of(ROWS[::-1]),
    "windows": "\ufeff" + text_of(ROWS).replace("\n", "\r\n"),
    "names": text_of(ROWS, header="Time,Position,Slip-Rate"),
    "header-in-comment": text_of(ROWS).replace("t,x,slip_rate", "% t,x,slip_rate"),
    "fortran": "\n".join(" ".join(f"{v:.8E}".replace("E", "D") for v in row) for row in ROWS),
    "repeated": text_of(ROWS + ROWS[2:5]),
    "nuls-in-a-comment": b"# code=some  \0\0\0\n" + text_of(ROWS).encode(),
    "gzip": gzip.compress(text_of(ROWS).encode()),
    "utf-16": text_of(ROWS).encode("utf-16"),
}


@pytest.mark.parametrize("content", TEXTS.values(), ids=TEXTS)
def test_tables_of_text(content, tmp_path):
    (records,) = read_records([written(tmp_path / "run.csv", content)])
    check(records)


def test_mended_rows_are_said_and_gaps_stay(tmp_path):
    rows = [list(row) for row in ROWS[::-1]]
    rows[3][2] = "nan"
    (records,) = read_records([written(tmp_path / "run.csv", text_of(rows))])
    assert "rows are sorted by time" in records.notes
    assert sorted(np.isnan(entry.values["slip_rate"]).sum() for entry in records.stations) == [0, 1]


def test_stations_of_a_run_have_a_file_each(tmp_path):
    paths = []
    for j, x in enumerate(X):
        rows = list(zip(T, RATE[:, j], strict=True))
        text = text_of(rows, " ", header="t,slip_rate")
        paths.append(written(tmp_path / f"run_x{x}.dat", text))
    for given in (paths, paths[::-1], [tmp_path]):
        (records,) = read_records(given)
        check(records)
    (records,) = read_records(paths, ReadingOptions(at=(1.25, 1.5), origin=1.0))
    check(records)


def test_scec_stations_and_rupture_times(tmp_path):
    header = "t h-slip h-slip-rate h-shear-stress v-slip v-slip-rate v-shear-stress n-stress\n"
    folder = tmp_path / "stations"
    folder.mkdir()
    for j, name in enumerate(("faultst003dp000.txt", "faultst005dp000.txt")):
        rows = [f"{t} {SLIP[i, j]} {RATE[i, j]} 70 0 0 0 -120\n" for i, t in enumerate(T)]
        written(folder / name, "# problem=TPV\n" + header + "".join(rows))
    (records,) = read_records([folder])
    check(records, x=(300.0, 500.0))
    assert records.stations[0].values["pressure"][0] == -120
    assert any("n-stress" in note for note in records.notes)


def test_scec_stations_name_their_units_in_comments(tmp_path):
    head = "# Column #1 = Time (s)\n# Column #2 = horizontal slip (m)\n"
    head += "# Column #3 = horizontal shear stress (MPa)\nt h-slip h-shear-stress\n"
    (records,) = read_records([written(tmp_path / "faultst030dp075", head + "0 0 70\n1 2 71\n")])
    assert records.stations[0].values["shear_traction"].tolist() == [7e7, 7.1e7]
    assert records.stated.units["shear_traction"].name == "MPa"


@pytest.mark.parametrize("never", ["-1", "0", "1000", "99999", "1.0E+09", "nan", "-nan", "inf"])
def test_rupture_times_of_points_that_never_slip_are_said(never, tmp_path):
    text = f"# times\nj k t\n0 0 0.1\n200 0 0.2\n100 0 0.15\n0 100 9\n300 0 {never}\n"
    (records,) = read_records([written(tmp_path / "cplot.txt", text)])
    np.testing.assert_array_equal(records.arrivals[0], [0, 100, 200, 300])
    np.testing.assert_array_equal(records.arrivals[1], [0.1, 0.15, 0.2, np.inf])
    said = f"times of rupture {float(never):g} are read as never"
    assert records.notes == ("times of rupture at k = 0", said)


def test_rupture_times_that_may_be_times_are_kept(tmp_path):
    text = "j k t\n0 0 0\n100 0 300\n200 0 600\n300 0 1000\n"
    (records,) = read_records([written(tmp_path / "cplot.txt", text)])
    np.testing.assert_array_equal(records.arrivals[1], [0, 300, 600, 1000])


def test_gaps_with_a_sign_and_exponents_that_lost_their_e(tmp_path):
    """A gap forces the reader to take rows one by one; Fortran writes 1.5-115 for 1.5e-115."""
    words = ["-nan", "NA", "1.5-115", "-.25+003", "-nan(ind)"]
    rows = [f"{t} {word}" for t, word in zip(T, words, strict=True)]
    (records,) = read_records([written(tmp_path / "x1.dat", "t slip\n" + "\n".join(rows))])
    slip = records.stations[0].values["slip"]
    np.testing.assert_array_equal(slip, [np.nan, np.nan, 1.5e-115, -250.0, np.nan])


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("suffix", [".npz", ".h5"])
def test_arrays(suffix, turned, tmp_path):
    arrays = {"time": T, "x": X, "V": RATE.T if turned else RATE, "unrelated": np.ones(3)}
    arrays["heat"] = np.ones(RATE.shape)
    path = tmp_path / f"run{suffix}"
    if suffix == ".npz":
        np.savez(path, **arrays)
    else:
        with h5py.File(path, "w") as file:
            for name, array in arrays.items():
                file[name] = array
    (records,) = read_records([path])
    check(records)
    assert any("turned" in note for note in records.notes) == turned
    assert records.unread[-1] == "heat"


def test_columns_may_be_told_and_faces_are_joined(tmp_path):
    rows = [(t, x, v, -v / 2, v / 2) for t, x, v in ROWS]
    path = written(tmp_path / "run.csv", text_of(rows, header="t,x,q,v_lower,v_upper"))
    (records,) = read_records([path])
    check(records)
    assert "slip_rate is velocity_upper less velocity_lower" in records.notes
    (records,) = read_records([path], ReadingOptions(columns={"slip_rate": "q"}))
    check(records)
    assert records.notes == ()
    path = written(tmp_path / "half.csv", text_of(rows, header="t,x,a,b,v_upper"))
    (records,) = read_records([path])
    check(records, RATE / 2)
    assert "slip_rate is that of the upper face alone" in records.notes


def two_bodies():
    """Two rows of squares that touch along y = 0 with nodes of their own."""
    x = np.linspace(-0.25, 0.75, 5)
    points = [(a, b, 0.0) for low in (0.0, -0.25) for b in (low, low + 0.25) for a in x]
    squares = [[i, i + 1, i + 6, i + 5] for start in (0, 10) for i in range(start, start + 4)]
    return np.array(points), [("quad", np.array(squares))]


@pytest.mark.parametrize("suffix", [".pvd", ".xdmf"])
def test_motion_of_faces_of_a_mesh(suffix, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where meshio puts the data of an XDMF file
    points, cells = two_bodies()
    half = np.where(np.arange(len(points)) < 10, 2.0, -2.0) * np.maximum(points[:, 0], 0)
    fields = [{"Velocity": np.outer(t * half, [1.0, 0.0, 0.0])} for t in T]
    path = tmp_path / f"run{suffix}"
    if suffix == ".pvd":
        for i, data in enumerate(fields):
            meshio.Mesh(points, cells, point_data=data).write(tmp_path / f"f{i}.vtu")
        inner = "".join(f'<DataSet timestep="{t}" file="f{i}.vtu"/>' for i, t in enumerate(T))
        path.write_text(f'<VTKFile type="Collection"><Collection>{inner}</Collection></VTKFile>')
    else:
        with meshio.xdmf.TimeSeriesWriter(path) as writer:
            writer.write_points_cells(points, cells)
            for t, data in zip(T, fields, strict=True):
                writer.write_data(t, point_data=data)
        # as dolfin, SeisSol and others begin their files
        kind = '<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>'
        path.write_text(f'<?xml version="1.0"?>\n{kind}\n{path.read_text()}')
    (records,) = read_records([path])
    places = np.linspace(-0.25, 0.75, 5)
    check(records, np.outer(T, 4 * np.maximum(places, 0)), places)
    assert records.spacing == 0.25
    assert "velocity is the field 'Velocity'" in records.notes


def test_what_this_package_writes(tmp_path):
    zero = np.zeros_like(RATE)
    InterfaceHistory(X, T, SLIP, RATE, zero, zero + 1, zero).save(tmp_path / "history.h5")
    (records,) = read_records([tmp_path / "history.h5"])
    check(records)
    simulation = simulate(find("preloaded"), 1.0, resolution=10, snapshots=tmp_path / "s")
    simulation.save(tmp_path / "run")
    for path in (tmp_path / "run", tmp_path / "run" / "simulation.h5"):
        (records,) = read_records([path])
        assert records.spacing == simulation.element_size
        assert len(records.stations) == np.sum(simulation.interface.x > 0)
        slip = simulation.interface.slip[:, -1]
        np.testing.assert_array_equal(records.stations[-1].values["slip"], slip)
    (seen,) = read_records([next((tmp_path / "s").glob("*.pvd"))])
    last = {round(station.x, 9): station.values["slip"][-1] for station in records.stations}
    both = [station for station in seen.stations if round(station.x, 9) in last]
    assert len(both) > 5
    for record in both:
        # frames are in single precision
        assert record.values["slip"][-1] == pytest.approx(last[round(record.x, 9)], rel=2e-7)


def test_answers_that_this_package_saves_are_read_whatever_they_are_called(tmp_path):
    march = solve("ramp", nodes=32, end_time=0.5, estimate=False)
    run = solve("two-slots", nodes=64, end_time=0.5, estimate=False)
    exact = solve("preloaded").to_xarray(X, T)
    saves = {"a.h5": march.save, "b.nc": march.save, "c.npz": run.save}
    saves |= {"e.nc": run.to_xarray().to_netcdf, "f.nc": exact.to_netcdf}
    for name, save in saves.items():
        save(tmp_path / name)
        (records,) = read_records([tmp_path / name])
        saved = march.interface if name < "c" else run.interface if name < "f" else exact
        last, *_ = np.nonzero(np.asarray(saved.x) == records.stations[-1].x)[0]
        for quantity, values in records.stations[-1].values.items():
            np.testing.assert_array_equal(values, np.asarray(getattr(saved, quantity))[:, last])
        assert len(records.stations) == np.sum(np.asarray(saved.x) > (0 if name < "c" else -9))
        assert "touching" not in records.unread


def test_what_uguca_writes():
    origin = ReadingOptions(origin=2.115)
    (dump,) = read_records([ENTRANTS / "uguca-own-files" / "preloaded.info"], origin)
    (table,) = read_records([ENTRANTS / "uguca" / "preloaded" / "100.csv"])
    assert table.spacing == 0.01
    beside = [station for station in dump.stations if abs(station.x - 0.5) < 0.01]
    mean = np.mean([station.values["slip"] for station in beside], axis=0)
    (here,) = (station for station in table.stations if station.x == 0.5)
    shown = 2 * np.interp(here.t, beside[0].t, mean)  # one half-space alone
    np.testing.assert_allclose(shown, here.values["slip"], atol=1e-5)


def test_what_sem2dpack_writes():
    (fault,) = read_records([ENTRANTS / "sem2dpack-own-files" / "preloaded"])
    (table,) = read_records([ENTRANTS / "sem2dpack" / "preloaded" / "80.csv"])
    for station, other in zip(fault.stations, table.stations, strict=True):
        assert station.x == pytest.approx(100 * other.x)
        for name, scale in (("slip", 0.01), ("slip_rate", 1.0), ("shear_traction", 1.0)):
            shown = np.interp(other.t, station.t / 100, scale * station.values[name])
            np.testing.assert_allclose(shown, other.values[name], atol=2e-5)


def test_several_runs_stay_apart(tmp_path):
    paths = [written(tmp_path / f"{name}.csv", text_of(ROWS)) for name in "ab"]
    assert [records.source for records in read_records(paths)] == [str(path) for path in paths]
