"""Sheets in both systems of units; their answers as written, in closed form, and when spoilt."""

import csv
import hashlib
import json
import shutil

import numpy as np
import pytest

from compare.benchmarks import __main__ as command
from compare.benchmarks.answers import (
    DATA,
    NODES,
    SUMS,
    answer_files,
    answer_to,
    arrival_level,
    arrival_times,
    changes,
    content_of,
    csv_of,
    document_of,
    json_of,
    write_answers,
    written_bytes,
    written_document,
)
from compare.benchmarks.sheet import SI_SCALES, STATIONS, TIMES, in_si
from compare.benchmarks.sheets import ALL_SHEETS, SHEETS
from compare.records.record import QUANTITIES
from semianalytic import solve
from semianalytic.reference import (
    antiplane_edge_speed,
    antiplane_slip,
    antiplane_slip_rate,
    edge_speed_of_opening,
)
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.overriding import override_scene

SOLVED = [sheet for sheet in SHEETS.values() if not sheet.is_marched]


def name(sheet):
    return sheet.name


@pytest.mark.thinned(4)
@pytest.mark.parametrize("sheet", SOLVED, ids=name)
def test_answers_have_not_changed(sheet):
    assert list(changes(sheet)) == []


@pytest.mark.parametrize("nodes", [1000, pytest.param(NODES, marks=pytest.mark.slow)])
def test_the_marched_answer_has_not_changed(nodes):
    assert list(changes(SHEETS["pulse"], nodes=nodes)) == []


def test_checksums_are_those_of_the_files_and_name_them_all():
    lines = (DATA / SUMS).read_text().splitlines()
    names = [line.split()[1] for line in lines]
    assert names == sorted(file for sheet in ALL_SHEETS.values() for file in answer_files(sheet))
    for line in lines:
        digest, file = line.split()
        assert hashlib.sha256((DATA / file).read_bytes()).hexdigest() == digest


# --- what is known in closed form -----------------------------------------------------------------


