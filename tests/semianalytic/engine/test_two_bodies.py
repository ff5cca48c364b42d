"""Two different bodies: kernels, growing waves, exact half-lines and slots, delayed friction."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dissimilar_pairs import GOUGE_ON_ROCK, PAIRS, ROCK, RUBBER_ON_STEEL
from two_body_march import kernels

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.growth import growing_waves
from semianalytic.dissimilar.kernels import PairImpedance
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.memory.exponentials import fit_shared
from semianalytic.memory.impedance import InPlane, Opening
from tests.semianalytic.dissimilar.half_line import half_line_slip_rate
from tests.semianalytic.engine.runs import one_run

FASTER = sf.Material(2.25, 1.0, 0.25)
"""A body of 1.5 times the wave speeds of `ROCK`."""
WITH_STONELEY_WAVE = (ROCK, sf.Material(9.0, 9.0, 0.25))
FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")


def each_body(material, s):
    """The impedance matrix (n, 2, 2) of one body at slowness i / s, from the witness."""
    ratio = material.shear_speed / material.longitudinal_speed
    along, normal, mixed = kernels(ratio, s) + np.array([[1.0], [1 / ratio], [0.0]])
    rows = [[along, -1j * mixed], [1j * mixed, normal]]
    return material.shear_impedance * np.moveaxis(np.array(rows), (0, 1), (-2, -1))


@pytest.mark.parametrize("pair", [PAIRS["0"], PAIRS["PMMA on aluminium"], RUBBER_ON_STEEL])
def test_kernels_of_a_pair_are_those_of_both_bodies_in_series(pair):
    upper, lower = pair
    s = np.array([1e-3 + 0.2j, 0.1 + 1.3j, 2.0 + 0.0j, 0.3 + 8.0j])
    impedance = PairImpedance(upper, lower)
    own, opening, coupled = impedance.at(s) * upper.shear_impedance
    above = each_body(upper, s)
    below = each_body(lower, s * upper.shear_speed / lower.shear_speed)
    below = below * np.array([[1, -1], [-1, 1]])  # mirrored in y
    total = np.linalg.inv(np.linalg.inv(above) + np.linalg.inv(below))
    np.testing.assert_allclose(own, total[:, 0, 0], rtol=1e-9)
    np.testing.assert_allclose(opening, total[:, 1, 1], rtol=1e-9)
    np.testing.assert_allclose(-1j * coupled, total[:, 0, 1], rtol=1e-7)


def test_kernels_of_identical_bodies_are_those_of_one():
    s = np.array([1e-3 + 0.2j, 0.1 + 1.3j, 2.0 + 0.0j, 0.3 + 8.0j])
    impedance, ratio = PairImpedance(ROCK, ROCK), ROCK.shear_speed / ROCK.longitudinal_speed
    own, opening, coupled = impedance(s)
    np.testing.assert_allclose(own / impedance.direct[0], InPlane(ratio)(s), rtol=1e-11)
    np.testing.assert_allclose(opening / impedance.direct[1], Opening(ratio)(s), rtol=1e-11)
    assert not coupled.any()


@pytest.mark.thinned(2)
@pytest.mark.parametrize("pair", [RUBBER_ON_STEEL, PAIRS["0"], WITH_STONELEY_WAVE])
def test_a_shared_fit_has_the_transforms_and_the_static_limits(pair):
    impedance = PairImpedance(*pair)
    fit = fit_shared(impedance, 512.0, 1e-6)
    s = 1 / 512 + 1j * np.geomspace(1e-3, 20, 400)
    poles, residues = fit.poles, fit.residues / 2
    fitted = residues @ (1 / (s - poles[:, None])) + residues.conj() @ (
        1 / (s - poles.conj()[:, None])
    )
    fitted += impedance.direct[:, None] + fit.static[:, None] / s
    exact = impedance.at(s)
    assert np.abs(fitted - exact).max() <= 1e-5 * np.abs(exact - fit.static[:, None] / s).max()
    small = np.array([1e-7 + 0.0j])
    np.testing.assert_allclose(impedance.at(small)[:, 0] * small, impedance.static, rtol=1e-6)
    assert len(impedance.lasting[0]) == (pair is WITH_STONELEY_WAVE)


def patch(upper, lower, **changes):
    """A line at rest below friction 0.2, stressed beyond it on 5 of its 10 units of length."""
    given = {
        "law": sf.Coulomb(0.2),
        "pressure": 1.0,
        "shear": 0.16,
        "loads": [sf.InterfaceLoad(lambda x: 0.08 * (abs(x) < 2.5))],
        "lower_material": lower,
    }
    return scene_along(upper, period=10.0, **{**given, **changes})


@cache
def slipping_half_line(ratio, nodes):
    """A run to t = 1 of a patch with ends like a half-line's; ratio is missing over excess."""
    load = sf.InterfaceLoad(lambda x: 0.04 * (1 + ratio) * (abs(x) < 2.5))
    face = patch(ROCK, FASTER, loads=[load], shear=0.2 - 0.04 * ratio)
    return one_run(face, 1.0, nodes, times=[1.0])


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("ratio", "known"), [(1.0, (0.394936752, 0.387292149)), (2.0, (0.178058450, 0.169609086))]
)
def test_an_over_stressed_half_line_slips_as_far_as_the_exact_answer(ratio, known):
    """Contrast 1.5, friction 0.2: speeds of the edges over c_t."""
    done, spacing = slipping_half_line(ratio, 512), 10.0 / 512
    slips = done.interface.x[done.interface.slip_rate[-1] > 1e-9]
    ends = slips.max() + spacing / 2 - 2.5, -slips.min() + spacing / 2 - 2.5
    np.testing.assert_allclose(ends, known, atol=spacing)


