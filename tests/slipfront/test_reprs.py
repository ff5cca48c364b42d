"""What a notebook shows of an answer is one line that says what it is."""

import re

import numpy as np
import pytest
from catalogue import PRELOADED

import slipfront as sf

X, T = np.array([0.1, 0.2]), np.linspace(0.1, 1.0, 20)


def validated():
    slip = sf.solve(PRELOADED).history(X, T).slip
    return sf.validate({"t": T, "x": X, "slip": slip}, PRELOADED, spacing=0.01)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sf.solve(PRELOADED), "converged, error estimate"),
        (
            lambda: sf.solve(PRELOADED).history(X, T),
            "<InterfaceHistory: 20 times from 0.1 to 1, 2 positions from 0.1 to 0.2>",
        ),
        (lambda: sf.march(PRELOADED, nodes=32), "<Marched: to t = 1 in "),
        (
            lambda: sf.run(sf.find_interface("punch").interface, 0.5, nodes=64),
            r"64 nodes, .* frames; done, error of slip",
        ),
        (
            lambda: sf.run(sf.find_interface("punch").interface, 0.5, nodes=64, estimate=False),
            "done, no error estimate>",
        ),
        (lambda: sf.prepare(PRELOADED, resolution=8), "<Model: antisymmetric half, 1,380 unknowns"),
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
