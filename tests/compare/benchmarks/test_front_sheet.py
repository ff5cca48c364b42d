"""The sheet under a wave at an angle: its answer, its page, and our own codes on it."""

import math

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to, changes, content_of, written_document
from compare.benchmarks.entries import enter
from compare.benchmarks.export import exported
from compare.benchmarks.pages import as_markdown, sheet_blocks
from compare.benchmarks.scores import score
from compare.benchmarks.sheet import SI_SCALES, STATIONS, in_si
from compare.benchmarks.sheets import FRONT_SHEETS, find_sheet
from semianalytic import SceneError, Tractions, find_scene, solve
from semianalytic.halfplane.rayleigh import rayleigh_factors

SHEET = FRONT_SHEETS["incident-sv"]


def test_the_written_answer_is_the_one_computed_now():
    assert list(changes(SHEET)) == []
    answers = written_document(SHEET)["answers"]
    assert answers["zones"] == [[0.0, 0.405067274343, -1.0]]
    content = content_of(SHEET, answer_to(SHEET))
    assert all(np.isfinite(content[name]).all() for name in SHEET.report)


def test_the_intensity_of_pressure_is_that_of_the_closed_form():
    """K_I of a step at t = 1, times M_+(0) / M_+(-p), at nu = 1/3, c_l = 2 c_t."""
    p, factors = math.sin(math.radians(-20.0)), rayleigh_factors(1 / 3)
    at_once = 3 * 0.3 * math.sin(math.radians(40.0)) * math.sqrt(2 / 3 / math.pi)
    moving = factors.m_plus(np.array([-p]), "I")[0]
    expected = at_once * factors.m_plus_at_zero["I"] / moving
    assert written_document(SHEET)["answers"]["K_I"] == pytest.approx(expected, rel=1e-11)


def test_the_si_problem_is_the_same_times_its_scales():
    plain, si = answer_to(SHEET), solve(SHEET.si_problem)
    x = np.array(STATIONS)
    for name in ("slip", "slip_rate", "shear_traction", "pressure"):
        ours, theirs = getattr(plain, name)(x, 0.9), getattr(si, name)(x * SI_SCALES["x"], 0.9)
        assert theirs == pytest.approx(ours * SI_SCALES[name], rel=1e-7, abs=1e-9)
    with pytest.raises(SceneError, match="moving loads are not known here"):
        in_si(find_scene("moving-load"))


def test_the_page_states_the_wave():
    text = as_markdown(list(sheet_blocks(SHEET)))
    assert "plane SV step wave arrives from below, towards -x" in text
    assert "P_0 = -S sin(2 theta)" in text
    assert "| angle theta | -20 degrees | the same |" in text
    assert "| pressure of the load P_0 | 0.192836 | 1.92836e+06 Pa |" in text
    assert "0 to 0.4050672743" in text
    assert "none are measured" in text
    assert find_sheet("incident-sv") is SHEET
    load = find_scene("incident-sv").superposition.taken_off
    wanted = Tractions(0.3 * math.sin(math.radians(40.0)), -0.3 * math.cos(math.radians(40.0)))
    assert load.pressure == pytest.approx(wanted.pressure, rel=1e-14)
    assert load.shear == pytest.approx(wanted.shear, rel=1e-14)


def test_an_export_has_page_answer_and_figure_and_no_starters():
    names = {name.removeprefix("incident-sv/") for name in exported([SHEET])}
    assert {"incident-sv.html", "figure.png", "records.csv", "answers.json"} <= names
    assert not any("uguca/" in name or "sem2dpack/" in name for name in names)


@pytest.mark.parametrize(("code", "most"), [("march", 0.02), ("fem", 0.06)])
def test_our_own_codes_take_it(code, most):
    found = {one.quantity: one.error for one in score(enter(code, SHEET, 50))}
    assert max(found[name] for name in ("slip", "shear_traction", "pressure")) < most
