"""Answers are shown on one line in a terminal, and as tables in a notebook."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from catalogue import PRELOADED, solved

import slipfront as sf
from compare.comparison.judgement import judge
from semianalytic.results.in_words import html_table
from tests.fem.runs import prepare

X, T = np.array([0.1, 0.2]), np.linspace(0.1, 1.0, 20)


def punched(**options):
    return sf.solve(sf.find("punch"), end_time=0.5, nodes=64, **options)


def validated():
    slip = solved(PRELOADED).history(X, T).slip
    return sf.validate({"t": T, "x": X, "slip": slip}, PRELOADED, spacing=0.01)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: solved(PRELOADED), "converged, error estimate"),
        (
            lambda: solved(PRELOADED).history(X, T),
            "<InterfaceHistory: 20 times from 0.1 to 1, 2 pos",
        ),
        (lambda: sf.solve(PRELOADED, method="space-time", nodes=32), "<Marched: to t = 1 in "),
        (lambda: punched(), r"64 nodes, .* levels; unresolved, error estimate 1"),
        (lambda: punched(estimate=False), "done, no error estimate>"),
        (lambda: prepare(PRELOADED, resolution=8), "<Model: antisymmetric half, 1,380 unknowns"),
        (lambda: sf.simulate(PRELOADED, resolution=8), "Simulation.antisymmetric half, 1,380"),
        (validated, r"<Validation: agrees .rows agrees: \d, differs: 0, unresolved: 0.>"),
        (
            lambda: sf.Gauge(0.2, T, T, 0.1, "exx", 0.01, "V1"),
            "<Gauge: 'V1', exx at x = 0.2, y = 0.01, 20 samples, t = 0.1 ... 1>",
        ),
        (lambda: sf.Gauge(0.2, T, T, 0.1), "<Gauge: slip_rate at x = 0.2, 20 samples"),
    ],
)
def test_an_answer_is_shown_on_one_line(make, said):
    text = repr(make())
    assert re.search(said, text)
    assert "\n" not in text
    assert len(text) < 160


def fitted():
    scene, t = sf.find("antiplane"), T[::5]
    record = sf.Gauge(0.2, t, sf.solve(scene).slip(0.2, t), 1e-3, "slip")
    return sf.fit([record], scene, "friction", priors={"friction": sf.Normal(0.5, 0.01)})


def judged():
    simulation = sf.with_companions(sf.simulate(PRELOADED, resolution=32))
    return judge(solved(PRELOADED), simulation)


SHOWN = {
    "preloaded": (lambda: solved(PRELOADED), 2, ["slip +1", "0.884266", "from [length/time]"]),
    "steel": (
        lambda: sf.solve(replace(sf.find("stuck"), units="SI")),
        0,
        ["no slip; converged", "from [m/s]"],
    ),
    "opening": (lambda: sf.solve("lift-off-shear"), 2, ["<td>open</td>", "slip +1"]),
    "march": (
        lambda: sf.solve("ramp", method="space-time", end_time=1.0, nodes=64),
        3,
        ["largest slip", "; resolved, ", "length^2"],
    ),
    "fit": (fitted, 1, ["<td>friction</td><td>0.5</td>", "chi2"]),
    "judgement": (judged, 15, ["Judgement: ", "<td>agrees</td>", "differs: 0"]),
}


@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_shows_an_answer_as_a_table(name):
    make, least, said = SHOWN[name]
    text = make()._repr_html_()
    assert [words for words in said if words not in text] == []
    table = ElementTree.fromstring(text)  # which fails unless all tags are closed
    head = table.findall("thead/tr/th")
    rows = table.findall("tbody/tr")
    assert len(rows) >= least
    assert {len(row) for row in rows} <= {len(head)}


def test_words_of_a_table_are_no_tags():
    assert "<b>" not in html_table("<b>", ("<b>",), [("<b>",)])
