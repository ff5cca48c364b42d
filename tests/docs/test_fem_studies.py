"""The committed studies, the command line's checkpoints, and histories as xarray."""

import importlib.util
import io
import re
import sys
import time

import numpy as np
import pytest
from rich.console import Console

from compare.output.progress import progress_bar
from docs.studies.accuracy import fem as study
from docs.studies.accuracy import scenes
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import MissingLibraryError
from slipfront.cli import commands as cli


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


def test_figures_of_named_scenes_are_drawn(tmp_path, monkeypatch):
    one_of_each = {figure: scene for scene, figure in scenes.FIGURES.items()}
    monkeypatch.setattr(scenes, "FIGURES", {scene: name for name, scene in one_of_each.items()})
    monkeypatch.setattr(scenes, "RESOLUTION", 16)
    scenes.write_figures(tmp_path)
    drawn = {path.name for path in tmp_path.iterdir()}
    assert drawn == {f"scene_{scene}.png" for scene in one_of_each.values()}


def test_command_keeps_checkpoints_by_seconds(tmp_path, monkeypatch):
    command = ["simulate", "preloaded", "--resolution", "16", "--no-snapshots", "--quiet"]
    again = [*command, "--output", str(tmp_path), "--checkpoint-seconds"]
    with monkeypatch.context() as patch:
        patch.setattr("fem.record.MeshRecord.level", stop_at_level(23))
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
    from fem.record import MeshRecord

    original = MeshRecord.level

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
