"""Error bars from mesh differences whose size and order are known."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from compare.comparison.bars import (
    LARGEST_ORDER,
    LEAST_ORDER,
    RANGE,
    SAFETY,
    error_bar,
    observed_order,
)

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


@given(st.floats(LEAST_ORDER + 1e-6, 4.0), st.sampled_from([1, -1]), st.floats(1e-6, 1.0))
def test_errors_of_an_allowed_order_are_within_their_bar(order, sign, error):
    moved = changes(readings(0.0, sign * error, order))
    bar, norm = (error_bar(moved, norm=choice) for choice in (False, True))
    assert error <= norm.size * (1 + 1e-9) <= bar.size * (1 + 2e-9)
    missing = abs(moved[0]) / (2 ** min(order, LARGEST_ORDER) - 1)
    assert (norm.size, norm.order, bar.converges) == pytest.approx((SAFETY * missing, order, True))
    assert order > LARGEST_ORDER or bar.size == pytest.approx(norm.size, rel=1e-9)


@given(st.floats(-2.0, LEAST_ORDER - 0.01), st.floats(1e-6, 1.0))
def test_what_falls_more_slowly_than_meshes_may_does_not_converge(order, change):
    """The last change is more than 0.71 of that before, or larger than it."""
    bar = error_bar([change, change * 2**order])
    assert not bar.converges
    assert bar.size >= RANGE * change


@given(st.floats(-2.0, LEAST_ORDER - 0.01), st.floats(1e-6, 1.0))
def test_changes_that_are_small_by_chance_are_no_smaller_than_the_nodes_leave_open(order, change):
    """Both changes are within the uncertainty of the nodes, and do not fall: the outer edge of a
    zone of `auxetic` moved by 0.08 and 0.04 elements, and was 0.7 off."""
    floor = 1.01 * change * max(1.0, 2**order)
    bar = error_bar([change, change * 2**order], floor)
    assert bar.converges
    assert bar.size == pytest.approx(SAFETY * floor / (2**LEAST_ORDER - 1) + floor)


STAND_IN = SAFETY * 0.4 / 2**LARGEST_ORDER / (2**LARGEST_ORDER - 1)
"""What a change of 0.4 from 4h to 2h leaves of the next, which was small by chance."""
BARS = {
    # the slip of a contact that sticks, which some mesh has exactly and others to 1e-17
    "changes by rounding": ([2e-17, 1e-17], 1e-6, 1e-6, True),
    "small changes that fall": ([0.1, 0.2], 0.3, SAFETY * 0.1 + 0.3, True),
    "no change": ([0.0, 0.0], 0.3, 0.3, True),
    # a reading is known to 0.1 at h and to 0.2 at 2h: a change of 0.3 says nothing of an order
    "what nodes leave open": ([0.3, 0.0], 0.1, None, True),
    "more than they do": ([0.31, 0.0], 0.1, None, False),
    # from 0.4 up to 0 and back to -1: three times all of that
    "forth and back": ([-1.0, 0.4], 0.0, RANGE * 1.0, False),
    "none by chance": ([0.0, 0.4], 0.0, STAND_IN, True),
    "little by chance": ([0.01, 0.4], 0.0, STAND_IN, True),
}


@pytest.mark.parametrize(("differences", "floor", "size", "converges"), BARS.values(), ids=BARS)
def test_bars_of_changes(differences, floor, size, converges):
    bar = error_bar(differences, floor)
    assert bar.converges is converges
    assert size is None or bar.size == pytest.approx(size)


def test_the_bar_of_two_meshes_alone_is_wider_and_never_small_by_chance():
    alone, floor = error_bar([0.2]), 0.05
    assert alone.size == pytest.approx(RANGE * 0.2)
    assert alone.size > error_bar([0.2, 0.4]).size
    assert error_bar([0.0], floor).size == pytest.approx((RANGE + 1) * floor)
    assert math.isinf(alone.limit)


@given(st.floats(0.01, 10.0), st.floats(0.0, 100.0))
def test_a_fault_in_the_finest_run_does_not_widen_what_the_coarser_ones_allow(before, last):
    """It may widen the bar; `limit` knows the coarser meshes alone."""
    right, faulty = error_bar([before / 2, before]), error_bar([before / 2 + last, before])
    assert faulty.limit == right.limit
    assert right.size <= right.limit
    # what may converge is missing less than the limit; what may not has a wider bar
    assert (faulty.size <= faulty.limit) is faulty.converges


@given(st.lists(sizes, min_size=1, max_size=2), sizes)
def test_bars_scale_with_the_differences_and_do_not_know_their_sign(differences, unit):
    bar = error_bar(differences)
    scaled = error_bar([-unit * difference for difference in differences])
    assert scaled.size == pytest.approx(unit * bar.size)
    assert scaled.converges is bar.converges


@given(sizes, sizes, sizes)
def test_only_three_meshes_count(first, second, third):
    assert error_bar([first, second, third]) == error_bar([first, second])


@pytest.mark.parametrize(
    ("differences", "order"),
    [
        *(([], None), ([0.1], None), ([0.0, 0.1], None), ([0.1, 0.0], None)),
        ([0.1, 0.4, 100.0], pytest.approx(2.0)),  # the two finest alone show it
        ([0.4, 0.1], pytest.approx(-2.0)),  # what diverges says so
    ],
)
def test_order_of_differences(differences, order):
    assert observed_order(differences) == order
