"""Problem sheets: their answers, what is known of these otherwise, and files that say all."""

import shutil
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from compare.benchmarks import answers, pages
from compare.benchmarks.answers import (
    answer_to,
    arrival_level,
    arrival_quantity,
    arrival_time,
    fields_of,
    numbers_of,
    stated_errors,
    table_of,
    values_of,
)
from compare.benchmarks.pages import page_of
from compare.benchmarks.scores import score_files
from compare.benchmarks.sheets import DATA, SUMS, find_sheet, sheet_names, sheets, stored_text
from compare.records.record import QUANTITIES
from docs.studies import benchmarks
from semianalytic import DataFileError, Material, Scene, Tractions, find, solve
from semianalytic.scene.given.named import NAMED_LINES, NAMED_SCENES

SHEETS = sheets()
INTERFACES = [name for name, sheet in SHEETS.items() if sheet.is_interface]
PAIRS = ["pair-slip", "pair-opening"]
QUICK = [name for name, sheet in SHEETS.items() if not sheet.is_marched and name not in PAIRS]
COARSE = {"tpv101": 720, "tpv205": 1920, "two-slots": 2400}


# --- answers --------------------------------------------------------------------------------------

EDGES = {
    "preloaded": [0.8842659394619, 0.9769067729790, 1.0614022957300],
    "incident-sv": [0.405067274343],
    "whole-line-patch": [0.395154376971],
    "antiplane": [4 / 9],
    "lift-off": [3 / 16],
    "stuck": [],
}
"""Edges over c_t, some in closed form."""


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(pair, marks=pytest.mark.slow) for pair in PAIRS)]
)
def test_a_table_holds_what_the_solver_says(name):
    sheet = SHEETS[name]
    answer = solve(sheet.problem)
    lines = table_of(sheet).splitlines()
    assert lines[2] == ",".join(("t", "x", *QUANTITIES))
    t, x, *columns = np.loadtxt(lines[3:], delimiter=",").T
    assert (sorted(set(t)), sorted(set(x))) == (sorted(sheet.times), sorted(sheet.stations))
    for quantity, column in zip(QUANTITIES, columns, strict=True):
        known = getattr(answer, quantity)(x, t)
        np.testing.assert_allclose(column, known, rtol=1e-9, atol=3e-8)
    found = [end for row in numbers_of(sheet).get("zones", []) for end in row[:2] if end > 0]
    found = found or [row[1] for row in numbers_of(sheet).get("openings", [])]
    if name in EDGES:
        assert found == pytest.approx(EDGES[name], rel=1e-10)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", [name for name in QUICK if SHEETS[name].arrival])
def test_at_an_arrival_the_level_is_passed_and_no_front_passes_at_a_time_of_the_table(name):
    sheet, answer = SHEETS[name], answer_to(SHEETS[name])
    for x in sheet.stations:
        time = arrival_time(sheet, answer, x)
        if np.isfinite(time):
            sides = np.array([1 - 1e-5, 1 + 1e-5]) * time
            before, after = np.abs(values_of(answer, arrival_quantity(sheet), x, sides))
            assert (before < arrival_level(sheet)) == (sheet.arrival == "slip")
            assert (after > arrival_level(sheet)) == (sheet.arrival == "slip")
    parts = (*answer.zones, *getattr(answer, "openings", ()))
    ends = [end for part in parts for end in (part.inner, part.outer)]
    speeds = np.array(sheet.stations) / np.array(sheet.times)[:, None]
    assert np.abs(np.subtract.outer(ends, speeds)).min() > 1e-5


def test_a_march_is_as_far_off_as_it_says(monkeypatch):
    sheet = SHEETS["pulse"]
    assert [name for name, listed in SHEETS.items() if listed.is_marched] == ["pulse", *INTERFACES]
    fine = fields_of(
        sheet, solve(sheet.problem, method="space-time", end_time=1.0, nodes=1600, estimate=False)
    )
    monkeypatch.setattr(answers, "NODES", 600)
    monkeypatch.setattr(answers, "answer_to", cache(answer_to.__wrapped__))
    coarse, errors = fields_of(sheet, answers.answer_to(sheet)), stated_errors(sheet)
    for name in sheet.report:
        off = benchmarks.apart(name, coarse[name], fine[name])
        assert 0.1 * errors[name] < off < 2 * errors[name]


def test_in_si_the_answer_is_the_same_times_what_the_page_says():
    assert "a slip rate of 1 is 2 m/s and a slip of 1 is 2 m" in page_of(SHEETS["preloaded"])
    si = solve(Scene(Material(1e10, 2500.0, 1 / 3), 0.3, Tractions(1e7, 0.0), Tractions(0.0, 1e7)))
    plain, x, t = answer_to(SHEETS["preloaded"]), np.array(SHEETS["preloaded"].stations), 0.9
    for name, scale in (("slip_rate", 2), ("slip", 2), ("shear_traction", 1e7), ("pressure", 1e7)):
        known = scale * getattr(plain, name)(x, t)
        np.testing.assert_allclose(getattr(si, name)(2000 * x, t), known, rtol=1e-9, atol=1e-9)


# --- answers to interfaces ------------------------------------------------------------------------


@cache
def limit(name, nodes):
    return benchmarks.extrapolated(SHEETS[name], nodes)


