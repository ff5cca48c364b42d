"""Waves at an angle and moving loads on interfaces, against the exact solver and one another."""

import numpy as np
import pytest

import semianalytic as sf

THIRD = sf.Material(1.0, 1.0, 1 / 3)
HALF = sf.Contact.half_line()


def beside_slot(load, mode="in-plane", nodes=512, at=0.0, length=12.0):
    """The run at unit time after a front has reached the tip, and the exact answer."""
    scene = sf.Scene(THIRD, friction=0.3, base=sf.Tractions(1.0, 0.0), load=load, mode=mode)
    begun = -load.slowness(THIRD) * at
    loads = [sf.FrontLoad(load, at=at)]
    face = sf.Interface(THIRD, sf.Coulomb(0.3), length, 1.0, 0.0, loads, HALF, mode)
    return sf.run(face, begun + 1, nodes, times=[begun + 1], estimate=False), sf.solve(scene)


@pytest.mark.parametrize(
    ("load", "mode", "at", "off"),
    [
        (sf.IncidentWave("SV", -20.0, stress=0.3), "in-plane", 0.0, 0.009),
        (sf.IncidentWave("SH", -40.0, stress=0.3), "antiplane", 0.0, 0.01),
        (sf.MovingLoad(4.0, 0.0, 1.0), "in-plane", 0.0, 0.008),
        pytest.param(
            sf.IncidentWave("SV", 18.0, stress=0.2), "in-plane", -10.0, 0.01, marks=pytest.mark.slow
        ),
    ],
)
def test_fronts_beside_a_slot_are_those_of_the_exact_solver(load, mode, at, off):
    length, nodes = (12.0, 512) if at == 0 else (20.0, 1024)
    done, known = beside_slot(load, mode, nodes, at, length)
    near = (done.x > 0.02) & (done.x < 1.9)
    x = done.x[near]
    for name, base in (("slip_rate", 0.0), ("shear_traction", 0.0), ("pressure", 1.0)):
        exact, found = getattr(known, name)(x, 1.0) - base, getattr(done, name)[0][near] - base
        size = np.abs(exact).sum()
        assert np.abs(found - exact).sum() < off * size + 1e-12


def test_a_wave_at_no_angle_is_a_load_of_the_line():
    wave = sf.IncidentWave("SV", 0.0, stress=0.6)
    shear = wave.tractions(THIRD).shear
    runs = []
    for load in (wave, sf.InterfaceLoad(shear)):
        face = sf.Interface(THIRD, sf.Coulomb(0.3), 8.0, loads=[load], contact=HALF, even=False)
        runs.append(sf.run(face, 1.0, 64, estimate=False))
    assert runs[0].slip.max() > 0.01 or runs[0].slip.min() < -0.01
    assert runs[0].slip == pytest.approx(runs[1].slip, abs=1e-12)


def test_a_front_is_the_mean_of_its_load_over_a_node_distance():
    wave = sf.FrontLoad(sf.IncidentWave("SH", -30.0, stress=2.0), at=4.0).of(THIRD)
    x = np.linspace(-4, 4, 161)
    step, smooth = wave.traction(x, 1.0), wave.traction(x, 1.0, spread=(0.5, 0.0))
    assert set(step) == {0.0, step[-1]}
    middle = np.abs(x - 2) < 0.25
    assert smooth[middle] == pytest.approx(step[-1] * ((x - 2) / 0.5 + 0.5)[middle])
    assert smooth.sum() == pytest.approx(step.sum(), abs=abs(step[-1]))  # one node
    away = sf.FrontLoad(sf.MovingLoad(2.0, 0.5, 1.0)).of(THIRD)
    assert away.traction([-2.5, -1.5, 0.5], 1.0, of="pressure").tolist() == [0.0, 0.5, 0.0]
    comes = sf.FrontLoad(sf.MovingLoad(-2.0, 0.5, 1.0), at=-1.0).of(THIRD)
    assert comes.traction([-1.5, 0.5, 1.5], 1.0).tolist() == [1.0, 1.0, 0.0]
