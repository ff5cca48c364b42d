"""Tables of gauges and lines, and what is said of those that cannot be read."""

import numpy as np
import pytest

from compare.output.field_files import record_fields, write_record
from semianalytic import DataFileError, SceneError, find, solve
from slipfront.fits import read_gauges
from slipfront.fits.data import gauges_and_notes

TABLE = """# strain gauges and one of slip rate on the interface
t [us]; x [mm]; y [mm]; exx [ustrain]; sigma_xy [MPa]; slip_rate; slip_rate_noise; noise
0;  20; 3,5; 1; 0,1; ; ; 2
2;  20; 3,5; 3; -; ; ; 2
1;  20; 3,5; 2; 0,2; ; ; 3
1;  20; 3,5; 4; 0,3; ; ; 3
0;  40; ;  ; ; 0,5; 0,01; 7
1;  40; ;  ; ; 0,6; 0,02; 7
"""


def written(folder, text, name="a.csv"):
    path = folder / name
    path.write_text(text)
    return path


def test_a_table_of_gauges_is_read_as_it_says(tmp_path):
    rate, stress, strain = read_gauges([written(tmp_path, TABLE)])
    assert [record.quantity for record in (rate, stress, strain)] == ["slip_rate", "sxy", "exx"]
    assert [record.name for record in (strain, stress, rate)] == ["exx-1", "sxy-1", "slip_rate-1"]
    assert (strain.x, strain.y, rate.x, rate.y) == (0.02, 0.0035, 0.04, None)
    np.testing.assert_allclose(strain.t, [0, 1e-6, 2e-6])
    np.testing.assert_allclose(strain.values, [1e-6, 4e-6, 3e-6])  # of one time the last counts
    np.testing.assert_allclose(stress.values, [1e5, 3e5])
    np.testing.assert_allclose(strain.noise, [2e-6, 3e-6, 2e-6])
    np.testing.assert_allclose(stress.noise, [2e6, 3e6])
    np.testing.assert_allclose(rate.noise, [0.01, 0.02])


@pytest.mark.parametrize(
    "unit", ["µε", "με", "ustrain", "microstrain", "µm/m", "um/m", "1e-6", "ppm"]
)
def test_strain_may_be_in_any_of_its_units(unit, tmp_path):
    for header in (f"t,x,y,exx [{unit}]\n", f"t,x,y,exx\ns,m,m,{unit}\n"):
        if unit != "1e-6" or "[" in header:
            (gauge,) = read_gauges([written(tmp_path, header + "0,1,2,5\n")], {"": 1e-6})
            assert gauge.values == pytest.approx(5e-6)


def test_places_without_y_are_of_the_interface_and_noise_may_be_told(tmp_path):
    path = written(tmp_path, "t,x,V,tau,other\n0,0.2,1,2,9\n1,0.2,1,3,9\n0,0.1,5,6,9\n")
    gauges = read_gauges([path], {"slip_rate": 0.5, "": 2.0})
    assert [(gauge.name, gauge.x, gauge.noise) for gauge in gauges] == [
        ("slip_rate-1", 0.1, 0.5),
        ("slip_rate-2", 0.2, 0.5),
        ("shear_traction-1", 0.1, 2.0),
        ("shear_traction-2", 0.2, 2.0),
    ]


def test_files_of_other_codes_are_gauges_too(tmp_path):
    path = written(tmp_path, "# x = 0.3\nt slip_rate\n0 1\n1 2\n", "station.dat")
    (gauge,) = read_gauges([path], {"": 0.1})
    assert (gauge.x, gauge.quantity, gauge.noise) == (0.3, "slip_rate", 0.1)
    arrays = tmp_path / "a.npz"
    np.savez(arrays, t=np.arange(3.0), x=np.array([0.1, 0.2]), slip=np.ones((3, 2)))
    assert [gauge.x for gauge in read_gauges([arrays, path], {"": 0.1})] == [0.1, 0.2, 0.3]


