"""Numbers, names and links of README and docs: as the code has them."""

import ast
import importlib
import inspect
import re
from functools import cache
from pathlib import Path

import pytest

from compare import number_functions, numbers
from compare.numbers import Entry, Quoted, check, main, read_list

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
ENTRIES = read_list()
CHEAP = [entry for entry in ENTRIES if not entry.slow]
SLOW = [entry for entry in ENTRIES if entry.slow]


def name(part):
    return part.id if isinstance(part, Entry) else part.name


@pytest.mark.parametrize("entry", ENTRIES, ids=name)
def test_every_quoted_text_is_in_its_pages(entry):
    assert entry.missing_pages() == []
    assert all(quoted.value == quoted.value for quoted in entry.quoted)


@pytest.mark.parametrize("entry", CHEAP, ids=name)
def test_number_is_what_the_code_computes(entry):
    assert check(entry).problem == ""


@pytest.mark.slow
@pytest.mark.parametrize("entry", SLOW, ids=name)
def test_expensive_number_is_what_the_code_computes(entry):
    assert check(entry).problem == ""


def test_entries_are_told_apart_and_every_function_is_used():
    assert len({entry.id for entry in ENTRIES}) == len(ENTRIES)
    own = {
        name
        for name, function in inspect.getmembers(number_functions, inspect.isfunction)
        if function.__module__ == number_functions.__name__ and not name.startswith("_")
    }
    assert {entry.function for entry in ENTRIES if "." not in entry.function} == own


@pytest.mark.parametrize(
    ("written", "value", "unit"),
    [
        ("0.0575", 0.0575, 1e-4),
        ("−24.4 %", -0.244, 1e-3),
        ("+7.3 %", 0.073, 1e-3),
        ("1.60·10⁻⁸", 1.60e-8, 1e-10),
        ("10⁻¹⁵", 1e-15, 1e-15),
        ("2.34e-3", 2.34e-3, 1e-5),
        ("82,940", 82940, 1),
        ("-7", -7, 1),
    ],
)
def test_numbers_are_read_as_they_are_written(written, value, unit):
    quoted = Quoted(written)
    assert quoted.value == pytest.approx(value, rel=1e-12)
    assert quoted.unit == pytest.approx(unit, rel=1e-12)
    assert quoted.rewritten(quoted.value) == written
    assert Quoted(quoted.rewritten(1.7 * value)).value == pytest.approx(1.7 * value, rel=0.5)


def test_what_is_no_number_is_refused():
    for written in ("", "%", "1.2.3", "seven", "1/3"):
        with pytest.raises(ValueError, match="not a number"):
            _ = Quoted(written).value


def entry(text, agreement, tolerance):
    return Entry("some", ("README.md",), text, "published_limit", agreement, tolerance)


@pytest.mark.parametrize(
    ("text", "agreement", "tolerance", "fine"),
    [
        ("not the published «0.0575»", "relative", 1e-9, True),
        ("not the published «0.0575»", "units", 0, True),
        ("«0.0576»", "units", 1, True),
        ("«0.0576»", "units", 0.5, False),
        ("«0.05»", "absolute", 0.01, True),
        ("«0.05»", "absolute", 0.001, False),
        ("«0.1»", "factor", 2, True),
        ("«0.2»", "factor", 2, False),
        ("«0.06»", "at_most", 1, True),
        ("«0.05»", "at_most", 1, False),
        ("«0.05»", "at_least", 1, True),
        ("«0.06»", "at_least", 1, False),
    ],
)
def test_kinds_of_agreement(text, agreement, tolerance, fine):
    finding = check(entry(text, agreement, tolerance))
    assert bool(finding.change) != fine


def test_findings_name_the_page_and_the_number():
    finding = check(entry("not the published «0.0576»", "relative", 1e-9))
    assert "README.md does not say" in finding.problem
    assert "0.0576 is 0.0575" in finding.problem
    assert finding.change == "not the published 0.0575"
    wrong = check(entry("from «1» to «2»", "relative", 1e-9))
    assert "2 numbers quoted, 1 found" in wrong.problem


