"""Error bars from mesh differences whose size and order are known."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from compare.comparison.bars import ONE_CHANGE, SAFETY, error_bar, observed_order

KINDS = sorted(SAFETY)
sizes = st.floats(1e-9, 1e9)


def readings(truth, error, order, ratio=2.0, meshes=3):
    """What meshes h, ratio h, ... read of a value with an error of that size on the finest."""
    return [truth + error * ratio ** (order * mesh) for mesh in range(meshes)]


def changes(values):
    return [fine - coarse for fine, coarse in pairwise(values)]


@given(st.floats(-5, 5), st.floats(0.001, 1), st.floats(0.3, 3), st.sampled_from([1.5, 2.0, 3.0]))
def test_order_of_a_sequence_is_that_it_was_made_with(truth, error, order, ratio):
    assert observed_order(changes(readings(truth, error, order, ratio)), ratio) == pytest.approx(
        order, rel=1e-6
    )


@pytest.mark.thinned(3)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("order", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_errors_of_first_order_or_better_are_within_their_bar(kind, order, sign):
    bar = error_bar(kind, changes(readings(3.0, sign * 0.01, order)))
    assert bar >= SAFETY[kind] * 0.01 * (1 - 1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_the_bar_of_an_error_of_first_order_is_the_error_times_its_safety(kind):
    assert error_bar(kind, changes(readings(3.0, 0.01, 1.0))) == pytest.approx(SAFETY[kind] * 0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_a_difference_that_is_small_by_chance_is_not_believed(kind):
    """0 from 2h to h and 0.4 from 4h to 2h: what changed before, halved, stands in."""
    assert error_bar(kind, [0.0, 0.4]) == pytest.approx(SAFETY[kind] * 0.2)
    assert error_bar(kind, [0.3, 0.4]) == pytest.approx(SAFETY[kind] * 0.3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_bar_of_two_meshes_alone_is_wider(kind):
    assert error_bar(kind, [0.2]) == pytest.approx(ONE_CHANGE * SAFETY[kind] * 0.2)
    assert error_bar(kind, [0.2]) > error_bar(kind, [0.2, 0.4])


@given(st.sampled_from(KINDS), st.lists(sizes, min_size=1, max_size=3), sizes)
def test_bars_scale_with_the_differences_and_do_not_know_their_sign(kind, differences, unit):
    bar = error_bar(kind, differences)
    scaled = error_bar(kind, [-unit * difference for difference in differences])
    assert scaled == pytest.approx(unit * bar)


@given(st.sampled_from(KINDS), sizes, sizes, sizes)
def test_a_fourth_mesh_never_narrows_a_bar(kind, first, second, third):
    assert error_bar(kind, [first, second, third]) >= error_bar(kind, [first, second])


@pytest.mark.parametrize("differences", [[], [0.1], [0.0, 0.1], [0.1, 0.0]])
def test_no_order_where_none_shows(differences):
    assert observed_order(differences) is None


def test_only_the_two_finest_differences_show_an_order():
    assert observed_order([0.1, 0.4, 100.0]) == pytest.approx(2.0)
    assert observed_order([0.4, 0.1]) == pytest.approx(-2.0)  # what diverges says so


def test_no_factor_of_safety_makes_light_of_mesh_differences():
    """A third is what is left where the order is two and first order is assumed."""
    assert all(1 / 3 <= factor < math.inf for factor in SAFETY.values())
