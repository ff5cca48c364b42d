"""Properties of a half-plane and closed forms that the prose of the docs quotes."""

import numpy as np
import pytest
from docs_pages import assert_page_says, quoted_numbers
from scipy.optimize import brentq

from semianalytic import Material
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.reference.closed_forms import (
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
)

THEORY, ARTICLE = "docs/theory.md", "docs/article.md"
THIRD = Material(1.0, 1.0, 1 / 3)


def test_stuck_tractions():
    slowness = np.array([0.7, 1.0, 2.0, 10.0])
    for name, mode in (("p", "I"), ("q", "II")):
        values = stuck_traction(1 / 3, mode)(slowness)
        assert_page_says(THEORY, rf"| {name}\* | {{}} | {{}} | {{}} | {{}} |", *values)


def test_shear_traction_ahead_of_the_shear_wave():
    front = float(stuck_traction(1 / 3, "II")(1.0))
    assert_page_says(THEORY, "rises to {} $Q_0$ at $c_t t$", front)
    assert_page_says(ARTICLE, r"q\* reaches {} Q_0 at c_t t", front)


def test_where_the_friction_bound_is_negative_without_a_base():
    pressure = stuck_traction(1 / 3, "I")
    place = 1 / brentq(lambda u: float(pressure(u)), 1.1, 5.0)
    assert_page_says(THEORY, "negative on {} $c_t t$", place)
    assert_page_says(ARTICLE, "negative on {} c_t t", place)


@pytest.mark.parametrize(
    ("page", "sentence"),
    [
        (THEORY, "complex for ν > {} ("),
        ("docs/solver.md", "which exists for ν > {}."),
        ("docs/stability.md", "one panel more for ν > {}, nothing"),
    ],
)
def test_hidden_root(page, sentence):
    [(ratio, unit)] = quoted_numbers(page, sentence)
    assert rayleigh_factors(ratio - unit).hidden_root.imag == 0
    assert rayleigh_factors(ratio + unit).hidden_root.imag != 0


def test_rayleigh_speeds():
    auxetic = Material(1.0, 1.0, -0.5)
    assert_page_says("docs/scenes.md", "ν = 1/3 (c_R = {}, c_l", THIRD.rayleigh_speed)
    assert_page_says(
        "docs/scenes.md",
        "ν = −0.5 (c_R = {}, c_l = {})",
        auxetic.rayleigh_speed,
        auxetic.longitudinal_speed,
    )


def test_one_zone_under_a_shear_step():
    values = []
    for chi in (1.0, 0.5):
        rate = slip_rate_under_shear_step(THIRD, 1.0, chi, np.array([0.0]))[0]
        values += [edge_speed_under_shear_step(THIRD, chi), rate / 2]
    assert_page_says(
        THEORY,
        r"$\chi_b = 1$: $\xi_s$ = {} and V(0+) = {}; $\chi_b = 0.5$: {} and {}.",
        *values,
    )


def test_slip_everywhere():
    velocity = np.array([0.5, 1.6])
    # with f P_0 = Q_0 = 1 only f P_0 Lambda is left of V
    share = slip_rate_under_remote_shock(THIRD, 1.0, 1.0, 1.0, velocity) / 2
    assert_page_says(THEORY, "Λ = {} there at ν = 1/3, and {} at 1.6 $c_t$", *share)


def test_edge_of_the_grid():
    offset = edge_offset_and_factors()[0]
    assert_page_says(THEORY, "with δ = {}, where", offset)
    assert_page_says("docs/spacetime.md", "as if the first node were {} spacings", offset)