def test_records_of_the_field_command_are_read(tmp_path):
    head = "# slipfront field preloaded\nt [s],x [m],y [m],v_x [m/s],sigma_xx [Pa],eps_xy [1]\n"
    gauges = read_gauges([written(tmp_path, head + "0,1,0.1,2,3,4\n")], {"": 1.0})
    assert [gauge.quantity for gauge in gauges] == ["vx", "sxx", "exy"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,x,slip_rate\n0,0.1,1\n", r"does not say how exact its slip_rate is"),
        ("t,x,speed\n0,0.1,1\n", r"none of it is slip_rate"),
        (
            "t,x,y,exx [furlong]\n0,0.1,1,1\n",
            r"line 1: 'furlong' in the name of 'exx .furlong.' is no known unit of strain",
        ),
        ("t,x,vx,y,v_x\n0,0.1,1,1,2\n", r"'vx' and 'v_x' are both vx; rename one"),
        ("t,x,slip_rate\n0,0.1,one\n", r"line 2: 'one' is not a number"),
        ("t,x,slip,noise\n0,0.1,1,0\n", r"slip at x = 0.1: gauge: noise must be positive"),
        ("", r"has no row of numbers"),
    ],
)
def test_bad_files_are_one_sentence(tmp_path, text, message):
    noise = {} if "how exact" in message else {"": 1.0}
    with pytest.raises(DataFileError, match=message) as raised:
        read_gauges([written(tmp_path, text)], noise)
    assert "\n" not in str(raised.value)
    assert "a.csv" in str(raised.value)


def test_no_file_is_refused(tmp_path):
    with pytest.raises(DataFileError, match="name at least one"):
        read_gauges([])
    with pytest.raises(DataFileError, match="does not exist"):
        read_gauges([tmp_path / "b.csv"])


# --- what the reader knows of a column counts in a fit --------------------------------------------

T = np.linspace(0.05, 1.2, 24)
PLACES = (0.2, 0.5, 0.9)


def station_files(folder, header, columns_at, places=PLACES, comments="# x1 {x}\n"):
    """A file of each place with columns of T, in the form of a station of another code."""
    paths = []
    for x in places:
        rows = [" ".join(map(repr, map(float, row))) for row in zip(T, *columns_at(x), strict=True)]
        text = comments.format(x=x) + header + "\n" + "\n".join(rows) + "\n"
        paths.append(written(folder, text, f"station_x{x}.dat"))
    return paths


