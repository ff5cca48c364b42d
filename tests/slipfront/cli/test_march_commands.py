"""Marches on the command line: saved, interrupted, and gone on with."""

import json
import os
import signal
from contextlib import contextmanager

import pytest

from semianalytic import Marched, SceneError, march
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.commands import main


def test_solve_marches_saves_and_goes_on(tmp_path, capsys):
    saved, plot = tmp_path / "march.h5", tmp_path / "march.png"
    command = ["solve", "harmonic", "--nodes", "120", "--end-time", "0.5", "--latest", "1"]
    assert main([*command, "--save", str(saved), "--plot", str(plot)]) == 0
    assert "reach of reverse slip" in capsys.readouterr().out
    assert plot.stat().st_size > 10_000
    assert main(["solve", "harmonic", "--go-on", str(saved), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["end_time"] == 1.0
    whole = march(find_scene("harmonic"), 1.0, 120, length=Marched.load(saved).interface.x[-1] * 1)
    assert document["frictional_work"] == pytest.approx(
        whole.final_work_density.sum() * whole.grid.spacing, rel=0.05
    )


def test_interrupted_march_is_saved(tmp_path, monkeypatch, capsys):
    """Ctrl-C after 30 steps: the file holds them, and can go on."""

    @contextmanager
    def pressing(*_):
        yield lambda done, steps: os.kill(os.getpid(), signal.SIGINT) if done == 30 else None

    monkeypatch.setattr("compare.output.progress.progress_bar", pressing)
    saved = tmp_path / "march.h5"
    assert main(["solve", "harmonic", "--nodes", "100", "--save", str(saved)]) == 130
    assert "holds the march until" in " ".join(capsys.readouterr().err.split())
    marched = Marched.load(saved)
    assert marched.statistics.steps == 30
    monkeypatch.undo()
    assert main(["solve", "harmonic", "--go-on", str(saved), "--json"]) == 0


def test_going_on_with_another_scene_is_refused(tmp_path, capsys):
    saved = tmp_path / "march.h5"
    march(find_scene("ramp"), 0.5, 50, latest=1.0).save(saved)
    assert main(["solve", "harmonic", "--go-on", str(saved)]) == SceneError.exit_code
    assert main(["solve", "ramp", "--go-on", str(saved), "--nodes", "60"]) == SceneError.exit_code
    assert "leave one of the two out" in capsys.readouterr().err
    saved.write_bytes(saved.read_bytes()[:500])
    assert main(["solve", "ramp", "--go-on", str(saved)]) == 3
