"""Loads that change within a step or between two: seen by `run`, or said to be unresolved."""

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.engine.stepping.pace import nodes_for_histories
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.scene.line.fields import Expression
from tests.semianalytic.engine.runs import one_run

UNIT = sf.Material(1.0, 1.0, 0.25)
ROCK = sf.Material(30e9, 2700.0, 0.25)
STRENGTHENING = sf.RateAndState(a=0.01, b=0.006, f0=0.6, v0=1e-6, distance=1e-4)
ON_PATCH = lambda x: 2e6 * (abs(x) < 1)  # noqa: E731
SPIKE = sf.Tabulated([0, 0.6, 0.62, 0.64, 1], [0, 0, 30, 0, 0])


def struck(history, **given):
    patch = sf.InterfaceLoad(lambda x: 1.0 * (abs(x) < 1), history=history)
    return scene_along(UNIT, sf.Coulomb(0.3), 16.0, shear=0.1, loads=[patch], **given)


def slow(load, law=STRENGTHENING, **given):
    creeping = {"pressure": 5e6, "shear": 3e6, "rate": 1e-9, "held": 16.0, **given}
    return scene_along(ROCK, law, 16.0, loads=[load], **creeping)


def with_short_steps(face, end, nodes, longest):
    """A run as long as it likes its steps, and one of short steps alone."""
    return (one_run(face, end, nodes, **given) for given in ({}, {"longest": longest}))


@pytest.mark.parametrize(
    "history",
    [
        *(SPIKE, sf.Pulse(0.04, "triangle"), sf.Harmonic(20.0)),
        *(lambda t: np.sin(40 * np.pi * t), Expression("sin(125 * t)", ("t",))),
    ],
)
def test_a_history_that_turns_within_a_step_is_unresolved(history):
    face = struck(history)
    coarse = one_run(face, 1.0, 128)
    assert coarse.status.startswith("unresolved: the history of a load turns faster than 128 nodes")
    needed = int(coarse.status.split("use ")[1].split()[0])
    assert needed == pytest.approx(nodes_for_histories(face, 1.0), abs=4)
    assert needed > 2000


def test_a_run_takes_the_nodes_that_its_loads_need():
    face = struck(sf.Pulse(0.1, "triangle"))
    done = sf.solve(face, end_time=0.5)
    assert done.status == "done"
    assert done.nodes == pytest.approx(nodes_for_histories(face, 0.5), abs=4)
    assert done.nodes > 512
    assert sf.solve(struck(sf.Pulse(2.0, "triangle")), end_time=0.5, estimate=False).nodes == 512
    assert sf.solve(face, end_time=0.5, nodes=128, rtol=0.5).nodes >= done.nodes


def blow(t):
    return np.maximum(1 - abs(t - 5) / 0.5, 0.0)


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    "load",
    [
        sf.InterfaceLoad(ON_PATCH, history=sf.Tabulated([0, 4.5, 5, 5.5, 1000], [0, 0, 1, 0, 0])),
        sf.InterfaceLoad(ON_PATCH, history=blow),
        sf.InterfaceLoad(ON_PATCH, history=sf.Pulse(0.5, "haversine")),
        sf.InterfaceLoad(lambda x, t: ON_PATCH(x) * blow(t), history=None),
        sf.InterfaceLoad(lambda x, t: 1e6 * blow(t - x / 4), history=None),
    ],
    ids=["table", "function of t", "pulse", "function of x and t", "wave"],
)
def test_long_steps_do_not_pass_over_a_load(load):
    """The line is struck within a quiet phase, in which steps last as long as the whole blow.

    Without the samples of a function of time its blow is missed whole, with error 0.
    """
    found, fine = with_short_steps(slow(load), 7.0, 32, 0.05)
    assert found.steps < fine.steps
    assert np.diff(found.totals.t).max() > 0.9
    assert found.interface.slip[-1] == pytest.approx(
        fine.interface.slip[-1], rel=1e-3, abs=1e-4 * fine.interface.slip.max()
    )
    assert fine.interface.slip[-1].max() > 1000 * 1e-9 * 7


