"""The normal problem alone: edges, gap and pressure against closed forms and other quadratures."""

import numpy as np
import pytest

from semianalytic import Material, Scene, Tractions, solve
from semianalytic.reference import detached_opening, edge_speed_of_opening, gap_rate_of_opening
from semianalytic.regimes import opening_threshold
from semianalytic.separation.opening import opening_of
from tests.semianalytic.selfsimilar.test_solution import integral

SPEEDS = np.linspace(0.02, 0.98, 7)


def pressed(poisson_ratio, base, step=1.0, rtol=1e-11, **material):
    """A scene without shear, solved."""
    solid = Material(
        poisson_ratio=poisson_ratio, **{"shear_modulus": 1.0, "density": 1.0} | material
    )
    return solve(Scene(solid, 0.3, Tractions(base, 0.0), Tractions(step, 0.0)), rtol=rtol)


@pytest.mark.thinned(4)
@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.3, 0.0, 1 / 3, 0.49])
@pytest.mark.parametrize("ratio", [0.05, 1.0, 20.0])
def test_opening_from_the_edge(poisson_ratio, ratio):
    solution = pressed(poisson_ratio, ratio, -1.0)
    edge = edge_speed_of_opening(solution.scene.material, ratio)
    (opening,) = solution.openings
    assert opening.inner == 0
    assert opening.outer == pytest.approx(edge, rel=1e-11)
    x = SPEEDS * edge
    expected = gap_rate_of_opening(solution.scene.material, -1.0, ratio, x)
    np.testing.assert_allclose(solution.gap_rate(x, 1.0), expected, rtol=0, atol=1e-11)
    assert solution.status == "converged"
    assert solution.stress_intensity(1.0)[0] == 0


@pytest.mark.thinned(4)
@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.3, 0.0, 1 / 3, 0.49])
@pytest.mark.parametrize("share", [0.02, 0.5, 1.0])
def test_detached_opening_slower_than_the_shear_front(poisson_ratio, share):
    material = Material(1.0, 1.0, poisson_ratio)
    outer = material.rayleigh_speed + share * (1 - material.rayleigh_speed)
    expected = detached_opening(material, outer)
    solution = pressed(poisson_ratio, expected.pressure_ratio)
    (opening,) = solution.openings
    assert opening.outer == pytest.approx(outer, rel=1e-11)
    assert opening.inner == pytest.approx(expected.inner, rel=1e-11)
    # of the gap too, which of a narrow opening is known less well than its edges
    assert solution.error_estimate < 1e-9


# Of a prototype with quadratures of its own: the opening edge over c_t, where it closes, P_b / P_0.
@pytest.mark.parametrize(
    ("poisson_ratio", "outer", "inner", "ratio"),
    [
        (1 / 3, 1.845, 0.5424254357253909, 0.02033322725628656),
        (1 / 3, 1.5, 0.6271198650321924, 0.031819359041848655),
        (1 / 3, 1.1, 0.6691473012794739, 0.036752692203291026),
    ],
)
def test_detached_opening_ahead_of_the_shear_front(poisson_ratio, outer, inner, ratio):
    (opening,) = pressed(poisson_ratio, ratio).openings
    assert opening.outer == pytest.approx(outer, rel=1e-11)
    assert opening.inner == pytest.approx(inner, rel=1e-11)


