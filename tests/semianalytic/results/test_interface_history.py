"""Histories of interfaces as files, and how much memory a computation may take."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from semianalytic import DataFileError, SceneError
from semianalytic.results import memory as memory_module
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.memory import available_memory, check_memory, memory_limit


@pytest.fixture
def history():
    x, t = np.linspace(0, 1, 5), np.array([0.1, 0.2])
    fields = [np.arange(10.0).reshape(2, 5) + k for k in range(5)]
    return InterfaceHistory(x, t, *fields)


def test_round_trip_and_shapes_that_must_agree(history, tmp_path):
    path = tmp_path / "history.h5"
    history.save(path)
    loaded = InterfaceHistory.load(path)
    for name in ("x", "t", "slip", "slip_rate", "shear_traction", "pressure", "gap"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(history, name))
    assert [p.name for p in tmp_path.iterdir()] == ["history.h5"]
    with pytest.raises(ValueError, match="slip_rate"):
        replace(history, slip_rate=history.slip_rate.T)


def test_damaged_foreign_and_missing_files(history, tmp_path):
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


# --- how much memory a computation may take -------------------------------------------------------


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A machine with 1 GB left, in a group that may take 0.5 GB and uses 0.2."""
    (tmp_path / "meminfo").write_text("MemTotal: 9000000 kB\nMemAvailable:   1000000 kB\n")
    (tmp_path / "max").write_text("500000000\n")
    (tmp_path / "current").write_text("200000000\n")
    monkeypatch.setattr(memory_module, "_MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(memory_module, "_GROUPS", ((tmp_path / "max", tmp_path / "current"),))
    return tmp_path


def test_available_memory_is_the_least_of_machine_and_group(machine):
    assert available_memory() == 300_000_000
    assert memory_limit(None) == 210_000_000
    (machine / "max").write_text("max\n")
    assert available_memory() == 1_024_000_000
    (machine / "meminfo").write_text("nothing of use\n")
    assert available_memory() > 100_000_000


@pytest.mark.parametrize("needed", [210_000_001, 10**30, 10**400])
def test_more_than_there_is_is_refused(machine, needed):
    with pytest.raises(SceneError, match=r"^the run would take .* GB of memory, and 0\.21 GB are"):
        check_memory(needed, None, "the run", "lower it")
    check_memory(210_000_000, None, "the run", "lower it")


def test_a_limit_that_was_given(machine):
    check_memory(10**9, 10**9, "the run", "lower it")
    with pytest.raises(SceneError, match=r"1e\+03 GB of memory, and 1 GB are allowed; lower it\.$"):
        check_memory(10**12, 1e9, "the run", "lower it")
    for wrong in (0, -1.0, float("nan"), float("inf"), "4 GB", True):
        with pytest.raises(SceneError, match="positive number of bytes"):
            memory_limit(wrong)