def test_a_wave_that_arrives_in_a_quiet_phase_sets_off_its_rupture():
    """The front is at the line from 10 to 13 s, when steps last seconds."""
    law = sf.RateAndState(a=0.012, b=0.006, f0=0.6, v0=1e-6, distance=1e-3)
    wave = sf.FrontLoad(
        sf.IncidentWave("SV", -20.0, stress=-1e6), history=sf.Pulse(1.0, "rectangle"), at=1e5
    )
    held = {"pressure": 5e6, "shear": 2.9e6, "rate": 1e-9, "held": 16e3}
    face = scene_along(ROCK, law, 16e3, loads=[wave], **held)
    found, fine = with_short_steps(face, 20.0, 64, 0.1)
    assert found.steps < fine.steps / 1.2
    assert np.abs(fine.interface.slip).max() > 0.1
    assert found.interface.slip[-1] == pytest.approx(fine.interface.slip[-1], rel=1e-4)


@pytest.mark.thinned(3)
@pytest.mark.parametrize(("period", "size"), [(20.0, 2e6), (5.0, 2e6), (100.0, 1e6)])
def test_friction_that_damps_less_as_it_speeds_up_does_not_let_short_waves_grow(period, size):
    """Steps chosen by slow slip at their beginning were too long for the fast slip at their end."""
    face = slow(
        sf.InterfaceLoad(lambda x: size * (abs(x) < 1), lambda t: np.sin(2 * np.pi * t / period))
    )
    steps = []

    def gives_up(time, end):
        steps.append(time)
        return len(steps) > 3000

    end = 1.5 * period
    done = one_run(face, end, 64, progress=gives_up)
    fine = one_run(face, end, 64, longest=period / 200, times=[end])
    assert done.status == "done"
    assert done.totals.peak_rate.max() < 1e-3
    assert done.interface.slip[-1] == pytest.approx(
        fine.interface.slip[-1], rel=0.02, abs=2e-3 * fine.interface.slip.max()
    )


def test_a_step_that_ends_beyond_convergence_is_repeated(monkeypatch):
    """Steps are chosen two rungs too long; without a repeat slip is 6 % off."""
    law = sf.RateAndState(a=0.012, b=0.006, f0=0.6, v0=1e-6, distance=1e-5)
    load = sf.InterfaceLoad(lambda x: 1.9e6 * (abs(x) < 1), lambda t: np.sin(np.pi * t / 500))
    face = scene_along(ROCK, law, 16.0, 5e6, 1e6, [load], rate=1e-9, mode="antiplane")
    right, chosen = one_run(face, 500.0, 64), Stepper.length

    def too_long(stepper, now):
        rung = chosen(stepper, now)[1] + 2
        return stepper.ladder.length(rung), rung

    monkeypatch.setattr(Stepper, "length", too_long)
    done = one_run(face, 500.0, 64)
    assert done.steps < right.steps / 3
    assert done.interface.slip[-1] == pytest.approx(
        right.interface.slip[-1], abs=0.01 * right.interface.slip[-1].max()
    )


@pytest.mark.parametrize("held", [1.0, 0.3])
def test_a_stiffness_of_a_wave_shorter_than_the_grid_bounds_steps_too(held):
    """A uniform slider on a spring is the same on 16 nodes as on 64 or 256."""
    law = sf.RateAndState(a=0.010, b=0.014, f0=0.6, v0=1e-6, distance=1e-5)
    push = sf.InterfaceLoad(2e4, history=sf.Tabulated([0, 5.0, 6.0, 1000], [0, 0, 1, 1]))
    face = scene_along(
        *(ROCK, law, 16.0, 5e6, 3e6, [push]),
        **{"rate": 1e-6, "plate_rate": 1e-6, "held": held, "mode": "antiplane"},
    )
    few, many = (
        one_run(face, 10.0, count, times=[10.0]) for count in (16, round(64 / held / 4) * 4)
    )
    assert few.interface.slip[-1] == pytest.approx(many.interface.slip[-1, 0], rel=1e-3)
    assert few.totals.peak_rate.max() == pytest.approx(many.totals.peak_rate.max(), rel=0.02)


def test_slots_take_no_work_of_adhesion():
    pull = sf.InterfaceLoad(pressure=lambda x: -3.0 * (abs(x) < 0.5))
    works = []
    for contact in (sf.Contact(), sf.Contact([(-5, 5)])):
        glued = sf.Coulomb(0.3, cohesion=1.0)
        face = scene_along(
            *(UNIT, glued, 16.0), loads=[pull], adhesion=sf.Adhesion(1.0, 0.5), contact=contact
        )
        done = one_run(face, 1.0, 256)
        assert np.isfinite(done.interface.pressure).all()
        works.append(done.work["closing"])
    assert works[0] == pytest.approx(works[1], rel=0.01)
    assert works[0] > 0.1