def test_the_antiplane_answer_is_the_closed_form():
    scene, document = SHEETS["antiplane"].scene, written_document(SHEETS["antiplane"])
    chi = scene.friction * scene.base.pressure / scene.load.shear
    answers = document["answers"]
    speed = antiplane_edge_speed(scene.material, chi)
    assert speed == pytest.approx(1 / (1 + chi) ** 2)
    assert answers["zones"][0][1] == pytest.approx(speed, rel=1e-10)
    x, t = np.array(STATIONS), np.array(TIMES)[:, None]
    rate = antiplane_slip_rate(scene.material, scene.load.shear, chi, x / t)
    slip = antiplane_slip(scene.material, scene.load.shear, chi, x, t)
    np.testing.assert_allclose(answers["slip_rate"], rate, rtol=1e-10, atol=1e-11)
    np.testing.assert_allclose(answers["slip"], slip, rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize("sheet", ["lift-off", "lift-off-shear"])
def test_the_contact_opens_up_to_the_closed_form(sheet):
    scene, document = SHEETS[sheet].scene, written_document(SHEETS[sheet])
    speed = edge_speed_of_opening(scene.material, scene.base.pressure / -scene.load.pressure)
    assert speed == pytest.approx(3 / 16)
    assert document["answers"]["openings"][0] == pytest.approx([0.0, speed], rel=1e-10)


def test_the_stuck_edge_has_the_closed_form_intensities():
    answers = written_document(SHEETS["stuck"])["answers"]
    assert answers["zones"] == []
    assert answers["K_I"] == pytest.approx(1.3820, abs=5e-5)
    assert answers["K_II"] == pytest.approx(1.9544, abs=5e-5)
    assert np.max(np.abs(answers["slip"])) == 0


@pytest.mark.thinned(2)
@pytest.mark.parametrize("sheet", [one for one in SOLVED if one.arrival], ids=name)
def test_at_an_arrival_the_level_is_passed(sheet):
    answer = answer_to(sheet)
    for x, time in zip(STATIONS, arrival_times(sheet, answer, STATIONS), strict=True):
        if np.isfinite(time):
            sides = np.array([1 - 1e-6, 1 + 1e-6]) * time
            read = np.abs(answer.slip_rate(x, sides))
            if sheet.arrival == "opening":
                read = -answer.pressure(x, sides)
            level = arrival_level(sheet) * (-1 if sheet.arrival == "opening" else 1)
            assert read[0] < level < read[1]


# --- files ----------------------------------------------------------------------------------------


def test_records_are_those_of_the_numbers():
    sheet = SHEETS["remote-shock"]
    answers = written_document(sheet)["answers"]
    lines = written_bytes(answer_files(sheet)[0]).decode().splitlines()
    table = list(csv.reader(line for line in lines if not line.startswith("#")))
    assert tuple(table[0]) == ("t", "x", *QUANTITIES)
    assert len(table) == 1 + len(STATIONS) * len(TIMES)
    row = table[1 + 2 * len(TIMES) + 20]
    expected = [TIMES[20], STATIONS[2], *(answers[one][20][2] for one in QUANTITIES)]
    assert [float(cell) for cell in row] == expected


@pytest.fixture
def folder(tmp_path):
    shutil.copytree(DATA, tmp_path / "data")
    return tmp_path / "data"


def signed(folder):
    """Writes the checksums of the files as they are."""
    files = [file for one in SHEETS.values() for file in answer_files(one)]
    sums = (f"{hashlib.sha256((folder / one).read_bytes()).hexdigest()}  {one}\n" for one in files)
    (folder / SUMS).write_text("".join(sums))


def respelt(folder, sheet, document):
    """Files of a sheet with other numbers and the checksums of those."""
    for file, text in zip(answer_files(sheet), (csv_of(document), json_of(document)), strict=True):
        (folder / file).write_text(text)
    signed(folder)


@pytest.mark.parametrize(
    ("quantity", "place"), [("zones", (0, 1)), ("arrivals", (1,)), ("slip_rate", (30, 0))]
)
def test_a_spoilt_number_is_noticed(folder, quantity, place):
    sheet = SHEETS["preloaded"]
    document = written_document(sheet)
    *path, last = quantity, *place
    row = document["answers"]
    for key in path:
        row = row[key]
    row[last] *= 1 + 1e-9
    respelt(folder, sheet, document)
    (change,) = changes(sheet, folder=folder)
    assert quantity in change


def test_a_spoilt_file_is_refused(folder):
    sheet = SHEETS["preloaded"]
    path = folder / answer_files(sheet)[1]
    path.write_text(path.read_text().replace("0.884265939462", "0.884265939463"))
    with pytest.raises(DataFileError, match="does not fit its checksum"):
        list(changes(sheet, folder=folder))
    path.unlink()
    with pytest.raises(DataFileError, match="cannot be read"):
        written_document(sheet, folder)


def test_records_that_are_not_those_of_the_numbers_are_noticed(folder):
    sheet = SHEETS["antiplane"]
    respelt(folder, sheet, written_document(sheet))
    path = folder / answer_files(sheet)[0]
    path.write_text(path.read_text().replace("0.1,", "0.2,", 1))
    signed(folder)
    (change,) = changes(sheet, folder=folder)
    assert "does not hold the records" in change


def test_what_is_written_anew_is_what_was_there(tmp_path, monkeypatch):
    few = {one: SHEETS[one] for one in ("lift-off", "antiplane")}
    monkeypatch.setattr("compare.benchmarks.answers.ALL_SHEETS", few)
    write_answers(tmp_path)
    for sheet in few.values():
        assert list(changes(sheet, folder=tmp_path)) == []
        old, new = json.loads(json_of(document_of(sheet))), written_document(sheet)
        assert old["scene"] == new["scene"]


def test_command_lists_checks_and_refuses(monkeypatch, capsys):
    assert command.main([]) == 0
    assert "remote-shock" in capsys.readouterr().out
    monkeypatch.setattr(command, "ALL_SHEETS", {"lift-off": ALL_SHEETS["lift-off"]})
    assert command.main(["--check"]) == 0
    monkeypatch.setattr(command, "changes", lambda sheet: [f"{sheet.name} has changed"])
    assert command.main(["--check"]) == 1
    assert "lift-off has changed" in capsys.readouterr().out


# --- the scenes that sheets stand for -------------------------------------------------------------


def test_there_are_ten_and_one_is_marched():
    assert len(SHEETS) == 10
    assert [sheet.name for sheet in SHEETS.values() if sheet.is_marched] == ["pulse"]
    assert all(set(sheet.report) <= set(QUANTITIES) for sheet in SHEETS.values())


@pytest.mark.thinned(12)
@pytest.mark.parametrize("sheet", SOLVED, ids=lambda sheet: sheet.name)
def test_in_si_the_answer_is_the_same_times_scales(sheet):
    plain, si = answer_to(sheet), solve(sheet.si_scene, rtol=1e-12)
    x, t = np.array(STATIONS), np.array(TIMES)[:, None]
    for name in QUANTITIES:
        scaled = SI_SCALES[name] * getattr(plain, name)(x, t)
        theirs = getattr(si, name)(x * SI_SCALES["x"], t * SI_SCALES["t"])
        np.testing.assert_allclose(theirs, scaled, rtol=1e-10, atol=1e-11 * SI_SCALES[name])


def test_in_si_a_pulse_lasts_as_long():
    sheet = SHEETS["pulse"]
    plain, si = (
        solve(sheet.scene, method="space-time", end_time=1.0, nodes=100),
        solve(sheet.si_scene, method="space-time", end_time=1.0, nodes=100),
    )
    slip = SI_SCALES["slip"] * plain.slip(0.25, 0.9)
    assert si.slip(0.25 * SI_SCALES["x"], 0.9) == pytest.approx(float(slip), rel=1e-9)


@pytest.mark.parametrize("sheet", SOLVED, ids=lambda sheet: sheet.name)
def test_no_front_passes_a_station_at_a_time_of_the_records(sheet):
    answer = answer_to(sheet)
    ends = [end for zone in (*answer.zones, *answer.openings) for end in (zone.inner, zone.outer)]
    material = sheet.scene.material
    fronts = [*ends, material.rayleigh_speed, material.shear_speed, material.longitudinal_speed]
    speeds = np.array(STATIONS) / np.array(TIMES)[:, None]
    assert np.abs(np.subtract.outer(fronts, speeds)).min() > 1e-5


def test_the_supershear_daughter_is_where_its_sheet_says():
    daughter = content_of(SHEETS["preloaded"], answer_to(SHEETS["preloaded"]))["zones"][1]
    assert daughter[0] == pytest.approx(0.977, abs=5e-4)
    assert daughter[1] == pytest.approx(1.061, abs=5e-4)


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (override_scene(find_scene("preloaded"), density=2.0), "modulus and a density of 1"),
        (find_scene("moving-load"), "moving loads are not known here"),
    ],
)
def test_only_scenes_in_plain_units_are_turned_to_si(scene, words):
    with pytest.raises(SceneError, match=words):
        in_si(scene)
