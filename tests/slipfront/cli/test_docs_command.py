"""``slipfront docs``: the pages that messages name are in the wheel, and are printed."""

import re
import tomllib
from pathlib import Path

import pytest

from slipfront.cli import docs_command

ROOT = Path(__file__).parents[3]
WHEEL = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]
WHEEL = WHEEL["wheel"]


def test_pages_that_the_packages_name_are_in_the_wheel():
    sources = (path for name in WHEEL["packages"] for path in (ROOT / name).rglob("*.py"))
    named = {page for path in sources for page in re.findall(r"docs/\w+\.md", path.read_text())}
    assert len(named) > 15
    assert named <= WHEEL["force-include"].keys()
    for source, place in WHEEL["force-include"].items():
        assert (ROOT / source).is_file()
        assert ROOT / place == docs_command.FOLDERS[0] / Path(source).name


@pytest.mark.parametrize("name", ["docs/not_here.md", "not_here.md", "not_here"])
def test_a_page_is_printed_by_the_name_that_messages_give(name, shown):
    said = shown(f"docs {name}").out
    text = (ROOT / "docs" / "not_here.md").read_text()
    assert text.startswith("---\n")  # settings of the site, which are not printed
    assert said.startswith("# What slipfront does not do")
    assert text.endswith(said)


def test_pages_are_listed_with_their_titles(shown):
    assert re.search(r"limits +│ Assumptions and limits", shown("docs").out)


def test_pages_and_titles_are_data_too(printed):
    pages, page = printed("docs")["pages"], printed("docs docs/limits.md")
    assert page["page"] == "limits"
    assert page["text"].startswith(f"# {pages['limits']}\n")


def test_an_installed_package_has_its_pages_beside_it(tmp_path, monkeypatch, shown):
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "limits.md").write_text("# Limits of the wheel\n")
    monkeypatch.setattr(docs_command, "FOLDERS", (tmp_path / "docs", ROOT / "docs"))
    assert shown("docs limits").out == "# Limits of the wheel\n"
