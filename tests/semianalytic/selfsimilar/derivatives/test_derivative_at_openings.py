"""Derivatives where the contact opens: differences of solutions and a closed form."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import unit_scene

from semianalytic import (
    solve,
)
from tests.semianalytic.selfsimilar.derivatives.test_derivative import (
    CLEAR,
    EIGHTH_ORDER,
    FIELDS,
    NAMES,
    changed,
    clear_positions,
    edges_of,
    value,
)

OPENED = (*FIELDS, "gap", "gap_rate")


def opened_errors(solution, name):
    """Derivatives of gap and openings are those of differences as well."""
    scene, x = solution.scene, clear_positions(solution)
    ends = edges_of_openings(solution.openings)
    x = x[np.abs(x[:, None] - ends).min(axis=1) > CLEAR]
    derivative = solution.derivative(name)
    assert derivative.status == "converged"
    step = 1e-3 * abs(value(scene, name))
    fields = OPENED if scene.mode == "in-plane" else FIELDS
    expected = dict.fromkeys((*fields, "edges", "openings"), 0.0)
    for steps, weight in EIGHTH_ORDER:
        for sign in (1, -1):
            beside = changed(scene, name, value(scene, name) + sign * steps * step)
            one, share = solve(beside, rtol=1e-12), sign * weight / step
            for field in fields:
                expected[field] = expected[field] + share * getattr(one, field)(x, 1.0)
            expected["edges"] = expected["edges"] + share * edges_of(one)
            expected["openings"] = expected["openings"] + share * edges_of_openings(one.openings)
    found = {field: getattr(derivative, field)(x, 1.0) for field in fields}
    found["edges"] = edges_of(derivative)
    found["openings"] = edges_of_openings(derivative.openings)
    return {
        field: np.abs(found[field] - expected[field]).max(initial=0.0)
        / max(np.abs(expected[field]).max(initial=0.0), 1e-2)
        for field in found
    }


def edges_of_openings(openings):
    return np.array([end for one in openings for end in (one.inner, one.outer)])


EDGE_OPENS = unit_scene(0.5, (1.0, 0.1), (-1.0, 1.0))


TAPPED = unit_scene(0.3, (0.02, 0.002), (1.0, 0.5))


@pytest.mark.thinned(15)
@pytest.mark.parametrize(
    ("scene", "name"),
    [
        *((EDGE_OPENS, name) for name in NAMES),
        (TAPPED, "friction"),
        (TAPPED, "base_pressure"),
        (TAPPED, "poisson_ratio"),
        (unit_scene(0.3, (0.02, 0.004), (1.0, 0.5), mode="antiplane"), "base_pressure"),
        (replace(TAPPED, mode="antiplane"), "friction"),  # an edge 1.5e-6 behind an end of a panel
        (replace(TAPPED, friction=3.0), "load_pressure"),  # sticks behind the closing edge
    ],
)
def test_differences_of_solutions_agree_where_the_contact_opens(scene, name):
    found = opened_errors(solve(scene, rtol=1e-11), name)
    assert max(found.values()) < 1e-8, found


def test_an_opening_from_the_edge_moves_as_its_closed_form():
    """c_t sqrt((1 - 2 nu) / (2 (1 - nu))) / ((1 - nu) (1 + P_b / |P_0|)^2)."""
    solution = solve(unit_scene(0.5, (1.0, 0.0), (-1.0, 0.0)))
    for name, expected in (("base_pressure", -0.1875), ("load_pressure", -0.1875), ("friction", 0)):
        (moved,) = solution.derivative(name).openings
        assert moved.inner == 0
        assert moved.outer == pytest.approx(expected, rel=1e-9)
    by_ratio = solution.derivative("poisson_ratio").openings[0].outer
    assert by_ratio == pytest.approx(0.1875 * (1.5 - 3 + 0.75), rel=1e-8)
    assert "one-sided: with any shear" in solution.derivative("load_shear").status
