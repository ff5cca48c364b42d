"""Waves that grow while two bodies slide: tables computed by an independent Newton's method and by
marching single waves, the principle of the argument on random pairs, verdicts on stability."""

from functools import cache

import numpy as np
import pytest
from dissimilar_pairs import (
    ALUMINIUM_ON_STEEL,
    GOUGE_ON_ROCK,
    PAIRS,
    ROCK,
    RUBBER_ON_STEEL,
    contrast,
)

import slipfront as sf
from semianalytic import Material, SceneError
from semianalytic.dissimilar import thresholds
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.delay import fastest_delayed_growth
from semianalytic.dissimilar.growth import count_growing, growing_waves

FASTEST = [
    (contrast(1.2), 0.05, 0.00209156, 0.98485883),
    (contrast(1.2), 0.2, 0.00844762, 0.98512795),
    (contrast(1.2), 0.5, 0.02194537, 0.98612211),
    (contrast(1.2), 1.0, 0.04627863, 0.98679677),
    (contrast(1.1), 0.2, 0.00572347, 0.95859767),
    (contrast(1.1), 0.5, 0.01425682, 0.95823356),
    (compliance_of(*ALUMINIUM_ON_STEEL), 0.2, 0.00128573, 0.94914187),
    (compliance_of(*ALUMINIUM_ON_STEEL), 0.5, 0.00316693, 0.94951167),
    (compliance_of(*GOUGE_ON_ROCK), 1.0, 0.06304035, 1.07828011),
    (compliance_of(*PAIRS["PMMA on aluminium"]), 0.02, 6.4570e-4, -2.07796665),
    (compliance_of(*PAIRS["PMMA on aluminium"]), 0.2, 0.01009075, -2.08509184),
    (compliance_of(*PAIRS["PMMA on aluminium"]), 0.5, 0.02175498, -2.11037591),
    (compliance_of(*RUBBER_ON_STEEL), 0.001, 9.49e-6, -7.14142488),
    (compliance_of(*RUBBER_ON_STEEL), 0.2, 0.00175415, -7.25921133),
    (compliance_of(*RUBBER_ON_STEEL), 0.5, 0.00428302, -7.76942886),
    (compliance_of(*RUBBER_ON_STEEL), 1.0, 0.00954590, -9.15148714),
]
"""Growth rate over wave number and velocity, over c_t of the upper body, of the fastest growth."""


@pytest.mark.thinned(4)
@pytest.mark.parametrize(("bodies", "friction", "growth", "velocity"), FASTEST)
def test_fastest_growth(bodies, friction, growth, velocity):
    wave = growing_waves(bodies, friction)[0]
    assert wave.growth == pytest.approx(growth, abs=6e-9)
    assert wave.velocity == pytest.approx(velocity, abs=6e-9)
    other = growing_waves(bodies.mirrored, -friction)[0]  # seen from below
    assert other.slowness == pytest.approx(wave.slowness, rel=1e-9)


def test_a_wave_front_is_not_taken_for_a_wave():
    """The search came to rest within 1e-18 of the P front of the lower body, and left out the wave
    that grows fastest."""
    bodies = compliance_of(Material(1.0, 1.0, 0.29), Material(0.08, 0.46, 0.42))
    known = [1.813793169911727 + 0.4086384367673271j, -0.6770412532623824 + 0.02726856400941844j]
    assert [wave.slowness for wave in growing_waves(bodies, 1.76)] == pytest.approx(known, rel=1e-9)


def test_waves_beyond_the_second_threshold_grow_slowly():
    for ratio, friction, growth in ((1.2, 0.3, 2.6e-5), (3, 0.1, 1.40e-3), (5, 0.1, 6.0e-4)):
        wave = growing_waves(contrast(ratio), friction)[-1]
        assert wave.velocity < 0
        assert wave.growth == pytest.approx(growth, rel=0.004)
    assert growing_waves(contrast(1.2), 2.0)[1].growth == pytest.approx(0.073638, abs=6e-7)


def test_there_may_be_waves_in_both_directions():
    _, other = growing_waves(contrast(1.2), 1.0)
    assert (other.growth, other.velocity) == pytest.approx((0.00586992, -1.75947300), abs=6e-9)
    rubber = growing_waves(compliance_of(*RUBBER_ON_STEEL), 1.0)
    assert [np.sign(wave.velocity) for wave in rubber] == [-1, 1]
    assert rubber[1].growth == pytest.approx(1.153e-5, rel=1e-3)


def test_nothing_grows_between_like_bodies():
    assert growing_waves(compliance_of(Material(1, 1, 0.3), Material(1, 1, 0.3)), 0.9) == ()


