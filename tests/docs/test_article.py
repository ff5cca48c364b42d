"""The article reproduced: its cases, claims and the equation register."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs.studies.article.cases import Cases, article_scene, run_cases
from docs.studies.article.claims import CLAIMS, METHODS
from docs.studies.pages import read_data
from semianalytic.halfplane.stuck import stuck_traction

DOCUMENT = Path(__file__).parents[2] / "docs" / "article.md"


@pytest.fixture(scope="module")
def cases() -> Cases:
    return run_cases(32)


def test_parameters_are_the_articles():
    scene = article_scene("remote", 0.5)
    material = scene.material
    assert material.shear_speed == pytest.approx(5)
    assert material.longitudinal_speed == pytest.approx(10)
    assert material.rayleigh_speed == pytest.approx(4.662, abs=1e-3)
    assert scene.coefficient * scene.load.pressure / scene.load.shear == 0.5


def test_the_two_honest_methods_agree(cases):
    """At 40 cells per c_t T slip rates differ by 1 % of Q_0/(mu b) in the mean, first order; at 32
    by a quarter more."""
    for case in cases.values():
        assert case.solution.status == "converged"
        assert case.difference() < 0.02


def test_claims(cases):
    """The verdicts of the two honest methods are the same, and those of the page."""
    rows = [judge(cases) for judge in CLAIMS]
    kept = read_data("article-claims")[1]
    assert len(rows) == len(kept) == 10
    for row, shown in zip(rows, kept, strict=True):
        verdicts = {name: row[name].split(":")[0] for name in METHODS}
        assert verdicts["exact"] == verdicts["finite_elements"], row["claim"]
        assert verdicts == {name: shown[name].split(":")[0] for name in METHODS}
        assert (row["claim"], row["exact"]) == (shown["claim"], shown["exact"])


def test_the_methods_differ_by_little_in_all_cases_of_the_page():
    rows = read_data("article-cases")[1]
    assert len(rows) == 9
    assert max(float(row["difference"]) for row in rows) < 2e-3


def test_the_bound_without_a_base_is_negative_ahead():
    """Friction times the pressure of section 6 is below 0 from 0.59 c_t t to the first wave."""
    pressure = stuck_traction(1 / 3, "I")
    assert pressure(1 / 0.58) > 0
    assert max(float(pressure(1 / v)) for v in (0.6, 0.8, 1.0, 1.5, 1.9)) < 0


def test_equation_register_is_complete():
    """Every numbered equation has a row; that its functions exist is tested of all pages."""
    register = DOCUMENT.read_text(encoding="utf-8").split("## Equation register")[1]
    listed = set()
    for first, last in re.findall(
        r"^\| \(([\d.]+)\)(?:–\(([\d.]+)\))? \|", register.split("\n## ")[0], flags=re.MULTILINE
    ):
        section, number = first.split(".")
        for entry in range(int(number), int((last or first).split(".")[1]) + 1):
            listed.add(f"{section}.{entry}")
    counts = {"2": 1, "3": 21, "4": 45, "5": 4, "7": 11}
    assert listed == {f"{s}.{n}" for s, count in counts.items() for n in range(1, count + 1)}
