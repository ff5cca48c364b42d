"""Thresholds and widths that the prose of the docs quotes."""

import math

import pytest
from docs_pages import assert_page_says, quoted_numbers

from semianalytic import solve
from semianalytic.reference.published import REVERSE_LIMIT
from semianalytic.regimes.reverse_slip import (
    log_frictionless_half_width,
    log_narrow_reverse_threshold,
    reverse_threshold,
)
from semianalytic.regimes.thresholds import (
    crossing_poisson_ratio,
    edge_threshold,
    edge_threshold_alone,
    gap_threshold,
    nucleation,
    scene_of,
)

REGIMES, THEORY, README = "docs/regimes.md", "docs/theory.md", "README.md"
THIRD = 1 / 3


def test_front_breaks_before_the_edge():
    assert_page_says(REGIMES, "Below ν = {} the shear front breaks", crossing_poisson_ratio())
    shifts = [edge_threshold(nu) - edge_threshold_alone(nu) for nu in (-0.9, -0.5)]
    assert_page_says(
        REGIMES, "slips below √(b/a) + {} at ν = −0.9 and √(b/a) + {} at ν = −0.5", *shifts
    )
    assert_page_says(THEORY, "{} at ν = 1/3, unless the shear front", edge_threshold(THIRD))
    assert_page_says("docs/scenes.md", "above √(b/a) = {}: the whole", edge_threshold(THIRD))


def test_second_zone():
    assert_page_says(THEORY, "(below {} at ν = 1/3)", nucleation("preload", THIRD))


def test_gap_of_a_preload():
    [(ratio, unit)] = quoted_numbers(REGIMES, "it passes 10⁻¹⁴ only for ν > {}")
    assert gap_threshold("preload", ratio - 2 * unit) is None
    assert gap_threshold("preload", ratio + 2 * unit) is not None


@pytest.mark.parametrize(
    ("page", "sentence"),
    [
        (REGIMES, "at ν = 1/3 becomes **{}**"),
        (THEORY, "At ν = 1/3 that is {}."),
        (THEORY, r"for $\chi_b$ < {}, preloaded"),
        (README, "reverse slip requires friction × base pressure below {} of the shear load, not"),
    ],
)
def test_reverse_threshold(page, sentence):
    assert_page_says(page, sentence, reverse_threshold(THIRD))


@pytest.mark.parametrize(
    ("page", "sentence"),
    [
        (REGIMES, "The published threshold {} at ν = 1/3"),
        (THEORY, "reverse slip for χ < {} at ν = 1/3"),
        ("docs/article.md", "**No reading reproduces {}**"),
        (README, "below 1.6e-8 of the shear load, not {} as published."),
    ],
)
def test_published_threshold(page, sentence):
    assert_page_says(page, sentence, REVERSE_LIMIT, units=1e-9)


def test_how_far_the_published_threshold_is_off():
    assert_page_says(
        REGIMES, "{} million times lower", REVERSE_LIMIT / reverse_threshold(THIRD) / 1e6
    )


def test_widths_of_reversed_strips():
    third, half, fifth = (math.exp(log_frictionless_half_width(nu)) for nu in (THIRD, -0.5, 0.2))
    assert_page_says(REGIMES, "down to half-widths of {} at", third)
    assert_page_says(REGIMES, "strip that then reverses is {} c_R", third)
    assert_page_says(
        THEORY, "half-width is {} $c_R$ at ν = −0.5, {} at 0.2 and {} at 1/3", half, fifth, third
    )
    solution = solve(scene_of("preload", -0.5, 0.007))
    strip = next(zone for zone in solution.zones if zone.sense < 0)
    widest = (strip.outer - strip.inner) / 2 / solution.scene.material.rayleigh_speed
    assert_page_says(REGIMES, "rises from {} at f → 0 to {} near χ_b = 0.007", half, widest)


def test_closed_form_of_narrow_strips():
    errors = [
        abs(math.exp(log_narrow_reverse_threshold(nu)) / reverse_threshold(nu) - 1)
        for nu in (0.2, 0.3)
    ]
    assert_page_says(
        REGIMES, "agrees with the traced threshold to {} at ν = 0.2 and {} at ν = 0.3", *errors
    )


def test_reversal_before_the_second_zone():
    [(ratio, unit)] = quoted_numbers(REGIMES, "Below ν = {} reversal comes before")
    lead = [
        reverse_threshold(nu) - nucleation("preload", nu) for nu in (ratio - unit, ratio + unit)
    ]
    assert lead[0] > 0 > lead[1]
