"""Scores: nothing for exact records, the truth for wrong ones."""

import math
from dataclasses import replace

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to
from compare.benchmarks.classes import CLASSES, tolerance_class, tolerances
from compare.benchmarks.entries import Run, enter, read_run, told_apart, write_run
from compare.benchmarks.scores import score
from compare.benchmarks.sheet import STATIONS
from compare.benchmarks.sheets import RATED_SHEETS, SHEETS
from compare.records.record import QUANTITIES, Record, Records
from docs.studies.league import ROOT, league_rows
from semianalytic import solve
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.overriding import override_scene

TIMES = np.arange(1, 601) / 600 - 1e-5
"""At none of which a front passes a station."""


def run_of(sheet, answer=None, stations=STATIONS, times=TIMES, names=QUANTITIES, step=0.0):
    """A run that recorded an answer, that of the sheet unless given."""
    answer = answer or answer_to(sheet)
    records = tuple(
        Record(x, times, {name: getattr(answer, name)(x, times) for name in names})
        for x in stations
    )
    return Run(sheet, "exact", "1", 100, 1.0, Records(records, source="here"), step)


def errors(run):
    return {one.quantity: one.error for one in score(run)}


@pytest.mark.thinned(10)
@pytest.mark.parametrize("sheet", SHEETS.values(), ids=lambda sheet: sheet.name)
def test_exact_records_have_no_error(sheet):
    for one in score(run_of(sheet)):
        assert one.error < (1e-3 if one.quantity == "arrival" else 1e-12), one
        assert one.second < 0.1
        assert one.tolerance == "?"
        assert one.note == "within 1e-06 of the answer, which no code comes so near to"


def test_friction_that_is_3_percent_off_shows_in_everything():
    sheet = SHEETS["preloaded"]
    wrong = solve(override_scene(sheet.scene, friction=1.03 * sheet.scene.friction))
    found = {one.quantity: one for one in score(run_of(sheet, wrong))}
    for name, least in (("slip_rate", 0.015), ("slip", 0.015), ("shear_traction", 0.02)):
        assert found[name].error > least
    assert all(found[name].tolerance == "D" for name in sheet.report)


def test_errors_are_what_they_are_called():
    run = run_of(SHEETS["preloaded"])
    for one in score(changed(run, 1.01)):
        if one.quantity != "arrival":
            assert (one.error, one.second) == pytest.approx((0.01, 0.01))
    arrival = score(changed(run, 1.0, late=0.01))[0]
    assert (arrival.error, arrival.second) == pytest.approx((0.01, 1.0), rel=0.05)


def test_slip_where_there_is_none_is_over_that_of_a_free_surface():
    sheet = SHEETS["stuck"]
    run = run_of(sheet)
    for one in run.records.stations:
        one.values["slip_rate"][:] = 0.2
    found = {one.quantity: one for one in score(run)}
    assert found["slip_rate"].error == pytest.approx(0.1)
    assert found["slip_rate"].tolerance == "D"
    assert found["slip"].error == 0


def test_a_mean_over_a_step_is_held_against_a_mean():
    sheet, step = SHEETS["preloaded"], 0.01
    times = np.arange(1, 100) / 100 - 1e-5
    run = run_of(sheet, times=times)
    solution = answer_to(sheet)
    for one in run.records.stations:
        mean = (solution.slip(one.x, times + step) - solution.slip(one.x, times)) / step
        one.values["slip_rate"][:] = mean
    assert errors(run)["slip_rate"] > 0.01
    assert errors(replace(run, step=step))["slip_rate"] < 1e-3


def test_what_is_missing_is_left_out_and_said():
    sheet = SHEETS["preloaded"]
    run = run_of(sheet, stations=(0.1, 0.5), names=("slip_rate", "slip"))
    for one in run.records.stations:
        one.values["slip"][100:300] = math.nan
    found = {one.quantity: one for one in score(run)}
    assert found["slip"].error < 1e-12
    assert math.isnan(found["shear_traction"].error)
    assert found["shear_traction"].tolerance == ""
    assert found["slip"].note.startswith("without x = 0.25, 0.75, 0.95; no class, which takes 90 %")
    assert {one.tolerance for one in found.values()} == {""}


