"""Sheets of interfaces: their answers, their scores, and what a spoilt run gets."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to, changes, written_document
from compare.benchmarks.classes import CLASSES, tolerances
from compare.benchmarks.documents import sheet_document, sheets_document
from compare.benchmarks.entries import Run, enter, read_run, write_run
from compare.benchmarks.export import exported
from compare.benchmarks.interfaces import reference
from compare.benchmarks.interfaces.entries import run_stations
from compare.benchmarks.interfaces.reference import off, reference_changes
from compare.benchmarks.pages import as_markdown, sheet_blocks
from compare.benchmarks.scores import score
from compare.benchmarks.sheets import INTERFACE_SHEETS, find_sheet
from compare.records.record import Record, Records
from semianalytic import DataFileError, Scene, Tractions, solve

SHEETS = list(INTERFACE_SHEETS.values())
COARSE = {"tpv101": 720, "tpv205": 1920, "two-slots": 2400}


def name(sheet):
    return sheet.name


@cache
def scored(sheet, cells=60, text=None):
    """Errors and classes of `run` by quantity, of the interface of another text if one is given."""
    given = sheet if text is None else replace(sheet, text=text)
    records = Records(run_stations(given, cells), source="mine")
    return {one.quantity: one for one in score(Run(sheet, "mine", "1", cells, 1.0, records))}


@pytest.fixture(autouse=True, scope="module")
def limits_computed_once():
    """The limit of a sheet on a grid is the same in each test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reference, "extrapolated", cache(reference.extrapolated))
        yield


# --- the answers ----------------------------------------------------------------------------------


@pytest.mark.thinned(3)
@pytest.mark.parametrize("sheet", SHEETS[::-1], ids=name)
def test_coarser_grids_have_the_written_limit(sheet):
    assert list(changes(sheet, nodes=COARSE[sheet.name])) == []


@pytest.mark.slow
@pytest.mark.parametrize("sheet", SHEETS, ids=name)
def test_the_written_answer_is_the_one_computed_now(sheet):
    assert list(changes(sheet, nodes=sheet.nodes)) == []


def test_a_spoilt_answer_is_noticed():
    sheet = INTERFACE_SHEETS["two-slots"]
    answer = answer_to(sheet)
    assert list(reference_changes(sheet, answer, 2400)) == []
    for quantity, factor in (("slip", 1.001), ("slip_rate", 1.01), ("shear_traction", 0.99)):
        values = {**answer.values, quantity: factor * answer.values[quantity]}
        (change,) = reference_changes(sheet, replace(answer, values=values), 2400)
        assert change.startswith(quantity)
    (change,) = reference_changes(sheet, replace(answer, arrivals=answer.arrivals + 0.05), 2400)
    assert change.startswith("arrivals")


def test_until_the_other_edge_is_heard_two_slots_are_one_long_slot():
    """Beside x = 3 the slot of width 2 is infinitely long until a wave has crossed it."""
    sheet = INTERFACE_SHEETS["two-slots"]
    answer, face = answer_to(sheet), sheet.interface
    scene = Scene(face.material, friction=0.3, base=Tractions(1.0, 0.0), load=Tractions(0.0, 1.0))
    known = solve(scene)
    assert face.material.poisson_ratio == 0.25
    wrong = dict.fromkeys(sheet.report, 0.0)
    for place, x in enumerate(sheet.stations):
        if x > 3:
            heard = (2 + x - 3) / face.material.longitudinal_speed
            early = answer.t < heard
            for quantity, most in (("slip", 1e-4), ("slip_rate", 1e-3), ("shear_traction", 2e-3)):
                exact = getattr(known, quantity)(x - 3, answer.t[early])
                found = answer.values[quantity][early, place]
                assert off(found, exact) < most
                wrong[quantity] += np.abs(found - exact).sum()
    for quantity, error in wrong.items():  # what is known to be wrong is within the stated error
        assert error < answer.errors[quantity] * np.abs(answer.values[quantity]).sum()


def test_written_answers_are_even_where_the_problem_is():
    answer = answer_to(INTERFACE_SHEETS["tpv205"])
    left, right = (list(answer.x).index(x) for x in (-4500.0, 4500.0))
    assert answer.arrivals[left] == pytest.approx(answer.arrivals[right], abs=1e-6)
    # the patches of high and low shear are heard on either side later
    early = answer.t < 1.7
    assert off(answer.values["slip"][early, left], answer.values["slip"][early, right]) < 1e-6
    assert answer.values["slip"][-1, left] > 1.05 * answer.values["slip"][-1, right]


# --- scores ---------------------------------------------------------------------------------------


@pytest.mark.thinned(2)
@pytest.mark.parametrize("sheet", SHEETS, ids=name)
def test_run_has_a_class(sheet):
    found = scored(sheet)
    assert set(found) == {"arrival", *sheet.report}
    assert all(one.tolerance in CLASSES for one in found.values())
    assert not any(one.note for one in found.values())


SPOILS = [
    ("tpv101", "f0 = 0.6", "f0 = 0.618"),
    ("tpv101", "b = 0.012", 'b = 0.012\nevolution = "slip"'),
    ("tpv205", "dynamic = 0.525", "dynamic = 0.541"),
    ("tpv205", 'kind = "slip-dependent"', 'kind = "slip-dependent"\nshape = "exponential"'),
    ("two-slots", "friction = 0.3", "friction = 0.309"),
    ("two-slots", "poisson_ratio = 0.25", "poisson_ratio = 0.3"),
]


