"""The sheets of two different bodies: answers, pages, figures, inputs and runs on them."""

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to, changes, content_of, written_document
from compare.benchmarks.entries import enter
from compare.benchmarks.export import exported
from compare.benchmarks.pages import as_markdown, sheet_blocks
from compare.benchmarks.scores import EXACTLY, score
from compare.benchmarks.sheet import SI_SCALES, STATIONS, TIMES
from compare.benchmarks.sheets import PAIR_SHEETS, find_sheet
from compare.benchmarks.starters import uguca_parameters
from semianalytic import SceneError, find_pair, solve_pair

every = pytest.mark.parametrize("name", PAIR_SHEETS)


@every
def test_the_written_answer_is_the_one_computed_now(name):
    sheet = PAIR_SHEETS[name]
    assert find_sheet(name) is sheet
    assert list(changes(sheet)) == []
    document = written_document(sheet)
    assert document["sure"] == "nine digits of twelve"
    assert document["scene"]["lower_material"]["shear_modulus"] == 2.5
    assert document["si_scene"]["lower_material"]["density"] == 3000.0


@pytest.mark.thinned(2)
@every
def test_nine_digits_are_sure(name):
    content, loose = (
        content_of(PAIR_SHEETS[name], answer)
        for answer in (answer_to(PAIR_SHEETS[name]), solve_pair(name, rtol=1e-9))
    )
    for key, values in content.items():
        known = np.isfinite(values)
        size = np.abs(values[known]).max(initial=0.0)
        np.testing.assert_allclose(loose[key][known], values[known], atol=3e-10 * (size or 1.0))


@pytest.mark.thinned(2)
@every
def test_the_si_problem_is_the_same_times_its_scales(name):
    plain, si = answer_to(PAIR_SHEETS[name]), solve_pair(PAIR_SHEETS[name].si_problem)
    x, t = np.array(STATIONS), np.array(TIMES)[:, None]
    for key in PAIR_SHEETS[name].report:
        ours, theirs = getattr(plain, key)(x, t), getattr(si, key)(x * SI_SCALES["x"], t)
        size = np.abs(ours).max() * SI_SCALES[key]
        np.testing.assert_allclose(theirs, ours * SI_SCALES[key], atol=1e-7 * size)


@every
def test_the_page_states_both_bodies_and_the_answer(name):
    text = as_markdown(list(sheet_blocks(PAIR_SHEETS[name])))
    assert "Two half-planes of different elastic solids" in text
    assert "| shear modulus μ_2 of the lower body | 2.5 | 2.5e+10 Pa |" in text
    assert "| Poisson ratio ν_2 of the lower body | 0.25 | the same |" in text
    assert "Tolerance classes" in text
    edge = written_document(PAIR_SHEETS[name])["answers"]["zones"][0][1]
    assert f"{edge:.10g}" in text


def test_an_export_has_page_answer_figure_and_inputs_for_both_codes():
    names = {one.removeprefix("pair-slip/") for one in exported([PAIR_SHEETS["pair-slip"]])}
    assert {"pair-slip.html", "figure.png", "records.csv", "answers.json"} <= names
    assert {"uguca/pair-slip.in", "uguca/uguca_sheet.cc"} <= names
    assert {"sem2dpack/Par.inp", "sem2dpack/two.mesh2d"} <= names


@every
def test_no_wave_of_the_far_edge_of_a_period_reaches_a_station(name):
    lines = [line.split() for line in uguca_parameters(PAIR_SHEETS[name]).splitlines()[1:]]
    given = {line[1]: line[-1] for line in lines}
    assert (given["lower_shear_modulus"], given["lower_density"]) == ("2.5", "1.2")
    slot = float(given["slot_nodes"]) / float(given["cells"])
    fastest = find_pair(name).lower.longitudinal_speed
    assert float(given["length"]) - slot - max(STATIONS) > fastest
    assert slot + min(STATIONS) > fastest


def test_finite_elements_take_them_and_our_marcher_of_identical_bodies_refuses():
    sheet = PAIR_SHEETS["pair-opening"]
    found = {one.quantity: one for one in score(enter("fem", sheet, 50))}
    assert found["slip"].error < 0.002
    assert {one.tolerance for one in found.values()} == {"C"}
    with pytest.raises(SceneError, match="march knows identical bodies only"):
        enter("march", sheet, 50)


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
