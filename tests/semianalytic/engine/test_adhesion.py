"""Contacts that carry tension before they open."""

import math
import re

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.engine.stepping.steps import Stepper
from tests.semianalytic.engine.runs import one_run

ROCK = sf.Material(1.0, 1.0, 0.25)


def pulled(tension, adhesion, pressure=0.5, length=1.0, law=None, history=None, **more):
    """An interface under a tension that acts everywhere."""
    load = sf.InterfaceLoad(pressure=-tension, **({"history": history} if history else {}))
    law = law or sf.Coulomb(0.3)
    return scene_along(ROCK, law, length, pressure, loads=[load], adhesion=adhesion, **more)


def parting(face, tension, t):
    """Gap (n,) at times t (n,): Z g' = tension - pressure - strength (1 - g / length)."""
    bonds, z = face.adhesion, face.material.density * face.material.longitudinal_speed / 2
    rest, soft = tension - face.base.pressure - bonds.strength, bonds.strength / bonds.length
    apart = z / soft * math.log(1 + soft * bonds.length / rest)
    together = rest / soft * np.expm1(soft * np.minimum(t, apart) / z)
    return np.where(
        t > apart, bonds.length + (tension - face.base.pressure) / z * (t - apart), together
    )


def test_faces_under_uniform_tension_part_as_in_closed_form():
    face, t = pulled(3.0, sf.Adhesion(1.0, 0.5)), np.linspace(0.02, 0.6, 30)
    errors = []
    for nodes in (32, 64):
        done = one_run(face, 0.6, nodes, times=t)
        gap = parting(face, 3.0, t)
        errors.append(np.abs(done.interface.gap[:, 0] - gap).max() / gap.max())
        held = gap < 0.5
        assert held.sum() > 5
        tension = 1 - gap[held] / 0.5
        assert -done.interface.pressure[held, 0] == pytest.approx(tension, abs=5 * errors[-1])
        assert np.abs(done.interface.pressure[~held]).max() == 0.0
        # parting takes strength x length / 2, by the backward rule too little at first order
        assert done.work["closing"] == pytest.approx(0.25, abs=0.5 / nodes)
    assert errors[1] < 0.003
    assert errors[0] / errors[1] == pytest.approx(2, abs=0.1)


def test_tension_below_the_strength_is_carried():
    face = pulled(1.49, sf.Adhesion(1.0, 0.5))
    done = one_run(face, 0.5, 16)
    assert done.interface.gap.max() == 0.0
    assert done.interface.pressure[1:] == pytest.approx(-0.99, abs=1e-12)
    assert one_run(pulled(1.51, sf.Adhesion(1.0, 0.5)), 0.5, 16).interface.gap.max() > 0.01


def test_under_tension_only_cohesion_resists_slip():
    for shear, slips in ((0.19, False), (0.21, True)):
        law = sf.Coulomb(0.3, cohesion=0.2)
        face = pulled(1.0, sf.Adhesion(1.0, 0.5), law=law, shear=shear)
        done = one_run(face, 0.5, 16)
        assert (done.interface.slip.max() > 0) == slips
        assert done.interface.gap.max() == 0.0


def test_adhesion_without_strength_is_none():
    burst = sf.InterfaceLoad(
        pressure=lambda x, t: -3 * np.exp(-2 * x**2 - 4 * (t - 1) ** 2), history=None
    )
    runs = []
    for adhesion in (None, sf.Adhesion(0.0, 0.1)):
        face = scene_along(ROCK, sf.Coulomb(0.3), 16.0, 1.0, 0.1, loads=[burst], adhesion=adhesion)
        runs.append(one_run(face, 2.5, 64))
    assert runs[0].interface.gap.max() > 0.1
    for name in ("gap", "pressure", "slip", "shear_traction"):
        assert np.array_equal(*(getattr(run.interface, name) for run in runs))


def test_what_has_parted_carries_no_tension_when_it_has_closed():
    pull = sf.Pulse(0.5)
    again = sf.InterfaceLoad(pressure=lambda x, t: -0.8 * (t > 4) + 0 * x, history=None)
    face = scene_along(
        *(ROCK, sf.Coulomb(0.3), 1.0, 0.5),
        loads=[sf.InterfaceLoad(pressure=-3.0, history=pull), again],
        adhesion=sf.Adhesion(1.0, 0.1),
    )
    done = one_run(face, 5.0, 16, times=[0.5, 3.9, 5.0])
    assert done.interface.gap[0].min() > 0.1
    assert done.interface.gap[1].max() == 0.0
    assert done.interface.gap[2].min() > 0.05