def test_slip_rate_of_a_half_line_converges_to_the_exact_profile():
    pair, errors = compliance_of(ROCK, FASTER), []
    for nodes in (128, 256, 512):
        done = slipping_half_line(1.0, nodes)
        v = done.interface.x - 2.5
        seen = (v > 0.02) & (v < 0.6)
        exact = 0.08 * half_line_slip_rate(pair, 0.2, 1.0, v[seen])
        errors.append(np.abs(done.interface.slip_rate[-1, seen] - exact).sum() / exact.sum())
    assert errors[2] < 0.06
    assert errors[0] > 1.6 * errors[1] > 1.6**2 * errors[2]


def test_bodies_that_change_places_give_the_mirrored_answer():
    fwd, back = (one_run(patch(*pair), 1.0, 256) for pair in ((ROCK, FASTER), (FASTER, ROCK)))
    for name in FIELDS:
        mirrored = np.roll(getattr(back.interface, name)[:, ::-1], 1, axis=1)
        size = np.abs(getattr(fwd.interface, name)).max()
        np.testing.assert_allclose(
            mirrored, getattr(fwd.interface, name), rtol=0, atol=1e-12 * size
        )
    # A positive control: without the mirror they differ.
    assert np.abs(back.interface.slip - fwd.interface.slip).max() > 1e-3 * fwd.interface.slip.max()


def test_nearly_identical_bodies_give_the_answer_of_identical_ones():
    contact = sf.Contact([(-2.5, 2.5)])
    loads = [
        sf.InterfaceLoad(lambda x: 0.2 * (abs(x) < 1)),
        sf.InterfaceLoad(0.1, on="slot", pressure=0.2),
    ]
    ends = []
    for lower in (ROCK, sf.Material(1.0 + 1e-12, 1.0, 0.25)):
        given = patch(ROCK, lower, contact=contact, loads=loads)
        stepper = Stepper(given, 128, 0.4, end_time=2.0)
        now = stepper.begin()
        for _ in range(60):
            now = stepper.step(now, stepper.shortest, 0)
        ends.append(now)
    assert ends[0].slip.max() > 0.1
    for name in ("slip", "traction", "pressure", "gap"):
        first, other = (getattr(end, name) for end in ends)
        np.testing.assert_allclose(other, first, rtol=0, atol=1e-6 * np.abs(first).max())


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("load", "pressure", "friction"), [((1.0, 0.5), 1.5, 0.3), ((-1.0, 0.5), 1.5, 0.3)]
)
def test_a_slot_is_met_by_the_exact_answer(load, pressure, friction):
    """Slip against a rising pressure; and an opening beside the slot with slip ahead of it."""
    upper, lower = PAIRS["0"]
    sides = sf.Tractions(pressure, 0.0), sf.Tractions(*load)
    exact = sf.solve(sf.Scene(upper, friction, *sides, lower_material=lower), rtol=1e-6)
    given = scene_along(
        upper,
        sf.Coulomb(friction),
        12.0,
        pressure=pressure,
        contact=sf.Contact.half_line(),
        loads=[sf.InterfaceLoad(load[1], on="slot", pressure=load[0])],
        lower_material=lower,
    )
    done = one_run(given, 1.0, 768, times=[1.0])
    seen = (done.interface.x > 0.1) & (done.interface.x < 3.0)
    for name, limit in (("slip_rate", 0.03), ("pressure", 0.03), ("shear_traction", 0.03)):
        field = getattr(done.interface, name)[-1]
        # Beside a stuck edge nodal tractions alternate about the answer on any grid.
        field = (np.roll(field, 1) + 2 * field + np.roll(field, -1)) / 4
        expected = getattr(exact, name)(done.interface.x[seen], 1.0)
        size = np.abs(expected - (pressure if name == "pressure" else 0.0)).sum()
        assert np.abs(field[seen] - expected).sum() < limit * size, name
    opened = done.interface.x[
        (done.interface.gap[-1] > 0) & (done.interface.x > 0) & (done.interface.x < 3.0)
    ]
    assert bool(len(opened)) == bool(exact.openings)
    if len(opened):
        assert opened.max() == pytest.approx(exact.openings[0].outer, abs=2 * 12 / 768)
    assert not (done.interface.pressure * done.interface.gap)[:, done.interface.touching].any()
    assert done.work["closing"] >= 0


