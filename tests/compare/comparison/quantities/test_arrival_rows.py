"""Rows of fronts: which there are, how far off they are, what cannot be read, and how."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved
from compare_cases import sampled_run

from compare.comparison.judgement import side_by_side
from compare.comparison.prediction import predict_like
from compare.comparison.quantities.arrival_rows import arrival_rows
from compare.comparison.quantities.arrivals import (
    FrontWindow,
    aligned_speed,
    alignment_bar,
    front_window,
    left_over,
    roughness,
)
from semianalytic.scene.given.finding import find_scene

IN_PLANE = {"P interface", "Rayleigh slot face", "P slot face"}
PRESENT = {
    "preloaded": IN_PLANE,
    "remote-shock": IN_PLANE,
    "stuck": IN_PLANE,
    "antiplane": {"S interface", "S slot face"},
}
"""The first signal on either face and the Rayleigh signal: an S front behind a P front is too close
to others for the mesh at 2h."""


def rows_of(prediction, run):
    return list(arrival_rows(side_by_side(prediction, run)))


@pytest.mark.thinned(6)
@pytest.mark.parametrize("name", PRESENT)
def test_every_signal_on_either_face_has_one_row(name):
    exact = solved(find_scene(name))
    rows = rows_of(exact, sampled_run(exact))
    assert len({row.name for row in rows}) == len(rows)
    signals = [row.name.split(" (")[0].replace(" front,", "") for row in rows]
    assert sorted(signals) == sorted(PRESENT[name])
    for row in rows:
        assert (row.unit, row.kind) == ("c_t", "arrival")
        # A Rayleigh front is too blurred at 4h to say how fast it converges.
        assert row.verdict == "agrees" or (row.verdict, row.name.split()[0]) == (
            "unresolved",
            "Rayleigh",
        )


@pytest.mark.thinned(2)
@pytest.mark.parametrize("stretch", [0.99, 1.01])
def test_arrivals_off_by_one_percent_say_so(solution, stretch):
    rows = rows_of(solution, sampled_run(solution, stretch=stretch))
    assert len(rows) == 3
    for row in rows:
        # A fifth of an element, 0.01.
        assert row.difference == pytest.approx((stretch - 1) * row.exact, abs=2e-3)
    fastest = [row for row in rows if row.exact == pytest.approx(2.0)]
    assert [row.verdict for row in fastest] == 2 * ["differs"]


@pytest.mark.slow
def test_arrivals_off_by_what_coarser_meshes_are_off_agree_and_say_where_they_are(solution):
    """By 1 % at h, 2 % at 2h, 4 % at 4h."""
    rows = rows_of(solution, sampled_run(solution, stretch=1.01, growth=2.0))
    agreeing = [row for row in rows if row.verdict == "agrees"]
    assert len(agreeing) >= 2
    for row in agreeing:
        assert row.bar > 0.01 * row.exact
    material, exact = solution.scene.material, {row.name.split()[0]: row.exact for row in rows}
    assert exact["P"] == pytest.approx(material.longitudinal_speed / material.shear_speed)
    assert exact["Rayleigh"] == pytest.approx(material.rayleigh_speed / material.shear_speed)


def test_a_mistake_of_the_prediction_does_not_widen_its_bars(solution):
    run = sampled_run(solution)
    wrong = solved(replace(solution.scene, friction=1.2 * solution.scene.friction))
    bars = {row.name: row.bar for row in rows_of(solution, run)}
    widened = {row.name: row.bar / bars[row.name] for row in rows_of(wrong, run)}
    assert len(widened) == 3
    assert max(widened.values()) < 1.1


def test_few_nodes_about_a_front_leave_it_unresolved(solution):
    rows = rows_of(solution, sampled_run(solution, resolution=16))
    (row,) = (row for row in rows if row.name.startswith("Rayleigh"))
    assert row.verdict == "unresolved"
    assert row.obstacle


def test_a_march_that_ends_before_the_fronts_has_none(solution):
    run = sampled_run(solution, resolution=40)
    assert rows_of(predict_like(run, "space-time"), run) == []


# --- speeds from aligned waveforms, on records whose speed is known -------------------------------

VELOCITY = np.linspace(0.005, 2.0, 400)
WINDOW = FrontWindow(0.8, 1.0, 1.2)


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
        unit * VELOCITY, record, lambda v: kink(v / unit), FrontWindow(0.8 * unit, unit, 1.2 * unit)
    )
    assert scaled == pytest.approx(unit * aligned_speed(VELOCITY, record, kink, WINDOW), rel=1e-6)


def test_records_without_the_front_or_of_few_samples_give_no_speed():
    assert aligned_speed(VELOCITY, kink(VELOCITY / 0.5), kink, WINDOW) is None
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
    assert front_window(1.0, [0.93, 2.0]) == FrontWindow(
        pytest.approx(0.965), 1.0, pytest.approx(1.2)
    )
    assert front_window(2.0, [], reach=0.1) == FrontWindow(
        pytest.approx(1.8), 2.0, pytest.approx(2.2)
    )


def test_roughness_sees_kinks_and_no_parabolas():
    samples = WINDOW.samples()
    assert roughness(3 * samples**2 - samples + 2, samples) < 1e-12
    assert roughness(kink(samples), samples) > 5e-3
    assert roughness(7 * kink(samples), samples) == pytest.approx(
        7 * roughness(kink(samples), samples)
    )