@pytest.mark.thinned(7)
@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.3, 0.0, 0.3, 0.45])
@pytest.mark.parametrize("share", [1e-6, 0.02, 0.6, 0.999, 1 - 1e-6])
def test_edges_are_smooth_and_the_gap_closes_at_no_rate(poisson_ratio, share):
    """Neither a pull nor an overlap, and no impact: the rate falls to nothing like a root."""
    solution = pressed(poisson_ratio, share * opening_threshold(poisson_ratio), rtol=1e-9)
    assert solution.status == "converged"
    (opening,) = solution.openings
    width, speeds = opening.outer - opening.inner, solution.scene.material
    assert opening.inner < speeds.rayleigh_speed < opening.outer < speeds.longitudinal_speed
    x = opening.inner + width * np.linspace(1e-3, 0.999, 300)
    assert np.all(solution.gap(x, 1.0) > 0)
    beside = opening.inner + width * np.array([1e-5, 4e-5])
    near, far = solution.gap_rate(beside, 1.0)
    assert near < 0
    assert far / near == pytest.approx(2.0, rel=0.02)
    near, far = solution.gap(beside, 1.0)
    assert far / near == pytest.approx(8.0, rel=0.02)
    near, far = solution.pressure(opening.inner * (1 - np.array([1e-5, 4e-5]) * width), 1.0)
    assert near > 0
    assert far / near == pytest.approx(2.0, rel=0.02)
    ahead = opening.outer + np.linspace(1e-3, 1, 50) * (
        1.01 * speeds.longitudinal_speed - opening.outer
    )
    assert np.all(np.diff(solution.pressure(ahead, 1.0)) >= -1e-12)  # monotone up to the base


def test_beside_the_threshold_the_opening_is_three_times_as_wide_behind_the_rayleigh_front():
    for poisson_ratio in (-0.5, 0.2, 0.4):
        speed = Material(1.0, 1.0, poisson_ratio).rayleigh_speed
        base = (1 - 1e-6) * opening_threshold(poisson_ratio)
        (opening,) = pressed(poisson_ratio, base, rtol=1e-9).openings
        assert (speed - opening.inner) / (opening.outer - speed) == pytest.approx(3.0, rel=0.03)
        assert not pressed(poisson_ratio, 1.000001 * opening_threshold(poisson_ratio)).openings


def test_on_ever_smaller_bases_the_contact_opens_ever_closer_to_the_longitudinal_front():
    outer = [pressed(1 / 3, base).openings[0].outer for base in (1e-3, 1e-5, 1e-7)]
    distance = 2.0 - np.array(outer)
    assert np.all(distance > 0)
    np.testing.assert_allclose(distance[1:] / distance[:-1], 1e-2, rtol=0.1)


def test_gap_is_the_integral_of_its_rate():
    solution = pressed(1 / 3, 0.02)
    (opening,) = solution.openings
    speeds = (opening.inner, opening.outer, solution.scene.material.rayleigh_speed, 1.0)
    for x, end in ((1.0, 0.8), (1.0, 1.05)):
        times = [x / speed for speed in speeds]
        total = integral(lambda t, x=x: solution.gap_rate(x, t), 0.0, end, times)
        assert solution.gap(x, end) == pytest.approx(total, rel=1e-9)


def test_pressure_behind_the_opening_goes_with_the_intensity_at_the_contact_edge():
    solution = pressed(1 / 3, 0.02)
    x = np.array([1e-10, 1e-8])
    intensity, _ = solution.stress_intensity(1.0)
    expected = intensity / np.sqrt(2 * np.pi * x)
    np.testing.assert_allclose(solution.pressure(x, 1.0), expected, rtol=1e-3)


def test_fields_scale_with_the_units():
    first, other = pressed(0.3, 0.02), pressed(0.3, 6.0, 300.0, shear_modulus=50.0, density=2.0)
    x = np.array([0.3, 0.7, 1.2, 1.7])
    np.testing.assert_allclose(other.gap(5 * x, 1.0), 30 * first.gap(x, 1.0), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(other.gap_rate(5 * x, 1.0), 30 * first.gap_rate(x, 1.0), rtol=1e-9)
    np.testing.assert_allclose(other.pressure(5 * x, 1.0), 300 * first.pressure(x, 1.0), rtol=1e-9)


def test_what_stays_closed_has_no_opening():
    assert opening_of(1 / 3, 1.0, 1.0, 1e-8) is None
    assert opening_of(1 / 3, 1.0, 0.0, 1e-8) is None
    solution = pressed(1 / 3, 1.0)
    assert solution.openings == ()
    x = np.array([0.1, 1.0, 1.9])
    assert np.all(solution.gap(x, 1.0) == 0)
    assert np.all(solution.gap_rate(x, 1.0) == 0)
