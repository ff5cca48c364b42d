"""Rows and report: what agrees passes, what is off by a known amount fails by that amount."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from compare_cases import sampled_run

from compare.cli.terminal import reasons_text
from compare.comparison.arrival_rows import arrival_rows
from compare.comparison.documents import edge_state, json_text, solution_document
from compare.comparison.edge_rows import onset_rows, zone_rows
from compare.comparison.prediction import prediction_at_nodes
from compare.comparison.profile_rows import slip_rate_rows, snapshot_rows, traction_rows
from compare.comparison.report import build_report, report_document, write_report
from compare.comparison.rows import Row
from compare.comparison.snapshots import SlipRateProfile
from semianalytic import solve
from semianalytic.scene.named import NAMED_SCENES, find_scene, override_scene


@pytest.fixture(scope="module")
def preloaded():
    return solve(find_scene("preloaded"))


@pytest.fixture(scope="module")
def faultless(preloaded):
    """A run of the preloaded scene without any error, and its report."""
    run = sampled_run(preloaded)
    return run, build_report("preloaded", prediction_at_nodes(run), run)


@pytest.fixture(scope="module")
def stuck():
    return solve(find_scene("stuck"))


def test_report_tells_what_the_march_misses(faultless):
    report = faultless[1]
    assert report_document(report)["caution"] == ""
    assert "unresolved" not in reasons_text(report)
    prediction = replace(report.prediction, caution="the edge slips over a length of 0.001")
    told = replace(report, prediction=prediction)
    assert report_document(told)["caution"] == prediction.caution
    assert "The march is unresolved: the edge slips over a length of 0.001." in reasons_text(told)


@pytest.mark.parametrize(
    "name",
    [
        name
        for name, named in NAMED_SCENES.items()
        if named.scene.is_self_similar and name != "lift-off"
    ],
)
def test_a_run_without_error_passes_with_nothing_but_rounding(name):
    solution = solve(NAMED_SCENES[name].scene)
    run = sampled_run(solution)
    report = build_report(name, prediction_at_nodes(run), run)
    assert report.passed
    # Waveforms are aligned through a table of 801 values: a fraction of its spacing is left.
    assert max(abs(row.difference) for row in report.rows if row.present) < 2e-3


def test_units_do_not_matter(preloaded):
    steel = override_scene(
        preloaded.scene,
        shear_modulus=80e9,
        density=7800.0,
        base_pressure=1e6,
        load_shear=1e6,
    )
    scaled = solve(steel)
    plain, rows = (
        build_report("", prediction_at_nodes(run), run).rows
        for run in (
            sampled_run(preloaded, stretch=1.01),
            sampled_run(scaled, end_time=3e-5, stretch=1.01),
        )
    )
    for one, other in zip(plain, rows, strict=True):
        assert one.quantity == other.quantity
        assert one.difference == pytest.approx(other.difference, abs=1e-4)


def test_arrivals_off_by_one_percent_say_so(preloaded):
    present = [
        r for r in arrival_rows(preloaded, sampled_run(preloaded, stretch=1.01)) if r.present
    ]
    assert len(present) >= 3
    for row in present:
        # A fifth of an element, 0.01.
        assert row.difference == pytest.approx(0.01 * row.prediction, abs=2e-3)


def test_zone_edges_off_by_five_percent_fail_by_five_percent(preloaded):
    rows = list(zone_rows(preloaded, sampled_run(preloaded, stretch=1.05)))
    assert len(rows) == 3
    for row in rows:
        # Half an element, 0.01: the edge moves past the samples it is read from.
        assert row.difference == pytest.approx(0.05 * row.prediction, abs=5e-3)
        assert not row.passed


def test_onset_comes_earlier_when_speeds_are_larger(preloaded):
    run = sampled_run(preloaded, times=100, stretch=1.05)
    for row in onset_rows(preloaded, run):
        # Interpolated between a hundred times: less than the step between two.
        assert row.simulation == pytest.approx(row.prediction / 1.05, abs=0.01)


def test_slip_rate_and_tractions_off_by_three_percent_say_so(preloaded):
    run = sampled_run(preloaded, gain=1.03)
    for row in (*slip_rate_rows(preloaded, run), *traction_rows(preloaded, run)):
        assert row.difference == pytest.approx(0.03)
        assert not row.passed


def test_a_zone_the_simulation_does_not_see_fails(preloaded):
    run = sampled_run(preloaded)
    ahead = run.interface.x / run.interface.t[-1] > 0.95
    run.interface = replace(run.interface, slip_rate=np.where(ahead, 0.0, run.interface.slip_rate))
    rows = {row.quantity: row for row in zone_rows(preloaded, run)}
    assert rows["zone 1, outer edge"].passed
    assert rows["zone 2, inner edge"].simulation is None
    assert not rows["zone 2, inner edge"].passed


def test_a_stuck_interface_has_no_onset_and_no_zone(stuck):
    run = sampled_run(stuck)
    assert not list(zone_rows(stuck, run))
    assert all(row.passed and not row.present for row in onset_rows(stuck, run))
    (row,) = slip_rate_rows(stuck, run)
    assert (row.prediction, row.simulation) == (0.0, 0.0)


def test_slip_where_none_is_predicted_fails(stuck):
    run = sampled_run(stuck)
    run.interface = replace(run.interface, slip_rate=run.interface.slip_rate + 0.1)
    assert not any(row.passed for row in onset_rows(stuck, run))
    (row,) = slip_rate_rows(stuck, run)
    assert not row.passed


def test_every_signal_on_either_face_has_a_row(faultless):
    quantities = [row.quantity for row in faultless[1].rows]
    for signal in ("Rayleigh", "S", "P"):
        for face in ("interface", "slot face"):
            assert sum(q.startswith(f"{signal} arrival on the {face}") for q in quantities) == 1


def test_tolerances_shrink_with_the_mesh(preloaded):
    coarse, fine = (
        build_report("", prediction_at_nodes(run), run).rows
        for run in (sampled_run(preloaded, resolution=n) for n in (40, 80))
    )
    for wide, narrow in zip(coarse, fine, strict=True):
        assert narrow.tolerance < wide.tolerance
        assert wide.reason


@pytest.mark.parametrize(
    ("prediction", "simulation", "present", "passed"),
    [(1.0, 1.01, True, True), (1.0, None, True, False), (None, None, False, True)],
)
def test_a_row_knows_whether_it_is_present_and_passes(prediction, simulation, present, passed):
    difference = None if simulation is None else simulation - prediction
    row = Row("speed", prediction, simulation, difference, 0.02, "mesh")
    assert (row.present, row.passed) == (present, passed)


def test_whole_interface_slipping_is_compared_too():
    solution = solve(override_scene(find_scene("remote-shock"), friction=0.5))
    run = sampled_run(solution)
    report = build_report("shock", prediction_at_nodes(run), run)
    assert report.passed
    document = solution_document(solution)
    assert document["zones"][-1]["outer"] is None
    assert document["far_slip_rate"] == pytest.approx(1.0)


def test_document_is_written_as_json_and_complete(faultless, tmp_path):
    _, report = faultless
    path = tmp_path / "results" / "report.json"
    write_report(report, path)
    document = json.loads(path.read_text())
    assert document == json.loads(json_text(report_document(report)))
    assert document["passed"] is True
    assert len(document["rows"]) == len(report.rows)
    for row in document["rows"]:
        assert {"quantity", "prediction", "simulation", "difference", "tolerance"} < set(row)
    assert document["finite_elements"]["resolution"] == 100
    assert document["semianalytic"]["scene"]["friction"] == 0.3


def test_edge_state_and_intensities(preloaded, stuck):
    assert edge_state(preloaded) == "slipping"
    assert edge_state(stuck) == "stuck"
    intensity = solution_document(stuck)["edge"]["stress_intensity_at_unit_time"]
    material = stuck.scene.material
    # Theory: K_II / K_I = (Q_0 / P_0) sqrt(c_l / c_t) while the edge is stuck.
    ratio = math.sqrt(material.longitudinal_speed / material.shear_speed)
    assert intensity["K_II"] / intensity["K_I"] == pytest.approx(ratio, rel=1e-9)


def test_a_snapshot_is_compared_at_its_own_time(preloaded, faultless):
    run, _ = faultless
    x = run.interface.x
    profile = SlipRateProfile(0.5, x, 1.03 * preloaded.slip_rate(x, 0.5))
    (row,) = snapshot_rows(preloaded, run, profile)
    assert row.difference == pytest.approx(0.03)
    assert row in build_report("preloaded", prediction_at_nodes(run), run, profile).rows
