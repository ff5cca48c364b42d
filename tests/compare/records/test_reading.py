"""Files of other codes come out as the records that went in, in the units that they name."""

import gzip
import re
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
from semianalytic.scene import extras
from semianalytic.scene.errors import DataFileError, MissingLibraryError
from semianalytic.scene.tables.units import si_size

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


# --- units that files name: converted where they are known, refused where not ---------------------

TABLE = [(t, x, 2 * t) for t in (0.0, 0.5, 1.0) for x in (0.25, 0.5)]
KNOWN = {
    "length": {"mm": 1e-3, "µm": 1e-6, "μm": 1e-6, "um": 1e-6, "thou": 2.54e-5, "in": 0.0254},
    "time": {"s": 1.0, "sec": 1.0, "µs": 1e-6, "ms": 1e-3, "min": 60.0},
    "length / time": {
        "mm/s": 1e-3, "m s-1": 1.0, "m s^-1": 1.0, "m.s⁻¹": 1.0, "mm/ms": 1.0, "km/h": 1 / 3.6,
        "furlong/s": 201.168,
    },
    "stress": {
        "MPa": 1e6, "mpa": 1e6, "mPa": 1e-3, "psi": 6894.757, "N/mm^2": 1e6, "N/mm²": 1e6,
        "bar": 1e5, "kN m^-2": 1e3,
    },
}  # fmt: skip


@pytest.mark.parametrize("dimension", KNOWN)
def test_sizes_of_units(dimension):
    for name, size in KNOWN[dimension].items():
        assert si_size(name, dimension) == pytest.approx(size, rel=1e-5), name


@pytest.mark.parametrize(
    ("name", "dimension"),
    [
        *(("s", "length"), ("m", "time"), ("m", "length / time"), ("Pa s", "stress")),
        ("MPa", "angle"),
        *(("upper", "length"), ("furlnog", "length"), ("1e3 m", "length"), ("m**", "length")),
        *(("m" * 99, "length"), ("(" * 30, "length"), ("10**10**10", "stress"), ("__x", "time")),
    ],
)
def test_what_is_no_unit_of_a_dimension(name, dimension):
    assert si_size(name, dimension) is None


def table(tmp_path, header, rows=TABLE, comments=""):
    path = tmp_path / "run.csv"
    body = "\n".join(",".join(map(repr, row)) for row in rows)
    path.write_text(f"{comments}{header}\n{body}\n", encoding="utf-8")
    return path


def read(path, **options):
    (records,) = read_records([path], ReadingOptions(**options))
    return records


@pytest.mark.parametrize(
    ("header", "sizes"),
    [
        ("t [ms],x [mm],slip_rate [mm/s]", (1e-3, 1e-3, 1e-3)),
        ("t (µs),x (in),V (in/s)", (1e-6, 0.0254, 0.0254)),
        ("t_ms,x_mm,V_mm_s", (1e-3, 1e-3, 1e-3)),
        ("t_ms,x_mm,tau_MPa", (1e-3, 1e-3, 1e6)),
        ("t [s],x [m],tau [N/mm^2]", (1.0, 1.0, 1e6)),
        ("t,x,tau\nms,mm,MPa", (1e-3, 1e-3, 1e6)),
        ("t [-],x [1],slip", (1.0, 1.0, 1.0)),
    ],
)
def test_units_in_headers_are_converted_and_said(tmp_path, header, sizes):
    records = read(table(tmp_path, header))
    station = records.stations[1]
    (name,) = station.values
    np.testing.assert_allclose(station.t, sizes[0] * np.array([0, 0.5, 1]))
    assert station.x == pytest.approx(0.5 * sizes[1])
    np.testing.assert_allclose(station.values[name], sizes[2] * np.array([0, 1, 2]))
    kept = {key: unit.size for key, unit in records.stated.units.items()}
    named = {"t": sizes[0], "x": sizes[1], name: sizes[2]} if "[-]" not in header else {}
    assert kept == pytest.approx(named)
    assert sum("SI" in note for note in records.notes) == sum(size != 1 for size in sizes)


UNKNOWN = r"line 1: '.*' in the name of .* is no known unit of"


@pytest.mark.parametrize(
    ("comments", "header", "words"),
    [
        ("", "t,x,slip [furlnog]", UNKNOWN),
        ("", "t [mm],x,slip", UNKNOWN),
        ("", "t,x,slip (upper)", UNKNOWN),
        ("", "t,x [Pa],slip", UNKNOWN),
        ("# spacing: 5 mm\n", "t,x,slip", "names a unit of its spacing and none of x"),
        ("# spacing: 5 cells\n", "t,x,slip", "'cells' in a comment is no known unit of length"),
    ],
)
def test_unknown_units_are_refused(tmp_path, comments, header, words):
    with pytest.raises(DataFileError, match=words):
        read(table(tmp_path, header, comments=comments))