@pytest.mark.thinned(2)
@pytest.mark.parametrize("seed", range(4))
def test_adhesion_gives_back_no_more_than_it_took(seed):
    """Every step dissipates at every node: the work taken, less what can be given back, grows.

    Faces come together before they have parted as well, and slip.
    """
    draw = np.random.default_rng(seed)
    size, place, pace = draw.uniform(1.5, 3.0, 6), draw.uniform(-4, 4, 6), draw.uniform(2, 9, 6)

    def pressure(x, t):
        waves = size * np.sin(pace * t) * np.exp(-((x[:, None] - place) ** 2))
        return -waves.sum(axis=1) * min(t, 1.0)

    load = sf.InterfaceLoad(pressure=pressure, history=None)
    face = scene_along(
        *(ROCK, sf.Coulomb(0.3), 8.0, 0.3, 0.2), loads=[load], adhesion=sf.Adhesion(1.0, 0.3)
    )
    stepper = Stepper(face, 64, 0.4, end_time=4.0)
    bonds, now, turned = stepper.unilateral.adhesion, stepper.begin(), 0

    def lost(state):
        return state.closing - 0.5 * bonds.tension(state.gap, state.opened) * state.gap

    while now.time < 4.0:
        length, rung = stepper.length(now)
        before, now = now, stepper.step(now, length, rung)
        back = (now.gap < before.gap) & (now.gap > 0) & (now.opened < 0.3)
        turned += int(back.sum())
        assert np.all(lost(now) >= lost(before) - 1e-13)
        assert np.all((now.pressure >= -1.0 - 1e-12) & (now.gap >= 0))
        assert np.all(now.pressure[now.gap > 0] <= 0)
    assert turned > 50
    assert now.opened.max() > 0.3


def griffith(strength, nodes, ramp=60.0):
    """Tension at which the contacts beside slots begin to part, over that of Griffith's crack."""
    intensity = 8 * math.tan(math.pi / 8)  # K^2 of slots |x| < 1 of period 8 under unit tension
    length = 0.75 * intensity / strength  # so that strength x length / 2 = K^2 (1 - nu) / (2 mu)
    beside = sf.Contact([(-math.inf, -1.0), (1.0, math.inf)])
    face = pulled(
        1.0,
        sf.Adhesion(strength, length),
        *(0.0, 8.0),
        history=lambda t: 1.2 * min(t / ramp, 1.0),
        contact=beside,
        even=True,
    )
    done = one_run(face, ramp, nodes, times=np.linspace(0, ramp, 601))
    edge = np.flatnonzero(done.interface.touching)[0]
    return 1.2 * done.interface.t[np.argmax(done.interface.gap[:, edge] >= length)] / ramp


@pytest.mark.slow
def test_slots_grow_under_the_tension_of_griffith():
    """The zone of falling tension is 0.05 of the slot, which makes the strength matter little."""
    assert griffith(6.0, 512) == pytest.approx(1.0, abs=0.02)
    assert griffith(3.0, 256) == pytest.approx(0.97, abs=0.02)


def test_grids_that_cannot_follow_it_are_told():
    with pytest.raises(sf.SceneError, match=r"cannot follow; take \d+ nodes or more"):
        one_run(pulled(3.0, sf.Adhesion(1.0, 1e-3)), 0.5, 16)
    # the number is that of the whole period, of an even line as well, and is enough
    for even in (False, True):
        face = pulled(3.0, sf.Adhesion(1.0, 1e-2), even=even)
        with pytest.raises(sf.SceneError, match=r"take \d+ nodes") as refused:
            one_run(face, 1e-3, 16)
        enough = int(re.search(r"take (\d+) nodes", str(refused.value))[1])
        assert enough > 16
        one_run(face, 1e-3, enough)
    # tension that falls within two node distances: mu / (strength / length) is 2 h
    coarse = one_run(pulled(3.0, sf.Adhesion(1.0, 0.25)), 0.1, 8)
    assert "falls over 2 node distances" in coarse.status
