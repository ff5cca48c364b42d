"""What the prose of the docs quotes of the self-similar solver."""

import numpy as np
import pytest
from docs_pages import assert_page_says, quoted_numbers

from semianalytic import Material, solve
from semianalytic.reference.closed_forms import (
    edge_speed_under_shear_step,
    slip_rate_under_shear_step,
)
from semianalytic.regimes.reverse_slip import reverse_threshold
from semianalytic.regimes.thresholds import scene_of
from semianalytic.scene.given.named import NAMED_SCENES

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
    sentence = (
        "a reversed strip is seen at {} of its threshold for `rtol` = 10⁻⁶, and at {} for 10⁻⁴."
    )
    threshold = reverse_threshold(nu)
    for (share, _), rtol in zip(quoted_numbers(SOLVER, sentence), (1e-6, 1e-4), strict=True):
        solution = solve(scene_of("preload", nu, share * threshold), rtol=rtol)
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