def test_a_station_that_slip_never_reaches_is_said():
    sheet = SHEETS["preloaded"]
    run = run_of(sheet)
    run.records.stations[3].values["slip_rate"][:] = 0
    assert score(run)[0].note == "1 station reached by one only"
    assert score(run)[0].tolerance == "D"


def changed(run, factor=1.0001, late=0.0):
    """A run whose values are off by a factor and its times late, so that it is no copy."""
    records = (
        Record(one.x, one.t + late, {name: factor * value for name, value in one.values.items()})
        for one in run.records.stations
    )
    return replace(run, records=Records(tuple(records)))


@pytest.mark.slow
def test_a_class_takes_nine_tenths_of_stations_and_times():
    sheet = SHEETS["preloaded"]
    whole = score(changed(run_of(sheet)))
    assert {one.tolerance for one in whole} == {"A"}
    early = score(changed(run_of(sheet, times=TIMES[TIMES < 0.09])))
    assert {one.tolerance for one in early} == {""}
    assert "at most 9 % of the time" in early[1].note
    few = score(changed(run_of(sheet, stations=STATIONS[:4])))
    assert {one.tolerance for one in few} == {""}
    gaps = changed(run_of(sheet))
    for one in gaps.records.stations:
        one.values["slip"][np.arange(len(one.t)) % 10 < 7] = math.nan
    found = {one.quantity: one for one in score(gaps)}
    assert (found["slip"].tolerance, found["slip_rate"].tolerance) == ("", "A")
    front = np.abs(TIMES - 0.55) < 0.02  # rows beside a front are left out and not marked
    beside = score(changed(run_of(sheet, times=TIMES[~front])))
    assert {one.tolerance for one in beside} == {"A"}
    front = np.abs(TIMES - 0.55) < 0.06
    beside = score(changed(run_of(sheet, times=TIMES[~front])))
    assert {one.tolerance for one in beside} == {""}
    seldom = score(changed(run_of(sheet, times=np.array([0.1, 0.5, 1.0]))))
    assert {one.tolerance for one in seldom} == {""}


def test_means_over_more_than_two_cells_are_refused():
    run = changed(run_of(SHEETS["preloaded"], step=0.02))
    assert score(run)
    with pytest.raises(DataFileError, match=r"0\.05 T is 5 cells; record them more often"):
        score(replace(run, step=0.05))
    with pytest.raises(DataFileError, match="how many cells it has"):
        score(replace(run, cells=math.nan))
    assert score(replace(run, cells=math.nan, step=0.01))


def test_a_run_without_a_station_is_refused():
    sheet = SHEETS["preloaded"]
    records = Records((Record(-0.5, TIMES, {"slip": TIMES}),), source="elsewhere.csv")
    with pytest.raises(DataFileError, match=r"elsewhere\.csv has no station"):
        score(Run(sheet, "none", "", 100, 1.0, records))


# --- our own codes --------------------------------------------------------------------------------


@pytest.mark.thinned(2)
@pytest.mark.parametrize("code", ["fem", "march"])
def test_our_own_codes_enter_by_the_same_door(tmp_path, code):
    sheet = SHEETS["viscous"]
    run = enter(code, sheet, 50)
    write_run(tmp_path / "run.csv", run)
    again = read_run(tmp_path / "run.csv")
    assert (again.sheet, again.code, again.cells) == (sheet, run.code, 50)
    assert errors(again) == pytest.approx(errors(run), rel=1e-4)
    for one in score(again):
        assert one.tolerance in CLASSES