def test_every_wave_that_the_principle_of_the_argument_counts_is_found():
    rng = np.random.default_rng(4)
    counts = set()
    for _ in range(6):
        bodies = compliance_of(
            Material(1.0, 1.0, rng.uniform(-0.5, 0.49)),
            Material(*np.exp(rng.uniform([-4, -1], [4, 1])), rng.uniform(-0.5, 0.49)),
        )
        friction = 10 ** rng.uniform(-2.5, 0.3)
        waves = growing_waves(bodies, friction)  # raises where one is not found
        right = sum(wave.velocity > 0 for wave in waves)
        assert right == count_growing(bodies, friction)
        counts.add(len(waves))
        for wave in waves:
            entries = bodies.at(np.array([wave.slowness]))
            size = np.abs(entries.normal) + friction * np.abs(entries.coupling)
            assert np.abs(entries.frictional(friction)) < 1e-7 * size
    assert len(counts) > 1


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("delay", "growth"),
    [
        (0.1, 2.181568e-3),
        (0.4, 7.670228e-3),
        (1.0, 1.138102e-2),
        (2.0, 9.179136e-3),
        (3.0, 3 * 0.002276675),
        (5.0, 4.313361e-3),
        (10.0, 2.182645e-3),
        (100.0, 2.160161e-4),
    ],
)
def test_growth_under_a_delay(delay, growth):
    fastest = growing_waves(contrast(1.2), 0.5, delay)[0]
    assert fastest.growth * delay == pytest.approx(growth, rel=3e-7)
    rule = delay * 0.02194537 / (1 + (delay * 0.984840) ** 2)  # a Lorentzian of that without delay
    assert rule == pytest.approx(growth, rel=0.05)


@pytest.mark.slow
def test_a_delay_bounds_growth():
    bodies, free = contrast(1.2), growing_waves(contrast(1.2), 0.5)[0]
    fastest = fastest_delayed_growth(bodies, 0.5)
    beside = [growing_waves(bodies, 0.5, s * fastest.wave_number)[0] for s in (0.97, 1.0, 1.03)]
    rates = [
        w.growth * s * fastest.wave_number for w, s in zip(beside, (0.97, 1, 1.03), strict=True)
    ]
    assert rates[1] == pytest.approx(fastest.rate, rel=1e-6)
    assert max(rates) == rates[1]
    assert fastest.wave_number == pytest.approx(1 / 0.984840, rel=0.02)
    assert 1 / fastest.rate == pytest.approx(88, abs=0.5)  # t* to grow by a factor of e
    # a wave near the generalised Rayleigh speed obeys a rule of thumb ...
    assert fastest.rate == pytest.approx(free.growth / (2 * free.velocity), rel=0.05)
    # ... one that hugs a body wave grows far faster than that
    rubber = compliance_of(*RUBBER_ON_STEEL)
    free = growing_waves(rubber, 0.5)[0]
    rule = free.growth / (2 * abs(free.velocity))
    assert fastest_delayed_growth(rubber, 0.5).rate > 100 * rule
    assert fastest_delayed_growth(compliance_of(ROCK, ROCK), 0.5) is None


@pytest.mark.parametrize(
    ("ratio", "speed"),
    [
        (1.02, 0.928321),
        (1.05, 0.940689),
        (1.1, 0.958669),
        (1.2, 0.984840),
        (1.3, 0.998005),
        (1.35, 0.999953),
    ],
)
def test_generalised_rayleigh_speed(ratio, speed):
    assert thresholds.generalised_rayleigh_speed(contrast(ratio)) == pytest.approx(speed, abs=6e-7)
    assert thresholds.growth_threshold(contrast(ratio), 1) == 0
    assert thresholds.stoneley_speed(contrast(ratio)) is None


@pytest.mark.parametrize(("nu", "ratio"), [(0.1, 1.478882), (0.25, 1.359316), (0.4, 1.252707)])
def test_generalised_rayleigh_wave_ends_at_the_slower_shear_wave(nu, ratio):
    def exists(other):
        bodies = compliance_of(Material(1, 1, nu), Material(other**2, 1, nu))
        return thresholds.generalised_rayleigh_speed(bodies) is not None

    assert exists(ratio - 1e-4)
    assert not exists(ratio + 1e-4)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("ratio", "ahead", "behind", "below", "above"),
    [
        (1.1, 0.0, 0.30043, 0.28, 0.32),
        (1.2, 0.0, 0.25798, 0.25, 0.27),
        (1.4, 0.29780, 2.1086, 2.05, 2.2),
        (1.6, 0.62529, None, 0.0, 0.0),
        (1.5, 0.51239, None, 2.3, 2.45),
        (1.8, 0.75080, 2.8435, 2.8, 2.9),
        (2.0, 0.81902, 1.0268, 1.0, 1.06),
        (2.2, None, 0.2517, 0.0, 0.0),
        (3.0, 0.93557, 0.0257, 0.024, 0.027),
        (2.5, None, 0.0833, 0.0, 0.0),
        (5.0, 0.97895, 0.0021, 0.001, 0.003),
        (10.0, 0.99494, 1e-4, 0.0, 0.0),
    ],
)
def test_thresholds(ratio, ahead, behind, below, above):
    """Above that behind, a wave against the slower body grows, and below it there is none."""
    bodies = contrast(ratio)
    for known, direction in ((ahead, 1), (behind, -1)):
        if known is not None:
            digit = 0.6 * 10.0 ** -len(f"{known}".partition(".")[2]) if known >= 1e-3 else 2e-5
            assert thresholds.growth_threshold(bodies, direction) == pytest.approx(known, abs=digit)
    if above:
        assert [count_growing(bodies.mirrored, answer) for answer in (below, above)] == [0, 1]
        assert below < thresholds.growth_threshold(bodies, -1) < above