@pytest.mark.thinned(4)
@pytest.mark.parametrize(("sheet", "words", "instead"), SPOILS)
def test_a_spoilt_run_is_in_the_last_class(sheet, words, instead):
    sheet = INTERFACE_SHEETS[sheet]
    assert words in sheet.text
    found = scored(sheet, text=sheet.text.replace(words, instead))
    right = scored(sheet)
    assert found["slip"].tolerance == "D"
    assert found["slip"].error > 5 * right["slip"].error


@pytest.mark.slow
def test_classes_are_those_of_finite_elements():
    found = {one.quantity: one for one in score(enter("fem", INTERFACE_SHEETS["two-slots"], 50))}
    for quantity, one in found.items():
        assert one.error <= tolerances()["two-slots", quantity].C <= 1.2 * one.error


def test_a_file_of_a_run_is_scored_as_the_run(tmp_path):
    sheet = INTERFACE_SHEETS["two-slots"]
    run = enter("run", sheet, 50)
    write_run(tmp_path / "mine.csv", run)
    first, second = (
        {one.quantity: one for one in score(one)} for one in (run, read_run(tmp_path / "mine.csv"))
    )
    assert first.keys() == second.keys()
    for quantity, one in first.items():
        assert second[quantity].error == pytest.approx(one.error, rel=1e-3, abs=1e-6)
        assert second[quantity].tolerance == one.tolerance
    assert first["arrival"].second == pytest.approx(
        first["arrival"].error * sheet.end_time / sheet.crossing * 50
    )


def test_units_may_be_named_where_the_sheet_is_in_the_si(tmp_path):
    lines = ["t [ms],x [km],slip [mm]"]
    answer = answer_to(INTERFACE_SHEETS["tpv205"])
    for place, x in enumerate(answer.x):
        slips = answer.values["slip"][:, place]
        rows = zip(answer.t, slips, strict=True)
        lines += [f"{1e3 * t},{x / 1e3},{1e3 * slip}" for t, slip in rows]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    run = read_run(tmp_path / "a.csv", find_sheet("tpv205"))
    found = {one.quantity: one for one in score(run)}
    assert found["slip"].error < 1e-12
    assert found["slip"].tolerance == "?"
    assert np.isnan(found["slip_rate"].error)
    with pytest.raises(DataFileError, match="without a unit"):
        read_run(tmp_path / "a.csv", find_sheet("two-slots"))


def test_means_over_a_step_count_for_its_middle():
    answer = answer_to(INTERFACE_SHEETS["two-slots"])
    t = np.linspace(0.01, 3.0, 1200)
    record = Record(0.3, t, {"slip_rate": t**2 + 0.01 * t, "slip": t**2})  # of step 0.01
    read = answer.at_times(record, 0.01)
    assert read.values["slip"] == pytest.approx(read.t**2, abs=1e-5)
    # the mean of t^2 from t to t + s is that of the middle, but for s^2 / 12
    assert read.values["slip_rate"][2:] == pytest.approx((read.t**2)[2:], abs=1e-4)


def test_records_elsewhere_are_refused():
    sheet = INTERFACE_SHEETS["tpv101"]
    t = np.linspace(0.1, 15, 300)
    records = Records((Record(4000.0, t, {"slip": t, "slip_rate": t}),), source="mine")
    with pytest.raises(DataFileError, match="no station of the sheet and 0 < t <= 15"):
        score(Run(sheet, "mine", "1", 100, 1.0, records))


# --- pages ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("sheet", SHEETS, ids=name)
def test_pages_state_problem_stations_and_errors(sheet):
    text = as_markdown(list(sheet_blocks(sheet)))
    assert sheet.statement in text
    assert "## Tolerance classes" in text
    assert f"Cells are counted over {sheet.breadth_words}." in text
    for quantity, error in written_document(sheet)["errors"].items():
        assert f"| {quantity.replace('_', ' ')} | {error:.2g} |" in text
    for x in sheet.stations:
        assert f"| {x:g} |" in text
    assert "nan" not in text.replace("anoth", "")


def test_numbers_of_pages_are_those_of_the_interfaces():
    for sheet in SHEETS:
        face, numbers = sheet.interface, dict(sheet.numbers)
        assert numbers["end T"].split()[0] == f"{sheet.end_time:g}"
        factor = 1e6 if sheet.units == "SI" else 1.0
        assert float(numbers["pressure p"].split()[0]) * factor == face.pressure


def test_exports_hold_the_interface_as_a_file(tmp_path, monkeypatch):
    monkeypatch.setattr("compare.benchmarks.export.figure_png", lambda figure, dpi: b"drawn")
    sheet = INTERFACE_SHEETS["two-slots"]
    contents = exported([sheet])
    assert {"two-slots/interface.toml", "two-slots/figure.png", "two-slots/records.csv"} <= set(
        contents
    )
    (tmp_path / "interface.toml").write_bytes(contents["two-slots/interface.toml"])
    from semianalytic import find

    again = find(tmp_path / "interface.toml").interface
    assert again.contact == sheet.interface.contact
    document = json.loads(contents["two-slots/answers.json"])
    assert document["units"].startswith("mu = rho = c_t = 1")


def test_documents_hold_the_problem():
    listed = {one["name"]: one for one in sheets_document()["sheets"]}
    assert listed["tpv101"]["marched"]
    assert "rate-and-state" in listed["tpv101"]["scene"]["interface"]
    shown = sheet_document(find_sheet("tpv101"))
    assert shown["si_scene"] is None
    assert len(shown["tolerances"]) == 4
    assert shown["units"]["stations"] == "m"
    assert shown["units"]["answers"]["shear_traction"] == "Pa"
    assert shown["units"]["errors"]["slip"] == "1"
    assert sheet_document(find_sheet("two-slots"))["units"]["stations"] == "length"
