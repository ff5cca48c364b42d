"""The committed studies, the command line's checkpoints, and histories as xarray."""

import importlib.util
import io
import re
import sys
import time

import numpy as np
import pytest
from catalogue import solved
from rich.console import Console

from compare.output.progress import progress_bar
from docs.studies.accuracy import fem as study
from docs.studies.profiles import PROFILE, profile_errors
from fem import load_simulation
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import MissingLibraryError
from semianalytic.scene.given.named import NAMED_SCENES
from slipfront.cli import commands as cli


def test_errors_of_the_exact_profile_are_zero():
    solution = solved(NAMED_SCENES["preloaded"].scene)
    exact = solution.slip_rate(PROFILE, 1.0)
    errors = profile_errors(solution, exact, 1.01 * exact)
    assert errors.last == 0
    for peak in (errors.averaged, errors.first_peak, errors.second_peak):
        assert peak == pytest.approx(0.01)


def test_accuracy_has_a_row_per_mesh_and_the_extrapolation():
    coarse, fine, limit = study.slip_rates("preloaded", (20, 40))
    assert [row["h"] for row in (coarse, fine, limit)] == ["1/20", "1/40", "extrapolated"]
    assert np.isnan(coarse["last_order"])
    assert fine["last_order"] == pytest.approx(np.log2(coarse["last"] / fine["last"]))
    assert fine["last_order"] > 0.8
    assert np.isnan(limit["seconds"])


def test_openings_and_fields_converge():
    coarse, fine = study.openings("tap", (30, 60))
    assert np.log2(coarse["gap"] / fine["gap"]) == pytest.approx(fine["order"])
    assert fine["order"] > 0.8
    assert abs(fine["inner"] - fine["exact_inner"]) < 0.01
    rows = study.fields("preloaded", (10, 20, 40))
    assert min(row["order"] for row in rows) > 0.5


@pytest.mark.slow
def test_default_mesh_and_three_meshes_reach_what_is_promised():
    """At most 0.3 % in L1 with defaults, 0.1 % on the next mesh, and of first order or better."""
    errors = [row["last"] for row in study.slip_rates("preloaded", (50, 100, 200))]
    assert errors[1] < 3e-3
    assert errors[2] < 1e-3
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


@pytest.mark.slow
def test_command_resumes_and_removes_the_checkpoint(tmp_path, monkeypatch, capsys):
    command = ["simulate", "preloaded", "--resolution", "16", "--no-snapshots", "--quiet"]
    assert cli.main([*command, "--output", str(tmp_path / "whole")]) == 0
    again = [*command, "--output", str(tmp_path / "run"), "--checkpoint-every", "5", "--resume"]
    with monkeypatch.context() as patch:
        patch.setattr("fem.record.Record.level", stop_at_level(23))
        assert cli.main(again) == cli.INTERRUPTED
    assert (tmp_path / "run" / "checkpoint.h5").is_file()
    assert cli.main([*again, "--damping", "0.03"]) == 3
    assert "its damping is 0.02, not 0.03" in capsys.readouterr().err
    assert cli.main(again) == 0
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["simulation.h5"]
    one, other = (load_simulation(tmp_path / name).interface for name in ("whole", "run"))
    np.testing.assert_array_equal(one.slip_rate, other.slip_rate)


def test_command_keeps_checkpoints_by_seconds(tmp_path, monkeypatch):
    command = ["simulate", "preloaded", "--resolution", "16", "--no-snapshots", "--quiet"]
    again = [*command, "--output", str(tmp_path), "--checkpoint-seconds"]
    with monkeypatch.context() as patch:
        patch.setattr("fem.record.Record.level", stop_at_level(23))
        assert cli.main([*again, "3600"]) == cli.INTERRUPTED
        assert not (tmp_path / "checkpoint.h5").exists()  # neither time nor 100 steps are up
        assert cli.main([*again, "1e-9"]) == cli.INTERRUPTED
    assert (tmp_path / "checkpoint.h5").is_file()
    assert cli.main([*again, "0"]) == 2
    assert cli.main([*again, "3600", "--resume"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["simulation.h5"]


def shown_progress(quiet, terminal):
    console = Console(file=io.StringIO(), force_terminal=terminal, width=100)
    with progress_bar(console, quiet) as progress:
        for step in range(1, 51):
            progress(step, 200)
            time.sleep(1e-4)
    return console.file.getvalue()


def test_progress_bar_shows_percent_rate_and_time_left():
    shown = shown_progress(quiet=False, terminal=True)
    for words in (" 25%", "50/200", r"\d steps/s", r"\d:\d\d:\d\d"):
        assert re.search(words, shown), words


@pytest.mark.parametrize(("quiet", "terminal"), [(True, True), (False, False)])
def test_progress_bar_is_silent_when_quiet_or_without_a_terminal(quiet, terminal):
    assert shown_progress(quiet, terminal).strip() == ""


def stop_at_level(level):
    from fem.record import Record

    original = Record.level

    def stop(self, step):
        if step == level:
            raise KeyboardInterrupt
        original(self, step)

    return stop


HISTORY = InterfaceHistory(np.arange(3.0), np.arange(2.0), *np.arange(30.0).reshape(5, 2, 3))


@pytest.mark.skipif(importlib.util.find_spec("xarray") is None, reason="xarray is not installed")
def test_history_as_xarray():
    dataset = HISTORY.to_xarray()
    assert dict(dataset.sizes) == {"t": 2, "x": 3}
    np.testing.assert_array_equal(dataset["pressure"], HISTORY.pressure)
    np.testing.assert_array_equal(dataset["slip"].sel(t=1.0), HISTORY.slip[1])


def test_without_xarray_it_is_asked_for(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(MissingLibraryError, match=r"pip install '\.\[xarray\]'"):
        HISTORY.to_xarray()
