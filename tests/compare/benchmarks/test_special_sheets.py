"""Sheets beside the ten: under a wave at an angle, without a slot, of two different bodies."""

import math

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to, changes, content_of, written_document
from compare.benchmarks.entries import enter, read_run
from compare.benchmarks.export import exported
from compare.benchmarks.pages import as_markdown, sheet_blocks
from compare.benchmarks.scores import EXACTLY, score
from compare.benchmarks.sheet import SI_SCALES, STATIONS, TIMES
from compare.benchmarks.sheets import (
    ALL_SHEETS,
    FRONT_SHEETS,
    LINE_SHEETS,
    PAIR_SHEETS,
    find_sheet,
)
from compare.benchmarks.starters import uguca_parameters
from compare.records.record import QUANTITIES
from semianalytic import SceneError, find, solve
from semianalytic.halfplane.rayleigh import rayleigh_factors

FRONT, LINE = FRONT_SHEETS["incident-sv"], LINE_SHEETS["whole-line-patch"]
SHEETS = [FRONT, LINE, *PAIR_SHEETS.values()]

every = pytest.mark.parametrize(
    "sheet",
    [*SHEETS[:-1], pytest.param(SHEETS[-1], marks=pytest.mark.slow)],  # whose answer takes longest
    ids=lambda sheet: sheet.name,
)
pairs = pytest.mark.parametrize("name", PAIR_SHEETS)


# --- the answers ----------------------------------------------------------------------------------


@every
def test_the_written_answer_is_the_one_computed_now(sheet):
    assert find_sheet(sheet.name) is ALL_SHEETS[sheet.name] is sheet
    assert list(changes(sheet)) == []
    content = content_of(sheet, answer_to(sheet))
    assert content["slip_rate"].shape == (33, 5)
    assert all(np.isfinite(content[name]).all() for name in sheet.report)


def test_numbers_of_written_answers():
    front, line = (written_document(sheet)["answers"] for sheet in (FRONT, LINE))
    assert front["zones"] == [[0.0, 0.405067274343, -1.0]]
    assert line["zones"] == [[-0.395154376971, 0.395154376971, 1.0]]
    assert line["arrivals"][2:] == [None, None, None]
    assert line["frictional_work"] == pytest.approx(0.5 * line["accumulated_slip"], abs=1e-12)
    for sheet in PAIR_SHEETS.values():
        document = written_document(sheet)
        assert document["sure"] == "nine digits of twelve"
        assert document["scene"]["lower_material"]["shear_modulus"] == 2.5
        assert document["si_scene"]["lower_material"]["density"] == 3000.0


@pytest.mark.thinned(2)
@pairs
def test_nine_digits_are_sure(name):
    content, loose = (
        content_of(PAIR_SHEETS[name], answer)
        for answer in (answer_to(PAIR_SHEETS[name]), solve(name, rtol=1e-9))
    )
    for key, values in content.items():
        known = np.isfinite(values)
        size = np.abs(values[known]).max(initial=0.0)
        np.testing.assert_allclose(loose[key][known], values[known], atol=3e-10 * (size or 1.0))


def test_load_and_intensity_under_a_wave_are_those_of_the_closed_forms():
    """K_I of a step at t = 1, times M_+(0) / M_+(-p), at nu = 1/3, c_l = 2 c_t."""
    p, factors = math.sin(math.radians(-20.0)), rayleigh_factors(1 / 3)
    pressure, shear = (0.3 * turn(math.radians(40.0)) for turn in (math.sin, math.cos))
    load = find("incident-sv").superposition.taken_off
    assert (load.pressure, load.shear) == pytest.approx((pressure, -shear), rel=1e-14)
    moving = factors.m_plus(np.array([-p]), "I")[0]
    expected = 3 * pressure * math.sqrt(2 / 3 / math.pi) * factors.m_plus_at_zero["I"] / moving
    assert written_document(FRONT)["answers"]["K_I"] == pytest.approx(expected, rel=1e-11)


SOLVERS = {FRONT.name: (solve, 1e-7), LINE.name: (solve, 1e-11)}


@every
def test_the_si_problem_is_the_same_times_its_scales(sheet):
    solver, rel = SOLVERS.get(sheet.name, (solve, 1e-7))
    plain, si = answer_to(sheet), solver(sheet.si_problem)
    x, t = np.array(STATIONS), np.array(TIMES)[:, None] if sheet.name in PAIR_SHEETS else 0.9
    for name in QUANTITIES:
        ours, theirs = getattr(plain, name)(x, t), getattr(si, name)(x * SI_SCALES["x"], t)
        least = 1e-7 * np.abs(ours).max() * SI_SCALES[name] if sheet.name in PAIR_SHEETS else 1e-9
        np.testing.assert_allclose(theirs, ours * SI_SCALES[name], rtol=rel, atol=least)


# --- pages and exports ----------------------------------------------------------------------------

