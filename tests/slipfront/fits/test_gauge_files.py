"""Tables of gauges and lines, and what is said of those that cannot be read."""

import numpy as np
import pytest

from compare.output.field_files import record_fields, write_record
from semianalytic import DataFileError, find, solve
from slipfront.fits import read_gauges

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
    strain, stress, rate = read_gauges([written(tmp_path, TABLE)])
    assert [one.quantity for one in (strain, stress, rate)] == ["exx", "sxy", "slip_rate"]
    assert [one.name for one in (strain, stress, rate)] == ["exx-1", "sxy-1", "slip_rate-1"]
    assert (strain.x, strain.y, rate.x, rate.y) == (0.02, 0.0035, 0.04, None)
    np.testing.assert_allclose(strain.t, [0, 1e-6, 2e-6])
    np.testing.assert_allclose(strain.values, [1e-6, 4e-6, 3e-6])  # of one time the last counts
    np.testing.assert_allclose(stress.values, [1e5, 3e5])
    np.testing.assert_allclose(strain.noise, [2e-6, 3e-6, 2e-6])
    np.testing.assert_allclose(stress.noise, [2e6, 3e6])
    np.testing.assert_allclose(rate.noise, [0.01, 0.02])


def test_places_without_y_are_of_the_interface_and_noise_may_be_told(tmp_path):
    path = written(tmp_path, "t,x,V,tau,other\n0,0.2,1,2,9\n1,0.2,1,3,9\n0,0.1,5,6,9\n")
    gauges = read_gauges([path], {"slip_rate": 0.5, "": 2.0})
    assert [(one.name, one.x, one.noise) for one in gauges] == [
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
    assert [one.x for one in read_gauges([arrays, path], {"": 0.1})] == [0.1, 0.2, 0.3]


def test_records_of_the_field_command_are_read(tmp_path):
    head = "# slipfront field preloaded\nt [s],x [m],y [m],v_x [m/s],sigma_xx [Pa],eps_xy [1]\n"
    gauges = read_gauges([written(tmp_path, head + "0,1,0.1,2,3,4\n")], {"": 1.0})
    assert [one.quantity for one in gauges] == ["vx", "sxx", "exy"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,x,slip_rate\n0,0.1,1\n", r"does not say how exact its slip_rate is"),
        ("t,x,speed\n0,0.1,1\n", r"has no column of slip_rate"),
        ("t,x,y,exx [furlong]\n0,0.1,1,1\n", r"line 1: 'furlong' is no known unit of exx"),
        ("t,x,vx,y,v_x\n0,0.1,1,1,2\n", r"two columns are v_x"),
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
    with pytest.raises(DataFileError, match="name one at least"):
        read_gauges([])
    with pytest.raises(DataFileError, match="does not exist"):
        read_gauges([tmp_path / "b.csv"])


@pytest.mark.parametrize("units", ["", "SI"])
def test_what_field_records_can_be_fitted(units, tmp_path):
    t = np.linspace(0.1, 1, 5)
    record = record_fields(solve(find("preloaded")), 0.4, 0.2, t)
    write_record(tmp_path / "gauge.csv", record, units, "slipfront field preloaded")
    gauges = {one.quantity: one for one in read_gauges([tmp_path / "gauge.csv"], {"": 1e-3})}
    assert {"vx", "uy", "sxy", "exy"} <= gauges.keys()
    assert (gauges["exy"].x, gauges["exy"].y) == (0.4, 0.2)
    assert gauges["exy"].values == pytest.approx(record.strain[2])
    assert gauges["vx"].values == pytest.approx(record.velocity[0])