def test_a_function_is_called_for_each_and_its_values_multiplied():
    rows = Entry(
        "some",
        ("README.md",),
        "«93.3», «77.4», «77.4»",
        "rayleigh_speed",
        "units",
        0.6,
        each=(1 / 3, [-0.5], -0.5),
        times=100,
    )
    assert rows.computed() == pytest.approx([93.25, 77.43, 77.43], rel=1e-4)
    assert check(rows).change == ""
    named = Entry("some", (), "«1»", "regime_boundaries.edge_threshold_alone", "units", 1, (0.0,))
    assert named.computed() == pytest.approx([2**0.25])


def test_command_fails_where_a_number_is_off(monkeypatch, capsys):
    off = entry("not the published «0.0576»", "relative", 1e-9)
    good = entry("not the published «0.0575»", "relative", 1e-9)
    monkeypatch.setattr(numbers, "read_list", lambda: [off, good])
    assert main(["--write"]) == 1
    shown = capsys.readouterr().out
    assert "some: README.md does not say" in shown
    assert "write\n  not the published 0.0575" in shown
    monkeypatch.setattr(numbers, "read_list", lambda: [good])
    assert main(["--check"]) == 0
    assert "1 numbers in 1 texts, 0 texts to correct" in capsys.readouterr().out


def test_incomplete_lists_are_refused(tmp_path):
    path = tmp_path / "numbers.toml"
    start = '[[number]]\nid = "a"\npages = ["README.md"]\ntext = "«1»"\n'
    for rest, message in (
        ('function = "published_limit"\n', "give one of"),
        ('function = "nothing"\nunits = 1\n', "nothing"),
        ('function = "published_limit"\nunits = 1\nhaste = 2\n', "haste"),
    ):
        path.write_text(start + rest)
        with pytest.raises(ValueError, match=message):
            read_list(path)


# --- names in the pages -------------------------------------------------------------------------


@cache
def functions_of(file):
    tree = ast.parse((ROOT / file).read_text())
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_test_named_in_docs_exists(page):
    text = page.read_text()
    missing = [
        f"{file}::{function}"
        for file, function in re.findall(r"(tests/[\w/]+\.py)::(test_\w+)", text)
        if not (ROOT / file).is_file() or function not in functions_of(file)
    ]
    alone = {one for one in re.findall(r"`(test_\w+)`", text)}
    everywhere = set().union(
        *(functions_of(str(p.relative_to(ROOT))) for p in (ROOT / "tests").rglob("test_*.py"))
    )
    assert missing == []
    assert alone - everywhere == set()


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_function_named_in_docs_exists(page):
    for dotted in set(
        re.findall(r"`((?:semianalytic|fem|meshes|compare)(?:\.\w+)+)`", page.read_text())
    ):
        module, *rest = dotted.split(".")
        found = importlib.import_module(module)
        for part in rest:
            try:
                found = getattr(found, part)
            except AttributeError:
                found = importlib.import_module(f"{found.__name__}.{part}")


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_file_and_link_named_in_docs_exists(page):
    text = page.read_text()
    for target in re.findall(r"\]\(([^)#:]+)(?:#[\w-]+)?\)", text):
        assert (page.parent / target).is_file(), target
    folders = "semianalytic|fem|meshes|compare|tests|docs"
    for path in re.findall(rf"`((?:{folders})/[\w/]+\.\w+)`", text):
        assert (ROOT / path).is_file(), path


def test_every_named_scene_has_its_section():
    from semianalytic.scene.named import NAMED_SCENES

    page = (ROOT / "docs" / "scenes.md").read_text()
    sections = re.findall(r"^## (\S+)$", page, re.MULTILINE)
    assert sections == list(NAMED_SCENES)


def test_figures_are_small():
    for path in (ROOT / "docs" / "figures").glob("scene_*.png"):
        assert path.stat().st_size < 150_000