WORDS = {
    "incident-sv": (
        "plane SV step wave arrives from below, towards -x",
        "P_0 = -S sin(2 theta)",
        "| angle theta | -20 degrees | the same |",
        "| pressure of the load P_0 | 0.192836 | 1.92836e+06 Pa |",
        "0 to 0.4050672743",
        "none are measured",
    ),
    "whole-line-patch": (
        "touch along all of y = 0, without a slot",
        "| speed w of either end of the patch | 0.3 | 600 m/s |",
        "-0.395154377 to 0.395154377",
        "without classes",
    ),
    **dict.fromkeys(
        PAIR_SHEETS,
        (
            "Two half-planes of different elastic solids",
            "| shear modulus μ_2 of the lower body | 2.5 | 2.5e+10 Pa |",
            "| Poisson ratio ν_2 of the lower body | 0.25 | the same |",
        ),
    ),
}


@every
def test_the_page_states_problem_and_answer(sheet):
    text = as_markdown(list(sheet_blocks(sheet)))
    assert [words for words in WORDS[sheet.name] if words not in text] == []
    assert f"{written_document(sheet)['answers']['zones'][0][1]:.10g}" in text
    assert ("Tolerance classes" in text) == (sheet.name in PAIR_SHEETS)


@pytest.mark.parametrize("name", ["incident-sv", "whole-line-patch", "pair-slip"])
def test_an_export_has_page_answer_and_figure_and_inputs_of_pairs_alone(name, monkeypatch):
    """The figures themselves are those of compare/figures/test_figures.py."""
    monkeypatch.setattr("compare.benchmarks.export.figure_png", lambda figure, dpi: b"drawn")
    contents = exported([ALL_SHEETS[name]])
    assert contents[f"{name}/figure.png"] == b"drawn"
    names = {one.removeprefix(f"{name}/") for one in contents}
    assert {f"{name}.html", "figure.png", "records.csv", "answers.json"} <= names
    inputs = {one for one in names if one.startswith(("uguca/", "sem2dpack/"))}
    if name in PAIR_SHEETS:
        assert inputs >= {"uguca/pair-slip.in", "uguca/uguca_sheet.cc"}
        assert inputs >= {"sem2dpack/Par.inp", "sem2dpack/two.mesh2d"}
    else:
        assert inputs == set()


@pairs
def test_no_wave_of_the_far_edge_of_a_period_reaches_a_station(name):
    lines = [line.split() for line in uguca_parameters(PAIR_SHEETS[name]).splitlines()[1:]]
    given = {line[1]: line[-1] for line in lines}
    assert (given["lower_shear_modulus"], given["lower_density"]) == ("2.5", "1.2")
    slot = float(given["slot_nodes"]) / float(given["cells"])
    fastest = find(name).lower.longitudinal_speed
    assert float(given["length"]) - slot - max(STATIONS) > fastest
    assert slot + min(STATIONS) > fastest


# --- scores ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("factor", "error"), [(1.02, 0.02), (0.9, 0.1)])
def test_a_run_without_a_slot_is_scored_by_its_errors(tmp_path, factor, error):
    answer, times = answer_to(LINE), np.linspace(0.001, 1.0, 700)
    lines = ["# benchmark: whole-line-patch", "# code: mine", "# cells: 100"]
    lines.append("t,x,slip_rate,slip,shear_traction")
    for x in STATIONS:
        rate, slip, shear = (getattr(answer, one)(x, times) for one in LINE.report[:3])
        rows = np.transpose([times, np.full(700, x), factor * rate, factor * slip, shear])
        lines += [",".join(f"{value:.10g}" for value in row) for row in rows]
    path = tmp_path / "mine.csv"
    path.write_text("\n".join(lines) + "\n")
    found = {one.quantity: one for one in score(read_run(path))}
    assert found["slip"].error == pytest.approx(error, rel=1e-6)
    assert found["slip_rate"].error == pytest.approx(error, rel=1e-6)
    assert found["shear_traction"].error < 1e-9
    assert found["arrival"].error < 2e-3


@pytest.mark.parametrize(("code", "most"), [("march", 0.02), ("fem", 0.06)])
def test_our_own_codes_take_a_wave(code, most):
    found = {one.quantity: one.error for one in score(enter(code, FRONT, 50))}
    assert max(found[name] for name in ("slip", "shear_traction", "pressure")) < most


@pytest.mark.parametrize(
    ("code", "sheet", "message"),
    [
        ("fem", "whole-line-patch", "takes scenes with a slot"),
        ("march", "whole-line-patch", "takes scenes with a slot"),
        ("march", "pair-opening", "march knows identical bodies only"),
        ("march", "tpv101", "march takes scenes, and tpv101 is an interface; give run."),
        ("run", "preloaded", "run takes interfaces, and preloaded is none; give march."),
    ],
)
def test_our_own_codes_refuse_what_they_do_not_take(code, sheet, message):
    with pytest.raises(SceneError, match=message):
        enter(code, find_sheet(sheet), 50)


def test_finite_elements_take_pairs():
    found = {one.quantity: one for one in score(enter("fem", PAIR_SHEETS["pair-slip"], 50))}
    assert found["slip"].error < 0.002
    assert {one.tolerance for one in found.values()} == {"C"}


def test_the_answer_itself_has_no_class():
    sheet = PAIR_SHEETS["pair-slip"]
    run = enter("fem", sheet, 20)
    answer = answer_to(sheet)
    for station in run.records.stations:
        for key in station.values:
            station.values[key][:] = getattr(answer, key)(station.x, station.t)
    scores = score(run)
    assert all(one.error < EXACTLY for one in scores if one.quantity != "arrival")
    assert {one.tolerance for one in scores} == {"?"}
