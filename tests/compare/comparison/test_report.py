"""What is written of a judgement and of a solution: whole, finite, with a verdict for each row."""

import json
import math
from dataclasses import replace

import pytest
from catalogue import solved
from compare_cases import Spoilt, differing, named, sampled_run, simulated

from compare import judge
from compare.comparison.documents import edge_state, json_text, solution_document
from compare.comparison.report import report_document, write_report
from semianalytic.results.answer import SlipInterval
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.overriding import override_scene

PRELOADED = find_scene("preloaded")
FIELDS = {
    *("name", "kind", "exact", "at_nodes", "simulated", "difference", "bar", "unit", "relative"),
    *("order", "obstacle", "resolution", "converges", "place", "verdict", "remedy"),
}


@pytest.fixture(scope="module")
def thin_gap():
    """A judgement with rows of all but one verdict: the gap is narrower than the mesh sees."""
    scene = override_scene(PRELOADED, friction=0.15)
    return judge(solved(scene), simulated(scene, 40))


def strict(text):
    return json.loads(text, parse_constant=pytest.fail)


def test_document_is_written_as_json_and_complete(thin_gap, tmp_path):
    path = tmp_path / "results" / "report.json"
    write_report(thin_gap, "thin", path)
    document = strict(path.read_text())
    assert document == strict(json_text(report_document(thin_gap, "thin")))
    assert (document["scene"], document["verdict"]) == ("thin", thin_gap.verdict)
    assert document["counts"] == thin_gap.counts
    assert sum(document["counts"].values()) == len(document["rows"]) == len(thin_gap.rows)
    for row, written in zip(thin_gap.rows, document["rows"], strict=True):
        assert set(written) == FIELDS
        assert (written["name"], written["verdict"]) == (row.name, row.verdict)
    assert document["finite_elements"]["resolution"] == 40
    assert document["finite_elements"]["companions"] == [20, 10]
    assert document["semianalytic"]["scene"]["friction"] == 0.15
    assert document["method"] == "self-similar"


def test_an_unresolved_row_says_in_the_document_why_and_what_would_do(thin_gap):
    rows = {row["name"]: row for row in report_document(thin_gap, "thin")["rows"]}
    edge = rows["zone 2, inner edge"]
    assert edge["verdict"] == "unresolved"
    assert "elements" in edge["obstacle"]
    assert edge["resolution"] > 1000
    assert edge["remedy"].startswith(f"resolution {edge['resolution']}, h = ")
    assert all(row["remedy"] == "" for row in rows.values() if row["verdict"] != "unresolved")


@pytest.mark.slow
def test_no_value_is_null_where_there_is_none(thin_gap):
    """No bar without companions, no value where a zone is missing: null and not NaN."""
    run = sampled_run(solved(PRELOADED), resolution=14, companions=0)
    document = strict(json_text(report_document(judge(solved(PRELOADED), run), "")))
    assert document["verdict"] == "unresolved"
    bars = {row["kind"] == "law": set() for row in document["rows"]}
    for row in document["rows"]:
        bars[row["kind"] == "law"].add(row["bar"])
    assert bars[False] == {None}
    assert None not in bars[True]  # what a run has to hold by itself needs no companions
    assert document["finite_elements"]["companions"] == []
    stuck = replace(run, interface=replace(run.interface, slip_rate=0 * run.interface.slip_rate))
    rows = strict(json_text(report_document(judge(solved(PRELOADED), stuck), "")))["rows"]
    edges = [row for row in rows if row["kind"] == "zone edge"]
    assert edges
    assert {row["simulated"] for row in edges} == {row["difference"] for row in edges} == {None}


def test_predictions_that_are_no_solution_are_described_by_their_class(solution):
    """What is judged is asked for its zones, not of its class."""
    run, zone = sampled_run(solution), SlipInterval(0.0, 0.5, 1)
    judgement = judge(Spoilt(solution), run)
    document = report_document(judgement, "")
    assert (document["method"], document["semianalytic"]) == ("Spoilt", None)
    assert judgement.verdict == "agrees"
    other = judge(Spoilt(solution, zones_at=lambda t: (zone,)), run)
    assert named(other)["zone 1, outer edge"].exact == 0.5
    assert any(name.startswith("unpredicted slip") for name in differing(other))


@pytest.mark.slow
def test_whole_interface_slipping_is_compared_too():
    solution = solved(override_scene(find_scene("remote-shock"), friction=0.5))
    assert judge(solution, sampled_run(solution)).verdict == "agrees"
    document = solution_document(solution)
    assert document["zones"][-1]["outer"] is None
    assert document["far_slip_rate"] == pytest.approx(1.0)


def test_edge_state_and_intensities(solution):
    stuck = solved(find_scene("stuck"))
    assert (edge_state(solution), edge_state(stuck)) == ("slipping", "stuck")
    intensity = solution_document(stuck)["edge"]["stress_intensity_at_unit_time"]
    material = stuck.scene.material
    # Theory: K_II / K_I = (Q_0 / P_0) sqrt(c_l / c_t) while the edge is stuck.
    ratio = math.sqrt(material.longitudinal_speed / material.shear_speed)
    assert intensity["K_II"] / intensity["K_I"] == pytest.approx(ratio, rel=1e-9)