def growth_rate(pair, law, friction, periods):
    """Growth rate over wave number of one wave of steady sliding, marched with two step lengths."""
    upper, lower = pair
    q, unit, found = 2 * np.pi, upper.shear_speed, []

    def kick(x, t):
        return 1e-6 * np.cos(q * x) * np.exp(-(((t * unit - 0.5) / 0.15) ** 2))

    given = scene_along(
        upper,
        law,
        1.0,
        pressure=1.0,
        shear=friction,
        rate=1.0,
        plate_rate=1.0,
        loads=[sf.InterfaceLoad(kick, history=None)],
        lower_material=lower,
    )
    for ratio in (0.2, 0.1):
        stepper = Stepper(given, 8, ratio, end_time=periods / unit)
        now, seen, every = stepper.begin(), [], round(0.4 / ratio)
        while now.time < periods / unit:
            for _ in range(every):
                now = stepper.step(now, stepper.shortest, 0)
            if now.time * unit > 1.5:
                seen.append(np.fft.rfft(now.rate)[1])
        series = np.array(seen)
        columns = np.array([series[i : len(series) - 4 + i] for i in range(4)]).T
        rest = np.linalg.lstsq(columns, -series[4:], rcond=None)[0]
        roots = np.roots([1, *rest[::-1]])
        found.append(max(np.log(np.abs(roots))) / (every * stepper.shortest * q * unit))
    # The error falls with the square of the step (checked: a quarter each time).
    return (4 * found[1] - found[0]) / 3


@pytest.mark.slow
@pytest.mark.parametrize(("delay", "periods"), [(0.0, 11.0), (0.3, 10.0)])
def test_one_wave_grows_as_the_dispersion_relation_says(delay, periods):
    law = sf.Coulomb(1.0, delay=delay / (2 * np.pi * GOUGE_ON_ROCK[0].shear_speed))
    wave = growing_waves(compliance_of(*GOUGE_ON_ROCK), 1.0, delay)[0]
    found = growth_rate(GOUGE_ON_ROCK, law, 1.0, periods)
    assert found == pytest.approx(wave.growth, rel=1e-3)


@pytest.mark.parametrize(
    "law", [{"delay": 0.5}, {"delay_slip": 1.0}, {"delay": 1, "delay_slip": 2}]
)
def test_delayed_friction_follows_a_pressure_exactly_over_steps_of_any_length(law):
    law, speed = sf.SlipWeakening(0.3, 0.1, 1.0, **law), np.array([2.0])
    steps = []
    for count in (1, 50):
        felt, dt = np.array([1.0]), 1.5 / count
        for i in range(count):
            before, after = 1.0 + i * dt, 1.0 + (i + 1) * dt
            felt = law.felt_pressure(felt, speed, dt, np.array([before]), np.array([after]))
        steps.append(float(felt[0]))
    assert steps[0] == pytest.approx(steps[1], rel=1e-12)
    delay = float(law.pressure_delay(speed)[0])
    assert steps[0] == pytest.approx(1 + 1.5 - delay * (1 - np.exp(-1.5 / delay)), rel=1e-12)


