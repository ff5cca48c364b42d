"""The chart of error against time: any scene, a named reference, and points that are kept."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from compare.chart import methods, points
from compare.chart.figure import by_scene, chart_figure, described, findings, judged_by, slope
from compare.chart.methods import METHODS, find_problem, measured, run_point
from compare.chart.points import Point, measure_all, not_measured, read_points, reference_of
from compare.output.tables import write_rows
from semianalytic.scene.errors import ComputationError, DataFileError, SceneError
from slipfront.cli.commands import main

FEW = {"exact": (1e-2, 1e-8), "march": (64, 128), "fem": (16, 32)}
"""Cheap settings, from coarse to fine."""
SI = """
friction = {friction}
units = "SI"
base = {{ pressure = 50e6, shear = 10e6 }}
load = {{ pressure = 0.0, shear = 40e6 }}
material = {{ shear_modulus = 32e9, density = 2700.0, poisson_ratio = 0.25 }}
"""


@pytest.fixture
def few(monkeypatch):
    """Few and coarse points, measured in this process, and a coarse marched reference."""
    for name, settings in FEW.items():
        monkeypatch.setitem(methods.METHODS, name, replace(METHODS[name], settings=settings))
    monkeypatch.setattr(points, "REFERENCE_NODES", 256)
    monkeypatch.setattr(points, "run_point", counted := Counted())
    return counted


class Counted:
    """`measured` in this process, or numbers in its place; it counts calls and may fail."""

    def __init__(self):
        self.calls, self.most, self.runs = [], math.inf, True

    def __call__(self, problem, method, setting):
        if len(self.calls) >= self.most:
            raise KeyboardInterrupt
        self.calls.append((problem.label, method, setting))
        if self.runs:
            return measured(problem, method, setting)
        return {"seconds": 1.0, "runs": 5, "status": "resolved", "slip_rate": problem.places}


@pytest.fixture
def wall(tmp_path):
    """A scene of a user's own in SI units."""
    (tmp_path / "wall.toml").write_text(SI.format(friction=0.4))
    return str(tmp_path / "wall.toml")


def made(**changes):
    """A point of preloaded with the given numbers."""
    row = ("preloaded", "", 1.0, "slip_rate", "march", 64, 1.0, 5, 1e-3, "resolved")
    return replace(
        Point(*row, "exact solver, rtol 1e-12", 1e-12, "abacus", "2026-01-01"), **changes
    )


@pytest.mark.parametrize(
    "scene",
    [
        *("wall", "ramp", "antiplane"),
        pytest.param("preloaded", marks=pytest.mark.slow),
        pytest.param("pair-slip", marks=pytest.mark.slow),
    ],
)
def test_errors_of_any_scene_fall_with_cost(scene, few, wall, tmp_path):
    problem = find_problem(wall if scene == "wall" else scene)
    measured_points = measure_all(tmp_path, [problem])
    groups = by_scene(measured_points)[scene]
    expected = {"ramp": ["march", "fem"], "pair-slip": ["exact", "fem"]}
    assert list(groups) == expected.get(scene, ["exact", "march", "fem"])
    for method, (coarse, fine) in groups.items():
        assert (coarse.setting, fine.setting) == FEW[method]
        assert 0 < fine.error < coarse.error < 0.1
        assert min(coarse.seconds, fine.seconds) > 0
    names = {"ramp": "march, 256 nodes", "pair-slip": "exact solver, rtol 1e-10"}
    (name,) = {point.reference for point in measured_points}
    assert name == names.get(scene, "exact solver, rtol 1e-12")
    exact = name.startswith("exact")
    assert (groups["fem"][0].reference_error <= 1e-9) is exact
    said = judged_by(measured_points, scene)
    assert re.search("one of the methods shown, and agrees with .*finite elements to", said)


@pytest.mark.slow
def test_lengths_and_times_of_si_scenes_change_no_error(few, wall, tmp_path):
    """The same scene in other units: errors are relative, and places follow the waves."""
    other = tmp_path / "other.toml"
    scaled = SI.format(friction=0.4).replace('units = "SI"', "")
    other.write_text(scaled.replace("e6", "").replace("32e9", "1").replace("2700.0", "1"))
    si, both = (
        measure_all(tmp_path / "charts", [find_problem(n)], fresh=True) for n in (wall, str(other))
    )
    for point, two in zip(si, both[6:], strict=True):
        assert point.error == pytest.approx(two.error, rel=1e-3, abs=1e-12)


