"""Finite elements of a periodic interface, against plane waves, energy and the laws themselves."""

import numpy as np
import pytest

import semianalytic as sf
from fem.lines import Line, simulate_line
from fem.lines.blocks import make_blocks
from fem.lines.march import build_line, imbalance
from semianalytic.scene.errors import SceneError

SOFT, STIFF = sf.Material(1.0, 1.0, 0.25), sf.Material(3.0, 1.2, 0.2)


def always(line, slot=None):
    """Tractions that do not change with time."""
    return lambda t, after=False: (line, 0 * line if slot is None else slot)


def whole(upper, lower, friction, shear, state=None, nodes=64, length=4.0, **more):
    """A line that touches everywhere, under a pressure of 1."""
    x = length * (np.arange(nodes) / nodes - 0.5)
    still = np.zeros(nodes)
    return Line(
        upper,
        lower,
        length,
        x,
        np.full(nodes, True),
        friction.on(x),
        still if state is None else state + still,
        always(shear(x) + still),
        always(1 + still),
        **more,
    )


@pytest.mark.parametrize(("lower", "opens"), [(SOFT, False), (SOFT, True), (STIFF, True)])
def test_uniform_slip_is_that_of_plane_waves_in_both_bodies(lower, opens):
    line = whole(SOFT, lower, sf.Coulomb(0.3), lambda x: 0.8, opens=opens)
    done = simulate_line(line, 1.0, samples=4)
    rate = (0.8 - 0.3) * (1 / SOFT.shear_impedance + 1 / lower.shear_impedance)
    # a kick at t = 0 acts for half a step, so that slip lags by less than a step
    assert done.slip[-1] == pytest.approx(rate, rel=0.01)
    assert done.slip_rate[-1] == pytest.approx(rate, rel=2e-3)
    assert done.shear_traction[-1] == pytest.approx(0.3, rel=1e-12)


def test_the_first_kick_rubs_under_the_pressure_that_it_brings():
    """Pressure rises from 1 to 2 at t = 0: slip (.9 - .3 2) 2 c_t t / mu from the first kick on."""
    line = whole(SOFT, SOFT, sf.Coulomb(0.3), lambda x: 0.9, nodes=128, opens=True)
    still = np.zeros(128)

    def pressure(t, after=False):
        return 1.0 + still + (t > 0 or after), still

    slip = simulate_line(Line(**{**vars(line), "pressure": pressure}), 1.0).slip[-1]
    assert slip == pytest.approx(0.6, abs=1e-3)


def test_a_far_side_lets_plane_waves_out(monkeypatch):
    monkeypatch.setattr("fem.lines.blocks.SHALLOW", 0.1)
    monkeypatch.setattr("fem.lines.blocks.STIFF", 2.0)
    line = whole(SOFT, STIFF, sf.Coulomb(0.3), lambda x: 0.8, opens=True)
    deep, shallow = make_blocks(line, 2.0, 0.02)
    assert shallow.rows < deep.rows / 4
    rate = 0.5 * (1 / SOFT.shear_impedance + 1 / STIFF.shear_impedance)
    assert simulate_line(line, 2.0).slip_rate[-1] == pytest.approx(rate, rel=5e-3)


LAWS = {
    "coulomb": (sf.Coulomb(0.3), 0.0),
    "delayed": (sf.Coulomb(0.3, cohesion=0.1, viscosity=0.2, delay=0.2), 0.0),
    "weakening": (sf.SlipWeakening(0.5, 0.2, 0.3, delay_slip=0.1), 0.0),
    "rate-and-state": (sf.RateAndState(0.02, 0.03, 0.5, 1e-3, 0.2), 50.0),
}


@pytest.mark.parametrize("name", LAWS)
def test_energy_balances_and_the_law_holds_at_every_step(name):
    law, state = LAWS[name]
    line = whole(SOFT, STIFF, law, lambda x: 1.0 * (abs(x) < 0.7), state, opens=True)
    line = Line(**{**vars(line), "pressure": always(1 - 1.6 * np.exp(-4 * line.x**2))})
    blocks = make_blocks(line, 1.0, 0.02)
    step = 0.8 * min(block.critical_step for block in blocks)
    march = build_line(line, blocks, step, 1.0)
    joint = march.joint
    opened = 0
    for level in range(round(0.8 / step)):
        march.kick(level)
        rate = joint.sliding.increment() / step
        # rounding of increments, 3e-16 of a rate, moves the strength of slower nodes by over 1e-9
        strength = line.friction.strength(joint.felt, np.maximum(np.abs(rate), 1e-8), joint.state)
        strength = np.where(joint.pressure > 0, strength, 0.0)
        assert (np.abs(joint.shear) <= strength + 1e-9).all()
        slips = np.abs(rate) > 1e-8
        assert joint.shear[slips] == pytest.approx((np.sign(rate) * strength)[slips], abs=1e-9)
        assert joint.pressure.min() >= 0
        march.drift()
        gap = joint.pressing.offset()
        assert gap.min() > -1e-12
        assert (gap[joint.pressure > 0] < 1e-12).all()
        opened = max(opened, int((gap > 1e-6).sum()))
        if level > 3:
            assert abs(imbalance(march)) < 1e-12
    assert 4 < opened < len(line.x)


def test_bodies_that_change_places_mirror_the_answer():
    def shear(x):
        return 0.2 + 0.6 * (abs(x - 0.3) < 0.5)

    simulation = simulate_line(whole(SOFT, STIFF, sf.Coulomb(0.3), shear, opens=True), 0.8)
    other = simulate_line(whole(STIFF, SOFT, sf.Coulomb(0.3), lambda x: shear(-x), opens=True), 0.8)
    for name, sign in (("slip", 1), ("pressure", 1)):
        mirrored = np.roll(getattr(other, name)[:, ::-1], 1, axis=1)
        assert getattr(simulation, name) == pytest.approx(sign * mirrored, abs=1e-12)
    assert abs(simulation.pressure - 1).max() > 0.05


def test_one_body_is_enough_where_the_other_moves_oppositely():
    def shear(x):
        return 0.8 * (abs(x) < 0.5)

    half = simulate_line(whole(SOFT, SOFT, sf.Coulomb(0.3), shear), 0.8)
    both = simulate_line(whole(SOFT, SOFT, sf.Coulomb(0.3), shear, opens=True), 0.8)
    assert both.unknowns == 2 * half.unknowns
    assert half.slip == pytest.approx(both.slip, abs=1e-12)
    assert both.pressure == pytest.approx(1.0, abs=1e-12)


def test_what_cannot_be_simulated_is_refused():
    line = whole(SOFT, STIFF, sf.Coulomb(0.3), lambda x: 0.8, nodes=4096, opens=True)
    with pytest.raises(SceneError, match="would take hours"):
        simulate_line(line, 100.0)
    with pytest.raises(SceneError, match="end_time must"):
        simulate_line(line, -1.0)
