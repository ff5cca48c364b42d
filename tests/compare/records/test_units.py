"""Units and conventions that files name are followed where known, and refused where not."""

import re

import h5py
import numpy as np
import pytest

from compare.records.read import read_records
from compare.records.record import ReadingOptions
from semianalytic.scene import extras
from semianalytic.scene.errors import DataFileError, MissingLibraryError
from semianalytic.scene.tables.units import si_size

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