ANSWER = solve(find("preloaded"))
BASE = ANSWER.scene.base.shear
KINDS = {
    "relative": ("t slip", lambda x: [ANSWER.slip(x, T)], "slip"),
    "upper": ("t u_upper", lambda x: [ANSWER.slip(x, T) / 2], "slip"),
    "lower": ("t v_lower", lambda x: [-ANSWER.slip_rate(x, T) / 2], "slip_rate"),
    "total": ("Time SRs T_s Ts0", lambda x: [T, T, ANSWER.shear_traction(x, T)], "shear_traction"),
    "change": ("Time T_s", lambda x: [ANSWER.shear_traction(x, T) - BASE], "shear_traction"),
    "tension": ("t n-stress", lambda x: [-ANSWER.pressure(x, T)], "pressure"),
    "mean": (
        "t slip_rate",
        lambda x: [(ANSWER.slip(x, T + 0.02) - ANSWER.slip(x, T)) / 0.02],
        "slip_rate",
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_gauges_are_what_files_say_of_their_columns(kind, tmp_path):
    header, columns, quantity = KINDS[kind]
    mean = "# the mean over the step from t to t + 0.02\n" if kind == "mean" else ""
    paths = station_files(tmp_path, header, columns, comments="# x1 {x}\n" + mean)
    gauges, notes, _ = gauges_and_notes(paths, {"": 1e-3}, ANSWER.scene)
    found = [gauge for gauge in gauges if gauge.quantity == quantity]
    assert [answer.x for answer in found] == list(PLACES)
    rtol = 2e-3 if kind == "mean" else 1e-12
    for item in found:
        exact = getattr(ANSWER, quantity)(item.x, item.t)
        away = item.t > item.x * 1.5 if kind == "mean" else item.t > 0  # a mean smooths the front
        np.testing.assert_allclose(item.values[away], exact[away], rtol=rtol, atol=1e-12)
        assert item.noise == (2e-3 if kind in ("upper", "lower") else 1e-3)
    said = {"upper": "doubled", "lower": "doubled", "change": "the base of the scene is added",
            "tension": "tension is positive", "mean": "stands for its middle"}  # fmt: skip
    found = {words for words in said.values() for note in notes if words in note}
    assert found == ({said[kind]} if kind in said else set())


def test_what_does_not_follow_from_a_file_is_refused(tmp_path):
    change = station_files(tmp_path, *KINDS["change"][:2])
    with pytest.raises(DataFileError, match="name the scene"):
        read_gauges(change, {"": 1.0})
    for name in ("base_shear", "gain"):
        with pytest.raises(DataFileError, match=f"do not say {name}"):
            gauges_and_notes(change, {"": 1.0}, ANSWER.scene, ["friction", name])
    alone = station_files(tmp_path, *KINDS["upper"][:2])
    for scene in (find("lift-off"), find("rock-on-gouge")):
        with pytest.raises(DataFileError, match=r"motion of one face alone.*give both faces"):
            read_gauges(alone, {"": 1.0}, scene)
    times = written(tmp_path, "j k t\n1 0 0.1\n2 0 0.2\n")
    with pytest.raises(DataFileError, match="times of rupture, which slipfront validate takes"):
        read_gauges(times, {"": 1.0})


@pytest.mark.parametrize("form", ["table", "arrays", "stations"])
def test_gauges_are_at_all_places_that_the_scene_has(form, tmp_path):
    places = [-1.0, 0.0, 0.5]
    paths = station_files(tmp_path, "t slip", lambda x: [T], places, "")
    if form == "table":
        rows = "".join(f"{t},{x},{t}\n" for t in T for x in places)
        paths = [written(tmp_path, "t,x,slip\n" + rows)]
    elif form == "arrays":
        np.savez(tmp_path / "a.npz", t=T, x=places, slip=np.ones((len(T), 3)))
        paths = [tmp_path / "a.npz"]
    gauges = read_gauges(paths, {"": 1.0}, find("cattaneo"))
    assert [gauge.x for gauge in gauges] == places
    gauges, notes, _ = gauges_and_notes(paths, {"": 1.0}, ANSWER.scene)
    assert [gauge.x for gauge in gauges] == [0.5]
    assert any("off the contact of the scene" in note for note in notes)


def test_y_of_zero_is_the_interface_and_what_is_elsewhere_is_said(tmp_path):
    text = "t,x,y,slip,exx\n0,1,0,3,\n0,1,,4,\n1,1,0,5,\n0,1,0.5,9,7\n1,1,,,8\n"
    gauges, notes, _ = gauges_and_notes([written(tmp_path, text)], {"": 1.0})
    slip, strain = gauges
    assert (slip.y, slip.values.tolist()) == (None, [4, 5])
    assert (strain.y, strain.values.tolist()) == (0.5, [7])
    assert "slip is of the interface, where y is 0 or missing: 1 rows are left out" in notes
    assert "exx is of points inside the bodies and needs its y: 1 rows are left out" in notes


def test_a_table_with_a_column_for_each_gauge(tmp_path):
    text = "Time [us];SG1 [ue];e2_ustrain;D1 [um];trigger\n0;1;2;3;9\n1;-1;;4;9\n"
    places = {"D1": ("slip", 0.03, 0), "e2": ("exy", -0.01, 0.002), "SG1": ("exx", 0.02, 0.003)}
    path = written(tmp_path, text)
    gauges, _, unread = gauges_and_notes([path], {"": 1e-6}, gauges=places)
    found = {item.name: (item.quantity, item.x, item.y, item.values.tolist()) for item in gauges}
    assert found == {
        "D1": ("slip", 0.03, None, pytest.approx([3e-6, 4e-6])),
        "e2": ("exy", -0.01, 0.002, pytest.approx([2e-6])),
        "SG1": ("exx", 0.02, 0.003, pytest.approx([1e-6, -1e-6])),
    }
    assert gauges[0].t.tolist() == [0, 1e-6]
    assert unread == ("trigger",)
    for name, place, message in (
        ("SG1", ("exx", 0.02), "exx is a quantity in the bodies; give y"),
        ("SG3", ("exx", 0.02, 0.1), "no column 'SG3'"),
        ("SG1", ("e", 0.02), "must be a quantity, x and"),
        ("D1", ("pressure", 0.02), "'um' in the name of 'D1 .um.' is no known unit of stress"),
    ):
        with pytest.raises((DataFileError, SceneError), match=message):
            read_gauges([path], {"": 1e-6}, gauges={name: place})
    np.savez(tmp_path / "a.npz", t=T, x=[0.1], slip=T[:, None])
    with pytest.raises(DataFileError, match="gauges are columns of a table of text"):
        read_gauges([tmp_path / "a.npz"], {"": 1.0}, gauges=places)


@pytest.mark.parametrize("units", ["", "SI"])
def test_what_field_records_can_be_fitted(units, tmp_path):
    t = np.linspace(0.1, 1, 5)
    record = record_fields(solve(find("preloaded")), 0.4, 0.2, t)
    write_record(tmp_path / "gauge.csv", record, units, "slipfront field preloaded")
    gauges = {gauge.quantity: gauge for gauge in read_gauges([tmp_path / "gauge.csv"], {"": 1e-3})}
    assert {"vx", "uy", "sxy", "exy"} <= gauges.keys()
    assert (gauges["exy"].x, gauges["exy"].y) == (0.4, 0.2)
    assert gauges["exy"].values == pytest.approx(record.strain[2])
    assert gauges["vx"].values == pytest.approx(record.velocity[0])