def changes(name, nodes, stored):
    """Quantities of a stored answer that differ from a limit by more than both errors."""
    fields, errors = limit(name, nodes)
    known = {**stored.values, "arrivals": stored.arrivals}
    return [
        field
        for field, values in fields.items()
        if not benchmarks.apart(field, values, known[field]) <= errors[field] + stored.errors[field]
    ]


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", INTERFACES[::-1])
def test_coarser_grids_have_the_stored_limit(name):
    stored = answer_to(SHEETS[name])
    assert changes(name, COARSE[name], stored) == []
    assert set(stored.values) == set(SHEETS[name].report)
    if name == "two-slots":
        slip = {**stored.values, "slip": 1.001 * stored.values["slip"]}
        wrong = replace(stored, values=slip, arrivals=stored.arrivals + 0.05)
        assert changes(name, COARSE[name], wrong) == ["arrivals", "slip"]


def test_until_a_wave_has_crossed_it_one_of_two_slots_is_one_long_slot():
    sheet = SHEETS["two-slots"]
    answer, face = answer_to(sheet), sheet.problem
    known = solve(Scene(face.material, 0.3, base=Tractions(1.0, 0.0), load=Tractions(0.0, 1.0)))
    wrong = dict.fromkeys(sheet.report, 0.0)
    for place, x in enumerate(sheet.stations):
        if x > 3:
            early = answer.t < (2 + x - 3) / face.material.longitudinal_speed
            for quantity, most in (("slip", 1e-4), ("slip_rate", 1e-3), ("shear_traction", 2e-3)):
                exact = getattr(known, quantity)(x - 3, answer.t[early])
                found = answer.values[quantity][early, place]
                assert benchmarks.apart(quantity, found, exact) < most
                wrong[quantity] += np.abs(found - exact).sum()
    for quantity, error in wrong.items():  # what is known to be wrong is within the stated error
        assert error < answer.errors[quantity] * np.abs(answer.values[quantity]).sum()


# --- files ----------------------------------------------------------------------------------------


def test_stored_data_are_signed_and_a_changed_digit_is_refused(tmp_path):
    lines = (DATA / SUMS).read_text().splitlines()
    assert {line.split()[1] for line in lines} == {path.name for path in DATA.iterdir()} - {SUMS}
    assert {f"{name}.json" for name in INTERFACES} < {line.split()[1] for line in lines}
    folder = shutil.copytree(DATA, tmp_path / "data")
    text = stored_text("tpv205.json", folder)
    (folder / "tpv205.json").write_text(text.replace("2.803", "2.804", 1))
    with pytest.raises(DataFileError, match="does not fit its checksum"):
        stored_text("tpv205.json", folder)
    (folder / "tpv205.json").unlink()
    with pytest.raises(DataFileError, match="cannot be read"):
        stored_text("tpv205.json", folder)


@pytest.mark.parametrize("name", SHEETS)
def test_the_file_of_a_sheet_is_its_problem(name, tmp_path):
    sheet, path = SHEETS[name], tmp_path / "problem.toml"
    assert find_sheet(name) is sheet
    page = (benchmarks.DOCS / "benchmarks.md").read_text()
    assert f"| {sheet.title} | {sheet.tests} |" in page
    path.write_text(sheet.file)
    assert find(path) == sheet.problem


@pytest.mark.thinned(4)
@pytest.mark.parametrize("name", [*QUICK, *INTERFACES])
def test_a_page_says_problem_stations_units_errors_and_classes(name):
    sheet, text = SHEETS[name], page_of(SHEETS[name])
    for words in (sheet.title, sheet.statement, sheet.note, sheet.file, f"in units {sheet.units}"):
        assert words in text
    assert ", ".join(f"{x:g}" for x in sheet.stations) in text
    assert not set("{}$") & set(sheet.statement)
    for quantity, bounds in sheet.classes.items():
        assert f"| {quantity.replace('_', ' ')} | {bounds[0]:.2g} | " in text
    for quantity, error in stated_errors(sheet).items():
        assert f"| {quantity.replace('_', ' ')} | {error:.2g} |" in text
    assert ("none are measured" in text) == (name in ("whole-line-patch", "incident-sv"))
    if sheet.is_interface:
        pressure = sheet.problem.base.pressure
        said = f"p = {pressure / 1e6:g} MPa" if sheet.units == "SI" else f"p = {pressure:g}"
        assert said in sheet.statement
        assert f"T = {sheet.end_time:g}" in sheet.statement


def test_every_named_scene_is_a_sheet():
    assert set(sheet_names()) == {*NAMED_SCENES, *NAMED_LINES}
    for name in set(sheet_names()) - set(SHEETS):
        sheet = find_sheet(name)
        assert sheet.problem == find(name)
        assert max(sheet.stations) <= sheet.extent
        assert not sheet.classes


@pytest.mark.parametrize(
    "name", ["growing-load", "incident-p", "punch", pytest.param("tpv103", marks=pytest.mark.slow)]
)
def test_a_sheet_without_classes_scores_its_own_answer(name, tmp_path):
    sheet, path = find_sheet(name), tmp_path / "mine.csv"
    path.write_text(table_of(sheet))
    assert sheet.title in page_of(sheet)
    for file in score_files([path]):
        assert (file.grade, file.held) == ("", pytest.approx(1.0))
        assert file.error < (0.02 if file.quantity == "arrival" else 1e-6)


def test_an_export_that_fails_leaves_nothing(tmp_path, monkeypatch):
    (tmp_path / "sheets").mkdir()
    (tmp_path / "sheets" / "notes.txt").write_text("mine")
    write, done = pages.write_bytes, []

    def full(path, data):
        if len(done) == 5:
            raise DataFileError("no room")
        done.append(path)
        write(path, data)

    monkeypatch.setattr(pages, "write_bytes", full)
    monkeypatch.setattr(pages, "exported", lambda _: {f"{n}/{n}": b"1" for n in range(9)})
    for place in ("sheets", "new/sheets"):
        done.clear()
        with pytest.raises(DataFileError, match="no room"):
            pages.export(tmp_path / place, [])
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["notes.txt", "sheets"]
