"""The chart of error against time: what it covers, what it keeps, what it says."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compare.comparison.measures import relative_error
from compare.output.tables import write_rows
from compare.studies.chart import reference as chart_reference
from compare.studies.chart import study as chart
from compare.studies.chart.figure import (
    FAILS,
    LEVELS,
    STYLES,
    chart_text,
    cheapest,
    slope,
    slopes_table,
)
from compare.studies.chart.methods import METHODS, PLACES, answer, measured, sampled
from compare.studies.chart.points import COMMAND, SCENES, read_points, same_machine
from compare.studies.chart.reference import (
    CLOSED_FORM_FRICTION,
    closed_form_errors,
    reference_of,
    richardson,
    worst_edge_error,
)
from compare.studies.chart.study import measure_all, missing, tasks
from compare.studies.chart.tasks import Task
from fem.run import peak_memory
from semianalytic import SlipZone
from semianalytic.scene.errors import ComputationError, DataFileError, SceneError
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.commands import main

MINI = {
    "self-similar": (1e-2, 1e-8),
    "first-stage": (20.0, 40.0),
    "space-time": (32.0, 64.0),
    "fem": (25.0,),
}
"""Cheap points for a chart of one scene."""


@pytest.fixture
def mini(monkeypatch):
    """A chart of a few cheap points; the processes that measure them know all methods."""
    few = {name: replace(METHODS[name], quick=settings) for name, settings in MINI.items()}
    monkeypatch.setattr(chart, "METHODS", few)


@pytest.fixture
def in_process(monkeypatch):
    """Measure in this process: what is tested is not memory."""

    def run(task, runs):
        return measured(task.scene_name, task.method, task.setting, 1)

    for module in (chart, chart_reference):
        monkeypatch.setattr(module, "run_task", run)


@pytest.fixture(scope="module")
def measured_once():
    """Text of the file of a mini chart."""
    return []


@pytest.fixture
def points(mini, in_process, measured_once, tmp_path):
    """Points of a mini chart, in `tmp_path`."""
    path = tmp_path / "data" / "chart.csv"
    if not measured_once:
        measure_all(path, ["preloaded"], quick=True)
        measured_once.append(path.read_bytes())
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(measured_once[0])
    return read_points(path)


def test_methods_cover_what_was_asked_for():
    full = tasks(SCENES, quick=False)
    on = {scene: {task.method for task in full if task.scene_name == scene} for scene in SCENES}
    assert on["ramp"] == {name for name in METHODS if name.startswith(("space", "fem"))}
    assert on["remote-shock"] == set(METHODS)
    assert on["preloaded"] == on["auxetic"] == set(METHODS) - {"published"}
    for name, least, largest in (
        ("self-similar", 1e-12, 1e-2),
        ("self-similar-cold", 1e-12, 1e-2),
        ("first-stage", 20, 640),
        ("space-time", 128, 8192),
        ("fem", 50, 400),
    ):
        assert (min(METHODS[name].full), max(METHODS[name].full)) == (least, largest)
    labels = " ".join(method.label for method in METHODS.values())
    for part in ("P1 squares", "P1 triangles", "Q2", "graded", "two blocks", "undamped", "whole"):
        assert part in labels
    assert set(STYLES) == set(METHODS)
    assert len({*STYLES.values()}) == len(METHODS)


def test_other_scenes_are_refused(tmp_path, refused):
    with pytest.raises(SceneError, match="choose preloaded, remote-shock"):
        tasks(["lift-off"], quick=True)
    assert "preloaded" in refused(["chart", "lift-off", "--output", tmp_path])


@pytest.mark.parametrize("scene", CLOSED_FORM_FRICTION)
def test_references_agree_with_closed_forms(scene):
    described = replace(find_scene(scene), friction=CLOSED_FORM_FRICTION[scene])
    slip_rate, edge = closed_form_errors(described)
    assert slip_rate < 1e-11
    assert math.isnan(edge) == (scene == "remote-shock")
    assert not edge > 1e-11


def test_measure_reads_profile_and_edges_off_samples():
    scene = find_scene("preloaded")
    velocity = np.linspace(0.0, 2.0, 401)
    profile = np.sqrt(np.maximum(0.8 - velocity, 0.0))
    at_places, zones = sampled(scene, velocity, profile)
    assert relative_error(at_places, np.sqrt(np.maximum(0.8 - PLACES, 0)), PLACES, 1) < 1e-3
    assert zones[0].inner == 0.0
    assert zones[0].outer == pytest.approx(0.8, abs=1e-3)
    assert sampled(scene, velocity, 0 * velocity)[1] == ()


def test_worst_edge():
    expected = [SlipZone(0.0, 0.8, 1), SlipZone(0.9, 1.1, 1)]
    assert worst_edge_error(expected, expected) == 0.0
    assert worst_edge_error([SlipZone(0, 0.81, 1), SlipZone(0.93, 1.1, 1)], expected) == (
        pytest.approx(0.03)
    )
    assert worst_edge_error(expected[:1], expected) == math.inf
    assert worst_edge_error([replace(zone, sense=-1) for zone in expected], expected) == math.inf
    everywhere = [SlipZone(0.0, math.inf, 1)]
    assert worst_edge_error(everywhere, everywhere) == 0.0
    assert worst_edge_error([], []) == 0.0


def test_richardson_removes_its_order():
    for order in (1, 2):
        assert richardson(1 + 0.2**order, 1 + 0.1**order, order) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.slow
def test_reference_of_a_ramp_is_what_two_methods_agree_on(in_process, monkeypatch):
    grids = {"space-time": (128, 256), "fem": (25, 50)}
    monkeypatch.setattr(chart_reference, "REFERENCE_GRIDS", {True: grids})
    reference = reference_of("ramp", quick=True)
    assert 1e-4 < reference.error < 1e-2
    assert reference.edge_error < 0.05
    assert [zone.sense for zone in reference.zones] == [1]
    seen = answer("ramp", "space-time", 512)
    assert relative_error(seen.slip_rate, reference.slip_rate, PLACES, 1) < reference.error
    assert worst_edge_error(seen.zones, reference.zones) < 0.01


def test_peak_memory_is_that_of_this_program():
    assert 1e7 < peak_memory() < 1e11


def test_a_scene_out_of_reach_is_an_answer_that_says_so():
    found = answer("ramp", "self-similar", 1e-2)
    assert "step loads" in found.status
    assert np.isnan(found.slip_rate).all()


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["preloaded", "remote-shock"])
def test_errors_fall_in_the_order_of_the_methods(scene):
    """Errors only: no time is compared."""
    exact = reference_of(scene, quick=True).slip_rate

    def error(method, setting):
        return relative_error(answer(scene, method, setting).slip_rate, exact, PLACES, 1)

    assert error("self-similar", 1e-8) < 1e-8 < error("self-similar", 1e-2)
    assert error("self-similar", 1e-2) < error("space-time", 256) < error("fem", 50)
    assert error("fem", 50) < error("fem-undamped", 50)
    assert error("self-similar", 1e-2) < error("first-stage", 80)
    if scene == "remote-shock":
        assert error("published", 200) > 1


@pytest.mark.slow
def test_points_survive_the_file_and_their_errors_reproduce(points, tmp_path):
    assert read_points(tmp_path / "data" / "chart.csv") == points
    assert [point.method for point in points] == [n for n, s in MINI.items() for _ in s]
    reference = reference_of("preloaded", quick=True)
    for point in points:
        assert same_machine(point)
        assert min(point.runs, point.memory, point.seconds) > 0
        again = chart.measure(Task(point.scene_name, point.method, point.setting), reference, True)
        assert again.error == pytest.approx(point.error, rel=1e-6, abs=1e-13)
        assert again.edge_error == pytest.approx(point.edge_error, rel=1e-6, abs=1e-13)


@pytest.mark.slow
def test_interrupted_run_goes_on_and_a_fresh_one_measures_again(
    mini, in_process, tmp_path, monkeypatch
):
    path, before = tmp_path / "data" / "chart.csv", chart.run_task
    done, last = [], [3]

    def interrupted(task, runs):
        if len(done) == last[0]:
            raise KeyboardInterrupt
        done.append(task)
        return before(task, runs)

    monkeypatch.setattr(chart, "run_task", interrupted)
    with pytest.raises(KeyboardInterrupt):
        measure_all(path, ["preloaded"], quick=True)
    kept = read_points(path)
    assert [Task(p.scene_name, p.method, p.setting) for p in kept] == done
    assert not list(tmp_path.glob(".*"))

    last[0], seen, told = math.inf, [], []
    whole = measure_all(
        path, ["preloaded"], quick=True, progress=lambda *at: seen.append(at), tell=told.append
    )
    assert whole[:3] == kept
    assert len(whole) == len(done) == 7
    assert seen == [(count, 7) for count in range(4, 8)]
    assert told[0].startswith("4 points to measure, 3 are there: about ")
    assert measure_all(path, ["preloaded"], quick=True, tell=told.append) == whole
    assert len(told) == 1
    measure_all(path, ["preloaded"], quick=True, fresh=True)
    assert (len(done), len(read_points(path))) == (14, 7)


def test_points_of_another_machine_do_not_count(points):
    elsewhere = [replace(point, machine="abacus") for point in points]
    wanted = [Task(point.scene_name, point.method, point.setting) for point in points]
    assert missing(wanted, points) == []
    assert missing(wanted, elsewhere) == wanted


def test_quick_and_full_charts_do_not_mix(points, tmp_path):
    path = tmp_path / "ramp.csv"
    other = replace(points[-1], scene_name="ramp", reference="another")
    write_rows(path, [other], checked=True, command=COMMAND)
    with pytest.raises(SceneError, match="another reference"):
        measure_all(path, ["ramp"])


@pytest.mark.thinned(3)
@pytest.mark.parametrize("damage", ["", "scene_name,method\n", "cut", "number", "method"])
def test_damaged_file_is_refused(points, tmp_path, damage, refused):
    path = tmp_path / "data" / "chart.csv"
    text = path.read_text()
    path.write_text(
        {
            "cut": text[:-40],
            "number": text.replace("20.0,", "twenty,", 1),
            "method": text.replace("first-stage", "second-stage"),
        }.get(damage, damage)
    )
    with pytest.raises(DataFileError, match="move it away"):
        read_points(path)
    refused(["chart", "preloaded", "--quick", "--quiet", "--output", tmp_path], 3)


@pytest.mark.slow
def test_broken_process_is_reported():
    with pytest.raises(ComputationError, match="ended with code 1"):
        chart.run_task(Task("nowhere", "fem", 25.0), 1)


def test_slope_is_that_of_a_power_law(points):
    law = [
        replace(points[0], setup=0.1 * time, solving=0.9 * time, error=3 * time**-1.5)
        for time in (0.1, 1.0, 10.0)
    ]
    assert slope(law) == pytest.approx(-1.5)
    assert slope([*law, replace(law[0], error=1e-16)]) == pytest.approx(-1.5)
    assert math.isnan(slope(law[:1]))
    assert math.isnan(slope([law[0], law[0]]))


def test_recommendations_are_the_fastest_that_are_good_enough(points):
    for level in LEVELS:
        found = cheapest(points, level)
        assert found.error <= level
        assert all(p.seconds >= found.seconds for p in points if p.error <= level)
    vague = [replace(point, reference_error=0.005) for point in points]
    assert cheapest(vague, 1e-3) is None
    assert cheapest(vague, 1e-2) is not None
    assert "below 1.0e-12, the reference" in chart_text([replace(p, error=0.0) for p in points])


def test_text_and_table_come_from_the_points(points):
    text = chart_text(points)
    assert "stability.md#the-first-stage" in text
    assert f"{points[-1].error:.1e}" in text
    for name in MINI:
        assert METHODS[name].label in text
    assert slopes_table(points).row_count == len(METHODS)
    missed = [replace(point, edge_error=math.inf) for point in points]
    assert "zones missed at 2 of 2 settings" in chart_text(missed)
    assert "perhaps" in chart_text([replace(points[0], status="perhaps."), *points[1:]])


def test_links_lead_to_headings():
    docs = Path(chart.__file__).parents[3] / "docs"
    for reason in FAILS.values():
        for link in reason.split("](")[1:]:
            name, _, anchor = link.split(")")[0].partition("#")
            headings = [
                "".join(c for c in line.lstrip("# ").lower() if c.isalnum() or c in " -")
                for line in (docs / name).read_text().splitlines()
                if line.startswith("#")
            ]
            assert not anchor or anchor in [heading.replace(" ", "-") for heading in headings]


@pytest.mark.slow
def test_chart_from_the_command_line(tmp_path, monkeypatch, capsys):
    """The points in processes of their own, as always."""
    few = {"self-similar": (1e-2,), "first-stage": (20.0,)}
    methods = {name: replace(METHODS[name], quick=settings) for name, settings in few.items()}
    monkeypatch.setattr(chart, "METHODS", methods)
    arguments = ["chart", "preloaded", "--quick", "--output", str(tmp_path)]
    assert main(arguments) == 0
    shown = capsys.readouterr()
    assert "2 points to measure" in shown.err
    assert "time^slope" in shown.out
    assert (tmp_path / "figures" / "chart_preloaded.png").stat().st_size > 10_000
    assert (tmp_path / "chart.md").read_text() in shown.out
    stored = (tmp_path / "data" / "chart.csv").read_bytes()
    assert main(arguments) == 0
    assert "points to measure" not in capsys.readouterr().err
    assert (tmp_path / "data" / "chart.csv").read_bytes() == stored