def test_a_marched_reference_carries_its_own_error_estimate(few):
    quantity, values, bar = reference_of(find_problem("ramp"))
    fine = measured(find_problem("ramp"), "march", 1024)
    error = np.abs(fine[quantity] - values).sum() / np.abs(values).sum()
    assert 0 < error < bar < 0.01


@pytest.mark.slow
def test_slip_is_compared_where_nothing_slips_any_more(few, tmp_path):
    measured_points = measure_all(tmp_path, [find_problem("incident-pulse")])
    assert {point.quantity for point in measured_points} == {"slip"}
    assert {point.error < 0.2 for point in measured_points} == {True}


def test_a_method_that_refuses_a_scene_says_why(few, tmp_path):
    measured_points = measure_all(tmp_path, [find_problem("lift-off-shear")])
    refusing = [point for point in measured_points if point.method == "march"]
    assert all("tensile" in point.status and math.isnan(point.error) for point in refusing)
    *_, last = described(measured_points)
    assert "tensile" in last
    assert "march" not in judged_by(measured_points, "lift-off-shear")
    (legend,) = chart_figure(measured_points, "lift-off-shear").legends
    assert len(legend.get_texts()) == 3  # the band, too


def test_an_interrupted_chart_goes_on_and_repeats_nothing(few, tmp_path):
    few.runs, few.most, problems = False, 3, [find_problem("antiplane"), find_problem("preloaded")]
    with pytest.raises(KeyboardInterrupt):
        measure_all(tmp_path, problems)
    kept = read_points(tmp_path / points.FILE)
    assert [point.key for point in kept] == few.calls
    few.most, sentences, counts = math.inf, [], []
    whole = measure_all(
        tmp_path, problems, progress=lambda *at: counts.append(at), tell=sentences.append
    )
    assert whole[:3] == kept
    assert sorted(few.calls) == sorted({point.key for point in whole})
    assert counts == [(count, 12) for count in range(4, 13)]
    assert sentences == ["9 points to measure, 3 are there."]
    assert read_points(tmp_path / points.FILE) == whole
    again = measure_all(tmp_path, problems[:1], tell=sentences.append)
    assert sorted(point.key for point in again) == sorted(point.key for point in whole)
    assert (len(few.calls), len(sentences)) == (12, 1)
    measure_all(tmp_path, problems[:1], fresh=True)
    assert len(few.calls) == 18


def test_a_budget_leaves_out_finer_points_which_the_next_run_measures(few, tmp_path, monkeypatch):
    few.runs, clock, problems = False, [0.0], [find_problem("antiplane")]

    def now():
        clock[0] += 1.0
        return clock[0]

    monkeypatch.setattr(points, "monotonic", now)
    whole = [("antiplane", *task) for task in problems[0].tasks]
    some = measure_all(tmp_path, problems, budget=3.0)
    assert [entry.key for entry in some] == whole[:2]
    assert not_measured(problems, some) == whole[2:]
    again = measure_all(tmp_path, problems)
    assert sorted(few.calls) == sorted(whole)
    assert not_measured(problems, again) == []


def test_points_of_other_machines_versions_and_scenes_are_measured_anew(
    few, wall, tmp_path, monkeypatch
):
    few.runs = False
    measure_all(tmp_path, [find_problem(wall)])
    (tmp_path / "wall.toml").write_text(SI.format(friction=0.3))
    changed = measure_all(tmp_path, [find_problem(wall)])
    assert (len(few.calls), len(changed)) == (12, 6)
    measure_all(tmp_path, [find_problem(wall, 1e-3)])
    assert len(few.calls) == 18
    monkeypatch.setattr(points, "this_machine", lambda: "abacus")
    measure_all(tmp_path, [find_problem(wall, 1e-3)])
    assert len(few.calls) == 24


