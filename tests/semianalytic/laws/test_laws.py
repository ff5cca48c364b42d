"""Laws of friction: the local balance, states, and refusals."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.scene.laws.law import balanced

IMPEDANCE, SIGMA = 4.6e6, 5e7


@settings(deadline=None, max_examples=60)
@given(
    st.floats(-300, 0),
    st.floats(-8, 12),
    st.sampled_from([0.001, 0.01, 0.05]),
    st.sampled_from(["ageing", "slip"]),
)
def test_local_balance_from_1e_300_to_1(speed, theta, a, evolution):
    law = sf.RateAndState(a, 0.014, 0.6, 1e-6, 1e-5, evolution)
    pressure, speed = np.array([SIGMA]), np.array([10.0**speed])
    state = np.array([10.0**theta])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stopping = law.strength(pressure, speed, state) + IMPEDANCE * speed
        if stopping[0] < 1e-290:  # the traction itself has lost its digits
            return
        found = law.slip_speed(stopping, pressure, IMPEDANCE, state)
        bracketed = balanced(law, stopping, pressure, IMPEDANCE, state)
    assert found == pytest.approx(speed, rel=1e-12)
    assert bracketed == pytest.approx(speed, rel=1e-12)


def test_without_pressure_slip_is_free():
    law = sf.RateAndState(0.01, 0.014, 0.6, 1e-6, 1e-5)
    stopping = np.array([0.0, 1e-3, 5e6])
    for pressure in (0.0, 1e-20):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = law.slip_speed(stopping, np.full(3, pressure), IMPEDANCE, np.full(3, 10.0))
        assert found == pytest.approx(stopping / IMPEDANCE, rel=1e-12)


@pytest.mark.parametrize(
    "law",
    [
        sf.Coulomb(0.4, cohesion=0.1, viscosity=0.3),
        sf.SlipWeakening(0.6, 0.2, 0.1),
        sf.SlipWeakening(0.6, 0.2, 0.1, 0.05, "exponential"),
        sf.RateWeakening(0.6, 0.4, 1.0),
    ],
    ids=lambda law: type(law).__name__,
)
def test_closed_forms_of_the_balance_agree_with_bracketing(law):
    rng = np.random.default_rng(1)
    pressure, state = rng.uniform(0.5, 2, 200), rng.uniform(0, 0.2, 200)
    stopping = rng.uniform(0, 3, 200)
    closed = law.slip_speed(stopping, pressure, 0.5, state)
    assert closed == pytest.approx(balanced(law, stopping, pressure, 0.5, state), rel=1e-11)
    slips = closed > 0
    assert slips.any()
    assert not slips.all()
    balance = law.strength(pressure, closed, state) + 0.5 * closed
    assert balance[slips] == pytest.approx(stopping[slips], rel=1e-12)
    assert (stopping[~slips] <= law.strength(pressure, closed, state)[~slips]).all()


@pytest.mark.parametrize("evolution", ["ageing", "slip"])
def test_state_evolves_as_its_law_says(evolution):
    """Against many short explicit steps of theta'."""
    law = sf.RateAndState(0.01, 0.015, 0.6, 1e-6, 1e-5, evolution)
    speed, time = np.array([3e-6, 1e-7, 1e-4]), 1.0
    theta = np.array([1.0, 20.0, 5.0])
    exact = law.evolved(theta, speed, time)
    steps, now = 40000, theta.copy()
    for _ in range(steps):
        share = speed * now / 1e-5
        rise = 1 - share if evolution == "ageing" else -share * np.log(share)
        now = now + time / steps * rise
    assert exact == pytest.approx(now, rel=1e-3)
    assert law.evolved(theta, np.zeros(3), 2.0) == pytest.approx(
        theta + (2.0 if evolution == "ageing" else 0.0)
    )


def test_start_carries_the_base_shear_at_the_slip_rate():
    law = sf.RateAndState(0.008, 0.012, 0.6, 1e-6, 0.02)
    pressure, shear, speed = np.array([120e6]), np.array([75e6]), np.array([1e-12])
    theta = law.start(pressure, shear, speed)
    assert theta == pytest.approx(1.606239e9, rel=1e-6)  # as UGUCA's input has it
    assert law.strength(pressure, speed, theta) == pytest.approx(shear)


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (lambda: sf.RateAndState(0.01, 0.01, 0.6, 1e-6, 0.0), "distance must be positive"),
        (lambda: sf.RateAndState(0.01, 0.01, 0.6, 1e-6, 1.0, "aging"), "ageing or slip"),
        (lambda: sf.SlipWeakening(0.6, 0.1, 0.1, shape="cubic"), "linear or exponential"),
        (lambda: sf.Coulomb(lambda x: x[:2]).on([0.0, 1.0, 2.0]), "must return 3 numbers"),
        (lambda: sf.Coulomb(lambda x: -x).on([0.0, 1.0, 2.0]), "friction must be 0 or more"),
    ],
)
def test_refusals_are_one_sentence(law, said):
    with pytest.raises(sf.SceneError, match=said) as refusal:
        law()
    assert str(refusal.value).count(". ") == 0


def test_friction_that_falls_faster_than_radiation_balances_is_refused():
    """The slope at rest is (static - dynamic) p / rate; mu / (2 c_t) is 0.5 here."""
    material = sf.Material(1.0, 1.0, 0.25)
    for rate, refused in ((0.59, True), (0.61, False)):
        law = sf.RateWeakening(0.6, 0.3, rate=rate)
        face = scene_along(material, law, 8.0, pressure=1.0, shear=0.4)
        if refused:
            with pytest.raises(sf.SceneError, match=r"by 0\.508 per slip rate, the impedance"):
                sf.solve(face, end_time=0.1, nodes=16)
        else:
            assert sf.solve(face, end_time=0.1, nodes=16).status == "done"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("a", "b"), [(0.016, 0.012), (0.01, 0.014), (0.02, 0.004)])
def test_flash_heating_has_a_steady_state_at_all_speeds(a, b):
    """Strengthening friction, a > b, would be negative at rest by the formula without arcsinh."""
    law = sf.RateAndState(
        *(a, b, 0.6, 1e-6, 1e-2), evolution="slip", weakened=0.2, weakening_rate=0.1
    )
    speed = 10.0 ** np.arange(-290.0, 3.0)
    time = 1e4 / speed  # long enough to forget its state
    state = law.evolved(np.ones(len(speed)), speed, time)
    friction = law.strength(np.ones(len(speed)), speed, state)
    assert (friction > 0).all()
    low = 0.6 + (a - b) * np.log(speed / 1e-6)
    steady = 0.2 + (low - 0.2) / (1 + (speed / 0.1) ** 8) ** (1 / 8)
    clear = low > 0.2
    assert friction[clear] == pytest.approx(steady[clear], rel=1e-9)
