"""README, what CI runs, how to cite, and the changelog say the same as the project."""

import contextlib
import io
import os
import re
import runpy
import shlex
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from slipfront import __all__ as PUBLIC
from slipfront.cli.commands import COMMANDS, command_for

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
COMMANDS_PAGE = (ROOT / "docs" / "commands.md").read_text()
PAGES = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
TEXT = "\n".join(path.read_text() for path in PAGES).replace("\\\n", " ")
SHOWN = sorted(set(re.findall(r"^ {4,}slipfront ([a-z].*)$", TEXT, re.MULTILINE)))
LAYOUT = (ROOT / "docs" / "contributing.md").read_text()
CHANGES = (ROOT / "CHANGELOG.md").read_text()
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text())
FALLBACK = SETTINGS["tool"]["hatch"]["version"]["fallback-version"]


def test_ci_runs_the_test_command_of_the_readme():
    (line,) = [line.strip() for line in README.splitlines() if line.endswith("bin/pytest")]
    assert line in (ROOT / ".ci" / "run").read_text().splitlines()


def said_by(code):
    """What an example prints, and its names."""
    shown, names = io.StringIO(), {}
    with contextlib.redirect_stdout(shown), contextlib.chdir(ROOT):
        exec(code, names)
    return shown.getvalue(), names


def said_by_ten_lines(page, words):
    """What the example prints, and its names, in which these words stand on a page."""
    text = (ROOT / "docs" / page).read_text()
    (code,) = [hit for hit in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if words in hit]
    assert sum(bool(line.strip()) for line in code.splitlines()) <= 10
    return said_by(code)


def test_fringes_are_ten_lines():
    said, _ = said_by_ten_lines("fields.md", "fringe_order(stress, thickness=")
    order, light = re.findall(r"\[(.+?)\]", said, re.DOTALL)
    order, light = np.array(order.split(), dtype=float), np.array(light.split(), dtype=float)
    assert light == pytest.approx(np.sin(np.pi * order) ** 2, abs=1e-5)
    assert order[-1] == pytest.approx(5e6 * 0.03 / 130e3)  # nothing but the base has come there
    sheared = np.hypot(5e6, 2 * 8e6) * 0.03 / 130e3  # behind the plane S wave
    assert order[0] == pytest.approx(sheared, rel=1e-3)


@pytest.mark.slow
def test_a_fit_is_ten_lines():
    said, names = said_by_ten_lines("inversion.md", "sf.fit(")
    assert said.endswith(" converged\n")
    fit = names["fit"]
    away = fit.values - [0.35, 4e6, 3e-6]  # what the records were made with
    assert np.abs(away / fit.standard_errors).max() < 3
    assert fit.standard_errors[0] < 0.02


def test_every_command_and_extra_has_its_line():
    assert set(re.findall(r"^\| `slipfront ([a-z]+)", COMMANDS_PAGE, re.MULTILINE)) == set(COMMANDS)
    extras = set(re.findall(r"^\| `'\.\[(\w+)\]'`", COMMANDS_PAGE, re.MULTILINE))
    assert extras | {"test"} == set(SETTINGS["project"]["optional-dependencies"])


@pytest.mark.parametrize("line", SHOWN)
def test_commands_and_options_of_the_pages_exist(line, capsys):
    command, *rest = shlex.split(line, comments=True)
    with pytest.raises(SystemExit):
        command_for([command])([command, "--help"], prog_name="slipfront")
    shown = capsys.readouterr().out
    options = (word.split("=")[0] for word in rest if word.startswith("--"))
    assert [option for option in options if option not in shown] == []


def test_every_folder_is_in_the_code_layout():
    layout = LAYOUT.split("## Code layout")[1].split("## Conventions")[0]
    folders = {path.parent.name for path in ROOT.glob("*/__init__.py")}
    folders |= {path.parent.name for path in (ROOT / "semianalytic").glob("*/__init__.py")}
    assert [name for name in sorted(folders) if f"`{name}/`" not in layout] == []


def test_versions_agree():
    """The newest of the changelog, the citation, and what follows in a clone without tags."""
    number = re.findall(r"^## \[([\d.]+)\] - \d{4}-\d\d-\d\d$", CHANGES, re.M)[0]
    citation = (ROOT / "CITATION.cff").read_text()
    assert f"\nversion: {number}\n" in citation
    assert f"\nkeywords: [{', '.join(SETTINGS['project']['keywords'])}]\n" in citation
    for author in SETTINGS["project"]["authors"]:
        assert f"\n  - name: {author['name']}\n" in citation
    # never that of a release, which only a tag gives, and newer than it, as in a clone with tags
    major, minor, patch = number.split(".")
    assert f"{major}.{minor}.{int(patch) + 1}.dev0" == FALLBACK


