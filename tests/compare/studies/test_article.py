"""The article reproduced: its cases, claims, figures and the equation register."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from compare.studies.article.cases import (
    Cases,
    article_material,
    article_scene,
    check_slot,
    run_cases,
)
from compare.studies.article.claims import FAILS, METHODS
from compare.studies.article.study import (
    claims_table,
    figure_2,
    figure_5,
    figure_6,
    judge_claims,
    readings_table,
    slot_figure,
    slot_table,
    write_article,
)
from semianalytic.reference import DEFAULT_READING, Reading, examine_reading
from semianalytic.scene.errors import SceneError

DOCUMENT = Path(__file__).parents[3] / "docs" / "article.md"


@pytest.fixture(scope="module")
def cases() -> Cases:
    return run_cases(32)


def test_parameters_are_the_articles():
    material = article_material()
    assert material.shear_speed == pytest.approx(5)
    assert material.longitudinal_speed == pytest.approx(10)
    assert material.rayleigh_speed == pytest.approx(4.662, abs=1e-3)
    scene = article_scene(0.5, "remote")
    assert scene.friction * scene.load.pressure / scene.load.shear == 0.5


def test_the_two_honest_methods_agree(cases):
    """At 40 cells per c_t T slip rates differ by 1 % of Q_0/(mu b) in the mean, first order; at 32
    by a quarter more."""
    for case in cases.everyone():
        assert case.solution.status == "converged"
        assert case.disagreement() < 0.02


def test_claims(cases):
    claims = judge_claims(cases)
    assert len(claims) == 10
    for claim in claims:
        assert tuple(claim.verdicts) == METHODS
        exact, simulated = claim.verdicts["exact"], claim.verdicts["finite elements"]
        assert exact.verdict == simulated.verdict, claim.text
        assert all(np.all([v.verdict, v.evidence]) for v in claim.verdicts.values())
    by_text = {claim.text: claim.verdicts["exact"].verdict for claim in claims}
    assert by_text["no shear traction ahead of the shear wave"] == FAILS
    assert by_text["the edge sticks for chi >= 1"] == FAILS
    table = claims_table(claims)
    assert len(table.splitlines()) == 12


@pytest.mark.slow
def test_tables_and_figures(cases):
    checks = (check_slot("II", 0.04), check_slot("I", 0.04))
    for figure in (figure_2(cases), figure_5(cases), figure_6(cases), slot_figure(checks)):
        assert all(axes.lines for axes in figure.axes)
    singular = examine_reading(Reading(delay="printed"), 10)
    table = readings_table([examine_reading(DEFAULT_READING, 40), singular])
    assert "(default)" in table
    assert "singular" in table
    assert "mode II" in slot_table(checks)


@pytest.mark.slow
def test_write_article(tmp_path):
    lines = []
    article = write_article(tmp_path, quick=True, progress=lines.append)
    assert all(path.stat().st_size > 1000 for path in article.files)
    assert len(article.readings) == 144
    assert len(lines) == 12
    assert article.disagreement < 0.02


@pytest.mark.parametrize(
    ("chi", "loading", "words"),
    [(0.5, "article", "bound is negative"), (-1.0, "remote", "chi must be positive")],
)
def test_scene_errors(chi, loading, words):
    with pytest.raises(SceneError, match=words):
        article_scene(chi, loading)


def test_equation_register_is_complete():
    """Every numbered equation has a row; that its functions exist is tested of all pages."""
    register = DOCUMENT.read_text(encoding="utf-8").split("## Equation register")[1]
    listed = set()
    for first, last in re.findall(
        r"^\| \(([\d.]+)\)(?:–\(([\d.]+)\))? \|", register.split("\n## ")[0], flags=re.MULTILINE
    ):
        section, number = first.split(".")
        for one in range(int(number), int((last or first).split(".")[1]) + 1):
            listed.add(f"{section}.{one}")
    counts = {"2": 1, "3": 21, "4": 45, "5": 4, "7": 11}
    assert listed == {f"{s}.{n}" for s, count in counts.items() for n in range(1, count + 1)}
