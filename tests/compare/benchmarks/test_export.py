"""Exported sheets: whole, self-contained, and never in the place of other files."""

import hashlib
import re
from base64 import b64decode
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from compare.benchmarks import export as exporting
from compare.benchmarks.answers import DATA, answer_files
from compare.benchmarks.export import export
from compare.benchmarks.pages import Heading, Table, Text, as_html, as_markdown, sheet_blocks
from compare.benchmarks.sheet import STATIONS
from compare.benchmarks.sheets import PAIR_SHEETS, SHEETS
from compare.benchmarks.starters import starter_inputs
from semianalytic import find
from semianalytic.scene.errors import DataFileError, SceneError

TWO = [SHEETS["antiplane"], SHEETS["lift-off"]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("export") / "sheets"
    export(place, TWO)
    return place


def test_all_that_is_promised_is_there(folder):
    for sheet in TWO:
        records, answers = answer_files(sheet)
        assert (folder / sheet.name / "records.csv").read_bytes() == (DATA / records).read_bytes()
        assert (folder / sheet.name / "answers.json").read_bytes() == (DATA / answers).read_bytes()
        assert (folder / sheet.name / f"{sheet.name}.md").is_file()
        assert (folder / sheet.name / "sem2dpack" / "Par.inp").is_file()
        assert (folder / sheet.name / "uguca" / f"{sheet.name}.in").is_file()
    for line in (folder / "SHA256SUMS").read_text().splitlines():
        digest, name = line.split()
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == digest


def test_pages_lack_no_figure(folder):
    for sheet in TWO:
        place = folder / sheet.name
        markdown = (place / f"{sheet.name}.md").read_text()
        pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", markdown)
        assert pictures
        for name in pictures:
            assert Image.open(place / name).width > 600
        page = (place / f"{sheet.name}.html").read_text()
        sources = re.findall(r'<img src="([^"]*)"', page)
        assert len(sources) == len(pictures)
        for source in sources:
            kind, data = source.split(",")
            assert kind == "data:image/png;base64"
            assert Image.open(BytesIO(b64decode(data))).width > 600
        assert not re.search(r'(?:src|href)="(?!data:)', page)
        assert "$" not in page


def test_links_of_the_readme_lead_somewhere(folder):
    links = re.findall(r"\]\(([^)]+)\)", (folder / "README.md").read_text())
    assert len(links) == len(TWO)
    assert all((folder / link).is_file() for link in links)


def test_an_export_that_fails_leaves_nothing(tmp_path, monkeypatch):
    (tmp_path / "sheets").mkdir()
    (tmp_path / "sheets" / "notes.txt").write_text("mine")
    write, done = exporting.write_bytes, []

    def full(path, data):
        if len(done) == 5:
            raise DataFileError("no room")
        done.append(path)
        write(path, data)

    monkeypatch.setattr(exporting, "write_bytes", full)
    monkeypatch.setattr(exporting, "exported", lambda _: {f"{n}/{n}": b"1" for n in range(9)})
    for place in ("sheets", "new/sheets"):
        done.clear()
        with pytest.raises(DataFileError, match="no room"):
            export(tmp_path / place, [SHEETS["lift-off"]])
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["notes.txt", "sheets"]


@pytest.mark.parametrize("sheet", SHEETS.values(), ids=lambda sheet: sheet.name)
def test_sheets_say_all_numbers_in_both_systems(sheet):
    text = as_markdown(list(sheet_blocks(sheet)))
    for words in ("| shear modulus μ | 1 | 1e+10 Pa |", "(200, 500, 1000, 1500, 1900 m)"):
        assert words in text
    assert f"| friction f | {sheet.scene.friction:g} |" in text
    assert "## Tolerance classes" in text
    assert "nan" not in text


def test_html_is_escaped():
    blocks = [Heading("a < b", 1), Text("<script>"), Table(("x",), (("<td>",),))]
    page = as_html(blocks, {})
    assert "<script>" not in page
    assert "<h1>a &lt; b</h1>" in page
    assert "<td>&lt;td&gt;</td>" in page


# --- inputs for other codes -----------------------------------------------------------------------


@pytest.mark.parametrize("sheet", SHEETS.values(), ids=lambda sheet: sheet.name)
def test_inputs_hold_the_numbers_of_the_sheet(sheet):
    inputs, scene = starter_inputs(sheet), sheet.scene
    held, load = scene.superposition
    lines = inputs[f"uguca/{sheet.name}.in"].splitlines()[1:]
    uguca = dict(re.fullmatch(r"\w+ (\w+) = (.*)", line).groups() for line in lines)
    assert float(uguca["friction"]) == scene.friction
    assert float(uguca["contact_pressure"]) == held.pressure
    assert float(uguca["slot_shear"]) == load.shear
    program = inputs["uguca/uguca_sheet.cc"]
    assert set(uguca) == set(re.findall(r'(?:number|get<[\w:]+>)\("(\w+)"\)', program)) | (
        set(uguca) & {"slot_shear", "contact_shear", "slot_pressure", "contact_pressure"}
    )
    if sheet.name == "viscous":
        assert not any(name.startswith("sem2dpack") for name in inputs)
        return
    parameters = inputs["sem2dpack/Par.inp"]
    assert f"MuS={scene.friction:.10g}, MuD={scene.friction:.10g}" in parameters
    assert f"Tn={-held.pressure:g}" in parameters
    for name in re.findall(r"file='([^']+)'", parameters):
        assert f"sem2dpack/{name}" in inputs


def mesh_of(sheet):
    """Places of nodes (n, 2), rows of elements (index, four nodes, tag), and lines of sides."""
    lines = starter_inputs(sheet)["sem2dpack/two.mesh2d"].splitlines()
    elements, corners, nodes, bounds = map(int, lines[1].split())
    assert (corners, bounds) == (4, 4)
    at = np.array([line.split()[1:] for line in lines[3 : 3 + nodes]], dtype=float)
    cells = np.array([line.split() for line in lines[4 + nodes :][:elements]], dtype=int)
    return at, cells, lines[4 + nodes + elements :]


def test_the_mesh_of_two_blocks_is_whole():
    at, cells, lines = mesh_of(SHEETS["tap"])
    np.testing.assert_array_equal(cells[:, 0], np.arange(len(cells)) + 1)
    low, right, high, left = at[cells[:, 1:5] - 1].transpose(1, 0, 2)
    np.testing.assert_array_equal(right - low, np.tile([10, 0], (len(cells), 1)))
    np.testing.assert_array_equal(high - left, np.tile([10, 0], (len(cells), 1)))
    np.testing.assert_array_equal(left - low, np.tile([0, 10], (len(cells), 1)))
    damped = np.minimum(abs(low[:, 1]), abs(left[:, 1])) < 20
    np.testing.assert_array_equal(cells[:, 5], np.where(damped, 2, 1))
    while lines:
        tag, count = map(int, lines[1].split())
        for line in lines[3 : 3 + count]:
            _, element, edge = map(int, line.split())
            four = cells[element - 1, 1:5]
            ends = at[(four[2:] if edge == 3 else four[:2]) - 1]
            assert not ends[:, 1].any()
            assert np.all(((ends[:, 0] >= 0) == (tag in (5, 6))) | (ends[:, 0] == 0))
        lines = lines[3 + count :]


@pytest.mark.parametrize("name", ["preloaded", "pair-slip", "pair-opening"])
def test_a_step_stays(name):
    """A table whose last load is 0 lets it fall evenly until 2 T: slip is a fifth too small."""
    sheet = {**SHEETS, **PAIR_SHEETS}[name]
    for axis, wanted in (("x", sheet.scene.load.shear), ("y", -sheet.scene.load.pressure)):
        table = starter_inputs(sheet).get(f"sem2dpack/up.{axis}", f"0 {wanted}")
        assert {float(value) for value in table.split()[1::2]} == {wanted}


@pytest.mark.parametrize("name", PAIR_SHEETS)
def test_the_mesh_of_two_different_bodies_has_both_solids(name):
    said, lower = starter_inputs(PAIR_SHEETS[name])["sem2dpack/Par.inp"], find(name).lower
    assert f"rho=1.2d0, cp={lower.longitudinal_speed:.15g}, cs={lower.shear_speed:.15g}" in said
    at, cells, _ = mesh_of(PAIR_SHEETS[name])
    middle = at[cells[:, 1:5] - 1].mean(axis=1)
    damped = np.abs(middle[:, 1]) < 20
    tags = np.where(middle[:, 1] > 0, np.where(damped, 2, 1), np.where(damped, 4, 3))
    np.testing.assert_array_equal(cells[:, 5], tags)
    fastest = lower.longitudinal_speed  # no wave is back at a station from a side before T
    assert -at[:, 0].min() / 100 >= fastest
    assert 2 * at[:, 1].max() / 100 >= fastest
    assert 2 * at[:, 0].max() / 100 - max(STATIONS) >= fastest


def test_a_pulse_goes_off_again():
    """In a table of steps alone, through which the code's cubic spline would swing far beyond."""
    table = starter_inputs(SHEETS["pulse"])["sem2dpack/up.x"].split()
    time, load = np.array(table, dtype=float).reshape(-1, 2).T
    np.testing.assert_array_equal(load, time < 40)
    assert time[-1] > 100
    assert np.diff(time).max() < 0.5
    assert np.diff(time)[np.abs(time[1:] - 40) < 0.5].max() < 0.01


def test_files_that_are_there_are_refused_or_replaced(tmp_path, monkeypatch):
    monkeypatch.setattr(exporting, "exported", lambda _: {"new/1": b"1", "there/2": b"2"})
    mine = tmp_path / "there" / "2"
    mine.parent.mkdir()
    mine.write_bytes(b"mine")
    with pytest.raises(SceneError, match=r"there/2 is there already.*--overwrite"):
        export(tmp_path, TWO)
    assert mine.read_bytes() == b"mine"
    assert not (tmp_path / "new").exists()
    export(tmp_path, TWO, overwrite=True)
    assert mine.read_bytes() == b"2"
    assert (tmp_path / "new" / "1").read_bytes() == b"1"
