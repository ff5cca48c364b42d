"""What is written of a judgement and a solution, with units; what a case reads off meshes."""

import html
import json
import math
from dataclasses import replace

import pytest
from catalogue import UNIT_FILE, solved, under
from compare_cases import Spoilt, differing, named, sampled_run, simulated
from hypothesis import given
from hypothesis import strategies as st

from compare import judge
from compare.comparison.case import own_wear, worn_of
from compare.comparison.documents import edge_state, json_text, march_document, solution_document
from compare.comparison.judgement import side_by_side
from compare.comparison.judging import mesh_changes
from compare.comparison.measures import NOTHING
from compare.comparison.prediction import predict_like
from compare.comparison.report import report_document, write_page, write_report
from compare.comparison.scales import reference_values
from semianalytic import Material, Scene, SlipWeakening, Tractions, solve
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.answer import SlipInterval
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import scene_document, scene_from_document
from semianalytic.scene.given.finding import find_scene

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


def test_one_page_holds_the_verdict_reasons_and_figures(thin_gap, tmp_path):
    figure = tmp_path / "a.png"
    figure.write_bytes(b"picture")
    write_page(thin_gap, "<thin>", tmp_path / "page.html", [figure, tmp_path / "b.pdf"])
    page = (tmp_path / "page.html").read_text()
    assert page.startswith("<!DOCTYPE html>")
    assert f"<h1>&lt;thin&gt;: {thin_gap.said}</h1>" in page
    assert 'src="data:image/png;base64,cGljdHVyZQ=="' in page
    assert '<a href="b.pdf">' in page
    for row in thin_gap.rows:
        assert html.escape(row.name) in page
        assert html.escape(row.obstacle) in page


def test_an_unresolved_row_says_in_the_document_why_and_what_would_do(thin_gap):
    rows = {row["name"]: row for row in report_document(thin_gap, "thin")["rows"]}
    edge = rows["zone 2, inner edge"]
    assert edge["verdict"] == "unresolved"
    assert "elements" in edge["obstacle"]
    assert edge["resolution"] > 1000
    assert edge["remedy"].startswith(f"it would take `resolution` {edge['resolution']}, ")
    assert all(row["remedy"] == "" for row in rows.values() if row["verdict"] != "unresolved")


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


def test_edge_state_and_intensities(solution):
    stuck = solved(find_scene("stuck"))
    assert (edge_state(solution), edge_state(stuck)) == ("slipping", "stuck")
    intensity = solution_document(stuck)["edge"]["stress_intensity_at_unit_time"]
    material = stuck.scene.material
    # Theory: K_II / K_I = (Q_0 / P_0) sqrt(c_l / c_t) while the edge is stuck.
    ratio = math.sqrt(material.longitudinal_speed / material.shear_speed)
    assert intensity["K_II"] / intensity["K_I"] == pytest.approx(ratio, rel=1e-9)


# --- what a case reads off meshes -----------------------------------------------------------------


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=5))
def test_differences_add_up_from_the_finest_mesh_to_the_coarsest(values):
    changes = mesh_changes(values)
    assert len(changes) == len(values) - 1
    assert sum(changes) == pytest.approx(values[0] - values[-1], abs=1e-8)


@pytest.mark.parametrize(
    ("values", "changes"),
    [
        ([None, 1.0, 2.0], []),
        ([1.0, None, 2.0], []),
        ([3.0, 1.0, None], [2.0]),
        ([3.0, 1.0, None, 7.0], [2.0]),
    ],
)
def test_differences_end_at_the_first_mesh_that_does_not_show_a_value(values, changes):
    assert mesh_changes(values) == changes


@pytest.mark.slow
def test_bars_shrink_with_the_mesh(solution, coarse):
    """Bars of a simulation at h = 1/30 and at h = 1/60."""
    runs = simulated(PRELOADED, 30), coarse
    large, small = ({row.name: row for row in judge(solution, run).rows} for run in runs)
    both = [
        (name, small[name].bar, large[name].bar)
        for name in large.keys() & small.keys()
        if large[name].bar is not None and small[name].bar is not None
    ]
    assert len(both) >= 10
    for name, *bars in both:
        if name == "coarser runs against this one":  # a limit, which depends on the rows behind it
            continue
        if small[name].kind == "law":  # what a run has to hold on any mesh, but for rounding
            assert bars == [NOTHING, NOTHING], name
        elif not small[name].converges:  # its bar is the range of what the meshes show
            assert (name, small[name].verdict) == ("shear traction, L1", "unresolved")
        else:  # Pressure is that of the base to rounding throughout: its bar is none at all.
            assert bars[0] < bars[1] or name.startswith("pressure, "), name


def rounded(run):
    seen = replace(run.interface, pressure=run.interface.pressure * (1 + 1e-12))
    return replace(run, interface=seen, companion=run.companion and rounded(run.companion))


def test_rounding_is_no_difference(solution):
    """Pressure that is that of the base throughout, to twelve digits on each mesh."""
    rows = {row.name: row for row in judge(solution, rounded(sampled_run(solution, 40))).rows}
    pressure = rows["pressure, L1"]
    assert 0 < pressure.difference < 1e-11
    assert (pressure.verdict, pressure.obstacle) == ("agrees", "")


