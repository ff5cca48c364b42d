import numpy as np
import pytest

from semianalytic import DataFileError, InterfaceHistory


@pytest.fixture
def history():
    x, t = np.linspace(0, 1, 5), np.array([0.1, 0.2])
    fields = [np.arange(10.0).reshape(2, 5) + k for k in range(5)]
    return InterfaceHistory(x, t, *fields)


def test_round_trip(history, tmp_path):
    path = tmp_path / "history.h5"
    history.save(path)
    loaded = InterfaceHistory.load(path)
    for name in ("x", "t", "slip", "slip_rate", "shear_traction", "pressure", "gap"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(history, name))
    assert [p.name for p in tmp_path.iterdir()] == ["history.h5"]


def test_shapes_must_agree(history):
    with pytest.raises(ValueError, match="slip_rate"):
        InterfaceHistory(
            history.x,
            history.t,
            history.slip,
            history.slip_rate.T,
            history.shear_traction,
            history.pressure,
            history.gap,
        )


def test_damaged_foreign_and_missing_files(history, tmp_path):
    import h5py

    path = tmp_path / "history.h5"
    history.save(path)
    path.write_bytes(path.read_bytes()[:300])
    with pytest.raises(DataFileError, match="cannot be read"):
        InterfaceHistory.load(path)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = [1.0]
    with pytest.raises(DataFileError, match="not a slipfront interface history"):
        InterfaceHistory.load(tmp_path / "other.h5")
    with pytest.raises(DataFileError, match="cannot be read"):
        InterfaceHistory.load(tmp_path / "none.h5")
