"""Scores: class A for right records, the last class and a verdict for wrong ones."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to, values_of
from compare.benchmarks.scores import class_of, score, score_files
from compare.benchmarks.sheets import sheets
from compare.records.record import AFTER, QUANTITIES, Record, Records, Stated
from compare.validation import validate
from docs.studies.benchmarks import run_of, simulated
from semianalytic import solve
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.errors import DataFileError, SceneError

SHEETS = sheets()
PRELOADED = SHEETS["preloaded"]
TIMES = np.arange(1, 601) / 600 - 1e-5
"""At none of which a front passes a station."""
SOLVED = [sheet for sheet in SHEETS.values() if not sheet.is_interface]


def records_of(sheet, answer=None, stations=None, times=TIMES, factor=1.0, late=0.0, step=None):
    """Records of an answer, that of the sheet unless given, wrong by a factor or late."""
    answer = answer or answer_to(sheet)
    records = tuple(
        Record(x, times + late, {n: factor * values_of(answer, n, x, times) for n in QUANTITIES})
        for x in stations or sheet.stations
    )
    stated = Stated(mean=AFTER, step=step) if step else Stated()
    return Records(records, source="here", spacing=0.005, stated=stated)


def scored(sheet, records):
    return {result.quantity: result for result in score(sheet, records)}


@pytest.mark.thinned(10)
@pytest.mark.parametrize("sheet", SOLVED, ids=lambda sheet: sheet.name)
def test_right_records_are_in_class_a(sheet):
    for result in score(sheet, records_of(sheet)):
        assert result.error < (1 / 600 if result.quantity == "arrival" else 1e-12), result
        assert result.grade == ("A" if sheet.classes else "")
        assert result.verdict != "differs"
        assert result.held > 0.99


def test_friction_3_per_cent_off_is_in_the_last_class_and_differs():
    wrong = solve(override_scene(PRELOADED.problem, friction=1.03 * PRELOADED.problem.friction))
    found = scored(PRELOADED, records_of(PRELOADED, wrong))
    assert {found[name].grade for name in PRELOADED.report} == {"D"}
    assert {answer.verdict for answer in found.values()} == {"differs"}


def test_errors_are_what_they_are_called_and_those_of_validate():
    records = records_of(PRELOADED, factor=1.01)
    found = scored(PRELOADED, records)
    norms = {row.quantity: row.L1 for row in validate(records, "preloaded").norms if row.x is None}
    for name in PRELOADED.report:
        assert found[name].error == pytest.approx(0.01)
        assert norms[name] == pytest.approx(0.01)
    late = scored(PRELOADED, records_of(PRELOADED, late=0.01))
    assert late["arrival"].error == pytest.approx(0.01, rel=0.05)


def test_slip_where_there_is_none_is_over_that_of_a_free_surface():
    records = records_of(SHEETS["stuck"])
    for station in records.stations:
        station.values["slip_rate"][:] = 0.2
    found = scored(SHEETS["stuck"], records)
    assert found["slip_rate"].error == pytest.approx(0.1)
    assert (found["slip_rate"].grade, found["slip"].error) == ("D", 0)


def test_a_record_may_have_a_sample_where_the_exact_slip_rate_is_infinite():
    """At the end of the patch, |x| = 0.3 t: `validate` ended in an error of Python."""
    records = records_of(SHEETS["whole-line-patch"], times=TIMES + 1e-5)
    for station in records.stations:
        np.nan_to_num(station.values["slip_rate"], copy=False, posinf=9.0)
    assert any(9.0 in station.values["slip_rate"] for station in records.stations)
    errors = [result.error for result in score(SHEETS["whole-line-patch"], records)]
    assert max(errors) < 0.05


def test_a_mean_over_a_step_is_held_against_a_mean():
    step, solution = 0.01, answer_to(PRELOADED)
    times = np.arange(1, 100) / 100 - 1e-5
    for stated, right in ((None, False), (step, True)):
        records = records_of(PRELOADED, times=times, step=stated)
        for station in records.stations:
            moved = solution.slip(station.x, times + step) - solution.slip(station.x, times)
            station.values["slip_rate"][:] = moved / step
        assert (scored(PRELOADED, records)["slip_rate"].error < 1e-3) == right


def test_a_class_takes_nine_tenths_of_stations_and_times():
    def grades(records):
        return {result.grade for result in score(PRELOADED, records)}

    assert grades(records_of(PRELOADED, times=TIMES[TIMES < 0.09])) == {""}
    assert grades(records_of(PRELOADED, stations=(0.1, 0.25, 0.5, 0.75))) == {""}
    assert grades(records_of(PRELOADED, times=TIMES[np.abs(TIMES - 0.55) > 0.02])) == {"A"}
    assert grades(records_of(PRELOADED, times=TIMES[np.abs(TIMES - 0.55) > 0.06])) == {""}
    gaps = records_of(PRELOADED)
    for station in gaps.stations:
        station.values["slip"][np.arange(len(station.t)) % 10 < 7] = math.nan
        del station.values["shear_traction"]
    found = scored(PRELOADED, gaps)
    assert [found[name].grade for name in PRELOADED.report] == ["A", "", ""]
    assert math.isnan(found["shear_traction"].error)


def test_an_error_is_graded_by_the_bounds():
    late = records_of(PRELOADED)
    late.stations[3].values["slip_rate"][:] = 0  # slip never reaches a station
    assert scored(PRELOADED, late)["arrival"].grade == "D"
    a, b, c = PRELOADED.classes["slip"]
    for error, grade in ((a, "A"), (1.01 * a, "B"), (1.01 * b, "C"), (1.01 * c, "D")):
        assert class_of(PRELOADED, "slip", error) == grade
    assert class_of(PRELOADED, "slip", math.nan) == class_of(PRELOADED, "pressure", 0.1) == ""


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", ["antiplane", "pair-slip", "two-slots"])
def test_classes_are_those_of_the_finite_elements(name):
    sheet = SHEETS[name]
    assert sheet.classes.keys() == {"arrival", *sheet.report}
    for quantity, entry in scored(sheet, simulated(sheet, 50)).items():
        assert entry.error <= sheet.classes[quantity][2] <= 1.2 * entry.error or quantity == "slip"


# --- interfaces -----------------------------------------------------------------------------------


@cache
def run_on(name, words="", instead=""):
    """Scores of `run` on 60 cells, of an interface whose text has other words."""
    sheet = SHEETS[name]
    assert words in sheet.interface
    given = replace(sheet, interface=sheet.interface.replace(words, instead))
    nodes = round(sheet.problem.period * 60 / sheet.extent)
    done = run_of(given, nodes, samples=5)
    rows = {line: done.at(getattr(done.interface, line), sheet.stations) for line in sheet.report}
    records = [
        Record(x, done.interface.t, {line: row[:, i] for line, row in rows.items()})
        for i, x in enumerate(sheet.stations)
    ]
    return scored(sheet, Records(tuple(records), source="mine"))


WRONG = [
    ("two-slots", "friction = 0.3", "friction = 0.309"),
    ("tpv101", "b = 0.012", 'b = 0.012\nevolution = "slip"'),
    ("tpv205", "dynamic = 0.525", "dynamic = 0.541"),
]


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("name", "words", "instead"), WRONG)
def test_a_wrong_interface_is_in_the_last_class_and_a_right_one_is_not(name, words, instead):
    right, wrong = run_on(name), run_on(name, words, instead)
    assert all(values.grade in set("ABC") for values in right.values())
    assert wrong["slip"].grade == "D"
    assert wrong["slip"].error > 5 * right["slip"].error


def test_means_of_an_interface_count_for_the_middle_of_their_step():
    sheet = SHEETS["two-slots"]
    answer, t = answer_to(sheet), np.linspace(0.01, 3.0, 1200)
    early = [
        Record(x, t, {"slip_rate": np.interp(t + 0.05, answer.t, answer.values["slip_rate"][:, i])})
        for i, x in enumerate(sheet.stations)
    ]
    errors = []
    for stated in (Stated(), Stated(mean=AFTER, step=0.1)):
        errors.append(scored(sheet, Records(tuple(early), stated=stated))["slip_rate"].error)
    assert errors[1] < 0.1 * errors[0]


# --- files ----------------------------------------------------------------------------------------


def test_units_may_be_named_where_the_sheet_is_in_the_si(tmp_path):
    answer, lines = answer_to(SHEETS["tpv205"]), ["t [ms],x [km],slip [mm]"]
    for place, x in enumerate(answer.x):
        rows = zip(answer.t, answer.values["slip"][:, place], strict=True)
        lines += [f"{1e3 * t},{x / 1e3},{1e3 * slip}" for t, slip in rows]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    found = {file.quantity: file for file in score_files([tmp_path / "a.csv"], SHEETS["tpv205"])}
    assert (found["slip"].error < 1e-12, found["slip"].grade) == (True, "A")
    with pytest.raises(DataFileError, match="without a unit"):
        score_files([tmp_path / "a.csv"], SHEETS["two-slots"])


@pytest.mark.parametrize("given", ["files", "folder"])
def test_stations_of_scec_are_one_run(given, tmp_path):
    """A file for each station, with tractions in MPa by its comments."""
    sheet = SHEETS["tpv205"]
    answer = answer_to(sheet)
    head = "# Column #3 = horizontal shear stress (MPa)\nt h-slip h-shear-stress\n"
    for place, x in enumerate(answer.x):
        slip, shear = (answer.values[name][:, place] for name in ("slip", "shear_traction"))
        rows = np.stack([answer.t, slip, shear / 1e6], axis=1).tolist()
        text = head + "".join(" ".join(map(repr, row)) + "\n" for row in rows)
        (tmp_path / f"faultst{round(x / 100):03d}dp075").write_text(text)
    paths = [tmp_path] if given == "folder" else sorted(tmp_path.iterdir())
    scores = score_files(paths, sheet)
    assert len(scores) == len({result.quantity for result in scores})  # one run
    found = {result.quantity: result for result in scores}
    for name in ("slip", "shear_traction"):
        assert (found[name].error < 1e-9, found[name].grade, found[name].held) == (True, "A", 1.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# benchmark: preloaded\nt,x,slip [mm]\n0,1,2\n1,1,2\n", "slip is in mm; hand it in"),
        ("# benchmark: preloaded\nstep,x,slip\n0,1,2\n", "no column of times"),
        ("# benchmark: preloaded\nt,x,slip\n0,1,0\n1,1,0\n", "no station at x = 0.1, 0.25"),
        ("# benchmark: stuck\nt,x,slip\n0,1,2\n", "is of stuck, not of preloaded"),
    ],
)
def test_files_that_are_no_runs_are_refused(tmp_path, text, message):
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(DataFileError, match=message):
        score_files([tmp_path / "run.csv"], PRELOADED)
    (tmp_path / "run.csv").write_text("t,x,slip\n0,1,2\n")
    with pytest.raises(SceneError, match="does not say of which benchmark"):
        score_files([tmp_path / "run.csv"])
