"""Speeds from aligned waveforms, on records whose speed is known."""

import numpy as np
import pytest

from compare.comparison.quantities.arrivals import (
    Window,
    aligned_speed,
    alignment_bar,
    front_window,
    left_over,
    roughness,
)

VELOCITY = np.linspace(0.005, 2.0, 400)
WINDOW = Window(0.8, 1.0, 1.2)


def kink(velocity):
    return np.maximum(1.0 - velocity, 0.0)


@pytest.mark.parametrize("speed", [0.97, 1.0, 1.02])
@pytest.mark.parametrize("smear", [0.0, 0.02])
def test_a_kink_is_found_where_it_is_however_smeared_and_tilted(speed, smear):
    # An even smear widens a kink and leaves its place; a parabola is no part of a front.
    offsets = smear * np.linspace(-1, 1, 21)
    record = np.mean([kink((VELOCITY + o) / speed) for o in offsets], axis=0)
    record += 0.1 - 0.05 * VELOCITY + 0.02 * VELOCITY**2
    # A fifth of the sample spacing, 0.005.
    assert aligned_speed(VELOCITY, record, kink, WINDOW) == pytest.approx(speed, abs=1e-3)


def test_units_of_speed_do_not_matter():
    record = kink(VELOCITY / 0.98)
    unit = 3200.0
    scaled = aligned_speed(
        unit * VELOCITY,
        record,
        lambda v: kink(v / unit),
        Window(0.8 * unit, unit, 1.2 * unit),
    )
    assert scaled == pytest.approx(unit * aligned_speed(VELOCITY, record, kink, WINDOW), rel=1e-6)


def test_a_record_without_the_front_gives_no_speed():
    assert aligned_speed(VELOCITY, kink(VELOCITY / 0.5), kink, WINDOW) is None


def test_too_few_samples_give_no_speed():
    assert aligned_speed(VELOCITY[::40], kink(VELOCITY[::40]), kink, WINDOW) is None


@pytest.mark.parametrize("strength", [1.0, 0.1])
def test_what_is_left_moves_a_weak_front_farther_than_a_strong_one(strength):
    """Ripples beside a kink of slope 1 or 0.1; without them nothing is left."""

    def front(velocity):
        return strength * kink(velocity)

    record = front(VELOCITY) + 1e-4 * np.sin(200 * VELOCITY)
    speed = aligned_speed(VELOCITY, record, front, WINDOW)
    seen, left = left_over(VELOCITY, record, front, WINDOW, speed)
    bar = alignment_bar(seen, left, front, WINDOW, speed)
    off = [roughness(front(seen / (speed + by)) - front(seen / speed), seen) for by in (bar, -bar)]
    assert off == pytest.approx(2 * [roughness(left, seen)], 0.1)
    # how much the kink changes per part by which its speed does
    slope = roughness(np.where(seen < 1, seen, 0.0), seen)
    assert bar == pytest.approx(1e-4 / 2**0.5 / (strength * slope), rel=0.1)
    clean = left_over(VELOCITY, front(VELOCITY), front, WINDOW, 1.0)[1]
    assert alignment_bar(seen, clean, front, WINDOW, 1.0) < 1e-9


def test_window_ends_half_way_to_the_neighbours():
    assert front_window(1.0, [0.93, 2.0]) == Window(pytest.approx(0.965), 1.0, pytest.approx(1.2))
    assert front_window(2.0, [], reach=0.1) == Window(pytest.approx(1.8), 2.0, pytest.approx(2.2))


def test_roughness_sees_kinks_and_no_parabolas():
    samples = WINDOW.samples()
    assert roughness(3 * samples**2 - samples + 2, samples) < 1e-12
    assert roughness(kink(samples), samples) > 5e-3
    assert roughness(7 * kink(samples), samples) == pytest.approx(
        7 * roughness(kink(samples), samples)
    )