def test_a_short_delay_is_none_and_a_long_one_lets_friction_feel_less_of_a_change():
    """Within the window a delay far below the step gives the answer without one."""
    plain, short, long = (
        one_run(patch(ROCK, FASTER, **given), 1.0, 256)
        for given in ({}, {"law": sf.Coulomb(0.2, delay=1e-9)}, {"law": sf.Coulomb(0.2, delay=3.0)})
    )
    np.testing.assert_allclose(
        short.interface.slip, plain.interface.slip, rtol=0, atol=1e-9 * plain.interface.slip.max()
    )
    np.testing.assert_allclose(
        short.interface.felt_pressure[1:], short.interface.pressure[1:], atol=1e-6
    )
    assert np.array_equal(plain.interface.felt_pressure, plain.interface.pressure)
    assert (
        np.abs(long.interface.slip - plain.interface.slip).max() > 1e-3 * plain.interface.slip.max()
    )
    assert (
        np.abs(long.interface.felt_pressure - 1.0).max()
        < np.abs(long.interface.pressure - 1.0).max() / 2
    )


def patch_of(law):
    """Gouge on rock, on which waves grow under friction above 0.531."""
    load = sf.InterfaceLoad(lambda x: 0.5 * (abs(x) < 1))
    rate = 0.0 if law.has_threshold else 1e-6
    return patch(*GOUGE_ON_ROCK, law=law, shear=0.4, loads=[load], rate=rate)


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (
            sf.Coulomb(0.6),
            "ill-posed: waves that run with .* grow by 5.33 % .* must be 0.0654 or more",
        ),
        pytest.param(
            sf.SlipWeakening(0.7, 0.3, 0.5),
            "friction 0.7 between these bodies is ill-posed",
            marks=pytest.mark.slow,
        ),
        pytest.param(sf.Coulomb(0.6, viscosity=0.1), "ill-posed", marks=pytest.mark.slow),
        (sf.Coulomb(0.6, delay=1e-3), "delay of 0.001, which the grid cannot resolve; raise it to"),
    ],
)
def test_friction_that_no_grid_follows_is_refused_with_what_would_do(law, words):
    with pytest.raises(sf.SceneError, match=words):
        sf.solve(patch_of(law), end_time=1.0, nodes=64)


def test_what_would_do_does():
    for law in (sf.Coulomb(0.6, delay=0.0654), sf.Coulomb(0.6, viscosity=3.0)):
        done = one_run(patch_of(law), 1.0, 64)
        assert done.status == "done"
        assert done.interface.slip.max() > 0


def test_runs_in_which_the_grid_let_waves_grow_say_so():
    quick = one_run(patch_of(sf.Coulomb(0.6, delay_slip=1e-4)), 1.0, 64)
    assert "friction follows pressure within" in quick.status
    law = sf.RateAndState(a=0.01, b=0.015, f0=0.6, v0=1e-6, distance=1e-2)
    fast = one_run(patch_of(law), 1.0, 64)
    assert "friction rises too little with slip rate" in fast.status


def test_rate_and_state_between_two_bodies_needs_no_short_steps():
    """The ladder against steps of one length, half of its shortest."""
    law = sf.RateAndState(a=0.02, b=0.012, f0=0.4, v0=1e-3, distance=0.05)
    push = sf.InterfaceLoad(lambda x: 0.05 * np.exp(-(x**2)), history=lambda t: min(t / 5, 1.0))
    given = patch(ROCK, FASTER, law=law, shear=0.4, rate=1e-3, plate_rate=1e-3, loads=[push])
    done = one_run(given, 6.0, 32, times=[6.0])
    fine = one_run(given, 6.0, 32, times=[6.0], step_ratio=0.2, longest=0.0521)
    assert done.steps < fine.steps / 4
    size = (fine.interface.slip - 6e-3).max()
    np.testing.assert_allclose(done.interface.slip, fine.interface.slip, rtol=0, atol=5e-3 * size)
    assert np.abs(done.interface.pressure - 1.0).max() > 1e-4


@pytest.mark.slow
def test_steel_on_rubber_is_resolved_under_its_delay_and_refused_without():
    found = sf.find("steel-on-rubber")
    done = sf.solve(found, nodes=256)
    assert done.status == "done"
    assert done.error_estimates["slip"] < 0.2
    with pytest.raises(sf.SceneError, match="no less friction helps"):
        sf.solve(replace(found, friction=0.5), nodes=256)
