"""Thresholds, widths and answers of the self-similar solver that the prose of the docs quotes."""

import math
from functools import cache

import numpy as np
import pytest
from docs_pages import assert_page_says, quoted_numbers

from docs.studies.article.published import REVERSE_LIMIT
from semianalytic import Material, solve
from semianalytic.reference.closed_forms import (
    edge_speed_under_shear_step,
    slip_rate_under_shear_step,
)
from semianalytic.regimes import reverse_slip
from semianalytic.regimes.thresholds import (
    crossing_poisson_ratio,
    edge_threshold,
    edge_threshold_alone,
    gap_threshold,
    nucleation,
    scene_of,
)
from semianalytic.scene.given.named import NAMED_SCENES

REGIMES, THEORY = "docs/regimes.md", "docs/theory.md"
THIRD = 1 / 3
reverse_threshold = cache(reverse_slip.reverse_threshold)


def test_front_breaks_before_the_edge_and_starts_a_second_zone():
    assert_page_says(REGIMES, "Below ν = {} the shear front breaks", crossing_poisson_ratio())
    shifts = [edge_threshold(nu) - edge_threshold_alone(nu) for nu in (-0.9, -0.5)]
    assert_page_says(
        REGIMES, "slips below √(b/a) + {} at ν = −0.9 and √(b/a) + {} at ν = −0.5", *shifts
    )
    assert_page_says(THEORY, "{} at ν = 1/3, unless the shear front", edge_threshold(THIRD))
    assert_page_says("docs/scenes.md", "above √(b/a) = {}: the whole", edge_threshold(THIRD))
    assert_page_says(THEORY, "(below {} at ν = 1/3)", nucleation("preload", THIRD))


def test_gap_of_a_preload():
    [(ratio, unit)] = quoted_numbers(REGIMES, "below 10⁻¹⁴ only for ν > {}")
    assert gap_threshold("preload", ratio - 2 * unit) is None
    assert gap_threshold("preload", ratio + 2 * unit) is not None


@pytest.mark.parametrize(
    ("page", "sentence"),
    [
        (REGIMES, "at ν = 1/3 is **{}**"),
        (THEORY, "At ν = 1/3 that is {}."),
    ],
)
def test_reverse_threshold(page, sentence):
    assert_page_says(page, sentence, reverse_threshold(THIRD))


@pytest.mark.parametrize(
    ("page", "sentence"),
    [
        (REGIMES, "the article has {}, 3.6 million"),
        ("docs/article.md", "**No interpretation reproduces the threshold {}**"),
    ],
)
def test_published_threshold(page, sentence):
    assert_page_says(page, sentence, REVERSE_LIMIT, units=1e-9)


def test_widths_of_reversed_strips():
    third, half, fifth = (
        math.exp(reverse_slip.log_frictionless_half_width(nu)) for nu in (THIRD, -0.5, 0.2)
    )
    assert_page_says(REGIMES, "the latter is {} at", third)
    assert_page_says(REGIMES, "strip that then reverses is {} c_R", third)
    assert_page_says(
        THEORY, "half-width is {} $c_R$ at ν = −0.5, {} at 0.2 and {} at 1/3", half, fifth, third
    )
    solution = solve(scene_of("preload", -0.5, 0.007))
    strip = next(zone for zone in solution.zones if zone.sense < 0)
    widest = (strip.outer - strip.inner) / 2 / solution.scene.material.rayleigh_speed
    assert_page_says(REGIMES, "rises from {} at f → 0 to {} near χ_b = 0.007", half, widest)


def test_closed_form_of_narrow_strips_and_the_published_threshold_are_off_by_what_is_said():
    errors = [
        abs(math.exp(reverse_slip.log_narrow_reverse_threshold(nu)) / reverse_threshold(nu) - 1)
        for nu in (0.2, 0.3)
    ]
    off = REVERSE_LIMIT / reverse_threshold(THIRD) / 1e6
    assert_page_says(REGIMES, "{} million times as much", off)
    assert_page_says(
        REGIMES, "agrees with the traced threshold to {} at ν = 0.2 and {} at ν = 0.3", *errors
    )


def test_reversal_before_the_second_zone():
    [(ratio, unit)] = quoted_numbers(REGIMES, "Below ν = {} reversal comes before")
    lead = [
        reverse_threshold(nu) - nucleation("preload", nu) for nu in (ratio - unit, ratio + unit)
    ]
    assert lead[0] > 0 > lead[1]


# --- what the prose of the docs quotes of the solver ----------------------------------------------


SCENES, SOLVER, STABILITY = "docs/scenes.md", "docs/solver.md", "docs/stability.md"


def test_named_scenes():
    preloaded, stuck = (
        solve(NAMED_SCENES[name].scene, rtol=1e-8) for name in ("preloaded", "stuck")
    )
    assert_page_says(SCENES, "V at the edge itself is {}.", preloaded.edge_slip_rate)
    assert_page_says(SCENES, "K_I = {} and K_II = {} at t = 1", *stuck.stress_intensity(1.0))


@pytest.mark.thinned(2)
@pytest.mark.parametrize("nu", [0.0, 0.1])
def test_reversed_strip_is_seen_near_its_threshold(nu):
    sentence = "a reversed strip is found at {} of its threshold for `rtol` = 10⁻⁶ and 10⁻⁴."
    [(share, _)] = quoted_numbers(SOLVER, sentence)
    for rtol in (1e-6, 1e-4):
        solution = solve(scene_of("preload", nu, share * reverse_threshold(nu)), rtol=rtol)
        assert any(zone.sense < 0 for zone in solution.zones)


@pytest.mark.parametrize(
    ("limit", "sign", "sentence"),
    [
        (
            -1.0,
            1,
            "* **ν → −1**: accuracy is kept. The edge is exact to {} and the slip rate to {}.",
        ),
        (0.0, 1, "kept on either side. The edge is exact to {} and the slip rate to {}."),
        (0.0, -1, "kept on either side. The edge is exact to {} and the slip rate to {}."),
        (0.5, -1, "edge of a preloaded zone is exact to {} and the slip rate to {}. Under"),
    ],
)
def test_limits_of_the_poisson_ratio(limit, sign, sentence):
    errors = []
    for distance in (1e-2, 1e-5, 1e-9):
        material = Material(1.0, 1.0, limit + sign * distance)
        solution = solve(scene_of("preload", material.poisson_ratio, 1.0), rtol=1e-10)
        edge = edge_speed_under_shear_step(material, 1.0)
        rate = slip_rate_under_shear_step(material, 1.0, 1.0, np.array([0.0]))[0]
        errors.append(
            [abs(solution.zones[0].outer - edge), abs(solution.edge_slip_rate / rate - 1)]
        )
    bounds = [most for most, _ in quoted_numbers(STABILITY, sentence)]
    assert (np.max(errors, axis=0) <= bounds).all(), errors
