"""README, what CI runs, how to cite, and the changelog say the same as the project."""

import contextlib
import io
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from compare.cli.commands import app
from slipfront import __all__ as PUBLIC

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
COMMANDS = {command.name or command.callback.__name__ for command in app.registered_commands} | {
    group.name for group in app.registered_groups
}
TITLE = "On the transient planar contact problem in the presence of dry friction and slip"


def test_ci_runs_the_test_command_of_the_readme():
    (line,) = [line.strip() for line in README.splitlines() if line.endswith("bin/pytest")]
    assert line in (ROOT / ".ci" / "run").read_text().splitlines()


def test_first_answer_of_the_readme():
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown):
        exec(README.split("```python\n")[1].split("```")[0], {})
    assert shown.getvalue().count("SlipZone") == 2


def test_fringes_of_the_readme_are_ten_lines():
    code = README.split("```python\n")[2].split("```")[0]
    assert sum(bool(line.strip()) for line in code.splitlines()) <= 10
    shown, names = io.StringIO(), {}
    with contextlib.redirect_stdout(shown):
        exec(code, names)
    order, light = re.findall(r"\[(.+?)\]", shown.getvalue(), re.DOTALL)
    order, light = np.array(order.split(), dtype=float), np.array(light.split(), dtype=float)
    assert light == pytest.approx(np.sin(np.pi * order) ** 2, abs=1e-5)
    assert order[-1] == pytest.approx(5e6 * 0.03 / 130e3)  # nothing but the base has come there
    sheared = np.hypot(5e6, 2 * 8e6) * 0.03 / 130e3  # behind the plane S wave
    assert order[0] == pytest.approx(sheared, rel=1e-3)


def test_fit_of_the_readme_is_ten_lines():
    code = README.split("```python\n")[3].split("```")[0]
    assert sum(bool(line.strip()) for line in code.splitlines()) <= 10
    shown, names = io.StringIO(), {}
    with contextlib.redirect_stdout(shown), contextlib.chdir(ROOT):
        exec(code, names)
    assert shown.getvalue().endswith(" converged\n")
    fit = names["fit"]
    away = fit.values - [0.35, 4e6, 3e-6]  # what the records were made with
    assert np.abs(away / fit.standard_errors).max() < 3
    assert fit.standard_errors[0] < 0.02


def test_readme_names_every_command_and_extra():
    assert set(re.findall(r"^\| `slipfront ([a-z]+)", README, re.MULTILINE)) == COMMANDS
    extras = set(re.findall(r"^\| `'\.\[(\w+)\]'`", README, re.MULTILINE))
    assert extras | {"test"} == set(PROJECT["optional-dependencies"])


@pytest.mark.parametrize("line", re.findall(r"^    slipfront (.+)$", README, re.MULTILINE))
def test_options_of_the_readme_exist(line, capsys):
    command, *rest = line.split()
    with pytest.raises(SystemExit):
        app([command, "--help"], prog_name="slipfront")
    shown = capsys.readouterr().out
    assert [word for word in rest if word.startswith("--") and word not in shown] == []


def test_every_folder_is_in_the_house():
    house = README.split("## The house")[1].split("## Documentation")[0]
    folders = {path.parent.name for path in ROOT.glob("*/__init__.py")}
    folders |= {path.parent.name for path in (ROOT / "semianalytic").glob("*/__init__.py")}
    assert [name for name in sorted(folders) if f"`{name}/`" not in house] == []


def test_title_of_the_article_stands_where_it_is_cited_only():
    pages = [ROOT / "README.md", ROOT / "CITATION.cff", *(ROOT / "docs").rglob("*.md")]
    named = {path.name for path in pages if TITLE in " ".join(path.read_text().split())}
    assert named == {"README.md", "CITATION.cff", "theory.md"}


def test_versions_agree():
    version = PROJECT["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert re.search(rf"^## {re.escape(version)}\b", (ROOT / "CHANGELOG.md").read_text(), re.M)


def test_reference_holds_every_public_name():
    page = (ROOT / "docs" / "api" / "slipfront.md").read_text()
    held = re.findall(
        r"^::: (?:semianalytic|fem|compare\.(?:validation|surveys|inversion))\.(\w+)$",
        page,
        re.MULTILINE,
    )
    assert sorted(held) == sorted(set(PUBLIC) - {"__version__"})


def test_every_page_is_in_the_site():
    site = (ROOT / "mkdocs.yml").read_text()
    pages = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    assert set(re.findall(r": ([\w/]+\.md)$", site, re.MULTILINE)) == pages
