"""Tables, names and links of README and docs: as the data and the code have them."""

import importlib
import importlib.util
import re
from functools import cache

import docs_pages
import pytest
from docs_pages import assert_page_says, quoted_numbers, read_number

import docs.studies.pages
from docs.studies.pages import DATA, ROOT, main, pages, read_data

PAGES = pages()
FILES = sorted(path.stem for path in DATA.glob("*.csv"))


def name(part):
    return part.name


# --- tables -------------------------------------------------------------------------------------


def test_pages_are_as_their_data_are(capsys):
    assert main(["--check"]) == 0, capsys.readouterr().out


@pytest.mark.thinned(2)
@pytest.mark.parametrize("file", FILES)
def test_every_data_file_names_a_command_there_is_and_is_shown(file):
    command, rows = read_data(file)
    assert rows
    python, *words = command.partition(";")[0].split()
    if python == "python":
        module = importlib.util.find_spec(words[1])
        assert module is not None
        studies = getattr(importlib.import_module(words[1]), "STUDIES", words[2:3])
        assert set(words[2:3]) <= {getattr(study, "name", study) for study in studies}
    else:
        assert python in ("slipfront", "pytest")
    marks = (f"<!-- table: {file}", f"data/{file}.csv")
    assert any(mark in page.read_text() for page in PAGES for mark in marks)


def test_command_names_a_stale_page_and_writes_it(tmp_path, monkeypatch, capsys):
    page = tmp_path / "page.md"
    block = "<!-- table: campaign-answers\n| what |\n| {what} |\n-->\nstale\n<!-- end -->\n"
    page.write_text(block)
    monkeypatch.setattr(docs.studies.pages, "ROOT", tmp_path)
    monkeypatch.setattr(docs.studies.pages, "pages", lambda: [page])
    assert main(["--check"]) == 1
    assert page.read_text() == block
    assert main(["--write"]) == 0
    assert "scenes drawn" in page.read_text()
    assert main(["--check"]) == 0
    assert capsys.readouterr().out == "page.md: not up to date\npage.md: written\n"


# --- numbers in sentences ------------------------------------------------------------------------


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
    assert read_number(written) == (pytest.approx(value), pytest.approx(unit))


def test_sentences_are_found_and_held(tmp_path, monkeypatch):
    monkeypatch.setattr(docs_pages, "ROOT", tmp_path)
    (tmp_path / "page.md").write_text(
        "The edge is at 0.31\nspacings, or **1.6·10⁻⁸**; once 1, once 2."
    )
    [(edge, _), (other, _)] = quoted_numbers("page.md", "is at {} spacings, or **{}**")
    assert (edge, other) == (0.31, pytest.approx(1.6e-8))
    assert_page_says("page.md", "is at {} spacings", 0.3148)
    with pytest.raises(AssertionError, match=r"0\.31 is 0\.317"):
        assert_page_says("page.md", "is at {} spacings", 0.317)
    with pytest.raises(AssertionError, match="does not say"):
        quoted_numbers("page.md", "was at {}")
    with pytest.raises(AssertionError, match="in several ways"):
        quoted_numbers("page.md", "once {}")


# --- names in the pages -------------------------------------------------------------------------


@cache
def functions_of(file):
    return set(re.findall(r"^ *def (\w+)", (ROOT / file).read_text(), re.MULTILINE))


@pytest.mark.thinned(3)
@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_test_named_in_docs_exists(page):
    text = page.read_text()
    missing = [
        f"{file}::{function}"
        for file, function in re.findall(r"(tests/[\w/]+\.py)::(test_\w+)", text)
        if not (ROOT / file).is_file() or function not in functions_of(file)
    ]
    alone = {match for match in re.findall(r"`(test_\w+)`", text)}
    everywhere = set().union(
        *(functions_of(str(p.relative_to(ROOT))) for p in (ROOT / "tests").rglob("test_*.py"))
    )
    assert missing == []
    assert alone - everywhere == set()


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_dotted_name_in_docs_exists(page):
    packages = r"semianalytic|fem|meshes|compare|slipfront|docs\.\w+|tests"
    text = page.read_text()
    commands = re.findall(r"python -m (docs[a-z_.]*[a-z_])\b(?!\.[A-Z])", text)
    for dotted in {*commands, *re.findall(rf"`((?:{packages})(?:\.\w+)+)[`(]", text)}:
        if (ROOT / dotted).is_file():  # the name of a file, such as compare.csv
            continue
        module, *rest = dotted.split(".")
        found = importlib.import_module(module)
        for part in rest:
            try:
                found = getattr(found, part)
            except AttributeError:
                found = importlib.import_module(f"{found.__name__}.{part}")


def test_paper_is_in_the_form_of_the_journal():
    yaml = pytest.importorskip("yaml")
    text, known = ((ROOT / "docs" / name).read_text() for name in ("paper.md", "paper.bib"))
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    names = [author["name"] for author in yaml.safe_load(text.split("---")[1])["authors"]]
    assert names == [author["name"] for author in citation["authors"]]
    assert len(text.split()) <= 1000
    entries = re.findall(r"^@\w+\{(\w+),$", known, re.MULTILINE)
    assert sorted(set(re.findall(r"@(\w+)[;\]]", text))) == sorted(entries)
    assert len(re.findall(r"^  doi = \{10\.\d+/\S+\},$", known, re.MULTILINE)) == len(entries)


@cache
def headings_of(page):
    """Anchors of a page, as `mkdocs` derives them from its headings."""
    plain = re.sub(r"^```.*?^```|<!--.*?-->", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#+ (.+)$", plain, re.MULTILINE)
    words = [re.sub(r"\]\([^)]*\)|[^\w\s-]", "", heading).strip().lower() for heading in headings]
    return {re.sub(r"[\s-]+", "-", word) for word in words}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_file_and_link_named_in_docs_exists(page):
    text = page.read_text()
    for target, anchor in re.findall(r"\]\(([^)#:]*)(?:#([\w-]+))?\)", text):
        assert not target or (page.parent / target).is_file(), target
        if anchor and not target.endswith(".ipynb"):
            headings = headings_of(page.parent / target if target else page)
            assert anchor in headings, f"{target}#{anchor}"
    folders = "semianalytic|fem|meshes|compare|slipfront|tests|docs"
    for path in re.findall(rf"`((?:{folders})/[\w/]+\.\w+)`", text):
        assert (ROOT / path).is_file(), path


def test_every_named_scene_has_its_section():
    from semianalytic.scene.given.named import NAMED_SCENES

    page = (ROOT / "docs" / "scenes.md").read_text()
    sections = re.findall(r"^##+ (\S+)$", page, re.MULTILINE)
    slots = (name for name, scene in NAMED_SCENES.items() if scene.scene.has_slot)
    assert sections == [name for name in slots if name != "growing-load"]


def test_pictures_are_said_in_words():
    seen = [
        (path.name, words)
        for path in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
        for words in re.findall(r"!\[([^\]]*)\]\(", path.read_text())
    ]
    assert len(seen) > 40
    assert [pair for pair in seen if len(pair[1].split()) < 6] == []


def test_figures_are_small():
    for path in (ROOT / "docs" / "figures").glob("scene_*.png"):
        assert path.stat().st_size < 150_000