@pytest.mark.slow
def test_wear_is_the_answers_own_where_it_has_any_and_else_summed_over_the_times():
    run = sampled_run(solved(PRELOADED), resolution=40, times=200)
    x, end = run.interface.x, run.end_time
    own = {}
    for method in ("self-similar", "space-time"):
        prediction = predict_like(run, method)
        case = side_by_side(prediction, run)
        own[method] = [own_wear(prediction, x, end, part) for part in (0, 1)]
        for mine, at_nodes in zip(own[method], case.worn_at_nodes, strict=True):
            assert mine == pytest.approx(at_nodes, abs=0)
    for exact, marched in zip(*own.values(), strict=True):
        assert marched.sum() == pytest.approx(exact.sum(), rel=0.02)
    assert own_wear(run, x, end, 0) is own_wear(run, x, end, 1) is None
    summed = [worn_of(part, run, run.interface) for part in (0, 1)]
    for exact, values in zip(own["self-similar"], summed, strict=True):
        assert values.sum() == pytest.approx(exact.sum(), rel=0.01)
        assert values.sum() != exact.sum()


# --- units of what is printed ---------------------------------------------------------------------

STEEL = Scene(
    Material(80e9, 7800.0, 0.3), 0.3, Tractions(1e6, 0.0), Tractions(0.0, 1e6), units="SI"
)


def without_unit(document, units, path=""):
    """Paths of numbers that are no counts and have no unit under the same names."""
    if isinstance(units, str):
        return
    if isinstance(document, (list, tuple)):
        for item in document:
            yield from without_unit(item, units, path)
    elif isinstance(document, dict):
        for name, part in document.items():
            if name != "units":
                yield from without_unit(part, units.get(name, {}), f"{path}/{name}")
    elif isinstance(document, float):
        yield path


@pytest.mark.parametrize("name", ["preloaded", "stuck", "remote-shock", "auxetic"])
def test_every_number_of_a_solution_has_a_unit(name):
    document = solution_document(solved(find_scene(name)), end_time=0.5)
    assert list(without_unit(document, document["units"])) == []
    assert document["units"]["edge"]["slip_rate"] == "length/time"
    assert document["units"]["until_end_time"]["accumulated_slip"] == "length^2"


@pytest.mark.parametrize("name", ["ramp", "pulse", "harmonic", "weakening"])
def test_every_number_of_a_march_has_a_unit(name):
    weakening = under(find_scene("preloaded"), SlipWeakening(1.0, 0.5, 0.2))
    scene = weakening if name == "weakening" else find_scene(name)
    document = march_document(solve(scene, method="space-time", end_time=0.5, nodes=60))
    assert list(without_unit(document, document["units"])) == []
    assert document["units"]["largest_slip"] == "length"
    assert document["units"]["frictional_work"] == "stress length^2"
    assert document["units"]["onset"] == {"x": "length", "time": "time"}


def test_every_number_of_a_report_has_a_unit():
    solution = solved(STEEL)
    run = sampled_run(solution, resolution=60, end_time=1e-4)
    document = report_document(judge(solution, run), "steel")
    rows = document.pop("rows")
    assert len({row["name"] for row in rows}) == len(rows)
    own = document["semianalytic"]["units"]
    units = {**document["units"], "semianalytic": own}
    assert list(without_unit(document, units)) == []
    symbols = {symbol for row in rows for symbol in row["unit"].replace("²", "").split()}
    assert symbols == {"c_t", "T", "V₀", "τ₀", "1"}
    assert symbols - {"1"} == set(document["units"]["rows"])
    assert document["units"]["rows"]["T"] == "0.0001 s"


@pytest.mark.slow
def test_values_of_rows_are_what_their_units_say():
    """The integrals of slip and work over the contact, by another rule.

    The rows leave out the first 2 % of c_t T: there slip and work per area are nearly even.
    """
    solution, end_time = solved(STEEL), 1e-4
    run = sampled_run(solution, resolution=100, end_time=end_time)
    rows = {row.name: row for row in judge(solution, run).rows}
    speed, rate = STEEL.material.shear_speed, 2e6 / math.sqrt(80e9 * 7800.0)
    start = 0.02 * speed * end_time
    slip, work = rows["accumulated |slip|, L1"], rows["frictional work, L1"]
    assert (slip.unit, slip.relative) == ("V₀ T c_t T", True)
    assert (work.unit, work.relative) == ("τ₀ V₀ T c_t T", True)
    for row, unit_value, total, density in (
        (slip, rate * end_time, solution.accumulated_slip, solution.path),
        (work, 1e6 * rate * end_time, solution.frictional_work, solution.work_density),
    ):
        whole = float(total(end_time)) - start * float(density(start, end_time))
        assert row.at_nodes * unit_value * speed * end_time == pytest.approx(whole, rel=0.02)
        assert row.exact * unit_value * speed * end_time == pytest.approx(whole, rel=0.02)
    references = reference_values(STEEL, end_time)
    assert references["c_t"] == (STEEL.material.shear_speed, "m/s")
    assert references["V₀"][0] == pytest.approx(rate)


def test_units_are_carried_by_documents_and_make_no_other_scene():
    assert scene_from_document(scene_document(STEEL)).units == "SI"
    assert replace(STEEL, units="") == STEEL
    assert "units" not in scene_document(replace(STEEL, units=""))
    with pytest.raises(SceneError, match="units must be"):
        replace(STEEL, units="cgs")


def test_tables_say_units(tmp_path, shown, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    path = tmp_path / "scene.toml"
    path.write_text('units = "SI"\n' + UNIT_FILE)
    said = shown(["solve", path, "--end-time", "1e-4"]).out
    for words in ("[m/s]", "Pa sqrt(m)", "m^2", "J/m", "t = 0.0001 s"):
        assert words in said
    path.write_text(UNIT_FILE)
    said = shown(["solve", path]).out
    assert "[length/time]" in said
    assert "m/s" not in said
