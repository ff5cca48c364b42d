"""Properties of a half-plane and closed forms that the prose of the docs quotes."""

import numpy as np
import pytest
from docs_pages import assert_page_says, quoted_numbers
from scipy.optimize import brentq

from semianalytic import Material
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.reference import closed_forms

THEORY, ARTICLE, SCENES = "docs/theory.md", "docs/article.md", "docs/scenes.md"
THIRD, AUXETIC = Material(1.0, 1.0, 1 / 3), Material(1.0, 1.0, -0.5)


def stuck(mode, slowness):
    return np.atleast_1d(stuck_traction(1 / 3, mode)(slowness))


def place_without_pressure():
    return [1 / brentq(lambda u: float(stuck("I", u)[0]), 1.1, 5.0)]


def slip_everywhere():
    # with f P_0 = Q_0 = 1 only f P_0 Lambda is left of V
    return closed_forms.slip_rate_under_remote_shock(THIRD, 1.0, 1.0, 1.0, np.array([0.5, 1.6])) / 2


def one_zone():
    values = []
    for chi in (1.0, 0.5):
        rate = closed_forms.slip_rate_under_shear_step(THIRD, 1.0, chi, np.array([0.0]))[0]
        values += [closed_forms.edge_speed_under_shear_step(THIRD, chi), rate / 2]
    return values


@pytest.mark.parametrize(
    ("page", "sentence", "values"),
    [
        (THEORY, r"| p\* | {} | {} | {} | {} |", lambda: stuck("I", [0.7, 1.0, 2.0, 10.0])),
        (THEORY, r"| q\* | {} | {} | {} | {} |", lambda: stuck("II", [0.7, 1.0, 2.0, 10.0])),
        # shear traction ahead of the shear wave
        (ARTICLE, r"q\* reaches {} at c_t t", lambda: stuck("II", 1.0)),
        # where the bound of friction is negative without a base
        (ARTICLE, "negative on {} c_t t", place_without_pressure),
        (SCENES, "ν = 1/3 (c_R = {}, c_l", lambda: [THIRD.rayleigh_speed]),
        (
            SCENES,
            "ν = −0.5 (c_R = {}, c_l = {})",
            lambda: [AUXETIC.rayleigh_speed, AUXETIC.longitudinal_speed],
        ),
        (
            THEORY,
            r"$\chi_b = 1$: $\xi_s$ = {} and V(0+) = {}; $\chi_b = 0.5$: {} and {}.",
            one_zone,
        ),
        (THEORY, "Λ = {} there at ν = 1/3, and {} at 1.6 $c_t$", slip_everywhere),
        (THEORY, "distance $\\Delta x$ and δ = {}, where", lambda: edge_offset_and_factors()[:1]),
        (
            "docs/spacetime.md",
            "as if the first node were {} spacings",
            lambda: edge_offset_and_factors()[:1],
        ),
    ],
)
def test_pages_say_what_is_computed(page, sentence, values):
    assert_page_says(page, sentence, *values())


@pytest.mark.parametrize(
    ("page", "sentence"),
    [
        (THEORY, "complex for ν > {} ("),
        ("docs/solver.md", "which exists for ν > {}."),
        (
            "docs/stability.md",
            "For ν > {} the root of the Rayleigh function on its other sheet is complex",
        ),
    ],
)
def test_hidden_root(page, sentence):
    [(ratio, unit)] = quoted_numbers(page, sentence)
    assert rayleigh_factors(ratio - unit).hidden_root.imag == 0
    assert rayleigh_factors(ratio + unit).hidden_root.imag != 0