def test_reference_holds_every_public_name():
    """On one page, to which the table of all names leads."""
    index = (ROOT / "docs" / "api" / "slipfront.md").read_text()
    held = {}
    for path in (ROOT / "docs" / "api").glob("*.md"):
        names = re.findall(
            r"^::: (?:semianalytic|fem|compare\.comparison\.comparing|compare\.validation"
            r"|slipfront\.(?:surveys|fits|loading))\.(\w+)$",
            path.read_text(),
            re.MULTILINE,
        )
        held |= dict.fromkeys(names, path.name) if path.name != "verify.md" else {}
    assert held.keys() == set(PUBLIC) - {"__version__", "reference", "regimes"}
    rows = re.findall(r"^\| \[.+?\]\((\w+\.md)\) \| (.+) \|$", index, re.MULTILINE)
    for page, listed in rows:
        on_it = {name for name, place in held.items() if place == page}
        assert on_it == set(re.findall(r"`(\w+)`", listed)) or page in ("verify.md", "meshes.md")


def test_every_page_is_in_the_site():
    site = (ROOT / "mkdocs.yml").read_text()
    pages = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    pages.remove("paper.md")  # for a journal
    assert set(re.findall(r": ([\w/]+\.md)$", site, re.MULTILINE)) == pages


def test_an_index_shows_the_readme_with_absolute_links(monkeypatch):
    """Its pictures and pages by the address of the forge, and no link that leads nowhere."""
    place = ModuleType("hatchling.metadata.plugin.interface")
    place.MetadataHookInterface = object
    monkeypatch.setitem(sys.modules, place.__name__, place)
    hook = runpy.run_path(str(ROOT / "hatch_build.py"))
    shown = hook["index_readme"](README, "https://forge.org/us/slipfront")
    targets = re.findall(r"\]\(([^)]*)\)", shown)
    assert len([target for target in targets if target.startswith("https://")]) == len(targets) > 20
    assert shown.count("/raw/main/docs/figures/") == README.count("![") > 0
    assert "](" not in hook["index_readme"](README, "")
    monkeypatch.setenv("GITHUB_SERVER_URL", "https://forge.org")
    monkeypatch.setenv("GITHUB_REPOSITORY", "us/slipfront")
    urls = hook["project_urls"](hook["repository"]())
    assert urls["Issues"] == "https://forge.org/us/slipfront/issues"
    assert {"readme", "urls"} < set(SETTINGS["project"]["dynamic"])


def test_every_recipe_installs_the_libraries_of_the_one_list():
    """Dockerfile and workflows read it; Binder wants one name a line."""
    libraries = (ROOT / "meshes" / "apt-packages.txt").read_text().split()
    assert (ROOT / "binder" / "apt.txt").read_text().split() == libraries
    for place in ("Dockerfile", ".github/workflows/tests.yml", ".github/workflows/nightly.yml"):
        assert "$(cat meshes/apt-packages.txt)" in (ROOT / place).read_text()


@pytest.mark.parametrize(
    "path", sorted((ROOT / ".github").rglob("*.yml")), ids=lambda case: case.name
)
def test_what_the_forge_reads_is_valid(path):
    """YAML, and no command or file that is not there."""
    yaml = pytest.importorskip("yaml")
    text = path.read_text()
    read = yaml.safe_load(text)
    jobs = read.get("jobs", {}) if path.parent.name == "workflows" else {}
    assert jobs or path.parent.name == "ISSUE_TEMPLATE"
    for job in jobs.values():
        assert job["timeout-minutes"] <= 180
        assert all(("run" in step) != ("uses" in step) for step in job["steps"])
    for name in re.findall(r"(?<![\w/])\.ci/\w+", text):
        assert os.access(ROOT / name, os.X_OK)


def test_community_files_lead_somewhere():
    for name in ("CONTRIBUTING.md", "SECURITY.md", "CODE_OF_CONDUCT.md"):
        for target in re.findall(r"\]\(([^)#:]+)(?:#[\w-]+)?\)", (ROOT / name).read_text()):
            assert (ROOT / target).exists(), target