def test_thresholds_of_named_pairs():
    gouge = compliance_of(*GOUGE_ON_ROCK)
    assert thresholds.growth_threshold(gouge, 1) == pytest.approx(0.5314169, abs=6e-8)
    assert growing_waves(gouge, 0.5314) == ()
    (wave,) = growing_waves(gouge, 0.532)
    assert 0 < wave.growth < 1e-4
    pmma = compliance_of(*PAIRS["PMMA on aluminium"])
    assert thresholds.growth_threshold(pmma, -1) == pytest.approx(0.0095371, abs=6e-8)
    assert thresholds.growth_threshold(compliance_of(*RUBBER_ON_STEEL), -1) < 1e-5


@pytest.mark.parametrize("nu", [0.1, 0.25, 0.4])
def test_on_a_rigid_body_waves_ahead_grow_above_friction_1(nu):
    bodies = compliance_of(Material(1, 1, nu), Material(1e10, 100.0, nu))
    assert thresholds.growth_threshold(bodies, 1) == pytest.approx(1.0, abs=1e-8)
    # exact: q = b^2 - 2 k^2 is 0 at a speed of sqrt(2) c_t, where A + k D vanishes
    entries = bodies.on_cut(np.sqrt([0.5]))
    assert abs(entries.frictional(1.0)[0]) < 1e-9 * abs(entries.normal[0])
    assert abs(entries.frictional(-1.0)[0]) > abs(entries.normal[0])


def test_a_wave_turns_at_its_threshold():
    bodies = contrast(1.5)
    for friction in thresholds.friction_crossings(bodies)[
        np.abs(thresholds.friction_crossings(bodies)) < 1
    ]:
        below, above = (count_growing(bodies, friction * (1 + s)) for s in (-1e-3, 1e-3))
        assert below != above


@cache
def growing_on(which, contrast):
    """Waves that grow on bodies of which one parameter differs by a relative contrast."""
    given = {"shear_modulus": 1.0, "density": 1.0, "poisson_ratio": 1 / 3}
    other = {**given, which: given[which] * (1 + contrast)}
    return growing_waves(compliance_of(Material(**given), Material(**other)), 0.3)


@pytest.mark.parametrize("which", ["shear_modulus", "density", "poisson_ratio"])
@pytest.mark.parametrize("contrast", [1e-12, 1e-10, 1e-8, 4e-7])
def test_bodies_that_differ_by_rounding_let_no_wave_grow(which, contrast):
    """Growth falls with the contrast, and what is left of it drowns in rounding."""
    assert growing_on(which, contrast) == ()
    (wave,) = growing_on(which, 1e-5)
    assert 1e-7 < wave.per_wavelength < 4e-6


def test_verdicts():
    known = sf.sliding_stability(*GOUGE_ON_ROCK, 0.5)
    assert known.well_posed
    assert known.verdict.endswith("under friction below 0.5314.")
    # a delay makes waves grow that decay without it
    assert known.delayed_growth == pytest.approx(0.0040085025, rel=1e-6)
    assert sf.sliding_stability(ROCK, ROCK, 3.0).verdict.endswith("slide under any friction.")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("steel", ROCK, 0.3), "upper must be a Material"),
        ((ROCK, ROCK, 0.0), "friction must be positive"),
        ((ROCK, ROCK, np.nan), "friction must be"),
        ((ROCK, Material(1e11, 1.0, 0.25), 0.3), "factor of 1e\\+10"),
    ],
)
def test_what_cannot_be_told_is_refused(arguments, complaint):
    with pytest.raises(SceneError, match=complaint):
        sf.sliding_stability(*arguments)


def test_growth_beyond_the_range_of_numbers_is_the_largest_number():
    upper, lower = Material(1.0, 1.0, 0.25), Material(2.0, 1.0, 0.25)
    waves = sf.sliding_stability(upper, lower, 1e9).waves
    largest = np.finfo(float).max
    assert max(wave.per_wavelength for wave in waves) == pytest.approx(largest, rel=1e-9)