def test_classes_are_those_of_the_finite_elements():
    bounds = tolerances()
    assert {sheet for sheet, _ in bounds} == set(RATED_SHEETS)
    for sheet in RATED_SHEETS.values():
        asked = {*sheet.report, *(("arrival",) if sheet.arrival else ())}
        assert {name for one, name in bounds if one == sheet.name} == asked
    for one in bounds.values():
        assert 0 < one.A <= one.B <= one.C
    found = errors(enter("fem", SHEETS["antiplane"], 100))
    for name, error in found.items():
        assert error <= bounds["antiplane", name].B <= 1.2 * error


def test_classes_in_docs_are_those_of_the_package():
    package = ROOT / "compare" / "benchmarks" / "data" / "classes.csv"
    assert (ROOT / "docs" / "data" / "benchmark-classes.csv").read_bytes() == package.read_bytes()


def test_an_error_is_graded_by_the_bounds():
    one = tolerances()["preloaded", "slip"]
    marks = [(one.A, "A"), (1.01 * one.A, "B"), (1.01 * one.B, "C"), (1.01 * one.C, "D")]
    for error, expected in marks:
        assert tolerance_class("preloaded", "slip", error) == expected
    assert tolerance_class("preloaded", "slip", math.nan) == ""
    assert tolerance_class("preloaded", "pressure", 0.1) == ""


def test_a_league_table_is_ranked_and_has_orders():
    sheets = [SHEETS["antiplane"], SHEETS["lift-off"]]
    runs = [enter("fem", sheet, cells) for sheet in sheets for cells in (60, 30)]
    rows = league_rows(runs)
    assert [(row.sheet, row.cells) for row in rows] == [
        ("antiplane", 30),
        ("antiplane", 60),
        ("lift-off", 30),
        ("lift-off", 60),
    ]
    assert math.isnan(rows[0].order)
    assert math.isnan(rows[2].order)
    assert rows[1].order == pytest.approx(math.log2(rows[0].slip_rate / rows[1].slip_rate))
    assert 0.7 < rows[3].order < 2
    assert rows[1].arrival_cells == pytest.approx(60 * rows[1].arrival)


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# benchmark: preloaded\n# cells: many\nt,x,slip\n0,1,2\n", "no number"),
        ("# benchmark: preloaded\nt,x,slip [mm]\n0,1,2\n1,1,2\n", "slip is in mm; hand it in"),
        ("# benchmark: preloaded\nt,x,slip\n0,1,here\n", "line 3: 'here' is not a number"),
        ("# benchmark: preloaded\nt,x,slip\n0,1\n", "line 3: there are 2 entries"),
        ("# benchmark: preloaded\nstep,x,slip\n0,1,2\n", "no column of times"),
        ("# benchmark: preloaded\nt,x,gap\n0,1,2\n", "none of it is"),
        ("# benchmark: preloaded\n", "no row of numbers"),
        ("# benchmark: stuck\nt,x,slip\n0,1,2\n", "is of stuck, not of preloaded"),
    ],
)
def test_files_that_are_no_runs_are_refused(tmp_path, text, message):
    path = tmp_path / "run.csv"
    path.write_text(text)
    with pytest.raises(DataFileError, match=message):
        read_run(path, SHEETS["preloaded"])


def test_a_sheet_may_be_given_and_names_and_steps_are_read(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("# v: mean from t to t + 0.02\nt,x,slip\n0.2,0.1,2\n0.1,0.1,1\n")
    run = read_run(path, SHEETS["preloaded"])
    assert (run.code, run.step) == ("mine", 0.02)
    assert run.records.stations[0].t.tolist() == [0.1, 0.2]


def test_runs_of_one_code_and_grid_are_told_apart(tmp_path):
    files = [tmp_path / name for name in ("a.csv", "b.csv", "c.csv")]
    for path, cells in zip(files, (50, 50, 100), strict=True):
        path.write_text(
            f"# benchmark: preloaded\n# code: me\n# cells: {cells}\nt,x,slip\n0,1,0\n1,1,0\n"
        )
    runs = told_apart([read_run(path) for path in files])
    assert [run.code for run in runs] == ["me (a.csv)", "me (b.csv)", "me"]