def test_units_of_datasets(tmp_path):
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        for name, value in (
            ("t", np.arange(3.0)),
            ("x", np.arange(1.0, 3)),
            ("V", np.ones((3, 2))),
        ):
            file[name] = value
        file["x"].attrs["units"] = "km"
        file["V"].attrs["units"] = np.bytes_(b"mm/s")
    records = read(path)
    assert [station.x for station in records.stations] == [1e3, 2e3]
    assert records.stations[0].values["slip_rate"][0] == 1e-3
    assert set(records.stated.units) == {"x", "slip_rate"}


@pytest.mark.parametrize(
    ("comment", "header", "spacing"),
    [
        ("# spacing: 5\n", "t,x [mm],slip", 5e-3),
        ("# spacing: 5 mm\n", "t,x [m],slip", 5e-3),
        ("# dx = 5 [mm]\n", "t,x [km],slip", 5e-3),
        ("# spacing: 5\n", "t,x,slip", 5.0),
        ("# benchmark: tap\n# cells: 20\n", "t,x,slip", 0.05),
        ("# benchmark: tap\n# cells: 20\n", "t,x [km],slip", None),
    ],
)
def test_spacing_and_origin_follow_the_unit_of_x(tmp_path, comment, header, spacing):
    records = read(table(tmp_path, header, comments=comment))
    assert records.spacing == (None if spacing is None else pytest.approx(spacing))
    size = records.stated.units["x"].size if "x" in records.stated.units else 1.0
    moved = read(table(tmp_path, header, comments=comment), origin=0.125)
    assert [station.x for station in moved.stations] == pytest.approx([0.125 * size, 0.375 * size])


def test_a_station_may_name_the_unit_of_its_place(tmp_path):
    path = tmp_path / "station.csv"
    path.write_text("# x = 250 mm\nt,slip\n0,0\n1,1\n")
    records = read(path)
    assert records.stations[0].x == pytest.approx(0.25)
    assert records.stated.units["x"].name == "mm"
    other = tmp_path / "other.csv"
    other.write_text("# x = 0.5\nt,slip\n0,0\n1,1\n")
    with pytest.raises(DataFileError, match="name different units"):
        read_records([path, other])


def test_other_units_of_the_si_need_pint(tmp_path, monkeypatch):
    monkeypatch.setattr("semianalytic.scene.tables.units._size", _without_pint)
    assert read(table(tmp_path, "t [ms],x [cm],tau [Pa]")).stations
    with pytest.raises(MissingLibraryError, match=re.escape("pip install '.[units]'")):
        read(table(tmp_path, "t [min],x,slip"))


def _without_pint(name, dimension):
    with extras.needing(f"Reading the unit {name!r}"):
        raise ModuleNotFoundError(name="pint")


SEISSOL = """TITLE = "Temporal Signal for fault receiver number 1"
VARIABLES = "Time" ,"SRs" ,"SRd" ,"T_s" ,"T_d" ,"P_n" {more}
# x1\t  2.5000000000E+02
# x2\t  0.0000000000E+00
# x3\t -1.0000000000E+02
  0.0E+00\t 0.0E+00\t 0.0E+00\t 0.0E+00\t 0.0E+00\t 0.0E+00\t{values}
  1.0E-01\t 2.0E+00\t 0.0E+00\t-3.0E+06\t 0.0E+00\t 1.0E+05\t{values}
"""


@pytest.mark.parametrize("time", ["Time", "t [s]"])
def test_t_s_of_seissol_is_a_shear_traction(tmp_path, time):
    path = tmp_path / "run-faultreceiver-00001.dat"
    path.write_text(SEISSOL.format(more="", values="").replace("Time", time))
    records = read(path)
    (station,) = records.stations
    assert station.x == 250
    assert station.values["slip_rate"].tolist() == [0, 2]
    assert station.values["shear_traction"].tolist() == [0, -3e6]
    assert station.values["pressure"].tolist() == [0, 1e5]
    assert records.stated.changes == {"shear_traction", "pressure"}
    assert records.stated.units.keys() == ({"t"} if time == "t [s]" else set())
    text = SEISSOL.replace("# x1", 'ZONE T="receiver", F=POINT\n# x1')
    path.write_text(text.format(more=',"Ts0" ,"Pn0"', values="7.0E+07\t-1.2E+08\t"))
    records = read(path)
    assert records.stations[0].values["shear_traction"][0] == 7e7
    assert records.stations[0].values["pressure"][0] == -1.2e8
    assert records.stated.changes == frozenset()


def test_t_s_alone_is_a_time_in_seconds(tmp_path):
    records = read(table(tmp_path, "T_s,x_m,V_m/s"))
    assert records.stations[0].t.tolist() == [0, 0.5, 1]
    assert records.stated.units["t"].name == "s"


def test_what_a_file_says_of_means_and_faces(tmp_path):
    comment = "# slip_rate is the mean over the step from t to t + 0.005\n"
    records = read(table(tmp_path, "t,x,v_upper", comments=comment))
    assert records.stated.mean == "after"
    assert records.stated.step == 0.005
    assert records.stated.faces == {"slip_rate"}