@pytest.mark.parametrize("damage", ["number", "cut", "other", "empty"])
def test_damaged_numbers_are_noticed(damage, few, tmp_path, refused):
    path = tmp_path / points.FILE
    write_rows(path, [made(), made(setting=128)], checked=True, command="slipfront chart preloaded")
    assert len(read_points(path)) == 2
    text = path.read_text()
    path.write_text(
        {"number": text.replace("0.001", "0.002"), "cut": text[:-40], "other": "a,b\n1,2\n"}.get(
            damage, ""
        )
    )
    with pytest.raises(DataFileError, match="move it away"):
        read_points(path)
    assert "move it away" in refused(["chart", "preloaded", "--quiet", "--output", tmp_path], 3)
    assert not few.calls


def test_scenes_without_a_chart_are_refused_in_one_sentence(few, tmp_path, refused):
    to = ["--output", str(tmp_path / "out")]
    assert "Nothing of stuck slips until t = 1" in refused(["chart", "stuck", *to])
    assert "There is no scene called 'nowhere'" in refused(["chart", "nowhere", *to])
    assert "takes only scenes with a slot" in refused(["chart", "whole-line-patch", *to])
    assert "same name" in refused(["chart", "preloaded", "preloaded", *to])
    assert "--end-time" in refused(["chart", "preloaded", "--end-time=-1", *to])
    assert list(tmp_path.iterdir()) == []


def test_a_reference_that_does_not_converge_is_none(few, tmp_path, monkeypatch, refused):
    def answer(*_):
        return type("Answer", (), {"status": "no set of zones fits"})

    monkeypatch.setattr(points, "exact", answer)
    assert "no set of zones fits" in refused(["chart", "--output", str(tmp_path / "out")], 4)


def test_findings_follow_from_points():
    law = [
        made(setting=n, seconds=s, error=3 * s**-1.5) for n, s in ((1, 10.0), (2, 50.0), (3, 1e3))
    ]
    assert slope(law) == pytest.approx(-1.5)
    assert slope([*law, made(seconds=1e4, error=1e-13)]) == pytest.approx(-1.5)
    assert math.isnan(slope(law[:1]))
    assert math.isnan(slope([law[0], law[0]]))
    (found,) = findings(law)
    assert (found.cheapest, found.cheapest_error) == (10.0, law[0].error)
    assert (found.seconds_to_percent, found.least_error) == (50.0, law[-1].error)
    assert "is compared with no other" in judged_by([made(method="exact")], "preloaded")
    table, *_ = described(law)
    assert table.row_count == 1


def test_a_point_is_measured_in_a_process_of_its_own():
    problem = find_problem("antiplane")
    there, here = (run(problem, "exact", 1e-4) for run in (run_point, measured))
    assert there["slip_rate"] == pytest.approx(here["slip_rate"])
    assert there["runs"] == 5
    with pytest.raises(ComputationError, match=r"exact solver on .* failed"):
        run_point(replace(problem, end_time="late"), "exact", 1e-4)


@pytest.mark.slow
def test_chart_from_the_command_line(tmp_path, monkeypatch, printed, shown):
    for name, settings in FEW.items():
        monkeypatch.setitem(methods.METHODS, name, replace(METHODS[name], settings=settings[:1]))
    line = ["chart", "antiplane", "--output", str(tmp_path)]
    said = shown(line)
    assert "3 points to measure, 0 are there." in said.err
    assert "Reference: exact solver, rtol 1e-12, uncertain by 1e-12" in said.out
    first = (tmp_path / "data" / "chart.csv").read_text().splitlines()[0]
    assert first == f"# slipfront chart antiplane --output {tmp_path}"
    assert (tmp_path / "data" / "chart-found.csv").read_text().startswith(first)
    assert (tmp_path / "figures" / "chart_antiplane.png").stat().st_size > 10_000
    document = printed([*line, "--figures", "svg"])
    assert [result["method"] for result in document["found"]] == [m.label for m in METHODS.values()]
    assert len(document["points"]) == 3
    with pytest.raises(SceneError):
        find_problem("nowhere")
    assert main([*line, "--quiet", "--fresh"]) == 0
