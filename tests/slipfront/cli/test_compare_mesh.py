"""`slipfront compare` chooses its mesh, and simulations carry their error bars."""

import json
import re
from pathlib import Path

import pytest

import fem.budget
from compare.comparison.mesh_choice import choose_mesh
from fem import cost
from fem.results import load_simulation
from semianalytic.scene.given.finding import find_scene
from slipfront.cli import simulate_command

COARSE = "--resolution 32 --no-snapshots --output out"
GAP = "compare preloaded --friction 0.15 --no-snapshots --output out"


@pytest.fixture(autouse=True)
def _known_pace(monkeypatch):
    """The machine has a known pace, and drawing and judging take no time."""
    monkeypatch.setattr(fem.budget, "machine_pace", lambda: 1.0)
    for name in ("DRAWN", "JUDGED"):
        monkeypatch.setattr(f"compare.comparison.mesh_choice.{name}", 0.0)


def budget_for(resolution):
    """Time that is enough for the default scene at a resolution and not for the next one."""
    choice = choose_mesh(None, find_scene("preloaded"), resolution=resolution)
    return f"{1.01 * choice.seconds:.6f}s"


def companions():
    """Resolutions of a simulation and of what it carries."""
    run, resolutions = load_simulation("out"), []
    while run is not None:
        resolutions.append(run.resolution)
        run = run.companion
    return resolutions


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_compare_says_its_mesh_and_what_stays_unresolved_before_it_starts(shown):
    said = shown(f"{GAP} --budget {budget_for(48)}").err
    told = [line for line in said.splitlines() if "this will take about" not in line]
    chosen, unresolved, ran = told[:3]  # a busy machine may exceed so small a budget
    resolution, *coarser = companions()
    assert resolution == 48
    assert coarser == [resolution // 2, resolution // 4]
    assert chosen.startswith(
        f"preloaded: resolution {resolution} (the finest within budget and memory): about 0."
    )
    assert unresolved == (
        "preloaded: will stay unresolved: the gap between 0.9323 and 0.9328 c_t; it would take "
        "--resolution 14995, more than a mesh may have."
    )
    assert ran.startswith("preloaded: mesh size")
    assert "preloaded: slip rate at the end within " in said
    rows = json.loads(Path("out/report.json").read_text())["rows"]
    remedies = {row["resolution"] for row in rows if "gap" in row["obstacle"]}
    assert remedies == {14995}


@pytest.mark.parametrize(
    ("time", "seconds"),
    [("60s", 60), ("60", 60), ("2min", 120), ("1.5 m", 90), ("1h", 3600), (".5H", 1800)],
)
def test_times_are_typed_as_people_write_them(time, seconds, monkeypatch, shown):
    given = []

    def choose(*_, budget, **__):
        given.append(budget)
        raise KeyboardInterrupt

    monkeypatch.setattr("compare.comparison.prediction.choose_mesh", choose)
    shown(["compare", "stuck", "--budget", time], 130)
    assert given == [seconds]


def test_an_interruption_of_companions_loses_nothing_of_the_simulation(monkeypatch, shown):
    def interrupt(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("fem.companions.run_plan", interrupt)
    shown(f"compare preloaded {COARSE}", 130)
    assert companions() == [32]


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_error_bars_that_are_missing_are_made_and_kept(shown, monkeypatch):
    assert "within" not in shown(f"simulate preloaded {COARSE} --no-companions").err
    assert companions() == [32]
    before = Path("out/simulation.h5").read_bytes()
    shown("compare --from out --output elsewhere")
    assert Path("out/simulation.h5").read_bytes() == before
    assert not Path("elsewhere/simulation.h5").exists()
    assert "out: slip rate at the end within" in shown("compare --from out").err
    assert companions() == [32, 16, 8]
    for name in ("fem.simulate", "fem.companions.run_plan"):
        monkeypatch.setattr(name, pytest.fail)
    assert shown("compare --from out").err == ""  # nothing is run again


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("scene", "sentence"),
    [
        ("preloaded", r"slip rate at the end within \d+(\.\d+)? %, slip within \d+(\.\d+)? %, by"),
        ("stuck", r"slip rate at the end within 1e-06 V₀, slip within 1e-06 V₀ T, by"),
    ],
)
def test_simulate_says_how_far_it_may_be_off(scene, sentence, shown):
    last = shown(f"simulate {scene} {COARSE}").err.splitlines()[-1]
    assert companions() == [32, 16, 8]
    assert re.fullmatch(rf"{scene}: {sentence} coarser meshes\.", last)


def test_simulate_says_that_there_are_no_error_bars(shown):
    told = shown("simulate stuck --resolution 12 --no-snapshots --output out").err
    assert "stuck: no error bars, for there is no coarser mesh." in told
    assert companions() == [12]


@pytest.mark.parametrize(("late", "told"), [(1.0, 0), (1.1, 0), (3.0, 1)])
def test_an_overrun_is_said_once_before_it_happens(late, told, monkeypatch):
    """A budget allows 10 s, of which 6 s are steps, and these take as long or longer."""
    clock = iter([0.0, *(0.6 * late * step for step in range(1, 11))])
    monkeypatch.setattr(simulate_command, "monotonic", lambda: next(clock))
    steps, sentences = [], []
    predicted = cost(find_scene("preloaded"))
    allowed = (predicted.seconds / 0.6, 10.0)
    watch = simulate_command.watched(
        lambda step, _: steps.append(step), predicted, allowed, "preloaded", sentences.append
    )
    for step in range(1, 11):
        watch(step, 10)
    assert steps == list(range(1, 11))
    assert len(sentences) == told
    for sentence in sentences:
        assert "about 30 s, more than the budget of 10 s" in sentence
